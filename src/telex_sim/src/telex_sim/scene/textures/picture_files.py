"""Picture files that are laid on visuals."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

# Larger pictures are reduced: the cameras could not resolve more, and it saves memory.
MAX_TEXTURE_SIZE = 2048


class TextureFileError(ValueError):
    """A texture's file is missing or is no picture; the message names the file."""


def load_texture(path: Path) -> np.ndarray:
    """Read a picture.

    Returns
    -------
    numpy.ndarray
        RGB, shape (height, width, 3), uint8, rows from above.

    Raises
    ------
    TextureFileError
        When the file is missing, may not be looked at, is no picture, or larger than OpenCV takes.
    """
    try:
        found = path.is_file()
    except OSError as error:
        raise TextureFileError(f"{path}: {error.strerror}") from error
    if not found:
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
