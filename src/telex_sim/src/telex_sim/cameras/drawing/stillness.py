"""Motion that is too small to be drawn anew."""

from __future__ import annotations

import numpy as np

STILL = 1e-4
"""Motion that changes neither a shadow nor a picture that anybody could see (m, or rad at 1 m)."""


def is_still(now: np.ndarray, before: np.ndarray) -> bool:
    """Whether poses or points, of any shape, are so near to others that nobody could see it."""
    return now.shape == before.shape and float(np.abs(now - before).max(initial=0.0)) < STILL
