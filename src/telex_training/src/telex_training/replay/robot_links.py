"""Poses of all links of a robot, of its root's pose and its joints."""

from __future__ import annotations

from typing import Dict, List, Mapping, Tuple

from telex_control.common.geometry.quaternions import Pose, about, compose, quaternion_from_rpy
from telex_control.kinematics.urdf_tree import FIXED, TreeJoint, UrdfTree

_PRISMATIC = "prismatic"
_UNTURNED = (0.0, 0.0, 0.0, 1.0)


class RobotLinks:
    """Forward kinematics from the root link to every link.

    Attributes
    ----------
    names : tuple of str
        Of the links, the root first.

    Raises
    ------
    telex_control.urdf.elements.UrdfError
    """

    def __init__(self, urdf: str) -> None:
        tree = UrdfTree.from_urdf(urdf)
        self._root = tree.root
        self._joints: List[Tuple[TreeJoint, Pose]] = [
            (joint, (joint.origin.xyz, quaternion_from_rpy(joint.origin.rpy)))
            for joint in tree.joints()
        ]
        self.names: Tuple[str, ...] = (
            tree.root,
            *(joint.child for joint, _ in self._joints),
        )

    def poses(self, base: Pose, joints: Mapping[str, float]) -> List[Pose]:
        """Poses in the world, in the order of `names`.

        Parameters
        ----------
        base : Pose
            Of the root link (m, quaternion x y z w).
        joints : mapping of str to float
            Positions (rad, m); a joint that is missing stands at 0.
        """
        found: Dict[str, Pose] = {self._root: base}
        for joint, origin in self._joints:
            pose = origin
            position = joints.get(joint.name, 0.0)
            if joint.kind == _PRISMATIC:
                x, y, z = joint.axis
                shift = (x * position, y * position, z * position)
                pose = compose(origin, (shift, _UNTURNED))
            elif joint.kind != FIXED and position:
                pose = compose(origin, ((0.0, 0.0, 0.0), about(joint.axis, position)))
            found[joint.child] = compose(found[joint.parent], pose)
        return [found[name] for name in self.names]
