"""The cameras' node of a replay, with a program that the test puts in its place."""

from __future__ import annotations

import os
import subprocess
import threading
from pathlib import Path

import pytest
from waiting import wait_until

from telex_training.ros.replay.cameras_process import CamerasProcess

pytestmark = [pytest.mark.ros, pytest.mark.waiting]


@pytest.fixture
def cameras(master, tmp_path, monkeypatch):
    stand_in = tmp_path / "rosrun"
    stand_in.write_text("#!/bin/sh\nexec sleep 600\n")
    stand_in.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}{os.pathsep}{os.environ['PATH']}")
    made = CamerasProcess("/replay_cameras")
    yield made
    made.end()


def test_it_outlives_the_call_that_had_it_started(cameras):
    # As the thread of a service's call: it is short, but not so short as the start of a program.
    def call():
        cameras.require({"rate": 1.0})
        command = Path(f"/proc/{cameras._process.pid}/comm")
        wait_until(lambda: command.read_text().strip() == "sleep", "the program")

    thread = threading.Thread(target=call)
    thread.start()
    thread.join()
    with pytest.raises(subprocess.TimeoutExpired):
        cameras._process.wait(0.5)
    assert cameras.runs
