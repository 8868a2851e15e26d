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
from typing import (
    Any,
    Callable,
    Dict,
    FrozenSet,
    Hashable,
    Iterable,
    List,
    Optional,
    Tuple,
    TypeVar,
)

from .fair_shares import FairShares

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

    The thread's time is shared fairly between clients, and each client's between its keys
    (`FairShares`). What several clients want, each of them pays a part of.

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
        self._payers: Dict[Hashable, FrozenSet[Hashable]] = {}  # the clients, by key
        self._clients = FairShares()
        self._keys: Dict[Hashable, FairShares] = {}  # by client
        self._changed = threading.Condition()
        threading.Thread(target=self._run, name=name, daemon=True).start()

    @property
    def backlog(self) -> int:
        """How many calls wait for their turn."""
        return len(self._calls)

    def submit(
        self, key: Hashable, call: Callable[[], None], clients: Iterable[Hashable] = ()
    ) -> None:
        """Let a call run instead of the one of the same key that still waits.

        Parameters
        ----------
        key, call
            What is to run.
        clients
            Who wants it; by default the key is a client of its own.
        """
        payers = frozenset(clients) or frozenset((key,))
        with self._changed:
            before = self._payers.get(key, frozenset())
            for client in before - payers:
                self._take_back(client, key)
            waiting = self._waiting()
            for client in payers:
                if client not in waiting:
                    self._clients.enter(client)
                if key not in waiting.get(client, ()):
                    self._keys.setdefault(client, FairShares()).enter(key)
            self._payers[key] = payers
            self._calls[key] = call
            self._changed.notify()

    def cancel(self, key: Hashable) -> None:
        """Forget a key, and its call if that still waits."""
        with self._changed:
            self._calls.pop(key, None)
            for client in self._payers.pop(key, ()):
                self._take_back(client, key)

    def _take_back(self, client: Hashable, key: Hashable) -> None:
        """Let a client pay for a key no longer; without keys it is forgotten."""
        keys = self._keys[client]
        keys.leave(key)
        if not keys:
            del self._keys[client]
            self._clients.leave(client)

    def _waiting(self) -> Dict[Hashable, List[Hashable]]:
        """Return the keys whose calls wait, by client."""
        waiting: Dict[Hashable, List[Hashable]] = {}
        for key in self._calls:
            for client in self._payers[key]:
                waiting.setdefault(client, []).append(key)
        return waiting

    def _run(self) -> None:
        if self._niceness:
            # On Linux this is the thread's own.
            os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), self._niceness)
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._calls)
                waiting = self._waiting()
                client = self._clients.next(waiting)
                key = self._keys[client].next(waiting[client])
                # Each that pays, with what it and its key had used before.
                bills = [
                    (payer, self._clients.used(payer), self._keys[payer].used(key))
                    for payer in self._payers[key]
                ]
                call = self._calls.pop(key)
            began = time.monotonic()
            try:
                call()
            except Exception:  # the thread serves all; the one whose call it is goes without
                logging.getLogger(__name__).exception("a call in a thread failed")
            took = time.monotonic() - began
            with self._changed:
                self._clients.advance(took, len(waiting))
                part = took / len(bills)
                for payer, used, used_by_key in bills:
                    self._clients.charge(payer, used, part)
                    keys = self._keys.get(payer)
                    if keys is not None:
                        keys.advance(part, len(waiting[payer]))
                        keys.charge(key, used_by_key, part)
