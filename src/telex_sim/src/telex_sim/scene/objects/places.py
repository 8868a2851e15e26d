"""Places in a running scene: what a ray meets, and how high something stands somewhere.

Only the thread that owns the PyBullet client may use what is here.
"""

from __future__ import annotations

import math
from typing import Collection, List, NamedTuple, Optional, Sequence, Set, Tuple

import numpy as np
import pybullet

from telex_control.common.geometry.matrices import rotation_matrix
from telex_control.common.geometry.quaternions import Quaternion, Vector3
from telex_control.common.params import ConfigError

FARTHEST = 500.0
"""How far a ray looks (m)."""
_SPACING = 0.05
_MOST = 15
"""Between looks at what is under something (m), and how many there are along each side at most."""
_EDGE = 0.002
"""What only touches the side of something does not stand on it (m)."""
_LEAST_REACH, _MOST_REACH = 0.05, 1.0
"""How far above the place the ground under something may rise (m)."""
_GAP = 0.001
"""Height from which it settles (m)."""


class Hit(NamedTuple):
    """What a ray meets: PyBullet's body, and where."""

    uid: int
    point: Vector3


def first_hit(client: int, origin: Vector3, direction: Vector3) -> Optional[Hit]:
    """Return what a ray meets first, or None.

    Raises
    ------
    ConfigError
        The numbers make no ray.
    """
    length = math.sqrt(sum(part * part for part in direction))
    if not all(map(math.isfinite, (*origin, length))) or length < 1e-9:
        raise ConfigError(
            f"origin is {list(origin)} and direction {list(direction)}; finite numbers are needed, "
            "and a direction that has a length"
        )
    end = [start + FARTHEST * part / length for start, part in zip(origin, direction)]
    ((uid, _, _, point, _),) = pybullet.rayTest(origin, end, physicsClientId=client)
    return None if uid < 0 else Hit(uid, tuple(point))


def standing_height(
    client: int,
    corners: np.ndarray,
    place: Vector3,
    orientation: Quaternion,
    own: Collection[int] = (),
) -> Tuple[float, Set[int]]:
    """Find the height at which something stands: the highest of what is under it carries it.

    Parameters
    ----------
    corners : numpy.ndarray
        Of its solid parts in its own frame (m), shape (N, 3).
    place : tuple of 3 floats
        In the world (m); what rises far above it is not looked at.
    orientation : Quaternion
        Of its own frame.
    own : collection of int
        Bodies (PyBullet's numbers) that are not there any more once it stands.

    Returns
    -------
    height : float
        Of its own frame's origin (m).
    bodies : set of int
        What is under it (PyBullet's numbers).

    Raises
    ------
    ConfigError
        There is nothing under it.
    """
    turn = rotation_matrix(orientation)
    points = (corners if len(corners) else np.zeros((1, 3))) @ turn.T
    # Along its own axes, as seen from above: a long thing that is turned is no square.
    ahead = math.atan2(turn[1, 0], turn[0, 0])
    axes = np.array([[math.cos(ahead), math.sin(ahead)], [-math.sin(ahead), math.cos(ahead)]])
    flat = points[:, :2] @ axes.T
    low, high = flat.min(axis=0), flat.max(axis=0)
    grid = np.array([(x, y) for x in _steps(low[0], high[0]) for y in _steps(low[1], high[1])])
    spots = grid @ axes + np.array(place[:2])
    reach = float(np.clip(0.5 * np.linalg.norm(high - low), _LEAST_REACH, _MOST_REACH))
    hits = _below(client, spots, place[2] + reach, own)
    if not hits:
        raise ConfigError("there is nothing for it to stand on")
    ground = max(hit.point[2] for hit in hits)
    return ground - float(points[:, 2].min()) + _GAP, {hit.uid for hit in hits}


def _steps(low: float, high: float) -> np.ndarray:
    margin = min(_EDGE, 0.5 * (high - low))
    count = min(_MOST, 2 + math.ceil((high - low) / _SPACING))
    return np.linspace(low + margin, high - margin, count)


def _below(client: int, spots: np.ndarray, height: float, own: Collection[int]) -> List[Hit]:
    """Return what vertical rays meet, through the bodies `own`."""
    found: List[Hit] = []
    starts = [(x, y, height) for x, y in spots.tolist()]
    while starts:
        ends = [(x, y, height - FARTHEST) for x, y, _ in starts]
        rays = pybullet.rayTestBatch(starts, ends, physicsClientId=client)
        starts = []
        for uid, _, _, (x, y, z), _ in rays:
            if uid in own:
                # From inside of it: a convex body is not met from there.
                starts.append((x, y, z - _EDGE))
            elif uid >= 0:
                found.append(Hit(uid, (x, y, z)))
    return found


def steady(pose: Sequence[Sequence[float]], farthest: float) -> Tuple[Vector3, Quaternion]:
    """Return a position and a quaternion that something can be put to, the latter of length 1.

    Parameters
    ----------
    farthest : float
        From the scene's middle, along each axis (m).

    Raises
    ------
    ConfigError
        A number is not finite or too large, or the quaternion is none.
    """
    position, orientation = pose
    if not all(math.isfinite(part) and abs(part) <= farthest for part in position):
        raise ConfigError(
            f"position is {list(position)}; finite numbers, of at most {farthest:g} m, are needed"
        )
    length = math.sqrt(sum(part * part for part in orientation))
    if not math.isfinite(length) or abs(length - 1.0) > 0.01:
        raise ConfigError(
            f"orientation is {list(orientation)}; a quaternion x y z w of length 1 is needed"
        )
    x, y, z = position
    a, b, c, d = (part / length for part in orientation)
    return (x, y, z), (a, b, c, d)
