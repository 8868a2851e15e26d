"""The chain of joints between two links of a robot."""

from __future__ import annotations

import math
from typing import Optional, Sequence, Tuple

import numpy as np
import PyKDL

from telex_control.common.geometry.matrices import Floats
from telex_control.urdf.joints import CONTINUOUS, UrdfJoint, joints, parse_urdf
from telex_control.urdf.model import Robot

from .kdl_tree import kdl_tree
from .urdf_tree import FIXED, KinematicsError, TreeJoint, UrdfTree


class Chain:
    """From a link of the robot out to another one.

    Parameters
    ----------
    robot : Robot
        See `telex_control.urdf.joints.parse_urdf`.
    base, tip : str
        Links; `tip` hangs on `base`.

    Attributes
    ----------
    path : tuple of TreeJoint
        All joints from base to tip, fixed ones too.
    joints : tuple of UrdfJoint
        The movable ones with their limits: what a position vector stands for, in its order.
    kdl : PyKDL.Chain
        For KDL's solvers, which do not keep it alive: hold the `Chain` as long as them.
    lower, upper : ndarray, shape (n,)
        Position limits (rad, m); infinite for continuous joints.
    velocity_limits : ndarray, shape (n,)
        rad/s, m/s; infinite where the URDF gives none.

    Raises
    ------
    KinematicsError, telex_control.urdf.joints.UrdfError
    """

    def __init__(self, robot: Robot, base: str, tip: str) -> None:
        tree = UrdfTree(robot)
        self.base, self.tip = base, tip
        self.path: Tuple[TreeJoint, ...] = tuple(tree.path(base, tip))
        movable = [joint.name for joint in self.path if joint.kind != FIXED]
        _check(robot, movable)
        limits = joints(robot)
        self.joints: Tuple[UrdfJoint, ...] = tuple(limits[name] for name in movable)
        self.lower = np.array([joint.lower for joint in self.joints])
        self.upper = np.array([joint.upper for joint in self.joints])
        self.velocity_limits = np.array([joint.velocity for joint in self.joints])
        self.kdl = kdl_tree(tree).getChain(base, tip)
        self._positions = PyKDL.ChainFkSolverPos_recursive(self.kdl)
        self._jacobians = PyKDL.ChainJntToJacSolver(self.kdl)

    @classmethod
    def from_urdf(cls, urdf: str, base: str, tip: str) -> Chain:
        """Make the chain from the text of a URDF; see the class."""
        return cls(parse_urdf(urdf), base, tip)

    @property
    def joint_names(self) -> Tuple[str, ...]:
        """Names of the movable joints, from base to tip."""
        return tuple(joint.name for joint in self.joints)

    def forward(self, positions: Floats, link: Optional[str] = None) -> np.ndarray:
        """Return the pose of the tip, or of another link of the chain.

        Parameters
        ----------
        positions : sequence of float
            Of `joints` (rad, m); their limits are not looked at.

        Returns
        -------
        ndarray, shape (4, 4)
            Homogeneous transform of the link's frame in the base link's (m).

        Raises
        ------
        KinematicsError
            There are more or fewer positions than joints, one is not finite, or the chain has no
            such link.
        """
        angles = self._joint_array(positions)
        frame = PyKDL.Frame()
        self._positions.JntToCart(angles, frame, self._segments_to(link or self.tip))
        return matrix(frame)

    def jacobian(self, positions: Floats) -> np.ndarray:
        """Return the geometric Jacobian of the tip.

        Parameters
        ----------
        positions : sequence of float
            Of `joints` (rad, m); their limits are not looked at.

        Returns
        -------
        ndarray, shape (6, n)
            Columns: velocity of the tip's origin (m/s) and of the tip's rotation (rad/s), in the
            base link's frame, for a joint speed of 1.

        Raises
        ------
        KinematicsError
            There are more or fewer positions than joints, or one is not finite.
        """
        angles = self._joint_array(positions)
        count = len(self.joints)
        found = PyKDL.Jacobian(count)
        self._jacobians.JntToJac(angles, found)
        return np.array([[found[row, column] for column in range(count)] for row in range(6)])

    def _joint_array(self, positions: Floats) -> PyKDL.JntArray:
        count = len(self.joints)
        if len(positions) != count:
            raise KinematicsError(
                f"{len(positions)} positions for the {count} joints from {self.base} to {self.tip}"
            )
        angles = PyKDL.JntArray(count)
        for index, position in enumerate(positions):
            if not math.isfinite(position):
                name = self.joints[index].name
                raise KinematicsError(f"position of {name} is {position}; a finite one is needed")
            angles[index] = position
        return angles

    def _segments_to(self, link: str) -> int:
        """How many segments of the chain lead to a link."""
        if link == self.base:
            return 0
        for number, joint in enumerate(self.path, start=1):
            if joint.child == link:
                return number
        raise KinematicsError(f"link '{link}' is not between {self.base} and {self.tip}")


def matrix(frame: PyKDL.Frame) -> np.ndarray:
    """Return a KDL frame as homogeneous transform, shape (4, 4)."""
    made = np.eye(4)
    for row in range(3):
        for column in range(4):
            made[row, column] = frame[row, column]
    return made


def _check(robot: Robot, names: Sequence[str]) -> None:
    """Refuse joints that are no free coordinates of the chain, or whose range nobody has given."""
    for name in names:
        joint = robot.joint_map[name]
        mimic, limit = joint.mimic, joint.limit
        if mimic is not None:
            raise KinematicsError(
                f"joint '{name}' mimics '{mimic.joint}'; only joints that move by "
                "themselves are possible in a chain"
            )
        if joint.type == CONTINUOUS or limit is None:
            continue
        if limit.lower is None and limit.upper is None:
            raise KinematicsError(
                f"joint '{name}' is {joint.type} and its <limit> has neither lower nor "
                "upper; give both, or make it continuous"
            )
