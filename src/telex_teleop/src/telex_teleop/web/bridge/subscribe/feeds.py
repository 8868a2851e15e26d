"""Topics that clients listen to: one ROS subscription each, each message encoded once for all."""

from __future__ import annotations

import asyncio
import collections
import contextlib
import json
import logging
import threading
from typing import Callable, Deque, Dict, Optional, Protocol, Set, Tuple

import genpy

from ...workers import OrderedWorker
from ..protocol.compression import ENCODERS, MAX_PNG, PLAIN, Encoded, to_png
from ..protocol.message_json import MessageCodec, codec_of
from ..protocol.message_types import topic_class
from ..protocol.operations import OperationError
from ..ros import Ros
from ..sharing import SharedResources

INBOX_DEPTH = 1000
"""Messages of a topic that may wait for the loop; the newest win."""


class TopicMessage:
    """One message of a topic, encoded when the first client needs it in some way."""

    def __init__(self, codec: MessageCodec, message: genpy.Message) -> None:
        self.message = message
        self._codec = codec
        self._body: Optional[str] = None
        self._encoded: Dict[Tuple[str, str], Encoded] = {}

    def encoded(self, topic: str, compression: str = PLAIN) -> Encoded:
        """Return the publish operation for a client that spells the topic this way."""
        key = (topic, compression)
        encoded = self._encoded.get(key)
        if encoded is None:
            encode = ENCODERS.get(compression)
            encoded = encode(topic, self.message) if encode else self._text(topic, compression)
            self._encoded[key] = encoded
        return encoded

    def _text(self, topic: str, compression: str) -> str:
        if self._body is None:
            self._body = json.dumps(self._codec.to_json(self.message), separators=(",", ":"))
        text = f'{{"op":"publish","topic":{json.dumps(topic)},"msg":{self._body}}}'
        return text if compression == PLAIN or len(text) > MAX_PNG else to_png(text)


class Listener(Protocol):
    """Somebody who gets the messages of a feed, on the loop's thread."""

    def deliver(self, message: TopicMessage) -> None:
        """Take a message."""


class TopicFeed:
    """The messages of one topic on their way from rospy's threads to the clients.

    Parameters
    ----------
    codec
        Encodes the topic's messages.
    loop
        The loop on which listeners get them.
    """

    def __init__(self, codec: MessageCodec, loop: asyncio.AbstractEventLoop) -> None:
        self.codec = codec
        self.unsubscribe: Optional[Callable[[], None]] = None
        self._loop = loop
        self._listeners: Set[Listener] = set()
        self._latched: Dict[str, TopicMessage] = {}
        self._lock = threading.Lock()
        self._inbox: Deque[Tuple[TopicMessage, Optional[str]]] = collections.deque(
            maxlen=INBOX_DEPTH
        )
        self._will_drain = False

    def receive(self, message: genpy.Message, latching_publisher: Optional[str]) -> None:
        """Take a message from ROS; rospy's threads call this."""
        with self._lock:
            self._inbox.append((TopicMessage(self.codec, message), latching_publisher))
            if self._will_drain:
                return
            self._will_drain = True
        with contextlib.suppress(RuntimeError):  # the loop may have ended
            self._loop.call_soon_threadsafe(self._drain)

    def _drain(self) -> None:
        """Hand what has come to the listeners."""
        with self._lock:
            waiting, self._will_drain = list(self._inbox), False
            self._inbox.clear()
        for message, latching_publisher in waiting:
            if latching_publisher is not None:
                self._latched[latching_publisher] = message
            for listener in tuple(self._listeners):
                try:
                    listener.deliver(message)
                except Exception:  # the others, and later messages, come all the same
                    logging.getLogger(__name__).exception("a message could not be encoded")

    def add(self, listener: Listener) -> None:
        """Let somebody listen, beginning with what latching publishers said last."""
        self._listeners.add(listener)
        for message in self._latched.values():
            listener.deliver(message)

    def remove(self, listener: Listener) -> None:
        """Let somebody go."""
        self._listeners.discard(listener)

    def close(self) -> None:
        """End the subscription; blocks."""
        if self.unsubscribe is not None:
            self.unsubscribe()


class FeedPool:
    """All feeds of the bridge, on the loop's thread.

    Parameters
    ----------
    ros
        Where to subscribe.
    worker
        Thread for the calls that block.
    """

    def __init__(self, ros: Ros, worker: OrderedWorker) -> None:
        self._ros = ros
        self._shared: SharedResources[str, TopicFeed] = SharedResources(worker, 0.0)

    def __len__(self) -> int:
        return len(self._shared)

    async def join(self, topic: str, type_name: Optional[str], listener: Listener) -> TopicFeed:
        """Let somebody listen to a topic and return its feed; each join needs a leave.

        Raises
        ------
        OperationError
            The type does not fit the topic, is unknown, or is missing. No leave is due then.
        """
        loop = asyncio.get_running_loop()

        def subscribe() -> TopicFeed:
            found = topic_class(self._ros, topic, type_name)
            feed = TopicFeed(codec_of(found), loop)
            feed.unsubscribe = self._ros.subscribe(topic, found, feed.receive)
            return feed

        feed = await self._shared.acquire(topic, subscribe)
        if type_name not in (None, feed.codec.type_name):
            self._shared.release(topic)
            raise OperationError(f"{topic} has the type {feed.codec.type_name}, not {type_name}")
        feed.add(listener)
        return feed

    def leave(self, topic: str, feed: TopicFeed, listener: Listener) -> None:
        """Let somebody go; the subscription ends with the last one."""
        feed.remove(listener)
        self._shared.release(topic)
