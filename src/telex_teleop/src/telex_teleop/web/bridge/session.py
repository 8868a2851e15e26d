"""One client of the bridge: what it asked for, and what has to be undone when it goes."""

from __future__ import annotations

import asyncio
import dataclasses
from typing import Callable, Dict, Optional

from ..server_config import RosbridgeConfig
from ..workers import OrderedWorker
from .control.access import Roles
from .control.clients import Control, Member
from .link import LEVELS, Link
from .outbox import Outbox
from .protocol.operations import Operation, OperationError
from .publish.command_age import CommandAge
from .publish.command_gate import CommandGate
from .publish.publishers import PublisherPool
from .publish.publishing import Publishing
from .ros import Ros
from .service.calling import Calling
from .service.goals import GoalDesk
from .service.offering import Offering
from .service.services import Caller, ServiceDesk
from .subscribe.feeds import FeedPool
from .subscribe.subscribing import Subscribing


@dataclasses.dataclass(frozen=True)
class Shared:
    """What all clients of a bridge share."""

    config: RosbridgeConfig
    ros: Ros
    worker: OrderedWorker
    publishers: PublisherPool
    feeds: FeedPool
    desk: GoalDesk
    services: ServiceDesk
    roles: Roles
    control: Control


class ClientSession:
    """Obeys one client, on the loop's thread; nothing that it sends raises or blocks.

    Parameters
    ----------
    member
        The client as others see it.
    shared
        What it shares with others.
    outbox
        What goes to the client.
    drop
        Cuts the connection, with the reason.
    """

    def __init__(
        self, member: Member, shared: Shared, outbox: Outbox, drop: Callable[[str], None]
    ) -> None:
        config, ros = shared.config, shared.ros
        access = shared.roles.of(instructor=member.instructor)
        self._member = member
        self._control = shared.control
        self._link = Link(outbox, drop)
        clock = asyncio.get_running_loop().time
        age = CommandAge(config.max_command_age, config.max_learned_delay)
        gate = CommandGate(member, shared.control, access, config.max_command_age, age, clock)
        self._publishing = Publishing(
            member.id,
            config,
            ros,
            pool=shared.publishers,
            desk=shared.desk,
            access=access,
            gate=gate,
            age=age,
            link=self._link,
        )
        self._subscribing = Subscribing(
            config,
            ros,
            feeds=shared.feeds,
            access=access,
            link=self._link,
            send=outbox.put_message,
        )
        self._offering = Offering(config, ros, shared.worker, access, self._link)
        self._calling = Calling(
            shared.services,
            Caller(member, gate),
            offering=self._offering,
            resolve=ros.resolve,
            limit=config.max_service_calls,
            link=self._link,
        )
        self._operations: Dict[str, Callable[[Operation], None]] = {
            "advertise": self._publishing.advertise,
            "unadvertise": self._publishing.unadvertise,
            "subscribe": self._subscribing.subscribe,
            "unsubscribe": self._subscribing.unsubscribe,
            "call_service": self._calling.call,
            "advertise_service": self._offering.advertise,
            "unadvertise_service": self._offering.unadvertise,
            "service_response": self._offering.respond,
            "set_level": self._set_level,
            "status": lambda _: None,
        }
        member.stop = self._publishing.stop
        self._control.join(member)

    def receive(self, text: str) -> None:
        """Obey one text message of the client."""
        operation: Optional[Operation] = None
        try:
            operation = Operation(text)
            self._obey(operation)
        except OperationError as error:
            name = f"{operation.op[:80]}: " if operation is not None else ""
            self.report(f"{name}{error}", operation)

    def _obey(self, operation: Operation) -> None:
        sent = self._publishing.note_time(operation)
        if operation.op == "publish":
            self._publishing.publish(operation, sent)
            return
        obey = self._operations.get(operation.op)
        if obey is None:
            known = ", ".join(["publish", *self._operations])
            raise OperationError(f"there is no operation {operation.op[:80]!r}; known are {known}")
        obey(operation)

    def report(self, sentence: str, operation: Optional[Operation] = None) -> None:
        """Tell the client what went wrong, unless it has asked not to hear that."""
        self._link.report(sentence, None if operation is None else operation.id)

    def set_level(self, level: str) -> None:
        """Choose what the client hears of: errors, warnings as well, nothing."""
        if level not in LEVELS:
            raise OperationError(f"there is no level {level[:80]!r}; known are {', '.join(LEVELS)}")
        self._link.level = level

    def _set_level(self, operation: Operation) -> None:
        self.set_level(operation.text("level"))

    def close(self) -> None:
        """End: stop what the client drove, give back all that it used."""
        self._publishing.close()
        self._subscribing.close()
        self._offering.close()
        self._link.close()
        self._control.leave(self._member)
