"""Held keys turned into commands for the teleoperation nodes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Dict, Iterable, List, Tuple

from telex_teleop.keyboard.map import Action, Drive, Jog, Preset
from telex_teleop.track_drive import STANDSTILL, Velocity

__all__ = ["NO_PRESET", "Commander", "Commands"]

NO_PRESET = ""
"""In place of a preset's name: stop."""


@dataclass(frozen=True)
class Commands:
    """What is to be sent now.

    Attributes
    ----------
    jogs
        Node to joint to rate (rad/s or m/s); a joint that has just been let go is in it with 0.
    drive
        Velocity for the tracks; empty when there is nothing to say to them.
    preset
        Name of a flipper preset, an empty one to stop; empty when there is nothing to say.
    """

    jogs: Dict[str, Dict[str, float]]
    drive: Tuple[Velocity, ...]
    preset: Tuple[str, ...] = ()


class Commander:
    """Sums the actions of all held keys, and sends a zero to what was let go.

    Parameters
    ----------
    jog_rate
        Rate of a jog (rad/s or m/s).
    linear, angular
        Velocity of a drive (m/s, rad/s).
    """

    def __init__(self, jog_rate: float, linear: float, angular: float) -> None:
        self._jog_rate = jog_rate
        self._linear = linear
        self._angular = angular
        self._moving: Dict[Tuple[str, str], None] = {}
        self._driving = False
        self._leading = False

    @property
    def busy(self) -> bool:
        """Whether something was last told to move."""
        return bool(self._moving) or self._driving or self._leading

    def update(self, held: Iterable[Action]) -> Commands:
        """Return the commands for the actions whose keys are held."""
        signs: Dict[Tuple[str, str], int] = dict.fromkeys(self._moving, 0)
        drives: List[Drive] = []
        presets: List[str] = []
        for action in held:
            if isinstance(action, Drive):
                drives.append(action)
            elif isinstance(action, Preset):
                presets.append(action.name)
            elif isinstance(action, Jog):
                for joint in action.joints:
                    axis = (action.node, joint)
                    signs[axis] = signs.get(axis, 0) + action.sign
        self._moving = {axis: None for axis, sign in signs.items() if sign != 0}
        jogs: Dict[str, Dict[str, float]] = {}
        for (node, joint), sign in signs.items():
            # two keys with the same joint do not make it faster
            jogs.setdefault(node, {})[joint] = self._jog_rate * _unit(sign)
        return Commands(jogs, self._drive(drives), self._preset(presets))

    def stop(self, actions: Iterable[Action]) -> Commands:
        """Return zeros for everything that any of the actions could move."""
        everything: Dict[str, Dict[str, float]] = {}
        for action in actions:
            if isinstance(action, Jog):
                everything.setdefault(action.node, {}).update(dict.fromkeys(action.joints, 0.0))
        self._moving = {}
        self._driving = self._leading = False
        return Commands(everything, (STANDSTILL,), (NO_PRESET,))

    def _preset(self, names: List[str]) -> Tuple[str, ...]:
        # the keys of two presets contradict each other as the two keys of a joint do
        name = names[0] if len(names) == 1 else NO_PRESET
        was_leading, self._leading = self._leading, name != NO_PRESET
        return (name,) if self._leading or was_leading else ()

    def _drive(self, drives: List[Drive]) -> Tuple[Velocity, ...]:
        velocity = Velocity(
            self._linear * _unit(sum(drive.linear for drive in drives)),
            self._angular * _unit(sum(drive.angular for drive in drives)),
        )
        was_driving, self._driving = self._driving, velocity != STANDSTILL
        return (velocity,) if self._driving or was_driving else ()


def _unit(number: int) -> int:
    return (number > 0) - (number < 0)
