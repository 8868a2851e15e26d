"""Wheel radius and separation, from the robot description."""

from __future__ import annotations

from typing import Optional, Tuple

import PyKDL

from ..kinematics.kdl_tree import kdl_frame
from .elements import UrdfError, number, origin
from .model import Cylinder, Joint, Robot, Sphere

_SAME = 1.0e-9
"""m; origins of joints that are nearer have one place."""


def wheel_separation(robot: Robot, left: str, right: str) -> float:
    """Return the distance (m) between the origins of two wheel joints.

    All joints are at 0, those that carry the wheels' suspensions too.

    Raises
    ------
    UrdfError
        A joint is missing, they have no link in common, or the distance is 0.
    """
    (first, first_root), (second, second_root) = (_place(robot, each) for each in (left, right))
    if first_root != second_root:
        raise UrdfError(
            f"wheel joints '{left}' and '{right}' hang on different roots, '{first_root}' and "
            f"'{second_root}'; their distance cannot be read from the URDF"
        )
    separation = (first - second).Norm()
    if separation < _SAME:
        raise UrdfError(f"wheel joints '{left}' and '{right}' are in the same place")
    return separation


def wheel_radius(robot: Robot, joint: str) -> float:
    """Return the radius (m) of the cylinder or sphere that a wheel collides as.

    Raises
    ------
    UrdfError
        The joint or its link is missing, or the link collides as something else.
    """
    link_name = _joint(robot, joint).child
    link = robot.link_map.get(link_name)
    if link is None:
        raise UrdfError(f"wheel joint '{joint}': there is no link '{link_name}'")
    shapes = [collision.geometry for collision in link.collisions]
    for kind in (Cylinder, Sphere):
        for shape in (each for each in shapes if isinstance(each, kind)):
            radius = number(shape, "radius", f"link '{link_name}'")
            if radius <= 0.0:
                raise UrdfError(
                    f"link '{link_name}': radius of its {kind.XML_REFL.tag} is {radius:g} m; a "
                    "number above 0 is needed"
                )
            return radius
    raise UrdfError(
        f"link '{link_name}' does not collide as a cylinder or a sphere; "
        "the wheel's radius cannot be read from the URDF"
    )


def _place(robot: Robot, name: str) -> Tuple[PyKDL.Vector, str]:
    """Where the origin of a joint is (m), in the frame of the root link; and that link."""
    above = {joint.child: joint for joint in robot.joint_map.values()}
    joint: Optional[Joint] = _joint(robot, name)
    frame, link = PyKDL.Frame(), ""
    while joint is not None:
        frame = kdl_frame(origin(joint, f"joint '{joint.name}'")) * frame
        link = joint.parent
        joint = above.get(link)
    return frame.p, link


def _joint(robot: Robot, name: str) -> Joint:
    if name not in robot.joint_map:
        raise UrdfError(f"robot_description has no wheel joint '{name}'")
    return robot.joint_map[name]
