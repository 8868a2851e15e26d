"""Followed paths as tables: for people, for spreadsheets, for programs."""

from __future__ import annotations

import csv
import io
import json
from dataclasses import asdict
from typing import Any, Dict, List, Sequence

from .analysis import AXES, TrackingResult


def text(results: Sequence[TrackingResult]) -> str:
    """Return a Markdown table; errors in mm."""
    lines = [
        "| path | length m | time s | error mm | x | y | z | distance | behind ms |",
        "|---|---:|---:|---|---:|---:|---:|---:|---:|",
    ]
    for result in results:
        figures = result.figures
        for kind, axes, whole in (
            ("rms", figures.rms_by_axis, figures.rms),
            ("max", figures.largest_by_axis, figures.largest),
        ):
            head = (
                f"| {result.name} | {figures.length:.2f} | {figures.duration:.1f} "
                if kind == "rms"
                else "| | | "
            )
            cells = " | ".join(f"{1000.0 * value:.3f}" for value in (*axes, whole))
            tail = f"{1000.0 * figures.delay:.1f}" if kind == "rms" else ""
            lines.append(f"{head}| {kind} | {cells} | {tail} |")
    return "\n".join(lines)


def records(results: Sequence[TrackingResult]) -> List[Dict[str, Any]]:
    """Return the figures as plain values in SI units."""
    return [{"path": result.name, **asdict(result.figures)} for result in results]


def as_json(results: Sequence[TrackingResult]) -> str:
    """Return a JSON list of the figures, in SI units."""
    return json.dumps(records(results), indent=2, allow_nan=False)


def as_csv(result: TrackingResult) -> str:
    """Return the desired and the measured way, comma-separated with a head (s, m)."""
    file = io.StringIO()
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(["time", *(f"desired_{axis}" for axis in AXES), *AXES])
    for time, desired, measured in zip(result.times, result.desired, result.measured):
        writer.writerow([f"{value:.6f}" for value in (time, *desired, *measured)])
    return file.getvalue()
