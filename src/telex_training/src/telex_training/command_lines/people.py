"""The command ``people``: who has done trials; forgets people, and what is too old."""

from __future__ import annotations

import argparse
import math
import sys
from typing import Optional, Sequence

from ..progress.index import ProgressIndex, ProgressIndexError
from ..progress.people import PeopleError, expire, forget, new_pseudonym
from ..progress.reports.report_pieces import NOBODY, count
from .progress import add_folder, open_index


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Run a command; returns its exit status: 0, or 1 where something could not be done."""
    options = _parser().parse_args(arguments)
    try:
        return int(options.run(open_index(options.folder), options))
    except (PeopleError, ProgressIndexError, OSError) as error:
        print(f"people: {error}", file=sys.stderr)
        return 1


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="people",
        description="People in the recordings of trials; docs/instructor/progress.md says what "
        "forgetting reaches, and what it does not.",
    )
    add_folder(parser)
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    listing = commands.add_parser("list", help="list people")
    listing.set_defaults(run=_list)
    forgetting = commands.add_parser("forget", help="take somebody out of recordings and exports")
    forgetting.add_argument("name", metavar="NAME", help="exactly as in the trials")
    how = forgetting.add_mutually_exclusive_group(required=True)
    how.add_argument("--remove", action="store_true", help="remove the person's recordings")
    how.add_argument(
        "--pseudonymise",
        action="store_true",
        help="keep them, under a pseudonym; their hashes change",
    )
    forgetting.set_defaults(run=_forget)
    expiring = commands.add_parser("expire", help="remove recordings and exports that are too old")
    expiring.add_argument("--days", type=_days, required=True, help="older than this")
    expiring.set_defaults(run=_expire)
    return parser


def _list(index: ProgressIndex, _options: argparse.Namespace) -> int:
    index.refresh()
    for person in index.people():
        print(f"{person.name or NOBODY}: {count(person.trials, 'trial')}")
    return 0


def _forget(index: ProgressIndex, options: argparse.Namespace) -> int:
    pseudonym = "" if options.remove else new_pseudonym()
    done = forget(index, options.name, pseudonym)
    for what, paths in (
        ("removed", done.removed),
        (f"now {pseudonym}'s", done.renamed),
        ("name taken out of", done.mentioned),
        ("export removed", done.exports),
    ):
        for path in paths:
            print(f"{what}: {path}")
    for each in done.left:
        print(f"people: {each}", file=sys.stderr)
    return 1 if done.left else 0


def _expire(index: ProgressIndex, options: argparse.Namespace) -> int:
    for path in expire(index, options.days):
        print(f"removed: {path}")
    return 0


def _days(text: str) -> float:
    try:
        days = float(text)
    except ValueError:
        days = math.nan
    if not 0.0 < days < math.inf:
        raise argparse.ArgumentTypeError(f"'{text}'; a number of days above 0 is needed")
    return days
