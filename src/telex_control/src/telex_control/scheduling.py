"""What a process gets of the processors, beside all others on the machine."""

from __future__ import annotations

import contextlib
import ctypes
import os
import platform
import struct
from pathlib import Path

__all__ = ["keep_time", "step_back"]

WAKE_SLICE = 100_000
"""Time (ns) that a thread of the loop asks for at once; the scheduler serves short ones first."""

# Number of the system call, by machine: Python and the C library of Debian 12 have no function.
_SCHED_SETATTR = {"x86_64": 314, "aarch64": 274}


def keep_time(priority: int) -> bool:
    """Have all threads of this process run as soon as they have something to do.

    For a loop that has to run every few milliseconds beside processes that use all there is: as an
    ordinary process it waits in line for a processor as long as it computes. Threads that are
    started later inherit it.

    Parameters
    ----------
    priority : int
        Among the machine's real-time processes (SCHED_RR), 1 to 99; 0 leaves it an ordinary one.

    Returns
    -------
    bool
        Whether these are real-time threads now. Where that is not permitted, not wanted, or there
        is one processor only, which the loop could take from all that is to stop it, they are
        ordinary threads that ask for short slices of time (Linux 6.12; no effect before).
    """
    realtime = priority > 0 and len(os.sched_getaffinity(0)) > 1
    done = set()
    while True:
        new = [int(name) for name in os.listdir("/proc/self/task") if int(name) not in done]
        if not new:
            return realtime
        for thread in new:
            done.add(thread)
            with contextlib.suppress(ProcessLookupError):
                realtime = realtime and _run_first(thread, priority)
                if not realtime:
                    _ask_for_short_slices(thread)


def _run_first(thread: int, priority: int) -> bool:
    """Make a thread a real-time one; returns whether this user may."""
    try:
        os.sched_setscheduler(thread, os.SCHED_RR, os.sched_param(priority))
    except PermissionError:
        return False
    return True


def _ask_for_short_slices(thread: int) -> None:
    """Let an ordinary thread be served sooner, for less at a time; its share remains the same."""
    number = _SCHED_SETATTR.get(platform.machine())
    if number is None:
        return
    # struct sched_attr of sched_setattr(2): size, policy, flags, nice, priority, runtime, ...
    nice = os.getpriority(os.PRIO_PROCESS, thread)
    size = struct.calcsize("=IIQiIQQQ")
    wanted = struct.pack("=IIQiIQQQ", size, os.SCHED_OTHER, 0, nice, 0, WAKE_SLICE, 0, 0)
    ctypes.CDLL(None).syscall(number, thread, wanted, 0)


def step_back(niceness: int) -> None:
    """Lower the priority of this process against all others, by 0 to 19.

    Linux shares the processors among sessions first (sched_autogroup), and roslaunch gives every
    node a session of its own: niceness alone would change nothing there.
    """
    os.nice(niceness)
    if os.getsid(0) == os.getpid():
        with contextlib.suppress(OSError):
            Path("/proc/self/autogroup").write_text(str(niceness))
