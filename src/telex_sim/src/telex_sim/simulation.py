"""The simulation of one robot in a scene: the loop's order, reset and emergency stop, without ROS.

One thread owns a `Simulation`; only `request_e_stop` and `plan` may be called from others.
"""

from __future__ import annotations

import logging
import time
from typing import Callable, Dict, List, Sequence

from telex_control.controller_manager import ControllerManager
from telex_control.node_handle import NodeHandle
from telex_control.params import ConfigError
from telex_control.urdf_joints import UrdfJoint, joints, parse_urdf

from .config import SimulatorConfig
from .phase_timer import PhaseTimer
from .robot_hw_sim import RobotHWSim
from .scene.assembly import Assembly
from .scene.assets import Assets
from .scene.bodies import SceneBodies
from .scene.catalog import find_scene
from .scene.model import WORLD_FRAME
from .scene.planning import PlannedScene, Progress, plan_entry, plan_scene
from .scene.scene_file import SceneError
from .self_collision import disable_pairs
from .start_check import check_start
from .traction import Traction
from .world import Body, World, WorldError

_log = logging.getLogger("rosout")


class Simulation:
    """World, robot, scene, controllers and tracks, advanced step by step.

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

    Attributes
    ----------
    scene : Scene
        As its file says; what is spawned and deleted changes `objects` only.
    objects : SceneBodies

    Raises
    ------
    ConfigError, SceneError, UrdfError, WorldError
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
        self._assets = Assets()
        self._planned = self._plan_scene()
        self.scene = self._planned.scene
        robot = parse_urdf(urdf)
        self.hw = RobotHWSim(robot, config.hardware)
        self.controllers = ControllerManager(self.hw, node)
        self._start_positions = self._check_joints(joints(robot))
        config.self_collision.check_links([link.get("name", "") for link in robot.iter("link")])
        self._belts = [
            (self.hw.joint_state(joint), radius) for joint, radius in config.tracks.belts.items()
        ]
        # What was asked for last, and how often a stop was: each one is obeyed for a cycle at
        # least, even if its release follows at once.
        self._e_stop_wanted = False
        self._e_stop_presses = 0
        self._e_stop_obeyed = 0
        self.world = World(self._step_size, config.solver_iterations, config.gui)
        self.objects = SceneBodies(self.world.client, self._step_size)
        self._fill_world()
        self._check_start()

    def _check_joints(self, described: Dict[str, UrdfJoint]) -> Dict[str, float]:
        """Refuse a configuration that names joints which are not there, or beyond their limits.

        Returns
        -------
        dict of str to float
            Where the robot's joints start; without those of the pose that only variants have.
        """
        for joint in self.config.tracks.belts:
            if not self.hw.has_joint(joint):
                raise ConfigError(f"tracks/belts/{joint}: the robot has no driven joint '{joint}'")
        start, asked = self.config.start, self.scene.start.pose
        if start.pose_name(asked) not in ("", *start.poses):
            raise SceneError(
                f"{self._planned.path}: start/pose is '{asked}'; "
                f"there are: {', '.join(sorted(start.poses)) or 'none'}"
            )
        positions = {}
        for joint, position in start.joint_positions(asked).items():
            where = f"start/poses/{start.pose_name(asked)}/{joint}"
            if joint not in described and joint in self.config.hardware.optional_joints:
                _log.info("%s: left out, for this robot has no such joint", where)
                continue
            if joint not in described:
                raise ConfigError(
                    f"{where}: the robot has no joint '{joint}'; one that only some variants have "
                    "belongs into hardware/optional_joints"
                )
            limits = described[joint]
            if not limits.lower <= position <= limits.upper:
                raise ConfigError(
                    f"{where} is {position}; its limits are {limits.lower} to {limits.upper}"
                )
            positions[joint] = position
        return positions

    def _plan_scene(self) -> PlannedScene:
        began = time.monotonic()
        planned = plan_scene(find_scene(self.config.world), self._assets, self._step_size)
        try:
            self._check_names(planned.assemblies)
        except ConfigError as error:
            raise SceneError(f"{planned.path}: objects: {error}") from error
        _log.info("scene %s: read in %.1f s", planned.scene.name, time.monotonic() - began)
        return planned

    def _check_names(self, assemblies: Sequence[Assembly]) -> None:
        for name in (assembly.source.name for assembly in assemblies):
            if name in (self.config.model, WORLD_FRAME):
                raise ConfigError(f"name is '{name}'; it is that of another frame already")

    def _fill_world(self) -> None:
        """Put the scene and the robot into an empty world."""
        self._load_scene()
        start, where = self.config.start, self.scene.start
        self.body: Body = self.world.load_robot(
            self.urdf,
            self._resolve,
            (where.x, where.y, where.ground + start.height),
            where.yaw,
            self._start_positions,
        )
        disable_pairs(self.body, self.config.self_collision)
        self.hw.attach(self.body)
        self._traction = Traction(self.body, self.config.tracks, self._step_size)

    def _check_start(self) -> None:
        """Refuse a start that would throw the robot; a reset leads back to the same one."""
        objects = {
            uid: f"'{each.name}'"
            for each in self.objects.objects()
            for uid in self.objects.bodies_of(each.name)
        }
        pose = self.config.start.pose_name(self.scene.start.pose)
        try:
            check_start(self.body, pose, lambda uid: objects.get(uid, "the floor"))
        except WorldError:
            self.close()
            raise

    def _load_scene(self) -> None:
        name, began = self.scene.name, time.monotonic()
        plans = self._planned.assemblies
        try:
            self.objects.load(self.scene.floor, plans, Progress(name, "in place"))
        except ConfigError as error:
            raise WorldError(f"{self._planned.path}: {error}") from error
        _log.info("scene %s: %d objects in %.1f s", name, len(plans), time.monotonic() - began)

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
        self.objects.apply()
        timer.end("mechanisms")
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
        self._fill_world()
        self.controllers.reset(self.time)

    def plan(self, text: str, name: str = "", folder: str = "") -> List[Assembly]:
        """Prepare an entry for `spawn`; may be called from any thread.

        Parameters
        ----------
        text : str
            YAML of an entry of a scene file's ``objects``.
        name : str
            Of the entry; empty: its own, or else its type and a number.
        folder : str
            That relative addresses start from; empty allows none.

        Raises
        ------
        ConfigError
        """
        taken = [item.name for item in self.objects.objects()]
        plans = plan_entry(text, name, folder, taken, self._assets, self._step_size)
        self._check_names(plans)
        return plans

    def spawn(self, plans: Sequence[Assembly]) -> None:
        """Put objects into the running scene, all or none.

        Raises
        ------
        ConfigError
            A name is taken, an object would stand in the robot, or there are too many.
        """
        self.objects.add(plans, (self.body.uid,))
        self._traction.forget_surfaces()

    def delete(self, name: str) -> List[str]:
        """Take an object, or all that one entry made, out of the running scene.

        Raises
        ------
        ConfigError
            There is nothing of this name.
        """
        gone = self.objects.remove(name)
        if not gone:
            raise ConfigError(f"name is '{name}'; there is no such object")
        self._traction.forget_surfaces()
        return gone

    def link_poses(self) -> List[float]:
        """Poses of all that moves, 7 numbers each.

        The robot's links come in the order of ``body.link_names()``, then the objects' in that of
        ``objects.frames()``.
        """
        return self.body.link_poses() + self.objects.poses()

    def close(self) -> None:
        """Release the controllers' callers and PyBullet."""
        self.controllers.close()
        self.world.close()
