"""Publishing operations of one client: advertise, publish, unadvertise."""

from __future__ import annotations

import asyncio
import functools
import math
from typing import Dict, Optional

from ...server_config import RosbridgeConfig
from ..control.access import Access
from ..link import Held, Link
from ..protocol.operations import Operation, OperationError
from ..ros import Ros
from ..service.goals import GoalDesk
from .command_age import CommandAge
from .command_gate import CommandGate
from .publications import Outgoing, Publication
from .publishers import PublisherPool

DEFAULT_QUEUE_SIZE = 100
"""Messages that a publisher keeps for a slow subscriber, as in rosbridge."""


class Publishing:
    """The topics that one client publishes.

    Parameters
    ----------
    name
        Tells the client from the others of the bridge.
    config
        Limits.
    ros
        Names and time.
    pool
        Where publishers come from.
    desk
        Knows the goals of all clients.
    access
        Which topics are open to clients.
    gate
        Which commands are obeyed.
    age
        How old the client's messages are.
    link
        The client.
    """

    def __init__(
        self,
        name: str,
        config: RosbridgeConfig,
        ros: Ros,
        *,
        pool: PublisherPool,
        desk: GoalDesk,
        access: Access,
        gate: CommandGate,
        age: CommandAge,
        link: Link,
    ) -> None:
        self._name = name
        self._config = config
        self._ros = ros
        self._pool = pool
        self._desk = desk
        self._access = access
        self._gate = gate
        self._link = link
        self._clock = asyncio.get_running_loop().time
        self._age = age
        self._publications: Dict[str, Held[Publication]] = {}

    def note_time(self, operation: Operation) -> Optional[float]:
        """Return when an operation was sent, on this machine's clock (s), if it tells that.

        Raises
        ------
        OperationError
            What it tells is no time.
        """
        sent = operation.get("sent")
        if sent is None:
            return None
        number = isinstance(sent, (int, float)) and not isinstance(sent, bool)
        if not number or not math.isfinite(sent):
            raise OperationError("'sent' must be a number: milliseconds on the client's clock")
        received = self._clock()
        known = self._age.slower
        age = self._age.of(sent / 1000.0, received)
        if self._age.slower > known:
            self._link.report(
                f"the line has become slower, by {self._age.slower:.2f} s; commands count again",
                level="warning",
            )
        return received - age

    def advertise(self, operation: Operation) -> None:
        """Begin to publish a topic."""
        topic = self._ros.resolve(operation.text("topic"))
        type_name = operation.text("type")
        held = self._publications.get(topic)
        if held is None:
            held = self._begin(topic, type_name, operation)
        known = held.thing.type_name
        if known not in (None, type_name):
            raise OperationError(f"this client publishes {topic} as {known}, not {type_name[:80]}")
        limit = self._config.max_subscriptions
        if operation.id not in held.thing.ids and len(held.thing.ids) >= limit:
            raise OperationError(f"a client may advertise a topic {limit} times at most")
        held.thing.ids.add(operation.id)

    def publish(self, operation: Operation, sent: Optional[float]) -> None:
        """Publish a message; begin with the topic if the client has not."""
        topic = self._ros.resolve(operation.text("topic"))
        held = self._publications.get(topic)
        if held is None:
            held = self._begin(topic, operation.optional_text("type"), operation)
        outgoing = Outgoing(operation.get("msg"), operation.id, self._clock(), sent)
        held.thing.publish(outgoing)

    def unadvertise(self, operation: Operation) -> None:
        """Publish a topic no more; what the client drove by it stops."""
        topic = self._ros.resolve(operation.text("topic"))
        held = self._publications.get(topic)
        if held is None:
            raise OperationError(f"{topic} has not been advertised")
        held.thing.ids.discard(operation.id)
        if operation.id is None or not held.thing.ids:
            self._publications.pop(topic).close()

    def stop(self) -> None:
        """Stop all that the client drives."""
        for held in self._publications.values():
            held.thing.stop()

    def close(self) -> None:
        """End: stop what the client drove, give back what it used."""
        while self._publications:
            self._publications.popitem()[1].close()

    def _begin(
        self, topic: str, type_name: Optional[str], operation: Operation
    ) -> Held[Publication]:
        self._access.check("publish", topic)
        limit = self._config.max_subscriptions
        if len(self._publications) >= limit:
            raise OperationError(f"a client may publish {limit} topics at most")
        publication = Publication(
            topic,
            type_name,
            latch=operation.flag("latch"),
            queue_size=self._config.depth(operation.count("queue_size", DEFAULT_QUEUE_SIZE)),
            pool=self._pool,
            desk=self._desk,
            ros=self._ros,
            client=self._name,
            gate=self._gate,
            clock=self._clock,
            report=self._link.report,
        )

        def forget() -> None:
            self._publications.pop(topic, None)
            publication.close()

        opening = functools.partial(
            publication.open, self._config.connect_timeout, self._config.action_timeout
        )
        task = self._link.start(self._link.open(opening, operation, forget))
        held = self._publications[topic] = Held(publication, task)
        return held
