"""Scene and poses of a moment, as the cameras' node takes them from the simulator."""

from __future__ import annotations

from typing import Dict, List, Mapping, NamedTuple, Optional, Sequence, Tuple

import numpy as np
from genpy import Time
from telex_msgs.msg import SceneDescription, ScenePoses

from telex_control.common.geometry.quaternions import Pose, compose
from telex_sim.robot.urdf.visuals import UrdfVisual, urdf_visuals
from telex_sim.ros.scene_messages import SceneMessages
from telex_sim.scene.model import Motion, Scene, SceneObject
from telex_sim.scene.objects.assembly import joint_pose

from .robot_links import RobotLinks
from .timeline import Moment, Timeline, TimelinePart

ALL_LIGHT = (1.0, 1.0)
"""Shares of daylight and lamps in a scene that nobody has darkened."""
OUTSIDE_FRAME = "replay_outside_optical_frame"
"""Frame of the free camera: part of the robot's frames, so that each pose of the scene has its
own view, and a picture shows both or none."""


class OtherRobotScenery(NamedTuple):
    """A robot that is drawn beside the recording's own.

    Attributes
    ----------
    name : str
        In the scene.
    """

    name: str
    links: Tuple[str, ...]
    visuals: Sequence[UrdfVisual]


class RobotBeside:
    """A further robot of a trial.

    Parameters
    ----------
    timeline : Timeline
        Its own.

    Raises
    ------
    telex_control.urdf.elements.UrdfError
    """

    def __init__(self, urdf: str, timeline: Timeline) -> None:
        self._links = RobotLinks(urdf)
        self._timeline = timeline
        name = timeline.at(0).part.robot
        self.robot = OtherRobotScenery(name, self._links.names, urdf_visuals(urdf))

    def poses(self, stamp: int) -> List[Pose]:
        """Poses of its links in the world (m, quaternion) at a sim time (ns), in their order."""
        index = int(np.searchsorted(self._timeline.stamps, stamp, side="right")) - 1
        moment = self._timeline.at(index)
        return self._links.poses(base_of(moment), joints_of(moment))


class Scenery:
    """What there is to see in a recording, and where it is.

    Parameters
    ----------
    urdf : str
        Of the robot.
    scene : Scene, optional
        As it was loaded; None: the robot alone is shown.
    beside : sequence of RobotBeside
        Further robots of the trial.

    Attributes
    ----------
    visuals : sequence of UrdfVisual
        The robot's.

    Raises
    ------
    telex_control.urdf.elements.UrdfError
    """

    def __init__(
        self, urdf: str, scene: Optional[Scene], beside: Sequence[RobotBeside] = ()
    ) -> None:
        self._urdf = urdf
        self._beside = tuple(beside)
        self._links = RobotLinks(urdf)
        self.visuals: Sequence[UrdfVisual] = urdf_visuals(urdf)
        self._scene = scene if scene is not None else Scene(name="replay")

    @property
    def links(self) -> Tuple[str, ...]:
        """Names of the robot's links."""
        return self._links.names

    def unknown(self, part: TimelinePart) -> List[str]:
        """Objects that were there and are not in the scene that was recorded: they came later."""
        known = {item.name for item in self._scene.objects}
        return [name for name in part.names.objects if name not in known]

    def _shown(self, part: TimelinePart) -> List[SceneObject]:
        present = set(part.names.objects)
        return [item for item in self._scene.objects if item.name in present]

    def description(
        self,
        moment: Moment,
        revision: int,
        other: Optional[OtherRobotScenery] = None,
        light: Tuple[float, float] = ALL_LIGHT,
    ) -> SceneDescription:
        """What there is to see from a moment on, until the names change.

        Parameters
        ----------
        other : OtherRobotScenery, optional
            A robot of another run.
        light : tuple of 2 floats
            Shares of the scene's daylight and of its lamps' light, 0 to 1.
        """
        part = moment.part
        messages = SceneMessages(part.robot, self._links.names, self._urdf, self._scene)
        for robot in (*(each.robot for each in self._beside), other):
            if robot is not None:
                messages.add_robot(*robot)
        messages.show(self._shown(part))
        messages.set_light(*light)
        made = messages.description(_time(moment.stamp))
        made.revision = revision
        made.frames.append(f"{part.robot}/{OUTSIDE_FRAME}")
        return made

    def link_poses(self, moment: Moment) -> List[Pose]:
        """Poses of the robot's links in the world (m, quaternion), in the order of `links`."""
        return self._links.poses(base_of(moment), joints_of(moment))

    def poses(
        self,
        moment: Moment,
        revision: int,
        stamp: int,
        outside: Pose,
        others: Sequence[Pose] = (),
    ) -> ScenePoses:
        """Where everything was.

        Parameters
        ----------
        revision : int
            Of the description.
        stamp : int
            Of the message (ns).
        outside : Pose
            Of the free camera's optical frame in the world (m, quaternion).
        others : sequence of Pose
            Of the links of the other run's robot, where the description has one.
        """
        numbers: List[float] = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]
        for position, orientation in (
            *self.link_poses(moment),
            *(pose for each in self._beside for pose in each.poses(moment.stamp)),
            *others,
            *self._object_poses(moment),
        ):
            numbers += (*position, *orientation)
        numbers += (*outside[0], *outside[1])
        message = ScenePoses(revision=revision, poses=numbers)
        message.header.stamp, message.header.frame_id = _time(stamp), "world"
        return message

    def _object_poses(self, moment: Moment) -> List[Pose]:
        part = moment.part
        bodies = part.bodies(moment.row)
        row = part.mechanisms[moment.row].tolist()
        mechanisms = {name: row[index] for name, index in part.names.mechanisms.items()}
        found: List[Pose] = []
        for item in self._shown(part):
            found += _link_poses(item, bodies, mechanisms)
        return found


def base_of(moment: Moment) -> Pose:
    """Pose of the robot's root link in the world (m, quaternion x y z w)."""
    return _pose(moment.part.base[moment.row].tolist())


def joints_of(moment: Moment) -> Dict[str, float]:
    """Positions of the robot's joints (rad, m)."""
    row = moment.part.joints[moment.row].tolist()
    return {name: row[index] for name, index in moment.part.names.joints.items()}


def _link_poses(
    item: SceneObject,
    bodies: Mapping[str, Sequence[float]],
    mechanisms: Mapping[str, float],
) -> List[Pose]:
    """Poses of an object's moving links: told, or led by a joint from the link that carries it."""
    model = item.model
    joints = {joint.child: joint for joint in model.joints}
    known: Dict[str, Pose] = {}

    def pose(link: str) -> Pose:
        if link not in known:
            told = bodies.get(f"{item.name}/{link}")
            joint = joints.get(link)
            if told is not None:
                known[link] = _pose(told)
            elif joint is None:
                known[link] = (item.position, item.orientation)
            else:
                latch = joint.motion is Motion.LATCH
                start = 0.0 if latch else joint.start
                position = mechanisms.get(f"{item.name}/{joint.name}", start)
                known[link] = compose(pose(joint.parent), joint_pose(joint, position))
        return known[link]

    return [pose(link.name) for link in model.moving_links()]


def _pose(numbers: Sequence[float]) -> Pose:
    x, y, z, a, b, c, d = numbers
    return (x, y, z), (a, b, c, d)


def _time(stamp: int) -> Time:
    return Time(stamp // 10**9, stamp % 10**9)
