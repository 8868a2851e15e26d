"""The solids of all links, put together by the joints of the URDF: gaps and overlaps between them.

Collision shapes are coarser than what is seen; only the solids themselves show whether two links
really clear each other.
"""

from __future__ import annotations

from itertools import combinations
from typing import Callable, Dict, List, Mapping, NamedTuple, Optional, Tuple

import numpy as np
from manifold3d import Manifold
from telex_cad import hull, running_gear, tools
from telex_cad.figures import Figures
from telex_cad.link_model import LinkModel
from telex_cad.solids import union
from telex_cad.upper import arm, gripper, turret
from urdf_parser_py.urdf import URDF, Joint

from telex_control.common.geometry.matrices import rotation_about, rotation_from_rpy


class Gap(NamedTuple):
    """Distance between two links (m); 0 where they touch or overlap."""

    distance: float
    first: str
    second: str


def motion(joint: Joint, position: float) -> np.ndarray:
    """Return the 4x4 pose of a joint's child in its parent at a position (rad, m)."""
    pose = np.eye(4)
    if joint.origin is not None:
        pose[:3, 3] = joint.origin.xyz or (0, 0, 0)
        pose[:3, :3] = rotation_from_rpy(joint.origin.rpy or (0, 0, 0))
    moved = np.eye(4)
    if joint.type in ("revolute", "continuous"):
        moved[:3, :3] = rotation_about(position * np.array(joint.axis))
    elif joint.type == "prismatic":
        moved[:3, 3] = position * np.array(joint.axis)
    return pose @ moved


def models_by_link(figures: Figures) -> Dict[str, LinkModel]:
    """Return what each link looks like, the links of all tools among them.

    The four flippers and the four drive wheels share their models.
    """
    models = {
        link.name: link
        for module in (hull, turret, arm, gripper, tools)
        for link in module.links(figures)
    }
    front, rear, track = running_gear.links(figures)
    for end, flipper in (("front", front), ("rear", rear)):
        for side in ("left", "right"):
            models[f"{end}_{side}_flipper_link"] = flipper
            models[f"{end}_{side}_track_link"] = track
    return models


class Assembly:
    """Links in their places.

    Parameters
    ----------
    robot
        Joints and frames.
    models
        What each link looks like; links that the robot lacks (other tools) are left out.
    """

    def __init__(self, robot: URDF, models: Mapping[str, LinkModel]) -> None:
        self.robot = robot
        self.solids: Dict[str, Manifold] = {
            name: union(model.merged().values())
            for name, model in models.items()
            if name in robot.link_map
        }
        self._parents = {joint.child: joint.parent for joint in robot.joints}
        self._joints_below: Dict[str, List[Joint]] = {}
        for joint in robot.joints:
            self._joints_below.setdefault(joint.parent, []).append(joint)

    def frames(self, positions: Mapping[str, float]) -> Dict[str, np.ndarray]:
        """Return the 4x4 poses of all links in the root's frame; joints not named stand at 0."""
        root = self.robot.get_root()
        poses = {root: np.eye(4)}
        waiting = [root]
        while waiting:
            parent = waiting.pop()
            for joint in self._joints_below.get(parent, []):
                poses[joint.child] = poses[parent] @ motion(joint, positions.get(joint.name, 0.0))
                waiting.append(joint.child)
        return poses

    def placed(self, positions: Mapping[str, float]) -> Dict[str, Manifold]:
        """Return the solids in the root's frame."""
        frames = self.frames(positions)
        return {name: solid.transform(frames[name][:3]) for name, solid in self.solids.items()}

    def bounds(self, positions: Mapping[str, float]) -> Tuple[np.ndarray, np.ndarray]:
        """Return the lower and upper corner of the box round everything (m, root's frame)."""
        boxes = np.array([solid.bounding_box() for solid in self.placed(positions).values()])
        return boxes[:, :3].min(axis=0), boxes[:, 3:].max(axis=0)

    def adjacent(self, first: str, second: str) -> bool:
        """Whether one of the links carries the other."""
        return self._parents.get(first) == second or self._parents.get(second) == first

    def gaps(
        self,
        positions: Mapping[str, float],
        below: float,
        wanted: Optional[Callable[[str, str], bool]] = None,
    ) -> List[Gap]:
        """Return the pairs of links that are nearer to each other than `below` (m), nearest first.

        wanted: which pairs to look at; None: all that are not adjacent.
        """
        solids = self.placed(positions)
        boxes = {name: np.array(solid.bounding_box()) for name, solid in solids.items()}
        found = []
        for first, second in combinations(solids, 2):
            if not (wanted(first, second) if wanted else not self.adjacent(first, second)):
                continue
            one, other = boxes[first], boxes[second]
            if (one[:3] > other[3:] + below).any() or (other[:3] > one[3:] + below).any():
                continue
            distance = solids[first].min_gap(solids[second], below)
            if distance < below:
                found.append(Gap(distance, first, second))
        return sorted(found)

    def adjacent_overlaps(
        self, positions: Mapping[str, float], above: float
    ) -> List[Tuple[float, str, str]]:
        """Return adjacent pairs whose solids share more than a volume (m3), largest first."""
        solids = self.placed(positions)
        found = []
        for child, parent in self._parents.items():
            if child in solids and parent in solids:
                volume = (solids[child] ^ solids[parent]).volume()
                if volume > above:
                    found.append((volume, parent, child))
        return sorted(found, reverse=True)
