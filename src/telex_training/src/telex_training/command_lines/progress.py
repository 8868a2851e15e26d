"""The command ``progress``: the index of people and trials, what it exports, and reports."""

from __future__ import annotations

import argparse
import contextlib
import hashlib
import sys
import time
from pathlib import Path
from typing import Dict, List, Optional, Sequence

from ..exercises.model import MODES
from ..progress.comparison import TIME, ComparisonError, compare
from ..progress.curriculum_file import (
    Curriculum,
    CurriculumError,
    curricula,
    find_curriculum,
    load_curriculum,
)
from ..progress.exports import BASE, repetitions_csv, statements_text, trials_csv
from ..progress.importing import REFUSED, import_files
from ..progress.index import Person, ProgressIndex, ProgressIndexError
from ..progress.people import EXPORTS
from ..progress.reports.class_report import class_report, comparison_lines, comparison_report
from ..progress.reports.person_report import person_report
from ..progress.reports.report_pieces import NOBODY, NONE, count, day, percent
from ..progress.skill import skills
from ..progress.trial_facts import TrialFacts
from ..recording.trial_file import FOLDER, safe_name
from ..recording.writer import RecordingError
from .drafts import draft_of


class CommandError(ValueError):
    """A command cannot be done; the message says why and what would be right."""


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Run a command; returns its exit status: 0, or 1 where it could not be done."""
    options = _parser().parse_args(arguments)
    try:
        index = open_index(options.folder, make=options.command == "import")
        problems = index.rebuild() if options.command == "rebuild" else index.refresh()
        for problem in problems:
            print(f"progress: left out: {problem}", file=sys.stderr)
        return int(options.run(index, options))
    except (
        CommandError,
        ComparisonError,
        CurriculumError,
        ProgressIndexError,
        RecordingError,
        OSError,
    ) as error:
        print(f"progress: {error}", file=sys.stderr)
        return 1


def open_index(folder: Path, make: bool = False) -> ProgressIndex:
    """Return the index of a folder of recordings.

    Parameters
    ----------
    folder : Path
        ``~`` is the home of the user.
    make : bool
        Whether it may be made.

    Raises
    ------
    NotADirectoryError
    """
    path = folder.expanduser()
    if not make and not path.is_dir():
        raise NotADirectoryError(f"{path}: there is no such folder; --folder names another one")
    return ProgressIndex(path)


def add_folder(parser: argparse.ArgumentParser) -> None:
    """Add the option that says where the recordings are."""
    parser.add_argument(
        "--folder",
        type=Path,
        default=Path(FOLDER),
        metavar="FOLDER",
        help=f"of the recordings; default: {FOLDER}",
    )


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="progress",
        description="People's progress, from the recordings of their trials; "
        "docs/instructor/progress.md says more.",
        epilog="Who may read the recordings sees everybody's; trainees see their own on the page "
        "/progress/.",
    )
    add_folder(parser)
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    listing = commands.add_parser("list", help="list people, or what one of them has done")
    listing.add_argument("person", nargs="?", metavar="PERSON")
    listing.set_defaults(run=_list)
    rebuild = commands.add_parser("rebuild", help="make the index anew from all recordings")
    rebuild.set_defaults(run=_rebuild)
    taking = commands.add_parser(
        "import", help="take in recordings of other machines; a trial that is here already is once"
    )
    taking.add_argument("files", nargs="+", type=Path, metavar="FILE", help="recording, or folder")
    taking.add_argument(
        "--verify",
        action="store_true",
        help="judge each anew; refuse those of which another sheet comes than they have",
    )
    taking.set_defaults(run=_import)
    table = commands.add_parser("csv", help="export a table, a row a trial")
    table.add_argument("--repetitions", action="store_true", help="a row a repetition")
    _add_export(table, "trials.csv")
    table.set_defaults(run=_csv)
    xapi = commands.add_parser("xapi", help="export xAPI statements, as JSON lines")
    xapi.add_argument(
        "--base",
        default=BASE,
        metavar="ADDRESS",
        help=f"beginning of the addresses in them; default: {BASE}",
    )
    _add_export(xapi, "trials.jsonl")
    xapi.set_defaults(run=_xapi)
    report = commands.add_parser("report", help="report of a person, or of a class, as HTML")
    report.add_argument(
        "people", nargs="*", metavar="PERSON", help="one: of that person; several, or none: a class"
    )
    report.add_argument(
        "--curriculum",
        action="append",
        metavar="NAME",
        help="name or file; default: all that have a name",
    )
    report.add_argument("--title", default="Class", help="of a class; default: Class")
    _add_output(report, "PERSON.html, or class.html")
    report.set_defaults(run=_report)
    comparing = commands.add_parser("compare", help="compare two groups in an exercise")
    comparing.add_argument(
        "--group",
        action="append",
        nargs="+",
        required=True,
        metavar="NAME",
        help="name of the group, then its people; to be given twice",
    )
    comparing.add_argument("--exercise", required=True, metavar="NAME")
    comparing.add_argument("--setting", default="", metavar="NAME")
    comparing.add_argument("--metric", default=TIME, metavar="NAME", help=f"default: {TIME}")
    comparing.add_argument("--mode", default="", choices=("", *MODES), help="default: all")
    comparing.add_argument("-o", "--output", metavar="FILE", help="also as HTML; -: only so")
    comparing.set_defaults(run=_compare)
    return parser


def _add_export(parser: argparse.ArgumentParser, name: str) -> None:
    parser.add_argument("--person", metavar="PERSON", help="only theirs")
    _add_output(parser, name)


def _add_output(parser: argparse.ArgumentParser, name: str) -> None:
    parser.add_argument(
        "-o",
        "--output",
        metavar="FILE",
        help=f"-: standard output; default: {EXPORTS}/{name} in the folder of the recordings, where"
        " people forget finds it",
    )


def _list(index: ProgressIndex, options: argparse.Namespace) -> int:
    if options.person is None:
        people = index.people()
        for person in people:
            trials = count(person.trials, "trial")
            dates = f"{day(person.first)} to {day(person.last)}"
            print(f"{person.name or NOBODY}: {trials}, {dates}")
        if not people:
            print(f"{index.folder}: no trials")
        return 0
    for skill in skills(_trials(index, options.person)):
        best = NONE if skill.best is None else f"{skill.best:.1f} s"
        print(
            f"{skill.exercise}, {skill.setting}: {count(skill.trials, 'trial')}, "
            f"{skill.passed} of {count(len(skill.repetitions), 'repetition')} passed, "
            f"reliability at least {percent(skill.reliability)} (n = {skill.recent}), best {best}"
        )
    return 0


def _rebuild(index: ProgressIndex, _options: argparse.Namespace) -> int:
    people = index.people()
    trials = sum(person.trials for person in people)
    print(f"{index.path}: {count(trials, 'trial')} of {count(len(people), 'person', 'people')}")
    return 0


def _import(index: ProgressIndex, options: argparse.Namespace) -> int:
    done = import_files(index, options.files, options.verify)
    for each in done:
        if each.what == REFUSED:
            print(f"progress: refused: {each.reason}", file=sys.stderr)
        else:
            print(f"{each.path}: {each.what}")
    if not done:
        raise CommandError(f"{options.files[0]}: there is no recording in it")
    return 1 if any(each.what == REFUSED for each in done) else 0


def _csv(index: ProgressIndex, options: argparse.Namespace) -> int:
    trials = _trials(index, options.person)
    text = repetitions_csv(trials) if options.repetitions else trials_csv(trials)
    name = "repetitions.csv" if options.repetitions else "trials.csv"
    return _write(index, options.output, name, text)


def _xapi(index: ProgressIndex, options: argparse.Namespace) -> int:
    base = options.base.rstrip("/")
    if "://" not in base:
        raise CommandError(f"--base is '{options.base}'; an address is needed, such as {BASE}")
    text = statements_text(_trials(index, options.person), base)
    return _write(index, options.output, "trials.jsonl", text)


def _report(index: ProgressIndex, options: argparse.Namespace) -> int:
    courses = _courses(options.curriculum)
    now = time.time()
    if len(options.people) == 1:
        name = options.people[0]
        text = person_report(name, _trials(index, name), courses, now)
        return _write(index, options.output, f"{_file_name(name)}.html", text)
    names = options.people or [person.name for person in index.people()]
    if not names:
        raise CommandError(f"{index.folder}: there are no trials to report of")
    people: Dict[str, Sequence[TrialFacts]] = {name: _trials(index, name) for name in names}
    text = class_report(people, courses, now, options.title)
    return _write(index, options.output, "class.html", text)


def _file_name(name: str) -> str:
    """Name of a person's report: of two whose names are spelt alike, each has one."""
    spelt = safe_name(name)
    return spelt if spelt == name else f"{spelt}-{hashlib.sha256(name.encode()).hexdigest()[:8]}"


def _compare(index: ProgressIndex, options: argparse.Namespace) -> int:
    groups = {name: people for name, *people in options.group}
    made = compare(
        index.trials(), groups, options.exercise, options.setting, options.metric, options.mode
    )
    if options.output != "-":
        print(f"{made.exercise}, {made.setting}: {made.metric}")
        for group in made.groups:
            middle = NONE if group.median is None else f"{group.median:.4g} {made.unit}".rstrip()
            people = count(len(group.medians), "person", "people")
            repetitions = count(group.repetitions, "repetition")
            print(f"{group.name}: median {middle}, n = {people}, {repetitions}")
        print("\n".join(comparison_lines(made)))
    if options.output:
        return _write(index, options.output, "", comparison_report(made))
    return 0


def _courses(names: Optional[Sequence[str]]) -> List[Curriculum]:
    paths = [find_curriculum(name) for name in names] if names else list(curricula().values())
    return [load_curriculum(path) for path in paths]


def _trials(index: ProgressIndex, person: Optional[str]) -> List[TrialFacts]:
    found = index.trials(person)
    if person is not None and not found:
        raise CommandError(unknown_person(person, index.people()))
    return found


def unknown_person(name: str, people: Sequence[Person]) -> str:
    """Say that there are no trials of somebody, and of whom there are."""
    known = ", ".join(person.name for person in people if person.name) or "nobody"
    return f"person is '{name}'; there are trials of: {known}"


def _write(index: ProgressIndex, output: Optional[str], name: str, text: str) -> int:
    if output == "-":
        sys.stdout.write(text)
        return 0
    path = Path(output or index.folder / EXPORTS / name)
    if not output:
        path.parent.mkdir(mode=0o700, exist_ok=True)
    # What was given may name a pipe, which a draft would replace.
    target = contextlib.nullcontext(path) if output else draft_of(path)
    with target as written, written.open("w", encoding="utf-8", newline="") as file:
        file.write(text)
    print(path)
    return 0
