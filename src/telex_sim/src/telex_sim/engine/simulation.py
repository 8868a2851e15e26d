"""The simulation of robots in a scene: the loop's order, reset and emergency stop, without ROS.

One thread owns a `Simulation`; only `request_e_stop`, `plan`, `plan_scene` and `plan_robot` may be
called from others.
"""

from __future__ import annotations

import logging
import time
from pathlib import Path
from typing import Any, Callable, Dict, Iterator, List, Optional, Sequence, Tuple

from telex_control.common.geometry.quaternions import Pose
from telex_control.common.params import ConfigError
from telex_control.manager.controller_manager import ControllerManager
from telex_control.ros.node_handle import NodeHandle
from telex_control.urdf.joints import UrdfError

from ..proximity.monitor import Proximity
from ..rehearsal.trial import Rehearsal, check_names, check_scene
from ..robot.gripper.contact import GripperContact
from ..robot.meshes import check_meshes
from ..robot.robot import Robot
from ..robot.robot_hw_sim import RobotHWSim
from ..scene.assets import Assets
from ..scene.files.scene_file import SceneError
from ..scene.model import WORLD_FRAME, Scene, Start
from ..scene.objects.assembly import Assembly
from ..scene.objects.bodies import SceneBodies
from ..scene.objects.body_maker import MeshLists
from ..scene.objects.irradiation import SceneField
from ..scene.objects.leaks import SceneGas
from ..scene.objects.places import steady
from ..scene.planning import PlannedScene, Progress, plan_entry, plan_world
from .phase_timer import PhaseTimer
from .simulator_config import TUNED_PERIOD, RobotConfig, SimulatorConfig
from .start_check import check_place, check_start, move_aside, place_beside, start_in_scene
from .world import Body, World, WorldError
from .world_state import WorldState

_log = logging.getLogger("rosout")

FLOOR = "floor"
"""Name of the ground among those that the arm is near to."""


class Simulation:
    """World, scene and robots, advanced step by step.

    It begins with one robot; others may come and go.

    Sim time never runs back: a reset restores the scene, not the clock, since tf, bags and
    timers do not survive a clock that jumps.

    Parameters
    ----------
    node : NodeHandle
        The robot's namespace, for the controllers.
    resolve : callable
        Turns a mesh address (``package://…``) into a path.

    Attributes
    ----------
    scene : Scene
        As its file says; what is spawned and deleted changes `objects` only. Another one comes by
        `change_scene`.
    scene_path : Path
        Of its file.
    robots : tuple of Robot
        The one that it began with, then those that were added. Replaced as a whole.
    changes : int
        How often bodies have come, gone, or been made anew.
    structure : int
        How often other objects or robots have come to be there. A state can be restored as long as
        it is the same.
    last_change : str
        What the last time was, in words.

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
        _warn_of_long_period(config.timing.control_period)
        self.timer = PhaseTimer()
        self._resolve = resolve
        self._step_size = config.timing.step_size
        self._steps_per_cycle = config.timing.steps_per_cycle
        self.steps = 0
        self.changes = 0
        self.structure = 0
        self.last_change = ""
        # Whether there are others than were loaded: a reset changes that back.
        self._altered = False
        # Of the bodies that there were at a number of `changes`.
        self._bodies: Optional[Tuple[int, WorldState]] = None
        # Number of `changes` since which the constraints of latches come last.
        self._ordered = -1
        # What a reset puts back: structure, steps, bodies, objects.
        self._start: Optional[Tuple[int, int, Any, Any]] = None
        self._field: Tuple[int, Optional[SceneField]] = (-1, None)
        self._gas: Tuple[int, Optional[SceneGas]] = (-1, None)
        self._assets = Assets()
        self.robots: Tuple[Robot, ...] = ()
        self._names: Dict[int, str] = {}
        self._meshes = MeshLists()
        self._planned = self.plan_scene(config.world)
        step, pose = self._step_size, self.scene.start.pose
        check_meshes(urdf, resolve, lambda problem: _log.warning("robot_description: %s", problem))
        self.robots = (Robot(config, urdf, node, resolve, step, pose),)
        self.world = World(self._step_size, config.solver_iterations, config.gui)
        self.objects = SceneBodies(self.world.client, self._step_size, self._meshes)
        self._fill_world()
        try:
            self._check_start()
        except (ConfigError, WorldError) as error:
            self.close()
            raise WorldError(f"{self.scene_path}: {error}") from error
        self._put_back()

    @property
    def scene(self) -> Scene:
        """What is loaded, as its file says."""
        return self._planned.scene

    @property
    def scene_path(self) -> Path:
        """Path of its file."""
        return self._planned.path

    @property
    def hw(self) -> RobotHWSim:
        """Hardware of the first robot."""
        return self.robots[0].hw

    @property
    def controllers(self) -> ControllerManager:
        """Controller manager of the first robot."""
        return self.robots[0].controllers

    @property
    def body(self) -> Body:
        """Body of the first robot."""
        return self.robots[0].body

    def plan_scene(self, world: str) -> PlannedScene:
        """Prepare a scene for `change_scene`; may be called from any thread.

        Parameters
        ----------
        world : str
            Its name, the path of its file, or its text.

        Raises
        ------
        SceneError
        """
        began = time.monotonic()
        planned = plan_world(world, self._assets, self._step_size)
        check_scene(self.config, planned, self._models())
        _log.info("scene %s: read in %.1f s", planned.scene.name, time.monotonic() - began)
        return planned

    def _models(self) -> List[str]:
        return [robot.model for robot in self.robots] or [self.config.model]

    def _fill_world(self) -> None:
        """Put the scene and the robots into an empty world; `_put_back` is to follow.

        What is put back differs by its rounding: so it is the same from the first time on. It takes
        a step, which with bodies in each other lasts for minutes: they are refused before.
        """
        self._load_scene()
        first, *others = self.robots
        self._place(first, ())
        for number, robot in enumerate(others, 1):
            self._place_again(robot, self.robots[:number])
        self._name_bodies()
        bodies, objects = self._world_state().save_state(), self.objects.save_state()
        self._start = (self.structure, self.steps, bodies, objects)

    def _place(self, robot: Robot, others: Sequence[Robot]) -> None:
        """Put a robot where its configuration says, or the scene: at its start, or beside that.

        Raises
        ------
        ConfigError
            There is no room.
        UrdfError, WorldError
            PyBullet refuses it.
        """

        def load(start: Start) -> Body:
            robot.place(self.world, start, self.objects.material)
            return robot.body

        if not others:
            load(self.scene.start)
            return
        own = start_in_scene(self.scene, robot.config.start, len(others))
        robot.start_from(robot.figure.start_positions(own.pose if own is not None else ""))
        if own is not None or not robot.config.start.looks_for_room:
            load(own or self.scene.start)
            return
        there = {each.body.uid: each.model for each in others}
        place_beside(self.world, self.scene.start, there, load, f"robot '{robot.model}'")

    def _place_again(self, robot: Robot, others: Sequence[Robot]) -> None:
        """Put a further robot where `_place` does, or aside where something else stands by now."""
        try:
            self._place_in_room(robot, others, f"robot '{robot.model}'")
        except ConfigError as error:
            start = self.scene.start
            robot.place(self.world, start, self.objects.material)
            move_aside(self.world, robot.body, start.yaw)
            x, y, _ = robot.body.base_pose()[0]
            _log.warning("%s; it begins at x %.1f, y %.1f", error, x, y)

    def _place_in_room(self, robot: Robot, others: Sequence[Robot], name: str) -> None:
        """Put a further robot where `_place` does; where it stands in something, it is not there.

        Raises
        ------
        ConfigError, UrdfError, WorldError
            It cannot stand there, or cannot be made.
        """
        before = self.world.bodies()
        try:
            self._place(robot, others)
            check_place(self.world, robot.body, self._owners(others), name)
        except BaseException:
            self.world.remove_others(before)
            raise

    def _check_start(self) -> None:
        """Refuse a start that would throw objects or the robot; a reset leads back to it.

        Raises
        ------
        ConfigError, WorldError
        """
        self.objects.check_room()
        if self.config.fixed_base:
            return
        owners = self._owners(self.robots)
        pose = self.config.start.pose_name(self.scene.start.pose)
        check_start(self.body, pose, lambda uid: owners.get(uid, "the floor"))

    def _load_scene(self) -> None:
        name, began = self.scene.name, time.monotonic()
        plans = self._planned.assemblies
        try:
            self.objects.load(self.scene.floor, plans, Progress(name, "in place"))
        except ConfigError as error:
            raise WorldError(f"{self._planned.path}: {error}") from error
        _log.info("scene %s: %d objects in %.1f s", name, len(plans), time.monotonic() - began)

    def change_scene(self, planned: PlannedScene) -> None:
        """Try another scene, and put it in the place of this one; for the robots it is a reset.

        Raises
        ------
        SceneError
            There is no room for a robot in it, or PyBullet refuses it; nothing has changed.
        """
        check_scene(self.config, planned, self._models())
        with Rehearsal(self.config, self._resolve, self._meshes) as rehearsal:
            rehearsal.scene(planned, [robot.figure for robot in self.robots])
        self.put_scene(planned)

    def put_scene(self, planned: PlannedScene) -> None:
        """Put a scene that was tried in the place of this one; for the robots it is a reset.

        Raises
        ------
        SceneError
            It is not for these robots; nothing has changed.
        """
        check_scene(self.config, planned, self._models())
        first = self.robots[0]
        try:
            positions = first.figure.start_positions(planned.scene.start.pose)
        except ConfigError as error:
            raise SceneError(f"{planned.path}: {error}") from error
        self._planned = planned
        first.start_from(positions)
        self._note_change(f"scene {planned.scene.name} was loaded")
        self._refill()

    @property
    def time(self) -> float:
        """Sim time (s)."""
        return self.steps * self._step_size

    @property
    def at_cycle_start(self) -> bool:
        """Whether the next step begins a control cycle."""
        return self.steps % self._steps_per_cycle == 0

    def request_e_stop(self, active: bool) -> None:
        """Set or release the first robot's emergency stop. May be called from any thread."""
        self.robots[0].request_e_stop(active)

    def step(self) -> None:
        """Advance by one physics step, with a control cycle before it when one is due."""
        timer = self.timer
        timer.begin()
        robots, now = self.robots, self.time
        if self.at_cycle_start:
            self._control(timer)
        for robot in robots:
            robot.hw.write(now, self._step_size)
        timer.end("write")
        for robot in robots:
            robot.apply_traction()
        timer.end("traction")
        self.objects.apply()
        timer.end("mechanisms")
        self.world.step()
        self.steps += 1
        timer.end("step")

    def _control(self, timer: PhaseTimer) -> None:
        robots, now = self.robots, self.time
        period = self.config.timing.control_period
        released = [robot.obey_e_stop() for robot in robots]
        for robot in robots:
            robot.hw.read(now, period)
            if robot.malfunctions.battery is not None:
                robot.malfunctions.run(period)
        timer.end("read")
        for robot, anew in zip(robots, released):
            robot.controllers.update(now, period, reset_controllers=anew)
        timer.end("update")
        timer.count_cycle()

    def idle(self) -> None:
        """What goes on while paused: controllers are switched, and emergency stops are set."""
        for robot in self.robots:
            robot.idle(self.time)

    def reset(self) -> None:
        """Put everything back to where it began; time goes on.

        The world is filled anew only where objects or robots have come or gone since it was.

        Raises
        ------
        ConfigError
            A robot cannot be loaded again; nothing has changed.
        """
        assert self._start is not None
        if not self._altered and self._start[0] == self.structure:
            self._put_back()
            self._reset_controllers()
            return
        self._try_robots()
        if self._altered:
            self._note_change("a reset brought back what was loaded")
        self._refill()

    def _try_robots(self) -> None:
        """Load the robots once more beside those that there are, and take them out again.

        PyBullet keeps the meshes that a client has read: another world would miss files that this
        one can do without.

        Raises
        ------
        ConfigError
            One cannot be loaded.
        """
        before = self.world.bodies()
        try:
            for robot in self.robots:
                robot.figure.load(self.world, self.scene.start, {}, self._resolve)
        except (UrdfError, WorldError) as error:
            raise ConfigError(f"robot '{robot.model}' cannot be loaded again: {error}") from error
        finally:
            self.world.remove_others(before)

    def _put_back(self) -> None:
        """Put bodies, objects and robots to where they began; all of them are there."""
        assert self._start is not None
        _, steps, bodies, objects = self._start
        self._world_state().restore_state(bodies)
        self._restore_objects(objects, (self.steps - steps) * self._step_size)
        for robot in self.robots:
            robot.put_back()

    def _note_change(self, words: str) -> None:
        self.structure += 1
        self.last_change = words

    def _refill(self) -> None:
        self._altered = False
        self.world.clear()
        self._fill_world()
        self._put_back()
        self._reset_controllers()

    def _reset_controllers(self) -> None:
        for robot in self.robots:
            robot.controllers.reset(self.time)

    def save_state(self) -> Any:
        """Return the state of all that has one; it does not change any more.

        Whatever has a state is listed here and in `Robot.save_state`: bodies, latches and
        mechanisms; of each robot its drives, brakes, sensors, belts, controllers and watchers.
        """
        bodies = self._world_state()
        if self._ordered != self.changes:
            # So that restores change no other constraint's place.
            self._restore_objects(self.objects.save_state(), 0.0)
        return (
            self.steps,
            bodies.save_state(),
            self.objects.save_state(),
            {robot: robot.save_state() for robot in self.robots},
        )

    def restore_state(self, saved: Any) -> None:
        """Go back to a state; sim time goes on, by less than a control period at once.

        Two restores of one state, with the same commands at the same steps after it, lead to the
        same to the last bit. An emergency stop that is set stays so.

        Parameters
        ----------
        saved : object
            What `save_state` returned, with the present `structure`.
        """
        steps, bodies, objects, robots = saved
        # The state belongs to one step of a control cycle.
        self.steps += (steps - self.steps) % self._steps_per_cycle
        now, elapsed = self.time, (self.steps - steps) * self._step_size
        self._world_state().restore_state(bodies)
        self._restore_objects(objects, elapsed)
        for robot in self.robots:
            robot.restore_state(robots[robot], now, elapsed)

    def _world_state(self) -> WorldState:
        """What saves and restores the bodies that there are now."""
        if self._bodies is None or self._bodies[0] != self.changes:
            self._bodies = (self.changes, WorldState(self.world.client, self.world.bodies()))
        return self._bodies[1]

    def _restore_objects(self, saved: Any, elapsed: float) -> None:
        """Let objects take a state up again; the constraints of latches come last then."""
        self.objects.restore_state(saved, elapsed)
        self._ordered = self.changes

    def plan_robot(self, config: RobotConfig, urdf: str, node: NodeHandle) -> Robot:
        """Prepare a robot for `add_robot`; may be called from any thread.

        Raises
        ------
        ConfigError, UrdfError
        """
        return Robot(config, urdf, node, self._resolve, self._step_size)

    def add_robot(self, robot: Robot) -> None:
        """Put a further robot into the running world.

        Raises
        ------
        ConfigError
            Its namespace or name is taken, it would stand in something, or PyBullet refuses it.
        """
        taken = [item.name for item in self.objects.objects()]
        taken += [WORLD_FRAME, *(each.model for each in self.robots)]
        if not robot.model or robot.model in taken:
            raise ConfigError(f"model is '{robot.model}'; another name is needed")
        if any(robot.namespace == each.namespace for each in self.robots):
            raise ConfigError(f"namespace is '{robot.namespace}'; there is a robot already")
        try:
            self._place_in_room(robot, self.robots, "it")
        except (ConfigError, UrdfError, WorldError) as error:
            raise ConfigError(str(error)) from error
        self.robots = (*self.robots, robot)
        self._note_change(f"robot '{robot.model}' was added")
        self._bodies_changed()

    def remove_robot(self, name: str) -> Robot:
        """Take a robot that was added out of the running world.

        Parameters
        ----------
        name : str
            Its namespace.

        Raises
        ------
        ConfigError
            There is none, or it is the first.
        """
        for robot in self.robots[1:]:
            if robot.namespace == name:
                self.robots = tuple(each for each in self.robots if each is not robot)
                self.world.remove(robot.body)
                self._note_change(f"robot '{robot.model}' was removed")
                self._bodies_changed()
                self.objects.wake_all()
                return robot
        there = ", ".join(robot.namespace for robot in self.robots[1:])
        raise ConfigError(f"name is '{name}'; robots that were added: {there or 'none'}")

    def _owners(self, robots: Sequence[Robot]) -> Dict[int, str]:
        """What each body is of, in the words of messages, by PyBullet's number; not the floor."""
        named = {each.body.uid: f"robot '{each.model}'" for each in robots}
        return {**named, **self.objects.owners()}

    def _bodies_changed(self) -> None:
        for robot in self.robots:
            robot.forget_surfaces()
        self._name_bodies()

    def _name_bodies(self) -> None:
        """Note the name of each robot and object by PyBullet's numbers."""
        self.changes += 1
        self._names = {each.body.uid: each.model for each in self.robots}
        for item in self.objects.objects():
            self._names.update(dict.fromkeys(self.objects.bodies_of(item.name), item.name))

    def proximity(self, robot: Robot) -> Proximity:
        """Return what a robot's arm is near to; what is no robot and no object is the floor."""
        return robot.proximity.measure(self.name_of)

    def gripper_contact(self, robot: Robot) -> Optional[GripperContact]:
        """Return what a robot's gripper holds, with names as in `proximity`; None without one."""
        if robot.gripper_contacts is None:
            return None
        return robot.gripper_contacts.measure(self.name_of)

    def name_of(self, uid: int) -> str:
        """Name of the robot or object that a body (PyBullet's number) is of; else `FLOOR`."""
        return self._names.get(uid, FLOOR)

    @property
    def radiation(self) -> Optional[SceneField]:
        """The field of the scene's sources; None where there is none."""
        changes, there = self._field
        if changes != self.changes:
            made = SceneField(self.objects)
            there = None if made.empty else made
            self._field = (self.changes, there)
        return there

    @property
    def gas(self) -> Optional[SceneGas]:
        """The gas of the scene's leaks; None where there is none."""
        changes, there = self._gas
        if changes != self.changes:
            made = SceneGas(self.objects)
            there = None if made.empty else made
            self._gas = (self.changes, there)
        return there

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
        taken = self.objects.names()
        plans = plan_entry(text, name, folder, taken, self._assets, self._step_size)
        check_names(plans, self._models())
        return plans

    def spawn(self, plans: Sequence[Assembly]) -> None:
        """Put objects into the running scene, all or none; parameters as of `spawn_gradually`."""
        for _ in self.spawn_gradually(plans):
            pass

    def spawn_gradually(self, plans: Sequence[Assembly]) -> Iterator[None]:
        """Put objects into the running scene, all or none.

        Steps may be made, but nothing else be changed, before the next body of what stands fast;
        what can move comes in one go.

        Raises
        ------
        ConfigError
            A name is taken, an object would stand in the robot, or there are too many.
        """
        yield from self.objects.add(plans, [robot.body.uid for robot in self.robots])
        self._altered = True
        self._note_change(f"'{plans[0].source.name}' was spawned")
        self._bodies_changed()

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
        self._altered = True
        self._note_change(f"'{name}' was deleted")
        self._bodies_changed()
        return gone

    def move(self, name: str, pose: Pose) -> None:
        """Put an object elsewhere in the running scene, at rest.

        A reset puts it back, and bookmarks stay.

        Parameters
        ----------
        pose : Pose
            Of its root in the world; the position within what is seen of the floor.

        Raises
        ------
        ConfigError
            The pose is none, there is no such object or it cannot be moved, or the place is taken;
            nothing has changed.
        """
        if name in self._models():
            raise ConfigError(f"name is '{name}'; that is a robot, which cannot be moved so")
        farthest = 0.5 * self.scene.floor.size
        self.objects.move(name, steady(pose, farthest), [robot.body.uid for robot in self.robots])
        # The truth is told anew, so that a trial sees that somebody has interfered.
        self._bodies_changed()

    def link_poses(self) -> List[float]:
        """Poses of all that moves, 7 numbers each.

        Each robot's links come in the order of its ``body.link_names()``, then the objects' in that
        of ``objects.frames()``.
        """
        poses: List[float] = []
        for robot in self.robots:
            poses += robot.body.link_poses()
        return poses + self.objects.poses()

    def close(self) -> None:
        """Release the controllers' callers and PyBullet."""
        for robot in self.robots:
            robot.close()
        self.world.close()


def _warn_of_long_period(period: float) -> None:
    """Say it where the control period (s) asks for other gains than the shipped ones."""
    if period > TUNED_PERIOD:
        _log.warning(
            "timing/control_period is %g s: the shipped gains are tuned for %g s; with a longer "
            "period joints chatter unless their gains are less",
            period,
            TUNED_PERIOD,
        )
