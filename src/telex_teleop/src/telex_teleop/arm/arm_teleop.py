"""Core of the arm's teleoperation: its joints one by one, its tool, or the way to a named pose.

Free of ROS, not thread-safe: whoever owns it serialises the calls.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Dict, FrozenSet, List, Mapping, Optional, Sequence, Set, Tuple

import numpy as np

from telex_teleop.arm.base_pose import BasePose
from telex_teleop.arm.path_motion import PathMotion
from telex_teleop.arm.proximity import Clearance, Nearness, ProximityGuard
from telex_teleop.arm.tool_command import Frame, ToolCommand, TwistCommand
from telex_teleop.arm.tool_motion import ToolMotion
from telex_teleop.joints.joint_teleop import JOINT_MODE, JointTeleop
from telex_teleop.motion.axis import AxisSettings
from telex_teleop.motion.joint_jog import InvalidCommand, JogCommand
from telex_teleop.motion.speed import SpeedScale
from telex_teleop.motion.stream import Clocks, CommandStream
from telex_teleop.motion.teleop_core import NEEDS_NEW_PRESS

CARTESIAN_MODE = "CARTESIAN"

# Time (s) for which a refused command is reported; a display reads ten statuses a second.
REFUSAL_SHOWN_FOR = 1.0
# A one-shot increment is given up when the guard leaves less of its speed: nobody holds a key
# for it, so it must not go on when the way becomes free.
DISPLACEMENT_SHARE = 0.02
# A tool that keeps its place is told to be off it from so far on (m): further than joints lag.
OFF_PLACE = 0.02
# A base slower than this (m/s, rad/s) only sways.
STANDING_SPEED = 0.02


class ModeError(ValueError):
    """A mode or an option cannot be set; the text says why."""


@dataclass(frozen=True)
class Carrier:
    """The joints that carry the tool, base to tip, and the poses that have a name.

    Attributes
    ----------
    joints
        Names; empty where the robot has no arm that could be led by its tool.
    poses
        Name of a pose to its joint positions, in the order of `joints` (rad or m).
    lacking
        Why there is no such arm; empty where there is.
    """

    joints: Tuple[str, ...] = ()
    poses: Mapping[str, Sequence[float]] = field(default_factory=dict)
    lacking: str = ""


class ArmTeleop(JointTeleop):
    """Moves the arm in one of three ways at a time; the newest command wins.

    Whatever moved before comes to rest on its ramp first, so nothing jumps when the ways change.

    Parameters
    ----------
    axes
        Joint name to the bounds of its motion.
    command_timeout, longest_step, speed
        See `JointTeleop`.
    base
        Where the base stands.
    """

    def __init__(
        self,
        axes: Mapping[str, AxisSettings],
        carrier: Carrier,
        command_timeout: float,
        longest_step: float,
        speed: SpeedScale,
        guard: ProximityGuard,
        base: BasePose,
    ) -> None:
        self._tool_stream: CommandStream[ToolCommand] = CommandStream(command_timeout)
        self._pose_stream: CommandStream[str] = CommandStream(command_timeout)
        self._tool: Optional[ToolMotion] = None
        self._path = PathMotion(carrier.joints, [axes[joint].motion for joint in carrier.joints])
        self._carrier = carrier
        self._poses = {name: np.array(pose, float) for name, pose in carrier.poses.items()}
        self._refused: Tuple[float, str] = (-math.inf, "")
        self._nearness: Optional[Nearness] = None
        self._held_back = ""
        self._reached = ""
        self._unprepared = carrier.lacking
        self.guard = guard
        self.base = base
        self.mode = JOINT_MODE
        super().__init__(axes, command_timeout, longest_step, speed)

    # ------------------------------------------------------------ modes and options

    @property
    def carrier(self) -> Carrier:
        """The joints that carry the tool."""
        return self._carrier

    @property
    def tool(self) -> Optional[ToolMotion]:
        """What leads the tool, None while that is not ready."""
        return self._tool

    def prepare(self, message: str) -> None:
        """Say why the tool cannot be led yet."""
        self._unprepared = message

    def attach(self, tool: ToolMotion) -> None:
        """Take what leads the tool; CARTESIAN mode can be set from now on."""
        self._tool = tool
        self._unprepared = ""

    def set_mode(self, mode: str) -> None:
        """Set JOINT or CARTESIAN mode; what moves comes to rest.

        Raises
        ------
        ModeError
            When there is no such mode, or it cannot be had.
        """
        if mode not in (JOINT_MODE, CARTESIAN_MODE):
            raise ModeError(
                f"mode {mode[:80]!r} is unknown; must be {JOINT_MODE} or {CARTESIAN_MODE}"
            )
        if mode == CARTESIAN_MODE and self._tool is None:
            raise ModeError(f"{CARTESIAN_MODE}: {self._unprepared}; the mode stays {self.mode}")
        if mode == self.mode:
            return
        self.mode = mode
        self._yield_axes()
        self._tool_stream.discard()
        self._pose_stream.discard()
        if self._tool is not None:
            self._tool.hold(False)

    def hold_tool(self, active: bool) -> None:
        """Let the tool keep its place in the world while the base moves, or no longer.

        Raises
        ------
        ModeError
            When it cannot be done now.
        """
        if active:
            if self.mode != CARTESIAN_MODE or self._tool is None:
                raise ModeError(f"the tool can be held in {CARTESIAN_MODE} mode only; set it first")
            if self._e_stop:
                raise ModeError("the e-stop is active; release it first")
            if self.base_now() is None:
                raise ModeError("the pose of the base in the world is not known")
        if self._tool is not None:
            self._tool.hold(active)

    # ------------------------------------------------------------ commands

    @property
    def idle(self) -> bool:
        """Whether the last joint state left nothing to move, and no place is to be kept."""
        return super().idle and not (self._tool is not None and self._tool.holding)

    def receive(self, jog: JogCommand, wall: float, caller: str = "") -> FrozenSet[str]:
        """Take a jog; see `JointTeleop.receive`.

        Raises
        ------
        InvalidCommand
            Also when it would move a joint that the tool's motion moves in this mode.
        """
        wanted = {**jog.velocities, **jog.displacements}
        moving = {name for name, value in wanted.items() if value != 0.0}
        led = [joint for joint in self._carrier.joints if joint in moving]
        if led and self.mode == CARTESIAN_MODE:
            raise self._refuse(
                wall,
                f"joint_names: {', '.join(led)} carry the tool, and the mode is {CARTESIAN_MODE}; "
                f"set {JOINT_MODE} to jog them",
            )
        obeying = super().receive(jog, wall, caller)
        if obeying.intersection(self._carrier.joints):
            self._tool_stream.discard()
            self._pose_stream.discard()
        return obeying

    def receive_tool(self, command: ToolCommand, wall: float, caller: str = "") -> bool:
        """Take a twist or a pose of the tool; return whether it is obeyed and moves something.

        Raises
        ------
        InvalidCommand
            When the mode is not CARTESIAN, or nothing tells where the world is.
        """
        if isinstance(command, TwistCommand) and not command.moves:
            self._tool_stream.end(caller)
            return False
        if self.mode != CARTESIAN_MODE:
            raise self._refuse(
                wall, f"the mode is {self.mode}; set {CARTESIAN_MODE} to move the tool"
            )
        if command.frame is Frame.WORLD and self.base_now() is None:
            raise self._refuse(
                wall, "header.frame_id: the pose of the base in the world is not known"
            )
        if self._ticks.now is None:
            return False
        obeyed = self._tool_stream.receive(command, self._arrival(wall), caller)
        if obeyed:
            self._yield_axes()
            self._pose_stream.discard()
        return obeyed

    def receive_pose_name(self, name: str, wall: float, caller: str = "") -> bool:
        """Take the name of a pose to move to, empty to stop; return whether it is obeyed.

        Raises
        ------
        InvalidCommand
            When no pose has the name.
        """
        if not name:
            self._pose_stream.end(caller)
            return False
        if name not in self._poses:
            known = ", ".join(self._poses) or "none"
            raise self._refuse(wall, f"pose {name[:80]!r} is unknown; known are {known}")
        if self._ticks.now is None:
            return False
        obeyed = self._pose_stream.receive(name, self._arrival(wall), caller)
        if obeyed:
            self._yield_axes()
            self._tool_stream.discard()
            if self._tool is not None:
                self._tool.hold(False)
        return obeyed

    def refuse(self, wall: float, reason: str) -> None:
        """Take note that a command was refused before it came here."""
        self._refused = (wall, reason)

    def _refuse(self, wall: float, reason: str) -> InvalidCommand:
        self.refuse(wall, reason)
        return InvalidCommand(reason)

    def _yield_axes(self) -> None:
        for joint in self._carrier.joints:
            self.axes[joint].yield_to_another()

    def base_now(self) -> Optional[np.ndarray]:
        """Return the base's pose in the world (4x4), None where it is not known."""
        return None if self._ticks.now is None else self.base.at(self._ticks.now)

    def carrier_positions(self) -> Optional[np.ndarray]:
        """Return where the joints that carry the tool were measured last, None before that."""
        positions = [self.axes[joint].position for joint in self._carrier.joints]
        if not positions or any(position is None for position in positions):
            return None
        return np.array(positions)

    # ------------------------------------------------------------ motion

    def _references(
        self, dt: float, now: Clocks, positions: Mapping[str, float]
    ) -> Dict[str, float]:
        joints = self._carrier.joints
        self._nearness = None
        self._held_back = self._reached = ""
        led: Optional[np.ndarray] = None
        if joints:
            measured = np.array([positions[joint] for joint in joints])
            start = self._start(positions, measured)
            led = self._lead_tool(dt, now, start, measured)
            if led is None:
                led = self._follow_path(dt, now, start, measured)
        references = self._jogged(dt, now, positions, led is not None)
        if led is not None:
            for joint, reference in zip(joints, led.tolist()):
                references[joint] = reference
                # a later jog of this joint goes on from here
                self.axes[joint].generator.rest_at(reference)
        return references

    def _start(self, positions: Mapping[str, float], measured: np.ndarray) -> np.ndarray:
        """Return where a motion of all joints together begins (rad or m).

        At their references, so that what sags a little does not creep; but when one of them was
        moved by somebody else, the references of the others say nothing any more.
        """
        generators = [self.axes[joint].generator for joint in self._carrier.joints]
        if any(generator.reference is None for generator in generators):
            return measured
        return np.array(
            [
                generator.start_from(positions[joint])
                for joint, generator in zip(self._carrier.joints, generators)
            ]
        )

    def _jogging(self) -> bool:
        return any(self.axes[joint].generator.moving for joint in self._carrier.joints)

    def _jogged(
        self, dt: float, now: Clocks, positions: Mapping[str, float], led: bool
    ) -> Dict[str, float]:
        """Move the joints that are jogged one by one."""
        scale = self.speed.value
        rates = {
            name: rate * scale
            for name, axis in self.axes.items()
            if (rate := axis.wanted_rate(now)) != 0.0
        }
        shares: Mapping[str, float] = {}
        if rates:
            names = list(positions)
            held = {name: self.axes[name].generator.start_from(positions[name]) for name in rates}
            clearance = self._clearance(now, names, np.array(list({**positions, **held}.values())))
            found, near = clearance.joint_shares(np.array([rates.get(name, 0.0) for name in names]))
            shares = dict(zip(names, found.tolist()))
            self._nearness = near or self._nearness
        moved: Dict[str, float] = {}
        for name, axis in self.axes.items():
            share = shares.get(name, 1.0)
            if share < DISPLACEMENT_SHARE and axis.generator.displacing:
                axis.generator.stop()
            reference = axis.update(
                dt,
                now,
                positions[name],
                scale * max(share, 1e-6),
                blocked=led and name in self._carrier.joints,
            )
            if reference is not None:
                moved[name] = reference
        return moved

    def _lead_tool(
        self, dt: float, now: Clocks, start: np.ndarray, measured: np.ndarray
    ) -> Optional[np.ndarray]:
        tool = self._tool
        if tool is None:
            return None
        free = not (self._jogging() or self._path.moving)
        command = self._tool_stream.command(now) if free else None
        if not (tool.moving or free):
            return None

        clearance = None
        if command is not None or tool.moving or tool.holding:
            ahead = tool.solution if tool.moving else start
            clearance = self._clearance(now, self._carrier.joints, ahead)
        references = tool.update(
            dt,
            command,
            start,
            measured,
            self.base.at(now.sim, tool.hold_ahead),
            self.speed.value,
            clearance,
        )
        self._nearness = tool.nearness
        return references

    def _clearance(self, now: Clocks, joints: Sequence[str], references: np.ndarray) -> Clearance:
        return self.guard.clearance(now.sim, joints, references, self.base.twist(now.sim))

    def _follow_path(
        self, dt: float, now: Clocks, start: np.ndarray, measured: np.ndarray
    ) -> Optional[np.ndarray]:
        path = self._path
        name = self._pose_stream.command(now)
        if name and not self._jogging():
            path.begin(name, start, self._poses[name])
        if not path.moving:
            return None
        scale = self.speed.value
        clearance = self._clearance(now, self._carrier.joints, start)
        share, self._nearness = clearance.share(path.wanted_rates(scale))
        wanted = scale * share if name == path.pose else 0.0
        references_now, self._held_back = path.update(dt, measured, wanted)
        if references_now is None and name:
            self._reached = name
        return references_now

    def _inhibit(self) -> None:
        super()._inhibit()
        self._tool_stream.inhibit(self._inhibited)
        self._pose_stream.inhibit(self._inhibited)
        if self._inhibited:
            self._drop_motion()

    def _drop(self) -> None:
        super()._drop()
        self._tool_stream.latch()
        self._pose_stream.latch()
        self._drop_motion()
        self.base.forget()
        self.guard.forget()

    def _drop_motion(self) -> None:
        self._path.drop()
        if self._tool is not None:
            self._tool.drop()

    # ------------------------------------------------------------ what a display shows

    def _commanders(self, now: Clocks) -> Set[str]:
        commanders = super()._commanders(now)
        if self._tool_stream.command(now) is not None:
            commanders.add(self._tool_stream.obeyed)
        if self._pose_stream.command(now) is not None:
            commanders.add(self._pose_stream.obeyed)
        return commanders

    def _refusal(self, wall: float) -> str:
        if any(stream.waiting(wall) for stream in (self._tool_stream, self._pose_stream)):
            return NEEDS_NEW_PRESS
        refused, reason = self._refused
        return super()._refusal(wall) or (reason if wall - refused < REFUSAL_SHOWN_FOR else "")

    def _notice(self, now: Clocks) -> str:
        parts: List[str] = []
        if self.slowdown:
            parts.append(self.slowdown)
        if self._held_back:
            parts.append(f"something holds {self._held_back} back")
        if self._reached:
            parts.append(f"in pose {self._reached}")
        if self._tool is not None and self._tool.holding:
            parts.append(self._held_place(self._tool, now))
        elif not self.slowdown:
            drives = self._drives_against(now)
            if drives:
                parts.append(drives)
        if self._unprepared:
            parts.append(f"{CARTESIAN_MODE} mode: {self._unprepared}")
        if self.guard.silent(now.sim):
            parts.append("no proximity guard: nothing tells what is near the arm")
        return "; ".join(parts)

    def _held_place(self, tool: ToolMotion, now: Clocks) -> str:
        if self.base.at(now.sim) is None:
            return "the tool does not keep its place: the pose of the base in the world is unknown"
        off = tool.off_place
        if off < OFF_PLACE:
            return "the tool keeps its place in the world"
        return f"the tool is {1000.0 * off:.0f} mm from the place that it is to keep"

    def _drives_against(self, now: Clocks) -> str:
        """Say what the base drives the arm against; it is not this node that could stop it."""
        twist = self.base.twist(now.sim)
        if twist is None or float(np.abs(twist).max()) < STANDING_SPEED:
            return ""
        near = self.guard.approach(now.sim, twist)
        return "" if near is None else f"the base drives: {near.where}"

    @property
    def share(self) -> float:
        """Share of the commanded speed that is left, 0 to 1."""
        near = 1.0 if self._nearness is None else self._nearness.factor
        slow = self._tool.slowdown if self._tool is not None else None
        return near if slow is None else min(near, slow.share)

    @property
    def slowdown(self) -> str:
        """Why the arm is slower than commanded, empty where it is not."""
        reasons: List[str] = []
        if self._nearness is not None:
            reasons.append(str(self._nearness))
        if self._tool is not None and self._tool.slowdown is not None:
            reasons.append(str(self._tool.slowdown))
        return "; ".join(reasons)
