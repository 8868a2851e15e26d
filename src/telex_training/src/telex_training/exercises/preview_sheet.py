"""Previews of several exercises: a picture of each, and one sheet with all."""

from __future__ import annotations

from pathlib import Path
from typing import Iterable, List, Optional, Tuple

import cv2
import numpy as np

from .exercise_file import ExerciseError, load_exercise
from .model import PRACTICE
from .preview import preview_picture, require_writer, write_picture

SIZE = (480, 270)
"""Of a picture (pixels)."""
_COLUMNS = 3
_CAPTION = 26
"""Height of the line with the title under a picture (pixels)."""
_PAPER, _INK = 250, (40, 40, 40)


def draw_all(
    paths: Iterable[Path],
    folder: Path,
    sheet: Optional[Path] = None,
    size: Tuple[int, int] = SIZE,
    quality: str = "still",
) -> List[Path]:
    """Draw each exercise, in its first setting and with its seed of practice, as ``NAME.jpg``.

    Parameters
    ----------
    paths : iterable of Path
        Of the exercises' files.
    folder : Path
        Made where it is not there.
    sheet : Path, optional
        Of one picture with all of them.
    size : tuple of int
        Of each picture (pixels).
    quality : str
        As for ``scene preview``.

    Returns
    -------
    list of Path
        Of what was written.

    Raises
    ------
    ExerciseError
        A file is wrong, a scene cannot be drawn, or a picture not be written.
    """
    if sheet is not None:
        require_writer(sheet)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ExerciseError(f"{folder}: {error.strerror}") from error
    written, pictures = [], []
    for path in paths:
        exercise = load_exercise(path).first
        picture = preview_picture(exercise, exercise.seeds.of(PRACTICE) or 0, size, quality=quality)
        output = folder / f"{exercise.name}.jpg"
        write_picture(output, picture)
        written.append(output)
        pictures.append((exercise.title, picture))
    if sheet is not None and pictures:
        write_picture(sheet, sheet_of(pictures))
        written.append(sheet)
    return written


def sheet_of(pictures: List[Tuple[str, np.ndarray]]) -> np.ndarray:
    """Put pictures of one size, shape (height, width, 3), in rows of three over their titles."""
    height, width = pictures[0][1].shape[:2]
    rows = -(-len(pictures) // _COLUMNS)
    columns = min(_COLUMNS, len(pictures))
    sheet = np.full((rows * (height + _CAPTION), columns * width, 3), _PAPER, dtype=np.uint8)
    for number, (title, picture) in enumerate(pictures):
        top = number // _COLUMNS * (height + _CAPTION)
        left = number % _COLUMNS * width
        sheet[top : top + height, left : left + width] = picture
        place = (left + 8, top + height + 18)
        cv2.putText(sheet, title, place, cv2.FONT_HERSHEY_SIMPLEX, 0.5, _INK, 1, cv2.LINE_AA)
    return sheet
