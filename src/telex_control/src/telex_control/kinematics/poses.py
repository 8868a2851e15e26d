"""Poses as 4x4 homogeneous transforms: made of what comes from outside, checked, moved."""

from __future__ import annotations

import math

import numpy as np

from telex_control.common.geometry.matrices import (
    Floats,
    pose_matrix,
    rotation_about,
    rotation_vector,
)
from telex_control.common.plausible import LARGEST_POSITION

from .urdf_tree import KinematicsError

BASE, TOOL = "base", "tool"
FRAMES = (BASE, TOOL)
_SKEW = 1e-6
"""Difference of R R^T from the identity that is taken for rounding."""
_EXACT = 1e-12
"""The same, below which nothing is corrected."""
_UNIT = 1e-3
"""Difference of a quaternion's norm from 1 that is taken for rounding."""


def make_pose(position: Floats, quaternion: Floats) -> np.ndarray:
    """Return the pose of a position and a quaternion.

    Parameters
    ----------
    position : sequence of 3 floats
        m.
    quaternion : sequence of 4 floats
        x, y, z, w.

    Returns
    -------
    ndarray, shape (4, 4)

    Raises
    ------
    KinematicsError
        A number is not finite, there are more or fewer, or the quaternion's norm is not 1.
    """
    place = vector(position, 3, "position")
    x, y, z, w = vector(quaternion, 4, "quaternion").tolist()
    norm = math.sqrt(x * x + y * y + z * z + w * w)
    if abs(norm - 1.0) > _UNIT:
        raise KinematicsError(
            f"quaternion is ({x:g}, {y:g}, {z:g}, {w:g}) with norm {norm:g}; norm 1 is needed"
        )
    return pose_matrix(place, (x / norm, y / norm, z / norm, w / norm))


def move_pose(pose: np.ndarray, twist: Floats, dt: float, frame: str = BASE) -> np.ndarray:
    """Return the pose after a twist has acted on it.

    Parameters
    ----------
    pose : ndarray, shape (4, 4)
    twist : sequence of 6 floats
        Velocity of the pose's origin (m/s), and its rotation about that origin (rad/s).
    dt : float
        s.
    frame : str
        Whose axes the twist is given along: ``base`` (those that the pose is given in) or ``tool``
        (those of the pose itself).

    Returns
    -------
    ndarray, shape (4, 4)

    Raises
    ------
    KinematicsError
        The frame is unknown, or a number is not finite.
    """
    speeds = vector(twist, 6, "twist") * positive(dt, "dt")
    moved = np.array(check_pose(pose, "pose"))
    turn = rotation_about(speeds[3:].tolist())
    if check_frame(frame) == TOOL:
        moved[:3, 3] += moved[:3, :3] @ speeds[:3]
        moved[:3, :3] = moved[:3, :3] @ turn
    else:
        moved[:3, 3] += speeds[:3]
        moved[:3, :3] = turn @ moved[:3, :3]
    return moved


class PoseLine:
    """The straight line from one pose to another, with the shortest turn."""

    def __init__(self, begin: np.ndarray, end: np.ndarray) -> None:
        self._begin = begin
        self._way = end[:3, 3] - begin[:3, 3]
        self._turn = rotation_vector(begin[:3, :3].T @ end[:3, :3])

    def at(self, share: float) -> np.ndarray:
        """Return the pose, shape (4, 4), at a share (0 to 1) of the line."""
        made = self._begin.copy()
        made[:3, 3] += share * self._way
        made[:3, :3] = made[:3, :3] @ rotation_about((share * self._turn).tolist())
        return made


def turned(pose: np.ndarray, twist: np.ndarray) -> np.ndarray:
    """Return a twist, shape (6,), with both of its vectors turned by a pose's rotation."""
    rotation = pose[:3, :3]
    return np.concatenate([rotation @ twist[:3], rotation @ twist[3:]])


def check_frame(frame: str) -> str:
    """Return the name of a frame; KinematicsError when it is none of `FRAMES`."""
    if frame not in FRAMES:
        raise KinematicsError(f"frame is {frame!r}; {' and '.join(FRAMES)} are possible")
    return frame


def check_pose(pose: np.ndarray, name: str) -> np.ndarray:
    """Return a pose as float64, its rotation freed of rounding errors.

    Parameters
    ----------
    pose : array_like, shape (4, 4)
    name : str
        For messages.

    Raises
    ------
    KinematicsError
        Another shape, a number that is not finite, a place beyond `LARGEST_POSITION`, another last
        row than 0 0 0 1, or no rotation.
    """
    made = _floats(pose, name)
    if made.shape != (4, 4):
        raise KinematicsError(f"{name} has shape {made.shape}; a 4x4 transform is needed")
    # Plain floats: on so few numbers, numpy's own calls cost several times as much.
    (a, b, c, x), (d, e, f, y), (g, h, i, z), last = made.tolist()
    if last != [0.0, 0.0, 0.0, 1.0]:
        _finite(made, name)
        raise KinematicsError(f"{name}: the last row is {last}; 0 0 0 1 is needed")
    error = max(
        abs(a * a + b * b + c * c - 1.0),
        abs(d * d + e * e + f * f - 1.0),
        abs(a * d + b * e + c * f),
        abs(g - (b * f - c * e)),
        abs(h - (c * d - a * f)),
        abs(i - (a * e - b * d)),
    )
    # The largest of numbers may miss a NaN among them, their sum does not.
    if not math.isfinite(a + b + c + d + e + f + g + h + i):
        error = math.nan
    far = max(abs(x), abs(y), abs(z)) if math.isfinite(x + y + z) else math.inf
    if error <= _EXACT and far <= LARGEST_POSITION:
        return made
    _finite(made, name)
    if far > LARGEST_POSITION:
        raise KinematicsError(
            f"{name}: its position is ({x:g}, {y:g}, {z:g}) m; numbers up to "
            f"{LARGEST_POSITION:g} are needed"
        )
    if not error <= _SKEW:
        raise KinematicsError(
            f"{name}: its upper left 3x3 part is no rotation (axes not orthonormal and right-"
            f"handed by {error:.2g}, {_SKEW:g} is allowed)"
        )
    left, _, right = np.linalg.svd(made[:3, :3])
    corrected = made.copy()
    corrected[:3, :3] = left @ right
    return corrected


def vector(values: Floats, count: int, name: str, largest: float = 1e150) -> np.ndarray:
    """Return numbers as a new float64 array.

    Raises
    ------
    KinematicsError
        More or fewer numbers than `count`, or one that is not finite or beyond `largest`.
    """
    made = _floats(values, name)
    if made.shape != (count,):
        raise KinematicsError(f"{name} has shape {made.shape}; {count} numbers are needed")
    # Infinities and NaN show in the sum of squares; where it is small, no number is large.
    if not made.dot(made) <= largest * largest:
        _finite(made, name)
        if abs(made).max() > largest:
            raise KinematicsError(
                f"{name} is {made.tolist()}; numbers up to {largest:g} are needed"
            )
    return made


def positive(value: float, name: str) -> float:
    """Return a number; KinematicsError unless it is finite and above 0."""
    if not (isinstance(value, (int, float, np.number)) and math.isfinite(value) and value > 0.0):
        raise KinematicsError(f"{name} is {value!r}; a finite number above 0 is needed")
    return float(value)


def _floats(values: object, name: str) -> np.ndarray:
    try:
        return np.array(values, dtype=float, order="C")
    except (TypeError, ValueError):
        raise KinematicsError(f"{name} is {values!r:.80}; numbers are needed") from None


def _finite(values: np.ndarray, name: str) -> None:
    if not np.isfinite(values).all():
        raise KinematicsError(f"{name} is {values.tolist()}; finite numbers are needed")
