"""Figures of matplotlib as files, without a display."""

from __future__ import annotations

from pathlib import Path
from typing import List

import matplotlib
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure


def save(figure: Figure, path: Path) -> List[Path]:
    """Write a figure as PNG and as SVG.

    Parameters
    ----------
    path : Path
        Without suffix.

    Returns
    -------
    list of Path
        The files.
    """
    FigureCanvasAgg(figure)
    files = [path.parent / f"{path.name}{suffix}" for suffix in (".png", ".svg")]
    # The same measurement makes the same files.
    with matplotlib.rc_context({"svg.hashsalt": path.name}):
        figure.savefig(files[0], dpi=120, metadata={"Software": None})
        figure.savefig(files[1], metadata={"Date": None})
    return files
