"""Subscription operations of one client: subscribe, unsubscribe."""

from __future__ import annotations

import functools
from typing import Dict, Optional

from ...server_config import RosbridgeConfig
from ..control.access import Access
from ..link import Held, Link
from ..protocol.compression import COMPRESSIONS
from ..protocol.operations import Operation, OperationError
from ..ros import Ros
from .feeds import FeedPool
from .subscriptions import Send, Subscription, Wish


class Subscribing:
    """The topics that one client listens to, by the names that it gives them.

    Parameters
    ----------
    config
        Limits.
    ros
        Names.
    feeds
        Where messages come from.
    access
        Which topics are open to clients.
    link
        The client.
    send
        Queues a message for the client.
    """

    def __init__(
        self,
        config: RosbridgeConfig,
        ros: Ros,
        *,
        feeds: FeedPool,
        access: Access,
        link: Link,
        send: Send,
    ) -> None:
        self._config = config
        self._ros = ros
        self._feeds = feeds
        self._access = access
        self._link = link
        self._send = send
        self._subscriptions: Dict[str, Held[Subscription]] = {}

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
        held = self._subscriptions.get(spelled)
        if held is None:
            held = self._begin(topic, spelled, type_name, operation)
        known = held.thing.type_name
        if type_name is not None and known not in (None, type_name):
            raise OperationError(f"this client hears {topic} as {known}, not {type_name[:80]}")
        if not held.thing.add(operation.id, wish, self._config.max_subscriptions):
            limit = self._config.max_subscriptions
            raise OperationError(f"a client may subscribe to a topic {limit} times at most")

    def unsubscribe(self, operation: Operation) -> None:
        """Withdraw the wish of an id, or all wishes."""
        spelled = operation.text("topic")
        held = self._subscriptions.get(spelled)
        if held is None:
            raise OperationError(f"{spelled[:200]} has not been subscribed to")
        held.thing.remove(operation.id)
        if operation.id is None or not held.thing.wanted:
            self._subscriptions.pop(spelled).close()

    def close(self) -> None:
        """End all subscriptions."""
        while self._subscriptions:
            self._subscriptions.popitem()[1].close()

    def _begin(
        self, topic: str, spelled: str, type_name: Optional[str], operation: Operation
    ) -> Held[Subscription]:
        self._access.check("subscribe", topic)
        limit = self._config.max_subscriptions
        if len(self._subscriptions) >= limit:
            raise OperationError(f"a client may subscribe to {limit} topics at most")
        subscription = Subscription(topic, type_name, spelled, feeds=self._feeds, send=self._send)
        forget = functools.partial(self._subscriptions.pop, spelled, None)
        task = self._link.start(self._link.open(subscription.open, operation, forget))
        held = self._subscriptions[spelled] = Held(subscription, task)
        return held
