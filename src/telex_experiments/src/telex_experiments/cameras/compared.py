"""Cost of a picture beside that in an earlier revision of this repository, in turn."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import tarfile
import tempfile
from pathlib import Path
from typing import Iterator, List

import numpy as np

from telex_experiments.rigs.report import Figure, MeasurementError

from ..workspace import ROOT

_PACKAGES = ("telex_control", "telex_description", "telex_experiments", "telex_sim")
_WORKER = Path(__file__).with_name("rounds.py")

MOST_MORE = 1.05
"""Times the cost of before, at most."""


@contextlib.contextmanager
def revision(name: str) -> Iterator[Path]:
    """Have the packages that pictures are made with as they are in a revision; gives their root.

    Raises
    ------
    MeasurementError
        There is no such revision.
    """
    with tempfile.TemporaryDirectory() as folder:
        archive = Path(folder) / "revision.tar"
        words = ["git", "archive", f"--output={archive}", name]
        made = subprocess.run(
            [*words, *(f"src/{package}" for package in _PACKAGES)],
            cwd=ROOT,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
        if made.returncode:
            raise MeasurementError(f"revision '{name}': {made.stderr.strip()}")
        with tarfile.open(archive) as packed:
            packed.extractall(folder)
        yield Path(folder)


def environment(root: Path) -> dict:
    """Return the environment of a process that takes the packages of a root before all others."""
    sources = [str(root / "src" / package / "src") for package in _PACKAGES]
    found = os.environ.get("PYTHONPATH", "")
    packages = os.environ.get("ROS_PACKAGE_PATH", "")
    return {
        **os.environ,
        "PYTHONPATH": os.pathsep.join([*sources, *filter(None, [found])]),
        "ROS_PACKAGE_PATH": os.pathsep.join([str(root / "src"), *filter(None, [packages])]),
        "PYTHONDONTWRITEBYTECODE": "1",
    }


def compared_figures(before: str, rounds: int) -> List[Figure]:
    """Cost of a picture, mean of the six views, now and in an earlier revision.

    Both draw in turn, each in a process of its own: what else the machine does meets both alike.
    """
    with revision(before) as root, contextlib.ExitStack() as ending:
        workers = [ending.enter_context(_worker(each)) for each in (root, ROOT)]
        costs = []
        for number in range(rounds):
            # Neither is always the first.
            pair = {}
            for place in (0, 1) if number % 2 else (1, 0):
                pair[place] = _round(workers[place])
            costs.append([pair[0], pair[1]])
    earlier, now = np.median(costs, axis=0).tolist()
    ratio = float(np.median([after / first for first, after in costs]))
    return [
        Figure(f"640x480 with JPEG, mean of six views, {before}: CPU", earlier, "ms"),
        Figure("640x480 with JPEG, mean of six views, now: CPU", now, "ms"),
        Figure("now / before, median of rounds", ratio, "times", at_most=MOST_MORE),
    ]


@contextlib.contextmanager
def _worker(root: Path) -> Iterator[subprocess.Popen]:
    worker = subprocess.Popen(
        [sys.executable, str(_WORKER)],
        env=environment(root),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        yield worker
    finally:
        assert worker.stdin is not None
        with contextlib.suppress(BrokenPipeError):
            worker.stdin.close()
        worker.wait()


def _round(worker: subprocess.Popen) -> float:
    assert worker.stdin is not None
    assert worker.stdout is not None
    worker.stdin.write("\n")
    worker.stdin.flush()
    for line in worker.stdout:
        if line.startswith("cost "):
            return float(line.split()[1])
    raise MeasurementError(f"what draws has ended with status {worker.wait()}")
