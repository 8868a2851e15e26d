"""Noise of a camera's sensor: of its electronics, and of radiation."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Dict, Optional, Tuple

import cv2
import numpy as np

from telex_control.common.params import require_range

# Pixels by which noise is moved about from picture to picture, along each axis: enough places for
# nobody to see it come again.
_SHIFTS = 128

# Grey levels per step of strength; finer differences cannot be seen, and each step takes memory.
_STEP = 0.5

# Grey levels; what is weaker vanishes when it is rounded.
_WEAKEST = 0.25

# Longest trace that a particle leaves, in pixels.
_LONGEST_TRACE = 6


@dataclass(frozen=True)
class RadiationConfig:
    """What ionising radiation does to a sensor.

    Attributes
    ----------
    dose_rate
        That the camera is exposed to (Gy/h).
    dose
        That it has been exposed to until now (Gy).
    dots
        Bright dots and short traces in each picture, per million pixels and Gy/h.
    hot_pixels
        Pixels that stay bright, per million pixels and Gy.

    Raises
    ------
    telex_control.common.params.ConfigError
    """

    dose_rate: float = 0.0
    dose: float = 0.0
    dots: float = 30.0
    hot_pixels: float = 20.0

    def __post_init__(self) -> None:
        require_range(self, "dose_rate", 0.0, 1e5)
        require_range(self, "dose", 0.0, 1e5)
        require_range(self, "dots", 0.0, 1e4)
        require_range(self, "hot_pixels", 0.0, 1e4)


class SensorNoise:
    """Adds noise to the pictures of one size, the same for the same seed and stamp.

    Noise is drawn once and moved about: drawing it for each picture would take a fifth of the time
    that the picture takes.

    Parameters
    ----------
    width, height
        Of the pictures (pixels).
    seed
        Different for cameras that shall not be alike.
    """

    def __init__(self, width: int, height: int, seed: int) -> None:
        self._width, self._height = width, height
        self._seed = seed
        self._normal: Optional[np.ndarray] = None
        self._tiles: Dict[int, Tuple[np.ndarray, np.ndarray]] = {}
        self._hot: Tuple[np.ndarray, np.ndarray, np.ndarray] = self._dots(self._generator(), 0)
        self._hot_count = 0

    def add(self, picture: np.ndarray, strength: float, stamp: int) -> None:
        """Add the noise of the electronics.

        Parameters
        ----------
        picture
            RGBA, shape (height, width, 4), uint8; changed in place.
        strength
            Standard deviation (grey levels of 255); steps of half a level are told apart.
        stamp
            Of the picture (ns).
        """
        if strength < _WEAKEST:
            return
        lighter, darker = self._tile(max(1, round(strength / _STEP)))
        x, y = self._generator(stamp).integers(0, _SHIFTS, 2)
        part = (slice(y, y + self._height), slice(x, x + self._width))
        cv2.add(picture, lighter[part], dst=picture)
        cv2.subtract(picture, darker[part], dst=picture)

    def irradiate(self, picture: np.ndarray, config: RadiationConfig, stamp: int) -> None:
        """Add what radiation leaves in the picture; its arguments are as for `add`."""
        area = self._width * self._height * 1e-6
        hot = round(config.dose * config.hot_pixels * area)
        if hot != self._hot_count:
            # The first are always the same: with the dose, others are added.
            self._hot = self._dots(self._generator(), hot)
            self._hot_count = hot
        if hot:
            rows, columns, values = self._hot
            _brighten(picture, rows, columns, values)
        expected = config.dose_rate * config.dots * area
        if expected <= 0.0:
            return
        generator = self._generator(stamp, 1)
        count = min(int(generator.poisson(expected)), self._width * self._height // 4)
        rows, columns, values = self._dots(generator, count)
        angles = generator.uniform(0.0, 2.0 * math.pi, count)
        # Most particles cross the sensor steeply and leave a dot, few a trace.
        lengths = np.minimum(generator.geometric(0.6, count), _LONGEST_TRACE)
        for step in range(int(lengths.max(initial=0))):
            reach = lengths > step
            down = rows[reach] + np.rint(step * np.sin(angles[reach])).astype(np.intp)
            right = columns[reach] + np.rint(step * np.cos(angles[reach])).astype(np.intp)
            inside = (down >= 0) & (down < self._height) & (right >= 0) & (right < self._width)
            _brighten(picture, down[inside], right[inside], values[reach][inside])

    def _dots(
        self, generator: np.random.Generator, count: int
    ) -> Tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Rows, columns and values, shape (count, 3) the last: each has a colour of its own."""
        drawn = generator.random((count, 6))
        rows = (drawn[:, 0] * self._height).astype(np.intp)
        columns = (drawn[:, 1] * self._width).astype(np.intp)
        # A dot falls upon one of the sensor's coloured pixels, the others get their share of it.
        brightness = 90.0 + 165.0 * drawn[:, 2:3]
        return rows, columns, (brightness * (0.55 + 0.45 * drawn[:, 3:])).astype(np.uint8)

    def _tile(self, step: int) -> Tuple[np.ndarray, np.ndarray]:
        """What is added and what is taken away, each larger than a picture by the shifts."""
        if step not in self._tiles:
            if self._normal is None:
                shape = (self._height + _SHIFTS, self._width + _SHIFTS, 4)
                self._normal = self._generator().standard_normal(shape, dtype=np.float32)
                self._normal[..., 3] = 0.0
            noise = np.rint(self._normal * (step * _STEP))
            self._tiles[step] = (
                np.clip(noise, 0, 255).astype(np.uint8),
                np.clip(-noise, 0, 255).astype(np.uint8),
            )
        return self._tiles[step]

    def _generator(self, *stamp: int) -> np.random.Generator:
        # A stamp before zero does not occur, but must not be an error here.
        return np.random.default_rng((self._seed, *(abs(number) for number in stamp)))


def _brighten(
    picture: np.ndarray, rows: np.ndarray, columns: np.ndarray, values: np.ndarray
) -> None:
    picture[rows, columns, :3] = np.maximum(picture[rows, columns, :3], values)
