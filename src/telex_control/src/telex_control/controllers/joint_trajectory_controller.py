"""``{position,velocity,effort}_controllers/JointTrajectoryController``."""

from __future__ import annotations

import bisect
import math
from collections import deque
from typing import Any, ClassVar, Deque, Dict, List, NamedTuple, Optional, Sequence, Tuple, Type

from control_msgs.msg import (
    FollowJointTrajectoryAction,
    FollowJointTrajectoryFeedback,
    JointTrajectoryControllerState,
)
from control_msgs.msg import FollowJointTrajectoryResult as Result
from control_msgs.srv import QueryTrajectoryState, QueryTrajectoryStateResponse
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from ..common.periodic import Periodic
from ..common.stateful import Names, Stateful
from ..hardware.hardware_interface import (
    EffortJointInterface,
    JointCommandInterface,
    JointHandle,
    PositionJointInterface,
    RobotHW,
    VelocityJointInterface,
)
from ..hardware.joint_limits import clamp
from ..laws.gravity import JointGravity
from ..laws.pid import Pid
from ..laws.pid_reconfigure import PidSet
from ..manager.controller import Controller
from ..manager.pending import drain
from ..ros.node_handle import ActionGoal, NodeHandle, ServiceError
from ..ros.sim_time import stamp
from ..trajectory.path import JointPath, Track
from ..trajectory.spline import Sample
from ..trajectory.tolerances import Tolerances, read_tolerances, with_goal
from ..trajectory.waypoints import Bounds, TrajectoryError, check_joints, read_tracks
from ..urdf.joints import CONTINUOUS
from .joint_description import joint_description, joint_gravity

_ROUNDING = 1e-6
"""By so much (s) times differ that went through messages."""

_REPLACED = "replaced by a newer trajectory"


class _Joint(Stateful):
    """One joint: its handle, what it is to do, and how far it is from that."""

    __slots__ = (
        "desired",
        "handle",
        "lower",
        "name",
        "path",
        "position_error",
        "upper",
        "velocity_error",
        "wraps",
    )
    SAVED = ("desired", "path", "position_error", "velocity_error")

    def __init__(self, handle: JointHandle, lower: float, upper: float, wraps: bool) -> None:
        self.name = handle.name
        self.handle = handle
        self.lower = lower
        self.upper = upper
        self.wraps = wraps
        self.path = JointPath.hold(0.0, handle.state.position)
        self.desired: Sample = (handle.state.position, 0.0, 0.0)
        self.position_error = 0.0
        self.velocity_error = 0.0

    def restore_state(self, saved: Any, elapsed: float) -> None:
        super().restore_state(saved, elapsed)
        self.path = self.path.shifted(elapsed)


class _Order(NamedTuple):
    """A trajectory on its way to the loop; without tracks, the order to stop."""

    tracks: Dict[str, Track]  # by joint
    start: float  # s; 0 is when the loop takes it
    goal: Optional[ActionGoal]
    tolerances: Tolerances


class _Active(NamedTuple):
    """The goal that is being carried out."""

    goal: ActionGoal
    joints: Tuple[_Joint, ...]
    start: float  # s; until then the joints still do what they did before
    tolerances: Tolerances


class JointTrajectoryController(Controller):
    """Leads joints through trajectories.

    Topics: ``command`` (trajectory_msgs/JointTrajectory; no points: stop), ``state``
    (control_msgs/JointTrajectoryControllerState). Action: ``follow_joint_trajectory``
    (control_msgs/FollowJointTrajectory). Service: ``query_state``
    (control_msgs/QueryTrajectoryState).

    Parameters: ``joints``, ``state_publish_rate`` (50 Hz), ``action_monitor_rate`` (20 Hz),
    ``stop_trajectory_duration`` (0 s), ``allow_partial_joints_goal`` (false), ``constraints``
    (see `read_tolerances`), for velocity and effort ``gains/<joint>`` (as a PID's) and
    ``velocity_ff/<joint>`` (0), for effort ``gravity_compensation`` (false).

    A trajectory takes the place of the running one from its start on; until then the running one
    goes on, and the joints are led over from it to the first point. A goal that violates its
    tolerances is aborted, and the joints then hold where they are.
    """

    parameters = frozenset(
        (
            "action_monitor_rate",
            "allow_partial_joints_goal",
            "constraints",
            "joints",
            "state_publish_rate",
            "stop_trajectory_duration",
        )
    )
    SAVED_PARTS: ClassVar[Names] = ("_feedback_timer", "_joints", "_state_timer")
    interface: Type[JointCommandInterface]

    def init(self, hw: RobotHW, root: NodeHandle, node: NodeHandle) -> None:
        """Claim the joints, open topics, action and service."""
        self._node = node
        self._names = node.names_param("joints")
        interface = hw.get(self.interface)
        self._joints: List[_Joint] = []
        self._bounds: Dict[str, Bounds] = {}
        for name in self._names:
            handle = interface.get_handle(name)
            limits = joint_description(root, name)
            self._bounds[name] = Bounds(limits.lower, limits.upper, limits.velocity)
            self._joints.append(
                _Joint(handle, limits.lower, limits.upper, limits.kind == CONTINUOUS)
            )
        self._state_timer = Periodic(node.positive_param("state_publish_rate", 50.0))
        self._feedback_timer = Periodic(node.positive_param("action_monitor_rate", 20.0))
        self._stop_duration = node.positive_param("stop_trajectory_duration", 0.0, zero=True)
        self._allow_partial = node.param("allow_partial_joints_goal", bool, False)
        self._tolerances = read_tolerances(
            node.param("constraints", dict, {}), node.resolve("constraints"), self._names
        )
        self._init_commands(hw, root, node)
        self._running = False
        self._time = 0.0
        self._orders: Deque[_Order] = deque()
        self._active: Optional[_Active] = None
        self._state = node.advertise("state", JointTrajectoryControllerState, queue_size=1)
        node.subscribe("command", JointTrajectory, self._on_command)
        node.advertise_service("query_state", QueryTrajectoryState, self._on_query)
        node.serve_action("follow_joint_trajectory", FollowJointTrajectoryAction, self._on_goal)

    def _init_commands(self, hw: RobotHW, root: NodeHandle, node: NodeHandle) -> None:
        """Prepare what `_command` needs."""

    def _start_commands(self) -> None:
        """Forget what `_command` remembers."""

    def _command(self, time: float, period: float) -> None:
        """Turn the desired states and errors of the joints into commands."""
        raise NotImplementedError

    def _rest_command(self, joint: _Joint) -> float:
        """Return what is commanded to a joint that is given up."""
        return 0.0

    # --- callbacks: other threads ------------------------------------------------------------

    def _on_command(self, message: JointTrajectory) -> None:
        topic = self._node.resolve("command")
        if not self._running:
            self._node.warn(f"{topic}: dropped; the controller is not running")
            return
        try:
            self._orders.append(self._order(message, None, self._tolerances))
        except TrajectoryError as error:
            self._node.warn(f"{topic}: {error}; the trajectory is dropped")

    def _on_goal(self, goal: ActionGoal) -> None:
        try:
            if not self._running:
                raise TrajectoryError(Result.INVALID_GOAL, "the controller is not running")
            # As upstream, an action's goal has to name joints even where it has no points.
            check_joints(goal.message.trajectory.joint_names, self._bounds, self._allow_partial)
            tolerances = with_goal(self._tolerances, goal.message)
            order = self._order(goal.message.trajectory, goal, tolerances)
        except TrajectoryError as error:
            self._node.warn(f"{self._node.resolve('follow_joint_trajectory')}: {error}")
            goal.reject(Result(error.code, str(error)), str(error))
            return
        goal.accept()
        self._orders.append(order)
        if not self._running:
            # It was stopped while the trajectory was read: nobody else would end the goal.
            self._drop_orders()

    def _order(self, trajectory: Any, goal: Optional[ActionGoal], tolerances: Tolerances) -> _Order:
        start = trajectory.header.stamp.to_sec()
        if not trajectory.points:
            return _Order({}, start, goal, tolerances)
        tracks = read_tracks(trajectory, self._bounds, self._allow_partial)
        last = trajectory.points[-1].time_from_start.to_sec()
        late = self._time - (start or self._time) - last
        if late >= 0.0 or last < 0.0:
            raise TrajectoryError(
                Result.OLD_HEADER_TIMESTAMP,
                f"all {len(trajectory.points)} point(s) lie in the past, the last one by "
                f"{max(late, -last):.3f} s; a time_from_start above 0 is needed",
            )
        return _Order(tracks, start, goal, tolerances)

    def _on_query(self, request: Any) -> Any:
        if not self._running:
            raise ServiceError("the controller is not running; it follows no trajectory")
        time = request.time.to_sec()
        paths = [joint.path for joint in self._joints]
        start = max(path.start_time for path in paths)
        if time < start - _ROUNDING:
            raise ServiceError(
                f"time is {time:.3f} s; the trajectory starts at {start:.3f} s, and a time from "
                "then on is needed"
            )
        samples = [path.sample_at(time) for path in paths]
        return QueryTrajectoryStateResponse(
            name=self._names,
            position=[sample[0] for sample in samples],
            velocity=[sample[1] for sample in samples],
            acceleration=[sample[2] for sample in samples],
        )

    # --- the control loop --------------------------------------------------------------------

    def starting(self, time: float) -> None:
        """Hold the measured positions."""
        self._drop_orders()
        for joint in self._joints:
            joint.path = JointPath.hold(time, joint.handle.state.position)
        self._start_commands()
        self._state_timer.restart()
        self._time = time
        self._running = True

    def update(self, time: float, period: float) -> None:
        """Follow the trajectory."""
        self._time = time
        active = self._active
        if active is not None and active.goal.cancel_requested:
            self._cancel("cancelled by a client")
            self._hold(time)
        for order in drain(self._orders):
            self._take(order, time)
        for joint in self._joints:
            joint.desired = desired = joint.path.sample(time)
            state = joint.handle.state
            error = desired[0] - state.position
            joint.position_error = math.remainder(error, 2.0 * math.pi) if joint.wraps else error
            joint.velocity_error = desired[1] - state.velocity
        if self._active is not None:
            self._check(self._active, time)
        self._command(time, period)
        if self._state_timer.is_due(time) and self._state.has_subscribers():
            self._state.publish(self._fill(JointTrajectoryControllerState(), time))

    def stopping(self, time: float) -> None:
        """Give up the joints; a goal is cancelled."""
        self._running = False
        self._cancel("the controller was stopped")
        self._drop_orders()
        for joint in self._joints:
            joint.handle.command = self._rest_command(joint)

    def restore_state(self, saved: Any, elapsed: float) -> None:
        """Take a state up again, and go on along its trajectory; goals are cancelled."""
        self._cancel("the simulation went back to a bookmark")
        self._drop_orders("the simulation went back to a bookmark")
        super().restore_state(saved, elapsed)

    def _drop_orders(self, text: str = "the controller was stopped") -> None:
        for order in drain(self._orders):
            if order.goal is not None:
                order.goal.cancel(Result(), text)

    def _cancel(self, text: str) -> None:
        if self._active is not None:
            self._active.goal.cancel(Result(error_string=text), text)
            self._active = None

    def _hold(self, time: float, measured: bool = False) -> None:
        """Stop all joints; with `measured`, from where they are instead of where they should be."""
        duration = self._stop_duration
        for joint in self._joints:
            state = joint.handle.state
            if duration == 0.0:
                joint.path = JointPath.hold(time, state.position)
                continue
            position, velocity = (
                (state.position, state.velocity) if measured else joint.path.sample(time)[:2]
            )
            joint.path = JointPath.stop(
                time, duration, position, velocity, joint.lower, joint.upper
            )

    def _take(self, order: _Order, time: float) -> None:
        """Replace the trajectory and the active goal, unless what came is over already."""
        goal = order.goal
        if not order.tracks:
            self._cancel(_REPLACED)
            self._hold(time)
            if goal is not None:
                self._active = _Active(goal, tuple(self._joints), time, order.tolerances)
            return
        start = order.start or time
        times = next(iter(order.tracks.values())).times
        # Until a start that is still to come the old motion goes on: nothing is reached before it.
        before_start = bisect.bisect_left(times, 0.0)
        passed = max(bisect.bisect_right(times, time - start), before_start)
        if passed == len(times):
            # It was in the future when it came, at the end of the last cycle.
            text = "all points lie in the past"
            if goal is not None:
                goal.abort(Result(Result.OLD_HEADER_TIMESTAMP, text), text)
            else:
                topic = self._node.resolve("command")
                self._node.warn(f"{topic}: {text}; the trajectory is dropped")
            return
        self._cancel(_REPLACED)
        # A first point at the start itself is where planners put the present state.
        if passed > 1 or (passed == 1 and times[0] > 0.0):
            self._node.warn(
                f"the first {passed} of {len(times)} trajectory points are dropped, since they "
                f"lie in the past; the next one is reached in "
                f"{start + times[passed] - time:.3f} s"
            )
        cut = max(start, time)
        moved = tuple(joint for joint in self._joints if joint.name in order.tracks)
        for joint in moved:
            track = order.tracks[joint.name]
            joint.path = joint.path.replaced(cut, track, passed, start, joint.wraps)
        if goal is not None:
            self._active = _Active(goal, moved, cut, order.tolerances)

    def _check(self, active: _Active, time: float) -> None:
        """End the goal when it is reached, or when its tolerances are violated."""
        tolerances = active.tolerances
        if time < active.start:
            return
        reached = True
        for joint in active.joints:
            end = joint.path.end_time
            # At the end itself a straight line still has its speed.
            if time <= end:
                reached = False
                allowed = tolerances.path[joint.name]
                if not allowed.allows(joint.position_error, joint.velocity_error):
                    problem = allowed.problem(joint.position_error, joint.velocity_error)
                    text = f"{joint.name} path error {problem}"
                    self._abort(Result.PATH_TOLERANCE_VIOLATED, text, time)
                    return
                continue
            allowed = tolerances.goal[joint.name]
            if not allowed.allows(joint.position_error, joint.velocity_error):
                reached = False
                if time >= end + tolerances.goal_time:
                    problem = allowed.problem(joint.position_error, joint.velocity_error)
                    text = f"{joint.name} goal error {problem}"
                    self._abort(Result.GOAL_TOLERANCE_VIOLATED, text, time)
                    return
        if reached:
            self._active = None
            active.goal.succeed(Result(Result.SUCCESSFUL, ""))
        elif self._feedback_timer.is_due(time):
            active.goal.publish_feedback(self._fill(FollowJointTrajectoryFeedback(), time))

    def _abort(self, code: int, text: str, time: float) -> None:
        assert self._active is not None
        self._active.goal.abort(Result(code, text), text)
        self._active = None
        # Going on would drive it further into whatever stands in its way.
        self._hold(time, measured=True)

    def _fill(self, message: Any, time: float) -> Any:
        """Fill a state or feedback message, whose fields are the same."""
        message.header.stamp = stamp(time)
        message.joint_names = self._names
        joints = self._joints
        message.desired = JointTrajectoryPoint(
            positions=[joint.desired[0] for joint in joints],
            velocities=[joint.desired[1] for joint in joints],
            accelerations=[joint.desired[2] for joint in joints],
        )
        message.actual = JointTrajectoryPoint(
            positions=[joint.handle.state.position for joint in joints],
            velocities=[joint.handle.state.velocity for joint in joints],
        )
        message.error = JointTrajectoryPoint(
            positions=[joint.position_error for joint in joints],
            velocities=[joint.velocity_error for joint in joints],
        )
        return message


class PositionJointTrajectoryController(JointTrajectoryController):
    """``position_controllers/JointTrajectoryController``: commands the desired positions."""

    interface = PositionJointInterface

    def _command(self, time: float, period: float) -> None:
        for joint in self._joints:
            joint.handle.command = joint.desired[0]

    def _rest_command(self, joint: _Joint) -> float:
        return joint.handle.state.position


class _ClosedLoopTrajectoryController(JointTrajectoryController):
    """Commands what PIDs make of the errors, and a share of the desired velocity."""

    parameters = JointTrajectoryController.parameters | {"gains", "velocity_ff"}
    SAVED_PARTS = ("_stateful_loops",)

    def _init_commands(self, hw: RobotHW, root: NodeHandle, node: NodeHandle) -> None:
        self._pids = PidSet(node)
        gravities = self._gravities(hw, root, node)
        self._loops: Sequence[Tuple[_Joint, Pid, float, Optional[JointGravity]]] = [
            (
                joint,
                self._pids.open(f"gains/{joint.name}"),
                node.param(f"velocity_ff/{joint.name}", float, 0.0),
                gravity,
            )
            for joint, gravity in zip(self._joints, gravities)
        ]
        self._stateful_loops: List[Stateful] = [
            part for loop in self._loops for part in (loop[1], loop[3]) if part is not None
        ]

    def _gravities(
        self, hw: RobotHW, root: NodeHandle, node: NodeHandle
    ) -> Sequence[Optional[JointGravity]]:
        return [None] * len(self._joints)

    def _start_commands(self) -> None:
        for _, pid, _, _ in self._loops:
            pid.reset()

    def _command(self, time: float, period: float) -> None:
        for joint, pid, velocity_ff, gravity in self._loops:
            position, velocity = joint.desired[0], joint.desired[1]
            error, error_dot = joint.position_error, joint.velocity_error
            if not joint.lower <= position <= joint.upper:
                # Towards the stop, not against it: nothing is reached beyond.
                state, velocity = joint.handle.state, 0.0
                error = clamp(position, joint.lower, joint.upper) - state.position
                error_dot = -state.velocity
            command = pid.update(error, period, error_dot)
            command += velocity_ff * velocity
            if gravity is not None:
                command += gravity.effort(time)
            joint.handle.command = command
        self._pids.publish(time)


class VelocityJointTrajectoryController(_ClosedLoopTrajectoryController):
    """``velocity_controllers/JointTrajectoryController``."""

    interface = VelocityJointInterface


class EffortJointTrajectoryController(_ClosedLoopTrajectoryController):
    """``effort_controllers/JointTrajectoryController``."""

    parameters = _ClosedLoopTrajectoryController.parameters | {"gravity_compensation"}
    interface = EffortJointInterface

    def _gravities(
        self, hw: RobotHW, root: NodeHandle, node: NodeHandle
    ) -> Sequence[Optional[JointGravity]]:
        if not node.param("gravity_compensation", bool, False):
            return super()._gravities(hw, root, node)
        return [joint_gravity(hw, root, name) for name in self._names]
