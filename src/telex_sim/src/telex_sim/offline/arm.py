"""The arm of a simulation without ROS master, led along ways of the tool."""

from __future__ import annotations

from typing import Callable, Dict, List, Mapping, Sequence

import numpy as np
from control_msgs.msg import JointControllerState
from std_msgs.msg import Float64

from telex_control.controllers.effort_joint_position_controller import EffortJointPositionController
from telex_control.follow_trajectory import FollowTrajectoryError
from telex_control.follow_trajectory.analysis import PathRecording
from telex_control.follow_trajectory.paths import Shape, circle
from telex_control.follow_trajectory.reference import PlannedPath, plan
from telex_control.follow_trajectory.speed_profile import SpeedProfile
from telex_control.kinematics import Chain, IKSolver
from telex_control.ros.local_node_handle import LocalNodeHandle

from ..engine.simulation import Simulation
from .simulation import robot_description, shipped_config

_FILTER_STAGES = 2
"""Of a position controller's command filter; each lets what moves wait for 1 / its frequency."""


class OfflineArm:
    """A `telex_control.follow_trajectory.follower.PathRig` in memory.

    References are handed over by the number of the step, by the controllers' topics, and read back
    from the controllers before the step is made: what comes of them hangs on no clock.

    Parameters
    ----------
    simulation : Simulation
        Whose position controllers run; they say what they hold once it has made a step (`wait`).
    joints : sequence of str
        Of the arm, each with a position controller.
    rate : float, optional
        Of the references (Hz); left out: one for every control cycle.

    Attributes
    ----------
    each_step : list of callable
        Called with a step's number, from 0, before it is made along what is streamed: for
        measurements.
    """

    def __init__(
        self,
        simulation: Simulation,
        node: LocalNodeHandle,
        joints: Sequence[str],
        rate: float = 0.0,
    ) -> None:
        self._simulation = simulation
        self._joints = tuple(joints)
        timing = simulation.config.timing
        self._step = timing.step_size
        self._cycle = timing.steps_per_cycle
        self._every = round(1.0 / (rate * self._step)) if rate else self._cycle
        self._states: Dict[str, JointControllerState] = {}
        self._commands = {}
        self._controllers: Dict[str, EffortJointPositionController] = {}
        delays = []
        for joint in self._joints:
            name = joint.replace("_joint", "_position_controller")
            frequency = node.find_param(f"{name}/command_filter_frequency", 0.0)
            delays.append(_FILTER_STAGES / frequency if frequency else 0.0)
            self._commands[joint] = node.advertise(f"/{name}/command", Float64)
            controller = simulation.controllers.controller(name)
            if not isinstance(controller, EffortJointPositionController):
                raise TypeError(f"controller '{name}' is no position controller: {controller}")
            self._controllers[joint] = controller
            node.subscribe(f"/{name}/state", JointControllerState, self._keeper(joint))
        self._filter_lag = max(delays)
        self.each_step: List[Callable[[int], None]] = []

    def _keeper(self, joint: str) -> Callable[[JointControllerState], None]:
        def keep(message: JointControllerState) -> None:
            self._states[joint] = message

        return keep

    def reference(self, joint: str) -> float:
        """See `PathRig`."""
        return float(self._states[joint].set_point)

    def position(self, joint: str) -> float:
        """See `PathRig`."""
        return float(self._simulation.hw.joint_positions()[joint])

    def lag(self) -> float:
        """See `PathRig`: of the filter, and of a reference that is held, in the mean."""
        return self._filter_lag + 0.5 * (self._every - self._cycle) * self._step

    def wait(self, seconds: float) -> None:
        """See `PathRig`."""
        for _ in range(round(seconds / self._step)):
            self._simulation.step()

    def stream(
        self, references: Callable[[float], Mapping[str, float]], end: float
    ) -> PathRecording:
        """See `PathRig`; positions are recorded at every control cycle.

        Raises
        ------
        FollowTrajectoryError
            A controller does not hold what it was sent.
        """
        states = [self._simulation.hw.joint_state(joint) for joint in self._joints]
        times, positions = [], []
        for index in range(round(end / self._step) + 1):
            if index % self._every == 0:
                for joint, value in references(index * self._step).items():
                    self._commands[joint].publish(Float64(value))
                    held = self._controllers[joint].set_point
                    if held != value:
                        raise FollowTrajectoryError(
                            f"{joint} was sent to {value} at {index * self._step:.3f} s, and its "
                            f"controller holds {held}"
                        )
            if index % self._cycle == 0:
                times.append(index * self._step)
                positions.append([state.position for state in states])
            for measure in self.each_step:
                measure(index)
            self._simulation.step()
        return PathRecording(np.array(times), np.array(positions))


def plan_circle(shape: Shape, pose: str, speed: float, acceleration: float) -> PlannedPath:
    """Plan a way of the tool from a named pose, whose orientation it keeps.

    Parameters
    ----------
    pose : str
        Named pose of the shipped robot.
    speed, acceleration : float
        m/s, m/s2.
    """
    chain = Chain.from_urdf(robot_description(), "base_link", "tool_link")
    positions = shipped_config(start__pose=pose).start.joint_positions()
    seed = [positions[name] for name in chain.joint_names]
    path = circle(shape)
    profile = SpeedProfile(path.length, path.stops, speed, acceleration)
    return plan(IKSolver(chain), path, profile, chain.forward(seed)[:3, :3], seed, 0.002)
