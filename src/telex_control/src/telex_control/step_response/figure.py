"""Draws step responses as the paper's figure 7 has them: reference and response, effort below."""

from __future__ import annotations

import math
from typing import Dict, List, Sequence

from matplotlib.figure import Figure

from ..urdf.joints import short_name
from .runner import StepResult, shown_unit
from .table import kind

COLUMNS = 4
COLOURS = {"shaped": "#1f6fb4", "raw": "#d9822b"}
GREY = "#555555"


def draw(title: str, results: Sequence[StepResult]) -> Figure:
    """Draw all steps of some joints in one figure; a joint's raw step joins its shaped one."""
    by_joint: Dict[str, List[StepResult]] = {}
    for result in results:
        by_joint.setdefault(result.joint.name, []).append(result)
    columns = min(COLUMNS, len(by_joint))
    rows = math.ceil(len(by_joint) / columns)
    figure = Figure(figsize=(3.4 * columns + 0.4, 3.5 * rows + 0.7), layout="constrained")
    figure.suptitle(title, fontsize=12)
    cells = figure.subfigures(rows, columns, squeeze=False)
    for index, name in enumerate(by_joint):
        _draw_joint(cells[index // columns][index % columns], by_joint[name], index == 0)
    return figure


def _draw_joint(cell: Figure, results: Sequence[StepResult], legend: bool) -> None:
    joint = results[0].joint
    unit = shown_unit(joint)
    above, below = cell.subplots(2, 1, sharex=True, gridspec_kw={"height_ratios": (2, 1)})
    reference = results[0].recording
    times = [reference.times[0], 0.0, 0.0, reference.times[-1]]
    levels = [reference.start, reference.start, reference.target, reference.target]
    above.plot(
        times,
        [level * unit.factor for level in levels],
        color=GREY,
        linewidth=1.0,
        linestyle="--",
        label="reference",
    )
    for result in results:
        recording, name = result.recording, kind(result)
        colour = COLOURS[name]
        above.plot(
            recording.times,
            recording.positions * unit.factor,
            color=colour,
            linewidth=1.3,
            label=f"response, {name}",
        )
        # A raw step's effort runs from limit to limit, and would cover the other.
        below.plot(
            recording.times,
            recording.efforts,
            color=colour,
            linewidth=0.7 if result.raw else 1.1,
            zorder=2 if result.raw else 3,
        )
    above.set_title(short_name(joint.name).replace("_", " "), fontsize=10)
    above.set_ylabel(f"position ({'°' if unit.position == 'deg' else unit.position})", fontsize=8)
    below.set_ylabel(f"effort ({unit.effort})", fontsize=8)
    below.set_xlabel("time (s)", fontsize=8)
    for axes in (above, below):
        axes.grid(True, linewidth=0.4, color="#dddddd")
        axes.tick_params(labelsize=7)
        axes.margins(x=0.0)
        for side in ("top", "right"):
            axes.spines[side].set_visible(False)
    if legend:
        above.legend(fontsize=7, frameon=False, loc="lower right")
