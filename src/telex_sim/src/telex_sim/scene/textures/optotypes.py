"""Characters for tests of sight: the tumbling E and the Landolt ring, after EN ISO 8596.

Both stand on a grid of 5 x 5 strokes; what has to be seen is the gap of one stroke.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Dict, List, Tuple

import cv2
import numpy as np

from ..sealed import seed_of

INK = (18, 18, 18)
PAPER = (244, 244, 240)

DIRECTIONS: Dict[str, Tuple[int, ...]] = {
    "E": (0, 90, 180, 270),
    "C": (0, 45, 90, 135, 180, 225, 270, 315),
}
"""Possible angles of each kind: where it opens, in degrees anticlockwise from the right."""

PER_ROW = 5
ROW_STEP = 10.0**0.1
"""How much larger each row is than the next, as on charts for doctors."""

_OVERSAMPLING = 4
_SINGLE = 512
_CHART = 1536
_MARGIN = 0.05


@dataclass(frozen=True)
class ChartRow:
    """A row of a chart.

    Attributes
    ----------
    middle
        Of the row, as a share of the sheet's height, from above.
    size
        Of its characters, as a share of the sheet's height; the gap is a fifth of it.
    angles
        Where each character opens, from left to right (degrees, as in `DIRECTIONS`).
    """

    middle: float
    size: float
    angles: Tuple[int, ...]


def chart_rows(kind: str, seed: int, rows: int) -> List[ChartRow]:
    """Layout and answers of a chart, from above; the same that `chart` draws."""
    rng = np.random.default_rng(seed)
    # Between rows stays at least the height of the lower one.
    sizes = ROW_STEP ** -np.arange(rows, dtype=np.float64)
    total = sizes.sum() + sizes[1:].sum()
    room = 1.0 - 2.0 * _MARGIN
    sizes *= min(room / total, room / (2 * PER_ROW - 1))
    spare = room - sizes.sum() - sizes[1:].sum()
    gap = spare / max(rows - 1, 1)
    top = _MARGIN if rows > 1 else 0.5 * (1.0 - sizes[0])
    found = []
    for number, size in enumerate(sizes):
        if number:
            top += size + gap
        angles = rng.choice(DIRECTIONS[kind], PER_ROW)
        found.append(ChartRow(top + 0.5 * size, float(size), tuple(int(a) for a in angles)))
        top += size
    return found


def sealed_angle(kind: str, token: str, index: int) -> int:
    """Angle that a sealed token stands for: one of `DIRECTIONS`.

    Raises
    ------
    ConfigError
        See `seed_of`.
    """
    angles = DIRECTIONS[kind]
    return angles[seed_of(token, str(index)) % len(angles)]


def chart(kind: str, seed: int, rows: int, sealed: str = "") -> np.ndarray:
    """Draw a square sheet with rows of five characters, each row smaller than the one above.

    A token, where there is one, stands in place of the seed.

    Returns
    -------
    numpy.ndarray
        RGB, shape (N, N, 3), uint8.
    """
    fine = _CHART * _OVERSAMPLING
    ink = np.zeros((fine, fine), dtype=np.uint8)
    layout = chart_rows(kind, seed_of(sealed) if sealed else seed, rows)
    pitch = 2.0 * layout[0].size
    for row in layout:
        for place, angle in enumerate(row.angles):
            x = 0.5 + (place - 0.5 * (PER_ROW - 1)) * pitch
            _draw(ink, kind, angle, (x * fine, row.middle * fine), row.size * fine)
    return _printed(ink)


def optotype(kind: str, angle: int, sealed: str = "", of: int = 0) -> np.ndarray:
    """Draw one character with a margin of one stroke around it.

    A token, where there is one, and a number stand in place of the angle.
    """
    if sealed:
        angle = sealed_angle(kind, sealed, of)
    fine = _SINGLE * _OVERSAMPLING
    ink = np.zeros((fine, fine), dtype=np.uint8)
    _draw(ink, kind, angle, (0.5 * fine, 0.5 * fine), 5.0 / 7.0 * fine)
    return _printed(ink)


def _draw(ink: np.ndarray, kind: str, angle: int, center: Tuple[float, float], size: float) -> None:
    """Draw one character; ``center`` and ``size`` are in pixels."""
    stroke = size / 5.0
    turn = np.radians(angle)
    right = np.array([np.cos(turn), -np.sin(turn)])
    down = np.array([np.sin(turn), np.cos(turn)])

    def fill(left: float, top: float, width: float, height: float, share: int) -> None:
        """Fill a rectangle, in strokes from the character's middle."""
        corners = [(left, top), (left + width, top), (left + width, top + height)]
        corners.append((left, top + height))
        points = [center + stroke * (x * right + y * down) for x, y in corners]
        cv2.fillConvexPoly(ink, np.round(16 * np.array(points)).astype(np.int32), (share,), shift=4)

    if kind == "E":
        fill(-2.5, -2.5, 1.0, 5.0, 255)
        for top in (-2.5, -0.5, 1.5):
            fill(-2.5, top, 5.0, 1.0, 255)
        return
    at = (round(16 * center[0]), round(16 * center[1]))
    cv2.circle(ink, at, round(16 * 2.5 * stroke), (255,), -1, shift=4)
    cv2.circle(ink, at, round(16 * 1.5 * stroke), (0,), -1, shift=4)
    fill(0.0, -0.5, 2.6, 1.0, 0)


def _printed(ink: np.ndarray) -> np.ndarray:
    size = (ink.shape[1] // _OVERSAMPLING, ink.shape[0] // _OVERSAMPLING)
    share = (
        cv2.resize(ink, size, interpolation=cv2.INTER_AREA).astype(np.float32)[..., None] / 255.0
    )
    tones = np.array(PAPER, np.float32) * (1.0 - share) + np.array(INK, np.float32) * share
    return np.round(tones).astype(np.uint8)
