"""Poses in messages of geometry_msgs: read into plain numbers and written from them."""

from __future__ import annotations

from typing import Any, Sequence, Tuple

import numpy as np
from geometry_msgs.msg import Point, Pose, Quaternion

from ..common.geometry import quaternions
from ..common.geometry.matrices import quaternion_of


def vector_in(message: Any) -> quaternions.Vector3:
    """Return x, y, z of a Vector3 or a Point."""
    return message.x, message.y, message.z


def quaternion_in(message: Any) -> quaternions.Quaternion:
    """Return x, y, z, w of a Quaternion."""
    return message.x, message.y, message.z, message.w


def pose_in(message: Any) -> Tuple[quaternions.Vector3, quaternions.Quaternion]:
    """Return position (m) and orientation of a Pose, as they are: nothing is checked."""
    return vector_in(message.position), quaternion_in(message.orientation)


def pose_message(position: Sequence[float], orientation: Sequence[float]) -> Pose:
    """Return a Pose of a position (m) and a quaternion x, y, z, w."""
    return Pose(Point(*position), Quaternion(*orientation))


def fill_pose(message: Pose, pose: np.ndarray) -> None:
    """Write a 4x4 transform into a Pose."""
    position, orientation = message.position, message.orientation
    position.x, position.y, position.z = pose[:3, 3].tolist()
    orientation.x, orientation.y, orientation.z, orientation.w = quaternion_of(pose).tolist()
