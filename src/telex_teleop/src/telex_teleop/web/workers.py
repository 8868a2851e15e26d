"""Threads for calls that block or take long: to the ROS master, to services, to encoders.

All threads here are daemons. Those of concurrent.futures are joined when the interpreter ends, so
that one service that never answers would keep the node from ending.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import os
import queue
import threading
import time
from typing import Any, Callable, Dict, Hashable, Optional, Tuple, TypeVar

Result = TypeVar("Result")
_Job = Tuple[Callable[[], Any], "asyncio.Future[Any]"]

_NEWS = 0.1
"""Weight of the last call in what calls usually take."""


def _settle(future: asyncio.Future[Any], result: Any, error: Optional[Exception]) -> None:
    """Hand a result to a future on its loop, unless nobody waits any more."""
    if future.done():
        return
    if error is None:
        future.set_result(result)
    else:
        future.set_exception(error)
        # Reading it marks it as seen: whoever posted the job may not be interested in its outcome.
        future.exception()


def _run_job(call: Callable[[], Any], future: asyncio.Future[Any]) -> None:
    """Run one job in the present thread and deliver its outcome to the loop."""
    result, failure = None, None
    try:
        result = call()
    except Exception as error:  # whatever it is belongs to the caller
        failure = error
    with contextlib.suppress(RuntimeError):  # the loop has closed meanwhile: the node ends
        future.get_loop().call_soon_threadsafe(_settle, future, result, failure)


def in_own_thread(call: Callable[[], Result]) -> asyncio.Future[Result]:
    """Start a call in a thread of its own and return a future of its result."""
    future: asyncio.Future[Result] = asyncio.get_running_loop().create_future()
    threading.Thread(target=_run_job, args=(call, future), daemon=True).start()
    return future


class OrderedWorker:
    """One thread that runs calls in the order in which they were submitted."""

    def __init__(self, name: str) -> None:
        self._jobs: queue.Queue[_Job] = queue.Queue()
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    @property
    def backlog(self) -> int:
        """How many calls wait for their turn."""
        return self._jobs.qsize()

    def submit(self, call: Callable[[], Result]) -> asyncio.Future[Result]:
        """Queue a call and return a future of its result; call it on the loop's thread."""
        future: asyncio.Future[Result] = asyncio.get_running_loop().create_future()
        self._jobs.put((call, future))
        return future

    def _run(self) -> None:
        while True:
            _run_job(*self._jobs.get())


class NewestWorker:
    """One thread that runs the newest call of each key; a call that is overtaken never runs.

    The call comes first after which its key will have used the thread least, as fair queueing has
    it: keys whose calls take long get their share of the time, and make the others wait for no more
    than one call. A key that begins, or has paused, starts level with the others: with what each
    of them would have used by now if all had got the same. That grows with every call, so that
    keys which keep coming and going cannot hold back one that stays.

    Parameters
    ----------
    name
        Of the thread.
    niceness
        How far the thread steps back behind others of the machine, 0 to 19.
    """

    def __init__(self, name: str, niceness: int = 0) -> None:
        self._niceness = niceness
        self._calls: Dict[Hashable, Callable[[], None]] = {}
        self._used: Dict[Hashable, float] = {}  # s of the thread's time
        self._took: Dict[Hashable, float] = {}  # s, the last call
        self._level = 0.0  # s, where a key begins; it never falls
        self._usual = 0.0  # s, what calls took of late
        self._changed = threading.Condition()
        threading.Thread(target=self._run, name=name, daemon=True).start()

    @property
    def backlog(self) -> int:
        """How many calls wait for their turn."""
        return len(self._calls)

    def submit(self, key: Hashable, call: Callable[[], None]) -> None:
        """Let a call run instead of the one of the same key that still waits."""
        with self._changed:
            if key not in self._calls:
                self._used[key] = max(self._used.get(key, 0.0), self._level)
            self._calls[key] = call
            self._changed.notify()

    def cancel(self, key: Hashable) -> None:
        """Forget a key, and its call if that still waits."""
        with self._changed:
            self._calls.pop(key, None)
            self._used.pop(key, None)
            self._took.pop(key, None)

    def _run(self) -> None:
        if self._niceness:
            # On Linux this is the thread's own.
            os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), self._niceness)
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._calls)
                key = min(self._calls, key=self._rank)
                sharers, used = len(self._calls), self._used[key]
                call = self._calls.pop(key)
            began = time.monotonic()
            try:
                call()
            except Exception:  # the thread serves all; the one whose call it is goes without
                logging.getLogger(__name__).exception("a call in a thread failed")
            took = time.monotonic() - began
            with self._changed:
                self._level += took / sharers
                self._usual += (took - self._usual) * _NEWS
                if key in self._used:
                    self._took[key] = took
                    self._used[key] = max(used + took, self._level)

    def _rank(self, key: Hashable) -> float:
        """Return what the key will have used after its call, if that takes as long as the last.

        A key that is new is taken for one like the others.
        """
        return self._used[key] + self._took.get(key, self._usual)
