"""Things that several clients use: opened for the first, closed after the last."""

from __future__ import annotations

import asyncio
from typing import Callable, Dict, Generic, Hashable, Optional, Protocol, TypeVar

from ..workers import OrderedWorker
from .protocol.operations import OperationError

MAX_BACKLOG = 1000
"""Calls to ROS that may wait; more come only from a client that has gone wild."""


class Closable(Protocol):
    """Something that can be closed."""

    def close(self) -> None:
        """End it; may block."""


Key = TypeVar("Key", bound=Hashable)
Resource = TypeVar("Resource", bound=Closable)


class _Share(Generic[Resource]):
    """One resource; `open` and `close` run in the worker's thread, one after the other."""

    def __init__(self, make: Callable[[], Resource]) -> None:
        self.users = 0
        self.failed = False
        self.opened: Optional[asyncio.Future[Resource]] = None
        self._make = make
        self.resource: Optional[Resource] = None

    def open(self) -> Resource:
        try:
            self.resource = self._make()
        except Exception:
            self.failed = True
            raise
        return self.resource

    def close(self) -> None:
        if self.resource is not None:
            self.resource.close()


class SharedResources(Generic[Key, Resource]):
    """Resources by key, counted on the loop's thread, opened and closed in a worker's.

    Parameters
    ----------
    worker
        Thread for the calls that block.
    linger
        Time (s) that a resource outlives its last user.
    """

    def __init__(self, worker: OrderedWorker, linger: float) -> None:
        self._worker = worker
        self._linger = linger
        self._shares: Dict[Key, _Share[Resource]] = {}

    def __len__(self) -> int:
        return len(self._shares)

    async def acquire(self, key: Key, make: Callable[[], Resource]) -> Resource:
        """Return the resource of a key; each one got must be released once.

        Parameters
        ----------
        key
            What is wanted.
        make
            Opens it, for the first user; runs in the worker's thread.

        Raises
        ------
        OperationError
            Too many calls are waiting. Besides, whatever `make` raises.
        """
        share = self._shares.get(key)
        if share is None:
            if self._worker.backlog > MAX_BACKLOG:
                raise OperationError("too many requests to ROS are waiting; try again later")
            share = _Share(make)
            share.opened = self._worker.submit(share.open)
            self._shares[key] = share
        share.users += 1
        assert share.opened is not None
        try:
            return await asyncio.shield(share.opened)
        except BaseException:
            self.release(key)
            raise

    def in_use(self, key: Key) -> Optional[Resource]:
        """Return the resource of a key if it is open and somebody uses it."""
        share = self._shares.get(key)
        return share.resource if share is not None and share.users else None

    def release(self, key: Key) -> None:
        """Give a resource back."""
        share = self._shares[key]
        share.users -= 1
        if share.users:
            return
        if share.failed or self._linger == 0.0:
            self._close(key, share)
        else:
            asyncio.get_running_loop().call_later(self._linger, self._close, key, share)

    def _close(self, key: Key, share: _Share[Resource]) -> None:
        """Close a resource, unless somebody has taken it again meanwhile."""
        if share.users == 0 and self._shares.get(key) is share:
            del self._shares[key]
            self._worker.submit(share.close)
