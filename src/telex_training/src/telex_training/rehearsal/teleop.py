"""A port to a robot in the same process, behind the cores of its teleoperation nodes."""

from __future__ import annotations

import math
from typing import Callable, Dict, Optional, Set

import numpy as np

from telex_control.kinematics import make_pose
from telex_sim.offline.robot import OfflineRobot
from telex_teleop.arm.arm_settings import ArmTeleopSettings
from telex_teleop.arm.arm_teleop import ArmTeleop, ModeError
from telex_teleop.arm.proximity import ProximityPair, ProximityState
from telex_teleop.arm.tool_command import PoseCommand, TwistCommand
from telex_teleop.cores import arm_core, flipper_core, gripper_core, tool_motion
from telex_teleop.joints.joint_settings import limits_of_present
from telex_teleop.joints.joint_teleop import JointTeleop
from telex_teleop.motion.idle_rest import LONGEST_REST
from telex_teleop.motion.joint_jog import InvalidCommand, parse_joint_jog
from telex_teleop.tracks.track_drive import TrackDrive, Velocity

from ..operators.port import (
    CameraView,
    Command,
    Drive,
    FlipperPreset,
    Grip,
    Jog,
    NamedPose,
    Notice,
    NotManagedError,
    Observation,
    TeleopPort,
    ToolPose,
    ToolTwist,
)
from .controllers import placement
from .node_settings import ARM, FLIPPERS, GRIPPER, TRACKS, shipped_settings

_LISTENING = 3.0
"""Time in command timeouts after which a core that has just started obeys."""


class OfflineTeleop(TeleopPort):
    """A robot with the teleoperation nodes' cores and their shipped parameters.

    The cores hear of joints, base and what is near the arm as often as the nodes do, which look
    seldom while there is nothing to move, and their watchdogs go by sim time. No pictures are
    drawn: there is no camera to look through.

    Parameters
    ----------
    advance : callable, optional
        Lets so much sim time (s) pass; without it, the robot's simulation does.
    on_answer : callable, optional
        Takes a question's name and the operator's answer, where somebody asks.
    """

    def __init__(
        self,
        robot: OfflineRobot,
        advance: Optional[Callable[[float], None]] = None,
        on_answer: Optional[Callable[[str, str], None]] = None,
    ) -> None:
        super().__init__()
        self.urdf = robot.urdf
        self._robot = robot
        self._advance = advance or robot.run
        self._on_answer = on_answer
        self._now = robot.simulation.time
        self._notices: Dict[str, Notice] = {}
        self._links = frozenset(robot.robot.body.link_names())
        tracks, arm, flippers, gripper = shipped_settings()
        self._arm = self._made_arm(arm)
        self._joints: Dict[str, JointTeleop] = {ARM: self._arm}
        self._flippers = flipper_core(flippers, limits_of_present(flippers, robot.urdf)[0])
        self._joints[FLIPPERS] = self._flippers
        self._joints[GRIPPER] = gripper_core(gripper, limits_of_present(gripper, robot.urdf)[0])
        self._tracks = TrackDrive(tracks, tracks.speed_scale())
        self._status = Due(tracks.status_rate)
        self._nearness = Due(robot.simulation.config.proximity.rate)
        self._idle_nearness = Due(1.5 / self._nearness_age)
        self._looks = {name: Due(1.0 / LONGEST_REST) for name in self._joints}
        self._woken: Set[str] = set()
        self._base_pose = Due(robot.simulation.config.publish.base_pose_rate)
        robot.each_joint_state.append(self._on_joint_state)
        self._advance(_LISTENING * tracks.command_timeout)

    def _made_arm(self, settings: ArmTeleopSettings) -> ArmTeleop:
        limits, _ = limits_of_present(settings, self.urdf)
        made = arm_core(settings, limits, self.urdf)
        if made.chain is not None:
            made.core.attach(tool_motion(made.core, made.chain, settings.cartesian))
        self._frames = settings.frames.names()
        self._nearness_age = settings.proximity.max_age
        return made.core

    # --- the cores' pulse ------------------------------------------------------------------------

    def _on_joint_state(self, stamp: float) -> None:
        robot, self._now = self._robot, stamp
        if self._base_pose.due(stamp):
            self._arm.base.take(stamp, make_pose(*robot.base_pose()))
        nearness = self._nearness if self._active(ARM) else self._idle_nearness
        if nearness.due(stamp):
            self._arm.guard.take(self._near(stamp))
        for name, core in self._joints.items():
            if self._looks[name].due(stamp) or self._active(name):
                positions = {joint: robot.positions[joint] for joint in core.measured_joints}
                robot.move(core.update(stamp, stamp, positions))
        self._woken.clear()
        velocity = self._tracks.update(stamp, stamp)
        if velocity is not None:
            robot.drive(velocity.linear, velocity.angular)
        if self._status.due(stamp):
            for name, core in self._joints.items():
                state = core.state(stamp)
                self._say(name, state.message or state.notice)
            self._say(TRACKS, self._tracks.state(stamp).message)

    def _active(self, name: str) -> bool:
        """Whether a node has something to move; an idle one looks seldom, as the nodes do."""
        return name in self._woken or not self._joints[name].idle

    def _say(self, node: str, text: str) -> None:
        last = self._notices.get(node)
        self._notices[node] = Notice(1 if last is None else last.number + 1, text)

    def _near(self, stamp: float) -> ProximityState:
        near, joints = self._robot.near(), self._robot.arm_joints()
        pairs = []
        for pair in near.pairs:
            place = pair.place
            by_base = (*place.normal, *np.cross(place.point, place.normal).tolist())
            pairs.append(
                ProximityPair(
                    link=pair.link,
                    other=pair.other,
                    touchable=pair.touchable,
                    distance=place.distance,
                    gradient=dict(zip(joints, place.gradient)),
                    base_gradient=(0.0,) * 6 if pair.other in self._links else by_base,
                )
            )
        return ProximityState(stamp, dict(zip(joints, near.positions)), tuple(pairs))

    def reset(self) -> None:
        """Put robot and scene back to where they began, and have the cores forget all motion."""
        self._robot.simulation.reset()
        for core in (*self._joints.values(), self._tracks):
            core.restart(self._now)

    # --- the port --------------------------------------------------------------------------------

    def observe(self) -> Observation:
        """See `Port.observe`."""
        robot, contact = self._robot, self._robot.contact()
        return Observation(
            time=robot.simulation.time,
            base=placement(robot.base_pose()),
            positions=robot.positions,
            velocities=robot.velocities,
            grip=Grip() if contact is None else Grip(contact.object, contact.force),
            notices=dict(self._notices),
        )

    def advance(self, seconds: float) -> None:
        """See `Port.advance`."""
        self._advance(seconds)

    def send(self, command: Command) -> None:
        """See `Port.send`; what a core refuses, its node says."""
        node = _node_of(command)
        self._woken.add(node)
        try:
            self._obey(command)
        except InvalidCommand as error:
            self._say(node, str(error))
            if node == ARM:
                self._arm.refuse(self._now, str(error))

    def _obey(self, command: Command) -> None:
        now = self._now
        if isinstance(command, Drive):
            self._tracks.receive(Velocity(command.linear, command.angular), now)
        elif isinstance(command, Jog):
            core, rates = self._joints[command.node], command.rates
            jog = parse_joint_jog(list(rates), (), list(rates.values()), 0.0, core.commanded_names)
            core.receive(jog, now)
        elif isinstance(command, FlipperPreset):
            self._flippers.hold_preset(command.name, (), now)
        elif isinstance(command, NamedPose):
            self._arm.receive_pose_name(command.name, now)
        elif isinstance(command, ToolPose):
            target = np.array(command.target, dtype=float)
            self._arm.receive_tool(PoseCommand(self._frames.find(command.frame), target), now)
        elif isinstance(command, ToolTwist):
            velocity = np.array([*command.linear, *command.angular])
            self._arm.receive_tool(TwistCommand(self._frames.find(command.frame), velocity), now)

    def set_mode(self, name: str) -> None:
        """See `TeleopPort.set_mode`."""
        try:
            self._arm.set_mode(name)
        except ModeError as error:
            raise NotManagedError(f"{ARM}: {error}") from error

    def e_stop(self, active: bool) -> None:
        """See `TeleopPort.e_stop`."""
        self._robot.robot.request_e_stop(active)
        for core in (*self._joints.values(), self._tracks):
            core.set_e_stop(active)

    def zoom(self, camera: str, factor: float) -> None:
        """Refuse; see the class."""
        raise NotManagedError(f"camera {camera}: a rehearsal draws no pictures")

    def camera(self, name: str) -> CameraView:
        """Refuse; see the class."""
        raise NotManagedError(f"camera {name}: a rehearsal draws no pictures")

    def object_pose(self, name: str) -> Optional[np.ndarray]:
        """See `TeleopPort.object_pose`."""
        pose = self._robot.object_pose(name)
        return None if pose is None else make_pose(*pose)

    def answer(self, question: str, answer: str) -> None:
        """See `TeleopPort.answer`."""
        if self._on_answer is None:
            raise NotManagedError(f"question {question!r} cannot be answered: nobody asks")
        self._on_answer(question, answer)


class Due:
    """Something that comes at a rate (1/s of sim time); never at 0."""

    def __init__(self, rate: float) -> None:
        self._period = 1.0 / rate if rate else math.inf
        self._next = -1.0 if rate else math.inf

    def due(self, stamp: float) -> bool:
        """Whether it comes now; then it does not again before its period is over."""
        # A stamp may lie a rounding error before its time.
        if stamp < self._next - 1e-6:
            return False
        self._next = stamp + self._period
        return True


def _node_of(command: Command) -> str:
    if isinstance(command, Drive):
        return TRACKS
    if isinstance(command, Jog):
        if command.node in (ARM, FLIPPERS, GRIPPER):
            return command.node
        raise TypeError(
            f"node of a Jog is {command.node!r}; {ARM}, {FLIPPERS} or {GRIPPER} is needed"
        )
    if isinstance(command, FlipperPreset):
        return FLIPPERS
    if isinstance(command, (NamedPose, ToolPose, ToolTwist)):
        return ARM
    raise TypeError(f"the teleoperation nodes do not take {command!r}")
