"""Kinematics of the robot from its URDF: KDL trees and chains, Denavit-Hartenberg parameters."""

from .chain import KinematicChain
from .denavit_hartenberg import DHChain, DHRow, dh_chain
from .kdl_tree import kdl_tree
from .urdf_tree import KinematicsError, UrdfTree

__all__ = [
    "DHChain",
    "DHRow",
    "KinematicChain",
    "KinematicsError",
    "UrdfTree",
    "dh_chain",
    "kdl_tree",
]
