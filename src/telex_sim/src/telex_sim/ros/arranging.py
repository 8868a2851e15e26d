"""Services by which an instructor arranges the running scene: by pointing, and its light."""

from __future__ import annotations

from typing import Any, Callable, Iterator, List, Optional, Tuple

import rospy
from geometry_msgs.msg import Point, Pose
from telex_msgs.msg import LibraryObject, SceneThing
from telex_msgs.srv import (
    FindPlace,
    FindPlaceResponse,
    ListObjects,
    ListObjectsResponse,
    Move,
    MoveResponse,
    SetLight,
    SetLightResponse,
)

from telex_control.common.geometry.quaternions import IDENTITY, Vector3, about, product
from telex_control.common.params import ConfigError
from telex_control.ros.pose_messages import pose_in, pose_message, vector_in

from ..engine.loop_requests import Action
from ..engine.simulation import Simulation
from ..rehearsal.client import RehearsalClient
from ..scene.catalog import preview_of_type, small_jpeg
from ..scene.library import types_by_name
from ..scene.objects.assembly import Assembly
from ..scene.objects.outlines import Outlines, extent
from ..scene.objects.places import Hit, first_hit, standing_height
from ..scene.type_texts import summary
from .scene_messages import SceneMessages

_MOST_TURN = 100.0


class Arranging:
    """Offers the services; their work on the simulation is done by the loop.

    Parameters
    ----------
    change : callable
        Has the loop's thread carry out an action; raises the ConfigError that it is refused with.
    """

    def __init__(
        self,
        simulation: Simulation,
        scene: SceneMessages,
        rehearsal: RehearsalClient,
        change: Callable[[Action], None],
        publish_scene: Callable[[], None],
    ) -> None:
        self._simulation = simulation
        self._scene = scene
        self._rehearsal = rehearsal
        self._change = change
        self._publish_scene = publish_scene
        self._outlines = Outlines()
        self._library = list(_library())
        self._pictured = list(_pictured(self._library))
        self._services = [
            rospy.Service("sim/list_objects", ListObjects, self._on_list),
            rospy.Service("sim/find_place", FindPlace, self._on_find_place),
            rospy.Service("sim/move", Move, self._on_move),
            rospy.Service("sim/set_light", SetLight, self._on_set_light),
        ]

    def close(self) -> None:
        """Take the services back."""
        for service in self._services:
            service.shutdown()

    def _on_list(self, request: Any) -> ListObjectsResponse:
        simulation = self._simulation
        assemblies = simulation.objects.assemblies()
        robots = simulation.robots
        revision, frames = self._scene.frames
        daylight, lamps = self._scene.light
        return ListObjectsResponse(
            revision=revision,
            frames=frames,
            robots=[robot.model for robot in robots],
            bases=[f"{robot.model}/{robot.body.base_link}" for robot in robots],
            floor=simulation.scene.floor.size,
            objects=[
                SceneThing(
                    name=assembly.source.name,
                    movable=not assembly.source.model.static,
                    frame=outline.frame,
                    bottom=outline.bottom,
                    top=outline.top,
                    corners=[len(polygon) for polygon in outline.polygons],
                    outlines=[
                        round(number, 3)
                        for polygon in outline.polygons
                        for number in polygon.reshape(-1).tolist()
                    ],
                )
                for assembly, outline in zip(assemblies, self._outlines.of(assemblies))
            ],
            library=self._pictured if request.pictures else self._library,
            daylight=daylight,
            lamps=lamps,
        )

    def _on_find_place(self, request: Any) -> FindPlaceResponse:
        origin, direction = vector_in(request.origin), vector_in(request.direction)
        yaw = request.yaw
        answer = FindPlaceResponse()
        answer.pose.orientation.w = 1.0

        def look() -> None:
            hit = self._look(origin, direction, answer)
            if request.object:
                answer.pose = self._place(request.object, plans, hit, yaw)

        try:
            if not abs(yaw) <= _MOST_TURN:
                raise ConfigError(f"yaw is {yaw}; rad, at most {_MOST_TURN:g}, are needed")
            plans = self._plans(request.object)
            self._change(look)
        except ConfigError as error:
            answer.message = str(error)
            return answer
        answer.success = True
        return answer

    def _plans(self, asked: str) -> Optional[List[Assembly]]:
        """Read the entry that is asked about; None: it is the name of an object, or nothing."""
        objects = self._simulation.objects
        if not asked or asked in (item.name for item in objects.objects()):
            return None
        if ":" not in asked:
            raise ConfigError(
                f"object is '{asked[:80]}'; there is no such object, and it is no entry of a scene"
            )
        models = [robot.model for robot in self._simulation.robots]
        floor = self._simulation.scene.floor
        return self._rehearsal.entry(asked, "", "", objects.names(), models, floor)

    # --- the loop's thread -----------------------------------------------------------------------

    def _look(
        self,
        origin: Vector3,
        direction: Vector3,
        answer: FindPlaceResponse,
    ) -> Hit:
        """Fill in what a ray meets.

        Raises
        ------
        ConfigError
            It meets nothing.
        """
        simulation = self._simulation
        hit = first_hit(simulation.world.client, origin, direction)
        if hit is None:
            raise ConfigError("there is nothing in that direction")
        answer.point, answer.met = Point(*hit.point), simulation.name_of(hit.uid)
        answer.robot = any(robot.body.uid == hit.uid for robot in simulation.robots)
        answer.movable = any(
            not item.model.static
            for item in simulation.objects.objects()
            if item.name == answer.met
        )
        return hit

    def _place(self, name: str, plans: Optional[List[Assembly]], hit: Hit, yaw: float) -> Pose:
        """Return where an object would stand.

        Raises
        ------
        ConfigError
            It cannot stand there.
        """
        simulation = self._simulation
        objects, client = simulation.objects, simulation.world.client
        robots = {robot.body.uid: robot.model for robot in simulation.robots}
        own: Tuple[int, ...] = ()
        turned, root = IDENTITY[1], IDENTITY
        if plans is None:
            own = objects.bodies_of(name)
            plans = [each for each in objects.assemblies() if each.source.name == name]
            source = plans[0].source
            root = source.position, source.orientation
            turned = objects.link_pose(name, source.model.links[0].name)[1]
        orientation = product(about((0.0, 0.0, 1.0), yaw), turned)
        corners = extent(plans, root)
        if hit.uid in own:
            raise ConfigError("that is the object itself")
        height, bodies = standing_height(client, corners, hit.point, orientation, own)
        for uid in (hit.uid, *sorted(bodies)):
            if uid in robots:
                raise ConfigError(f"robot '{robots[uid]}' is there; it needs another place")
        return pose_message((hit.point[0], hit.point[1], height), orientation)

    def _on_move(self, request: Any) -> MoveResponse:
        try:
            self._change(lambda: self._simulation.move(request.name, pose_in(request.pose)))
        except ConfigError as error:
            rospy.logwarn("sim/move: %s", error)
            return MoveResponse(success=False, message=str(error))
        x, y, z = vector_in(request.pose.position)
        return MoveResponse(
            success=True, message=f"moved: {request.name} to {x:.2f}, {y:.2f}, {z:.2f}"
        )

    def _on_set_light(self, request: Any) -> SetLightResponse:
        for name in ("daylight", "lamps"):
            share = getattr(request, name)
            if not 0.0 <= share <= 1.0:
                return SetLightResponse(
                    success=False, message=f"{name} is {share}; 0 to 1 is possible"
                )

        def light() -> None:
            self._scene.set_light(request.daylight, request.lamps)
            self._publish_scene()

        self._change(light)
        return SetLightResponse(
            success=True,
            message=f"daylight {request.daylight:.0%}, lamps of the scene {request.lamps:.0%}",
        )


def _library() -> Iterator[LibraryObject]:
    """Types that can be put by their names."""
    for name, kind in types_by_name().items():
        yield LibraryObject(name, kind.__module__.split(".")[-2], summary(kind), b"")


def _pictured(library: List[LibraryObject]) -> Iterator[LibraryObject]:
    for each in library:
        picture = small_jpeg(preview_of_type(each.type))
        yield LibraryObject(each.type, each.group, each.text, picture)
