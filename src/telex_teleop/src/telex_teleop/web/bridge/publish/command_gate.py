"""Admission of one client's commands."""

from __future__ import annotations

from typing import Any, Callable, Dict, Optional, Tuple

import genpy

from ..control.access import Access
from ..control.clients import Control, ControlError, Member
from ..protocol.message_json import holds_null
from ..protocol.operations import OperationError
from .command_age import PAUSE, CommandAge
from .stop import kind_of


class CommandRefusedError(OperationError):
    """A command is not obeyed; the text says why."""


class CommandUncertainError(OperationError):
    """A command comes late on a line that seems to have become slower; the text says so."""


class CommandOverdueError(OperationError):
    """A command came in time, but has waited in the bridge for too long; the text says so."""


class CommandGate:
    """Lets the commands of one client through, or says why not.

    A stream of commands that was refused stays refused until it has paused or sent a stop, even if
    its client gets control meanwhile: a key that was held all the time must be pressed anew.

    Parameters
    ----------
    member
        The client.
    control
        Who holds control.
    access
        What the client may do, and what is a command.
    max_age
        Age (s) above which a command comes too late.
    ages
        Learns it when the client's line becomes slower.
    clock
        Monotonic time (s).
    """

    def __init__(
        self,
        member: Member,
        control: Control,
        access: Access,
        max_age: float,
        ages: CommandAge,
        clock: Callable[[], float],
    ) -> None:
        self._member = member
        self._control = control
        self._access = access
        self._max_age = max_age
        self._ages = ages
        self._clock = clock
        self._refused: Dict[str, Tuple[float, int]] = {}  # topic to time of the last one, number

    def admit_message(
        self, topic: str, message: genpy.Message, age: Optional[float], waited: float = 0.0
    ) -> bool:
        """Decide on a message to a topic.

        Parameters
        ----------
        topic
            Global name.
        message
            What the client wants to publish.
        age
            Its age on arrival (s), None if the client does not tell.
        waited
            Time (s) that it has waited since for the bridge's own connections.

        Returns
        -------
        bool
            False for a stop that is not this client's to give; there is nothing to complain of.

        Raises
        ------
        CommandRefusedError
            It is a command, and not obeyed.
        CommandUncertainError
            It comes late, but by what may be the line's new delay. The stream may go on: it began
            after the line had become slower, and will be obeyed when that is certain.
        CommandOverdueError
            It is one that moves the robot, and would have been obeyed at once. The stream may go
            on: what the bridge was late with is not the client's gap, and its next command is a
            fresh one.
        """
        if topic == self._access.e_stop_topic:
            return self._admit_e_stop(message, None if age is None else age + waited)
        if not self._access.is_command("publish", topic):
            return True
        kind = kind_of(message)
        if kind is not None and not kind.moves(message):
            self._refused.pop(topic, None)
            # Whose stop reaches the robot also ends the wait for a new press, so it must be his.
            return self._control.holder in (None, self._member)
        if age is not None:
            self._ages.note_command(age, self._clock() - waited)
        try:
            self._check_age(age)
            if self._access.needs_control("publish", topic):
                self._require_control()
                self._check_stream(topic)
        except CommandRefusedError:
            self._note_refused(topic)
            raise
        self._refused.pop(topic, None)
        # What moves nothing by itself, such as a lamp's brightness, is sent once and still wanted.
        if kind is not None and age is not None and age + waited > self._max_age:
            self._control.count_dropped(self._member)
            raise CommandOverdueError(f"the command waited {waited:.2f} s for a subscriber")
        return True

    def admit_call(self, service: str) -> None:
        """Raise CommandRefusedError unless the client may call a service now."""
        self._access.check("call", service)
        self._admit("call", service)

    def admit_setting(self, name: str) -> None:
        """Raise CommandRefusedError unless the client may set or delete a parameter now."""
        self._access.check("set", name)
        self._admit("set", name)

    def check_numbers(self, use: str, name: str, value: Any) -> None:
        """Raise OperationError for a command that holds a null, which would become a NaN."""
        if self._access.is_command(use, name) and holds_null(value):
            raise OperationError("a command holds null, which is no number to move by")

    def _admit(self, use: str, name: str) -> None:
        if not self._access.needs_control(use, name):
            return
        try:
            self._require_control()
        except CommandRefusedError:
            self._control.count_dropped(self._member)
            raise

    def _admit_e_stop(self, message: Any, age: Optional[float]) -> bool:
        if message.data or self._member.instructor:
            return True
        try:
            self._check_age(age)
            self._require_control()
        except CommandRefusedError:
            self._control.count_dropped(self._member)
            raise
        return True

    def _check_age(self, age: Optional[float]) -> None:
        if age is None or age <= self._max_age:
            return
        if self._ages.is_learning:
            self._control.count_dropped(self._member)
            raise CommandUncertainError(
                "commands came late, and will count again when the line is steady"
            )
        raise CommandRefusedError(
            f"the command came {age:.2f} s late; {self._max_age:g} s are allowed. Let go, and "
            "press anew"
        )

    def _require_control(self) -> None:
        try:
            self._control.require(self._member)
        except ControlError as error:
            raise CommandRefusedError(str(error)) from None

    def _check_stream(self, topic: str) -> None:
        refused, number = self._refused.get(topic, (0.0, 0))
        if number > 1 and self._clock() - refused < PAUSE:
            raise CommandRefusedError("this stream began when it was refused: stop, and start anew")

    def _note_refused(self, topic: str) -> None:
        self._control.count_dropped(self._member)
        now = self._clock()
        refused, number = self._refused.get(topic, (now, 0))
        self._refused[topic] = (now, number + 1 if now - refused < PAUSE else 1)
