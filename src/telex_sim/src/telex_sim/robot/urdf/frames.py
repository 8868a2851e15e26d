"""Links of a URDF that PyBullet can do without, because no force depends on how they move.

PyBullet takes nearly as long for each of them as for a link that collides and is driven.
"""

from __future__ import annotations

from typing import Collection, Dict, NamedTuple

from telex_control.common.geometry.quaternions import IDENTITY, Pose, Quaternion, compose
from telex_control.urdf.elements import Vector

from .elements import Element, by_name, carried_joints, end, mass_of, pose_of, set_pose, vector
from .masses import NO_MASS, add_mass, is_placed


class Frame(NamedTuple):
    """Where a link is that was taken out.

    Attributes
    ----------
    link : str
        What carries it: a link that stays.
    position, orientation : Vector, Quaternion
        In that link's frame (m, xyzw); of a wheel, at angle 0.
    joint : str
        That turns it; empty where it is fixed.
    axis : Vector
        Of that joint, in the frame itself.
    """

    link: str
    position: Vector
    orientation: Quaternion
    joint: str = ""
    axis: Vector = (1.0, 0.0, 0.0)


def take_out_wheels(root: Element, joints: Collection[str]) -> Dict[str, Frame]:
    """Take wheels out of a robot that only show how something runs; their mass stays.

    It becomes their carrier's, and must be the same all around the axis. Left are wheels with a
    collision shape, and such as carry something.

    Parameters
    ----------
    root : Element
        The robot; it is changed.
    joints : collection of str
        That turn the wheels.

    Returns
    -------
    dict of str to Frame
        By name of the wheel's link.
    """
    links, carried = by_name(root, "link"), carried_joints(root)
    gone: Dict[str, Frame] = {}
    for joint in root.findall("joint"):
        name, parent = end(joint, "child"), end(joint, "parent")
        wheel, carrier = links.get(name), links.get(parent)
        if joint.get("name") not in joints or name in carried or wheel is None or carrier is None:
            continue
        if wheel.find("collision") is None and is_placed(joint, wheel, carrier):
            pose = pose_of(joint)
            axis = vector(
                joint.find("axis"), "xyz", f"joint '{joint.get('name')}'", (1.0, 0.0, 0.0)
            )
            add_mass(carrier, wheel, pose)
            _take(root, joint, wheel, carrier, pose)
            gone[name] = Frame(parent, *pose, joint=joint.get("name", ""), axis=axis)
    return gone


def take_out_frames(root: Element) -> Dict[str, Frame]:
    """Take mere frames out of a robot: links without mass and shape that are fixed to another.

    A frame stays that carries a link which stays. What is to be seen of one goes to the link that
    carries it. What PyBullet would read out of an origin that is no numbers is left to it.

    Parameters
    ----------
    root : Element
        The robot; it is changed.

    Returns
    -------
    dict of str to Frame
        By name.
    """
    links, carried = by_name(root, "link"), carried_joints(root)
    gone: Dict[str, Frame] = {}

    def is_bare(joint: Element) -> bool:
        name = end(joint, "child")
        link = links.get(name)
        return (
            joint.get("type") == "fixed"
            and link is not None
            and is_placed(joint, link)
            and link.find("collision") is None
            and mass_of(link) <= NO_MASS
            and all(is_bare(each) for each in carried.get(name, ()))
        )

    def take(joint: Element, carrier: str, pose: Pose) -> None:
        name = end(joint, "child")
        pose = compose(pose, pose_of(joint))
        gone[name] = Frame(carrier, *pose)
        _take(root, joint, links[name], links[carrier], pose)
        for each in carried.get(name, ()):
            take(each, carrier, pose)

    for joint in root.findall("joint"):
        parent = end(joint, "parent")
        if parent in links and parent not in gone and is_bare(joint):
            take(joint, parent, IDENTITY)
    return gone


def _take(
    root: Element,
    joint: Element,
    link: Element,
    carrier: Element,
    pose: Pose,
) -> None:
    """Remove a link and its joint; what is to be seen of it goes to its carrier."""
    for visual in link.findall("visual"):
        set_pose(visual, compose(pose, pose_of(visual)))
        carrier.append(visual)
    root.remove(link)
    root.remove(joint)
