"""Stop messages for what a client drove, once the client is gone."""

from __future__ import annotations

import copy
import dataclasses
from typing import Any, Callable, Dict, Iterable, Optional

import genpy


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
