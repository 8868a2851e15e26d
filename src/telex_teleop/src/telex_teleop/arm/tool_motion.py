"""Leads the tool: commanded velocities and poses become references of the arm's joints.

The paper's operational-space scheme (section 4.2, figure 5): the joint angles give the tool's pose,
increments move the desired pose, inverse kinematics gives the references. Free of ROS.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Optional, Sequence, Tuple

import numpy as np

from telex_teleop.arm.held_place import HeldPlace
from telex_teleop.arm.proximity import Clearance, Nearness
from telex_teleop.arm.tool_clearance import scaled_clear, slid_clear, tool_effects
from telex_teleop.arm.tool_command import ToolCommand
from telex_teleop.arm.tool_settings import ToolSettings
from telex_teleop.arm.tool_slowdown import ON_BOUND, Slowdown, SlowdownReasons
from telex_teleop.arm.wanted_motion import WantedMotion
from telex_teleop.motion.joint_follower import JointFollower
from telex_teleop.motion.reference import MotionLimits
from telex_teleop.motion.rigid_motion import advanced, pose_error, shortened

if TYPE_CHECKING:
    from telex_teleop.arm.ik_kinematics import IKKinematics

# Above this share of the speed, no slowdown is reported.
FREE = 0.95
# Below this a motion counts as ended: a joint's step (rad or m), the tool's speed as a share of its
# largest.
STILL_STEP = 1e-7
STILL_SHARE = 1e-6
# What is left of the way is given up when a step leaves more of it than this share.
SETTLING = 0.9
# A joint slower than this (per second) does not come near its limits.
MOVING_RATE = 1e-6
# Share of its largest velocity from which a joint counts as running at it.
AT_SPEED = 0.999
# Poses whose numbers differ by no more than this (m, and parts of unit vectors) are the same to a
# lead, which must be larger.
NEAR = 1e-4
# A joint whose lag behind inverse kinematics is so many seconds of its full speed holds the tool
# back, and from the second figure on stops it.
LAG_FREE, LAG_STOP = 0.005, 0.1
# The way ahead is tried so often (s): seldom enough to be cheap, often enough for any boundary.
LOOK_PERIOD = 0.04

# So much faster (m/s) than allowed two bodies may come nearer by a tool that was already kept from
# it: joints that move on curves miss by as little, and would stop a tool that slides along.
CURVE_SLACK = 1e-3


class ToolMotion:
    """References for the joints that carry the tool.

    Parameters
    ----------
    joints
        Names, in the order of all arrays.
    limits
        Of each joint.
    prismatic
        Which of them are measured in metres.
    kinematics
        Of the chain of these joints.
    settings
        Speeds and leads.
    """

    def __init__(
        self,
        joints: Sequence[str],
        limits: Sequence[MotionLimits],
        prismatic: Sequence[bool],
        kinematics: IKKinematics,
        settings: ToolSettings,
    ) -> None:
        self._kinematics = kinematics
        self._settings = settings
        self._lower = np.array([each.lower for each in limits])
        self._upper = np.array([each.upper for each in limits])
        self._leads = np.array([each.max_lead for each in limits])
        self._velocity_limits = np.array([each.max_velocity for each in limits])
        self._accelerations = np.array([each.max_acceleration for each in limits])
        self._reasons = SlowdownReasons(joints, prismatic, limits, settings.look_ahead)
        self._wanted = WantedMotion(settings)
        self.slowdown: Optional[Slowdown] = None
        self.nearness: Optional[Nearness] = None
        self._weights = np.repeat([1.0 / settings.max_linear, 1.0 / settings.max_angular], 3)
        self._follower = JointFollower(limits)
        self._goal: Optional[np.ndarray] = None
        self._solution = np.zeros(len(limits))
        self._measured = self._solution
        self._reached = np.eye(4)
        self._stand()
        self._moving = False
        self._place = HeldPlace(settings)

    @property
    def moving(self) -> bool:
        """Whether the tool is led now, or still comes to rest."""
        return self._moving

    @property
    def holding(self) -> bool:
        """Whether the tool is to keep its place in the world."""
        return self._place.active

    @property
    def solution(self) -> np.ndarray:
        """Where inverse kinematics leads the joints now (rad or m); references follow it."""
        return self._solution

    @property
    def off_place(self) -> float:
        """How far (m) the tool is from the place in the world that it is to keep."""
        target = self._place.target
        if target is None:
            return 0.0
        measured = self._kinematics.forward(self._measured)
        return float(np.linalg.norm(target[:3, 3] - measured[:3, 3]))

    @property
    def hold_ahead(self) -> float:
        """How far ahead (s) the base's pose is needed: 0 unless the tool keeps its place."""
        return self._settings.hold_ahead if self.holding else 0.0

    @property
    def goal(self) -> Optional[np.ndarray]:
        """Desired pose (4x4, in the base's frame), None while there is none to go on from."""
        return self._goal

    def hold(self, active: bool) -> None:
        """Begin or end keeping the tool's place in the world while the base moves."""
        self._place.hold(active)

    def drop(self) -> None:
        """Stop at once and forget everything; what comes next starts where the arm is."""
        self.hold(False)
        self._moving = False
        self._goal = None
        self._wanted.forget()
        self._stand()

    def _stand(self) -> None:
        self._twist = np.zeros(6)
        self._done = np.zeros(6)
        self._left = math.inf
        self._share = 1.0
        self._free_share = 1.0
        self._look_age = math.inf
        self.slowdown = None
        self.nearness = None

    def update(
        self,
        dt: float,
        command: Optional[ToolCommand],
        start: np.ndarray,
        positions: np.ndarray,
        base: Optional[np.ndarray],
        speed_scale: float,
        clearance: Optional[Clearance] = None,
    ) -> Optional[np.ndarray]:
        """Lead the tool for one step.

        Parameters
        ----------
        dt
            Time since the last joint state (s), above 0.
        command
            What is wanted now, None to come to rest.
        start : ndarray, shape (n,)
            Where a motion that begins now starts (rad or m).
        positions : ndarray, shape (n,)
            Measured.
        base : ndarray, shape (4, 4), or None
            Pose of the base in the world, as far as it is known.
        clearance
            What is near leaves of the joints' motion; None where nothing is.

        Returns
        -------
        ndarray, shape (n,), or None
            References; None while idle.
        """
        self.nearness = None
        self._measured = positions
        if not self._moving:
            self.slowdown = None
            if command is None and not (self.holding and base is not None):
                self._wanted.forget()
                return None
            self._begin(start)
        assert self._goal is not None
        wanted = self._wanted.twist(command, self._goal, base, speed_scale, dt)
        self._twist = self._ramped(wanted, dt)
        lower, upper = self._bounds(positions)
        twist = self._twist + self._place.twist(base, self._goal, dt)
        if clearance is not None and len(clearance):
            twist = self._cleared(twist, clearance)
        self._look_ahead(twist, lower, upper, dt)
        last = self._solution
        goal = self._step(twist * self._share, dt, lower, upper)
        if clearance is not None and len(clearance):
            self._keep_clear(last, dt, clearance)
        self._reached = self._kinematics.forward(self._solution)
        self._goal = self._within_lead(goal, self._reached)
        if not (self.holding or self._done.any()):
            self._settle()
        self._place.keep(base, self._goal, self._reached, bool(self._twist.any()))
        references = self._follower.update(self._solution, dt)
        still = command is None and not wanted.any() and self._still(last)
        self._moving = self.holding or not still
        return references

    def _settle(self) -> None:
        """Give up what is left of the way to the desired pose, unless that is soon done.

        Along a boundary the arm would else go on creeping towards it when nobody commands it.
        """
        assert self._goal is not None
        left = float(np.abs(self._goal - self._reached).max())
        if left > SETTLING * self._left:
            self._goal = self._reached
            left = 0.0
        self._left = left

    def _step(
        self, twist: np.ndarray, dt: float, lower: np.ndarray, upper: np.ndarray
    ) -> np.ndarray:
        """Move the solution by one step, and return the desired pose that belongs to it.

        The tool changes its velocity only as fast as the joints can change theirs, and is slow
        enough for each of them to stop before its limit: a joint that falls behind, or that hands
        over to others at full speed, would bend the tool's line.
        """
        assert self._goal is not None
        kinematics, last = self._kinematics, self._solution
        goal = advanced(self._goal, twist * dt)
        solution = kinematics.track(goal, last, dt, lower, upper)
        rates = (solution - last) / dt
        braking, nearest = self._braking_share(rates, dt, lower, upper)
        share = min(braking, self._share_at_speed(rates, solution, goal))
        if share < 1.0:
            twist = twist * share
            goal = advanced(self._goal, twist * dt)
            solution = kinematics.track(goal, last, dt, lower, upper)
            if braking < FREE and (self.slowdown is None or braking < self.slowdown.share):
                towards = float(solution[nearest])
                self.slowdown = self._reasons.near_bound(
                    braking, nearest, last, towards, lower, upper
                )
        change = np.abs((solution - last) / dt - self._follower.velocities)
        excess = float(np.max(change / (self._accelerations * dt)))
        # A base that brakes harder than the slowest joint would take all of them off the place.
        if excess > 1.0 and not self.holding:
            twist = self._done + (twist - self._done) / excess
            goal = advanced(self._goal, twist * dt)
            solution = kinematics.track(goal, last, dt, lower, upper)
        self._done = twist
        if twist.any():
            self._left = math.inf
        self._solution = solution
        return goal

    def _cleared(self, twist: np.ndarray, clearance: Clearance) -> np.ndarray:
        """Return the twist without what would bring the arm too near to something."""
        effects = tool_effects(clearance.gradients, self._kinematics.jacobian(self._solution))
        closing = -(effects @ twist)
        over = closing > clearance.allowed
        if not over.any():
            return twist
        # to a pose the tool goes straight, or not at all
        clear = scaled_clear if self._wanted.to_a_pose else slid_clear
        left = clear(twist, effects, clearance.allowed)
        wanted = twist * self._weights
        size = float(wanted @ wanted)
        # The square of a twist of 1e-200 is 0.
        share = float(wanted @ (left * self._weights)) / size if size > 0.0 else 1.0
        nearest = int(np.argmax(np.where(over, closing - clearance.allowed, -np.inf)))
        self.nearness = clearance.nearness(nearest, max(0.0, share))
        return left

    def _keep_clear(self, last: np.ndarray, dt: float, clearance: Clearance) -> None:
        """Shorten a step of the joints, whatever asks for it, that comes too near to something."""
        moved = self._solution - last
        share, nearness = clearance.share(moved / dt, CURVE_SLACK)
        if nearness is None:
            return
        self._solution = last + share * moved
        self._done = self._done * share
        if self.nearness is None or nearness.factor < self.nearness.factor:
            self.nearness = nearness

    def _begin(self, start: np.ndarray) -> None:
        # A rest in between, or a joint that gave way a little, does not bend the desired line.
        if self._goal is None or not np.array_equal(start, self._follower.references):
            self._goal = self._kinematics.forward(start)
        self._solution = np.array(start, dtype=float)
        self._reached = self._kinematics.forward(self._solution)
        self._follower.rest_at(self._solution)
        self._stand()
        self._moving = True

    def _still(self, last: np.ndarray) -> bool:
        slow = float(np.max(np.abs(self._done * self._weights))) <= STILL_SHARE
        settled = bool(np.all(np.abs(self._solution - last) <= STILL_STEP))
        return slow and settled and self._follower.resting

    def _ramped(self, wanted: np.ndarray, dt: float) -> np.ndarray:
        """Return the twist on its way to the wanted one, translation and rotation in step."""
        change = wanted - self._twist
        weighted = change * self._weights
        size = max(float(np.linalg.norm(weighted[:3])), float(np.linalg.norm(weighted[3:])))
        most = dt / self._settings.acceleration_time
        return wanted if size <= most else self._twist + change * (most / size)

    # ------------------------------------------------------------ what is possible

    def _bounds(self, positions: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
        """Return between which positions the joints may be led now (rad or m)."""
        lower = np.maximum(self._lower, positions - self._leads)
        upper = np.minimum(self._upper, positions + self._leads)
        # a joint that is already outside may stay there, but goes no further
        return np.minimum(lower, self._solution), np.maximum(upper, self._solution)

    def _look_ahead(
        self, twist: np.ndarray, lower: np.ndarray, upper: np.ndarray, dt: float
    ) -> None:
        """Find what share of the speed the arm can keep up, and why no more.

        The tool is led ahead on trial. How far it gets, as a share of how far it should, is the
        share of the speed: so it comes to a boundary exponentially, with the time constant of the
        look-ahead, and along a boundary it moves as fast as the boundary lets it.
        """
        self._look_age += dt
        if self._look_age >= LOOK_PERIOD:
            self._look_age = 0.0
            self._look(twist, lower, upper)
        lag = float(
            np.max(np.abs(self._solution - self._follower.references) / self._velocity_limits)
        )
        lagging = (LAG_STOP - lag) / (LAG_STOP - LAG_FREE)
        share = max(self._settings.least_share, min(self._free_share, lagging))
        # Sudden on the way down, as a boundary is; on the way up on the tool's own ramp.
        self._share = min(share, self._share + dt / self._settings.acceleration_time)

    def _look(self, twist: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> None:
        assert self._goal is not None
        horizon = self._settings.look_ahead
        way = twist * horizon
        wanted = way * self._weights
        size = float(wanted @ wanted)
        self._free_share, self.slowdown = 1.0, None
        if size <= STILL_SHARE**2:
            return
        solution = self._solution
        # A measured joint moves on, and the room that its lead leaves with it, unless it is stuck.
        lower = np.where(solution - lower > ON_BOUND, self._lower, lower)
        upper = np.where(upper - solution > ON_BOUND, self._upper, upper)
        lower, upper = np.minimum(lower, solution), np.maximum(upper, solution)
        ahead = self._kinematics.track(advanced(self._goal, way), solution, horizon, lower, upper)
        got = pose_error(self._kinematics.forward(ahead), self._reached) * self._weights
        share = max(0.0, min(1.0, float(got @ wanted) / size))
        self._free_share = share
        if share < FREE:
            self.slowdown = self._reasons.explain(share, solution, ahead, lower, upper)

    def _share_at_speed(self, rates: np.ndarray, solution: np.ndarray, goal: np.ndarray) -> float:
        """Return how much of a step is done whose joints run at these rates.

        All of it, unless one of them is as fast as it can be and the others cannot make up for it.
        """
        if float(np.max(np.abs(rates) / self._velocity_limits)) < AT_SPEED:
            return 1.0
        wanted = pose_error(goal, self._reached) * self._weights
        size = float(wanted @ wanted)
        if size == 0.0:
            return 1.0
        got = pose_error(self._kinematics.forward(solution), self._reached) * self._weights
        return max(self._settings.least_share, min(1.0, float(got @ wanted) / size))

    def _braking_share(
        self, rates: np.ndarray, dt: float, lower: np.ndarray, upper: np.ndarray
    ) -> Tuple[float, int]:
        """Return at what share of these rates all joints can stop in time, and which sets it."""
        room = np.where(rates > 0.0, upper - self._solution, self._solution - lower)
        change = self._accelerations * dt
        stoppable = np.sqrt(change**2 + 2.0 * self._accelerations * room) - change
        shares = stoppable / np.maximum(np.abs(rates), MOVING_RATE)
        nearest = int(np.argmin(shares))
        return float(shares[nearest]) if abs(rates[nearest]) > MOVING_RATE else 1.0, nearest

    def _within_lead(self, goal: np.ndarray, reached: np.ndarray) -> np.ndarray:
        """Return the desired pose, taken back where it is too far ahead of the reached one."""
        if float(np.abs(goal - reached).max()) <= NEAR:
            return goal
        error = pose_error(goal, reached)
        settings = self._settings
        lead = shortened(error, settings.lead, settings.angular_lead)
        return goal if lead is error else advanced(reached, lead)
