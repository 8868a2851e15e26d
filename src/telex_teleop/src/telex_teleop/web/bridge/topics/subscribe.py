"""The operations subscribe and unsubscribe of one client."""

from __future__ import annotations

import asyncio
import dataclasses
import functools
import math
from typing import Callable, Dict, List, Optional

from ...server_config import RosbridgeConfig
from ..clients.client import Client
from ..protocol.compression import COMPRESSIONS, Encoded, TopicMessage
from ..protocol.operations import Id, Operation, OperationError
from ..ros import Ros
from .shared_topics import SharedSubscriber, Subscribers

Send = Callable[[str, Encoded, int], None]
"""Queues a message of a topic, of which at most so many may wait."""


@dataclasses.dataclass(frozen=True)
class Wish:
    """One subscribe operation: least time between messages (s), how many may wait, and how."""

    throttle: float
    depth: int
    compression: str


class ClientSubscription:
    """A topic that one client hears, no more often than it asked for.

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

    Attributes
    ----------
    topic
        Global name of the topic.
    opening
        The task that opens it.
    """

    def __init__(
        self,
        topic: str,
        type_name: Optional[str],
        spelled: str,
        *,
        subscribers: Subscribers,
        send: Send,
    ) -> None:
        self.opening: Optional[asyncio.Task[None]] = None
        self.topic = topic
        self._asked_type = type_name
        self._spelled = spelled
        self._subscribers = subscribers
        self._send = send
        self._subscriber: Optional[SharedSubscriber] = None
        self._loop = asyncio.get_running_loop()
        self._wishes: Dict[Id, Wish] = {}
        self._sent = -math.inf
        self._pending: Optional[TopicMessage] = None
        self._timer: Optional[asyncio.TimerHandle] = None

    @property
    def type_name(self) -> Optional[str]:
        """Type of the messages; None as long as nobody has told it."""
        return self._asked_type if self._subscriber is None else self._subscriber.codec.type_name

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
        self._subscriber = await self._subscribers.join(self.topic, self._asked_type, self)

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
        """Stop listening, or trying to."""
        if self.opening is not None:
            self.opening.cancel()
        self._wishes.clear()
        self._pending = None
        if self._timer is not None:
            self._timer.cancel()
        if self._subscriber is not None:
            self._subscribers.leave(self.topic, self._subscriber, self)
            self._subscriber = None

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


class Subscriptions:
    """All topics that one client hears, by the names that it gives them."""

    def __init__(
        self, client: Client, *, config: RosbridgeConfig, ros: Ros, subscribers: Subscribers
    ) -> None:
        self._client = client
        self._config = config
        self._ros = ros
        self._subscribers = subscribers
        self._subscriptions: Dict[str, ClientSubscription] = {}

    def subscribe(self, operation: Operation) -> None:
        """Begin to listen to a topic, or add a wish to what is heard already."""
        spelled = operation.text("topic")
        topic = self._ros.resolve(spelled)
        type_name = operation.optional_text("type")
        compression = operation.optional_text("compression") or COMPRESSIONS[0]
        if compression not in COMPRESSIONS:
            raise OperationError(
                f"there is no compression {compression[:80]!r}; known are {', '.join(COMPRESSIONS)}"
            )
        wish = Wish(
            throttle=operation.count("throttle_rate", 0) / 1000.0,
            depth=self._config.depth(operation.count("queue_length", 0)),
            compression=compression,
        )
        subscription = self._subscriptions.get(spelled)
        if subscription is None:
            subscription = self._begin(topic, spelled, type_name, operation)
        known = subscription.type_name
        if type_name is not None and known not in (None, type_name):
            raise OperationError(f"this client hears {topic} as {known}, not {type_name[:80]}")
        if not subscription.add(operation.id, wish, self._config.max_subscriptions):
            limit = self._config.max_subscriptions
            raise OperationError(f"a client may subscribe to a topic {limit} times at most")

    def unsubscribe(self, operation: Operation) -> None:
        """Withdraw the wish of an id, or all wishes."""
        spelled = operation.text("topic")
        subscription = self._subscriptions.get(spelled)
        if subscription is None:
            raise OperationError(f"{spelled[:200]} has not been subscribed to")
        subscription.remove(operation.id)
        if operation.id is None or not subscription.wanted:
            self._subscriptions.pop(spelled).close()

    def review(self) -> List[str]:
        """End what the client may not hear any more; returns a sentence for each."""
        ended = [
            (spelled, subscription.topic)
            for spelled, subscription in self._subscriptions.items()
            if not self._client.access.allows("subscribe", subscription.topic)
        ]
        for spelled, _ in ended:
            self._subscriptions.pop(spelled).close()
        return [
            f"unsubscribed: {self._client.access.refusal('subscribe', topic)}" for _, topic in ended
        ]

    def close(self) -> None:
        """End all subscriptions."""
        while self._subscriptions:
            self._subscriptions.popitem()[1].close()

    def _begin(
        self, topic: str, spelled: str, type_name: Optional[str], operation: Operation
    ) -> ClientSubscription:
        self._client.access.check("subscribe", topic)
        limit = self._config.max_subscriptions
        if len(self._subscriptions) >= limit:
            raise OperationError(f"a client may subscribe to {limit} topics at most")
        subscription = ClientSubscription(
            topic,
            type_name,
            spelled,
            subscribers=self._subscribers,
            send=self._client.send_message,
        )
        forget = functools.partial(self._subscriptions.pop, spelled, None)
        subscription.opening = self._client.open(subscription.open, operation, forget)
        self._subscriptions[spelled] = subscription
        return subscription
