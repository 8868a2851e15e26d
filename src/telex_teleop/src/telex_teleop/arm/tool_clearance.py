"""Bounds on the tool's twist near obstacles: it slides along them."""

from __future__ import annotations

import numpy as np

# Damping (m^2, rad^2) of the inverse Jacobian: near a singularity joints do not follow the tool.
DAMPING = 1e-4
# Most passes over the bounds, each of which restores what the others have undone; where they are
# not enough (in a sharp corner) the tool stops.
SWEEPS = 16
# A bound is kept when it is missed by no more (m/s).
KEPT = 1e-4
# A direction in which the tool changes a distance by less (m/m) cannot be avoided by moving it.
PARALLEL = 1e-3


def tool_effects(gradients: np.ndarray, jacobian: np.ndarray) -> np.ndarray:
    """Return how the tool's twist changes distances that joints change.

    Parameters
    ----------
    gradients : ndarray, shape (m, n)
        Of the distances by the joints (m/rad, m/m).
    jacobian : ndarray, shape (6, n)
        Of the tool.

    Returns
    -------
    ndarray, shape (m, 6)
        When the joints follow the tool with as little motion as possible.
    """
    both = jacobian @ np.concatenate([jacobian, gradients]).T
    both[:, :6] += DAMPING * np.eye(6)
    # Gauss and Jordan, without a search for pivots, for the matrix is positive definite. LAPACK
    # takes milliseconds for so little, when its threads have to wait for a processor.
    for row in range(6):
        pivot = both[row] / both[row, row]
        both -= both[:, row : row + 1] * pivot
        both[row] = pivot
    return both[:, 6:].T


def scaled_clear(twist: np.ndarray, effects: np.ndarray, allowed: np.ndarray) -> np.ndarray:
    """Return a twist in its own direction that closes no distance faster than allowed.

    Parameters
    ----------
    twist : ndarray, shape (k,)
    effects : ndarray, shape (m, k)
        What a unit of it adds to each distance.
    allowed : ndarray, shape (m,)
        Speeds (m/s), 0 or more.
    """
    closing = -(effects @ twist)
    over = closing > allowed + KEPT
    return twist * float(np.min(allowed[over] / closing[over])) if over.any() else twist


def slid_clear(twist: np.ndarray, effects: np.ndarray, allowed: np.ndarray) -> np.ndarray:
    """Return the twist without what closes a distance faster than allowed.

    A rotation is slowed, for about another axis it would be another one. A translation loses the
    part that closes (alternating projections on half-spaces; each holds standing still, so that it
    never becomes faster), and is slowed where that is not enough.

    Parameters
    ----------
    twist : ndarray, shape (6,)
        Linear and angular velocity (m/s, rad/s).
    effects : ndarray, shape (m, 6)
        What a unit of it adds to each distance.
    allowed : ndarray, shape (m,)
        Speeds (m/s), 0 or more.
    """
    by_moving, by_turning = effects[:, :3], effects[:, 3:]
    turn = scaled_clear(twist[3:], by_turning, allowed)
    room = allowed + np.minimum(0.0, by_turning @ turn)
    room = np.maximum(room, 0.0)
    move = twist[:3].copy()
    steepness = np.einsum("ij,ij->i", by_moving, by_moving)
    for _ in range(SWEEPS):
        excess = np.where(steepness > PARALLEL**2, -(by_moving @ move) - room, 0.0)
        worst = int(np.argmax(excess))
        if excess[worst] <= 0.5 * KEPT:
            break
        move += by_moving[worst] * (excess[worst] / steepness[worst])
    return np.concatenate([scaled_clear(move, by_moving, room), turn])
