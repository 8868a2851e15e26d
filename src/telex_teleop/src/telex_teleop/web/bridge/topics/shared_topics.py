"""Publishers and subscribers in ROS, one for a topic, which all clients share.

Each is opened for its first client, in the worker's thread because that blocks, and closed after
its last.
"""

from __future__ import annotations

import asyncio
import collections
import contextlib
import logging
import threading
from typing import (
    Callable,
    Deque,
    Dict,
    Generic,
    Hashable,
    Optional,
    Protocol,
    Set,
    Tuple,
    Type,
    TypeVar,
)

import genpy
from actionlib_msgs.msg import GoalID

from ...workers import OrderedWorker
from ..protocol.compression import TopicMessage
from ..protocol.operations import OperationError
from ..protocol.ros_messages import MessageCodec, codec_of, message_class
from ..ros import BridgePublisher, Ros
from .commands import commands_motion

LINGER = 1.0
"""Time (s) that a publisher outlives its last client: its last message must still get out."""

CANCEL_QUEUE = 1000
"""Cancellations of goals that are kept for a slow server, however few their client asks for: those
of all clients go by one publisher, and whoever leaves cancels all of his goals at once."""

CONNECTION_POLL = 0.01
"""Period (s) at which a new publisher is asked how many subscribers are connected."""

INBOX_DEPTH = 1000
"""Messages of a topic that may wait for the loop; the newest win."""

MAX_BACKLOG = 1000
"""Calls to ROS that may wait; only a faulty client makes more."""


class _Closable(Protocol):
    """A publisher or subscriber."""

    def close(self) -> None:
        """End it; may block."""


Key = TypeVar("Key", bound=Hashable)
Resource = TypeVar("Resource", bound=_Closable)


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


class _Shares(Generic[Key, Resource]):
    """Resources by key, counted on the loop's thread.

    Parameters
    ----------
    linger
        Time (s) that a resource outlives its last user.
    """

    def __init__(self, ros: Ros, worker: OrderedWorker, linger: float) -> None:
        self._ros = ros
        self._worker = worker
        self._linger = linger
        self._shares: Dict[Key, _Share[Resource]] = {}

    def __len__(self) -> int:
        return len(self._shares)

    async def _get(self, key: Key, make: Callable[[], Resource]) -> Resource:
        """Return the resource of a key, which must be given back once; may raise what `make` does.

        Raises
        ------
        OperationError
            Too many calls are waiting.
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
            self._give_back(key)
            raise

    def _in_use(self, key: Key) -> Optional[Resource]:
        """Return the resource of a key if it is open and somebody uses it."""
        share = self._shares.get(key)
        return share.resource if share is not None and share.users else None

    def _give_back(self, key: Key) -> None:
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


class SharedPublisher:
    """A publisher of a topic; `settled` when its subscribers are connected.

    Parameters
    ----------
    codec
        Reads the topic's messages.
    expected
        How many subscribers the master knew when it was made; what is published before those are
        connected is lost for them.
    """

    def __init__(self, publisher: BridgePublisher, codec: MessageCodec, expected: int) -> None:
        self.codec = codec
        self._publisher = publisher
        self._expected = expected
        self.settled = False

    async def settle(self, timeout: float) -> None:
        """Wait until the subscribers are connected, for `timeout` (s) at most."""
        loop = asyncio.get_running_loop()
        deadline = loop.time() + timeout
        while not self.settled and self._publisher.connections() < self._expected:
            if loop.time() >= deadline:
                break
            await asyncio.sleep(CONNECTION_POLL)
        self.settled = True

    def publish(self, message: genpy.Message) -> None:
        """Publish without blocking; raises OperationError if that cannot be done."""
        self._publisher.publish(message)

    def close(self) -> None:
        """End it; blocks."""
        self._publisher.unregister()


class Publishers(_Shares[Tuple[str, bool], SharedPublisher]):
    """All publishers of the bridge, by topic and whether they latch; on the loop's thread.

    Parameters
    ----------
    linger
        Time (s) that a publisher outlives its last client.
    """

    def __init__(self, ros: Ros, worker: OrderedWorker, linger: float = LINGER) -> None:
        super().__init__(ros, worker, linger)

    async def acquire(
        self, topic: str, type_name: Optional[str], *, latch: bool, queue_size: int
    ) -> SharedPublisher:
        """Return the publisher of a topic; each one got must be released.

        Raises
        ------
        OperationError
            The type does not fit the topic, is unknown, or is missing.
        """

        def advertise() -> SharedPublisher:
            found = _topic_class(self._ros, topic, type_name)
            # An old command must not reach a node that starts later.
            latched = latch and not commands_motion(found._type)
            size = max(queue_size, CANCEL_QUEUE) if found is GoalID else queue_size
            publisher = self._ros.advertise(topic, found, latch=latched, queue_size=size)
            expected = len(self._ros.subscribers(topic))
            return SharedPublisher(publisher, codec_of(found), expected)

        shared = await self._get((topic, latch), advertise)
        if type_name not in (None, shared.codec.type_name):
            self.release(topic, latch=latch)
            raise OperationError(f"{topic} has the type {shared.codec.type_name}, not {type_name}")
        return shared

    def settled(self, topic: str) -> Optional[SharedPublisher]:
        """Return a publisher of a topic whose subscribers are connected, if any client has one."""
        for latch in (True, False):
            shared = self._in_use((topic, latch))
            if shared is not None and shared.settled:
                return shared
        return None

    async def catch_up(self) -> None:
        """Wait until all that ROS has been asked for by now is done, subscriptions as well."""
        await self._worker.submit(lambda: None)

    def release(self, topic: str, *, latch: bool) -> None:
        """Give a publisher back; it ends a while after its last client."""
        self._give_back((topic, latch))


class Listener(Protocol):
    """A recipient of a subscriber's messages, on the loop's thread."""

    def deliver(self, message: TopicMessage) -> None:
        """Take a message."""


class SharedSubscriber:
    """A subscriber to a topic, whose messages go from rospy's threads to the clients that listen.

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
        """Add a listener; it first gets the last messages of latching publishers."""
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


class Subscribers(_Shares[str, SharedSubscriber]):
    """All subscribers of the bridge, by topic; on the loop's thread."""

    def __init__(self, ros: Ros, worker: OrderedWorker) -> None:
        super().__init__(ros, worker, 0.0)

    async def join(
        self, topic: str, type_name: Optional[str], listener: Listener
    ) -> SharedSubscriber:
        """Let somebody listen to a topic and return its subscriber; each join needs a leave.

        Raises
        ------
        OperationError
            The type does not fit the topic, is unknown, or is missing. No leave is due then.
        """
        loop = asyncio.get_running_loop()

        def subscribe() -> SharedSubscriber:
            found = _topic_class(self._ros, topic, type_name)
            subscriber = SharedSubscriber(codec_of(found), loop)
            subscriber.unsubscribe = self._ros.subscribe(topic, found, subscriber.receive)
            return subscriber

        shared = await self._get(topic, subscribe)
        if type_name not in (None, shared.codec.type_name):
            self._give_back(topic)
            raise OperationError(f"{topic} has the type {shared.codec.type_name}, not {type_name}")
        shared.add(listener)
        return shared

    def leave(self, topic: str, subscriber: SharedSubscriber, listener: Listener) -> None:
        """Let somebody go; the subscription ends with the last one."""
        subscriber.remove(listener)
        self._give_back(topic)


def _topic_class(ros: Ros, topic: str, type_name: Optional[str]) -> Type[genpy.Message]:
    """Return the message class of a topic, of the type that the client gave, if any; blocks.

    Raises
    ------
    OperationError
        The client's type is not the topic's, or nobody knows the topic's type.
    """
    known = ros.topic_types().get(topic)
    if known is None or known == "*":  # "*": somebody has subscribed without knowing the type
        if type_name is None:
            raise OperationError(f"nobody has published {topic} yet, so its type must be given")
        return message_class(type_name)
    if type_name is None:
        return message_class(known)
    # The master remembers types of topics that nobody uses any more; those bind nobody.
    if type_name != known and topic in ros.topics():
        raise OperationError(f"{topic} has the type {known}, not {type_name}")
    return message_class(type_name)
