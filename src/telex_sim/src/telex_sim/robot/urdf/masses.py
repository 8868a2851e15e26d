"""The masses and inertias of a URDF, made such that PyBullet can move the robot.

PyBullet takes 1 kg for a link without ``<inertial>``, holds one of mass 0 fast in the world, and
drops the whole of an inertia that no body can have. The XML itself is changed; see `elements`.
"""

from __future__ import annotations

from typing import Dict, Iterator, List, NamedTuple, Tuple
from xml.etree import ElementTree

import numpy as np

from telex_control.common.geometry.matrices import rotation_matrix
from telex_control.common.geometry.quaternions import IDENTITY, Pose, compose
from telex_control.urdf.elements import number as described_number
from telex_control.urdf.model import Robot, UrdfError

from .elements import (
    Element,
    by_name,
    carried_joints,
    end,
    mass_of,
    number,
    pose_of,
    root_links,
    set_pose,
)

NO_MASS = 1.0e-5
"""What mere frames are given for tools that demand a mass (kg), at most."""
_WORLD_LINK = "world"
"""A root link of this name means the world itself, as Gazebo has it."""
_ROUNDING = 1.0e-6
"""Share of the largest moment of inertia by which others may miss what a body can have."""
_EDGE = 1.0e-9
"""Share of it within which rounding decides whether PyBullet takes the inertia of a thin plate."""
_THIN = 1.0e-4
"""Share by which a mended inertia stays off what PyBullet might take for none."""
_MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


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


def complete_masses(root: Element, fixed_base: bool) -> Masses:
    """Give every link a mass and an inertia that PyBullet can move.

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
    remarks = [remark for link in links.values() for remark in _mend_inertia(link)]
    fixed = fixed_base or _WORLD_LINK in root_links(root)
    for name in () if fixed else root_links(root):
        carrier = links[name]
        if mass_of(carrier) > NO_MASS:
            continue
        _remove_inertial(carrier)
        for link, pose in _fixed_to(name, links, carried_joints(root)):
            add_mass(carrier, link, pose)
            _remove_inertial(link)
        if mass_of(carrier) <= NO_MASS:
            fixed = True
            remarks.append(
                f"link '{name}' is the root, and neither it nor what is fixed to it has a mass: it "
                "is held fast where it stands; give it one if it is to move"
            )
    for link in links.values():
        if not mass_of(link):
            _remove_inertial(link)
            inertial = ElementTree.SubElement(link, "inertial")
            ElementTree.SubElement(inertial, "mass", value="1e-6")
            _write_inertia(inertial, 1e-9 * np.eye(3))
    return Masses(fixed, remarks)


def massless_joints(robot: Robot) -> List[str]:
    """Return the joints that move nothing with a mass."""
    above = {joint.child: joint for joint in robot.joints}
    loaded = set()
    for name, link in robot.link_map.items():
        mass = described_number(link.inertial, "mass", f"link '{name}'", 0.0)
        joint = above.get(name) if mass > NO_MASS else None
        while joint is not None and joint.name not in loaded:
            loaded.add(joint.name)
            joint = above.get(joint.parent)
    return [name for name in robot.joint_map if name not in loaded]


def _mend_inertia(link: Element) -> Iterator[str]:
    """Replace an inertia that no body can have by the nearest one; yields what to tell of it.

    Some are in most robots that are made with CAD: PyBullet drops them, and says so in its own
    words, those of thin plates too, which have a moment that is the sum of the others.
    """
    mass, _, inertia = _inertial(link, IDENTITY)
    if not mass:
        if inertia.any():
            yield f"link '{link.get('name')}' has the mass 0, so its <inertia> does not count"
        return
    moments, axes = np.linalg.eigh(inertia)
    largest = np.max(np.abs(moments))
    # No moment of a body is larger than the sum of the other two.
    low, high = -moments[0], moments[2] - max(moments[0], 0.0) - max(moments[1], 0.0)
    if not largest or max(low / largest, high / largest) < -_EDGE:
        return
    possible = np.maximum(moments, _THIN * max(moments[2], 0.0))
    excess = max(possible[2] - possible[0] - possible[1], 0.0)
    possible = possible + excess / 3.0 * np.array([1.0, 1.0, -1.0])
    possible[2] = min(possible[2], (1.0 - _THIN) * (possible[0] + possible[1]))
    if max(low, high) > _ROUNDING * largest:
        yield (
            f"link '{link.get('name')}' has an inertia that no body can have: the principal "
            f"moments {_listed(moments)} kg m2 count as {_listed(possible)}"
        )
    element = link.find("inertial")
    assert element is not None
    for old in element.findall("inertia"):
        element.remove(old)
    # Above, it was turned into the link's axes.
    set_pose(element, (pose_of(element)[0], IDENTITY[1]))
    _write_inertia(element, axes @ np.diag(possible) @ axes.T)


def _listed(moments: np.ndarray) -> str:
    return ", ".join(f"{moment:.3g}" for moment in moments)


def _write_inertia(inertial: Element, moments: np.ndarray) -> None:
    values = moments[np.triu_indices(3)]
    ElementTree.SubElement(
        inertial, "inertia", {key: repr(float(value)) for key, value in zip(_MOMENTS, values)}
    )


def _fixed_to(
    name: str,
    links: Dict[str, Element],
    carried: Dict[str, List[Element]],
    pose: Pose = IDENTITY,
) -> Iterator[Tuple[Element, Pose]]:
    """Yield all links that fixed joints hold at a link, and their poses in its frame.

    One whose place is no numbers stays as it is, and what it carries.
    """
    for joint in carried.get(name, ()):
        child = end(joint, "child")
        if joint.get("type") == "fixed" and child in links and is_placed(joint, links[child]):
            place = compose(pose, pose_of(joint))
            yield links[child], place
            yield from _fixed_to(child, links, carried, place)


def _remove_inertial(link: Element) -> None:
    for inertial in link.findall("inertial"):
        link.remove(inertial)


def is_placed(joint: Element, *links: Element) -> bool:
    """Whether all origins of a joint and of links have the numbers that they should have."""
    try:
        for element in (joint, *(part for link in links for part in link)):
            pose_of(element)
    except UrdfError:
        return False
    return True


def add_mass(link: Element, other: Element, pose: Pose) -> None:
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
    set_pose(inertial, ((centre[0], centre[1], centre[2]), IDENTITY[1]))
    _write_inertia(inertial, moments)


def _inertial(link: Element, pose: Pose) -> Tuple[float, np.ndarray, np.ndarray]:
    """Mass (kg), centre of mass (m) and inertia about it (kg m2), where the link is at `pose`."""
    centre, turned = compose(pose, pose_of(link.find("inertial")))
    moments = np.zeros((3, 3))
    inertia, where = link.find("inertial/inertia"), f"link '{link.get('name')}'"
    moments[np.triu_indices(3)] = [number(inertia, key, where) for key in _MOMENTS]
    moments = moments + np.triu(moments, 1).T
    rotation = rotation_matrix(turned)
    return mass_of(link), np.array(centre), rotation @ moments @ rotation.T
