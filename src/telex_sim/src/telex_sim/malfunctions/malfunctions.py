"""Malfunctions of one robot in a simulation; only the simulation's thread may use them."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, Callable, Dict, List, Mapping, NamedTuple, Optional, Tuple

from telex_control.common.params import ConfigError
from telex_control.common.stateful import Stateful

from ..robot.drives import WHOLE, Impairment
from ..tracks.belt_faults import SOUND, BeltFault
from . import kinds
from .battery import DRIVES, Battery, BatteryConfig, Charge, Reach, charge_of
from .kinds import Parts, Possible

if TYPE_CHECKING:
    from ..robot.robot import Robot


class Active(NamedTuple):
    """Something that does not work.

    Attributes
    ----------
    value : float
        Severity, in the kind's unit.
    announced : bool
        Whether the operator is told.
    since : float
        Sim time (s).
    """

    what: str
    group: str
    kind: str
    value: float
    announced: bool
    since: float


class Malfunctions(Stateful):
    """What of a robot does not work, and what that does to its hardware.

    What fails beyond the simulator (pictures, lamps, keys) is only noted: who simulates that hears
    of it. A reset ends all; a bookmark has those that there were.

    Attributes
    ----------
    active : tuple of Active
        Oldest first.
    changes : int
        How often that, or what gets power, has changed.
    battery : Battery, optional
        One that runs down. Where it is None, there is nothing to compute in a step.
    has_battery : bool
        Whether the robot has one at all.
    lamp_levels : float
        Sum of the levels at which the lamps are switched on.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._lamps: Tuple[str, ...] = ()
        self._cameras: Tuple[str, ...] = ()
        self._unpowered: Tuple[str, ...] = ()
        self._impairments: Dict[str, Impairment] = {}
        self._faults: Dict[str, BeltFault] = {}
        self.active: Tuple[Active, ...] = ()
        self.changes = 0
        self.battery: Optional[Battery] = None
        self._reach: Optional[Reach] = None
        self.has_battery = robot.config.battery is not None
        self.lamp_levels = 0.0

    def equip(self, cameras: Any, lamps: Any) -> None:
        """Take the robot's cameras and lamps over, as the node ``cameras`` has them.

        Parameters
        ----------
        cameras, lamps : mapping
            Their parameters by name; those whose ``frame`` the robot has count.
        """
        found = self._fitted(lamps), self._fitted(cameras)
        if found != (self._lamps, self._cameras):
            self._lamps, self._cameras = found
            self.changes += 1

    def _fitted(self, described: Any) -> Tuple[str, ...]:
        links = set(self._robot.body.link_names())
        if not isinstance(described, Mapping):
            return ()
        return tuple(
            name
            for name, each in sorted(described.items())
            if isinstance(each, Mapping)
            and isinstance(each.get("frame"), str)
            and each["frame"] in links
        )

    @property
    def parts(self) -> Parts:
        """Names of what can fail."""
        robot = self._robot
        return Parts(
            joints=tuple(robot.hw.moved_joints()),
            flippers=robot.flippers(),
            belts=tuple(f"{name}_belt" for name in robot.tracks.names),
            gripper=bool(robot.finger_joints()),
            imus=tuple(imu.handle.name for imu in robot.hw.imus),
            lamps=self._lamps,
            cameras=self._cameras,
            battery=self.has_battery,
        )

    def possible(self) -> List[Possible]:
        """Return all that can fail."""
        return list(self.parts.possible())

    @property
    def unpowered(self) -> Tuple[str, ...]:
        """What the empty battery feeds no longer."""
        return self._unpowered

    @property
    def _fed_by(self) -> BatteryConfig:
        config = self._robot.config.battery
        assert config is not None  # whoever asks has looked at has_battery, or at the parts
        return config

    def charge(self) -> Charge:
        """Return what the robot's battery tells; one that does not run down is full."""
        config, battery = self._fed_by, self.battery
        if battery is None:
            return charge_of(config, 1.0, self._power())
        return charge_of(config, battery.share, battery.power)

    def reach(self, time: float) -> float:
        """Return how far (m) the charge lasts at a time (s); to be asked about once a second."""
        if self._reach is None:
            self._reach = Reach(self._fed_by)
        self._reach.be_at(self._robot.body.base_pose()[0], self._power(), time)
        return self._reach.of(self.charge().share)

    def begin(self, what: str, kind: str, value: float, announced: bool, time: float) -> Active:
        """Let something fail at `time` (s); what fails so already gets another severity.

        Raises
        ------
        ConfigError
            It is not there, or cannot fail so, or not so much; nothing has changed.
        """
        kinds.require_finite(value)
        found = self.parts.find(what, kind)
        severity = found.kind.severity(value)
        made = Active(found.what, found.group, kind, severity, announced, time)
        if found.group == kinds.BATTERY:
            self.battery = Battery(self._fed_by, severity)
            self._repower()
        kept = [each for each in self.active if (each.what, each.kind) != (made.what, kind)]
        replaced = len(kept) < len(self.active)
        self._set((*kept, made))
        if replaced and made.group in _MOVING:
            self._robot.begin_anew()  # for it may have become less
        return made

    def end(self, what: str = "", kind: str = "") -> Tuple[Active, ...]:
        """End what fails, of a part alone, in a way alone, or all.

        Joints that were concerned stay where they are, until they are commanded anew.

        Raises
        ------
        ConfigError
            Nothing fails so.
        """
        named = (what, f"{what}_joint")
        gone = tuple(
            each
            for each in self.active
            if (not what or each.what in named) and kind in ("", each.kind)
        )
        if (what or kind) and not gone:
            there = ", ".join(f"{each.what} {each.kind}" for each in self.active) or "nothing"
            raise ConfigError(
                f"'{f'{what} {kind}'.strip()[:120]}' is not active; there is: {there}"
            )
        if any(each.group == kinds.BATTERY for each in gone):
            self.battery = None
            self._repower()
        self._set(tuple(each for each in self.active if each not in gone))
        if any(each.group in _MOVING for each in gone):
            self._robot.begin_anew()
        return gone

    def forget(self) -> None:
        """End all, before the robot is put to its start."""
        if self.active:
            self.changes += 1
        self.active, self.battery, self._reach, self._unpowered = (), None, None, ()
        self._impairments, self._faults = {}, {}
        self._robot.hw.mend()

    def run(self, period: float) -> None:
        """Let time pass (s) for what runs down."""
        if self.battery is not None:
            self.battery.drain(self._power(), period)
            self._repower()

    def _power(self) -> float:
        """Power that the robot takes (W)."""
        config, robot = self._fed_by, self._robot
        return (
            config.base_power
            + config.lamp_power * self.lamp_levels
            + config.drive_power(robot.hw.drives())
        )

    def _repower(self) -> None:
        unpowered = () if self.battery is None else self.battery.unpowered
        if unpowered != self._unpowered:
            self._unpowered = unpowered
            self._robot.hw.set_power(DRIVES not in unpowered)
            self.changes += 1

    def _set(self, active: Tuple[Active, ...]) -> None:
        """Have what fails now, and nothing else."""
        if active != self.active:
            self.active = active
            self.changes += 1
        hw, tracks = self._robot.hw, self._robot.tracks
        before, self._impairments = self._impairments, self._joints()
        _tell_changes(before, self._impairments, WHOLE, hw.impair)
        broken, self._faults = self._faults, self._belts()
        _tell_changes(broken, self._faults, SOUND, tracks.damage)
        biases = {each.what: each.value for each in active if each.group == kinds.IMU}
        for imu in hw.imus:
            imu.bias = biases.get(imu.handle.name, 0.0)

    def _joints(self) -> Dict[str, Impairment]:
        made: Dict[str, Impairment] = {}
        for each in self.active:
            if each.group == kinds.JOINT:
                made[each.what] = _impaired(made.get(each.what, WHOLE), each)
            elif each.group == kinds.GRIPPER:
                for joint in self._robot.finger_joints():
                    finger = made.get(joint, WHOLE)
                    made[joint] = replace(finger, share=finger.share * (1.0 - each.value))
        return made

    def _belts(self) -> Dict[str, BeltFault]:
        made: Dict[str, BeltFault] = {}
        for each in self.active:
            if each.group == kinds.BELT:
                name = each.what[: -len("_belt")]
                made[name] = _damaged(made.get(name, SOUND), each)
        return made

    def save_state(self) -> Any:
        """Return the present state; see `Stateful.save_state`."""
        battery, reach = (
            None if part is None else part.save_state() for part in (self.battery, self._reach)
        )
        return self.active, battery, reach

    def restore_state(self, saved: Any, elapsed: float) -> None:
        """Take a state up again; see `Stateful.restore_state`."""
        active, battery, reach = saved
        self.battery = self._reach = None
        if battery is not None:
            self.battery = Battery(self._fed_by, 1.0)
            self.battery.restore_state(battery, elapsed)
        if reach is not None:
            self._reach = Reach(self._fed_by)
            self._reach.restore_state(reach, elapsed)
        self._repower()
        self._set(tuple(each._replace(since=each.since + elapsed) for each in active))


_MOVING = (kinds.JOINT, kinds.BELT, kinds.GRIPPER, kinds.BATTERY)
"""Groups whose drives would move at once to where they were told to be meanwhile."""


def _impaired(before: Impairment, each: Active) -> Impairment:
    if each.kind == kinds.WEAK.name:
        return replace(before, share=before.share * each.value)
    if each.kind == kinds.SLIPPING.name:
        return replace(before, slip=each.value)
    if each.kind == kinds.STUCK.name:
        return replace(before, jammed=True)
    return replace(before, limp=True)


def _damaged(before: BeltFault, each: Active) -> BeltFault:
    if each.kind == kinds.WEAK.name:
        return before._replace(share=each.value)
    if each.kind == kinds.STUCK.name:
        return before._replace(jammed=True)
    if each.kind == kinds.LIMP.name:
        return before._replace(limp=True)
    return before._replace(thrown=True)


def _tell_changes(
    before: Mapping[str, Any], now: Mapping[str, Any], sound: Any, tell: Callable[[str, Any], None]
) -> None:
    for name in {**before, **now}:
        state = now.get(name, sound)
        if state != before.get(name, sound):
            tell(name, state)
