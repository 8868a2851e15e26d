"""The suites of ``tests/rostest``, each under the ``rostest`` command with a master of its own."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest

from telex_experiments.rigs.private_master import end_tree

pytestmark = [pytest.mark.ros, pytest.mark.real_time]

WAITING = ("controller_manager", "controllers", "robot_alone")
SUITES = [
    pytest.param(path, id=path.stem, marks=[pytest.mark.waiting] * (path.stem in WAITING))
    for path in sorted(Path(__file__).parent.glob("rostest/*.test"))
]
LONGEST = 900.0  # s; each test in a suite has its own limit, which ends it in order before this
SHOWN = 12_000  # characters of what a failed suite wrote


def test_the_suites_are_found():
    assert SUITES


@pytest.mark.parametrize("suite", SUITES)
def test_suite(suite, tmp_path):
    written, results, logs = (tmp_path / name for name in ("output", "results", "log"))
    with written.open("wb") as output:
        rostest = subprocess.Popen(
            ["rostest", str(suite)],
            env=dict(os.environ, ROS_TEST_RESULTS_DIR=str(results), ROS_LOG_DIR=str(logs)),
            stdout=output,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        try:
            status = rostest.wait(LONGEST)
        finally:
            end_tree(rostest, 60.0)
    if status != 0:
        # What a test found stands in its results or, where it could not begin, in its log.
        told = [*logs.rglob("*_test-*-stdout.log"), *results.rglob("rosunit-*.xml"), written]
        pytest.fail("\n".join(path.read_text(errors="replace")[-SHOWN:] for path in told))
