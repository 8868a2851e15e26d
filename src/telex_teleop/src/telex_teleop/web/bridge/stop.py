"""What stops a thing that a client drove, when the client is no longer there to do it."""

from __future__ import annotations

import copy
from typing import Any, Callable, Dict, Iterable, Optional, Tuple

import genpy


def _moves(*numbers: Iterable[float]) -> bool:
    return any(value != 0.0 for group in numbers for value in group)


def _twist_moves(twist: Any) -> bool:
    linear, angular = twist.linear, twist.angular
    return _moves((linear.x, linear.y, linear.z), (angular.x, angular.y, angular.z))


def _stop_twist(message: Any) -> Any:
    return type(message)()


def _stop_with_header(message: Any) -> Any:
    stop = type(message)()
    stop.header = copy.copy(message.header)
    return stop


def _stop_preset(message: Any) -> Any:
    stop = _stop_with_header(message)
    stop.client = message.client
    return stop


def _jog_moves(jog: Any) -> bool:
    return _moves(jog.velocities, jog.displacements)


def _stop_jog(message: Any) -> Any:
    stop = type(message)()
    stop.header = copy.copy(message.header)
    stop.joint_names = list(message.joint_names)
    stop.velocities = [0.0] * len(message.joint_names)
    return stop


_Rule = Tuple[Callable[[Any], bool], Callable[[Any], Any]]

_RULES: Dict[str, _Rule] = {
    "geometry_msgs/Twist": (_twist_moves, _stop_twist),
    "geometry_msgs/TwistStamped": (
        lambda message: _twist_moves(message.twist),
        _stop_with_header,
    ),
    "control_msgs/JointJog": (_jog_moves, _stop_jog),
    "telex_msgs/FlipperPresetHold": (lambda message: message.preset != "", _stop_preset),
}


def stop_for(message: genpy.Message) -> Optional[genpy.Message]:
    """Return the message that ends the motion which a message commands.

    Returns
    -------
    stop
        A command of zero velocity for the same thing; None if the message commands no motion, or
        is no velocity command at all.
    """
    rule = _RULES.get(message._type)
    if rule is None or not rule[0](message):
        return None
    return rule[1](message)
