"""Groups of a robot's links, by which its contacts are told apart: base, tracks, arm, gripper."""

from __future__ import annotations

from typing import Dict, List, Sequence

from ..engine.world import Body
from ..robot.robot import Robot
from .ledger import ARM, BASE, GRIPPER, TRACKS

NAMES = ("base", "tracks", "arm", "gripper")
"""Names of the groups, by their numbers."""


def link_groups(robot: Robot) -> Dict[str, int]:
    """Group of each link that PyBullet has.

    The gripper is the last link that carries both pads, with all that hangs on it; the arm is what
    its first watched joint moves (``proximity/joints``), and the gripper is no part of it; a track
    is a link that a belt runs round; the base is everything else.

    Parameters
    ----------
    robot : Robot
        Placed in a world.
    """
    body, config = robot.body, robot.config
    carriers = _carriers(body)
    groups = dict.fromkeys(body.links, BASE)
    for belt in config.tracks.belts:
        groups[body.parents[belt]] = TRACKS
    arm = [name for name in config.proximity.joints if name in body.joints]
    if arm:
        _mark(groups, carriers, _child(body, arm[0]), ARM)
    pads = config.gripper_contact.pads
    if pads and all(name in body.links for name in pads):
        lines = [_line(carriers, name) for name in pads]
        shared = [name for name in lines[0] if all(name in line for line in lines)]
        _mark(groups, carriers, shared[0], GRIPPER)
    return groups


def _carriers(body: Body) -> Dict[str, str]:
    """Parent of each link; the base has none."""
    return {_child(body, joint): body.parents[joint] for joint in body.joints}


def _child(body: Body, joint: str) -> str:
    names = {index: name for name, index in body.links.items()}
    return names[body.joints[joint]]


def _line(carriers: Dict[str, str], link: str) -> List[str]:
    """A link and all that carries it, up to the base."""
    line = [link]
    while line[-1] in carriers:
        line.append(carriers[line[-1]])
    return line


def _mark(groups: Dict[str, int], carriers: Dict[str, str], root: str, group: int) -> None:
    """Give a group to a link and to all that hangs on it."""
    for name in _below(carriers, root, list(groups)):
        groups[name] = group


def _below(carriers: Dict[str, str], root: str, links: Sequence[str]) -> List[str]:
    return [name for name in links if root in _line(carriers, name)]
