"""The command ``rehearse``: trials of an exercise by the hundred, without wall time and ROS."""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections import defaultdict
from contextlib import nullcontext, redirect_stdout
from pathlib import Path
from typing import Any, Callable, Dict, List, Optional, Sequence, Tuple

from telex_control.common.params import ConfigError

from ..exercises.catalog import find_exercise
from ..exercises.exercise_file import ExerciseError, ExerciseFile, load_exercise
from ..recording.trial_file import SUFFIX, Trial
from ..recording.writer import RecordingError
from ..rehearsal.crew import CrewError, do_elsewhere, do_here, processors
from ..rehearsal.jobs import (
    SCRIPTED,
    Job,
    OperatorError,
    Rehearsed,
    exercise_digest,
    find_operator,
    rehearse_job,
    run,
    software_digest,
)
from ..rehearsal.line_port import line_setting
from ..rehearsal.outcomes import Change, Run, change, provisional, run_of, summarised, worst
from ..rehearsal.recorded import record
from ..rehearsal.store import SUMMARY, About, Store, StoreError

FOLDER = "~/.ros/telex_rehearsals"
OWN = "own"
"""Name of the line that the exercise asks for."""
_SEEDS = 20
_WORST = 5
_MOST_SEEDS = 100_000
_ERRORS = (
    ConfigError,
    CrewError,
    ExerciseError,
    OperatorError,
    RecordingError,
    StoreError,
    OSError,
)

Outcomes = Dict[Tuple[str, str], Dict[int, Rehearsed]]
"""By setting and line, then by seed."""


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Run the command; returns its exit status.

    0; 1 where trials could not be done; 2 where nothing could be; 130 when interrupted.
    """
    given = _parser().parse_args(arguments)
    try:
        return _rehearse(given)
    except _ERRORS as error:
        print(f"rehearse: {error}", file=sys.stderr)
        return 2


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="rehearse",
        description=__doc__,
        epilog="What is there already is not done again: an interrupted command goes on.",
    )
    parser.add_argument("exercise", metavar="EXERCISE", help="name, or path of a file")
    parser.add_argument(
        "--operator",
        default=SCRIPTED,
        metavar="WHO",
        help=f"{SCRIPTED} (default), or MODULE:FUNCTION",
    )
    parser.add_argument(
        "--seeds",
        type=_seeds,
        default=range(1, _SEEDS + 1),
        metavar="N|A-B",
        help=f"1 to N, or A to B; default {_SEEDS}",
    )
    parser.add_argument(
        "--settings",
        type=_names,
        default=[],
        metavar="NAMES",
        help="with commas between, or all; default: the first",
    )
    parser.add_argument(
        "--lines",
        type=_names,
        default=[OWN],
        metavar="NAMES",
        help="profiles of the line to the robot, with commas between, e.g. perfect,300; default: "
        f"{OWN}, what the exercise asks for",
    )
    parser.add_argument(
        "--workers",
        type=_count,
        default=processors(),
        metavar="N",
        help="processes; default: one for each processor",
    )
    parser.add_argument(
        "--scheduler",
        default="",
        metavar="ADDRESS",
        help="of dask.distributed, whose workers do it, e.g. tcp://10.0.0.5:8786",
    )
    parser.add_argument(
        "--out",
        type=Path,
        metavar="FOLDER",
        help=f"of the sheets; default: one for this exercise and software in {FOLDER}",
    )
    parser.add_argument(
        "--compare",
        type=Path,
        metavar="FOLDER",
        help="of an earlier campaign: say what has changed",
    )
    parser.add_argument(
        "--record",
        type=_count,
        default=0,
        metavar="N",
        help="write recordings of the N worst trials of each setting, for run.sh replay:=FILE",
    )
    parser.add_argument(
        "--factor",
        type=_factor,
        default=1.5,
        metavar="X",
        help="how much more time than the operator people are given in provisional pass values",
    )
    parser.add_argument(
        "--json",
        action="store_true",
        help="print the summary as JSON, and all else to standard error",
    )
    return parser


def _seeds(text: str) -> range:
    first, dash, last = text.partition("-")
    ends = (first, last) if dash else ("1", first)
    if not all(end.isdecimal() for end in ends) or not 1 <= int(ends[0]) <= int(ends[1]):
        raise argparse.ArgumentTypeError(f"'{text}'; N from 1, or A-B with 1 <= A <= B is needed")
    low, high = int(ends[0]), int(ends[1])
    if high - low >= _MOST_SEEDS:
        raise argparse.ArgumentTypeError(f"'{text}'; at most {_MOST_SEEDS} seeds are possible")
    return range(low, high + 1)


def _names(text: str) -> List[str]:
    return [name for name in text.split(",") if name]


def _count(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"'{text}'; a whole number from 1 is needed")
    return int(text)


def _factor(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0.1 <= value <= 100.0:
        raise argparse.ArgumentTypeError(f"'{text}'; a number from 0.1 to 100 is needed")
    return value


# --- the campaign --------------------------------------------------------------------------------


def _rehearse(given: argparse.Namespace) -> int:
    # Another process may have another working folder.
    file = load_exercise(find_exercise(given.exercise).absolute())
    settings = _settings(file, given.settings)
    find_operator(given.operator, file.first.name)
    for setting in settings:
        for line in given.lines:
            line_setting(file.setting(setting), "" if line == OWN else line)
    about = About(
        file.first.name, exercise_digest(file), given.operator, software_digest(given.operator)
    )
    before = None if given.compare is None else Store.open(given.compare.expanduser())
    folder = given.out or Path(FOLDER) / f"{about.exercise}-{about.sha256[:8]}-{about.software[:8]}"
    store = Store.begin(folder.expanduser(), about)
    jobs = [
        Job(str(file.path), file.text, setting, seed, given.operator, "" if line == OWN else line)
        for setting in settings
        for line in given.lines
        for seed in given.seeds
    ]
    left = [job for job in jobs if store.get(job.setting, job.line or OWN, job.seed) is None]
    progress = _Progress(len(jobs), len(jobs) - len(left), store)
    try:
        _do(left, given, progress.done)
    except KeyboardInterrupt:
        progress.end()
        print(f"{store.folder}: interrupted; the same command goes on there", file=sys.stderr)
        return 130
    progress.end()
    found: Outcomes = defaultdict(dict)
    for job in jobs:
        outcome = store.get(job.setting, job.line or OWN, job.seed)
        if outcome is not None:
            found[job.setting, job.line or OWN][job.seed] = outcome
    _report(given, store, found)
    # With --json, standard output has the summary alone.
    with redirect_stdout(sys.stderr) if given.json else nullcontext():
        _tell_more(given, file, store, found, before)
    return 1 if progress.problems else 0


def _tell_more(
    given: argparse.Namespace,
    file: ExerciseFile,
    store: Store,
    found: Outcomes,
    before: Optional[Store],
) -> None:
    if before is not None:
        _compare(before, found)
    if given.record:
        _record(given, file, store, found)


def _settings(file: ExerciseFile, names: Sequence[str]) -> List[str]:
    if not names:
        return [file.first.setting]
    if list(names) == ["all"]:
        return list(file.settings)
    return [file.setting(name).setting for name in dict.fromkeys(names)]


def _do(jobs: Sequence[Job], given: argparse.Namespace, done: Callable[..., None]) -> None:
    if not jobs:
        return
    if given.scheduler:
        do_elsewhere(jobs, run, given.scheduler, done, _warn)
    else:
        do_here(jobs, run, given.workers, done)


def _warn(text: str) -> None:
    print(f"rehearse: {text}", file=sys.stderr, flush=True)


class _Progress:
    """Keeps outcomes as they come, and says how far it is."""

    def __init__(self, total: int, kept: int, store: Store) -> None:
        self._total, self._at, self._kept, self._store = total, kept, kept, store
        self._began = time.monotonic()
        self._passed = self._shown = 0
        self._live = sys.stderr.isatty()
        self.problems: List[str] = []
        if kept:
            _warn(f"{kept} of {total} trials are there already ({store.folder})")

    def done(self, job: Job, outcome: Optional[Rehearsed], error: Optional[Exception]) -> None:
        """Take the outcome of a job, or why there is none."""
        self._at += 1
        if outcome is None:
            where = f"setting {job.setting!r}, line {job.line or OWN}, seed {job.seed}"
            problem = f"{where}: {type(error).__name__}: {error}"
            self.problems.append(problem)
            self.end()
            _warn(problem)
        else:
            self._store.put(job.setting, job.line or OWN, job.seed, outcome)
            self._passed += run_of(job.seed, outcome).passed
        share = 10 * self._at // self._total
        if self._live or share > self._shown:
            self._shown = share
            self._show()

    def _show(self) -> None:
        new = self._at - self._kept
        left = (time.monotonic() - self._began) / new * (self._total - self._at)
        text = (
            f"{self._at} of {self._total} trials, {self._passed} of {new} passed, "
            f"{_duration(left)} left"
        )
        if self._live:
            filled = 24 * self._at // self._total
            text = f"\r[{'#' * filled}{'.' * (24 - filled)}] {text}\033[K"
        print(text, end="" if self._live else "\n", file=sys.stderr, flush=True)

    def end(self) -> None:
        """Leave the progress bar's line."""
        if self._live and self._shown:
            print(file=sys.stderr, flush=True)


def _duration(seconds: float) -> str:
    if seconds < 90.0:
        return f"{seconds:.0f} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 5400.0 else f"{seconds / 3600.0:.1f} h"


# --- what is said of it --------------------------------------------------------------------------


def _report(given: argparse.Namespace, store: Store, found: Outcomes) -> None:
    summary: Dict[str, Any] = {"exercise": store.about.exercise, "operator": store.about.operator}
    summary["factor"] = given.factor
    summary["rows"] = []
    for key, outcomes in found.items():
        runs = [run_of(seed, outcome) for seed, outcome in sorted(outcomes.items())]
        row = summarised(key, runs)
        row["provisional"] = provisional(row["metrics"], given.factor)
        row["worst"] = [each.seed for each in worst(runs, _WORST)]
        summary["rows"].append(row)
        if not given.json:
            _print_row(row, runs, given.factor)
    text = json.dumps(summary, indent=1, sort_keys=True, ensure_ascii=False) + "\n"
    store.summarise(text)
    print(text if given.json else f"\nsheets and {SUMMARY}: {store.folder}", flush=True)


def _print_row(row: Dict[str, Any], runs: Sequence[Run], factor: float) -> None:
    share = row["passed"] / row["trials"]
    print(
        f"\n{row['setting']}, line {row['line']}: {row['passed']} of {row['trials']} passed, "
        f"{share:.0%} ({row['at_least']:.0%} to {row['at_most']:.0%}, each at "
        f"{row['confidence']:.0%} confidence)"
    )
    for name, each in row["metrics"].items():
        if each is not None:
            print(f"  {name}: median {each[2]:.4g}, 10 % {each[1]:.4g}, 90 % {each[3]:.4g}")
    for name, value in row["provisional"].items():
        print(f"  provisional pass value of {name}, {factor:g} times the 90 %: {value:g}")
    for each in worst(runs, _WORST):
        took = "" if each.seconds is None else f" {each.seconds:.1f} s"
        print(f"  seed {each.seed}:{took} {'passed' if each.passed else each.why}")


def _compare(before: Store, found: Outcomes) -> None:
    old: Outcomes = defaultdict(dict)
    for setting, line, seed, outcome in before.all():
        old[setting, line][seed] = outcome
    print(f"\ncompared with {before.folder}")
    shared = [key for key in found if key in old]
    if not shared:
        print("  it has none of these settings")
    for key in shared:
        _print_change(change(key, old[key], found[key]))


def _print_change(each: Change) -> None:
    print(
        f"  {each.setting}, line {each.line}: passed {each.passed[0]} of {each.trials[0]} before, "
        f"{each.passed[1]} of {each.trials[1]} now (p = {each.chance:.3g})"
    )
    if each.seconds is not None:
        print(
            f"    median time {each.seconds.value:+.2f} s "
            f"({each.seconds.low:+.2f} to {each.seconds.high:+.2f}, 95 %)"
        )
    print(f"    sheets that differ: {each.sheets}")
    if each.differing:
        print(f"    other verdict: seed {', '.join(map(str, each.differing))}")


def _record(given: argparse.Namespace, file: ExerciseFile, store: Store, found: Outcomes) -> None:
    for (setting, line), outcomes in found.items():
        runs = [run_of(seed, outcome) for seed, outcome in sorted(outcomes.items())]
        for each in worst(runs, given.record):
            own = "" if line == OWN else line
            job = Job(str(file.path), file.text, setting, each.seed, given.operator, own)
            trial, _ = rehearse_job(job)
            name = f"rehearsal_{store.about.exercise}_{setting}_{line}_{each.seed}"
            about = Trial(
                name,
                job.path,
                setting,
                "practice",
                "script",
                store.about.software[:12],
                each.seed,
            )
            path = store.folder / f"{name}{SUFFIX}"
            print(record(path, about, file.text, trial), flush=True)
