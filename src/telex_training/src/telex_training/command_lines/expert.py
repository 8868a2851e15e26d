"""The command ``expert``: lets scripted experts do exercises, and measures their figures."""

from __future__ import annotations

import argparse
import sys
from typing import Any, Dict, Optional, Sequence

from ..exercises.catalog import find_exercise
from ..exercises.exercise_file import ExerciseError, load_exercise
from ..operators.experts.catalog import EXPERTS
from ..rehearsal.figures import LEAST_RUNS, Figure, FiguresError, measured, places, with_figures

_RUNS = 5


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Run the command; returns its exit status: 0, or 1 where an expert has no figures."""
    given = _parser().parse_args(arguments)
    status = 0
    for name in given.exercises or sorted(EXPERTS):
        try:
            _measure(name, given.runs, given.write)
        except (ExerciseError, FiguresError, OSError) as error:
            print(f"expert: {error}", file=sys.stderr)
            status = 1
    return status


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="expert", description=__doc__)
    parser.add_argument(
        "exercises", nargs="*", metavar="NAME", help="default: all that have a scripted expert"
    )
    parser.add_argument(
        "--runs",
        type=_runs,
        default=_RUNS,
        metavar="N",
        help=f"of each setting that has figures, with the seeds 1 to N; default {_RUNS}",
    )
    parser.add_argument(
        "--write", action="store_true", help="put the figures into the exercise's file"
    )
    return parser


def _runs(text: str) -> int:
    if not text.isdigit() or int(text) < LEAST_RUNS:
        raise argparse.ArgumentTypeError(f"'{text}'; a whole number from {LEAST_RUNS} is needed")
    return int(text)


def _measure(name: str, runs: int, write: bool) -> None:
    if name not in EXPERTS:
        raise FiguresError(f"{name} has no scripted expert; these have: {', '.join(EXPERTS)}")
    path = find_exercise(name)
    file = load_exercise(path)
    where = places(file)
    figures: Dict[str, Dict[str, Figure]] = {}
    for setting in dict.fromkeys(place.setting for place in where):
        exercise = file.setting(setting)
        figures[setting] = measured(exercise, EXPERTS[name], range(1, runs + 1), _progress)
        for metric, (mean, deviation) in figures[setting].items():
            print(f"{name} {setting} {metric}: {mean:.4g} +- {deviation:.2g}", flush=True)
    if write:
        path.write_text(with_figures(file.text, where, figures, runs), encoding="utf-8")
        print(path)


def _progress(sheet: Dict[str, Any]) -> None:
    seconds = sheet["repetitions"][0]["seconds"]
    print(f"    seed {sheet['exercise']['seed']}: {seconds:.1f} s", file=sys.stderr, flush=True)
