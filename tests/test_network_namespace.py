"""A network of its own, and nothing of it left."""

from __future__ import annotations

import subprocess
import sys

import pytest

from telex_experiments.rigs.network_namespace import NetworkNamespace

# In mounts of its own, for other tests make networks, too.
PROGRAM = """
import subprocess
from pathlib import Path
from telex_experiments.rigs.network_namespace import NetworkNamespace, NoNamespaceError

subprocess.run(["umount", "-l", "/run/netns"], stderr=subprocess.DEVNULL)
mounts = Path("/proc/self/mounts")
before = mounts.read_text()
try:
    with NetworkNamespace() as network:
        command = [*network.before, "ip", "-brief", "address"]
        told = subprocess.run(command, capture_output=True, text=True, check=True).stdout
        assert network.other in told, told
        assert "/run/netns" in mounts.read_text()
except NoNamespaceError as error:
    print(error)
assert mounts.read_text() == before, mounts.read_text()
"""


@pytest.mark.skipif(not NetworkNamespace.available(), reason="only root can make networks")
def test_it_has_an_address_and_leaves_nothing_mounted():
    command = ["unshare", "--mount", sys.executable, "-c", PROGRAM]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.stdout or "unshare" in done.stderr:
        pytest.skip(done.stdout + done.stderr)
    assert done.returncode == 0, done.stderr
