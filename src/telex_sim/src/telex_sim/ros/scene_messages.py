"""The scene as messages for renderers.

What stands fast is part of the frame ``world``: its poses are said once, with its looks, and cost
nothing afterwards.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from typing import Any, Dict, List, Mapping, NamedTuple, Sequence, Tuple

from genpy import Time
from geometry_msgs.msg import Point, Vector3
from std_msgs.msg import ColorRGBA
from telex_msgs.msg import SceneDescription, SceneLamp, ScenePoses, SceneVisual

from telex_control.common.geometry import quaternions
from telex_control.common.geometry.quaternions import IDENTITY, compose
from telex_control.ros.pose_messages import pose_message

from ..robot.urdf.visuals import UrdfVisual, urdf_visuals
from ..scene.model import WORLD_FRAME, Floor, Form, Lamp, Lights, Part, Scene, SceneObject, Surface

_WORLD = 0
_IDENTITY = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
_SHAPES = {
    Form.BOX: SceneVisual.BOX,
    Form.SPHERE: SceneVisual.SPHERE,
    Form.CYLINDER: SceneVisual.CYLINDER,
    Form.MESH: SceneVisual.MESH,
}


@dataclass(frozen=True)
class _Robot:
    links: Tuple[str, ...]
    visuals: Tuple[UrdfVisual, ...]


class _Shown(NamedTuple):
    """What is described; replaced as a whole, since descriptions are made in another thread."""

    revision: int
    lights: Lights
    daylight: float
    lamps: float
    floor: SceneVisual
    robots: Mapping[str, _Robot]
    objects: Tuple[SceneObject, ...]


class SceneMessages:
    """Describes robots in a scene.

    `description` may be called from any thread.

    Parameters
    ----------
    model, links, urdf
        The first robot's, as in `add_robot`.
    scene : Scene
        Its floor and light; objects come by `show`. `change_scene` puts another in its place.

    Raises
    ------
    telex_control.urdf.elements.UrdfError
    """

    def __init__(self, model: str, links: Sequence[str], urdf: str, scene: Scene) -> None:
        self._shown = _Shown(0, scene.lights, 1.0, 1.0, _floor(scene.floor), {}, ())
        self.add_robot(model, links, urdf_visuals(urdf))

    @property
    def revision(self) -> int:
        """Of what is described; rises with every change."""
        return self._shown.revision

    def _change(self, **changes: Any) -> None:
        self._shown = self._shown._replace(revision=self._shown.revision + 1, **changes)

    def add_robot(self, model: str, links: Sequence[str], visuals: Sequence[UrdfVisual]) -> None:
        """Describe a further robot from now on.

        Parameters
        ----------
        model : str
            Its name; its frames are ``<model>/<link>``. Those of robots come in the order in which
            they were added, and before those of objects.
        links : sequence of str
            In the order in which `poses` gets their poses.
        """
        robot = _Robot(tuple(links), tuple(visuals))
        self._change(robots={**self._shown.robots, model: robot})

    def remove_robot(self, model: str) -> None:
        """Leave a robot out from now on."""
        robots = self._shown.robots
        self._change(robots={name: each for name, each in robots.items() if name != model})

    def show(self, objects: Sequence[SceneObject]) -> bool:
        """Describe these objects from now on; returns whether that is a change."""
        if tuple(objects) == self._shown.objects:
            return False
        self._change(objects=tuple(objects))
        return True

    def change_scene(self, scene: Scene, objects: Sequence[SceneObject]) -> None:
        """Describe another scene from now on, with its objects."""
        self._change(
            lights=scene.lights,
            daylight=1.0,
            lamps=1.0,
            floor=_floor(scene.floor),
            objects=tuple(objects),
        )

    @property
    def light(self) -> Tuple[float, float]:
        """Shares of the scene's daylight and of its lamps' light that are described."""
        return self._shown.daylight, self._shown.lamps

    def set_light(self, daylight: float, lamps: float) -> None:
        """Describe a share of the scene's daylight, and of its lamps' light, from now on.

        Another scene begins with all of its own.
        """
        self._change(daylight=daylight, lamps=lamps)

    @property
    def frames(self) -> Tuple[int, List[str]]:
        """The revision that is described, and the names of its frames."""
        shown = self._shown
        return shown.revision, _frames_and_visuals(shown)[0]

    def description(self, stamp: Time) -> SceneDescription:
        """What there is to see."""
        shown = self._shown
        frames, visuals = _frames_and_visuals(shown)
        lights, day = shown.lights, shown.daylight
        sun, fog = lights.sun, lights.fog
        message = SceneDescription(
            revision=shown.revision,
            frames=frames,
            visuals=visuals,
            lamps=[_lamp(lamp, shown.lamps) for lamp in lights.lamps],
            to_sun=_to_sun(lights),
            sun=ColorRGBA(*(part * sun.intensity * day for part in sun.color), 1.0),
            ambient=lights.ambient * day,
            visibility=fog.visibility,
            fog=ColorRGBA(*fog.color, 1.0),
        )
        message.header.stamp = stamp
        message.header.frame_id = WORLD_FRAME
        return message

    def poses(self, stamp: Time, link_poses: Sequence[float]) -> ScenePoses:
        """Where everything is at `stamp`.

        Parameters
        ----------
        link_poses : sequence of float
            7 numbers each: the robots' links, then those of the objects shown that can move.
        """
        message = ScenePoses(
            revision=self.revision, wall_time=time.time(), poses=[*_IDENTITY, *link_poses]
        )
        message.header.stamp = stamp
        message.header.frame_id = WORLD_FRAME
        return message


def _frames_and_visuals(shown: _Shown) -> Tuple[List[str], List[SceneVisual]]:
    frames, visuals = [WORLD_FRAME], [shown.floor]
    for model, robot in shown.robots.items():
        index = {link: len(frames) + i for i, link in enumerate(robot.links)}
        frames += [f"{model}/{link}" for link in robot.links]
        visuals += [_robot(index, v) for v in robot.visuals if v.link in index]
    for item in shown.objects:
        own: Dict[str, int] = {}
        for link in item.model.moving_links():
            own[link.name] = len(frames)
            frames.append(f"{item.name}/{link.name}")
        origin = (item.position, item.orientation)
        for link in item.model.links:
            frame = own.get(link.name, _WORLD)
            within = origin if frame == _WORLD else IDENTITY
            visuals += [
                _part(frame, within, part, part.surface)
                for part in link.parts
                if part.surface is not None
            ]
    return frames, visuals


def _floor(floor: Floor) -> SceneVisual:
    return _visual(
        _WORLD,
        SceneVisual.PLANE,
        (floor.size, floor.size, 0.0),
        "",
        IDENTITY,
        floor.surface,
    )


def _part(frame: int, within: quaternions.Pose, part: Part, surface: Surface) -> SceneVisual:
    geometry = part.geometry
    pose = compose(within, (part.position, part.orientation))
    shape = _SHAPES[geometry.form]
    return _visual(frame, shape, geometry.size, geometry.mesh, pose, surface)


def _visual(
    frame: int,
    shape: int,
    size: Sequence[float],
    mesh: str,
    pose: quaternions.Pose,
    surface: Surface,
) -> SceneVisual:
    return SceneVisual(
        frame=frame,
        shape=shape,
        size=Vector3(*size),
        mesh=mesh,
        pose=pose_message(*pose),
        color=ColorRGBA(*surface.color),
        texture=surface.texture,
        texture_scale=surface.texture_scale,
        glow=surface.glow,
    )


def _robot(index: Mapping[str, int], visual: UrdfVisual) -> SceneVisual:
    return SceneVisual(
        frame=index[visual.link],
        shape=int(visual.shape),
        size=Vector3(*visual.size),
        mesh=visual.mesh,
        pose=pose_message(visual.position, visual.orientation),
        color=ColorRGBA(*visual.color),
        texture=visual.texture,
        texture_scale=0.0,
        # A wheel that is not simulated leaves its belt at rest.
        drive=index.get(visual.drive, _WORLD),
        mesh_materials=visual.mesh_materials,
    )


def _lamp(lamp: Lamp, share: float) -> SceneLamp:
    return SceneLamp(
        frame=_WORLD,
        position=Point(*lamp.position),
        direction=Vector3(*lamp.direction),
        angle=lamp.angle,
        intensity=lamp.intensity * share,
        reach=lamp.reach,
        color=ColorRGBA(*lamp.color, 1.0),
    )


def _to_sun(lights: Lights) -> Vector3:
    azimuth, elevation = lights.sun.azimuth, lights.sun.elevation
    across = math.cos(elevation)
    return Vector3(across * math.cos(azimuth), across * math.sin(azimuth), math.sin(elevation))
