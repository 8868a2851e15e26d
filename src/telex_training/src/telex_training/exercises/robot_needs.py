"""Needs of an exercise, compared with the links and joints of a URDF."""

from __future__ import annotations

from typing import Iterator, Tuple

from telex_control.kinematics.urdf_tree import UrdfTree

from .conditions import ROBOT, TOOL
from .metric_kinds import KINDS
from .model import Exercise

_TOOL_LINK, _FINGER_LINK = "tool_link", "left_finger_tip_link"
_OF_TOOL = ("tool_path", "tool_path_ratio", "sparc", "slip")


def lacking(exercise: Exercise, urdf: str) -> Iterator[Tuple[str, str]]:
    """Yield what the robot of a URDF lacks: the key that asks for it, and what is needed.

    Raises
    ------
    ValueError
        The URDF cannot be read.
    """
    tree = UrdfTree.from_urdf(urdf)
    links, joints = set(tree.inertials), {joint.name for joint in tree.joints()}
    for where, condition in exercise.conditions():
        for part in condition.walk():
            gripper = part.kind in ("held", "dropped") or getattr(part.of, "group", "") == "gripper"
            if gripper and _FINGER_LINK not in links:
                yield f"{where}/{part.kind}", "it needs a gripper"
            if getattr(part.of, "what", "") == TOOL and _TOOL_LINK not in links:
                yield f"{where}/{part.kind}", "it needs a tool"
            robot = part.kind == "joint" and part.of.object == ROBOT
            if robot and part.of.joint not in joints:
                yield f"{where}/joint", f"it needs the joint '{part.of.joint}'"
    for metric in exercise.metrics:
        if metric.kind in _OF_TOOL and _TOOL_LINK not in links:
            yield f"metrics/{metric.name}", f"{KINDS[metric.kind].text}: it needs a tool"
