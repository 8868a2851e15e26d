"""Modified Denavit-Hartenberg parameters (Craig), derived from the axes of a chain.

Frame i lies on the axis of joint i, its x axis along the common normal from there to the axis of
joint i + 1. From frame i - 1 to frame i lead a turn alpha and a shift a about and along x, then a
turn theta and a shift d about and along the new z (J. J. Craig, Introduction to Robotics, ch. 3).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import List, Sequence, Tuple

import numpy as np

from telex_control.common.geometry.matrices import inverse
from telex_control.urdf.joints import PRISMATIC

from .chain import Chain
from .urdf_tree import FIXED, KinematicsError

_PARALLEL = 1e-9
"""Sine of the angle, or distance (m), below which axes are parallel, or meet."""


@dataclass(frozen=True)
class DHRow:
    """One joint.

    Attributes
    ----------
    alpha, a : float
        Twist (rad) and length (m) of the link before the joint: alpha(i-1), a(i-1).
    theta, d : float
        Angle (rad) and offset (m) of the joint at position 0.
    prismatic : bool
        The position adds to `d` instead of `theta`.
    """

    joint: str
    alpha: float
    a: float
    theta: float
    d: float
    prismatic: bool

    def transform(self, position: float) -> np.ndarray:
        """Return the pose of frame i in frame i - 1.

        Parameters
        ----------
        position : float
            Of the joint (rad, m).

        Returns
        -------
        ndarray, shape (4, 4)
        """
        theta = self.theta + (0.0 if self.prismatic else position)
        d = self.d + (position if self.prismatic else 0.0)
        ct, st = math.cos(theta), math.sin(theta)
        ca, sa = math.cos(self.alpha), math.sin(self.alpha)
        return np.array(
            [
                [ct, -st, 0.0, self.a],
                [st * ca, ct * ca, -sa, -sa * d],
                [st * sa, ct * sa, ca, ca * d],
                [0.0, 0.0, 0.0, 1.0],
            ]
        )


@dataclass(frozen=True)
class DHChain:
    """A chain in Denavit-Hartenberg parameters.

    Attributes
    ----------
    base : ndarray, shape (4, 4)
        Frame 0 in the base link.
    tool : ndarray, shape (4, 4)
        The tip link in the last frame.
    """

    base: np.ndarray
    rows: Tuple[DHRow, ...]
    tool: np.ndarray

    def frames(self, positions: Sequence[float]) -> List[np.ndarray]:
        """Return the poses of frames 0 to n and of the tip in the base link.

        Parameters
        ----------
        positions : sequence of float
            Of the joints (rad, m).

        Returns
        -------
        list of ndarray, shape (4, 4)

        Raises
        ------
        KinematicsError
            There are more or fewer positions than joints.
        """
        if len(positions) != len(self.rows):
            raise KinematicsError(f"{len(positions)} positions for {len(self.rows)} joints")
        found = [self.base]
        for row, position in zip(self.rows, positions):
            found.append(found[-1] @ row.transform(position))
        return [*found, found[-1] @ self.tool]

    def forward(self, positions: Sequence[float]) -> np.ndarray:
        """Return the pose of the tip in the base link: the product of all transforms."""
        return self.frames(positions)[-1]


@dataclass(frozen=True)
class _Axis:
    """A joint's axis at position 0, in the base link."""

    point: np.ndarray
    direction: np.ndarray


def dh_chain(chain: Chain) -> DHChain:
    """Derive the Denavit-Hartenberg parameters of a chain.

    Where the convention leaves a choice (axes that meet or are parallel, both ends of the chain),
    joint angles and offsets are made 0, or else the smaller ones, negative before positive.

    Raises
    ------
    KinematicsError
        The chain has no movable joint.
    """
    axes = _axes(chain)
    if not axes:
        raise KinematicsError(f"no joint between {chain.base} and {chain.tip} can move")
    tip = chain.forward([0.0] * len(axes))
    # Frame 0: on the first axis, at the height and along the x axis of the base link.
    first = axes[0]
    x = _perpendicular(np.array([1.0, 0.0, 0.0]), first.direction)
    origin = first.point - np.dot(first.point, first.direction) * first.direction
    base = _frame(origin, x, first.direction)
    rows = []
    frame = base
    for index, axis in enumerate(axes):
        following = axes[index + 1] if index + 1 < len(axes) else None
        before = frame
        if following is None:
            # The last frame has the tip's place along its axis.
            x = _perpendicular(before[:3, 0], axis.direction)
            along = np.dot(tip[:3, 3] - axis.point, axis.direction)
            origin = axis.point + along * axis.direction
        else:
            origin, x = _normal(axis, following, before)
        frame = _frame(origin, x, axis.direction)
        rows.append(_row(chain, index, before, frame))
    return DHChain(base, tuple(rows), inverse(frame) @ tip)


def _axes(chain: Chain) -> List[_Axis]:
    found = []
    zero = [0.0] * len(chain.joints)
    for joint in chain.path:
        if joint.kind != FIXED:
            pose = chain.forward(zero, joint.child)
            found.append(_Axis(pose[:3, 3], pose[:3, :3] @ np.array(joint.axis)))
    return found


def _normal(axis: _Axis, following: _Axis, before: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
    """Foot on `axis` of its common normal with the `following` one, and the normal's direction."""
    across = np.cross(axis.direction, following.direction)
    between = following.point - axis.point
    if np.linalg.norm(across) < _PARALLEL:
        # Any common normal will do: the one through the frame before.
        along = np.dot(before[:3, 3] - axis.point, axis.direction)
        foot = axis.point + along * axis.direction
        offset = between - np.dot(between, axis.direction) * axis.direction
        if np.linalg.norm(offset) < _PARALLEL:
            return foot, _perpendicular(before[:3, 0], axis.direction)
        return foot, offset / np.linalg.norm(offset)
    along = np.dot(np.cross(between, following.direction), across) / np.dot(across, across)
    foot = axis.point + along * axis.direction
    normal = across / np.linalg.norm(across)
    distance = np.dot(between, normal)
    if abs(distance) >= _PARALLEL:
        return foot, math.copysign(1.0, distance) * normal
    # The axes meet: the normal may point to either side.
    turns = [(_angle(before[:3, 0], x, axis.direction), x) for x in (normal, -normal)]
    turns.sort(key=lambda turn: (round(abs(turn[0]), 9), turn[0]))
    return foot, turns[0][1]


def _row(chain: Chain, index: int, before: np.ndarray, frame: np.ndarray) -> DHRow:
    joint = chain.joints[index]
    step = frame[:3, 3] - before[:3, 3]
    return DHRow(
        joint=joint.name,
        alpha=_angle(before[:3, 2], frame[:3, 2], before[:3, 0]),
        a=_clean(np.dot(step, before[:3, 0])),
        theta=_angle(before[:3, 0], frame[:3, 0], frame[:3, 2]),
        d=_clean(np.dot(step, frame[:3, 2])),
        prismatic=joint.kind == PRISMATIC,
    )


def _angle(start: np.ndarray, end: np.ndarray, about: np.ndarray) -> float:
    """Angle (rad) from one direction to another about an axis perpendicular to both."""
    return _clean(math.atan2(np.dot(np.cross(start, end), about), np.dot(start, end)))


def _clean(value: float) -> float:
    """A figure without the dust of rounding, and no -0."""
    return round(float(value), 12) + 0.0


def _perpendicular(direction: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """Unit vector perpendicular to `axis`, as near to `direction` as can be."""
    rest = direction - np.dot(direction, axis) * axis
    if np.linalg.norm(rest) < _PARALLEL:
        rest = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    return rest / np.linalg.norm(rest)


def _frame(origin: np.ndarray, x: np.ndarray, z: np.ndarray) -> np.ndarray:
    made = np.eye(4)
    made[:3, 0], made[:3, 1], made[:3, 2], made[:3, 3] = x, np.cross(z, x), z, origin
    return made
