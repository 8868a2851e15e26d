"""Priorities of a process among all others on the machine."""

from __future__ import annotations

import contextlib
import ctypes
import os
import resource
import struct
import threading
import time
from pathlib import Path
from typing import Callable

LONGEST_RUN = 0.2
"""Time (s) without a rest after which the process of a loop becomes an ordinary one."""

ORDINARY_FOR = 5.0
"""Time (s) for which it remains one, at least."""

LONGEST_CALL = 30.0
"""Computing time (s) in one native call after which the kernel ends the process (SIGXCPU)."""

WAKE_SLICE = 100_000
"""Time (ns) that an ordinary thread of the loop, or of who hands commands on, asks for at once;
Linux serves short ones first."""

_ONE_PROCESSOR = "it has one processor only, which it would take from all others"

# Number of the system call, by machine: Python and the C library of Debian 12 have no function.
_SCHED_SETATTR = {"x86_64": 314, "aarch64": 274}


class LoopPriority:
    """Puts a process with a loop before all ordinary ones, as long as the loop rests now and then.

    As an ordinary process, a loop that runs every few milliseconds beside processes that use all
    there is waits for a processor as long as it computes. As a real-time one it does not, but one
    that computed without a rest would leave too little to what is to stop it: it gives way then.
    One that hangs in a native call, which keeps Python's lock and with it this watch from running,
    is ended by the kernel. Child processes inherit what this one is.

    Parameters
    ----------
    priority : int
        Among the machine's real-time processes (SCHED_RR), 1 to 99; 0 leaves it an ordinary one.
    """

    def __init__(self, priority: int) -> None:
        self._priority = priority
        self._rested_at = 0.0

    def take(self) -> str:
        """Make all threads real-time ones, also those that are started later.

        Where that cannot be, they are ordinary threads that ask for short slices of time (from
        Linux 6.12 on). Call it once, and `rest` from then on.

        Returns
        -------
        str
            Why they are ordinary threads; empty where they are not.
        """
        if os.sched_getscheduler(0) != os.SCHED_OTHER:
            return "it was started with a scheduler of its own, which is kept"
        refused = self._refused()
        if refused:
            _each_thread(_make_ordinary)
        else:
            refused = self._come_first()
        if refused:
            return refused
        _limit_native_calls()
        self.rest()
        threading.Thread(target=self._watch, name="loop_priority", daemon=True).start()
        return ""

    def rest(self) -> None:
        """Tell that the loop has just rested."""
        self._rested_at = time.monotonic()

    def _refused(self) -> str:
        if self._priority == 0:
            return "none is wanted"
        return _ONE_PROCESSOR if len(os.sched_getaffinity(0)) < 2 else ""

    def _come_first(self) -> str:
        """Make all threads real-time ones, or else all ordinary ones, and return why."""
        try:
            _each_thread(self._run_first)
        except OSError as error:
            _each_thread(_make_ordinary)
            return error.strerror or str(error)
        return ""

    def _run_first(self, thread: int) -> None:
        os.sched_setscheduler(thread, os.SCHED_RR, os.sched_param(self._priority))

    def _watch(self) -> None:
        """Give way when the loop no longer rests, and come back some time after it does again.

        The kernel has a limit for that (RLIMIT_RTTIME), but for it a thread rests that hands the
        interpreter over to another one.
        """
        comes_first, gave_way_at = True, 0.0
        while True:
            time.sleep(0.5 * LONGEST_RUN)
            now = time.monotonic()
            rests = now < self._rested_at + LONGEST_RUN
            try:
                if comes_first and not rests:
                    _each_thread(_make_ordinary)
                    comes_first, gave_way_at = False, now
                elif not comes_first and rests and now >= gave_way_at + ORDINARY_FOR:
                    comes_first = True  # some threads at least, where this raises
                    comes_first, gave_way_at = not self._come_first(), now
            except OSError:
                continue  # no file descriptor is left, say; tried again


def _limit_native_calls() -> None:
    """Have the kernel end this process where a real-time thread computes on and on."""
    soft, hard = resource.getrlimit(resource.RLIMIT_RTTIME)
    wanted = round(1e6 * LONGEST_CALL)
    if soft == resource.RLIM_INFINITY or wanted < soft:
        resource.setrlimit(resource.RLIMIT_RTTIME, (wanted, hard))


def _each_thread(action: Callable[[int], None]) -> None:
    """Do something to all threads of this process, those included that begin meanwhile.

    Raises
    ------
    OSError
        Of `action`, but for threads that have ended.
    """
    done = set()
    while True:
        new = [int(name) for name in os.listdir("/proc/self/task") if int(name) not in done]
        if not new:
            return
        for thread in new:
            done.add(thread)
            with contextlib.suppress(ProcessLookupError):
                action(thread)


def _make_ordinary(thread: int) -> None:
    """Let a thread have its share, served sooner for less at a time."""
    if os.sched_getscheduler(thread) != os.SCHED_OTHER:
        os.sched_setscheduler(thread, os.SCHED_OTHER, os.sched_param(0))
    number = _SCHED_SETATTR.get(os.uname().machine)
    if number is None or struct.calcsize("P") != 8:
        return
    # struct sched_attr of sched_setattr(2): size, policy, flags, nice, priority, runtime, ...
    nice = os.getpriority(os.PRIO_PROCESS, thread)
    size = struct.calcsize("=IIQiIQQQ")
    wanted = struct.pack("=IIQiIQQQ", size, os.SCHED_OTHER, 0, nice, 0, WAKE_SLICE, 0, 0)
    ctypes.CDLL(None).syscall(number, thread, wanted, 0)


def ask_for_short_slices() -> None:
    """Have all threads of this process, and those it starts, served sooner for less at a time.

    That is for who hands commands on: it computes little, and what it waits, the robot waits. From
    Linux 6.12 on; everybody may. A process that was started with a scheduler of its own keeps it.
    """
    if os.sched_getscheduler(0) == os.SCHED_OTHER:
        _each_thread(_make_ordinary)


def may_come_first(priority: int) -> bool:
    """Tell whether a `LoopPriority` of this user would come before ordinary processes here.

    It tries it for a moment with the calling thread; where that is no ordinary one, it is False.
    """
    if not priority or len(os.sched_getaffinity(0)) < 2:
        return False
    if os.sched_getscheduler(0) != os.SCHED_OTHER:
        return False
    try:
        os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(priority))
    except OSError:
        return False
    os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
    return True


def add_niceness(niceness: int) -> None:
    """Change the priority of the calling thread, and of those it starts, against all others.

    Linux shares the processors among sessions first (sched_autogroup), and roslaunch gives every
    node a session of its own: niceness alone would change nothing there.

    Parameters
    ----------
    niceness : int
        -20 to 19; added to what the thread has, and that of its session. Below 0 it raises the
        priority, where the user may do that: root, or who has ``nice`` in limits.conf(5). Where
        not, nothing changes.
    """
    try:
        os.nice(niceness)
    except PermissionError:
        return
    if os.getsid(0) == os.getpid():
        with contextlib.suppress(OSError):
            Path("/proc/self/autogroup").write_text(str(niceness))
