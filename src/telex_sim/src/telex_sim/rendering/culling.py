"""Which visuals a view can see at all, by their bounding spheres."""

from __future__ import annotations

import numpy as np


def spheres_in_world(model: np.ndarray, centers: np.ndarray) -> np.ndarray:
    """Centres of bounding spheres in the world, shape (N, 3); the model matrices are rigid."""
    return np.einsum("nij,nj->ni", model[:, :3, :3], centers) + model[:, :3, 3]


def spheres_in_view(
    clip_from_world: np.ndarray, centers: np.ndarray, radii: np.ndarray
) -> np.ndarray:
    """Which spheres touch the view's volume; a few beyond its corners may be kept as well.

    The planes are the rows' sums and differences of the clip matrix (G. Gribb, K. Hartmann,
    "Fast extraction of viewing frustum planes from the world-view-projection matrix", 2001).

    Parameters
    ----------
    clip_from_world
        Shape (4, 4), perspective or parallel.
    centers, radii
        In the world (m), shapes (N, 3) and (N,).

    Returns
    -------
    numpy.ndarray
        Shape (N,), bool.
    """
    w = clip_from_world[3]
    planes = np.concatenate([w + clip_from_world[:3], w - clip_from_world[:3]])
    planes /= np.linalg.norm(planes[:, :3], axis=1, keepdims=True)
    distances = centers @ planes[:, :3].T + planes[:, 3]
    return (distances > -radii[:, None]).all(axis=1)
