"""One client's publication on one topic."""

from __future__ import annotations

import asyncio
import collections
import dataclasses
import functools
from typing import Any, Callable, Deque, Optional, Set

import genpy

from ..protocol.message_json import FieldError
from ..protocol.operations import Id, OperationError
from ..ros import Ros
from ..service.goals import GoalDesk, Goals
from .command_gate import (
    CommandGate,
    CommandOverdueError,
    CommandRefusedError,
    CommandUncertainError,
)
from .publishers import PublisherPool, SharedPublisher
from .stop import is_goal_type, stop_for

MAX_HELD = 20
"""Messages that wait while a new publisher finds its subscribers; the newest win."""

_NAMES_CLIENT = ("telex_msgs/FlipperPresetHold",)
"""Types with a field `client`: operators who share the bridge must not pass for one."""

Report = Callable[[str, Id, str], None]
"""Tells the client what went wrong with the operation of an id, and how grave that is."""


@dataclasses.dataclass(frozen=True)
class Outgoing:
    """A message that a client wants to publish.

    Attributes
    ----------
    value
        As JSON gave it.
    id
        Of the operation.
    received
        When it came, on this machine's monotonic clock (s).
    sent
        When it was sent, on the same clock; None if the client does not tell.
    """

    value: Any
    id: Id
    received: float
    sent: Optional[float] = None


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
    pool
        Where publishers come from.
    desk
        Knows the goals of all clients.
    ros
        For the present time.
    client
        Name of the client, in messages that have a place for it.
    gate
        Decides which messages are obeyed.
    clock
        Monotonic time (s).
    report
        Tells the client what went wrong.
    """

    def __init__(
        self,
        topic: str,
        type_name: Optional[str],
        *,
        latch: bool,
        queue_size: int,
        pool: PublisherPool,
        desk: GoalDesk,
        ros: Ros,
        client: str,
        gate: CommandGate,
        clock: Callable[[], float],
        report: Report,
    ) -> None:
        self.topic = topic
        self.ids: Set[Id] = set()
        self._latch = latch
        self._queue_size = queue_size
        self._pool = pool
        self._desk = desk
        self._ros = ros
        self._client = client
        self._gate = gate
        self._clock = clock
        self._report = report
        self._publisher: Optional[SharedPublisher] = None
        self._asked_type = type_name
        self._ready = False
        self._last: Optional[SharedPublisher] = None
        self._held: Deque[Outgoing] = collections.deque(maxlen=MAX_HELD)
        self._holds = asyncio.Event()
        self._stop: Optional[genpy.Message] = None
        self._goals: Optional[Goals] = None

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
        self._publisher = await self._pool.acquire(
            self.topic, self._asked_type, latch=self._latch, queue_size=self._queue_size
        )
        type_name = self._publisher.codec.type_name
        if Goals.go_to(self.topic) and is_goal_type(type_name):
            self._goals = Goals(self.topic, type_name, self._client, self._desk)
            await self._goals.open()
            await self._send_goals(self._publisher, self._goals, action_timeout)
        await self._publisher.settle(connect_timeout)
        self._ready = True
        while self._held:
            self._send(self._publisher, self._held.popleft())

    async def _send_goals(self, publisher: SharedPublisher, goals: Goals, timeout: float) -> None:
        while True:
            await self._holds.wait()
            self._holds.clear()
            if not await goals.connect(timeout):
                sentence = f"servers of {self.topic} are not connected within {timeout:g} s"
                self._report(f"publish: {sentence}; answers may be lost", None, "warning")
            while self._held:
                self._send(publisher, self._held.popleft())

    def publish(self, outgoing: Outgoing) -> None:
        """Publish a message, now or as soon as that is possible."""
        publisher = self._publisher if self._ready else self._settled_by_others()
        if publisher is None:
            if len(self._held) == MAX_HELD and Goals.go_to(self.topic):
                sentence = f"dropped; {MAX_HELD} newer goals wait for the action's servers"
                self._report(f"publish to {self.topic}: {sentence}", self._held[0].id, "error")
            self._held.append(outgoing)
            self._holds.set()
        else:
            self._send(publisher, outgoing)

    def _settled_by_others(self) -> Optional[SharedPublisher]:
        """Return a publisher that others use already, so that an e-stop need not wait."""
        settled = self._pool.settled(self.topic)
        if settled is None or self._held or is_goal_type(settled.codec.type_name):
            return None
        return settled

    def _send(self, publisher: SharedPublisher, outgoing: Outgoing) -> None:
        try:
            value = {} if outgoing.value is None else outgoing.value
            message = publisher.codec.from_json(value, self._ros.now)
            self._gate.check_numbers("publish", self.topic, value)
            if message._type in _NAMES_CLIENT:
                message.client = self._client
            age = None if outgoing.sent is None else outgoing.received - outgoing.sent
            # A goal is no less wanted for having waited for its server.
            waited = 0.0 if self._goals is not None else self._clock() - outgoing.received
            if not self._gate.admit_message(self.topic, message, age, waited):
                return
            self._desk.check_cancel(self.topic, message, self._client)
            if self._goals is not None:
                self._goals.note(message)
            self._last = publisher
            publisher.publish(message)
        except CommandUncertainError as error:
            # Not in the words of a refusal, on which clients let go of what is held.
            self._report(str(error), outgoing.id, "warning")
        except CommandOverdueError as error:
            self._report(f"publish to {self.topic}: {error}", outgoing.id, "info")
        except CommandRefusedError as error:
            self._report(f"publish to {self.topic}: {error}", outgoing.id, "warning")
        except (FieldError, OperationError) as error:
            self._report(f"publish to {self.topic}: {error}", outgoing.id, "error")
        else:
            self._stop = stop_for(message)

    def stop(self) -> None:
        """End the motion that the client commands on this topic, and forget what waits."""
        self._held.clear()
        stop, self._stop = self._stop, None
        if stop is not None and self._last is not None:
            self._finish(functools.partial(self._last.publish, stop))
        if self._goals is not None:
            self._finish(self._goals.cancel)

    def _finish(self, publish: Callable[[], None]) -> None:
        try:
            publish()
        except OperationError as error:
            self._report(f"stop on {self.topic}: {error}", None, "error")

    def close(self) -> None:
        """End: stop what the client drove, and give the publishers back."""
        self.stop()
        if self._goals is not None:
            self._goals.close()
        if self._publisher is not None:
            self._pool.release(self.topic, latch=self._latch)
        self._publisher = self._goals = self._last = None
