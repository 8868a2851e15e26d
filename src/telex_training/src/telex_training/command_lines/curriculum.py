"""The command ``curriculum``: lists and checks curricula; needs no ROS master."""

from __future__ import annotations

import argparse
import sys
from typing import Optional, Sequence

from ..exercises.findings import print_findings
from ..progress.curriculum_check import check_curriculum
from ..progress.curriculum_file import (
    PATH_VARIABLE,
    CurriculumError,
    curricula,
    find_curriculum,
    load_curriculum,
)


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Run the command; returns its exit status: 0, or 1 where a curriculum is wrong."""
    options = _parser().parse_args(arguments)
    return int(options.run(options))


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="curriculum",
        description="Curricula; docs/instructor/progress.md describes their files.",
        epilog=f"Curricula are also found by name in the folders of {PATH_VARIABLE} (separated"
        " by :).",
    )
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    listing = commands.add_parser("list", help="list the curricula that have a name")
    listing.set_defaults(run=_list)
    check = commands.add_parser("check", help="say whether curriculum files are right")
    check.add_argument("curricula", nargs="+", metavar="FILE", help="file, or name of a curriculum")
    check.set_defaults(run=_check)
    return parser


def _list(_options: argparse.Namespace) -> int:
    wrong = 0
    for name, path in curricula().items():
        try:
            made = load_curriculum(path)
        except CurriculumError as error:
            print(error, file=sys.stderr)
            wrong += 1
            continue
        print(f"{name}: {made.title}")
        if made.description:
            print(f"    {made.description}")
        print(f"    modules: {', '.join(module.name for module in made.modules)}")
        print(f"    {path}")
    return 1 if wrong else 0


def _check(options: argparse.Namespace) -> int:
    wrong = 0
    for name in options.curricula:
        try:
            made = load_curriculum(find_curriculum(name))
        except CurriculumError as error:
            print(error, file=sys.stderr)
            wrong += 1
            continue
        counts = f"{len(made.modules)} modules, {len(made.exam)} parts of an exam"
        wrong += not print_findings(made.path, check_curriculum(made), counts)
    return 1 if wrong else 0
