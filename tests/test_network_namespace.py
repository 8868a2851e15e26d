"""A network of its own, and nothing of it left."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from telex_experiments.rigs.network_namespace import NetworkNamespace, NoNamespaceError

FOLDER = Path("/run/netns")


def mounts():
    return [line.split()[1] for line in Path("/proc/self/mounts").read_text().splitlines()]


@pytest.mark.skipif(not NetworkNamespace.available(), reason="only root can make networks")
def test_it_has_an_address_and_leaves_nothing_mounted():
    before = mounts()
    network = NetworkNamespace()
    try:
        with network:
            command = [*network.before, "ip", "-brief", "address"]
            told = subprocess.run(command, capture_output=True, text=True, check=True).stdout
            assert network.other in told
            name = Path(network.before[-1].split("=")[-1]).name
            assert str(FOLDER / name) in mounts()
    except NoNamespaceError as error:
        pytest.skip(str(error))
    after = mounts()
    assert str(FOLDER / name) not in after
    # Other tests make networks, too, and need the folder meanwhile.
    is_needed = FOLDER.is_dir() and any(FOLDER.iterdir())
    assert str(FOLDER) not in after or str(FOLDER) in before or is_needed
