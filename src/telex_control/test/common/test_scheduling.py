"""A process that steps forward or back among all others, each in a process of its own."""

import os
import signal
import subprocess
import sys

import pytest

# What comes before all others would hold up a browser that another worker tests.
pytestmark = [pytest.mark.real_time, pytest.mark.waiting]

START = """
import ctypes, os, struct, sys, threading, time
from telex_control.common import scheduling

ended = threading.Event()
def thread():
    it = threading.Thread(target=ended.wait)
    it.start()
    return it.native_id

def policies():
    return {os.sched_getscheduler(int(each)) for each in os.listdir("/proc/self/task")}
"""

TAKE = """
CASE = sys.argv[1]
if CASE in ("forbidden", "unknown"):
    def refuse(*arguments):
        raise PermissionError(1, "forbidden") if CASE == "forbidden" else OSError(22, "unknown")
    os.sched_setscheduler = refuse
if CASE == "one processor":
    os.sched_getaffinity = lambda process: {0}

def slice_of(thread):
    number = {"x86_64": 315, "aarch64": 275}[os.uname().machine]  # sched_getattr(2)
    told = ctypes.create_string_buffer(48)
    assert ctypes.CDLL(None).syscall(number, thread, told, 48, 0) == 0
    return struct.unpack("=IIQiIQQQ", told.raw)[5]

nice = min(os.nice(0) + 3, 19)
os.nice(3)
threads = [os.getpid(), thread()]
priority = 0 if CASE == "not wanted" else 2
may = scheduling.may_come_first(priority)
why_not = scheduling.LoopPriority(priority).take()
threads.append(thread())
assert {os.getpriority(os.PRIO_PROCESS, each) for each in threads} == {nice}
assert may == (not why_not)
if why_not:
    assert policies() == {os.SCHED_OTHER}
    linux = tuple(int(part) for part in os.uname().release.split("-")[0].split(".")[:2])
    if linux >= (6, 12) and os.uname().machine in ("x86_64", "aarch64"):
        assert {slice_of(each) for each in threads} == {scheduling.WAKE_SLICE}
else:
    assert policies() == {os.SCHED_RR}
    assert {os.sched_getparam(each).sched_priority for each in threads} == {2}
ended.set()
print(why_not)
"""

NEVER_REST = """
scheduling.ORDINARY_FOR = 1.0
priority = scheduling.LoopPriority(1)
assert not priority.take()
thread()

def rest_for(seconds):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        time.sleep(0.001)
        priority.rest()
        yield

def compute_for(seconds):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        yield

def becomes(policy, steps):
    for _ in steps:
        if policies() == {policy}:
            return
    raise AssertionError(f"still {policies()}")

for _ in range(2):
    assert all(policies() == {os.SCHED_RR} for _ in rest_for(1.0))
    becomes(os.SCHED_OTHER, compute_for(30.0))
    assert all(policies() == {os.SCHED_OTHER} for _ in compute_for(2.0))  # does not come back
    becomes(os.SCHED_RR, rest_for(30.0))
ended.set()
"""

FAILS_ONCE = """
each_thread, failing = scheduling._each_thread, [False, True, False, True]
def fails_at_first(action):
    if failing and failing.pop(0):
        raise OSError(24, "no file descriptor is left")
    each_thread(action)
scheduling._each_thread = fails_at_first
"""

HANG = """
scheduling.LONGEST_CALL = 0.3
assert not scheduling.LoopPriority(1).take()
print("hangs", flush=True)
sum(range(10**15))  # never lets another thread have Python's lock
"""

FOREIGN = """
os.sched_setscheduler(0, os.SCHED_BATCH, os.sched_param(0))
assert not scheduling.may_come_first(1)
why_not = scheduling.LoopPriority(1).take()
scheduling.ask_for_short_slices()
assert policies() == {os.SCHED_BATCH}
print(why_not)
"""

NICENESS = """
import os
from pathlib import Path
from telex_control.common.scheduling import add_niceness

expected = min(os.nice(0) + 7, 19)
add_niceness(7)
assert os.nice(0) == expected
group = Path("/proc/self/autogroup")
try:
    told = group.read_text().strip()
except OSError:
    told = ""
print(told)
"""


FORWARD = """
import os
from telex_control.common import scheduling

before = os.nice(0)
def refuse(increment):
    raise PermissionError(1, "forbidden")
os.nice, asked = refuse, os.nice
scheduling.add_niceness(-3)
assert asked(0) == before
"""


def run(script, *arguments, ends=0):
    result = subprocess.run(
        [sys.executable, "-c", script, *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=90.0,
        check=False,
        start_new_session=True,
    )
    assert result.returncode == ends, result.stdout
    return result.stdout.strip()


def may_be_realtime():
    """Whether this user may have real-time processes, as the system itself says it."""
    command = ["chrt", "--rr", "2", "true"]
    tried = subprocess.run(command, stderr=subprocess.DEVNULL, check=False)
    return tried.returncode == 0 and len(os.sched_getaffinity(0)) > 1


def test_all_threads_come_first_where_the_user_may_have_that():
    assert (run(START + TAKE, "as it is") == "") == may_be_realtime()


@pytest.mark.parametrize(
    ("case", "why"),
    [
        ("forbidden", "forbidden" if len(os.sched_getaffinity(0)) > 1 else "one processor only"),
        ("unknown", "unknown" if len(os.sched_getaffinity(0)) > 1 else "one processor only"),
        ("one processor", "one processor only"),
        ("not wanted", "none is wanted"),
    ],
)
def test_else_they_ask_for_short_slices(case, why):
    assert why in run(START + TAKE, case)


@pytest.fixture
def realtime():
    if not may_be_realtime():
        pytest.skip("this user may not have real-time processes, or there is one processor only")


def test_a_loop_that_never_rests_gives_way_for_a_while(realtime):
    run(START + NEVER_REST)


def test_a_watch_that_fails_once_goes_on(realtime):
    run(START + FAILS_ONCE + NEVER_REST)


def test_a_native_call_that_hangs_is_ended(realtime):
    assert run(START + HANG, ends=-signal.SIGXCPU) == "hangs"


def test_a_scheduler_that_was_given_is_kept():
    assert "which is kept" in run(START + FOREIGN)


def test_stepping_back_holds_against_other_sessions():
    told = run(NICENESS)
    assert told == "" or told.endswith("nice 7"), told


def test_who_may_not_come_forward_stays_where_it_is():
    run(FORWARD)
