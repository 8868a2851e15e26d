"""Kinematics of the robot from its URDF: chains, forward and inverse kinematics, DH parameters."""

from telex_control.common.geometry.matrices import quaternion_of, rotation_vector

from .chain import Chain
from .denavit_hartenberg import DHChain, DHRow, dh_chain
from .inverse.options import FREE, Goal, IKOptions, Mode, Tolerance
from .inverse.result import IKResult, IKStatus, TrackResult
from .inverse.solver import ACCELERATION_TIME, IKSolver
from .kdl_tree import kdl_tree
from .poses import make_pose, move_pose
from .urdf_tree import KinematicsError, UrdfTree

__all__ = [
    "ACCELERATION_TIME",
    "FREE",
    "Chain",
    "DHChain",
    "DHRow",
    "Goal",
    "IKOptions",
    "IKResult",
    "IKSolver",
    "IKStatus",
    "KinematicsError",
    "Mode",
    "Tolerance",
    "TrackResult",
    "UrdfTree",
    "dh_chain",
    "kdl_tree",
    "make_pose",
    "move_pose",
    "quaternion_of",
    "rotation_vector",
]
