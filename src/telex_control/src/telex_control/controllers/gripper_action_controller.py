"""``{position,effort}_controllers/GripperActionController``, and what grippers have in common."""

from __future__ import annotations

import math
from collections import deque
from typing import Any, ClassVar, Deque, NamedTuple, Optional, Tuple

from control_msgs.msg import GripperCommandAction, GripperCommandFeedback, GripperCommandResult

from ..common.periodic import Periodic
from ..common.plausible import effort_problem, position_problem
from ..common.stateful import Names
from ..hardware.hardware_interface import EffortJointInterface, PositionJointInterface, RobotHW
from ..hardware.joint_limits import clamp
from ..laws.pid_reconfigure import PidSet
from ..manager.controller import Controller
from ..manager.pending import drain
from ..ros.node_handle import ActionGoal, NodeHandle
from .joint_description import joint_description


class GripperState(NamedTuple):
    """Measured opening (m, rad), its rate, and the force of the grip (N, Nm)."""

    position: float
    velocity: float
    effort: float


class GripperCommandController(Controller):
    """Carries out ``gripper_cmd`` (control_msgs/GripperCommand) by what a subclass commands.

    Parameters: ``goal_tolerance``, ``max_effort`` (0: as much as the joints have),
    ``stall_velocity_threshold``, ``stall_timeout`` (s), ``action_monitor_rate`` (20 Hz),
    ``allow_stalling``. A goal whose max_effort is not above 0 takes the parameter's.

    A gripper that stands still for the time-out short of its goal has stalled. Then the goal is
    aborted, or succeeds with ``allow_stalling``: a stall is how a grasp ends. Either way the
    gripper goes on pressing.
    """

    parameters = frozenset(
        (
            "action_monitor_rate",
            "allow_stalling",
            "goal_tolerance",
            "max_effort",
            "stall_timeout",
            "stall_velocity_threshold",
        )
    )
    SAVED: ClassVar[Names] = ("_max_effort", "_position")
    SAVED_TIMES = ("_moved",)
    SAVED_PARTS: ClassVar[Names] = ("_feedback_timer",)
    goal_tolerance = 0.01
    """Default of the parameter; as are the next two."""
    stall_velocity_threshold = 0.001
    allow_stalling = False

    def init(self, hw: RobotHW, root: NodeHandle, node: NodeHandle) -> None:
        """Claim the joints and open the action."""
        self._node = node
        self._goal_tolerance = node.positive_param("goal_tolerance", self.goal_tolerance)
        self._default_effort = node.positive_param("max_effort", 0.0, zero=True) or math.inf
        self._stall_velocity = node.positive_param(
            "stall_velocity_threshold", self.stall_velocity_threshold
        )
        self._stall_timeout = node.positive_param("stall_timeout", 1.0)
        self._allow_stalling = node.param("allow_stalling", bool, self.allow_stalling)
        self._feedback_timer = Periodic(node.positive_param("action_monitor_rate", 20.0))
        self._init_joints(hw, root, node)
        self._running = False
        self._goals: Deque[ActionGoal] = deque()
        self._active: Optional[ActionGoal] = None
        self._position = 0.0
        self._max_effort = self._default_effort
        self._moved = 0.0
        node.serve_action("gripper_cmd", GripperCommandAction, self._on_goal)

    def _init_joints(self, hw: RobotHW, root: NodeHandle, node: NodeHandle) -> None:
        """Claim the joints."""
        raise NotImplementedError

    def _limits(self) -> Tuple[float, float]:
        """Return the least and the largest opening."""
        raise NotImplementedError

    def _measure(self) -> GripperState:
        """Return how the gripper is."""
        raise NotImplementedError

    def _start(self) -> None:
        """Forget what was commanded before."""
        raise NotImplementedError

    def _command(self, time: float, period: float, position: float, max_effort: float) -> None:
        """Command the joints towards an opening, with no more than an effort."""
        raise NotImplementedError

    def _release(self) -> None:
        """Give the joints up."""
        raise NotImplementedError

    def _on_goal(self, goal: ActionGoal) -> None:
        command = goal.message.command
        problem = None
        if not self._running:
            problem = "the controller is not running"
        else:
            beyond = position_problem(command.position, *self._limits())
            too_strong = effort_problem(command.max_effort)
            if beyond:
                problem = f"position {command.position} {beyond} and is dropped"
            elif too_strong:
                problem = f"max_effort {command.max_effort} {too_strong} and is dropped"
        if problem is not None:
            self._node.warn(f"{self._node.resolve('gripper_cmd')}: {problem}")
            goal.reject(GripperCommandResult(), problem)
            return
        goal.accept()
        self._goals.append(goal)
        if not self._running:
            # It was stopped meanwhile: nobody else would end the goal.
            self._drop_goals()

    def starting(self, time: float) -> None:
        """Hold the measured opening."""
        self._drop_goals()
        self._hold()
        self._start()
        self._running = True

    def _hold(self) -> None:
        self._position = clamp(self._measure().position, *self._limits())
        self._max_effort = self._default_effort

    def update(self, time: float, period: float) -> None:
        """Move on, and end the goal when it is reached or the gripper has stalled."""
        if self._active is not None and self._active.cancel_requested:
            self._cancel("cancelled by a client")
            self._hold()
        for goal in drain(self._goals):
            self._cancel("replaced by a newer goal")
            self._active = goal
            command = goal.message.command
            self._position = clamp(command.position, *self._limits())
            self._max_effort = self._default_effort
            if command.max_effort > 0.0:
                self._max_effort = min(command.max_effort, self._default_effort)
            self._moved = time
        if self._active is not None:
            self._check(self._active, time)
        self._command(time, period, self._position, self._max_effort)

    def _check(self, goal: ActionGoal, time: float) -> None:
        state = self._measure()
        if abs(self._position - state.position) < self._goal_tolerance:
            self._active = None
            goal.succeed(self._fill(GripperCommandResult(), state, reached=True))
            return
        if abs(state.velocity) > self._stall_velocity:
            self._moved = time
        elif time - self._moved > self._stall_timeout:
            self._active = None
            result = self._fill(GripperCommandResult(), state, stalled=True)
            text = f"stalled at {state.position:.4f}, short of {self._position:.4f}"
            if self._allow_stalling:
                goal.succeed(result, text)
            else:
                goal.abort(result, text)
            return
        if self._feedback_timer.is_due(time):
            goal.publish_feedback(self._fill(GripperCommandFeedback(), state))

    def _fill(
        self, message: Any, state: GripperState, reached: bool = False, stalled: bool = False
    ) -> Any:
        message.position = state.position
        message.effort = state.effort
        message.reached_goal = reached
        message.stalled = stalled
        return message

    def stopping(self, time: float) -> None:
        """Give up the joints; a goal is cancelled."""
        self._running = False
        self._cancel("the controller was stopped")
        self._drop_goals()
        self._release()

    def restore_state(self, saved: Any, elapsed: float) -> None:
        """Take a state up again; goals are cancelled, and none is taken up."""
        self._cancel("the simulation went back to a bookmark")
        self._drop_goals("the simulation went back to a bookmark")
        super().restore_state(saved, elapsed)

    def _cancel(self, text: str) -> None:
        if self._active is not None:
            self._active.cancel(self._fill(GripperCommandResult(), self._measure()), text)
            self._active = None

    def _drop_goals(self, text: str = "the controller was stopped") -> None:
        for goal in drain(self._goals):
            goal.cancel(GripperCommandResult(), text)


class _JointGripperController(GripperCommandController):
    """A gripper with a single joint (parameter ``joint``); position and effort are the joint's."""

    parameters = GripperCommandController.parameters | {"joint"}
    interface: Any

    def _init_joints(self, hw: RobotHW, root: NodeHandle, node: NodeHandle) -> None:
        name = node.param("joint", str)
        self._joint = hw.get(self.interface).get_handle(name)
        limits = joint_description(root, name)
        self._bounds = (limits.lower, limits.upper)

    def _limits(self) -> Tuple[float, float]:
        return self._bounds

    def _measure(self) -> GripperState:
        state = self._joint.state
        return GripperState(state.position, state.velocity, state.effort)


class PositionGripperActionController(_JointGripperController):
    """``position_controllers/GripperActionController``; the drive limits the effort."""

    interface = PositionJointInterface

    def _start(self) -> None:
        self._joint.command = self._position

    def _command(self, time: float, period: float, position: float, max_effort: float) -> None:
        self._joint.command = position

    def _release(self) -> None:
        self._joint.command = self._joint.state.position


class EffortGripperActionController(_JointGripperController):
    """``effort_controllers/GripperActionController``: a PID (``gains/<joint>``), limited."""

    parameters = _JointGripperController.parameters | {"gains"}
    SAVED_PARTS = ("_pid",)
    interface = EffortJointInterface

    def _init_joints(self, hw: RobotHW, root: NodeHandle, node: NodeHandle) -> None:
        super()._init_joints(hw, root, node)
        self._pids = PidSet(node)
        self._pid = self._pids.open(f"gains/{self._joint.name}")

    def _start(self) -> None:
        self._pid.reset()

    def _command(self, time: float, period: float, position: float, max_effort: float) -> None:
        state = self._joint.state
        effort = self._pid.update(position - state.position, period, -state.velocity)
        self._joint.command = clamp(effort, -max_effort, max_effort)
        self._pids.publish(time)

    def _release(self) -> None:
        self._joint.command = 0.0
