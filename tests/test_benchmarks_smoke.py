"""Every benchmark still runs: one sample of each part, none of them judged."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import uuid
from contextlib import suppress
from pathlib import Path

import pytest
from waiting import wait_until

from telex_control.common.child_processes import DIES_WITH_US
from telex_experiments.rigs.private_master import end_tree

pytestmark = pytest.mark.slow

BENCHMARKS = Path(__file__).resolve().parents[1] / "benchmarks"
OFFLINE = (
    "bookmarks",
    "grasping",
    "ik",
    "mobility",
    "rehearse",
    "step_response",
    "trajectory",
)
LIMIT = 900.0
"""Time (s) that one may take, on a machine that is busy with something else."""
ENDING = 60.0
"""Time (s) within which all that it has started has to be gone."""


def benchmarks():
    for path in sorted(BENCHMARKS.iterdir()):
        if path.is_file() and not path.suffix and os.access(path, os.X_OK):
            marks = () if path.name in OFFLINE else (pytest.mark.ros, pytest.mark.browser)
            yield pytest.param(path, id=path.name, marks=marks)


def bearing(mark):
    """Processes that have a mark in their environment."""
    found = {}
    for process in Path("/proc").glob("[0-9]*"):
        # It may end meanwhile; what has ended and is not yet waited for has no environment.
        with suppress(OSError):
            if mark in (process / "environ").read_bytes():
                words = (process / "cmdline").read_bytes().decode(errors="replace")
                found[int(process.name)] = words.replace("\0", " ")[:200]
    return found


@pytest.mark.parametrize("benchmark", benchmarks())
def test_it_still_runs(benchmark, tmp_path):
    mark = f"telex-smoke-{uuid.uuid4().hex}"
    figures, output = tmp_path / "figures.json", tmp_path / "output.txt"
    with output.open("w") as file:
        process = subprocess.Popen(
            [*DIES_WITH_US, sys.executable, str(benchmark), "--smoke", "--json", str(figures)],
            env={**os.environ, "TELEX_BENCHMARK": mark},
            stdin=subprocess.DEVNULL,
            stdout=file,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
    try:
        # It ends what it has started when this process is ended.
        with suppress(subprocess.TimeoutExpired):
            process.wait(LIMIT)
        told = output.read_text(errors="replace")[-6000:]
        assert process.poll() == 0, told
        assert json.loads(figures.read_text())["figures"], told
        wait_until(
            lambda: bearing(mark.encode()) == {}, f"the end of its processes: {told}", ENDING
        )
    finally:
        end_tree(process)
        for pid in bearing(mark.encode()):
            with suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
