"""Outlines of objects as they start: their corners, and what a plan shows of them from above."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Dict, List, Sequence, Tuple

import numpy as np

from telex_control.common.geometry.matrices import rotation_matrix
from telex_control.common.geometry.quaternions import Pose, compose, invert

from ..model import WORLD_FRAME, Form
from .assembly import Assembly, SegmentShape, joint_pose

_ROUND = 16
"""Corners of what is round."""
_MOST_CORNERS = 24
"""Of an outline: one of more is thinned out."""


@dataclass(frozen=True)
class Outline:
    """What a plan shows of an object.

    Attributes
    ----------
    frame : str
        In which it is: that of the object's root where it can move, otherwise the world's.
    bottom, top : float
        Height of the lowest and of the highest solid point (m); 0 where nothing of it is solid.
    polygons : tuple of numpy.ndarray
        Convex, one for each solid part; shapes (corners, 2) (m).
    """

    frame: str
    bottom: float
    top: float
    polygons: Tuple[np.ndarray, ...]


def solids(assembly: Assembly) -> List[np.ndarray]:
    """Corners of each solid part in the frame of the object's root (m), shapes (corners, 3)."""
    found: List[np.ndarray] = []
    for plan in assembly.bodies:
        frames: List[Pose] = []
        for segment in plan.segments:
            pose = joint_pose(segment.joint, segment.joint.start) if segment.joint else segment.pose
            frame = pose if segment.parent < 0 else compose(frames[segment.parent], pose)
            frames.append(frame)
            for shape in segment.shapes:
                found.append(_placed(_corners(shape), compose(frame, shape.pose)))
    return found


def extent(assemblies: Sequence[Assembly], root: Pose) -> np.ndarray:
    """Corners of objects that one entry makes, in the frame `root` of its origin; shape (N, 3)."""
    parts = [
        _placed(corners, compose(invert(root), (each.source.position, each.source.orientation)))
        for each in assemblies
        for corners in solids(each)
    ]
    return np.concatenate(parts) if parts else np.zeros((0, 3))


class Outlines:
    """Outlines of the objects of a scene; those of an object are made once."""

    def __init__(self) -> None:
        self._known: Dict[str, Tuple[Assembly, Outline]] = {}

    def of(self, assemblies: Sequence[Assembly]) -> List[Outline]:
        """Return the outline of each; what is not among them any more is forgotten."""
        known: Dict[str, Tuple[Assembly, Outline]] = {}
        for assembly in assemblies:
            name = assembly.source.name
            before = self._known.get(name)
            same = before is not None and before[0] is assembly
            known[name] = before if before is not None and same else (assembly, outline(assembly))
        self._known = known
        return [made for _, made in known.values()]


def outline(assembly: Assembly) -> Outline:
    """Return what a plan shows of an object."""
    source = assembly.source
    parts = solids(assembly)
    frame = f"{source.name}/{source.model.links[0].name}"
    if source.model.static:
        frame = WORLD_FRAME
        parts = [_placed(part, (source.position, source.orientation)) for part in parts]
    heights = np.concatenate([part[:, 2] for part in parts]) if parts else np.zeros(1)
    polygons = tuple(_hull(part[:, :2]) for part in parts)
    return Outline(frame, float(heights.min()), float(heights.max()), polygons)


def _corners(shape: SegmentShape) -> np.ndarray:
    """Corners of a shape in its own frame."""
    if shape.vertices is not None:
        return shape.vertices
    if shape.form is Form.BOX:
        half = 0.5 * np.array(shape.size)
        signs = np.array(np.meshgrid((-1, 1), (-1, 1), (-1, 1))).reshape(3, -1).T
        return signs * half
    radius = shape.size[0]
    if shape.form is Form.SPHERE:
        # Rings about three axes, so that it is as high and as wide however it is turned.
        ring = _ring(radius)
        return np.concatenate([ring, ring[:, [2, 0, 1]], ring[:, [1, 2, 0]]])
    end = np.array([0.0, 0.0, 0.5 * shape.size[2]])
    return np.concatenate([_ring(radius) - end, _ring(radius) + end])


def _ring(radius: float) -> np.ndarray:
    angles = np.arange(_ROUND) * 2.0 * math.pi / _ROUND
    return radius * np.column_stack([np.cos(angles), np.sin(angles), np.zeros(_ROUND)])


def _placed(points: np.ndarray, pose: Pose) -> np.ndarray:
    return points @ rotation_matrix(pose[1]).T + pose[0]


def _hull(points: np.ndarray) -> np.ndarray:
    """Convex hull of points in a plane, counter-clockwise (monotone chain)."""
    ordered = sorted(set(map(tuple, np.round(points, 4).tolist())))

    def half(along: Sequence[Tuple[float, ...]]) -> List[Tuple[float, ...]]:
        chain: List[Tuple[float, ...]] = []
        for point in along:
            while len(chain) > 1 and _turn(chain[-2], chain[-1], point) <= 0.0:
                chain.pop()
            chain.append(point)
        return chain[:-1]

    found = half(ordered) + half(ordered[::-1]) or ordered
    return np.array(found[:: math.ceil(len(found) / _MOST_CORNERS)])


def _turn(a: Sequence[float], b: Sequence[float], c: Sequence[float]) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
