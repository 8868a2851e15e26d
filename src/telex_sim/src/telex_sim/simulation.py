"""The simulation of one robot: the loop's order, reset and emergency stop, without ROS.

One thread owns a `Simulation`; only `request_e_stop` may be called from others.
"""

from __future__ import annotations

from typing import Callable, Dict, List

from telex_control.controller_manager import ControllerManager
from telex_control.node_handle import NodeHandle
from telex_control.params import ConfigError
from telex_control.urdf_joints import UrdfJoint, joints, parse_urdf

from .config import SimulatorConfig
from .phase_timer import PhaseTimer
from .robot_hw_sim import RobotHWSim
from .traction import Traction
from .world import Body, World


class Simulation:
    """World, robot, controllers and tracks, advanced step by step.

    Sim time never runs back: a reset restores the scene, not the clock, since tf, bags and
    timers do not survive a clock that jumps.

    Parameters
    ----------
    config : SimulatorConfig
    urdf : str
    node : NodeHandle
        The robot's namespace, for the controllers.
    resolve : callable
        Turns a mesh address (``package://…``) into a path.

    Raises
    ------
    ConfigError, UrdfError, WorldError
        With a message for a person.
    """

    def __init__(
        self,
        config: SimulatorConfig,
        urdf: str,
        node: NodeHandle,
        resolve: Callable[[str], str],
    ) -> None:
        self.config = config
        self.timer = PhaseTimer()
        self.urdf = urdf
        self._resolve = resolve
        self._step_size = config.timing.step_size
        self._steps_per_cycle = config.timing.steps_per_cycle
        self.steps = 0
        robot = parse_urdf(urdf)
        self.hw = RobotHWSim(robot, config.hardware)
        self.controllers = ControllerManager(self.hw, node)
        self._check_joints(joints(robot))
        self._belts = [
            (self.hw.joint_state(joint), radius) for joint, radius in config.tracks.belts.items()
        ]
        # What was asked for last, and how often a stop was: each one is obeyed for a cycle at
        # least, even if its release follows at once.
        self._e_stop_wanted = False
        self._e_stop_presses = 0
        self._e_stop_obeyed = 0
        self.world = World(self._step_size, config.solver_iterations, config.gui)
        self._place_robot()

    def _check_joints(self, described: Dict[str, UrdfJoint]) -> None:
        """Refuse a configuration that names joints which are not there, or beyond their limits."""
        for joint in self.config.tracks.belts:
            if not self.hw.has_joint(joint):
                raise ConfigError(f"tracks/belts/{joint}: the robot has no driven joint '{joint}'")
        for joint, position in self.config.start.joint_positions().items():
            where = f"start/poses/{self.config.start.pose}/{joint}"
            if joint not in described:
                raise ConfigError(f"{where}: the robot has no joint '{joint}'")
            limits = described[joint]
            if not limits.lower <= position <= limits.upper:
                raise ConfigError(
                    f"{where} is {position}; its limits are {limits.lower} to {limits.upper}"
                )

    def _place_robot(self) -> None:
        start = self.config.start
        self.body: Body = self.world.load_robot(
            self.urdf, self._resolve, start.position, start.yaw, start.joint_positions()
        )
        self.hw.attach(self.body)
        self._traction = Traction(self.body, self.config.tracks, self._step_size)

    @property
    def time(self) -> float:
        """Sim time (s)."""
        return self.steps * self._step_size

    @property
    def at_cycle_start(self) -> bool:
        """Whether the next step begins a control cycle."""
        return self.steps % self._steps_per_cycle == 0

    def request_e_stop(self, active: bool) -> None:
        """Set or release the emergency stop with the next step. May be called from any thread."""
        self._e_stop_wanted = active
        if active:
            self._e_stop_presses += 1

    def step(self) -> None:
        """Advance by one physics step, with a control cycle before it when one is due."""
        timer = self.timer
        timer.begin()
        if self.at_cycle_start:
            self._control(timer)
        self.hw.write(self.time, self._step_size)
        timer.end("write")
        self._traction.apply([state.velocity * radius for state, radius in self._belts])
        timer.end("traction")
        self.world.step()
        self.steps += 1
        timer.end("step")

    def _control(self, timer: PhaseTimer) -> None:
        released = self._obey_e_stop()
        self.hw.read(self.time, self.config.timing.control_period)
        timer.end("read")
        self.controllers.update(
            self.time, self.config.timing.control_period, reset_controllers=released
        )
        timer.end("update")
        timer.count_cycle()

    def _obey_e_stop(self) -> bool:
        """Carry out a request; returns whether the stop was released just now."""
        presses, self._e_stop_obeyed = self._e_stop_obeyed, self._e_stop_presses
        wanted = self._e_stop_wanted or presses != self._e_stop_obeyed
        if wanted == self.hw.e_stop:
            return False
        self.hw.set_e_stop(wanted)
        return not wanted

    def idle(self) -> None:
        """What goes on while paused: controllers are switched, and an emergency stop is set."""
        if self._obey_e_stop():
            # Without a cycle of their own, the controllers drop what they were told meanwhile.
            self.controllers.restart_running(self.time)
        self.controllers.apply_switch(self.time)

    def reset(self) -> None:
        """Put everything back to where it began; time goes on."""
        self.world.clear()
        self._place_robot()
        self.controllers.reset(self.time)

    def link_poses(self) -> List[float]:
        """Poses of the robot's links, 7 numbers each, in the order of ``body.link_names()``."""
        return self.body.link_poses()

    def close(self) -> None:
        """Release the controllers' callers and PyBullet."""
        self.controllers.close()
        self.world.close()
