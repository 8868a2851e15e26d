"""Coarser meshes, for shadows."""

from __future__ import annotations

from typing import Tuple

import numpy as np


def simplified(
    positions: np.ndarray, triangles: np.ndarray, detail: float
) -> Tuple[np.ndarray, np.ndarray]:
    """Merge what lies in the same cell of a grid.

    This is vertex clustering (J. Rossignac, P. Borrel, "Multi-resolution 3D approximations for
    rendering complex scenes", 1993).

    Parameters
    ----------
    positions
        Shape (V, 3) (m).
    triangles
        Shape (T, 3).
    detail
        Edge of the cells (m): nothing moves further than its diagonal. 0 merges only what is in
        the same place.

    Returns
    -------
    tuple of two numpy.ndarray
        Positions, shape (W, 3), float32, and triangles, shape (U, 3), int32; those that have
        collapsed or come twice are gone. What would vanish altogether stays as it is.
    """
    # Without a grid, the bits of the numbers tell points apart.
    cells = np.floor(positions / detail).astype(np.int32) if detail else positions
    _, first, cluster = np.unique(cells, axis=0, return_index=True, return_inverse=True)
    cluster = cluster.reshape(-1)
    count = np.bincount(cluster)
    if detail:
        merged = np.stack(
            [np.bincount(cluster, positions[:, axis]) / count for axis in range(3)], axis=1
        )
    else:
        merged = positions[first]
    kept = cluster[triangles]
    a, b, c = kept.T
    kept = kept[(a != b) & (b != c) & (c != a)]
    # The same corner first, so that equal triangles are equal rows; the winding stays.
    turn = kept.argmin(axis=1)[:, None]
    kept = np.take_along_axis(kept, (np.arange(3) + turn) % 3, axis=1)
    kept = np.unique(kept, axis=0)
    if not len(kept):
        # All of it is smaller than a cell.
        return positions.astype(np.float32), triangles.astype(np.int32)
    return merged.astype(np.float32), kept.astype(np.int32)
