"""Pictures of materials, drawn by code; they repeat without a seam.

Except for checker and hazard stripes they are nearly white and without a hue of their own: the
visual's colour, which is multiplied by them, makes pine or walnut of the same wood.
"""

from __future__ import annotations

from typing import Tuple

import cv2
import numpy as np

from .noise_patterns import (
    blurred,
    cells,
    relief,
    soft_step,
    specks,
    spectral_noise,
    tinted,
    to_pixels,
    wrapped_offsets,
)

_SIZE = 1024
_SMALL = 512


def concrete(seed: int, slabs: int) -> np.ndarray:
    """Floor of ``slabs`` x ``slabs`` slabs with stains, pores and joints; 0: without joints."""
    rng = np.random.default_rng(seed)
    clouds = spectral_noise(_SIZE, 2.6, rng)
    grain = spectral_noise(_SIZE, 0.9, rng)
    tone = 0.88 + 0.030 * clouds + 0.016 * grain
    tone -= 0.07 * soft_step(spectral_noise(_SIZE, 3.2, rng), 0.7, 2.4)
    tone -= 0.22 * blurred(specks(_SIZE, 700, (0.6, 2.4), rng), 0.6, 0.6)
    if slabs:
        tone += by_field(rng.normal(0.0, 0.016, (slabs, slabs)), _SIZE)
        line = joint_distance(_SIZE, _SIZE / slabs)
        joint = 1.0 - soft_step(np.minimum(line[:, None], line[None, :]), 1.0, 3.5)
        dirt = 1.0 - soft_step(np.minimum(line[:, None], line[None, :]), 2.0, 26.0)
        tone *= (1.0 - 0.5 * joint) * (1.0 - 0.05 * dirt * (1.0 + 0.6 * clouds))
    return to_pixels(tinted(tone, (np.clip(clouds, 0.0, 2.0) * 0.25, (1.0, 0.985, 0.95))))


def asphalt(seed: int) -> np.ndarray:
    """Fine stones in bitumen, with worn lighter patches."""
    rng = np.random.default_rng(seed)
    number, distance = cells(_SIZE, 22000, rng)
    tones = np.clip(rng.normal(0.78, 0.13, int(number.max()) + 1), 0.4, 1.0).astype(np.float32)
    stone = 1.0 - soft_step(distance, 0.25, 0.62)
    patches = spectral_noise(_SIZE, 2.8, rng)
    tone = 0.60 + (tones[number] - 0.60) * stone + 0.035 * patches
    tone *= 1.0 + 0.5 * relief(blurred(stone, 0.8, 0.8))
    return to_pixels(tone)


def gravel(seed: int) -> np.ndarray:
    """Loose stones of several sizes."""
    rng = np.random.default_rng(seed)
    number, distance = cells(_SIZE, 1500, rng)
    fine_number, fine_distance = cells(_SIZE, 9000, rng)
    coarse = 1.0 - soft_step(distance, 0.30, 0.52)
    tones = np.clip(rng.normal(0.82, 0.10, int(number.max()) + 1), 0.5, 1.0).astype(np.float32)
    fine_tones = np.clip(rng.normal(0.62, 0.10, int(fine_number.max()) + 1), 0.3, 0.9)
    fine = fine_tones.astype(np.float32)[fine_number] * (1.0 - 0.5 * fine_distance)
    grain = spectral_noise(_SIZE, 1.2, rng)
    tone = fine + (tones[number] - fine) * coarse + 0.03 * grain
    height = coarse * (1.0 - 0.8 * distance) + 0.25 * (1.0 - fine_distance) * (1.0 - coarse)
    tone *= np.clip(1.0 + 6.0 * relief(blurred(height, 1.2, 1.2)), 0.45, 1.35)
    warm = rng.random(int(number.max()) + 1).astype(np.float32)[number] * coarse
    return to_pixels(tinted(tone, (warm, (1.0, 0.95, 0.88))))


def brick(seed: int, rows: int, columns: int) -> np.ndarray:
    """Wall in stretcher bond: ``columns`` bricks across, ``rows`` (even) upwards, gray mortar."""
    rng = np.random.default_rng(seed)
    place = np.arange(_SIZE, dtype=np.float32) + 0.5
    wobble = spectral_noise(_SIZE, 2.4, rng) * np.float32(0.9)
    height, width = _SIZE / rows, _SIZE / columns
    row = (np.arange(_SIZE) * rows // _SIZE)[:, None]
    along = place / width + 0.5 * (row % 2).astype(np.float32)
    column = along.astype(np.int32) % columns
    joint = 5.0
    # Distance to the brick's outline, above 0 inside.
    to_side = (0.5 - np.abs(along % 1.0 - 0.5)) * width
    to_bed = joint_distance(_SIZE, height)[:, None]
    inside = np.minimum(to_side, to_bed) - joint + wobble
    body = soft_step(inside, -1.5, 1.5)
    tones = np.clip(rng.normal(0.86, 0.065, (rows, columns)), 0.62, 1.0).astype(np.float32)
    burnt = rng.random((rows, columns)).astype(np.float32)
    grain = spectral_noise(_SIZE, 1.1, rng)
    clouds = spectral_noise(_SIZE, 2.4, rng)
    tone = tones[row, column] + 0.035 * clouds
    tone = 0.66 + (tone - 0.66) * body + 0.025 * grain
    tone *= np.clip(1.0 + 0.45 * relief(blurred(body, 1.3, 1.3)) + 0.02 * grain, 0.5, 1.5)
    # Mortar takes back some of the brick's red, so that it comes out nearly gray on it.
    hue = soft_step(burnt[row, column], 0.6, 1.0) * body
    return to_pixels(tinted(tone, (1.0 - body, (0.95, 1.12, 1.22)), (hue, (0.86, 0.80, 0.82))))


def plaster(seed: int) -> np.ndarray:
    """Rough white wall with faint stains."""
    rng = np.random.default_rng(seed)
    bumps = blurred(spectral_noise(_SIZE, 0.6, rng), 1.6, 1.6)
    bumps /= bumps.std()
    tone = 0.925 + 0.012 * spectral_noise(_SIZE, 2.8, rng) + 0.022 * relief(bumps)
    tone -= 0.025 * soft_step(spectral_noise(_SIZE, 3.0, rng), 1.0, 2.5)
    return to_pixels(tone)


def wood(seed: int) -> np.ndarray:
    """Sawn board without seams, the grain along x, with a few knots."""
    rng = np.random.default_rng(seed)
    return to_pixels(_wood_grain(_SIZE, rng, knots=5, rings=17))


def planks(seed: int, count: int) -> np.ndarray:
    """Boards along x, ``count`` of them upwards, with gaps between."""
    return to_pixels(_plank_wall(_SIZE, np.random.default_rng(seed), count))


def crate(seed: int) -> np.ndarray:
    """One side of a wooden crate: boards behind a frame with a diagonal, and nails."""
    rng = np.random.default_rng(seed)
    size, bar = _SMALL, _SMALL // 8
    picture = _plank_wall(size, rng, 6)
    across = _wood_grain(size, rng, knots=3, rings=40)
    upright = across.transpose(1, 0, 2)
    near, far = bar // 2, size - bar // 2
    for ends, grain in (
        (((near, far), (far, near)), across),
        (((near, 0), (near, size)), upright),
        (((far, 0), (far, size)), upright),
        (((bar, near), (size - bar, near)), across),
        (((bar, far), (size - bar, far)), across),
    ):
        mask = _bar_mask(size, ends, bar)
        # A bar lies on what is behind it: it throws a narrow shadow and has a lit edge.
        shadow: np.ndarray = cv2.GaussianBlur(np.roll(mask, (4, 3), axis=(0, 1)), (0, 0), 2.5)
        picture *= (1.0 - 0.45 * shadow * (1.0 - mask))[..., None]
        lit = 0.93 + 0.28 * relief(cv2.GaussianBlur(mask, (0, 0), 0.8))
        picture += (grain * lit[..., None] - picture) * mask[..., None]
    nails = np.zeros((size, size), dtype=np.uint8)
    for u in (bar // 3, bar - bar // 3):
        for v in (bar // 3, bar - bar // 3):
            for x in (u, size - u):
                for y in (v, size - v):
                    cv2.circle(nails, (x, y), 3, (255,), -1, cv2.LINE_AA)
    picture *= (1.0 - 0.6 * _share(nails))[..., None]
    return to_pixels(picture)


def cardboard(seed: int) -> np.ndarray:
    """Corrugated board: fine fibres, faint flutes along y, a few scuffs."""
    rng = np.random.default_rng(seed)
    size = _SIZE
    fibres = spectral_noise(size, 1.2, rng, stretch=(4.0, 1.0))
    flutes = np.sin(np.arange(size, dtype=np.float32) * (2.0 * np.pi * 96 / size))[None, :]
    tone = 0.90 + 0.012 * fibres + 0.010 * flutes + 0.018 * spectral_noise(size, 2.6, rng)
    scuffs = soft_step(spectral_noise(size, 2.2, rng, stretch=(1.0, 3.0)), 1.9, 3.2)
    return to_pixels(tone + 0.05 * scuffs)


def tread_plate(seed: int, bars: int) -> np.ndarray:
    """Chequer plate: ``bars`` (even) raised bars across, turned in turn."""
    rng = np.random.default_rng(seed)
    size, pitch = _SIZE, _SIZE / bars
    canvas = np.zeros((size, size), dtype=np.uint8)
    axes = (round(0.46 * pitch), round(0.105 * pitch))
    for i in range(bars):
        for j in range(bars):
            x, y = round((i + 0.5) * pitch), round((j + 0.5) * pitch)
            angle = 45 if (i + j) % 2 else -45
            for dx in wrapped_offsets(x, axes[0], size):
                for dy in wrapped_offsets(y, axes[0], size):
                    center = (x + dx, y + dy)
                    cv2.ellipse(canvas, center, axes, angle, 0, 360, (255,), -1, cv2.LINE_AA)
    height = _share(canvas)
    rounded = blurred(height, 2.2, 2.2)
    tone = 0.80 + 0.020 * spectral_noise(size, 2.4, rng) + 0.020 * spectral_noise(size, 0.8, rng)
    tone = tone + 0.07 * rounded
    tone *= np.clip(1.0 + 1.7 * relief(rounded), 0.5, 1.3)
    # Dirt gathers at the feet of the bars.
    tone *= 1.0 - 0.16 * np.clip(blurred(height, 7.0, 7.0) * 1.6 - rounded, 0.0, 1.0)
    return to_pixels(tone)


def brushed_metal(seed: int) -> np.ndarray:
    """Fine strokes along x."""
    rng = np.random.default_rng(seed)
    strokes = spectral_noise(_SMALL, 0.9, rng, stretch=(60.0, 1.0))
    return to_pixels(0.90 + 0.022 * strokes + 0.010 * spectral_noise(_SMALL, 2.6, rng))


def painted_metal(seed: int) -> np.ndarray:
    """Paint with orange peel, some grime, and scratches down to the metal."""
    rng = np.random.default_rng(seed)
    size = _SIZE
    peel = blurred(spectral_noise(size, 0.4, rng), 2.5, 2.5)
    tone = 0.93 + 0.014 * spectral_noise(size, 2.8, rng) + 0.010 * relief(peel / peel.std())
    grime = soft_step(spectral_noise(size, 2.6, rng, stretch=(1.0, 2.5)), 0.9, 2.8)
    tone -= 0.10 * grime
    scratches = _scratches(size, 26, rng)
    tone = tone * (1.0 - 0.25 * scratches)
    return to_pixels(tone)


def rubber(seed: int) -> np.ndarray:
    """Dull and slightly rough, with dust."""
    rng = np.random.default_rng(seed)
    grain = blurred(spectral_noise(_SMALL, 0.3, rng), 0.8, 0.8)
    tone = 0.86 + 0.045 * relief(grain / grain.std()) + 0.030 * spectral_noise(_SMALL, 2.4, rng)
    return to_pixels(tone + 0.06 * soft_step(spectral_noise(_SMALL, 1.8, rng), 1.2, 3.0))


def tiles(seed: int, count: int) -> np.ndarray:
    """Glazed tiles with grout, ``count`` across."""
    rng = np.random.default_rng(seed)
    size = _SIZE
    line = joint_distance(size, size / count)
    distance = np.minimum(line[:, None], line[None, :])
    body = soft_step(distance, 2.5, 5.0)
    tone = 0.70 + (by_field(rng.normal(0.94, 0.012, (count, count)), size) - 0.70) * body
    tone *= 1.0 + 0.5 * relief(blurred(body, 1.5, 1.5))
    grout = 1.0 - body
    tone += (0.006 + 0.030 * grout) * spectral_noise(size, 1.8, rng)
    return to_pixels(tinted(tone, (grout, (1.0, 0.97, 0.93))))


def tunnel_wall(seed: int) -> np.ndarray:
    """Cast concrete: marks of the formwork's boards along x, tie holes, streaks running down."""
    rng = np.random.default_rng(seed)
    size, boards = _SIZE, 8
    pitch = size // boards
    clouds = spectral_noise(size, 2.4, rng)
    grain = spectral_noise(size, 1.1, rng, stretch=(5.0, 1.0))
    tone = 0.86 + 0.022 * clouds + 0.016 * grain
    steps = rng.normal(0.0, 0.020, boards).astype(np.float32).repeat(pitch)[:, None]
    line = joint_distance(size, pitch)[:, None]
    tone = (tone + steps) * (1.0 - 0.16 * (1.0 - soft_step(line, 0.5, 2.5)))
    ring = np.minimum(np.arange(size), size - np.arange(size)).astype(np.float32)[None, :]
    tone *= 1.0 - 0.40 * (1.0 - soft_step(ring, 1.0, 4.0))
    streaks = spectral_noise(size, 2.2, rng, stretch=(1.0, 9.0))
    tone -= 0.085 * soft_step(streaks, 0.8, 2.6)
    holes = np.zeros((size, size), dtype=np.uint8)
    for x in (size // 4, 3 * size // 4):
        for y in (size // 4 + pitch // 2, 3 * size // 4 + pitch // 2):
            cv2.circle(holes, (x, y), 9, (255,), -1, cv2.LINE_AA)
    hollow = _share(holes)
    tone *= (1.0 - 0.55 * hollow) * (1.0 - 0.25 * relief(blurred(hollow, 1.5, 1.5)))
    damp = soft_step(streaks, 1.2, 3.0)
    return to_pixels(tinted(tone, (damp, (1.0, 0.97, 0.90))))


def checker(seed: int) -> np.ndarray:
    """Two tones: one repetition holds two by two tiles, each with a grid of quarters."""
    rng = np.random.default_rng(seed)
    half = _SIZE // 2
    row, column = np.indices((_SIZE, _SIZE))
    tone = np.where((row // half + column // half) % 2, 0.87, 0.775).astype(np.float32)
    tone -= 0.055 * _on_line(row, column, half // 4, 2)
    tone = np.where(_on_line(row, column, half, 5), np.float32(0.47), tone)
    return to_pixels(tone + 0.006 * spectral_noise(_SIZE, 2.2, rng))


def hazard_stripes(seed: int) -> np.ndarray:
    """Yellow and black at 45 degrees, worn."""
    rng = np.random.default_rng(seed)
    size = _SMALL
    y, x = np.mgrid[0:size, 0:size].astype(np.float32)
    phase = np.abs(((x + y) % size) / size - 0.5) * size
    yellow = soft_step(phase, 0.25 * size - 1.0, 0.25 * size + 1.0)[..., None]
    picture = np.array([0.09, 0.09, 0.10]) * (1.0 - yellow) + np.array([0.96, 0.74, 0.08]) * yellow
    dirt = spectral_noise(size, 1.9, rng)
    picture = picture * (1.0 - 0.35 * soft_step(dirt, 1.1, 2.2) * yellow[..., 0])[..., None]
    return to_pixels(picture + (0.05 * soft_step(-dirt, 1.3, 2.4))[..., None])


def _plank_wall(size: int, rng: np.random.Generator, count: int) -> np.ndarray:
    """Boards along x, one above the other; RGB 0..1."""
    grain = _wood_grain(size, rng, knots=6, rings=17)
    board = np.arange(size) * count // size
    # Each board is cut from another place of the same wood.
    across, along = rng.integers(size, size=(2, count))
    column = (np.arange(size)[None, :] + along[board][:, None]) % size
    picture = grain[((np.arange(size) + across[board]) % size)[:, None], column]
    edge = joint_distance(size, size / count) * (1024.0 / size)
    gap = (0.35 + 0.65 * soft_step(edge, 0.5, 3.0)) * (0.93 + 0.07 * np.clip(edge, 0.0, 9.0) / 9.0)
    shade = rng.normal(1.0, 0.05, count).astype(np.float32)[board]
    return picture * (gap * shade).astype(np.float32)[:, None, None]


def _wood_grain(size: int, rng: np.random.Generator, knots: int, rings: int) -> np.ndarray:
    """Yearly rings cut lengthwise, along x; nearly white, RGB 0..1."""
    y = np.arange(size, dtype=np.float32)[:, None] / size
    bend = spectral_noise(size, 3.4, rng, stretch=(7.0, 1.0)) * 0.030
    phase = np.broadcast_to(y, (size, size)) + bend
    knot_body = np.zeros((size, size), dtype=np.float32)
    x_grid = np.arange(size, dtype=np.float32)
    for _ in range(knots):
        center_x, center_y = rng.uniform(0, size, 2)
        radius = rng.uniform(0.008, 0.017) * size
        # The grain flows round a knot; distances wrap, so that it does so across the seam as well.
        dx = (x_grid - center_x + 0.5 * size) % size - 0.5 * size
        dy = (x_grid - center_y + 0.5 * size) % size - 0.5 * size
        away = np.exp(-((dx / (4.5 * radius)) ** 2))[None, :]
        phase = phase + (
            0.9
            * radius
            / size
            * away
            * np.sign(dy)[:, None]
            * np.exp(-np.abs(dy / (3.0 * radius)))[:, None]
        )
        distance = np.hypot((dx / 1.25)[None, :], dy[:, None]) / radius
        knot_body = np.maximum(knot_body, 1.0 - soft_step(distance, 0.75, 1.1))
    # A saw-tooth with a soft back: pale early wood that ends in a dark late ring. A whole number of
    # rings keeps the seam.
    widths = 0.35 * np.sin(2.0 * np.pi * phase * 3.0) + 0.25 * np.sin(
        2.0 * np.pi * phase * 7.0 + 1.0
    )
    turn = phase * rings + widths
    turn = turn - np.floor(turn)
    ring = turn**2.2 * (1.0 - soft_step(turn, 0.90, 1.0))
    fibres = spectral_noise(size, 0.9, rng, stretch=(40.0, 1.0))
    patches = spectral_noise(size, 2.6, rng, stretch=(5.0, 1.0))
    tone = 0.95 - 0.17 * ring + 0.022 * fibres + 0.020 * patches
    tone *= 1.0 - 0.45 * knot_body
    return tinted(tone, (ring, (1.0, 0.94, 0.86)), (knot_body, (1.0, 0.88, 0.78)))


def _bar_mask(size: int, ends: Tuple, width: int) -> np.ndarray:
    """1 inside a bar of ``width`` from the first of two ends to the second."""
    (x0, y0), (x1, y1) = ends
    direction = np.array([x1 - x0, y1 - y0]) / np.hypot(x1 - x0, y1 - y0)
    side = 0.5 * width * np.array([-direction[1], direction[0]])
    start, end = np.array((x0, y0)), np.array((x1, y1))
    corners = np.array([start - side, end - side, end + side, start + side])
    mask = np.zeros((size, size), dtype=np.uint8)
    cv2.fillConvexPoly(mask, np.round(corners * 16).astype(np.int32), (255,), cv2.LINE_AA, shift=4)
    return _share(mask)


def _scratches(size: int, count: int, rng: np.random.Generator) -> np.ndarray:
    """Thin straight lines at random, 0..1."""
    canvas = np.zeros((size, size), dtype=np.uint8)
    for _ in range(count):
        x, y = rng.uniform(0, size, 2)
        angle, length = rng.uniform(-0.5, 0.5), size * rng.uniform(0.02, 0.14)
        dx, dy = length * np.cos(angle), length * np.sin(angle)
        tone = int(rng.integers(60, 255))
        for ox in wrapped_offsets(x + 0.5 * dx, length, size):
            for oy in wrapped_offsets(y + 0.5 * dy, length, size):
                start = (round(x + ox), round(y + oy))
                end = (round(x + ox + dx), round(y + oy + dy))
                cv2.line(canvas, start, end, (tone,), 1, cv2.LINE_AA)
    return _share(canvas)


def _share(canvas: np.ndarray) -> np.ndarray:
    """0..255 as 0..1; OpenCV draws smooth outlines on bytes alone."""
    return canvas.astype(np.float32) / 255.0


def by_field(tones: np.ndarray, size: int) -> np.ndarray:
    """Spread one value per field over the pixels of a square picture."""
    field = np.arange(size) * len(tones) // size
    return tones.astype(np.float32)[field[:, None], field[None, :]]


def joint_distance(size: int, pitch: float) -> np.ndarray:
    """Distance of each pixel from the nearest multiple of the pitch (pixels)."""
    place = (np.arange(size, dtype=np.float32) + 0.5) % pitch
    return np.minimum(place, pitch - place)


def _on_line(row: np.ndarray, column: np.ndarray, spacing: int, width: int) -> np.ndarray:
    return ((row + width // 2) % spacing < width) | ((column + width // 2) % spacing < width)
