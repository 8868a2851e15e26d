"""Held keys turned into commands for the teleoperation nodes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Dict, Iterable, List, Tuple

from telex_teleop.keyboard.map import Action, Drive, Jog, Preset, Tool, ToPose
from telex_teleop.track_drive import STANDSTILL, Velocity

__all__ = ["NO_NAME", "Commander", "Commands"]

NO_NAME = ""
"""In place of the name of a preset or of a pose: stop."""


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
        Name of a flipper preset, `NO_NAME` to stop; empty when there is nothing to say.
    tool
        Linear and angular velocity of the tool (m/s, rad/s), six numbers; empty likewise.
    pose
        Name of the pose that the arm shall move to, `NO_NAME` to stop; empty likewise.
    """

    jogs: Dict[str, Dict[str, float]]
    drive: Tuple[Velocity, ...]
    preset: Tuple[str, ...] = ()
    tool: Tuple[Tuple[float, ...], ...] = ()
    pose: Tuple[str, ...] = ()


class Commander:
    """Sums the actions of all held keys, and sends a zero to what was let go.

    Parameters
    ----------
    jog_rate
        Rate of a jog (rad/s or m/s).
    linear, angular
        Velocity of a drive (m/s, rad/s).
    tool_linear, tool_angular
        Velocity of the tool (m/s, rad/s).
    """

    def __init__(
        self,
        jog_rate: float,
        linear: float,
        angular: float,
        tool_linear: float = 1.0,
        tool_angular: float = 1.0,
    ) -> None:
        self._jog_rate = jog_rate
        self._linear = linear
        self._angular = angular
        self._tool_rates = (tool_linear,) * 3 + (tool_angular,) * 3
        self._moving: Dict[Tuple[str, str], None] = {}
        self._driving = False
        self._leading = False
        self._preset = NO_NAME
        self._pose = NO_NAME

    @property
    def busy(self) -> bool:
        """Whether something was last told to move."""
        return bool(self._moving or self._preset or self._pose) or self._driving or self._leading

    def update(self, held: Iterable[Action]) -> Commands:
        """Return the commands for the actions whose keys are held."""
        signs: Dict[Tuple[str, str], int] = dict.fromkeys(self._moving, 0)
        drives: List[Drive] = []
        tools: List[Tool] = []
        presets: List[str] = []
        poses: List[str] = []
        for action in held:
            if isinstance(action, Drive):
                drives.append(action)
            elif isinstance(action, Tool):
                tools.append(action)
            elif isinstance(action, Preset):
                presets.append(action.name)
            elif isinstance(action, ToPose):
                poses.append(action.name)
            elif isinstance(action, Jog):
                for joint in action.joints:
                    axis = (action.node, joint)
                    signs[axis] = signs.get(axis, 0) + action.sign
        self._moving = {axis: None for axis, sign in signs.items() if sign != 0}
        jogs: Dict[str, Dict[str, float]] = {}
        for (node, joint), sign in signs.items():
            # two keys with the same joint do not make it faster
            jogs.setdefault(node, {})[joint] = self._jog_rate * _unit(sign)
        last_preset, self._preset = self._preset, _only(presets)
        last_pose, self._pose = self._pose, _only(poses)
        return Commands(
            jogs,
            self._drive(drives),
            preset=_news(self._preset, last_preset),
            tool=self._lead(tools),
            pose=_news(self._pose, last_pose),
        )

    def stop(self, actions: Iterable[Action]) -> Commands:
        """Return zeros for everything that any of the actions could move."""
        everything: Dict[str, Dict[str, float]] = {}
        for action in actions:
            if isinstance(action, Jog):
                everything.setdefault(action.node, {}).update(dict.fromkeys(action.joints, 0.0))
        self._moving = {}
        self._driving = self._leading = False
        self._preset = self._pose = NO_NAME
        return Commands(
            everything, (STANDSTILL,), preset=(NO_NAME,), tool=((0.0,) * 6,), pose=(NO_NAME,)
        )

    def _drive(self, drives: List[Drive]) -> Tuple[Velocity, ...]:
        velocity = Velocity(
            self._linear * _unit(sum(drive.linear for drive in drives)),
            self._angular * _unit(sum(drive.angular for drive in drives)),
        )
        was_driving, self._driving = self._driving, velocity != STANDSTILL
        return (velocity,) if self._driving or was_driving else ()

    def _lead(self, tools: List[Tool]) -> Tuple[Tuple[float, ...], ...]:
        signs = [0] * len(self._tool_rates)
        for tool in tools:
            signs[tool.axis] += tool.sign
        twist = tuple(rate * _unit(sign) for rate, sign in zip(self._tool_rates, signs))
        was_leading, self._leading = self._leading, any(twist)
        return (twist,) if self._leading or was_leading else ()


def _only(names: List[str]) -> str:
    # two of them contradict each other as the two keys of a joint do
    return names[0] if len(names) == 1 else NO_NAME


def _news(name: str, last: str) -> Tuple[str, ...]:
    """Return what to say of a name after the last one: a stop once, a name again and again."""
    return () if name == last == NO_NAME else (name,)


def _unit(number: int) -> int:
    return (number > 0) - (number < 0)
