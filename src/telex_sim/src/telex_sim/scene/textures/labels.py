"""Signs and labels, drawn by code; no trademarks, and symbols that anybody may use."""

from __future__ import annotations

import math
from typing import Callable, Dict, List, Tuple

import cv2
import numpy as np

Tone = Tuple[int, int, int]
Symbol = Callable[[np.ndarray, Tuple[float, float], float, Tone], None]

# Everything is drawn larger and reduced, which smooths the outlines.
_OVERSAMPLING = 3
_SHORT_SIDE = 384

USUAL = "usual"

BLACK: Tone = (20, 20, 20)
WHITE: Tone = (242, 242, 238)
YELLOW: Tone = (250, 196, 12)
RED: Tone = (190, 24, 30)
BLUE: Tone = (18, 84, 160)

_FONT = cv2.FONT_HERSHEY_SIMPLEX


def sign(text: str, shape: str, symbol: str) -> np.ndarray:
    """Make a square plate with a sign of ``shape`` and, below or on it, a text.

    triangle warns, circle forbids, square informs; the symbol "usual" is an exclamation mark on the
    first and none on the others.
    """
    if symbol == USUAL:
        symbol = "exclamation" if shape == "triangle" else "none"
    size = _SHORT_SIDE * _OVERSAMPLING
    plate = np.full((size, size, 3), WHITE, dtype=np.uint8)
    share = 0.76 if text and shape != "square" else 1.0
    if shape == "triangle":
        _triangle(plate, share, symbol)
    elif shape == "circle":
        _circle(plate, share, symbol)
    else:
        margin = round(0.05 * size)
        cv2.rectangle(plate, (margin, margin), (size - margin, size - margin), BLUE, -1)
        if not text:
            SYMBOLS[symbol](plate, (0.5 * size, 0.5 * size), 0.34 * size, WHITE)
        elif symbol == "none":
            write_text(plate, text, (0.10, 0.10, 0.90, 0.90), WHITE)
        else:
            SYMBOLS[symbol](plate, (0.5 * size, 0.34 * size), 0.22 * size, WHITE)
            write_text(plate, text, (0.10, 0.60, 0.90, 0.90), WHITE)
    if text and shape != "square":
        write_text(plate, text, (0.06, share, 0.94, 0.96), BLACK)
    return _reduced(plate)


def label(text: str, aspect: float, color: str) -> np.ndarray:
    """Make a plate with a text and a thin frame; ``aspect`` is its width over its height."""
    ground, ink = LABEL_COLORS[color]
    short = _SHORT_SIDE * _OVERSAMPLING // 2
    width, height = round(short * max(aspect, 1.0)), round(short * max(1.0 / aspect, 1.0))
    plate = np.full((height, width, 3), ground, dtype=np.uint8)
    inset, line = round(0.05 * short), max(2, round(0.022 * short))
    cv2.rectangle(plate, (inset, inset), (width - 1 - inset, height - 1 - inset), ink, line)
    border = 0.14 * short
    box = (border / width, border / height, 1.0 - border / width, 1.0 - border / height)
    write_text(plate, text, box, ink)
    return _reduced(plate)


LABEL_COLORS: Dict[str, Tuple[Tone, Tone]] = {
    "white": (WHITE, BLACK),
    "yellow": (YELLOW, BLACK),
    "blue": (BLUE, WHITE),
    "red": (RED, WHITE),
    "black": ((28, 28, 30), WHITE),
}


def write_text(
    picture: np.ndarray, text: str, box: Tuple[float, float, float, float], ink: Tone
) -> None:
    """Write as large as a box allows, broken into the lines that allow the most.

    Parameters
    ----------
    picture
        RGB, changed in place.
    text
        Printable ASCII.
    box
        Left, top, right, bottom, as shares of the picture.
    """
    height, width = picture.shape[:2]
    left, top, right, bottom = (
        value * extent for value, extent in zip(box, (width, height, width, height))
    )
    scale, lines = max(
        (_fitting_scale(lines, right - left, bottom - top), lines) for lines in _breaks(text)
    )
    thickness = max(1, round(_STROKE * scale))
    pitch = _LINE_PITCH * scale
    # The height of capitals, which the middle of a line of text is judged by.
    capital = _CAPITAL * scale
    first = 0.5 * (top + bottom) - 0.5 * pitch * (len(lines) - 1) + 0.5 * capital
    for number, line in enumerate(lines):
        extent = cv2.getTextSize(line, _FONT, scale, thickness)[0][0]
        at = (round(0.5 * (left + right) - 0.5 * extent), round(first + number * pitch))
        cv2.putText(picture, line, at, _FONT, scale, ink, thickness, cv2.LINE_AA)


# Of OpenCV's font at scale 1 (pixels).
_CAPITAL = 21.0
_LINE_PITCH = 33.0
_STROKE = 3.4


def _fitting_scale(lines: List[str], width: float, height: float) -> float:
    widest = max(cv2.getTextSize(line, _FONT, 1.0, 1)[0][0] for line in lines) + _STROKE
    return min(width / widest, height / (_LINE_PITCH * (len(lines) - 1) + _CAPITAL + _STROKE))


def _breaks(text: str) -> List[List[str]]:
    """Break a text at blanks into one line, two, three, and so on, each of even length."""
    words = text.split() or [""]
    ways = []
    for count in range(1, len(words) + 1):
        target = len(text) / count
        lines = [words[0]]
        for word in words[1:]:
            if len(lines) < count and len(lines[-1]) + 0.5 * len(word) >= target:
                lines.append(word)
            else:
                lines[-1] += f" {word}"
        if lines not in ways:
            ways.append(lines)
    return ways


def _triangle(plate: np.ndarray, share: float, symbol: str) -> None:
    size = plate.shape[0]
    height = share * size * 0.86
    half = height / math.sqrt(3.0)
    top = 0.5 * (share * size - height) + 0.01 * size
    middle = (0.5 * size, top + height * 2.0 / 3.0)
    outline = [
        (0.5 * size, top),
        (0.5 * size + half, top + height),
        (0.5 * size - half, top + height),
    ]
    for factor, color in ((1.0, BLACK), (0.80, YELLOW)):
        corners = [
            (middle[0] + factor * (x - middle[0]), middle[1] + factor * (y - middle[1]))
            for x, y in outline
        ]
        _rounded_polygon(plate, corners, 0.045 * size * factor, color)
    SYMBOLS[symbol](plate, (middle[0], middle[1] + 0.01 * height), 0.24 * height, BLACK)


def _circle(plate: np.ndarray, share: float, symbol: str) -> None:
    size = plate.shape[0]
    center, radius = (0.5 * size, 0.5 * share * size + 0.01 * size), 0.45 * share * size
    _disc(plate, center, radius, RED)
    _disc(plate, center, 0.78 * radius, WHITE)
    SYMBOLS[symbol](plate, center, 0.55 * radius, BLACK)
    along = 0.8 * radius * math.sqrt(0.5)
    start = (round(center[0] - along), round(center[1] - along))
    end = (round(center[0] + along), round(center[1] + along))
    cv2.line(plate, start, end, RED, round(0.20 * radius), cv2.LINE_AA)


def _exclamation(plate: np.ndarray, center: Tuple[float, float], size: float, ink: Tone) -> None:
    x, y = center
    wide, narrow = 0.21 * size, 0.12 * size
    top, waist, dot = y - size, y + 0.30 * size, y + 0.74 * size
    _disc(plate, (x, top + wide), wide, ink)
    _disc(plate, (x, waist - narrow), narrow, ink)
    _polygon(
        plate,
        [
            (x - wide, top + wide),
            (x + wide, top + wide),
            (x + narrow, waist - narrow),
            (x - narrow, waist - narrow),
        ],
        ink,
    )
    _disc(plate, (x, dot), 0.22 * size, ink)


def _radiation(plate: np.ndarray, center: Tuple[float, float], size: float, ink: Tone) -> None:
    # Trefoil of ISO 361: radii 1 : 1.5 : 5.
    unit = size / 5.0
    for turn in (30.0, 150.0, 270.0):
        arc = [math.radians(turn + step) for step in range(-30, 31, 3)]
        for_arc = [(center[0] + size * math.cos(a), center[1] + size * math.sin(a)) for a in arc]
        inner = [
            (center[0] + 1.5 * unit * math.cos(a), center[1] + 1.5 * unit * math.sin(a))
            for a in reversed(arc)
        ]
        _polygon(plate, for_arc + inner, ink)
    _disc(plate, center, unit, ink)


def _voltage(plate: np.ndarray, center: Tuple[float, float], size: float, ink: Tone) -> None:
    bolt = [(0.10, -1.0), (-0.38, 0.18), (-0.04, 0.12), (-0.20, 0.72), (-0.34, 0.66), (-0.16, 1.02)]
    bolt += [(0.16, 0.76), (0.0, 0.74), (0.36, -0.18), (0.04, -0.12), (0.34, -1.0)]
    _polygon(plate, [(center[0] + size * x, center[1] + size * y) for x, y in bolt], ink)


def _none(plate: np.ndarray, center: Tuple[float, float], size: float, ink: Tone) -> None:
    """Leave the sign empty."""


SYMBOLS: Dict[str, Symbol] = {
    "none": _none,
    "exclamation": _exclamation,
    "radiation": _radiation,
    "voltage": _voltage,
}


def _disc(plate: np.ndarray, center: Tuple[float, float], radius: float, color: Tone) -> None:
    at = (round(16 * center[0]), round(16 * center[1]))
    cv2.circle(plate, at, round(16 * radius), color, -1, cv2.LINE_AA, shift=4)


def _polygon(plate: np.ndarray, corners: List[Tuple[float, float]], color: Tone) -> None:
    points = np.round(16 * np.array(corners)).astype(np.int32)
    cv2.fillPoly(plate, [points], color, cv2.LINE_AA, shift=4)


def _rounded_polygon(
    plate: np.ndarray, corners: List[Tuple[float, float]], radius: float, color: Tone
) -> None:
    """Fill a convex polygon whose corners are rounded."""
    middle = np.mean(corners, axis=0)
    inner = []
    for corner in np.array(corners):
        away = corner - middle
        # In an equilateral triangle the centre of the rounding lies two radii from the corner.
        inner.append(corner - 2.0 * radius * away / np.linalg.norm(away))
    _polygon(plate, [(x, y) for x, y in inner], color)
    points = np.round(16 * np.array(inner)).astype(np.int32)
    cv2.polylines(plate, [points], True, color, round(2.0 * radius), cv2.LINE_AA, shift=4)
    for x, y in inner:
        _disc(plate, (x, y), radius, color)


def _reduced(plate: np.ndarray) -> np.ndarray:
    size = (plate.shape[1] // _OVERSAMPLING, plate.shape[0] // _OVERSAMPLING)
    return cv2.resize(plate, size, interpolation=cv2.INTER_AREA)
