"""Floors that work has left its traces on; they repeat without a seam."""

from __future__ import annotations

import math
from typing import Callable

import cv2
import numpy as np

from .noise_patterns import (
    blurred,
    relief,
    soft_step,
    specks,
    spectral_noise,
    tinted,
    to_pixels,
    wrapped_offsets,
)
from .surfaces import by_field, joint_distance
from .surfaces import concrete as clean_concrete

# Twice as fine as walls are: the cameras look at it from a hand's breadth.
_SIZE = 2048


def concrete(seed: int, slabs: int, worn: int) -> np.ndarray:
    """Floor of ``slabs`` x ``slabs`` slabs (0: without joints), clean or worn (0 or 1)."""
    return _worn_concrete(seed, slabs) if worn else clean_concrete(seed, slabs)


def _worn_concrete(seed: int, slabs: int) -> np.ndarray:
    """Show cracks, marks of tyres, oil and scratches."""
    rng = np.random.default_rng(seed)
    size = _SIZE
    coarse = spectral_noise(size // 2, 2.6, rng)
    tiled: np.ndarray = np.asarray(cv2.resize(np.tile(coarse, (2, 2)), (2 * size, 2 * size)))
    clouds = tiled[:size, :size].astype(np.float32)
    grain = spectral_noise(size, 0.7, rng)
    tone = 0.88 + 0.026 * clouds + 0.026 * grain
    # Sand and pebbles where the surface is rubbed off.
    rubbed = soft_step(np.roll(clouds, size // 3, axis=1), 0.1, 1.6)
    pebbles = blurred(specks(size, 9000, (0.5, 1.8), rng), 0.5, 0.5)
    tone += (0.10 * relief(blurred(pebbles, 0.7, 0.7)) - 0.03 * pebbles) * (0.35 + 0.65 * rubbed)
    tone -= 0.22 * blurred(specks(size, 1200, (0.6, 2.6), rng), 0.6, 0.6)
    if slabs:
        tone += by_field(rng.normal(0.0, 0.016, (slabs, slabs)), size)
        line = joint_distance(size, size / slabs)
        near = np.minimum(line[:, None], line[None, :])
        dirt = 1.0 - soft_step(near, 2.0, 30.0)
        tone *= 1.0 - 0.5 * (1.0 - soft_step(near, 1.2, 3.6))
        tone *= 1.0 - 0.05 * dirt * (1.0 + 0.6 * clouds)
    tone *= 1.0 - 0.45 * blurred(_cracks(size, 4, rng), 0.7, 0.7)
    tone += 0.05 * blurred(_lines(size, 60, rng, 0.01, 0.05, 1), 0.6, 0.6)
    tyres = blurred(_lines(size, 5, rng, 0.25, 0.6, size // 85), 2.0, 2.0)
    # The rubber comes off in patches.
    tone *= 1.0 - 0.16 * tyres * soft_step(grain + 1.5 * clouds, -1.6, 1.2)
    oil = blurred(specks(size, 14, (6.0, 34.0), rng), 3.0, 3.0)
    oil = soft_step(oil + 0.10 * clouds, 0.25, 0.75)
    tone *= 1.0 - 0.30 * oil
    warm = np.clip(clouds, 0.0, 2.0) * 0.25
    return to_pixels(tinted(tone, (warm, (1.0, 0.985, 0.95)), (oil, (1.0, 0.97, 0.90))))


def _lines(
    size: int,
    count: int,
    rng: np.random.Generator,
    shortest: float,
    longest: float,
    width: int,
) -> np.ndarray:
    """Gently bent lines at random, 0 to 1; lengths are shares of the side."""

    def line() -> np.ndarray:
        steps = 24
        length = size * rng.uniform(shortest, longest)
        heading = rng.uniform(0.0, 2.0 * math.pi) + np.linspace(0.0, rng.normal(0.0, 0.5), steps)
        return np.cumsum(np.stack([np.cos(heading), np.sin(heading)], axis=1), axis=0) * (
            length / steps
        )

    return _drawn(size, count, rng, line, width)


def _cracks(size: int, count: int, rng: np.random.Generator) -> np.ndarray:
    """Thin jagged lines that wander, 0 to 1."""

    def crack() -> np.ndarray:
        steps = int(rng.integers(30, 90))
        heading = rng.uniform(0.0, 2.0 * math.pi) + np.cumsum(rng.normal(0.0, 0.35, steps))
        way = np.stack([np.cos(heading), np.sin(heading)], axis=1)
        return np.cumsum(way * rng.uniform(3.0, 12.0, (steps, 1)), axis=0)

    return _drawn(size, count, rng, crack, 1)


def _drawn(
    size: int,
    count: int,
    rng: np.random.Generator,
    path: Callable[[], np.ndarray],
    width: int,
) -> np.ndarray:
    """Draw paths from random places on, 0 to 1, across the seams as well."""
    canvas = np.zeros((size, size), dtype=np.uint8)
    for _ in range(count):
        way = path() + rng.uniform(0.0, size, 2)
        low, high = way.min(axis=0) - width, way.max(axis=0) + width
        middle, reach = 0.5 * (low + high) % size, 0.5 * (high - low)
        way += middle - 0.5 * (low + high)
        for dx in wrapped_offsets(float(middle[0]), float(reach[0]), size):
            for dy in wrapped_offsets(float(middle[1]), float(reach[1]), size):
                points = np.round(16.0 * (way + np.array([dx, dy]))).astype(np.int32)
                cv2.polylines(canvas, [points], False, (255,), width, cv2.LINE_AA, shift=4)
    return canvas.astype(np.float32) / 255.0
