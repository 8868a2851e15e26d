"""Draws a followed path as the paper's figure 8 has it: the way in space, errors over time."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

# Named "3d" by its import.
from mpl_toolkits.mplot3d import Axes3D

from .analysis import AXES, TrackingResult

DESIRED, MEASURED = "#1f6fb4", "#c8372d"
COLOURS = ("#1f6fb4", "#d9822b", "#3a8f5c")
_SHOWN_POINTS = 3000
"""Points of a curve that are drawn; more cannot be seen."""


def draw(result: TrackingResult) -> Figure:
    """Draw a result: path and desired path, and below the error in x, y and z over time."""
    step = max(1, len(result.times) // _SHOWN_POINTS)
    figures = result.figures
    figure = Figure(figsize=(7.2, 9.0), layout="constrained")
    figure.suptitle(
        f"{result.name}: error {1000.0 * figures.rms:.2f} mm rms, "
        f"{1000.0 * figures.largest:.2f} mm at most",
        fontsize=12,
    )
    above, below = figure.subfigures(2, 1, height_ratios=(1.5, 1.0))
    space = above.add_subplot(projection=Axes3D.name)
    _draw_way(space, result, step)
    rows = below.subplots(3, 1, sharex=True)
    reach = 1.15e3 * max(np.abs(result.error).max(), 1e-6)
    for index, (axes, name) in enumerate(zip(rows, AXES)):
        axes.axhline(0.0, color="#888888", linewidth=0.6)
        axes.plot(
            result.times[::step],
            1000.0 * result.error[::step, index],
            color=COLOURS[index],
            linewidth=0.8,
        )
        axes.set_ylabel(f"error in {name} (mm)", fontsize=8)
        axes.set_ylim(-reach, reach)
        axes.grid(True, linewidth=0.4, color="#dddddd")
        axes.tick_params(labelsize=7)
        axes.margins(x=0.0)
        for side in ("top", "right"):
            axes.spines[side].set_visible(False)
    rows[-1].set_xlabel("time (s)", fontsize=8)
    return figure


def _draw_way(space: Axes3D, result: TrackingResult, step: int) -> None:
    desired, measured = result.desired[::step], result.measured[::step]
    space.plot(*desired.T, color=DESIRED, linewidth=2.2, alpha=0.75, label="desired")
    space.plot(*measured.T, color=MEASURED, linewidth=0.9, label="followed")
    space.scatter(*desired[0], color="#222222", s=18, label="begin")
    # Equal scales, so that a circle looks like one; a flat path gets some depth all the same.
    low, high = desired.min(axis=0), desired.max(axis=0)
    middle, half = 0.5 * (low + high), 0.55 * max(float((high - low).max()), 0.01)
    for name, centre in zip(AXES, middle):
        getattr(space, f"set_{name}lim")(centre - half, centre + half)
        getattr(space, f"set_{name}label")(f"{name} (m)", fontsize=8)
    space.set_box_aspect((1.0, 1.0, 1.0))
    space.tick_params(labelsize=7)
    space.view_init(elev=22.0, azim=-55.0)
    space.legend(fontsize=8, frameon=False, loc="upper left")
