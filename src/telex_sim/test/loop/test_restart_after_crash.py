"""What is started again, and what is not."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

PROGRAM = Path(__file__).resolve().parents[2] / "nodes" / "restart_after_crash"

# Notes its start, and ends as the next of its arguments says: a signal, or an exit status.
SCRIPT = """
import os, sys, time
starts, *ends = sys.argv[1:]
with open(starts, "a") as file:
    file.write(f"{os.getpid()}\\n")
with open(starts) as file:
    end = ends[len(file.readlines()) - 1]
if end == "wait":
    print("waits", flush=True)
    time.sleep(60)
if end.startswith("-"):
    os.kill(os.getpid(), -int(end))
sys.exit(int(end))
"""


@pytest.fixture
def start(tmp_path):
    starts = tmp_path / "starts"
    running = []

    def run(*ends, least_run="0"):
        process = subprocess.Popen(
            [str(PROGRAM), sys.executable, "-c", SCRIPT, str(starts), *ends],
            env={**os.environ, "RESTART_LEAST_RUN": least_run},
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )
        running.append(process)
        return process, lambda: [int(line) for line in starts.read_text().split()]

    yield run
    for process in running:
        process.kill()
        process.communicate()


@pytest.mark.parametrize(("end", "status"), [("0", 0), ("78", 78)])
def test_an_end_in_order_and_wrong_parameters_are_final(start, end, status):
    process, starts = start(end)
    assert process.wait(20) == status
    assert len(starts()) == 1


def test_a_crash_is_followed_by_another_start(start):
    process, starts = start("-9", "1", "0")
    _, said = process.communicate(timeout=30)
    assert process.returncode == 0
    assert len(starts()) == 3
    assert "has crashed (SIGKILL)" in said
    assert "has crashed (exit status 1)" in said


@pytest.mark.parametrize(("end", "status"), [("-11", 139), ("1", 1)])
def test_what_fails_at_once_is_not_tried_again(start, end, status):
    process, starts = start(end, "0", least_run="30")
    assert process.wait(20) == status
    assert len(starts()) == 1


def test_a_signal_that_asks_for_the_end_is_passed_on(start):
    process, starts = start("wait", "0")
    assert process.stdout.readline() == "waits\n"
    process.send_signal(signal.SIGTERM)
    assert process.wait(20) == 128 + signal.SIGTERM
    assert len(starts()) == 1


def test_killed_itself_it_leaves_nothing_behind(start):
    process, starts = start("wait", "0")
    assert process.stdout.readline() == "waits\n"
    process.kill()
    # The output ends with whoever holds it last: the program, which would wait for a minute.
    assert process.communicate(timeout=20) == ("", "")
    assert len(starts()) == 1


def test_without_a_program_it_says_how_it_is_used():
    done = subprocess.run([str(PROGRAM)], capture_output=True, text=True, check=False)
    assert done.returncode == os.EX_USAGE
    assert "restart_after_crash PROGRAM" in done.stderr
