"""What one client publishes on one topic."""

from __future__ import annotations

import collections
import dataclasses
from typing import Any, Callable, Deque, Optional, Set

import genpy

from .command_gate import CommandGate, CommandRefusedError
from .message_json import FieldError
from .operations import Id, OperationError
from .publishers import PublisherPool, SharedPublisher
from .ros import Ros
from .stop import cancel_for, is_goal_type, stop_for

MAX_HELD = 20
"""Messages that wait while a new publisher finds its subscribers; the newest win."""

MAX_GOALS = 10
"""Goals of an action that are cancelled when their client goes; the newest ones."""

_GOAL, _CANCEL, _CANCEL_TYPE = "/goal", "/cancel", "actionlib_msgs/GoalID"

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
    sent
        When it was sent, on this machine's monotonic clock (s); None if the client does not tell.
    """

    value: Any
    id: Id
    sent: Optional[float] = None


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
        *,
        latch: bool,
        queue_size: int,
        pool: PublisherPool,
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
        self._ros = ros
        self._client = client
        self._gate = gate
        self._clock = clock
        self._report = report
        self._publisher: Optional[SharedPublisher] = None
        self._canceller: Optional[SharedPublisher] = None
        self._ready = False
        self._last: Optional[SharedPublisher] = None
        self._held: Deque[Outgoing] = collections.deque(maxlen=MAX_HELD)
        self._stop: Optional[genpy.Message] = None
        self._cancels: Deque[genpy.Message] = collections.deque(maxlen=MAX_GOALS)
        self._goals = 0

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
        if self.topic.endswith(_GOAL) and is_goal_type(self._publisher.codec.type_name):
            cancel_topic = self.topic[: -len(_GOAL)] + _CANCEL
            self._canceller = await self._pool.acquire(
                cancel_topic, _CANCEL_TYPE, latch=False, queue_size=MAX_GOALS
            )
            await self._canceller.settle(connect_timeout)
        await self._publisher.settle(connect_timeout)
        if self._canceller is not None:
            # The result is said once; who sends a goal has just subscribed to it.
            await self._pool.catch_up()
        self._ready = True
        while self._held:
            self._send(self._publisher, self._held.popleft())

    def publish(self, outgoing: Outgoing) -> None:
        """Publish a message, now or as soon as that is possible."""
        publisher = self._publisher if self._ready else self._settled_by_others()
        if publisher is None:
            self._held.append(outgoing)
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
            if message._type in _NAMES_CLIENT:
                message.client = self._client
            age = None if outgoing.sent is None else self._clock() - outgoing.sent
            if not self._gate.admit_message(self.topic, message, age):
                return
            if self._canceller is not None:
                self._remember_goal(message)
            self._last = publisher
            publisher.publish(message)
        except CommandRefusedError as error:
            self._report(f"publish to {self.topic}: {error}", outgoing.id, "warning")
        except (FieldError, OperationError) as error:
            self._report(f"publish to {self.topic}: {error}", outgoing.id, "error")
        else:
            self._stop = stop_for(message)

    def _remember_goal(self, goal: Any) -> None:
        if not goal.goal_id.id:
            self._goals += 1
            now = self._ros.now().to_sec()
            goal.goal_id.id = f"bridge client {self._client}, {self._goals}, {now:.6f}"
        self._cancels.append(cancel_for(goal))

    def stop(self) -> None:
        """End the motion that the client commands on this topic, and forget what waits."""
        self._held.clear()
        if self._stop is not None and self._last is not None:
            self._publish_last(self._last, self._stop)
        self._stop = None
        while self._cancels and self._canceller is not None:
            self._publish_last(self._canceller, self._cancels.popleft())

    def _publish_last(self, publisher: SharedPublisher, message: genpy.Message) -> None:
        try:
            publisher.publish(message)
        except OperationError as error:
            self._report(f"stop on {self.topic}: {error}", None, "error")

    def close(self) -> None:
        """End: stop what the client drove, and give the publishers back."""
        self.stop()
        if self._canceller is not None:
            self._pool.release(self.topic[: -len(_GOAL)] + _CANCEL, latch=False)
        if self._publisher is not None:
            self._pool.release(self.topic, latch=self._latch)
        self._publisher = self._canceller = self._last = None
