"""Vignetting: a lens lets less light through to the corners of its picture."""

from __future__ import annotations

import math

import cv2
import numpy as np


class Vignette:
    """Darkens the pictures of one size towards their corners.

    Light falls with the fourth power of the cosine of an angle off the middle, as behind an ideal
    lens (the "cosine fourth" law of irradiance, e.g. B. K. P. Horn, "Robot Vision", 1986, section
    10.3); how wide the angle is in the corners follows from what they lack.

    Parameters
    ----------
    width, height
        Of the pictures (pixels).
    loss
        Share of the light that the corners lack, from 0 to below 1.
    """

    def __init__(self, width: int, height: int, loss: float) -> None:
        # Of the angle in the corners: (1 + square)^-2 is its cosine's fourth power.
        square = 1.0 / math.sqrt(1.0 - loss) - 1.0
        columns, rows = (
            np.square(np.linspace(-1.0, 1.0, count, dtype=np.float32)) for count in (width, height)
        )
        share = (columns * width**2 + rows[:, np.newaxis] * height**2) / (width**2 + height**2)
        # Pictures show about the square root of light.
        shown = np.full((height, width, 4), 255, np.uint8)
        shown[..., :3] = np.rint(255.0 / (1.0 + square * share))[..., np.newaxis]
        self._shown = shown

    def darken(self, picture: np.ndarray) -> None:
        """Change a picture in place: RGBA, shape (height, width, 4), uint8."""
        cv2.multiply(picture, self._shown, dst=picture, scale=1.0 / 255.0)
