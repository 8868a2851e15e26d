"""Needs of an exercise, compared with the links and joints of a URDF."""

from __future__ import annotations

from typing import Iterator, Set, Tuple

from telex_control.kinematics.urdf_tree import UrdfTree

from .conditions import ELECTRONICS, ROBOT, TOOL
from .metric_kinds import KINDS
from .model import Exercise

_TOOL_LINK, _FINGER_LINK = "tool_link", "left_finger_tip_link"
_OPTICAL = "_camera_optical_frame"
_OF_TOOL = ("tool_path", "tool_path_ratio", "sparc", "slip")


def lacking(exercise: Exercise, urdf: str, of: str = "") -> Iterator[Tuple[str, str]]:
    """Yield what the robot of a URDF lacks: the key that asks for it, and what is needed.

    Parameters
    ----------
    of : str
        Which of the exercise's robots it is; empty: the first.

    Raises
    ------
    ValueError
        The URDF cannot be read.
    """
    tree = UrdfTree.from_urdf(urdf)
    links, joints = set(tree.inertials), {joint.name for joint in tree.joints()}
    for where, condition in exercise.conditions():
        for part in condition.walk():
            if part.robot != of:
                continue
            gripper = part.kind in ("held", "dropped") or getattr(part.of, "group", "") == "gripper"
            if gripper and _FINGER_LINK not in links:
                yield f"{where}/{part.kind}", "it needs a gripper"
            if getattr(part.of, "what", "") == TOOL and _TOOL_LINK not in links:
                yield f"{where}/{part.kind}", "it needs a tool"
            robot = part.kind == "joint" and part.of.object == ROBOT
            if robot and part.of.joint not in joints:
                yield f"{where}/joint", f"it needs the joint '{part.of.joint}'"
    yield from _unknown_components(exercise, links, of)
    for metric in exercise.metrics:
        if metric.robot == of and metric.kind in _OF_TOOL and _TOOL_LINK not in links:
            yield f"metrics/{metric.name}", f"{KINDS[metric.kind].text}: it needs a tool"


def _unknown_components(exercise: Exercise, links: Set[str], of: str) -> Iterator[Tuple[str, str]]:
    """Components whose dose is asked for, and that nothing would tell the dose of."""
    # What holds for all robots is of those that have the component.
    of_all = () if not of else tuple(exercise.radiation.limits)
    asked = [
        (f"{where}/dose/what", part.of.what)
        for where, condition in exercise.conditions()
        for part in condition.walk()
        if part.kind == "dose" and part.robot == of and part.of.what not in of_all
    ]
    asked += [
        (f"metrics/{metric.name}/object", metric.object or ROBOT)
        for metric in exercise.metrics
        if metric.kind == "dose" and metric.robot == of
    ]
    if not of:
        asked += [(f"history/{name}", name) for name in exercise.radiation.history]
    cameras = sorted(link[: -len(_OPTICAL)] for link in links if link.endswith(_OPTICAL))
    known = (ROBOT, *ELECTRONICS, *cameras)
    for where, name in asked:
        if name not in known:
            yield where, f"it is '{name}', and there are {', '.join(known)}: a component"
