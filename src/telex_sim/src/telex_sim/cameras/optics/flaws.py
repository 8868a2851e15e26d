"""Flaws of a camera that has been damaged: dirt, blur, darkness, noise."""

from __future__ import annotations

import math
from typing import NamedTuple, Optional, Tuple

import cv2
import numpy as np

# Patches of dirt along a picture's width and height.
_PATCHES = (40, 30)

# How sharply a patch ends: share of the spread of the field that it is drawn from.
_EDGE = 0.35

# Share of the light that the thickest dirt keeps away, and its grey (levels, RGB).
_THICKEST = 0.94
_SOIL = (64.0, 58.0, 50.0)

# Wider blur is made of a smaller picture: in pixels of it, standard deviation.
_SMALL_BLUR = 2.0


class Flaws(NamedTuple):
    """What is wrong with a camera.

    Attributes
    ----------
    frozen : bool
        It goes on sending its last picture.
    dark : float
        Share of the light that is lost.
    noisy : float
        Standard deviation of further noise (grey levels of 255).
    dirty : float
        Share of its window that dirt covers.
    blurred : float
        Standard deviation of the blur, as a share of the picture's width.
    """

    frozen: bool = False
    dark: float = 0.0
    noisy: float = 0.0
    dirty: float = 0.0
    blurred: float = 0.0


SOUND = Flaws()


class FlawedGlass:
    """Shows pictures of one size through a window and a lens with flaws.

    Parameters
    ----------
    width, height
        Of the pictures (pixels).
    seed
        Of the dirt: another camera is dirty elsewhere. It is the same in every size.
    """

    def __init__(self, width: int, height: int, seed: int) -> None:
        self._size = (width, height)
        self._seed = seed
        # Share of the window, and what light it lets through and adds, as pictures.
        self._dirt: Optional[Tuple[float, np.ndarray, np.ndarray]] = None

    def show(self, picture: np.ndarray, flaws: Flaws) -> None:
        """Change a picture in place: RGBA, shape (height, width, 4), uint8."""
        if flaws.dirty:
            clear, soil = self._dirt_of(flaws.dirty)
            cv2.multiply(picture, clear, dst=picture, scale=1.0 / 255.0)
            cv2.add(picture, soil, dst=picture)
        if flaws.blurred:
            _blur(picture, flaws.blurred * self._size[0])
        if flaws.dark:
            # Pictures show about the square root of light.
            cv2.convertScaleAbs(picture, dst=picture, alpha=math.sqrt(max(0.0, 1.0 - flaws.dark)))

    def _dirt_of(self, share: float) -> Tuple[np.ndarray, np.ndarray]:
        if self._dirt is None or self._dirt[0] != share:
            drawn = np.random.default_rng((self._seed, 3)).standard_normal(
                (_PATCHES[1], _PATCHES[0]), dtype=np.float32
            )
            patches = np.asarray(cv2.GaussianBlur(drawn, (0, 0), 1.2), np.float32)
            edge, spread = float(np.quantile(patches, 1.0 - share)), float(patches.std())
            field = np.asarray(
                cv2.resize(patches, self._size, interpolation=cv2.INTER_CUBIC), np.float32
            )
            thickness = np.clip((field - edge) / (_EDGE * spread) + 0.5, 0.0, 1.0)
            thickness = (_THICKEST * thickness)[..., np.newaxis]
            clear = np.repeat(255.0 * (1.0 - thickness), 4, axis=2)
            soil = thickness * np.array((*_SOIL, 255.0), np.float32)
            self._dirt = (share, np.rint(clear).astype(np.uint8), np.rint(soil).astype(np.uint8))
        return self._dirt[1:]


def _blur(picture: np.ndarray, deviation: float) -> None:
    """Blur a picture in place, by so many pixels of it."""
    height, width = picture.shape[:2]
    factor = max(1.0, deviation / _SMALL_BLUR)
    small = picture
    if factor > 1.0:
        size = (max(1, round(width / factor)), max(1, round(height / factor)))
        small = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
    small = cv2.GaussianBlur(small, (0, 0), max(0.1, deviation / factor))
    picture[...] = cv2.resize(small, (width, height), interpolation=cv2.INTER_LINEAR)
