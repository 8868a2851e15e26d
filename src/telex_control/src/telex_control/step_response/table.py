"""Step responses as tables: for people, for spreadsheets, for programs."""

from __future__ import annotations

import csv
import io
import json
import math
from dataclasses import asdict
from typing import Any, Dict, List, Sequence

from ..urdf.joints import short_name
from .runner import StepResult, shown_unit

HEAD = (
    "posture",
    "joint",
    "reference",
    "step",
    "rise s",
    "overshoot %",
    "settling s",
    "error",
    "peak effort",
    "of limit %",
)


def kind(result: StepResult) -> str:
    """Name of how the reference came: raw or shaped."""
    return "raw" if result.raw else "shaped"


def _number(value: float, digits: int) -> str:
    return "-" if math.isnan(value) else f"{value:.{digits}f}"


def _cells(result: StepResult) -> List[str]:
    figures, recording, joint = result.figures, result.recording, result.joint
    unit = shown_unit(joint)
    step = (recording.target - recording.start) * unit.factor
    share = 100.0 * figures.peak_effort / joint.effort
    return [
        result.posture,
        short_name(joint.name),
        kind(result),
        f"{step:.1f} {unit.position}",
        _number(figures.rise_time, 2),
        _number(figures.overshoot, 1),
        _number(figures.settling_time, 2),
        f"{abs(figures.steady_state_error) * unit.factor:.3f} {unit.position}",
        f"{figures.peak_effort:.1f} {unit.effort}",
        _number(share, 0) if math.isfinite(share) else "-",
    ]


def text(results: Sequence[StepResult]) -> str:
    """Return a Markdown table with aligned columns; ``-`` stands for what was not reached."""
    rows = [list(HEAD), *map(_cells, results)]
    widths = [max(len(row[column]) for row in rows) for column in range(len(HEAD))]
    names = 3  # columns of words, aligned to the left
    lines = []
    for index, row in enumerate(rows):
        cells = [
            cell.ljust(width) if column < names else cell.rjust(width)
            for column, (cell, width) in enumerate(zip(row, widths))
        ]
        lines.append(f"| {' | '.join(cells)} |")
        if index == 0:
            rule = [
                "-" * width if column < names else "-" * (width - 1) + ":"
                for column, width in enumerate(widths)
            ]
            lines.append(f"| {' | '.join(rule)} |")
    return "\n".join(lines)


def records(results: Sequence[StepResult]) -> List[Dict[str, Any]]:
    """Return plain values in SI units by name; None stands for what was not reached."""
    rows = []
    for result in results:
        figures = {
            key: None if math.isnan(value) else value
            for key, value in asdict(result.figures).items()
        }
        limit = result.joint.effort
        rows.append(
            {
                "posture": result.posture,
                "joint": result.joint.name,
                "reference": kind(result),
                "start": result.recording.start,
                "target": result.recording.target,
                **figures,
                "effort_limit": limit if math.isfinite(limit) else None,
            }
        )
    return rows


def as_json(results: Sequence[StepResult]) -> str:
    """Return a JSON list of the records, in SI units."""
    return json.dumps(records(results), indent=2, allow_nan=False)


def as_csv(results: Sequence[StepResult]) -> str:
    """Return comma-separated records with a head, in SI units."""
    rows = records(results)
    file = io.StringIO()
    writer = csv.DictWriter(file, list(rows[0]) if rows else [], lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return file.getvalue()
