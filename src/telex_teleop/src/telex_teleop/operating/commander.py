"""Conversion of an operator's demands into commands for the teleoperation nodes."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Dict, Iterable, List, Mapping, Optional, Protocol, Tuple, Union

from telex_teleop.actions.grammar import Action, Drive, Jog, Preset, Side, Tool, ToPose, Zoom
from telex_teleop.tracks.track_drive import STANDSTILL, Velocity

NO_NAME = ""
"""In place of the name of a preset or of a pose: stop."""

Demands = Mapping[Action, float]
"""What is held, and how far: above 0, up to 1."""


class Rates(Protocol):
    """The rates that a full demand stands for; None where they are not known yet."""

    def joint(self, node: str, joint: str) -> Optional[float]:
        """Return the rate of a joint (rad/s or m/s)."""

    def drive(self) -> Optional[Velocity]:
        """Return the velocity of the tracks."""

    def tool_speed(self) -> Optional[Tuple[float, float]]:
        """Return the linear and the angular velocity of the tool (m/s, rad/s)."""


@dataclass(frozen=True)
class FixedRates:
    """The same rates for every robot, whose teleoperation nodes clamp them.

    Attributes
    ----------
    jog
        Of every joint (rad/s or m/s).
    linear, angular
        Of the tracks (m/s, rad/s).
    tool_linear, tool_angular
        Of the tool (m/s, rad/s).
    """

    jog: float
    linear: float
    angular: float
    tool_linear: float = 1.0
    tool_angular: float = 1.0

    def joint(self, node: str, joint: str) -> Optional[float]:
        """Return the rate of a joint (rad/s or m/s)."""
        del node, joint
        return self.jog

    def drive(self) -> Optional[Velocity]:
        """Return the velocity of the tracks."""
        return Velocity(self.linear, self.angular)

    def tool_speed(self) -> Optional[Tuple[float, float]]:
        """Return the linear and the angular velocity of the tool (m/s, rad/s)."""
        return self.tool_linear, self.tool_angular


@dataclass(frozen=True)
class PresetCommand:
    """A flipper preset by name, `NO_NAME` to stop, for the flippers of a side (empty: all)."""

    name: str
    side: str = ""


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
        Flipper preset; empty when there is nothing to say.
    tool
        Linear and angular velocity of the tool (m/s, rad/s), six numbers; empty likewise.
    pose
        Name of the pose that the arm shall move to, `NO_NAME` to stop; empty likewise.
    zoom
        How fast the camera shall zoom in, as a share of the full rate, 0 to stop; empty likewise.
    unknown
        What moves although its full rate is not known yet, and is therefore not in the commands.
    """

    jogs: Dict[str, Dict[str, float]]
    drive: Tuple[Velocity, ...]
    preset: Tuple[PresetCommand, ...] = ()
    tool: Tuple[Tuple[float, ...], ...] = ()
    pose: Tuple[str, ...] = ()
    zoom: Tuple[float, ...] = ()
    unknown: Tuple[str, ...] = field(default=(), compare=False)

    @property
    def moves(self) -> bool:
        """Whether anything of it asks for motion."""
        return (
            any(any(rates.values()) for rates in self.jogs.values())
            or any(velocity != STANDSTILL for velocity in self.drive)
            or any(preset.name != NO_NAME for preset in self.preset)
            or any(any(tool) for tool in self.tool)
            or any(name != NO_NAME for name in self.pose)
            or any(self.zoom)
        )

    def stopped(self) -> Commands:
        """Return the commands that end the motion which these ask for."""
        return Commands(
            jogs={node: dict.fromkeys(rates, 0.0) for node, rates in self.jogs.items()},
            drive=tuple(STANDSTILL for _ in self.drive),
            preset=tuple(PresetCommand(NO_NAME) for _ in self.preset),
            tool=tuple((0.0,) * len(tool) for tool in self.tool),
            pose=tuple(NO_NAME for _ in self.pose),
            zoom=tuple(0.0 for _ in self.zoom),
        )


class Commander:
    """Sums all that is held, and sends a zero to what was let go."""

    def __init__(self, rates: Rates) -> None:
        self._rates = rates
        self._moving: Dict[Tuple[str, str], None] = {}
        self._driving = False
        self._leading = False
        self._zooming = False
        self._preset = PresetCommand(NO_NAME)
        self._pose = NO_NAME

    @property
    def busy(self) -> bool:
        """Whether something was last told to move."""
        return (
            bool(self._moving or self._preset.name or self._pose)
            or self._driving
            or self._leading
            or self._zooming
        )

    def update(self, held: Union[Demands, Iterable[Action]]) -> Commands:
        """Return the commands for what is held; without saying how far, it is held fully."""
        demands = held if isinstance(held, Mapping) else dict.fromkeys(held, 1.0)
        side = _only([action.name for action in demands if isinstance(action, Side)])
        unknown: List[str] = []
        jogs = self._jog(demands, side, unknown)
        presets = [action.name for action in demands if isinstance(action, Preset)]
        name = _only(presets)
        preset = PresetCommand(name, side if name else "")
        last_preset, self._preset = self._preset, preset
        poses = [action.name for action in demands if isinstance(action, ToPose)]
        last_pose, self._pose = self._pose, _only(poses)
        return Commands(
            jogs,
            self._drive(demands, unknown),
            preset=(preset,) if name or last_preset.name else (),
            tool=self._lead(demands, unknown),
            pose=(self._pose,) if self._pose or last_pose else (),
            zoom=self._zoom(demands),
            unknown=tuple(unknown),
        )

    def stop(self, actions: Iterable[Action]) -> Commands:
        """Return zeros for everything that any of the actions could move."""
        everything: Dict[str, Dict[str, float]] = {}
        for action in actions:
            if isinstance(action, Jog):
                everything.setdefault(action.node, {}).update(dict.fromkeys(action.joints, 0.0))
        self._moving = {}
        self._driving = self._leading = self._zooming = False
        self._preset = PresetCommand(NO_NAME)
        self._pose = NO_NAME
        return Commands(
            everything,
            (STANDSTILL,),
            preset=(PresetCommand(NO_NAME),),
            tool=((0.0,) * 6,),
            pose=(NO_NAME,),
            zoom=(0.0,),
        )

    def _jog(self, demands: Demands, side: str, unknown: List[str]) -> Dict[str, Dict[str, float]]:
        shares: Dict[Tuple[str, str], float] = {}
        for action, share in demands.items():
            if not isinstance(action, Jog):
                continue
            for joint in action.joints:
                if side and action.node == "flipper" and side not in joint.split("_"):
                    continue
                axis = (action.node, joint)
                shares[axis] = shares.get(axis, 0.0) + share * action.sign
        rates: Dict[Tuple[str, str], float] = dict.fromkeys(self._moving, 0.0)
        for (node, joint), share in shares.items():
            full = self._rates.joint(node, joint)
            if full is not None:
                # two keys with the same joint do not make it faster
                rates[node, joint] = full * _unit(share)
            elif share != 0.0:
                unknown.append(joint)
        self._moving = {axis: None for axis, rate in rates.items() if rate != 0.0}
        jogs: Dict[str, Dict[str, float]] = {}
        for (node, joint), rate in rates.items():
            jogs.setdefault(node, {})[joint] = rate
        return jogs

    def _drive(self, demands: Demands, unknown: List[str]) -> Tuple[Velocity, ...]:
        linear = angular = 0.0
        for action, share in demands.items():
            if isinstance(action, Drive):
                linear += share * action.linear
                angular += share * action.angular
        full = self._rates.drive()
        if full is None and (linear or angular):
            unknown.append("tracks")
        velocity = STANDSTILL
        if full is not None:
            velocity = Velocity(full.linear * _unit(linear), full.angular * _unit(angular))
        was_driving, self._driving = self._driving, velocity != STANDSTILL
        return (velocity,) if self._driving or was_driving else ()

    def _lead(self, demands: Demands, unknown: List[str]) -> Tuple[Tuple[float, ...], ...]:
        shares = [0.0] * 6
        for action, share in demands.items():
            if isinstance(action, Tool):
                shares[action.axis] += share * action.sign
        full = self._rates.tool_speed()
        if full is None and any(shares):
            unknown.append("tool")
        linear, angular = full or (0.0, 0.0)
        rates = (linear,) * 3 + (angular,) * 3
        twist = tuple(rate * _unit(share) for rate, share in zip(rates, shares))
        was_leading, self._leading = self._leading, any(twist)
        return (twist,) if self._leading or was_leading else ()

    def _zoom(self, demands: Demands) -> Tuple[float, ...]:
        zooms = [share * a.sign for a, share in demands.items() if isinstance(a, Zoom)]
        rate = _unit(sum(zooms))
        was_zooming, self._zooming = self._zooming, rate != 0.0
        return (rate,) if self._zooming or was_zooming else ()


def _only(names: List[str]) -> str:
    # two of them contradict each other as the two keys of a joint do
    return names[0] if len(names) == 1 else NO_NAME


def _unit(share: float) -> float:
    return max(-1.0, min(1.0, share))
