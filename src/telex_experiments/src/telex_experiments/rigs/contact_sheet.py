"""Pictures side by side on one sheet, each with a caption."""

from __future__ import annotations

from typing import Sequence

import cv2
import numpy as np

_GAP, _CAPTION = 6, 26  # pixels
_PAPER, _INK = (255, 255, 255), (40, 40, 40)


def captioned(picture: np.ndarray, text: str) -> np.ndarray:
    """Return a picture (height, width, 3; blue, green, red) with a line of text below it."""
    height, width = picture.shape[:2]
    cell = np.full((height + _CAPTION, width, 3), _PAPER, dtype=np.uint8)
    cell[:height] = picture
    at, font = (4, height + _CAPTION - 8), cv2.FONT_HERSHEY_SIMPLEX
    cv2.putText(cell, text, at, font, 0.55, _INK, 1, cv2.LINE_AA)
    return cell


def sheet(cells: Sequence[np.ndarray], columns: int) -> np.ndarray:
    """Return pictures of one size in rows of so many columns.

    Raises
    ------
    ValueError
        There are none.
    """
    if not cells:
        raise ValueError("a sheet needs pictures")
    rows = -(-len(cells) // columns)
    height, width = cells[0].shape[:2]
    size = (rows * (height + _GAP) + _GAP, columns * (width + _GAP) + _GAP, 3)
    paper = np.full(size, _PAPER, dtype=np.uint8)
    for number, cell in enumerate(cells):
        row, column = divmod(number, columns)
        top, left = _GAP + row * (height + _GAP), _GAP + column * (width + _GAP)
        paper[top : top + height, left : left + width] = cell
    return paper
