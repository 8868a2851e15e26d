"""Commands of clients: which messages are commands, which are obeyed, and what stops them."""

from __future__ import annotations

import asyncio
import copy
import dataclasses
import math
from typing import Any, Callable, Dict, Iterable, Optional, Tuple

import genpy

from ...server_config import RosbridgeConfig
from ..clients.client import Client
from ..clients.control import Control, ControlError
from ..protocol.operations import Operation, OperationError
from ..protocol.ros_messages import holds_null
from .command_age import PAUSE, CommandAge


@dataclasses.dataclass(frozen=True)
class CommandKind:
    """What the bridge knows of a type of command.

    Attributes
    ----------
    moves
        Tells whether a message asks for motion; if not, it asks for standstill.
    stop
        Makes the message that ends the motion; None if it ends when the stream falls silent.
    """

    moves: Callable[[Any], bool]
    stop: Optional[Callable[[Any], Any]]


def _any(*numbers: Iterable[float]) -> bool:
    return any(value != 0.0 for group in numbers for value in group)


def _twist_moves(twist: Any) -> bool:
    linear, angular = twist.linear, twist.angular
    return _any((linear.x, linear.y, linear.z), (angular.x, angular.y, angular.z))


def _stop_empty(message: Any) -> Any:
    return type(message)()


def _stop_with_header(message: Any) -> Any:
    stop = type(message)()
    stop.header = copy.copy(message.header)
    return stop


def _stop_preset(message: Any) -> Any:
    stop = _stop_with_header(message)
    stop.client = message.client
    return stop


def _stop_jog(message: Any) -> Any:
    stop = _stop_with_header(message)
    stop.joint_names = list(message.joint_names)
    stop.velocities = [0.0] * len(message.joint_names)
    return stop


_KINDS: Dict[str, CommandKind] = {
    "geometry_msgs/Twist": CommandKind(_twist_moves, _stop_empty),
    "geometry_msgs/TwistStamped": CommandKind(
        lambda message: _twist_moves(message.twist), _stop_with_header
    ),
    "geometry_msgs/PoseStamped": CommandKind(lambda message: True, None),
    "control_msgs/JointJog": CommandKind(
        lambda message: _any(message.velocities, message.displacements), _stop_jog
    ),
    "telex_msgs/FlipperPresetHold": CommandKind(lambda message: message.preset != "", _stop_preset),
    # An empty trajectory, and only one without a stamp, stops the controller at once.
    "trajectory_msgs/JointTrajectory": CommandKind(
        lambda message: bool(message.points), _stop_empty
    ),
}


def kind_of(message: genpy.Message) -> Optional[CommandKind]:
    """Return what is known of a message as a command; None for types that command no motion."""
    return _KINDS.get(message._type)


def commands_motion(type_name: str) -> bool:
    """Tell whether messages of a type command motion, so that an old one must not be replayed."""
    return type_name in _KINDS or is_goal_type(type_name)


def stop_for(message: genpy.Message) -> Optional[genpy.Message]:
    """Return the message that ends the motion which a message commands.

    Returns
    -------
    stop
        A command of standstill for the same thing, on the same topic; None if the message commands
        no motion, or one that ends otherwise.
    """
    kind = kind_of(message)
    if kind is None or kind.stop is None or not kind.moves(message):
        return None
    return kind.stop(message)


def is_goal_type(type_name: str) -> bool:
    """Tell whether messages of a type are goals of an action."""
    return type_name.endswith("ActionGoal")


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
    config
        How old a command may be, and by how much the client's line may become slower.

    Attributes
    ----------
    clock
        Monotonic time (s).
    """

    def __init__(self, client: Client, control: Control, config: RosbridgeConfig) -> None:
        self.clock = asyncio.get_running_loop().time
        self._client = client
        self._member = client.member
        self._access = client.access
        self._control = control
        self._max_age = config.max_command_age
        self._ages = CommandAge(config.max_command_age, config.max_learned_delay)
        self._refused: Dict[str, Tuple[float, int]] = {}  # topic to time of the last one, number

    def note_time(self, operation: Operation) -> None:
        """Learn from an operation how slow the client's line is, and set when it was sent.

        Raises
        ------
        OperationError
            What it tells is no time.
        """
        sent = operation.get("sent")
        if sent is None:
            return
        number = isinstance(sent, (int, float)) and not isinstance(sent, bool)
        if not number or not math.isfinite(sent):
            raise OperationError("'sent' must be a number: milliseconds on the client's clock")
        known = self._ages.slower
        operation.sent = operation.received - self._ages.of(sent / 1000.0, operation.received)
        if self._ages.slower > known:
            self._client.report(
                f"the line has become slower, by {self._ages.slower:.2f} s; commands count again",
                level="warning",
            )

    def admit_message(
        self,
        topic: str,
        message: genpy.Message,
        age: Optional[float],
        waited: float = 0.0,
        held: float = 0.0,
    ) -> bool:
        """Decide on a message to a topic.

        Parameters
        ----------
        topic
            Global name.
        age
            Its age on arrival (s), None if the client does not tell.
        waited
            Time (s) that it has waited since for the bridge's own connections.
        held
            Time (s) that the line has held it, which is not of its age.

        Returns
        -------
        bool
            False for a stop that is not this client's to give, and for what a client without
            control tells of what it sees; there is nothing to complain of.

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
        if topic == self._access.telemetry_topic:
            return self._control.holder is self._member
        if not self._access.is_command("publish", topic):
            return True
        kind = kind_of(message)
        if kind is not None and not kind.moves(message):
            self._refused.pop(topic, None)
            # Whose stop reaches the robot also ends the wait for a new press, so it must be his.
            return self._control.holder in (None, self._member)
        if age is not None:
            self._ages.note_command(age, self.clock() - waited - held)
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
        if message.data:
            # Now: where it was set already, nothing in sim/status tells of it.
            self._control.note_e_stop(self._member)
            return True
        if self._member.instructor:
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
        if number > 1 and self.clock() - refused < PAUSE:
            raise CommandRefusedError("this stream began when it was refused: stop, and start anew")

    def _note_refused(self, topic: str) -> None:
        self._control.count_dropped(self._member)
        now = self.clock()
        refused, number = self._refused.get(topic, (now, 0))
        self._refused[topic] = (now, number + 1 if now - refused < PAUSE else 1)
