"""Writes what a measurement has yielded into a folder."""

from __future__ import annotations

from pathlib import Path
from typing import Dict, List, Sequence, Tuple

from ..common.figure_files import save
from . import figure, table
from .plan import Plan
from .runner import StepResult


def write(folder: Path, plan: Plan, results: Sequence[StepResult]) -> List[Path]:
    """Write ``steps.csv``, ``steps.json``, ``steps.md``, and for each posture and group a figure.

    Raises
    ------
    OSError
        The folder cannot be made or written to.
    """
    folder.mkdir(parents=True, exist_ok=True)
    files = []
    for name, content in (
        ("steps.md", table.text(results) + "\n"),
        ("steps.csv", table.as_csv(results)),
        ("steps.json", table.as_json(results) + "\n"),
    ):
        files.append(folder / name)
        files[-1].write_text(content, encoding="utf-8")
    figures: Dict[Tuple[str, str], List[StepResult]] = {}
    for result in results:
        figures.setdefault((result.posture, plan.group(result.joint.name)), []).append(result)
    for (posture, group), members in figures.items():
        drawing = figure.draw(f"Step responses: {group.replace('_', ' ')}, {posture}", members)
        files += save(drawing, folder / f"{group}_{posture}")
    return files
