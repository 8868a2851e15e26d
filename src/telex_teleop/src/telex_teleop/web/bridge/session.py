"""One client of the bridge: what it asked for, and what has to be undone when it goes."""

from __future__ import annotations

import functools
from random import Random
from typing import Callable, Dict, Optional

from ..exam.exam_list import Exam
from ..line.line import Line
from ..link.uplink import Sent, Uplink
from ..rights import ExamRights, Rights
from ..server_config import RosbridgeConfig
from ..workers import OrderedWorker
from .clients.access import Access
from .clients.client import LEVELS, Client
from .clients.control import Control, ControlServices, Member
from .clients.other_robots import OtherRobots
from .clients.outbox import Outbox
from .protocol.operations import Operation, OperationError
from .ros import Ros
from .services.advertise_service import AdvertisedServices
from .services.call_service import ServiceCalls, Services
from .services.instructor_actions import InstructorActions
from .topics.commands import CommandGate
from .topics.goals import AllGoals
from .topics.publish import Publications
from .topics.shared_topics import LINGER, Publishers, Subscribers
from .topics.stuck_key import StuckKey
from .topics.subscribe import Subscriptions


class Shared:
    """What all clients of a bridge share; make it on the loop's thread.

    Parameters
    ----------
    exam_rights
        What clients may do while an exam runs.
    proven
        Whether instructors have shown the token of theirs; otherwise an exam's list holds for
        them, too.
    linger
        Time (s) that a publisher outlives its last client.

    Attributes
    ----------
    line
        What passes between the robot and clients that are no instructors.
    """

    def __init__(
        self,
        config: RosbridgeConfig,
        ros: Ros,
        rights: Rights,
        *,
        exam_rights: Optional[ExamRights] = None,
        proven: bool = False,
        linger: float = LINGER,
    ) -> None:
        self.config = config
        self.ros = ros
        self.worker = OrderedWorker("bridge to ROS")
        self.line = Line(Random())
        self.publishers = Publishers(ros, self.worker, linger)
        self.subscribers = Subscribers(ros, self.worker)
        self.goals = AllGoals(self.publishers, self.subscribers, ros)
        self.stuck_key = StuckKey(ros, self.worker, config.e_stop_topic)
        self.control = Control()
        namespace = ros.resolve("x")[: -len("x")]
        self.exam = Exam(exam_rights or ExamRights(), namespace)
        self.exam.changed = self._review
        self.other_robots = OtherRobots(namespace)
        self.other_robots.changed = self._review
        self.access = {
            instructor: Access(
                rights,
                ros.resolve,
                config.e_stop_topic,
                others=self.other_robots,
                instructor=instructor,
                plain=config.plain,
                exam=None if instructor and proven else self.exam,
            )
            for instructor in (False, True)
        }
        own_services = ControlServices(self.control, ros.resolve, self.end_exam if proven else None)
        self.actions = InstructorActions(ros, self.publishers)
        self.services = Services(
            ros, self.worker, own_services, self.access, self.actions, config.service_timeout
        )

    def _review(self) -> None:
        for member in self.control.members:
            member.review()

    def end_exam(self) -> bool:
        """End the list of the exam that runs; tell whether one did."""
        ran = bool(self.exam.trial)
        self.exam.set("")
        return ran


class ClientSession:
    """Obeys one client, on the loop's thread; nothing that it sends raises or blocks.

    Whatever the client asks for comes in by `receive`, and its end by `close`; whatever goes to it
    leaves by its outbox.

    Parameters
    ----------
    drop
        Cuts the connection, with the reason.

    Attributes
    ----------
    ended
        Called when it has ended.
    """

    def __init__(
        self, member: Member, shared: Shared, outbox: Outbox, drop: Callable[[str], None]
    ) -> None:
        config, ros, control = shared.config, shared.ros, shared.control
        access = shared.access[member.instructor]
        self._control = control
        self._uplink = Uplink(None if member.instructor else shared.line, ros.sim_time)
        self._has_ended = False
        self.ended: Callable[[], None] = lambda: None
        self._client = Client(member, access, outbox, drop)
        self._gate = CommandGate(self._client, control, config)
        self._publications = Publications(
            self._client,
            self._gate,
            config=config,
            ros=ros,
            publishers=shared.publishers,
            goals=shared.goals,
            stuck_key=shared.stuck_key,
        )
        self._subscriptions = Subscriptions(
            self._client, config=config, ros=ros, subscribers=shared.subscribers
        )
        self._advertised = AdvertisedServices(
            self._client, config=config, ros=ros, worker=shared.worker
        )
        self._calls = ServiceCalls(
            self._client,
            self._gate,
            shared.services,
            advertised=self._advertised,
            resolve=ros.resolve,
            limit=config.max_service_calls,
        )
        self._operations: Dict[str, Callable[[Operation], None]] = {
            "publish": self._publications.publish,
            "advertise": self._publications.advertise,
            "unadvertise": self._publications.unadvertise,
            "subscribe": self._subscriptions.subscribe,
            "unsubscribe": self._subscriptions.unsubscribe,
            "call_service": self._calls.call,
            "advertise_service": self._advertised.advertise,
            "unadvertise_service": self._advertised.unadvertise,
            "service_response": self._advertised.respond,
            "set_level": self._set_level,
            "status": lambda _: None,
        }
        member.stop = self._publications.stop
        member.call_back = self._uplink.call_back
        member.has_under_way = lambda: not self._uplink.passes
        member.review = self._review
        control.join(member)

    def receive(self, text: str) -> None:
        """Obey one text message of the client, as soon as it has passed the line."""
        operation: Optional[Operation] = None
        try:
            operation = Operation(text, self._gate.clock())
            # Before the line, whose delay is not of the message's age.
            self._gate.note_time(operation)
            if self._uplink.passes:
                self._obey(operation)
            else:
                self._send(operation, len(text))
        except OperationError as error:
            self._complain(error, operation)

    async def room(self) -> None:
        """Wait until more messages may be on the line."""
        await self._uplink.room()

    def _send(self, operation: Operation, size: int) -> None:
        """Let an operation pass the line."""
        publishes = operation.op == "publish"
        releases = publishes and self._publications.releases_e_stop(operation)
        commands = (publishes and self._publications.commands(operation)) or (
            operation.op == "call_service" and self._calls.commands(operation)
        )
        sent = Sent(
            functools.partial(self._arrive, operation),
            functools.partial(self._called_back, operation) if commands or releases else None,
            releases,
        )
        self._uplink.send(
            sent, size, may_be_lost=publishes and commands and self._publications.moves(operation)
        )

    def _arrive(self, operation: Operation) -> None:
        """Obey an operation that has passed the line."""
        operation.hold_until(self._gate.clock())
        try:
            self._obey(operation)
        except OperationError as error:
            self._complain(error, operation)

    def _called_back(self, operation: Operation, reason: str) -> None:
        if operation.op == "call_service":
            self._calls.refuse(operation, f"the call was lost on its way: {reason}")
        else:
            self._control.count_dropped(self._client.member)

    def _complain(self, error: OperationError, operation: Optional[Operation]) -> None:
        name = f"{operation.op[:80]}: " if operation is not None else ""
        self.report(f"{name}{error}", operation)

    def _obey(self, operation: Operation) -> None:
        obey = self._operations.get(operation.op)
        if obey is None:
            known = ", ".join(self._operations)
            raise OperationError(f"there is no operation {operation.op[:80]!r}; known are {known}")
        obey(operation)

    def report(self, sentence: str, operation: Optional[Operation] = None) -> None:
        """Tell the client what went wrong, unless it has asked not to hear that."""
        self._client.report(sentence, None if operation is None else operation.id)

    def set_level(self, level: str) -> None:
        """Choose what the client hears of: errors, warnings as well, nothing."""
        if level not in LEVELS:
            raise OperationError(f"there is no level {level[:80]!r}; known are {', '.join(LEVELS)}")
        self._client.level = level

    def _set_level(self, operation: Operation) -> None:
        self.set_level(operation.text("level"))

    def _review(self) -> None:
        """End what the client may not use any more, and say so."""
        for closed in (
            *self._publications.review(),
            *self._subscriptions.review(),
            *self._advertised.review(),
        ):
            self.report(closed)

    def close(self) -> None:
        """End when all that the client has sent has arrived, its end being the last of it."""
        self._subscriptions.close()
        if self._uplink.passes:
            self.end()
        else:
            self._uplink.send(Sent(self.end), 0)

    def end(self) -> None:
        """End now: stop what the client drove, give back all that it used."""
        if self._has_ended:
            return
        self._has_ended = True
        self._uplink.close()
        self._publications.close()
        self._subscriptions.close()
        self._advertised.close()
        self._client.close()
        self._control.leave(self._client.member)
        self.ended()
