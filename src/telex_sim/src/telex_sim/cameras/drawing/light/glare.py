"""Glare: lamps that shine into a lens brighten the picture around them."""

from __future__ import annotations

from typing import List

import numpy as np

from .lamps import LampRig
from .spots import spot

# Radius in the picture, as a share of its width, and light in the middle by that which arrives.
_RADIUS, _SHARE = 0.05, 0.6

# Less is not seen.
_WEAKEST = 0.004

# By what it lies nearer to the camera than the lamp, which sits in its housing (m).
_LIFT = 0.12


def glare(
    rig: LampRig,
    clip_from_world: np.ndarray,
    optical_in_world: np.ndarray,
    exposure: float,
) -> List[np.ndarray]:
    """Find the glare of all lamps in a picture, as `Spots` draws it.

    Parameters
    ----------
    rig
        The lamps, where they are now.
    clip_from_world
        Of the view, shape (4, 4).
    optical_in_world
        Pose of the camera's optical frame, shape (4, 4).
    exposure
        Factor on all light.
    """
    if not rig.levels.any():
        return []
    right, down, eye = (optical_in_world[:3, column] for column in (0, 1, 3))
    light = exposure * _SHARE * rig.arriving(eye)
    spots = []
    for lamp in np.flatnonzero(light.max(axis=1, initial=0.0) > _WEAKEST).tolist():
        to_eye = eye - rig.positions[lamp]
        distance = float(np.linalg.norm(to_eye))
        if distance < 2.0 * _LIFT:
            continue
        middle = rig.positions[lamp] + to_eye * (_LIFT / distance)
        x, y, _, ahead = clip_from_world @ [*middle, 1.0]
        if ahead <= 0.0 or max(abs(x), abs(y)) > (1.0 + 2.0 * _RADIUS) * ahead:
            continue
        # Of the picture's width, which spans -1 to 1.
        radius = 2.0 * _RADIUS * ahead / float(np.linalg.norm(clip_from_world[0, :3]))
        spots.append(spot(middle, radius * right, radius * down, light[lamp]))
    return spots
