"""Joints that follow others: ``<mimic>`` of a URDF."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Dict, Tuple

from .elements import UrdfError, number
from .model import Robot
from .transmission_parser import interfaces


@dataclass(frozen=True)
class Mimic:
    """How a joint follows another: position = multiplier * the other's position + offset.

    Attributes
    ----------
    joint : str
        The leader. It follows no other joint itself.
    multiplier : float
        rad/rad, m/rad, ...
    offset : float
        rad, m.
    """

    joint: str
    multiplier: float
    offset: float

    def position(self, leader: float) -> float:
        """Return the position that belongs to one of the leader (rad, m)."""
        return self.multiplier * leader + self.offset

    def image(self, lower: float, upper: float) -> Tuple[float, float]:
        """Return the range that belongs to a range of the leader."""
        return _ordered(*(self._of(each, self.multiplier, self.offset) for each in (lower, upper)))

    def preimage(self, lower: float, upper: float) -> Tuple[float, float]:
        """Return the range of the leader in which this joint stays in its own.

        It is (inf, -inf) where there is none.
        """
        if self.multiplier == 0.0:
            end = math.inf if lower <= self.offset <= upper else -math.inf
            return -end, end
        return _ordered(
            *(self._of(each - self.offset, 1.0 / self.multiplier, 0.0) for each in (lower, upper))
        )

    @staticmethod
    def _of(position: float, multiplier: float, offset: float) -> float:
        # Infinity times 0 is no number.
        return multiplier * position + offset if multiplier else offset


def _ordered(first: float, second: float) -> Tuple[float, float]:
    return min(first, second), max(first, second)


def mimics(robot: Robot) -> Dict[str, Mimic]:
    """Return how joints follow others, by name, in the order of the file.

    Left out are joints that a transmission of their own drives, as ros_control has it. A joint that
    follows a follower has the leader of both.

    Raises
    ------
    UrdfError
        A leader is not there or cannot move, joints follow each other in a circle, or a number is
        wrong.
    """
    elements = robot.joint_map
    driven = interfaces(robot)
    own: Dict[str, Mimic] = {}
    for name, element in elements.items():
        mimic = element.mimic
        if mimic is None or name in driven or element.type == "fixed":
            continue
        leader, where = mimic.joint, f"joint '{name}'"
        if leader not in elements or elements[leader].type == "fixed":
            problem = "cannot move" if leader in elements else "is not there"
            raise UrdfError(f"{where} mimics the joint '{leader}', which {problem}")
        own[name] = Mimic(
            leader,
            number(mimic, "multiplier", where, 1.0),
            number(mimic, "offset", where, 0.0),
        )
    return {name: _followed(name, own) for name in own}


def _followed(name: str, own: Dict[str, Mimic]) -> Mimic:
    """What a joint follows in the end."""
    found, passed = own[name], {name}
    while found.joint in own:
        if found.joint in passed:
            raise UrdfError(f"joint '{name}' mimics itself, by way of '{found.joint}'")
        passed.add(found.joint)
        above = own[found.joint]
        found = Mimic(
            above.joint,
            found.multiplier * above.multiplier,
            found.multiplier * above.offset + found.offset,
        )
    return found
