"""The scene as messages for renderers."""

from __future__ import annotations

import time
from typing import List, Sequence

from genpy import Time
from geometry_msgs.msg import Point, Pose, Quaternion, Vector3
from std_msgs.msg import ColorRGBA
from telex_msgs.msg import SceneDescription, ScenePoses, SceneVisual

from .rendering.urdf_visuals import UrdfVisual, urdf_visuals
from .world import FLOOR_SIZE

WORLD_FRAME = "world"
_IDENTITY = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)


class SceneMessages:
    """Describes one robot on the floor.

    Parameters
    ----------
    model : str
        Name of the robot; its frames are ``<model>/<link>``.
    links : sequence of str
        In the order in which `poses` gets their poses.
    urdf : str
    """

    def __init__(self, model: str, links: Sequence[str], urdf: str) -> None:
        self.revision = 1
        self._frames = [WORLD_FRAME, *(f"{model}/{link}" for link in links)]
        index = {link: number + 1 for number, link in enumerate(links)}
        self._visuals = [_floor()]
        self._visuals += [_visual(index[v.link], v) for v in urdf_visuals(urdf) if v.link in index]

    def description(self, stamp: Time) -> SceneDescription:
        """What there is to see."""
        message = SceneDescription(
            revision=self.revision, frames=self._frames, visuals=self._visuals
        )
        message.header.stamp = stamp
        message.header.frame_id = WORLD_FRAME
        return message

    def poses(self, stamp: Time, link_poses: Sequence[float]) -> ScenePoses:
        """Where everything is at `stamp`; `link_poses` has 7 numbers for each link."""
        poses: List[float] = [*_IDENTITY, *link_poses]
        message = ScenePoses(revision=self.revision, wall_time=time.time(), poses=poses)
        message.header.stamp = stamp
        message.header.frame_id = WORLD_FRAME
        return message


def _floor() -> SceneVisual:
    return SceneVisual(
        frame=0,
        shape=SceneVisual.PLANE,
        size=Vector3(FLOOR_SIZE, FLOOR_SIZE, 0.0),
        pose=Pose(orientation=Quaternion(w=1.0)),
        color=ColorRGBA(0.62, 0.63, 0.64, 1.0),
        texture="checker",
        texture_scale=2.0,
    )


def _visual(frame: int, visual: UrdfVisual) -> SceneVisual:
    return SceneVisual(
        frame=frame,
        shape=int(visual.shape),
        size=Vector3(*visual.size),
        mesh=visual.mesh,
        pose=Pose(Point(*visual.position), Quaternion(*visual.orientation)),
        color=ColorRGBA(*visual.color),
        texture=visual.texture,
        texture_scale=0.0,
    )
