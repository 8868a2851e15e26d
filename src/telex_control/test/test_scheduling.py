"""A process that steps forward or back among all others, each in a process of its own."""

import os
import subprocess
import sys

import pytest

KEEP_TIME = """
import ctypes, os, struct, sys, threading
from telex_control import scheduling

CASE = sys.argv[1]
if CASE == "forbidden":
    def forbidden(*arguments):
        raise PermissionError("not this user")
    os.sched_setscheduler = forbidden
if CASE == "one processor":
    os.sched_getaffinity = lambda process: {0}

ended = threading.Event()
def thread():
    it = threading.Thread(target=ended.wait)
    it.start()
    return it.native_id

def slice_of(thread):
    # sched_getattr(2) is the next system call.
    number = {"x86_64": 315, "aarch64": 275}[os.uname().machine]
    told = ctypes.create_string_buffer(48)
    assert ctypes.CDLL(None).syscall(number, thread, told, 48, 0) == 0
    return struct.unpack("=IIQiIQQQ", told.raw)[5]

os.nice(3)
threads = [os.getpid(), thread()]
realtime = scheduling.keep_time(0 if CASE == "not wanted" else 2)
threads.append(thread())
policies = {os.sched_getscheduler(each) for each in threads}
nices = {os.getpriority(os.PRIO_PROCESS, each) for each in threads}
slices = {slice_of(each) for each in threads}
ended.set()
assert nices == {3}, nices
if realtime:
    assert policies == {os.SCHED_RR}, policies
    assert {os.sched_getparam(each).sched_priority for each in threads[:1]} == {2}
else:
    assert policies == {os.SCHED_OTHER}, policies
    linux = tuple(int(part) for part in os.uname().release.split("-")[0].split(".")[:2])
    assert linux < (6, 12) or slices == {scheduling.WAKE_SLICE}, slices
print(realtime)
"""

STEP_BACK = """
import os
from pathlib import Path
from telex_control.scheduling import step_back

step_back(7)
assert os.nice(0) == 7
group = Path("/proc/self/autogroup")
try:
    told = group.read_text().strip()
except OSError:
    told = ""
print(told)
"""


def run(script, *arguments):
    result = subprocess.run(
        [sys.executable, "-c", script, *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=30.0,
        check=False,
        start_new_session=True,
    )
    assert result.returncode == 0, result.stdout
    return result.stdout.strip()


def may_be_realtime():
    """Whether this user may have real-time processes, as the system itself says it."""
    command = ["chrt", "--rr", "2", "true"]
    return subprocess.run(command, stderr=subprocess.DEVNULL, check=False).returncode == 0


def test_all_threads_come_first_where_the_user_may_have_that():
    expected = may_be_realtime() and len(os.sched_getaffinity(0)) > 1
    assert run(KEEP_TIME, "as it is") == str(expected)


@pytest.mark.parametrize("case", ["forbidden", "one processor", "not wanted"])
def test_else_they_ask_for_short_slices(case):
    assert run(KEEP_TIME, case) == "False"


def test_stepping_back_holds_against_other_sessions():
    told = run(STEP_BACK)
    assert told == "" or told.endswith("nice 7"), told
