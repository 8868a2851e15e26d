"""Postures of a chain, random but fixed, and those of them that bring the tip near to a target.

Where an iteration is dear, as without a compiler, beginning near to the target saves many.
"""

from __future__ import annotations

import random
from typing import Iterator, Tuple

import numpy as np

from .ik_task import Task

SIZE = 4096
PARTS, ROUNDS = 8, 3


class PoseLibrary:
    """Poses of random postures.

    The distance of two poses is w^2 |p - p'|^2 + |R - R'|^2 / 2 with the Frobenius norm of the
    difference of the rotations, which for small angles is the squared angle: a dot product finds
    the nearest.

    Parameters
    ----------
    postures : ndarray, shape (m, n)
        rad, m.
    poses : ndarray, shape (m, 12)
        Position (m) and the rotation's nine entries, of each.
    """

    def __init__(self, postures: np.ndarray, poses: np.ndarray) -> None:
        self._postures = postures
        # Single precision is enough to choose by, and rows of one number each are twice as fast.
        self._rows = np.empty((13, len(poses)), dtype=np.float32)
        self._rows[:12] = poses.T
        self._rows[12] = np.einsum("ij,ij->i", poses[:, :3], poses[:, :3])
        self._parts = np.arange(0, len(poses), len(poses) // PARTS)

    def nearest(self, task: Task, seed: np.ndarray) -> Iterator[np.ndarray]:
        """Yield postures whose poses are near to a target, `ROUNDS` times `PARTS` of them.

        In each round the nearest of each part of the library that is left, which is quicker found
        than the nearest of all, in the order of their distance from the seed, by the joint that
        would move most.
        """
        weight = task.length_weight**2
        # All rotations have the same norm, and the target's square is the same for all.
        query = np.zeros(13, dtype=np.float32)
        query[:3] = (-2.0 * weight) * task.target[:3, 3]
        query[12] = weight
        if not np.isinf(task.bounds[3:]).all():
            query[3:12] = -task.target[:3, :3].ravel()
        # Not by BLAS: its threads would keep a second core busy.
        far = np.einsum("ij,i->j", self._rows, query)
        for _ in range(ROUNDS):
            chosen = far.reshape(PARTS, -1).argmin(axis=1) + self._parts
            found = self._postures[chosen]
            yield from found[abs(found - seed).max(axis=1).argsort(kind="stable")]
            far[chosen] = np.inf


def random_postures(box: Tuple[np.ndarray, np.ndarray], seed: int) -> np.ndarray:
    """Return `SIZE` postures in a box, shape (SIZE, n); over a turn where it has no end."""
    generator = random.Random(seed)
    lower = np.where(np.isinf(box[0]) | np.isinf(box[1]), -np.pi, box[0])
    upper = np.where(np.isinf(box[0]) | np.isinf(box[1]), np.pi, box[1])
    shares = [[generator.random() for _ in range(lower.size)] for _ in range(SIZE)]
    return lower + np.array(shares) * (upper - lower)
