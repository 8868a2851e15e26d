"""Validation of control_msgs/JointJog, free of ROS types."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import Collection, Dict, Optional, Sequence

from telex_control.common.plausible import LARGEST_POSITION, LARGEST_SPEED, LONGEST, number_problem


class InvalidCommand(ValueError):  # noqa: N818  it names a message, as rospy's exceptions do
    """A message that must not move anything; the text names the field and what would be right."""


@dataclass(frozen=True)
class JogCommand:
    """A valid jog: either velocities or displacements of some joints.

    Attributes
    ----------
    velocities
        Joint to rate (rad/s or m/s); 0 stops the joint.
    displacements
        Joint to one-shot increment of its reference (rad or m).
    validity
        Time (s) that the velocities hold unless repeated, None for the node's own timeout.
    """

    velocities: Dict[str, float]
    displacements: Dict[str, float]
    validity: Optional[float]


def parse_joint_jog(
    joint_names: Sequence[str],
    displacements: Sequence[float],
    velocities: Sequence[float],
    duration: float,
    known: Collection[str],
) -> JogCommand:
    """Check the fields of a JointJog as a whole: one bad entry refuses the message.

    Parameters
    ----------
    joint_names, displacements, velocities, duration
        The fields of the message.
    known
        Joints that this node moves.

    Raises
    ------
    InvalidCommand
        When the message contradicts itself or names what is not there.
    """
    _check_names(joint_names, known)
    if len(displacements) > 0 and len(velocities) > 0:
        raise InvalidCommand("displacements and velocities are both given; give one of them")
    if len(displacements) == 0 and len(velocities) == 0:
        raise InvalidCommand("displacements and velocities are both empty; give one of them")
    if not 0.0 <= duration <= LONGEST:
        raise InvalidCommand(
            f"duration is {duration!r}; must be 0 (none) or a time above 0 s, at most {LONGEST:g} s"
        )
    return JogCommand(
        velocities=_by_joint("velocities", joint_names, velocities),
        displacements=_by_joint("displacements", joint_names, displacements),
        validity=duration if duration > 0.0 else None,
    )


def require_number(field: str, value: float, largest: float) -> None:
    """Raise an `InvalidCommand` unless a number of a command can be meant.

    Parameters
    ----------
    field : str
        Where it stands.
    largest : float
        Magnitude that is possible; beyond, it comes from a fault.
    """
    if number_problem(value, largest):
        raise InvalidCommand(
            f"{field} is {value!r}; must be a finite number, of at most {largest:g}"
        )


def require_known(joint_names: Sequence[str], known: Collection[str]) -> None:
    """Raise an `InvalidCommand` unless all of some joints are among those that a node moves."""
    if len(joint_names) > len(known):
        raise InvalidCommand(
            f"joint_names has {len(joint_names)} entries; this node moves {len(known)} joints"
        )
    unknown = [name[:80] for name in joint_names if name not in known]
    if unknown:
        raise InvalidCommand(
            f"joint_names: unknown {', '.join(map(repr, unknown))}; "
            f"this node moves {', '.join(known)}"
        )


def require_once(field: str, joint_names: Sequence[str]) -> None:
    """Raise an `InvalidCommand` when a joint stands twice in a field."""
    twice = sorted(name for name, count in Counter(joint_names).items() if count > 1)
    if twice:
        raise InvalidCommand(f"{field}: {', '.join(twice)} stands there twice; give it once")


def _check_names(joint_names: Sequence[str], known: Collection[str]) -> None:
    if len(joint_names) == 0:
        raise InvalidCommand("joint_names is empty; name the joints to move")
    require_known(joint_names, known)
    require_once("joint_names", joint_names)


def _by_joint(field: str, joint_names: Sequence[str], values: Sequence[float]) -> Dict[str, float]:
    if len(values) == 0:
        return {}
    if len(values) != len(joint_names):
        raise InvalidCommand(
            f"{field} has {len(values)} entries for {len(joint_names)} joint_names; give as many"
        )
    largest = LARGEST_SPEED if field == "velocities" else LARGEST_POSITION
    for name, value in zip(joint_names, values):
        require_number(f"{field} of {name}", value, largest)
    return {name: float(value) for name, value in zip(joint_names, values)}
