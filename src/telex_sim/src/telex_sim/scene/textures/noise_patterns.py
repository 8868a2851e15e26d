"""Parts of procedural textures: seamless noise, relief, cells.

All arrays are square, float32, and repeat without a seam.
"""

from __future__ import annotations

from typing import Tuple

import cv2
import numpy as np


def spectral_noise(
    size: int, falloff: float, rng: np.random.Generator, stretch: Tuple[float, float] = (1.0, 1.0)
) -> np.ndarray:
    """Noise whose power falls with frequency f as 1/f^falloff.

    Made in the frequency domain, where everything is periodic.

    Parameters
    ----------
    size
        Pixels along a side, even.
    falloff
        0 is white, 1 fine grain, 3 clouds.
    rng
        Where the randomness comes from.
    stretch
        How much longer features are along x and along y.

    Returns
    -------
    numpy.ndarray
        Shape (size, size), mean 0, standard deviation 1.
    """
    frequency = np.hypot(
        np.fft.fftfreq(size)[:, None] * stretch[1], np.fft.rfftfreq(size)[None, :] * stretch[0]
    ).astype(np.float32)
    frequency[0, 0] = 1.0
    shape = frequency.shape
    spectrum = np.empty(shape, dtype=np.complex64)
    spectrum.real = rng.standard_normal(shape, dtype=np.float32)
    spectrum.imag = rng.standard_normal(shape, dtype=np.float32)
    spectrum *= frequency ** (-0.5 * falloff)
    spectrum[0, 0] = 0.0
    noise = np.fft.irfft2(spectrum, (size, size)).astype(np.float32)
    return noise / noise.std()


def blurred(field: np.ndarray, sigma_x: float, sigma_y: float) -> np.ndarray:
    """Blur across the seam; the standard deviations are in pixels."""
    margin = min(int(np.ceil(4.0 * max(sigma_x, sigma_y))) + 1, len(field))
    padded = np.pad(field, margin, mode="wrap")
    soft = cv2.GaussianBlur(padded, (0, 0), sigmaX=max(sigma_x, 1e-3), sigmaY=max(sigma_y, 1e-3))
    return soft[margin:-margin, margin:-margin]


def relief(height: np.ndarray) -> np.ndarray:
    """Slope towards a light at the upper left: above 0 where the surface faces it."""
    return (height - np.roll(height, (1, 1), axis=(0, 1))) * 0.7071


def specks(
    size: int, count: int, radius: Tuple[float, float], rng: np.random.Generator
) -> np.ndarray:
    """Round soft spots at random places, 0 to 1.

    Parameters
    ----------
    size
        Pixels along a side.
    count
        Of the spots.
    radius
        Smallest and largest (pixels); small ones are more frequent.
    rng
        Where the randomness comes from.
    """
    margin = int(np.ceil(radius[1])) + 2
    canvas = np.zeros((size + 2 * margin, size + 2 * margin), dtype=np.uint8)
    places = rng.integers(0, size, (count, 2))
    radii = radius[0] + (radius[1] - radius[0]) * rng.random(count) ** 3
    scale = 8
    for (x, y), r in zip(places, radii):
        for dx in wrapped_offsets(x, r, size):
            for dy in wrapped_offsets(y, r, size):
                center = (scale * (x + dx + margin), scale * (y + dy + margin))
                cv2.circle(
                    canvas, center, max(1, round(scale * r)), (255,), -1, cv2.LINE_AA, shift=3
                )
    return canvas[margin:-margin, margin:-margin].astype(np.float32) / 255.0


def wrapped_offsets(at: float, reach: float, size: int) -> Tuple[int, ...]:
    """Shifts by which something has to be drawn again so that it continues across the seam."""
    offsets = [0]
    if at < reach + 1.0:
        offsets.append(size)
    if at > size - reach - 1.0:
        offsets.append(-size)
    return tuple(offsets)


def cells(size: int, count: int, rng: np.random.Generator) -> Tuple[np.ndarray, np.ndarray]:
    """Voronoi cells of points that keep some distance of one another.

    Returns
    -------
    tuple of two numpy.ndarray
        Number of the cell of each pixel, int, and the distance to the cell's point as a share of
        the mean distance of points; shape (size, size).
    """
    across = max(1, round(np.sqrt(count)))
    pitch = size / across
    grid = np.stack(np.meshgrid(np.arange(across), np.arange(across)), axis=-1).reshape(-1, 2)
    points = ((grid + 0.5 + rng.uniform(-0.42, 0.42, grid.shape)) * pitch).astype(int) % size
    margin = int(np.ceil(3.0 * pitch))
    seeds = np.zeros((size, size), dtype=bool)
    seeds[points[:, 1], points[:, 0]] = True
    number_at = np.zeros((size, size), dtype=np.int32)
    number_at[points[:, 1], points[:, 0]] = np.arange(len(points))
    padded = np.pad(seeds, margin, mode="wrap")
    distance, label = cv2.distanceTransformWithLabels(
        np.where(padded, 0, 255).astype(np.uint8),
        cv2.DIST_L2,
        cv2.DIST_MASK_5,
        labelType=cv2.DIST_LABEL_PIXEL,
    )
    share: np.ndarray = np.asarray(distance, dtype=np.float32) / np.float32(pitch)
    # OpenCV numbers the points in an order of its own.
    number_of = np.zeros(int(label.max()) + 1, dtype=np.int32)
    number_of[label[padded]] = np.pad(number_at, margin, mode="wrap")[padded]
    inner = slice(margin, margin + size)
    return number_of[label[inner, inner]], share[inner, inner]


def soft_step(field: np.ndarray, low: float, high: float) -> np.ndarray:
    """0 below ``low``, 1 above ``high``, smooth in between."""
    share = np.clip((field - low) / (high - low), 0.0, 1.0)
    return share * share * (3.0 - 2.0 * share)


def to_pixels(tone: np.ndarray) -> np.ndarray:
    """Convert 0..1, gray (N, N) or RGB (N, N, 3), to RGB, shape (N, N, 3), uint8."""
    pixels = np.clip(tone * 255.0 + 0.5, 0.0, 255.0).astype(np.uint8)
    return pixels if pixels.ndim == 3 else cv2.cvtColor(pixels, cv2.COLOR_GRAY2RGB)


def tinted(tone: np.ndarray, *hues: Tuple[np.ndarray, Tuple[float, float, float]]) -> np.ndarray:
    """Give a gray picture hues where masks say so.

    Parameters
    ----------
    tone
        Shape (N, N), 0..1.
    hues
        Pairs of a mask, shape (N, N), 0..1, and the factors for red, green and blue where it is 1.
    """
    colored = np.repeat(tone[..., None], 3, axis=2)
    for mask, factors in hues:
        colored *= 1.0 + mask[..., None] * (np.array(factors, dtype=np.float32) - 1.0)
    return colored
