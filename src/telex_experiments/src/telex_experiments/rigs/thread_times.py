"""Use of the processors: how long each thread of the machine ran, and waited for one.

Read from /proc/*/task/*/schedstat, as far as it may be read.
"""

from __future__ import annotations

import contextlib
import os
from collections import deque
from pathlib import Path
from typing import Deque, Dict, Iterator, List, Mapping, NamedTuple, Tuple

KEPT = 3
"""Looks whose threads are kept."""
LEAST = 0.005
"""Threads that ran and waited less (s) are not told."""
MOST = 15
"""Threads that are told of one look."""


def schedstat(folder: str) -> Tuple[int, int]:
    """Return for how long (ns) a process or a thread has run, and waited for a processor.

    Raises
    ------
    OSError, ValueError
        It has ended, or may not be looked at.
    """
    with open(f"{folder}/schedstat") as file:
        ran, waited, *_ = file.read().split()
    return int(ran), int(waited)


class ThreadTime(NamedTuple):
    """What a thread did between two looks.

    Attributes
    ----------
    name : str
        Of the process and of the thread, with their numbers.
    ran, waited : float
        On a processor, and for one (s).
    """

    name: str
    ran: float
    waited: float


class ThreadTimes:
    """Looks at all threads again and again, at little cost.

    A look reads one file of each process; those of its threads only when its CPU time has grown.

    Parameters
    ----------
    root : str
        Where the kernel shows its processes.
    """

    def __init__(self, root: str = "/proc") -> None:
        self._root = root
        self._used: Dict[str, Tuple[str, ...]] = {}
        self._threads: Dict[Tuple[str, str], Tuple[int, int]] = {}
        self._looks: Deque[List[ThreadTime]] = deque(maxlen=KEPT)

    def look(self) -> None:
        """Note what each thread did since the last look; of a process first seen, nothing."""
        found: List[ThreadTime] = []
        present = set()
        for pid in filter(str.isdigit, os.listdir(self._root)):
            # It may end at any moment.
            with contextlib.suppress(OSError, IndexError, ValueError):
                name, used = self._process(pid)
                present.add(pid)
                known = self._used.get(pid)
                if used != known:
                    self._used[pid] = used
                    times = list(self._grown(pid, name))
                    found += times if known is not None else ()
        for pid in self._used.keys() - present:
            del self._used[pid]
        self._threads = {key: value for key, value in self._threads.items() if key[0] in present}
        self._looks.append(found)

    def _process(self, pid: str) -> Tuple[str, Tuple[str, ...]]:
        """Name of a process, and its CPU times as the kernel writes them."""
        with open(f"{self._root}/{pid}/stat") as file:
            head, _, rest = file.read().rpartition(")")
        return head.partition("(")[2], tuple(rest.split()[11:13])

    def _grown(self, pid: str, process: str) -> Iterator[ThreadTime]:
        """What each thread of a process did since they were read last."""
        for tid in os.listdir(f"{self._root}/{pid}/task"):
            task = f"{self._root}/{pid}/task/{tid}"
            with contextlib.suppress(OSError, ValueError):
                ran, waited = schedstat(task)
                before = self._threads.get((pid, tid), (0, 0))
                self._threads[pid, tid] = ran, waited
                if (ran, waited) != before:
                    with open(f"{task}/comm") as comm:
                        name = f"{process} {pid}, {comm.read().strip()} {tid}"
                    yield ThreadTime(name, 1e-9 * (ran - before[0]), 1e-9 * (waited - before[1]))

    def table(self) -> str:
        """The threads of the last looks, the oldest first, by how long they ran and waited."""
        lines = []
        for age, found in zip(range(len(self._looks) - 1, -1, -1), self._looks):
            told = [each for each in found if each.ran + each.waited >= LEAST]
            told.sort(key=lambda each: each.ran + each.waited, reverse=True)
            lines.append(f"    {age} before: {len(told)} threads" if age else "    then:")
            lines += [
                f"      ran {1e3 * ran:5.0f} ms, waited {1e3 * waited:5.0f} ms: {name}"
                for name, ran, waited in told[:MOST]
            ]
        return "\n".join(lines)


Thread = Tuple[str, int, int]
"""Name of the process, and numbers of process and thread."""


class Share(NamedTuple):
    """Time (s) that a thread has run, and that it could have run but waited for a processor."""

    running: float
    waiting: float


def threads(processes: Mapping[int, str]) -> Dict[Thread, Share]:
    """Return what the threads of some processes, given with their names, have had so far."""
    found = {}
    for pid, name in processes.items():
        with contextlib.suppress(OSError):
            for task in os.listdir(f"/proc/{pid}/task"):
                with contextlib.suppress(OSError):
                    share = (1e-9 * each for each in schedstat(f"/proc/{pid}/task/{task}"))
                    found[name, pid, int(task)] = Share(*share)
    return found


def used(before: Mapping[Thread, Share], after: Mapping[Thread, Share]) -> Dict[Thread, Share]:
    """Return what threads have had between two looks."""
    nothing = Share(0.0, 0.0)
    return {
        thread: Share(*(b - a for a, b in zip(before.get(thread, nothing), share)))
        for thread, share in after.items()
    }


def thread_name(thread: Thread) -> str:
    """Return what to call a thread of a process that is still there."""
    _, pid, task = thread
    if pid == task:
        return "main"
    try:
        return Path(f"/proc/{pid}/task/{task}/comm").read_text().strip()
    except OSError:
        return "ended"


def idle_seconds() -> float:
    """Return the time (s) that all processors together have been idle since the start."""
    fields = Path("/proc/stat").read_text().splitlines()[0].split()
    return (int(fields[4]) + int(fields[5])) / os.sysconf("SC_CLK_TCK")
