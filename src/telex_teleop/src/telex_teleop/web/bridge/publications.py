"""What one client publishes on one topic."""

from __future__ import annotations

import collections
from typing import Any, Callable, Deque, Optional, Set, Tuple

import genpy

from .message_json import FieldError
from .operations import Id, OperationError
from .publishers import PublisherPool, SharedPublisher
from .ros import Ros
from .stop import stop_for

MAX_HELD = 20
"""Messages that wait while a new publisher finds its subscribers; the newest win."""

_NAMES_CLIENT = ("telex_msgs/FlipperPresetHold",)
"""Types with a field `client`: operators who share the bridge must not pass for one."""

Report = Callable[[str, Id], None]
"""Tells the client what went wrong with the operation of an id."""


class Publication:
    """A topic that one client publishes.

    Until the subscribers of a new publisher are connected its messages wait; without that the
    first ones would be lost.

    Parameters
    ----------
    topic
        Global name.
    latch
        Whether the last message is kept for subscribers to come.
    queue_size
        Messages that are kept for a slow subscriber.
    pool
        Where publishers come from.
    ros
        For the present time.
    client
        Name of the client, in messages that have a place for it.
    report
        Tells the client what went wrong.
    """

    def __init__(
        self,
        topic: str,
        *,
        latch: bool,
        queue_size: int,
        pool: PublisherPool,
        ros: Ros,
        client: str,
        report: Report,
    ) -> None:
        self.topic = topic
        self.ids: Set[Id] = set()
        self._latch = latch
        self._queue_size = queue_size
        self._pool = pool
        self._ros = ros
        self._client = client
        self._report = report
        self._publisher: Optional[SharedPublisher] = None
        self._ready = False
        self._held: Deque[Tuple[Any, Id]] = collections.deque(maxlen=MAX_HELD)
        self._stop: Optional[genpy.Message] = None

    async def open(self, type_name: Optional[str], connect_timeout: float) -> None:
        """Get the publisher, wait for its subscribers, send what has waited.

        Raises
        ------
        OperationError
            The topic cannot be published with this type.
        """
        self._publisher = await self._pool.acquire(
            self.topic, type_name, latch=self._latch, queue_size=self._queue_size
        )
        await self._publisher.settle(connect_timeout)
        self._ready = True
        while self._held:
            self._send(self._publisher, *self._held.popleft())

    def publish(self, value: Any, operation_id: Id) -> None:
        """Publish a message given as JSON, now or as soon as that is possible."""
        if self._publisher is not None and self._ready:
            self._send(self._publisher, value, operation_id)
        else:
            self._held.append((value, operation_id))

    def _send(self, publisher: SharedPublisher, value: Any, operation_id: Id) -> None:
        try:
            message = publisher.codec.from_json({} if value is None else value, self._ros.now)
            if message._type in _NAMES_CLIENT:
                message.client = self._client
            publisher.publish(message)
        except (FieldError, OperationError) as error:
            self._report(f"publish to {self.topic}: {error}", operation_id)
        else:
            self._stop = stop_for(message)

    def close(self) -> None:
        """End: stop what the client drove, and give the publisher back."""
        if self._publisher is None:
            return
        if self._stop is not None:
            try:
                self._publisher.publish(self._stop)
            except OperationError as error:
                self._report(f"stop on {self.topic}: {error}", None)
        self._publisher = None
        self._pool.release(self.topic, latch=self._latch)
