"""``rosrun telex_training exercise``: lists, checks and draws exercises; needs no ROS master."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import List, Optional, Sequence, Tuple

from ..exercises.catalog import PATH_VARIABLE, exercises, find_exercise
from ..exercises.exercise_file import ExerciseError, ExerciseFile, load_exercise
from ..exercises.findings import print_findings
from ..exercises.model import PRACTICE

_LARGEST_SIDE = 4096


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Run a command; returns the exit status."""
    options = _parser().parse_args(arguments)
    try:
        return options.run(options)
    except ExerciseError as error:
        print(error, file=sys.stderr)
        return 1


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="exercise",
        description="Exercises; docs/instructor/exercises.md describes their files.",
        epilog=f"Exercises are also found by name in the folders of {PATH_VARIABLE} (separated"
        " by :).",
    )
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    listing = commands.add_parser("list", help="list the exercises that have a name")
    listing.set_defaults(run=_list)
    check = commands.add_parser("check", help="say whether exercise files are right")
    check.add_argument("exercises", nargs="+", metavar="FILE", help="file, or name of an exercise")
    check.add_argument(
        "--no-robot",
        action="store_true",
        help="leave out whether the robot has what is asked for, and room at its start",
    )
    check.set_defaults(run=_check)
    preview = commands.add_parser("preview", help="draw scene, zones and names of an exercise")
    which = preview.add_mutually_exclusive_group(required=True)
    which.add_argument("exercise", nargs="?", metavar="FILE", help="file, or name of an exercise")
    which.add_argument(
        "--all",
        metavar="FOLDER",
        help="draw all exercises that have a name, as NAME.jpg in a folder",
    )
    preview.add_argument(
        "--sheet", metavar="PICTURE", help="with --all: also one picture with all of them"
    )
    preview.add_argument(
        "-o", "--output", metavar="PICTURE", help="default: the exercise's name.png"
    )
    preview.add_argument("--setting", default="", metavar="NAME", help="default: the first")
    preview.add_argument("--seed", type=_seed, metavar="N", help="default: that of practice")
    preview.add_argument(
        "--size",
        type=_size,
        metavar="WxH",
        help="pixels; default 1280x720, with --all 480x270",
    )
    preview.add_argument("--top", action="store_true", help="look straight down")
    preview.add_argument(
        "--quality", default="still", metavar="NAME", help="as for scene preview; default: still"
    )
    preview.set_defaults(run=_preview)
    return parser


def _list(options: argparse.Namespace) -> int:
    wrong = 0
    for name, path in exercises().items():
        try:
            first = load_exercise(path).first
        except ExerciseError as error:
            print(error, file=sys.stderr)
            wrong += 1
            continue
        print(f"{name}: {first.title}")
        if first.description:
            print(f"    {first.description}")
        print(f"    settings: {', '.join(first.settings)}; {', '.join(first.modes)}")
        print(f"    {path}")
    return 1 if wrong else 0


def _check(options: argparse.Namespace) -> int:
    # Physics takes a moment to load, which the other commands do without.
    from ..briefing.texts import unsaid
    from ..exercises.check import check_file

    wrong = 0
    for name in options.exercises:
        try:
            path = find_exercise(name)
            file = load_exercise(path)
        except ExerciseError as error:
            print(error, file=sys.stderr)
            wrong += 1
            continue
        findings = [*check_file(file, not options.no_robot), *unsaid(file)]
        wrong += not print_findings(path, findings, _counts(file))
    return 1 if wrong else 0


def _counts(file: ExerciseFile) -> str:
    first = file.first
    counts: List[Tuple[int, str]] = [
        (len(file.settings), "setting"),
        (len(first.steps), "step"),
        (len(first.zones), "zone"),
        (len(first.metrics), "metric"),
    ]
    return ", ".join(f"{count} {word}{'' if count == 1 else 's'}" for count, word in counts)


def _preview(options: argparse.Namespace) -> int:
    if options.all is not None:
        return _preview_all(options)
    from ..exercises.preview import draw_preview

    if options.sheet is not None:
        raise ExerciseError("--sheet belongs to --all")
    exercise = load_exercise(find_exercise(options.exercise)).setting(options.setting)
    seed = exercise.seeds.of(PRACTICE) if options.seed is None else options.seed
    output = Path(options.output or f"{exercise.name}.png")
    size = options.size or (1280, 720)
    draw_preview(exercise, seed or 0, output, size=size, top=options.top, quality=options.quality)
    print(output)
    return 0


def _preview_all(options: argparse.Namespace) -> int:
    from ..exercises.preview_sheet import SIZE, draw_all

    if options.output or options.setting or options.top or options.seed is not None:
        raise ExerciseError("--all takes no --output, --setting, --seed or --top")
    sheet = None if options.sheet is None else Path(options.sheet)
    size = options.size or SIZE
    for path in draw_all(exercises().values(), Path(options.all), sheet, size, options.quality):
        print(path)
    return 0


def _seed(text: str) -> int:
    if not text.isdigit() or int(text) >= 2**63:
        raise argparse.ArgumentTypeError(f"'{text}'; a whole number from 0 is needed")
    return int(text)


def _size(text: str) -> Tuple[int, int]:
    width, _, height = text.partition("x")
    if not (width.isdigit() and height.isdigit()):
        raise argparse.ArgumentTypeError(f"'{text}'; WIDTHxHEIGHT is needed, as 1280x720")
    size = int(width), int(height)
    if not all(16 <= side <= _LARGEST_SIDE for side in size):
        raise argparse.ArgumentTypeError(f"'{text}'; sides of 16 to {_LARGEST_SIDE} are possible")
    return size
