"""An operator's station: commands to the teleoperation nodes, and their answers."""

from __future__ import annotations

import math
from typing import Dict, Tuple

import numpy as np

from telex_control.kinematics import Chain, make_pose

from .by_presets import PresetKeys
from .port import (
    Command,
    Drive,
    FlipperPreset,
    Grip,
    Jog,
    NamedPose,
    NotManagedError,
    Placement,
    TeleopPort,
    ToolPose,
    ToolTwist,
)
from .scripted_operator import Operator, RobotPose

FLIPPERS = tuple(
    f"{end}_{side}_flipper_joint" for end in ("front", "rear") for side in ("left", "right")
)
Course = Tuple[float, float, float]
"""x, y (m) and heading (rad) in the world of a course that a script drives along its own x."""

_TRACKS, _FLIPPERS, _ARM = "track_teleop", "flipper_teleop", "arm_teleop"
_PRESS_ANEW = "press it again"
"""What a node says that does not obey a command which outlived a stop."""
_LETTING_GO = 0.6
"""How long a key is let go of then (s)."""
_FLIPPER_RATE = 0.9  # rad/s
_FLIPPER_SETTLED = 0.02  # rad
_JOG_GAIN = 4.0  # 1/s
_JOGGED = 0.005  # rad, m


class Station(Operator):
    """Drives base, flippers, arm and gripper as a person at a console does.

    A command is held until it is released, as a key is; it is repeated at each look. What the base
    does is given in the frame of a course, so that a script for one along x serves anywhere.

    Attributes
    ----------
    notices : dict of str to str
        What the teleoperation nodes have said last.
    """

    def __init__(self, port: TeleopPort) -> None:
        super().__init__(port)
        self.port = port
        self.notices: Dict[str, str] = {}
        self._heard: Dict[str, int] = {}
        self._course: Course = (0.0, 0.0, 0.0)
        self._held: Dict[str, Command] = {}
        self._silent_until: Dict[str, float] = {}
        self._wanted: Dict[str, float] = {}
        self._chains: Dict[str, Chain] = {}
        self._began = port.observe().time
        self.look()
        port.repeat = self._repeat

    # --- what is seen ----------------------------------------------------------------------------

    def look(self) -> None:
        """See the robot as it is now, and hear what its nodes say."""
        super().look()
        self.time = self.now - self._began
        for node, notice in self._seen.notices.items():
            if notice.number == self._heard.get(node):
                continue
            self._heard[node], self.notices[node] = notice.number, notice.text
            if _PRESS_ANEW in notice.text:
                self.press_anew(node)

    def _pose_of(self, base: Placement) -> RobotPose:
        seen = super()._pose_of(base)
        x, y, yaw = self._course
        ahead, aside = seen.x - x, seen.y - y
        return RobotPose(
            ahead * math.cos(yaw) + aside * math.sin(yaw),
            aside * math.cos(yaw) - ahead * math.sin(yaw),
            seen.z,
            seen.roll,
            seen.rise,
            math.remainder(seen.yaw - yaw, 2.0 * math.pi),
        )

    def enter(self, course: Course) -> None:
        """From now on, measure the base along a course."""
        self._course = course
        self.look()

    @property
    def now(self) -> float:
        """Sim time of what is seen (s)."""
        return self._seen.time

    @property
    def grip(self) -> Grip:
        """What the gripper holds."""
        return self._seen.grip

    def base(self) -> np.ndarray:
        """Pose of base_link in the world, 4x4.

        Raises
        ------
        NotManagedError
            It is not known.
        """
        base = self._seen.base
        if base is None:
            raise NotManagedError("nothing is known of where the base is")
        return make_pose(base.position, base.orientation)

    def place_of(self, frame: str) -> np.ndarray:
        """Pose of one of the robot's frames in base_link by the measured joints, 4x4."""
        chain = self._chains.get(frame)
        if chain is None:
            chain = self._chains[frame] = Chain.from_urdf(self.port.urdf, "base_link", frame)
        joints = self._seen.positions
        return chain.forward([joints[name] for name in chain.joint_names])

    def object_pose(self, name: str) -> np.ndarray:
        """True pose of an object, or a link, in the world, 4x4; see `TeleopPort.object_pose`.

        Raises
        ------
        NotManagedError
            There is no such object.
        """
        pose = self.port.object_pose(name)
        if pose is None:
            raise NotManagedError(f"the scene has no object {name!r}")
        return pose

    def measured(self, joint: str) -> float:
        """Position of a joint by its full name (rad, m)."""
        return self._seen.positions[joint]

    # --- commands --------------------------------------------------------------------------------

    def hold(self, node: str, command: Command) -> None:
        """Repeat a command at each look from now on, in place of what is held for its node."""
        self._held[node] = command

    def release(self, *nodes: str) -> None:
        """Let go of what is held for some nodes; of everything where none is named."""
        for node in nodes or tuple(self._held):
            self._held.pop(node, None)
        if not nodes:
            self._wanted = {}

    def tick(self) -> None:
        """Repeat what is held, and let a moment pass; see `Operator.tick`."""
        if self._wanted:
            self._jog_flippers()
        self._send_held()
        super().tick()

    def _send_held(self) -> None:
        for node, command in list(self._held.items()):
            if not self._lets_go(node):
                self.port.send(command)

    def _repeat(self) -> None:
        self._send_held()
        self.port.send(self._speed())

    def press_anew(self, node: str) -> None:
        """Let go of what is held for a node, for a moment."""
        self._silent_until[node] = self.now + _LETTING_GO

    def _lets_go(self, node: str) -> bool:
        return self.now < self._silent_until.get(node, 0.0)

    def _speed(self) -> Drive:
        return Drive() if self._lets_go(_TRACKS) else super()._speed()

    def rest(self) -> None:
        """Let go of everything, until all has come to rest."""
        self.release()
        self.stop()
        self.wait(0.5)

    def mode(self, name: str) -> None:
        """Set the arm's mode, JOINT or CARTESIAN.

        Raises
        ------
        NotManagedError
        """
        self.port.set_mode(name)

    def hold_tool_pose(self, target: np.ndarray, frame: str = "base_link") -> None:
        """Lead the tool on a straight line to a pose (4x4) from now on."""
        self.hold(_ARM, ToolPose(target, frame))

    def hold_tool_twist(
        self,
        linear: Tuple[float, float, float] = (0.0, 0.0, 0.0),
        angular: Tuple[float, float, float] = (0.0, 0.0, 0.0),
        frame: str = "tool_link",
    ) -> None:
        """Lead the tool at a velocity (m/s, rad/s) along a frame's axes from now on."""
        self.hold(_ARM, ToolTwist(linear, angular, frame))

    def hold_named_pose(self, name: str) -> None:
        """Move the arm's joints to a named pose from now on."""
        self.hold(_ARM, NamedPose(name))

    def release_arm(self) -> None:
        """Let go of what leads the arm."""
        self.release(_ARM)

    def jog(self, node: str, **rates: float) -> None:
        """Move joints, by their full names, at rates (rad/s, m/s) from now on."""
        self.hold(node, Jog(node, rates))

    def jog_to(
        self, node: str, joint: str, position: float, rate: float = 0.3, timeout: float = 20.0
    ) -> None:
        """Jog a joint, by its full name, to a position (rad, m), by eye, and let go of it.

        Parameters
        ----------
        rate : float
            At most (rad/s, m/s).

        Raises
        ------
        NotManagedError
            It is not reached.
        """

        def left() -> float:
            return position - self.measured(joint)

        self.until(
            lambda: abs(left()) < _JOGGED,
            timeout,
            f"{joint} at {position:.3f}",
            lambda: self.jog(node, **{joint: max(-rate, min(rate, _JOG_GAIN * left()))}),
        )
        self.release(node)

    def hold_preset(self, preset: str) -> None:
        """Hold a flipper preset's key from now on; empty: let go of it."""
        if preset:
            self._wanted = {}
            self.hold(_FLIPPERS, FlipperPreset(preset))
        else:
            self.release(_FLIPPERS)

    def move(self, **positions: float) -> None:
        """Jog flippers, named without ``_joint``, to angles (rad) from now on, by eye.

        Raises
        ------
        NotManagedError
            A joint is no flipper: the arm has its own commands.
        """
        for name, angle in positions.items():
            joint = f"{name}_joint"
            if joint not in FLIPPERS:
                raise NotManagedError(f"{name} is none of the flippers")
            self._wanted[joint] = angle
        self.hold_preset("")

    def _jog_flippers(self) -> None:
        rates = {}
        for joint, angle in self._wanted.items():
            error = angle - self.measured(joint)
            if abs(error) > _FLIPPER_SETTLED:
                rates[joint] = max(-_FLIPPER_RATE, min(_FLIPPER_RATE, _JOG_GAIN * error))
        if rates:
            self.jog(_FLIPPERS, **rates)
        else:
            self.release(_FLIPPERS)


class Keys(PresetKeys):
    """The preset keys of a station; what is held is repeated by its looks."""

    def __init__(self, station: Station) -> None:
        super().__init__(station)
        self._station = station

    def hold(self, preset: str) -> None:
        """Hold a preset's key from now on; empty: let go of it."""
        self._station.hold_preset(preset)

    def look(self) -> None:
        """Do nothing: the station repeats the key."""
