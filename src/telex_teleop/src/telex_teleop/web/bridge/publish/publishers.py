"""Publishers, shared by all clients that publish a topic."""

from __future__ import annotations

import asyncio
from typing import Optional, Tuple

import genpy
from actionlib_msgs.msg import GoalID

from ...workers import OrderedWorker
from ..protocol.message_json import MessageCodec, codec_of
from ..protocol.message_types import topic_class
from ..protocol.operations import OperationError
from ..ros import Publisher, Ros
from ..sharing import SharedResources
from .stop import commands_motion

LINGER = 1.0
"""Time (s) that a publisher outlives its last client: its last message must still get out."""

CANCEL_QUEUE = 1000
"""Cancellations of goals that are kept for a slow server, however few their client asks for: those
of all clients go by one publisher, and whoever leaves cancels all of his goals at once."""

CONNECTION_POLL = 0.01
"""Period (s) at which a new publisher is asked how many subscribers are connected."""


class SharedPublisher:
    """A publisher of a topic; `settled` when its subscribers are connected.

    Parameters
    ----------
    publisher
        Of ROS.
    codec
        Reads the topic's messages.
    expected
        How many subscribers the master knew when it was made; what is published before those are
        connected is lost for them.
    """

    def __init__(self, publisher: Publisher, codec: MessageCodec, expected: int) -> None:
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


class PublisherPool:
    """All publishers of the bridge, on the loop's thread.

    Parameters
    ----------
    ros
        Where to publish.
    worker
        Thread for the calls that block.
    linger
        Time (s) that a publisher outlives its last client.
    """

    def __init__(self, ros: Ros, worker: OrderedWorker, linger: float = LINGER) -> None:
        self._ros = ros
        self._worker = worker
        self._shared: SharedResources[Tuple[str, bool], SharedPublisher] = SharedResources(
            worker, linger
        )

    def __len__(self) -> int:
        return len(self._shared)

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
            found = topic_class(self._ros, topic, type_name)
            # An old command must not reach a node that starts later.
            latched = latch and not commands_motion(found._type)
            size = max(queue_size, CANCEL_QUEUE) if found is GoalID else queue_size
            publisher = self._ros.advertise(topic, found, latch=latched, queue_size=size)
            expected = len(self._ros.subscribers(topic))
            return SharedPublisher(publisher, codec_of(found), expected)

        shared = await self._shared.acquire((topic, latch), advertise)
        if type_name not in (None, shared.codec.type_name):
            self.release(topic, latch=latch)
            raise OperationError(f"{topic} has the type {shared.codec.type_name}, not {type_name}")
        return shared

    async def catch_up(self) -> None:
        """Wait until all that ROS has been asked for by now is done, subscriptions as well."""
        await self._worker.submit(lambda: None)

    def settled(self, topic: str) -> Optional[SharedPublisher]:
        """Return a publisher of a topic whose subscribers are connected, if any client has one."""
        for latch in (True, False):
            shared = self._shared.in_use((topic, latch))
            if shared is not None and shared.settled:
                return shared
        return None

    def release(self, topic: str, *, latch: bool) -> None:
        """Give a publisher back; it ends a while after its last client."""
        self._shared.release((topic, latch))
