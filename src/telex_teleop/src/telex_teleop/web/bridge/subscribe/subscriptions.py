"""One client's subscriptions to one topic."""

from __future__ import annotations

import asyncio
import dataclasses
import math
from typing import Callable, Dict, Optional

from ..protocol.compression import COMPRESSIONS, Encoded
from ..protocol.operations import Id
from .feeds import FeedPool, TopicFeed, TopicMessage

Send = Callable[[str, Encoded, int], None]
"""Queues a message of a topic, of which at most so many may wait."""


@dataclasses.dataclass(frozen=True)
class Wish:
    """One subscribe operation: least time between messages (s), how many may wait, and how."""

    throttle: float
    depth: int
    compression: str


class Subscription:
    """The messages of a topic for one client, no more often than it asked for.

    A message that comes too early waits until it is due, and a newer one replaces it: what the
    client saw last is never old news for longer than the throttle period. Of several that come at
    once the newest counts, too.

    Parameters
    ----------
    topic
        Global name of the topic.
    type_name
        What the client says its type is; None if it does not.
    spelled
        The topic as the client spells it, which is how it expects to hear of it.
    feeds
        Where messages come from.
    send
        Queues a message for the client.
    """

    def __init__(
        self, topic: str, type_name: Optional[str], spelled: str, *, feeds: FeedPool, send: Send
    ) -> None:
        self._topic = topic
        self._asked_type = type_name
        self._spelled = spelled
        self._feeds = feeds
        self._send = send
        self._feed: Optional[TopicFeed] = None
        self._loop = asyncio.get_running_loop()
        self._wishes: Dict[Id, Wish] = {}
        self._sent = -math.inf
        self._pending: Optional[TopicMessage] = None
        self._timer: Optional[asyncio.TimerHandle] = None

    @property
    def type_name(self) -> Optional[str]:
        """Type of the messages; None as long as nobody has told it."""
        return self._asked_type if self._feed is None else self._feed.codec.type_name

    @property
    def wanted(self) -> bool:
        """Tell whether any id still asks for the topic."""
        return bool(self._wishes)

    def add(self, subscription_id: Id, wish: Wish, limit: int) -> bool:
        """Add a wish, or change the one of the same id; the most demanding ones hold.

        Returns
        -------
        bool
            False if there are as many as there may be already.
        """
        if subscription_id not in self._wishes and len(self._wishes) >= limit:
            return False
        self._wishes[subscription_id] = wish
        if self._timer is not None:
            # What waits for another wish may be due sooner for this one.
            self._timer.cancel()
            self._timer = self._loop.call_at(self._sent + self._throttle(), self._send_pending)
        return True

    def remove(self, subscription_id: Id) -> None:
        """Withdraw the wish of one id."""
        self._wishes.pop(subscription_id, None)

    async def open(self) -> None:
        """Begin to listen.

        Raises
        ------
        OperationError
            The type does not fit the topic, is unknown, or is missing.
        """
        self._feed = await self._feeds.join(self._topic, self._asked_type, self)

    def deliver(self, message: TopicMessage) -> None:
        """Send a message now, or when it is due."""
        if not self._wishes:
            return
        throttle = self._throttle()
        if throttle == 0.0:
            self._send_now(message)
            return
        self._pending = message
        if self._timer is None:
            # Also where it is due already: not before the last one that has come by now.
            due = max(self._sent + throttle, self._loop.time())
            self._timer = self._loop.call_at(due, self._send_pending)

    def close(self) -> None:
        """Stop listening."""
        self._wishes.clear()
        self._pending = None
        if self._timer is not None:
            self._timer.cancel()
        if self._feed is not None:
            self._feeds.leave(self._topic, self._feed, self)
            self._feed = None

    def _throttle(self) -> float:
        return min(wish.throttle for wish in self._wishes.values())

    def _send_now(self, message: TopicMessage) -> None:
        self._pending = None
        self._sent = self._loop.time()
        depth = min(wish.depth for wish in self._wishes.values())
        compression = max(
            (wish.compression for wish in self._wishes.values()), key=COMPRESSIONS.index
        )
        self._send(self._spelled, message.encoded(self._spelled, compression), depth)

    def _send_pending(self) -> None:
        self._timer = None
        if self._pending is not None and self._wishes:
            self._send_now(self._pending)
