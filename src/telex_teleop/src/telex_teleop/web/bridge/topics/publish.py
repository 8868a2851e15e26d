"""The operations advertise, publish and unadvertise of one client."""

from __future__ import annotations

import asyncio
import collections
import functools
from typing import Callable, Deque, Dict, List, Optional, Set

import genpy
from std_msgs.msg import Bool

from ...server_config import RosbridgeConfig
from ..clients.client import Client
from ..protocol.operations import Id, Operation, OperationError
from ..protocol.ros_messages import FieldError, codec_of, message_class
from ..ros import Ros
from .commands import (
    CommandGate,
    CommandOverdueError,
    CommandRefusedError,
    CommandUncertainError,
    is_goal_type,
    kind_of,
    stop_for,
)
from .goals import AllGoals, ClientGoals
from .shared_topics import Publishers, SharedPublisher
from .stuck_key import StuckKey

DEFAULT_QUEUE_SIZE = 100
"""Messages that a publisher keeps for a slow subscriber, as in rosbridge."""

MAX_HELD = 20
"""Messages that wait while a new publisher finds its subscribers; the newest win."""

_NAMES_CLIENT = ("telex_msgs/FlipperPresetHold",)
"""Types with a field `client`: operators who share the bridge must not pass for one."""


class Publication:
    """A topic that one client publishes.

    Until the subscribers of a new publisher are connected its messages wait; without that the
    first ones would be lost. Goals of an action wait until its answers can come back as well.

    Parameters
    ----------
    topic
        Global name.
    type_name
        What the client says its type is; None if it does not.
    latch
        Whether the last message is kept for subscribers to come.
    queue_size
        Messages that are kept for a slow subscriber.

    Attributes
    ----------
    ids
        Of the operations that have advertised it and not withdrawn that.
    opening
        The task that opens it.
    """

    def __init__(
        self,
        topic: str,
        type_name: Optional[str],
        *,
        latch: bool,
        queue_size: int,
        client: Client,
        gate: CommandGate,
        publishers: Publishers,
        goals: AllGoals,
        stuck_key: StuckKey,
        ros: Ros,
    ) -> None:
        self.topic = topic
        self.ids: Set[Id] = set()
        self.opening: Optional[asyncio.Task[None]] = None
        self._latch = latch
        self._queue_size = queue_size
        self._client = client
        self._gate = gate
        self._publishers = publishers
        self._all_goals = goals
        self._stuck_key = stuck_key
        self._ros = ros
        self._publisher: Optional[SharedPublisher] = None
        self._asked_type = type_name
        self._ready = False
        self._last: Optional[SharedPublisher] = None
        self._held: Deque[Operation] = collections.deque(maxlen=MAX_HELD)
        self._holds = asyncio.Event()
        self._stop: Optional[genpy.Message] = None
        self._goals: Optional[ClientGoals] = None

    @property
    def type_name(self) -> Optional[str]:
        """Type of its messages; None as long as nobody has told it."""
        return self._asked_type if self._publisher is None else self._publisher.codec.type_name

    async def open(self, connect_timeout: float, action_timeout: float) -> None:
        """Get the publisher, wait for its subscribers, send what has waited.

        For goals of an action this goes on until it is cancelled: each goal may have to wait.

        Parameters
        ----------
        connect_timeout
            Longest time (s) that messages wait for subscribers.
        action_timeout
            Longest time (s) that a goal waits for its action's servers.

        Raises
        ------
        OperationError
            The topic cannot be published with this type.
        """
        self._publisher = await self._publishers.acquire(
            self.topic, self._asked_type, latch=self._latch, queue_size=self._queue_size
        )
        type_name = self._publisher.codec.type_name
        if ClientGoals.go_to(self.topic) and is_goal_type(type_name):
            self._goals = ClientGoals(
                self.topic, type_name, self._client.member.id, self._all_goals
            )
            await self._goals.open()
            await self._send_goals(self._publisher, self._goals, action_timeout)
        await self._publisher.settle(connect_timeout)
        self._ready = True
        while self._held:
            self._send(self._publisher, self._held.popleft())

    async def _send_goals(
        self, publisher: SharedPublisher, goals: ClientGoals, timeout: float
    ) -> None:
        while True:
            await self._holds.wait()
            self._holds.clear()
            if not await goals.connect(timeout):
                sentence = f"servers of {self.topic} are not connected within {timeout:g} s"
                self._report(f"publish: {sentence}; answers may be lost", None, "warning")
            while self._held:
                self._send(publisher, self._held.popleft())

    def publish(self, operation: Operation) -> None:
        """Publish the message of an operation, now or as soon as that is possible."""
        publisher = self._publisher if self._ready else self._settled_by_others()
        if publisher is None:
            if len(self._held) == MAX_HELD and ClientGoals.go_to(self.topic):
                sentence = f"dropped; {MAX_HELD} newer goals wait for the action's servers"
                self._report(f"publish to {self.topic}: {sentence}", self._held[0].id, "error")
            self._held.append(operation)
            self._holds.set()
        else:
            self._send(publisher, operation)

    def _settled_by_others(self) -> Optional[SharedPublisher]:
        """Return a publisher that others use already, so that an e-stop need not wait."""
        settled = self._publishers.settled(self.topic)
        if settled is None or self._held or is_goal_type(settled.codec.type_name):
            return None
        return settled

    def _send(self, publisher: SharedPublisher, operation: Operation) -> None:
        topic, client = self.topic, self._client.member.id
        try:
            value = {} if operation.get("msg") is None else operation.get("msg")
            message = publisher.codec.from_json(value, self._ros.now)
            self._gate.check_numbers("publish", topic, value)
            if message._type in _NAMES_CLIENT:
                message.client = client
            age = None if operation.sent is None else operation.received - operation.sent
            # A goal is no less wanted for having waited for its server.
            waited = 0.0 if self._goals is not None else self._gate.clock() - operation.received
            if not self._gate.admit_message(topic, message, age, waited, operation.held):
                return
            self._all_goals.check_cancel(topic, message, client)
            if self._goals is not None:
                self._goals.note(message)
            self._last = publisher
            if self._stuck_key.swallows(self, message):
                return
            publisher.publish(message)
        except CommandUncertainError as error:
            # Not in the words of a refusal, on which clients let go of what is held.
            self._report(str(error), operation.id, "warning")
        except CommandOverdueError as error:
            self._report(f"publish to {topic}: {error}", operation.id, "info")
        except CommandRefusedError as error:
            self._report(f"publish to {topic}: {error}", operation.id, "warning")
        except (FieldError, OperationError) as error:
            self._report(f"publish to {topic}: {error}", operation.id, "error")
        else:
            self._stop = stop_for(message)

    def stop(self) -> None:
        """End the motion that the client commands on this topic, and forget what waits."""
        self._held.clear()
        self._stuck_key.leave(self)
        self.end_motion()
        if self._goals is not None:
            self._finish(self._goals.cancel)

    def end_motion(self) -> None:
        """Publish the stop of what was commanded last, if that moves anything."""
        stop, self._stop = self._stop, None
        if stop is not None and self._last is not None:
            self._finish(functools.partial(self._last.publish, stop))

    def repeat(self, message: genpy.Message) -> None:
        """Publish a message once more, as if it came now."""
        if hasattr(message, "header"):
            message.header.stamp = self._ros.now()
        if self._last is not None:
            self._last.publish(message)

    def _finish(self, publish: Callable[[], None]) -> None:
        try:
            publish()
        except OperationError as error:
            self._report(f"stop on {self.topic}: {error}", None, "error")

    def _report(self, sentence: str, operation_id: Id, level: str) -> None:
        self._client.report(sentence, operation_id, level)

    def close(self) -> None:
        """End, open or not: stop what the client drove, and give the publishers back."""
        if self.opening is not None:
            self.opening.cancel()
        self.stop()
        if self._goals is not None:
            self._goals.close()
        if self._publisher is not None:
            self._publishers.release(self.topic, latch=self._latch)
        self._publisher = self._goals = self._last = None


class Publications:
    """All topics that one client publishes."""

    def __init__(
        self,
        client: Client,
        gate: CommandGate,
        *,
        config: RosbridgeConfig,
        ros: Ros,
        publishers: Publishers,
        goals: AllGoals,
        stuck_key: StuckKey,
    ) -> None:
        self._client = client
        self._gate = gate
        self._config = config
        self._ros = ros
        self._publishers = publishers
        self._goals = goals
        self._stuck_key = stuck_key
        self._publications: Dict[str, Publication] = {}

    def advertise(self, operation: Operation) -> None:
        """Begin to publish a topic."""
        topic = self._ros.resolve(operation.text("topic"))
        type_name = operation.text("type")
        publication = self._publications.get(topic)
        if publication is None:
            publication = self._begin(topic, type_name, operation)
        known = publication.type_name
        if known not in (None, type_name):
            raise OperationError(f"this client publishes {topic} as {known}, not {type_name[:80]}")
        limit = self._config.max_subscriptions
        if operation.id not in publication.ids and len(publication.ids) >= limit:
            raise OperationError(f"a client may advertise a topic {limit} times at most")
        publication.ids.add(operation.id)

    def publish(self, operation: Operation) -> None:
        """Publish a message; begin with the topic if the client has not."""
        topic = self._ros.resolve(operation.text("topic"))
        publication = self._publications.get(topic)
        if publication is None:
            publication = self._begin(topic, operation.optional_text("type"), operation)
        publication.publish(operation)

    def moves(self, operation: Operation) -> bool:
        """Tell whether an operation `publish` holds a command of a stream that asks for motion.

        Of such the next one says the same, so one may get lost; whatever else is sent must arrive.
        """
        try:
            topic = self._ros.resolve(operation.text("topic"))
            publication = self._publications.get(topic)
            type_name = None if publication is None else publication.type_name
            if type_name is None or is_goal_type(type_name) or not self.commands(operation):
                return False
            codec = codec_of(message_class(type_name))
            message = codec.from_json(operation.get("msg") or {}, self._ros.now)
        except (FieldError, OperationError):
            return False  # which the client is told when it has arrived
        kind = kind_of(message)
        return kind is not None and kind.moves(message)

    def commands(self, operation: Operation) -> bool:
        """Tell whether an operation `publish` commands the robot, the e-stop apart."""
        topic = self._ros.resolve(operation.text("topic"))
        access = self._client.access
        return topic != access.e_stop_topic and access.is_command("publish", topic)

    def releases_e_stop(self, operation: Operation) -> bool:
        """Tell whether an operation `publish` releases the emergency stop."""
        try:
            if self._ros.resolve(operation.text("topic")) != self._client.access.e_stop_topic:
                return False
            message = codec_of(Bool).from_json(operation.get("msg") or {}, self._ros.now)
        except (FieldError, OperationError):
            return False  # which the client is told when it has arrived
        return not message.data

    def unadvertise(self, operation: Operation) -> None:
        """Publish a topic no more; what the client drove by it stops."""
        topic = self._ros.resolve(operation.text("topic"))
        publication = self._publications.get(topic)
        if publication is None:
            raise OperationError(f"{topic} has not been advertised")
        publication.ids.discard(operation.id)
        if operation.id is None or not publication.ids:
            self._publications.pop(topic).close()

    def stop(self) -> None:
        """Stop all that the client drives."""
        for publication in self._publications.values():
            publication.stop()

    def review(self) -> List[str]:
        """End what the client may not publish any more; returns a sentence for each."""
        ended = [
            topic
            for topic in self._publications
            if not self._client.access.allows("publish", topic)
        ]
        for topic in ended:
            self._publications.pop(topic).close()
        return [f"unadvertised: {self._client.access.refusal('publish', topic)}" for topic in ended]

    def close(self) -> None:
        """End: stop what the client drove, give back what it used."""
        while self._publications:
            self._publications.popitem()[1].close()

    def _begin(self, topic: str, type_name: Optional[str], operation: Operation) -> Publication:
        self._client.access.check("publish", topic)
        limit = self._config.max_subscriptions
        if len(self._publications) >= limit:
            raise OperationError(f"a client may publish {limit} topics at most")
        publication = Publication(
            topic,
            type_name,
            latch=operation.flag("latch"),
            queue_size=self._config.depth(operation.count("queue_size", DEFAULT_QUEUE_SIZE)),
            client=self._client,
            gate=self._gate,
            publishers=self._publishers,
            goals=self._goals,
            stuck_key=self._stuck_key,
            ros=self._ros,
        )

        def forget() -> None:
            self._publications.pop(topic, None)
            publication.close()

        opening = functools.partial(
            publication.open, self._config.connect_timeout, self._config.action_timeout
        )
        publication.opening = self._client.open(opening, operation, forget)
        self._publications[topic] = publication
        return publication
