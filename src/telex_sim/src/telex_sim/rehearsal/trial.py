"""Trying out what is to come into a world, in a world of its own.

Whatever comes from outside (a scene, an object, a robot) is built and stepped here before it comes
near the running loop: what PyBullet refuses, what stands in something else, and what would be
thrown about by the first steps is found here.
"""

from __future__ import annotations

import functools
import math
from typing import Callable, Dict, List, Optional, Sequence

import pybullet

from telex_control.common.params import ConfigError
from telex_control.urdf.checks import check_bodies
from telex_control.urdf.joints import parse_urdf

from ..engine.simulator_config import SimulatorConfig
from ..engine.start_check import check_place, check_start, place_beside, start_in_scene
from ..engine.world import World, WorldError
from ..robot.body import RobotBody
from ..robot.meshes import check_meshes
from ..scene.files.scene_file import SceneError
from ..scene.model import LARGEST, WORLD_FRAME, Floor, Scene, Start
from ..scene.objects.assembly import Assembly
from ..scene.objects.bodies import SceneBodies
from ..scene.objects.body_maker import MeshLists
from ..scene.planning import PlannedScene, Progress

_TIME = 0.1
"""Sim time (s) for which it is stepped."""


def check_names(assemblies: Sequence[Assembly], models: Sequence[str]) -> None:
    """Refuse objects with the name of a robot, or of the world.

    Raises
    ------
    ConfigError
    """
    for name in (assembly.source.name for assembly in assemblies):
        if name in (*models, WORLD_FRAME):
            raise ConfigError(f"name is '{name}'; it is that of another frame already")


def check_scene(config: SimulatorConfig, planned: PlannedScene, models: Sequence[str]) -> None:
    """Refuse a scene that asks for a pose which there is not, or takes a robot's name.

    Raises
    ------
    SceneError
    """
    start, scene = config.start, planned.scene
    asked = {"start": scene.start, **{f"robots[{i}]": each for i, each in enumerate(scene.robots)}}
    for where, each in asked.items():
        if start.pose_name(each.pose) not in ("", *start.poses):
            raise SceneError(
                f"{planned.path}: {where}/pose is '{each.pose}'; "
                f"there are: {', '.join(sorted(start.poses)) or 'none'}"
            )
    try:
        check_names(planned.assemblies, models)
    except ConfigError as error:
        raise SceneError(f"{planned.path}: objects: {error}") from error


class Rehearsal:
    """A world for one rehearsal; to be closed.

    Parameters
    ----------
    resolve : callable
        Turns a mesh address (``package://…``) into a path.
    meshes : MeshLists, optional
        Those of other worlds of this program.
    """

    def __init__(
        self,
        config: SimulatorConfig,
        resolve: Callable[[str], str],
        meshes: Optional[MeshLists] = None,
    ) -> None:
        self._config = config
        self._resolve = resolve
        self._world = World(config.timing.step_size, config.solver_iterations)
        self._objects = SceneBodies(self._world.client, config.timing.step_size, meshes)

    def __enter__(self) -> Rehearsal:
        return self

    def __exit__(self, *exception: object) -> None:
        """Close the world."""
        self._world.close()

    def scene(self, planned: PlannedScene, robots: Sequence[RobotBody]) -> None:
        """Try a scene with the robots in it, or without any.

        Raises
        ------
        SceneError
        """
        try:
            self._scene(planned, robots)
        except (ConfigError, WorldError) as error:
            raise SceneError(f"{planned.path}: {error}") from error

    def _scene(self, planned: PlannedScene, robots: Sequence[RobotBody]) -> None:
        scene = planned.scene
        self._objects.load(scene.floor, planned.assemblies, Progress(scene.name, "rehearsed"))
        self._objects.check_room()
        if robots:
            self._place(scene, *robots)
        self._step()

    def _place(self, scene: Scene, first: RobotBody, *others: RobotBody) -> None:
        start = scene.start
        positions = first.start_positions(start.pose)
        body = first.load(self._world, start, positions, self._resolve)
        owners = {body.uid: f"robot '{first.model}'", **self._objects.owners()}
        if not self._config.fixed_base:
            pose = self._config.start.pose_name(start.pose)
            check_start(body, pose, lambda uid: owners.get(uid, "the floor"))
        robots = {body.uid: first.model}
        for number, robot in enumerate(others, 1):
            name = f"robot '{robot.model}'"
            own = start_in_scene(scene, robot.config.start, number)
            load = functools.partial(
                robot.load,
                self._world,
                positions=robot.start_positions(own.pose if own is not None else ""),
                resolve=self._resolve,
            )
            if own is not None or not robot.config.start.looks_for_room:
                body = load(own or start)
            else:
                body = place_beside(self._world, start, robots, load, name)
            check_place(self._world, body, owners, name)
            owners[body.uid], robots[body.uid] = name, robot.model

    def objects(self, floor: Floor, plans: Sequence[Assembly]) -> None:
        """Try objects by themselves.

        Raises
        ------
        ConfigError
        """
        self._objects.load(floor, plans, lambda done, count: None)
        self._objects.check_room()
        self._step()

    def check_robot(self, robot: RobotBody) -> None:
        """Look at what a robot's description says, and at its files.

        Raises
        ------
        ConfigError, UrdfError
        """
        check_bodies(parse_urdf(robot.urdf))
        check_meshes(robot.urdf, self._resolve)

    def robot(self, robot: RobotBody, start: Start) -> None:
        """Try a robot by itself.

        Raises
        ------
        ConfigError, UrdfError, WorldError
        """
        self._objects.load(Floor(), (), lambda done, count: None)
        robot.load(self._world, start, robot.start_positions(""), self._resolve)
        self._step()

    def _step(self) -> None:
        """Step, and refuse what does not stay where anything can be.

        Raises
        ------
        ConfigError
        """
        for _ in range(max(1, round(_TIME / self._config.timing.step_size))):
            self._objects.apply()
            self._world.step()
        names: Dict[int, str] = self._objects.owners()
        gone: List[str] = []
        for uid in self._world.bodies():
            position, orientation = pybullet.getBasePositionAndOrientation(
                uid, physicsClientId=self._world.client
            )
            known = all(map(math.isfinite, (*position, *orientation)))
            if not known or max(map(abs, position)) > 2.0 * LARGEST:
                gone.append(names.get(uid, "the robot"))
        if gone:
            raise ConfigError(
                f"{gone[0]} is thrown out of the world within {_TIME} s; its masses, inertias and "
                "joints cannot be simulated"
            )
