"""The command ``expert``: lets scripted experts do exercises, measures their figures, records."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any, Dict, Optional, Sequence

from ..exercises.catalog import find_exercise
from ..exercises.exercise_file import ExerciseError, load_exercise
from ..operators.experts.brief import Expert
from ..operators.experts.catalog import EXPERTS
from ..recording.trial_file import FOLDER
from ..recording.writer import RecordingError
from ..rehearsal.demonstration import demonstrate
from ..rehearsal.figures import LEAST_RUNS, Figure, FiguresError, measured, places, with_figures
from ..ros.robot_files import software_version

_RUNS = 5


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Run the command; returns its exit status: 0, or 1 where an expert has no figures."""
    given = _parser().parse_args(arguments)
    status = 0
    for name in given.exercises or sorted(EXPERTS):
        try:
            if given.record:
                _record(name, given.setting, given.recordings.expanduser())
            else:
                _measure(name, given.runs, given.write)
        except (ExerciseError, FiguresError, RecordingError, OSError) as error:
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
    parser.add_argument(
        "--record",
        action="store_true",
        help="measure nothing: record a run of each setting that has figures, for replays",
    )
    parser.add_argument("--setting", metavar="NAME", help="of what is recorded: this one alone")
    parser.add_argument(
        "--recordings",
        type=Path,
        default=Path(FOLDER),
        metavar="FOLDER",
        help=f"of people's recordings, beside which experts' are put; default {FOLDER}",
    )
    return parser


def _runs(text: str) -> int:
    if not text.isdigit() or int(text) < LEAST_RUNS:
        raise argparse.ArgumentTypeError(f"'{text}'; a whole number from {LEAST_RUNS} is needed")
    return int(text)


def _record(name: str, setting: Optional[str], folder: Path) -> None:
    expert = _expert(name)
    file = load_exercise(find_exercise(name))
    settings = [setting] if setting else dict.fromkeys(each.setting for each in places(file))
    for each in settings:
        print(demonstrate(file, each, expert, folder, software_version()), flush=True)


def _expert(name: str) -> Expert:
    if name not in EXPERTS:
        raise FiguresError(f"{name} has no scripted expert; these have: {', '.join(EXPERTS)}")
    return EXPERTS[name]


def _measure(name: str, runs: int, write: bool) -> None:
    expert = _expert(name)
    path = find_exercise(name)
    file = load_exercise(path)
    where = places(file)
    figures: Dict[str, Dict[str, Figure]] = {}
    for setting in dict.fromkeys(place.setting for place in where):
        exercise = file.setting(setting)
        figures[setting] = measured(exercise, expert, range(1, runs + 1), _progress)
        for metric, (mean, deviation) in figures[setting].items():
            print(f"{name} {setting} {metric}: {mean:.4g} +- {deviation:.2g}", flush=True)
    if write:
        path.write_text(with_figures(file.text, where, figures, runs), encoding="utf-8")
        print(path)


def _progress(sheet: Dict[str, Any]) -> None:
    seconds = sheet["repetitions"][0]["seconds"]
    print(f"    seed {sheet['exercise']['seed']}: {seconds:.1f} s", file=sys.stderr, flush=True)
