"""The chain of joints between two links of a robot."""

from __future__ import annotations

from typing import Optional, Sequence, Tuple
from xml.etree import ElementTree

import numpy as np
import PyKDL

from telex_control.urdf_joints import UrdfJoint, joints

from .kdl_tree import kdl_tree
from .urdf_tree import FIXED, KinematicsError, TreeJoint, UrdfTree


class KinematicChain:
    """From a link of the robot out to another one.

    Parameters
    ----------
    robot : Element
        ``<robot>`` of the URDF.
    base, tip : str
        Links; `tip` hangs on `base`.

    Attributes
    ----------
    path : tuple of TreeJoint
        All joints from base to tip, fixed ones too.
    joints : tuple of UrdfJoint
        The movable ones with their limits: what a position vector stands for, in its order.
    kdl : PyKDL.Chain
        For KDL's solvers.

    Raises
    ------
    KinematicsError, telex_control.urdf_joints.UrdfError
    """

    def __init__(self, robot: ElementTree.Element, base: str, tip: str) -> None:
        tree = UrdfTree(robot)
        self.base, self.tip = base, tip
        self.path: Tuple[TreeJoint, ...] = tuple(tree.path(base, tip))
        limits = joints(robot)
        self.joints: Tuple[UrdfJoint, ...] = tuple(
            limits[joint.name] for joint in self.path if joint.kind != FIXED
        )
        self.kdl = kdl_tree(tree).getChain(base, tip)
        self._solver = PyKDL.ChainFkSolverPos_recursive(self.kdl)

    @property
    def joint_names(self) -> Tuple[str, ...]:
        """Names of the movable joints, from base to tip."""
        return tuple(joint.name for joint in self.joints)

    def forward(self, positions: Sequence[float], link: Optional[str] = None) -> np.ndarray:
        """Return the pose of the tip, or of another link of the chain.

        Parameters
        ----------
        positions : sequence of float
            Of `joints` (rad, m); their limits are not looked at.
        link : str, optional

        Returns
        -------
        ndarray, shape (4, 4)
            Homogeneous transform of the link's frame in the base link's (m).

        Raises
        ------
        KinematicsError
            There are more or fewer positions than joints, or the chain has no such link.
        """
        count = len(self.joints)
        if len(positions) != count:
            raise KinematicsError(
                f"{len(positions)} positions for the {count} joints from {self.base} to {self.tip}"
            )
        angles = PyKDL.JntArray(count)
        for index, position in enumerate(positions):
            angles[index] = position
        frame = PyKDL.Frame()
        self._solver.JntToCart(angles, frame, self._segments_to(link or self.tip))
        return _matrix(frame)

    def _segments_to(self, link: str) -> int:
        """How many segments of the chain lead to a link."""
        if link == self.base:
            return 0
        for number, joint in enumerate(self.path, start=1):
            if joint.child == link:
                return number
        raise KinematicsError(f"link '{link}' is not between {self.base} and {self.tip}")


def _matrix(frame: PyKDL.Frame) -> np.ndarray:
    made = np.eye(4)
    for row in range(3):
        for column in range(4):
            made[row, column] = frame[row, column]
    return made
