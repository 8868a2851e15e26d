"""Pictures that are laid on visuals."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

# Larger pictures are reduced: the cameras could not resolve more, and it saves memory.
MAX_TEXTURE_SIZE = 2048

_CHECKER_PIXELS = 1024
_CHECKER_TONES = (222, 198)
_CHECKER_LINE_TONE = 120
_CHECKER_LINE_WIDTH = 5
_CHECKER_FINE_TONE_STEP = 14


class TextureFileError(ValueError):
    """A texture's file is missing or is no picture; the message names the file."""


def checker_texture() -> np.ndarray:
    """Floor of two tones: one repetition holds two by two tiles, each with a grid of quarters.

    Returns
    -------
    numpy.ndarray
        RGB, shape (N, N, 3), uint8; it tiles without a seam.
    """
    half = _CHECKER_PIXELS // 2
    row, column = np.indices((_CHECKER_PIXELS, _CHECKER_PIXELS))
    tones = np.where((row // half + column // half) % 2, *_CHECKER_TONES)
    fine = _on_line(row, column, half // 4, 2)
    tones = np.where(fine, tones - _CHECKER_FINE_TONE_STEP, tones)
    tones = np.where(_on_line(row, column, half, _CHECKER_LINE_WIDTH), _CHECKER_LINE_TONE, tones)
    return np.repeat(tones[..., None], 3, axis=2).astype(np.uint8)


def _on_line(row: np.ndarray, column: np.ndarray, spacing: int, width: int) -> np.ndarray:
    return ((row + width // 2) % spacing < width) | ((column + width // 2) % spacing < width)


def load_texture(path: Path) -> np.ndarray:
    """Read a picture.

    Returns
    -------
    numpy.ndarray
        RGB, shape (height, width, 3), uint8, rows from above.

    Raises
    ------
    TextureFileError
        When the file is missing, no picture, or larger than OpenCV takes.
    """
    if not path.is_file():
        raise TextureFileError(f"{path}: no such file")
    try:
        picture = cv2.imread(str(path), cv2.IMREAD_COLOR)
        if picture is None:
            raise TextureFileError(f"{path}: no picture that OpenCV can read")
        return cv2.cvtColor(_reduced(picture), cv2.COLOR_BGR2RGB)
    except cv2.error as error:
        raise TextureFileError(f"{path}: OpenCV cannot read it: {error.err}") from error


def _reduced(picture: np.ndarray) -> np.ndarray:
    height, width = picture.shape[:2]
    reduction = MAX_TEXTURE_SIZE / max(height, width)
    if reduction >= 1.0:
        return picture
    # Of a narrow strip at least a line has to remain.
    size = (max(1, round(width * reduction)), max(1, round(height * reduction)))
    return cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
