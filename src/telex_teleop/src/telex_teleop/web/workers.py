"""Threads for calls that block or take long: to the ROS master, to services, to encoders.

All threads here are daemons. Those of concurrent.futures are joined when the interpreter ends, so
that one service that never answers would keep the node from ending.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import queue
import threading
from typing import Any, Callable, Dict, Hashable, Optional, Tuple, TypeVar

Result = TypeVar("Result")
_Job = Tuple[Callable[[], Any], "asyncio.Future[Any]"]


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

    Keys take turns, so that none of them starves however often another one calls.
    """

    def __init__(self, name: str) -> None:
        self._calls: Dict[Hashable, Callable[[], None]] = {}
        self._changed = threading.Condition()
        threading.Thread(target=self._run, name=name, daemon=True).start()

    @property
    def backlog(self) -> int:
        """How many calls wait for their turn."""
        return len(self._calls)

    def submit(self, key: Hashable, call: Callable[[], None]) -> None:
        """Let a call run instead of the one of the same key that still waits."""
        with self._changed:
            self._calls[key] = call
            self._changed.notify()

    def cancel(self, key: Hashable) -> None:
        """Forget the call of a key, if it still waits."""
        with self._changed:
            self._calls.pop(key, None)

    def _run(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._calls)
                call = self._calls.pop(next(iter(self._calls)))
            try:
                call()
            except Exception:  # the thread serves all; the one whose call it is goes without
                logging.getLogger(__name__).exception("a call in a thread failed")
