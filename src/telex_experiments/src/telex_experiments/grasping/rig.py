"""The shipped robot, all of it, with objects to grip: no ROS master, and always the same."""

from __future__ import annotations

import functools
import math
from typing import Any, Callable, Dict, List, NamedTuple, Optional, Sequence, Tuple

import genpy
import numpy as np
import pybullet
import yaml
from control_msgs.msg import FollowJointTrajectoryGoal, GripperCommand, GripperCommandGoal
from trajectory_msgs.msg import JointTrajectoryPoint

from telex_control.common.file_catalog import package_yaml
from telex_control.common.geometry.matrices import homogeneous, rotation_from_rpy
from telex_control.common.params import read_config
from telex_control.controllers.parallel_gripper_controller import FingerGeometry
from telex_control.follow_trajectory import FollowTrajectoryError
from telex_control.kinematics import Chain, IKSolver, Tolerance
from telex_experiments.rigs.offline_rig import OfflineRig, for_period
from telex_sim.engine.simulator_config import TUNED_PERIOD
from telex_sim.offline.simulation import robot_description
from telex_sim.robot.gripper.contact import GripperContact

PLACE = (1.0, 0.0, 0.6)
"""Where the tool starts, in base_link (m): from here it can be shaken however the hand points."""
FRONT, OBLIQUE, TOP = 0.0, 0.25 * math.pi, 0.5 * math.pi
"""How far down the hand points (rad)."""

_ARM, _GRIPPER = "arm_trajectory_controller", "gripper_controller"
_SEED_POSE = "look_front"
_REFERENCE_PERIOD = 0.02
"""Time between the points of a trajectory (s); the controller runs splines through them."""
_SETTLING = 1.0
"""For tracks, arm and integral terms to come to rest (s)."""
_COMMAND_PERIOD = 0.1
"""Time between two commands to the tracks (s), shorter than their watchdog's."""
_LOST = 1e-3  # m, rad
_AS_IT_COMES = Tolerance(rotation_bounds=(0.3, 0.3, 0.3))
"""Lets the hand turn a little (rad) where the arm is too slow to swing it without."""

Vector = Sequence[float]
Pose = Tuple[Vector, Vector]
"""Position (m) and quaternion (x, y, z, w)."""


class NotGrippedError(Exception):
    """The pads do not come to rest on what they are to grip."""


class GripChange(NamedTuple):
    """How far what is held has moved in the hand, at the place where it is held (m, rad)."""

    distance: float
    angle: float


class GraspRig(OfflineRig):
    """A robot with its trajectory and gripper controllers, in a scene; close it when done.

    Parameters
    ----------
    objects : sequence of dict
        Entries of a scene file.
    place : sequence of 3 floats
        Where the tool starts, in base_link (m).
    pitch : float
        How far down the hand points (rad).
    roll : float
        By which the hand is turned about its axis (rad); at 0 the pads stand upright.
    opening : float
        Of the pads at the start (m).
    friction : float
        Of the pads, on a surface of friction 1.
    anchor : bool
        Whether the pads' friction is anchored, as the shipped one is.
    step_size : float
        Of physics and control (s). Above the period that the shipped gains are tuned for, gains
        are less by as much.
    start : dict
        Of the scene file.
    **changes
        See `OfflineRig`.
    """

    def __init__(
        self,
        objects: Sequence[Dict[str, Any]] = (),
        place: Vector = PLACE,
        pitch: float = FRONT,
        roll: float = 0.0,
        opening: float = 0.12,
        friction: float = 0.8,
        anchor: bool = True,
        step_size: float = TUNED_PERIOD,
        start: Optional[Dict[str, float]] = None,
        **changes: Any,
    ) -> None:
        pads = {"friction": friction, "spinning_friction": 0.01, "friction_anchor": anchor}
        contacts = dict.fromkeys(("left_finger_tip_link", "right_finger_tip_link"), pads)
        controllers, urdf = for_period(step_size)
        pose = _start_pose(place, pitch, roll, opening)
        super().__init__(
            {"start": dict(start or {}), "objects": list(objects)},
            urdf,
            controllers,
            step_size,
            start__poses={"work": pose},
            start__default_pose="",
            start__pose="work",
            timing__control_period=step_size,
            hardware__contacts=contacts,
            **changes,
        )
        self._reference = np.array([pose[name] for name in _chain().joint_names])
        groups = controllers["controller_groups"]
        self.offline.switch(groups["actions"], groups["manual"])
        self.wait(_SETTLING)
        self.operator.look()

    # --- the arm ---------------------------------------------------------------------------------

    def line(self, offset: Vector, speed: float = 0.1, acceleration: float = 0.2) -> None:
        """Move the tool on a straight line by so much in base_link (m), from rest to rest.

        Raises
        ------
        FollowTrajectoryError
            The arm cannot follow.
        """
        way = float(np.linalg.norm(offset))
        ramp = min(speed, math.sqrt(acceleration * way)) / acceleration
        peak = acceleration * ramp
        duration = way / peak + ramp

        def gone(time: float) -> float:
            left = max(duration - time, 0.0)
            if time < ramp:
                return 0.5 * acceleration * time**2
            if left < ramp:
                return way - 0.5 * acceleration * left**2
            return peak * (time - 0.5 * ramp)

        direction = np.asarray(offset, dtype=float) / way
        self._lead(lambda time: gone(time) * direction, duration)

    def advance_hand(self, way: float, speed: float = 0.15) -> None:
        """Move the tool along its own axis (m); back where it is negative."""
        self.line(way * _chain().forward(self._reference)[:3, 0], speed, 2.0 * speed)

    def shake(self, direction: Vector, amplitude: float, frequency: float, seconds: float) -> None:
        """Swing the tool about its place, along a unit vector of base_link; the hand may turn.

        Parameters
        ----------
        direction : sequence of 3 floats
        amplitude : float
            To either side (m); it grows and dies away over the first and the last second.
        frequency : float
            Hz.
        seconds : float
            Of it all.
        """

        def swing(time: float) -> np.ndarray:
            envelope = min(1.0, time, max(seconds - time, 0.0))
            part = envelope**2 * (3.0 - 2.0 * envelope)
            phase = 2.0 * math.pi * frequency * time
            return amplitude * part * math.sin(phase) * np.asarray(direction)

        self._lead(swing, seconds, _AS_IT_COMES)

    def swing_up(self, radius: float, angle: float, rate: float = 0.2) -> None:
        """Lead the tool on an arc about a level axis ahead of it, turning it as a lever turns.

        Parameters
        ----------
        radius : float
            From the tool to the axis, along the tool's own (m).
        angle : float
            rad; the tool rises, and its nose sinks.
        rate : float
            rad/s.
        """
        begin = _chain().forward(self._reference)
        axis = begin[:3, 3] + radius * begin[:3, 0]
        duration = 1.5 * angle / rate

        def turned(time: float) -> np.ndarray:
            share = time / duration
            rotation = rotation_from_rpy((0.0, share**2 * (3.0 - 2.0 * share) * angle, 0.0))
            return homogeneous(rotation @ begin[:3, :3], axis + rotation @ (begin[:3, 3] - axis))

        self._track(turned, duration)

    def _lead(
        self,
        offset: Callable[[float], np.ndarray],
        duration: float,
        tolerance: Optional[Tolerance] = None,
    ) -> None:
        """Lead the tool by offsets from where it is; without a tolerance it does not turn."""
        begin = _chain().forward(self._reference)

        def moved(time: float) -> np.ndarray:
            target = begin.copy()
            target[:3, 3] += offset(time)
            return target

        self._track(moved, duration, tolerance)

    def _track(
        self,
        pose: Callable[[float], np.ndarray],
        duration: float,
        tolerance: Optional[Tolerance] = None,
    ) -> None:
        """Lead the tool through poses in base_link."""
        references = [self._reference]
        for index in range(1, max(2, math.ceil(duration / _REFERENCE_PERIOD)) + 1):
            target = pose(min(index * _REFERENCE_PERIOD, duration))
            tick = _solver().track(
                target, references[-1], _REFERENCE_PERIOD, tolerance, acceleration_time=None
            )
            turned = tolerance is None and tick.orientation_error > _LOST
            if turned or tick.position_error > _LOST:
                raise FollowTrajectoryError(f"the tool cannot follow to {target[:3, 3].tolist()}")
            references.append(np.asarray(tick.q))
        self._follow(np.array(references))

    def _follow(self, references: np.ndarray) -> None:
        """Have the trajectory controller run through joint positions, and wait for it."""
        rates = np.gradient(references, _REFERENCE_PERIOD, axis=0)
        rates[0] = rates[-1] = 0.0
        goal = FollowJointTrajectoryGoal()
        goal.trajectory.joint_names = list(_chain().joint_names)
        goal.trajectory.points = [
            JointTrajectoryPoint(
                positions=position,
                velocities=rate,
                time_from_start=genpy.Duration.from_sec(index * _REFERENCE_PERIOD),
            )
            for index, (position, rate) in enumerate(zip(references.tolist(), rates.tolist()))
            if index
        ]
        sent = self.offline.node.send_goal(f"{_ARM}/follow_joint_trajectory", goal)
        self._reference = references[-1]
        self.wait((len(references) - 1) * _REFERENCE_PERIOD + 0.1)
        if sent.status in ("aborted", "rejected"):
            raise FollowTrajectoryError(f"the arm's trajectory was {sent.status}: {sent.text}")

    # --- the gripper -----------------------------------------------------------------------------

    def command_pads(self, opening: float, force: float) -> Any:
        """Send the pads to an opening (m) with so much force (N); returns the goal."""
        goal = GripperCommandGoal(command=GripperCommand(opening, force))
        return self.offline.node.send_goal(f"{_GRIPPER}/gripper_cmd", goal)

    def grip(self, force: float, timeout: float = 4.0) -> None:
        """Close the pads (N) until they stand.

        Raises
        ------
        NotGrippedError
            They do not come to rest in time.
        """
        goal = self.command_pads(0.0, force)
        for _ in range(round(timeout / _COMMAND_PERIOD)):
            self.wait(_COMMAND_PERIOD)
            if goal.status == "succeeded":
                return
        raise NotGrippedError(f"after {timeout} s the grip is still {goal.status}")

    def contact(self) -> GripperContact:
        """What the pads feel."""
        found = self.simulation.gripper_contact(self.simulation.robots[0])
        assert found is not None
        return found

    # --- the tracks ------------------------------------------------------------------------------

    def drive(self, linear: float, angular: float, seconds: float) -> None:
        """Drive (m/s, rad/s), then stop."""
        for _ in range(round(seconds / _COMMAND_PERIOD)):
            self.robot.drive(linear, angular)
            self.wait(_COMMAND_PERIOD)
        self.robot.drive(0.0, 0.0)

    # --- objects ---------------------------------------------------------------------------------

    @property
    def client(self) -> int:
        """PyBullet's."""
        return self.simulation.world.client

    def spawn(self, entry: Dict[str, Any]) -> str:
        """Put an object of the library into the world; returns its name."""
        plans = self.simulation.plan(yaml.safe_dump(entry))
        self.simulation.spawn(plans)
        return plans[0].source.name

    def uid(self, name: str) -> int:
        """PyBullet's number of an object."""
        return self.simulation.objects.bodies_of(name)[0]

    def pose(self, name: str) -> Pose:
        """Of an object's centre of mass, in the world."""
        return pybullet.getBasePositionAndOrientation(self.uid(name), physicsClientId=self.client)

    def speed(self, name: str) -> float:
        """Of an object's centre of mass (m/s)."""
        linear, _ = pybullet.getBaseVelocity(self.uid(name), physicsClientId=self.client)
        return math.hypot(*linear)

    def tool(self) -> Pose:
        """Of tool_link, in the world."""
        return self.simulation.body.pose("tool_link")

    def by_tool(self, offset: Vector) -> List[float]:
        """A place relative to the tool, along the world's axes (m)."""
        return [a + b for a, b in zip(self.tool()[0], offset)]

    def held_at(self, name: str) -> Pose:
        """Of tool_link, in an object's frame: where the object is held, and how."""
        return pybullet.multiplyTransforms(
            *pybullet.invertTransform(*self.pose(name)), *self.tool()
        )

    def slip(self, name: str, before: Pose) -> GripChange:
        """How far an object has moved in the hand since it was `held_at` a pose."""
        after = self.held_at(name)
        turn = abs(float(np.dot(before[1], after[1])))
        return GripChange(math.dist(before[0], after[0]), 2.0 * math.acos(min(1.0, turn)))

    def present(self, entry: Dict[str, Any], force: float) -> str:
        """Hold an object between the pads as a helping hand does, grip it, and let go of it.

        Parameters
        ----------
        entry : dict
            Entry of a scene file; its position is relative to the tool, along the world's axes.
        force : float
            Of the pads (N).

        Returns
        -------
        str
            Its name.
        """
        name = self.spawn({**entry, "position": self.by_tool(entry["position"])})
        position, orientation = self.pose(name)
        helping_hand = pybullet.createConstraint(
            *(self.uid(name), -1, -1, -1, pybullet.JOINT_FIXED),
            *((0, 0, 0), (0, 0, 0), position, (0, 0, 0, 1), orientation),
            physicsClientId=self.client,
        )
        self.grip(force)
        pybullet.removeConstraint(helping_hand, physicsClientId=self.client)
        return name


@functools.lru_cache(maxsize=None)
def _chain() -> Chain:
    return Chain.from_urdf(robot_description(), "base_link", "tool_link")


@functools.lru_cache(maxsize=None)
def _solver() -> IKSolver:
    return IKSolver(_chain())


def _start_pose(place: Vector, pitch: float, roll: float, opening: float) -> Dict[str, float]:
    """Joint positions with the tool at a place, the flippers flat."""
    pose = dict(package_yaml("telex_description", "config", "poses.yaml")["poses"][_SEED_POSE])
    names = _chain().joint_names
    target = homogeneous(rotation_from_rpy((roll, pitch, 0.0)), place)
    found = _solver().solve(target, [pose[name] for name in names])
    if not found.converged:
        raise FollowTrajectoryError(f"the tool cannot reach {list(place)}")
    pose.update(zip(names, np.asarray(found.q).tolist()))
    geometry = package_yaml("telex_control", "config", "telex_controllers.yaml")[_GRIPPER][
        "geometry"
    ]
    angle = read_config(FingerGeometry, geometry, "geometry").angle(opening)
    for joint, ratio in (("base", 1.0), ("middle", 1.0), ("tip", -2.0)):
        for side in ("left", "right"):
            pose[f"{side}_finger_{joint}_joint"] = ratio * angle
    return pose
