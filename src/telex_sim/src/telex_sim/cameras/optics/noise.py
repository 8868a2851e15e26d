"""Noise of a camera's sensor: of its electronics, and of radiation."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Dict, Optional, Tuple

import cv2
import numpy as np

from telex_control.common.params import Declared, number

# Pixels by which noise is moved about from picture to picture, along each axis: enough places for
# nobody to see it come again.
_SHIFTS = 128

# Grey levels per step of strength; finer differences cannot be seen, and each step takes memory.
_STEP = 0.5

# Grey levels: what is weaker vanishes when it is rounded, what is stronger looks the same.
_WEAKEST, _STRONGEST = 0.25, 255.0

# Strengths whose noise is kept, the last ones: that of a large picture takes 100 MB.
_KEPT_TILES = 4

# Gy/h and Gy: more cannot be told from it.
_MOST = 1e5

# Longest trace that a particle leaves, in pixels.
_LONGEST_TRACE = 6

# Dots and traces that are drawn once; each picture shows a run of them, moved to another place.
_KEPT_DOTS = 4096

# Share of the light that is seen at least, and most of the veil (grey levels), whatever the dose.
_LEAST_LIGHT = 0.2
_THICKEST_VEIL = 160.0


@dataclass(frozen=True)
class RadiationConfig(Declared):
    """What ionising radiation does to a sensor.

    Raises
    ------
    telex_control.common.params.ConfigError
    """

    dose_rate: float = number(0.0, "That the camera is exposed to (Gy/h).", 0.0, _MOST)
    dose: float = number(0.0, "That it has been exposed to until now (Gy).", 0.0, _MOST)
    dots: float = number(
        30.0, "Bright dots and short traces in each picture, per million pixels and Gy/h.", 0.0, 1e4
    )
    hot_pixels: float = number(
        20.0, "Pixels that stay bright, per million pixels and Gy.", 0.0, 1e4
    )
    veil: float = number(
        0.25,
        "Dark current, which brightens the whole picture (grey levels of 255 per Gy).",
        0.0,
        100.0,
    )
    loss: float = number(
        0.002, "Share of the light that browned glass takes away, per Gy.", 0.0, 1.0
    )

    def exposed(self, dose_rate: float, dose: float) -> RadiationConfig:
        """Return it with a further dose rate (Gy/h) and dose (Gy), as far as that is possible."""
        if not dose_rate and not dose:
            return self
        return replace(
            self,
            dose_rate=min(self.dose_rate + dose_rate, _MOST),
            dose=min(self.dose + dose, _MOST),
        )


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
        self._hot = self._dots(self._generator(), 0)
        self._hot_count = 0
        self._traces: Optional[Tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]] = None

    def add(self, picture: np.ndarray, strength: float, stamp: int) -> None:
        """Add the noise of the electronics.

        Parameters
        ----------
        picture
            RGBA, shape (height, width, 4), uint8; changed in place.
        strength
            Standard deviation (grey levels of 255); steps of half a level are told apart, and what
            is above 255 is as 255.
        stamp
            Of the picture (ns).
        """
        if strength < _WEAKEST:
            return
        lighter, darker = self._tile(max(1, round(min(strength, _STRONGEST) / _STEP)))
        x, y = self._generator(stamp).integers(0, _SHIFTS, 2)
        part = (slice(y, y + self._height), slice(x, x + self._width))
        cv2.add(picture, lighter[part], dst=picture)
        cv2.subtract(picture, darker[part], dst=picture)

    def age(self, picture: np.ndarray, config: RadiationConfig) -> None:
        """Lay the veil of the dose over a picture, in place; the electronics' noise comes after."""
        veil = min(config.dose * config.veil, _THICKEST_VEIL)
        light = max(1.0 - config.dose * config.loss, _LEAST_LIGHT)
        if veil >= _WEAKEST or light < 1.0 - _WEAKEST / 255.0:
            cv2.convertScaleAbs(picture, dst=picture, alpha=light, beta=veil)

    def irradiate(self, picture: np.ndarray, config: RadiationConfig, stamp: int) -> None:
        """Add what radiation leaves in the picture; its arguments are as for `add`."""
        area = self._width * self._height * 1e-6
        hot = min(round(config.dose * config.hot_pixels * area), self._width * self._height)
        if hot != self._hot_count:
            # The first are always the same: with the dose, others are added.
            self._hot = self._dots(self._generator(), hot)
            self._hot_count = hot
        if hot:
            _brighten(picture, *self._hot)
        expected = config.dose_rate * config.dots * area
        if expected <= 0.0:
            return
        generator = self._generator(stamp, 1)
        count = min(int(generator.poisson(expected)), self._width * self._height // 4)
        traces = self._traces
        if traces is None:
            traces = self._traces = self._draw_traces()
        rows, columns, values, ends = traces
        while count > 0:
            first = int(generator.integers(0, _KEPT_DOTS))
            shown = min(count, _KEPT_DOTS - first)
            down, right = generator.integers(0, (self._height, self._width))
            run = slice(int(ends[first]), int(ends[first + shown]))
            _brighten(
                picture,
                (rows[run] + down) % self._height,
                (columns[run] + right) % self._width,
                values[run],
            )
            count -= shown

    def _draw_traces(self) -> Tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Pixels of the kept dots: rows, columns and values, and where each dot's pixels begin."""
        generator = self._generator(2)
        rows, columns, values = self._dots(generator, _KEPT_DOTS)
        angles = generator.uniform(0.0, 2.0 * math.pi, _KEPT_DOTS)
        # Most particles cross the sensor steeply and leave a dot, few a trace.
        lengths = np.minimum(generator.geometric(0.6, _KEPT_DOTS), _LONGEST_TRACE)
        ends = np.concatenate(([0], np.cumsum(lengths)))
        of = np.repeat(np.arange(_KEPT_DOTS), lengths)
        steps = np.arange(len(of)) - ends[of]
        down = np.rint(steps * np.sin(angles[of])).astype(np.intp)
        right = np.rint(steps * np.cos(angles[of])).astype(np.intp)
        return rows[of] + down, columns[of] + right, values[of], ends

    def _dots(
        self, generator: np.random.Generator, count: int
    ) -> Tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Rows, columns and values, shape (count, 4) the last: each has a colour of its own."""
        drawn = generator.random((count, 6))
        rows = (drawn[:, 0] * self._height).astype(np.intp)
        columns = (drawn[:, 1] * self._width).astype(np.intp)
        # A dot falls upon one of the sensor's coloured pixels, the others get their share of it.
        brightness = 90.0 + 165.0 * drawn[:, 2:3]
        values = np.zeros((count, 4), np.uint8)
        values[:, :3] = brightness * (0.55 + 0.45 * drawn[:, 3:])
        return rows, columns, values

    def _tile(self, step: int) -> Tuple[np.ndarray, np.ndarray]:
        """What is added and what is taken away, each larger than a picture by the shifts."""
        tile = self._tiles.pop(step, None)
        if tile is None:
            tile = self._draw_tile(step * _STEP)
            if len(self._tiles) >= _KEPT_TILES:
                del self._tiles[next(iter(self._tiles))]
        self._tiles[step] = tile  # the last one that was used comes last
        return tile

    def _draw_tile(self, strength: float) -> Tuple[np.ndarray, np.ndarray]:
        if self._normal is None:
            shape = (self._height + _SHIFTS, self._width + _SHIFTS, 4)
            self._normal = self._generator().standard_normal(shape, dtype=np.float32)
            self._normal[..., 3] = 0.0
        noise = np.rint(self._normal * strength)
        return (
            np.clip(noise, 0, 255).astype(np.uint8),
            np.clip(-noise, 0, 255).astype(np.uint8),
        )

    def _generator(self, *stamp: int) -> np.random.Generator:
        # A stamp before zero does not occur, but must not be an error here.
        return np.random.default_rng((self._seed, *(abs(number) for number in stamp)))


def _brighten(
    picture: np.ndarray, rows: np.ndarray, columns: np.ndarray, values: np.ndarray
) -> None:
    picture[rows, columns] = np.maximum(picture[rows, columns], values)
