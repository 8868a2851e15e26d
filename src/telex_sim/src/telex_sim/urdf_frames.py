"""What PyBullet is not given as a URDF has it: links without a mass, and such as need no body.

PyBullet takes 1 kg for a link without ``<inertial>``, holds one of mass 0 fast in the world, and
takes nearly as long for a link on which no force depends as for one that collides and is driven.
"""

from __future__ import annotations

from typing import Collection, Dict, Iterator, List, NamedTuple, Optional, Tuple
from xml.etree import ElementTree

import numpy as np
import pybullet

from telex_control.urdf import UrdfError, Vector, by_name, end, number, origin, root_links, vector

Quaternion = Tuple[float, float, float, float]
Pose = Tuple[Vector, Quaternion]

IDENTITY: Pose = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
_NO_MASS = 1.0e-5
"""What mere frames are given for tools that demand a mass (kg), at most."""
_WORLD_LINK = "world"
"""A root link of this name means the world itself, as Gazebo has it."""
_MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


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


class Masses(NamedTuple):
    """What `complete_masses` found.

    Attributes
    ----------
    fixed : bool
        Whether the root is held fast.
    remarks : list of str
        What of the description does not count, for a person.
    """

    fixed: bool
    remarks: List[str]


def take_out_wheels(root: ElementTree.Element, joints: Collection[str]) -> Dict[str, Frame]:
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
    links, carried = by_name(root, "link"), _carried(root)
    gone: Dict[str, Frame] = {}
    for joint in root.findall("joint"):
        name, parent = end(joint, "child"), end(joint, "parent")
        wheel, carrier = links.get(name), links.get(parent)
        if joint.get("name") not in joints or name in carried or wheel is None or carrier is None:
            continue
        if wheel.find("collision") is None and _is_placed(joint, wheel, carrier):
            pose = _origin(joint)
            axis = vector(
                joint.find("axis"), "xyz", f"joint '{joint.get('name')}'", (1.0, 0.0, 0.0)
            )
            _add_mass(carrier, wheel, pose)
            _take(root, joint, wheel, carrier, pose)
            gone[name] = Frame(parent, *pose, joint=joint.get("name", ""), axis=axis)
    return gone


def take_out_frames(root: ElementTree.Element) -> Dict[str, Frame]:
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
    links, carried = by_name(root, "link"), _carried(root)
    gone: Dict[str, Frame] = {}

    def is_bare(joint: ElementTree.Element) -> bool:
        name = end(joint, "child")
        link = links.get(name)
        return (
            joint.get("type") == "fixed"
            and link is not None
            and _is_placed(joint, link)
            and link.find("collision") is None
            and _mass(link) <= _NO_MASS
            and all(is_bare(each) for each in carried.get(name, ()))
        )

    def take(joint: ElementTree.Element, carrier: str, pose: Pose) -> None:
        name = end(joint, "child")
        pose = pybullet.multiplyTransforms(*pose, *_origin(joint))
        gone[name] = Frame(carrier, *pose)
        _take(root, joint, links[name], links[carrier], pose)
        for each in carried.get(name, ()):
            take(each, carrier, pose)

    for joint in root.findall("joint"):
        parent = end(joint, "parent")
        if parent in links and parent not in gone and is_bare(joint):
            take(joint, parent, IDENTITY)
    return gone


def complete_masses(root: ElementTree.Element, fixed_base: bool) -> Masses:
    """Give every link a mass that PyBullet can move.

    A root that is a mere frame gets the mass of the links that are fixed to it: a body moves as
    well from there, and a root of next to no mass would turn at once by any rounding error. All
    others without mass get one that does not count.

    Parameters
    ----------
    root : Element
        The robot; it is changed.
    fixed_base : bool
        Whether the root is to be held fast; one of the name ``world`` always is.
    """
    links = by_name(root, "link")
    remarks = [
        f"link '{name}' has the mass 0, so its <inertia> does not count"
        for name, link in links.items()
        if not _mass(link) and _inertial(link, IDENTITY)[2].any()
    ]
    fixed = fixed_base or _WORLD_LINK in root_links(root)
    for name in () if fixed else root_links(root):
        carrier = links[name]
        if _mass(carrier) > _NO_MASS:
            continue
        _remove_inertial(carrier)
        for link, pose in _fixed_to(name, links, _carried(root)):
            _add_mass(carrier, link, pose)
            _remove_inertial(link)
        if _mass(carrier) <= _NO_MASS:
            fixed = True
            remarks.append(
                f"link '{name}' is the root, and neither it nor what is fixed to it has a mass: it "
                "is held fast where it stands; give it one if it is to move"
            )
    for link in links.values():
        if not _mass(link):
            _remove_inertial(link)
            inertial = ElementTree.SubElement(link, "inertial")
            ElementTree.SubElement(inertial, "mass", value="1e-6")
            values = {key: "1e-9" if key[1] == key[2] else "0" for key in _MOMENTS}
            ElementTree.SubElement(inertial, "inertia", values)
    return Masses(fixed, remarks)


def _fixed_to(
    name: str,
    links: Dict[str, ElementTree.Element],
    carried: Dict[str, List[ElementTree.Element]],
    pose: Pose = IDENTITY,
) -> Iterator[Tuple[ElementTree.Element, Pose]]:
    """Yield all links that fixed joints hold at a link, and their poses in the frame of the first.

    One whose place is no numbers stays as it is, and what it carries.
    """
    for joint in carried.get(name, ()):
        child = end(joint, "child")
        if joint.get("type") == "fixed" and child in links and _is_placed(joint, links[child]):
            place = pybullet.multiplyTransforms(*pose, *_origin(joint))
            yield links[child], place
            yield from _fixed_to(child, links, carried, place)


def _remove_inertial(link: ElementTree.Element) -> None:
    for inertial in link.findall("inertial"):
        link.remove(inertial)


def _take(
    root: ElementTree.Element,
    joint: ElementTree.Element,
    link: ElementTree.Element,
    carrier: ElementTree.Element,
    pose: Pose,
) -> None:
    """Remove a link and its joint; what is to be seen of it goes to its carrier."""
    for visual in link.findall("visual"):
        _place(visual, pybullet.multiplyTransforms(*pose, *_origin(visual)))
        carrier.append(visual)
    root.remove(link)
    root.remove(joint)


def _carried(root: ElementTree.Element) -> Dict[str, List[ElementTree.Element]]:
    """Joints on each link that has any."""
    carried: Dict[str, List[ElementTree.Element]] = {}
    for joint in root.findall("joint"):
        carried.setdefault(end(joint, "parent"), []).append(joint)
    return carried


def _is_placed(joint: ElementTree.Element, *links: ElementTree.Element) -> bool:
    """Whether all origins of a joint and of links have the numbers that they should have."""
    try:
        for element in (joint, *(part for link in links for part in link)):
            _origin(element)
    except UrdfError:
        return False
    return True


def _origin(element: Optional[ElementTree.Element]) -> Pose:
    place = origin(element, "" if element is None else element.tag)
    return place.xyz, pybullet.getQuaternionFromEuler(place.rpy)


def _place(element: ElementTree.Element, pose: Pose) -> None:
    """Replace the origin of an element."""
    place = element.find("origin")
    if place is None:
        place = ElementTree.SubElement(element, "origin")
    for key, values in (("xyz", pose[0]), ("rpy", pybullet.getEulerFromQuaternion(pose[1]))):
        place.set(key, " ".join(repr(float(value)) for value in values))


def _mass(link: ElementTree.Element) -> float:
    """Mass (kg); 0 where none is given."""
    return number(link.find("inertial/mass"), "value", f"link '{link.get('name')}'", 0.0)


def _add_mass(link: ElementTree.Element, other: ElementTree.Element, pose: Pose) -> None:
    """Add the mass of another link, which is at `pose` in this one's frame."""
    parts = [_inertial(link, IDENTITY), _inertial(other, pose)]
    mass = sum(part[0] for part in parts)
    if mass <= 0.0:
        return
    centre: np.ndarray = np.add(*(part[0] * part[1] for part in parts)) / mass
    moments = np.zeros((3, 3))
    for share, place, own in parts:
        # The parallel axis theorem.
        away = place - centre
        moments += own + share * (away @ away * np.eye(3) - np.outer(away, away))
    _remove_inertial(link)
    inertial = ElementTree.SubElement(link, "inertial")
    ElementTree.SubElement(inertial, "mass", value=repr(mass))
    _place(inertial, ((centre[0], centre[1], centre[2]), IDENTITY[1]))
    values = moments[np.triu_indices(3)]
    ElementTree.SubElement(
        inertial, "inertia", {key: repr(float(value)) for key, value in zip(_MOMENTS, values)}
    )


def _inertial(link: ElementTree.Element, pose: Pose) -> Tuple[float, np.ndarray, np.ndarray]:
    """Mass (kg), centre of mass (m) and inertia about it (kg m2), where the link is at `pose`."""
    centre, turned = pybullet.multiplyTransforms(*pose, *_origin(link.find("inertial")))
    moments = np.zeros((3, 3))
    inertia, where = link.find("inertial/inertia"), f"link '{link.get('name')}'"
    moments[np.triu_indices(3)] = [number(inertia, key, where, 0.0) for key in _MOMENTS]
    moments = moments + np.triu(moments, 1).T
    rotation = np.reshape(pybullet.getMatrixFromQuaternion(turned), (3, 3))
    return _mass(link), np.array(centre), rotation @ moments @ rotation.T
