"""Writes what a followed path has yielded into a folder."""

from __future__ import annotations

import re
from pathlib import Path
from typing import List

from ..common.figure_files import save
from . import figure, table
from .analysis import TrackingResult


def write(folder: Path, result: TrackingResult) -> List[Path]:
    """Write ``<path>.png``, ``.svg``, ``.csv`` (the ways), ``.json`` and ``.md`` (the figures).

    Raises
    ------
    OSError
        The folder cannot be made or written to.
    """
    folder.mkdir(parents=True, exist_ok=True)
    name = "_".join(re.findall(r"\w+", result.name))
    files = save(figure.draw(result), folder / name)
    for suffix, content in (
        (".csv", table.as_csv(result)),
        (".json", table.as_json([result]) + "\n"),
        (".md", table.text([result]) + "\n"),
    ):
        file = folder / f"{name}{suffix}"
        file.write_text(content, encoding="utf-8")
        files.append(file)
    return files
