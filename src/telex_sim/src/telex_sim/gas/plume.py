"""Gas around leaks, in closed form.

A leak of the volume flow Q into air that drifts with the velocity u and mixes by the eddy
diffusivity D gives, once it has lasted for long, the share of volume
Q / (4 pi D r) exp(-(|u| r - u d) / 2D) at the way d, of length r, from it: the steady solution of
advection and diffusion for a point source in open air. Walls, the floor and the robot hold back
nothing, the gas is as heavy as air, and the drift is the same everywhere; gusts are left out.
"""

from __future__ import annotations

import numpy as np

DIFFUSIVITY = 0.02
"""m2/s, of the eddies of a ventilated hall."""
NEAREST = 0.02
"""m; nearer to its middle no leak is a point, and there is no more gas."""


def shares(ways: np.ndarray, flows: np.ndarray, drifts: np.ndarray) -> np.ndarray:
    """Share of volume of the gas of each leak at a place.

    Parameters
    ----------
    ways : numpy.ndarray
        From the leaks to the place, shape (L, 3) (m).
    flows : numpy.ndarray
        Of the leaks, shape (L,) (m3/s).
    drifts : numpy.ndarray
        Velocities of the air around them, shape (L, 3) (m/s).

    Returns
    -------
    numpy.ndarray
        Shape (L,), 0 to 1.
    """
    way = np.maximum(np.linalg.norm(ways, axis=1), NEAREST)
    behind = np.linalg.norm(drifts, axis=1) * way - np.einsum("li,li->l", drifts, ways)
    spread = flows / (4.0 * np.pi * DIFFUSIVITY * way)
    found: np.ndarray = np.minimum(
        spread * np.exp(-np.maximum(behind, 0.0) / (2.0 * DIFFUSIVITY)), 1.0
    )
    return found
