"""Reproduces the paper's results, and writes ``report.html``.

Starts the simulator as run.sh does, works through its ROS interface, and ends with status 1 when a
result misses its bar. Ctrl-C ends everything that was started.
"""

from __future__ import annotations

import argparse
import shutil
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any, List, Optional, Sequence

from telex_experiments.rigs.report import machine

from ..workspace import ROOT
from .experiment import Experiment
from .page import ReportRun, page
from .registry import UnknownExperimentError, experiments, select
from .schedule import ExperimentOutcome, Schedule, planned

MISSED, MISUSED, INTERRUPTED = 1, 2, 130


class Clock:
    """Says lines with the time since the start; lanes share it."""

    def __init__(self) -> None:
        self._began = time.monotonic()
        self._lock = threading.Lock()

    def elapsed(self) -> float:
        """Wall time since the start (s)."""
        return time.monotonic() - self._began

    def say(self, line: str) -> None:
        """Print a line."""
        whole = round(self.elapsed())
        with self._lock:
            print(f"[{whole // 60:2d}:{whole % 60:02d}] {line}", flush=True)


def parse(arguments: Optional[Sequence[str]] = None) -> argparse.Namespace:
    """Read the command line; it ends the program when that is wrong."""
    parser = argparse.ArgumentParser(prog="reproduce_paper.sh", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="coarse: fewer runs, shorter paths")
    parser.add_argument(
        "--only", nargs="+", default=[], metavar="NAME", help="only these experiments, or groups"
    )
    parser.add_argument(
        "--out",
        type=Path,
        default=ROOT / "results",
        metavar="DIR",
        help="where the results go (results)",
    )
    parser.add_argument("--seed", type=int, default=1, help="of all that is random (1)")
    parser.add_argument(
        "--repeat",
        type=int,
        default=1,
        metavar="N",
        help="lead the paths of fig8_trajectories so often, every second time while something "
        "keeps all processors busy, and compare the joint states of the runs (1)",
    )
    parser.add_argument("--list", action="store_true", help="say which experiments there are")
    options = parser.parse_args(arguments)
    if options.seed < 0:
        parser.error(f"--seed {options.seed} is below 0")
    if options.repeat < 1:
        parser.error(f"--repeat {options.repeat} is below 1")
    return options


def version() -> str:
    """Return the commit, and whether the files differ from it; empty without git."""
    command = ["git", "-C", str(ROOT), "describe", "--always", "--dirty", "--abbrev=8"]
    try:
        answer = subprocess.run(command, capture_output=True, text=True, check=False)
    except OSError:
        return ""
    return f"commit {answer.stdout.strip()}" if answer.returncode == 0 else ""


def listing(found: Sequence[Experiment]) -> str:
    """Return the experiments as a list for people."""
    width = max(len(each.name) for each in found)
    return "\n".join(f"{e.name:{width}}  {e.paper}: {e.title} ({e.seconds:.0f} s)" for e in found)


def clear(folder: Path, chosen: Sequence[Experiment]) -> None:
    """Make place for what comes; what is of other experiments, or of nobody, stays."""
    folder.mkdir(parents=True, exist_ok=True)
    for experiment in chosen:
        shutil.rmtree(folder / experiment.name, ignore_errors=True)


def reproduce(options: argparse.Namespace) -> int:
    """Run the experiments, write the report; returns the exit status."""
    chosen = select(options.only)
    folder: Path = options.out.resolve()
    clear(folder, chosen)
    clock = Clock()
    expected = planned(chosen, options.quick, options.repeat)
    clock.say(f"{len(chosen)} experiments, about {max(1, round(expected / 60.0))} min; in {folder}")
    when = time.strftime("%Y-%m-%d %H:%M")
    schedule = Schedule(folder, options.quick, options.seed, clock.say, options.repeat)
    outcomes = schedule.run(chosen)
    run = ReportRun(when, machine(), version(), options.quick, options.seed, clock.elapsed())
    target = folder / "report.html"
    target.write_text(page(run, outcomes, folder), encoding="utf-8")
    return conclude(outcomes, target, clock)


def conclude(outcomes: Sequence[ExperimentOutcome], report: Path, clock: Clock) -> int:
    """Print a line for each result; returns the exit status."""
    width = max(len(outcome.experiment.name) for outcome in outcomes)
    print()
    for outcome in outcomes:
        verdict = "met" if outcome.result.ok else "MISSED"
        name = outcome.experiment.name
        print(f"  {name:{width}}  {verdict:6}  {outcome.seconds:4.0f} s  {outcome.experiment.bar}")
    print()
    clock.say(f"report: {report}")
    missed: List[str] = [o.experiment.name for o in outcomes if not o.result.ok]
    if missed:
        clock.say(f"missed: {', '.join(missed)}")
    return MISSED if missed else 0


def _interrupt(number: int, frame: Any) -> None:
    # Whoever presses Ctrl-C twice does not want half of it left running.
    for each in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(each, signal.SIG_IGN)
    print("\nEnding what was started ...", flush=True)
    raise KeyboardInterrupt


def main() -> None:
    """Run the program."""
    options = parse()
    for each in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(each, _interrupt)
    try:
        if options.list:
            print(listing(experiments()))
            return
        status = reproduce(options)
    except UnknownExperimentError as error:
        print(f"reproduce_paper.sh: {error}", file=sys.stderr)
        status = MISUSED
    except KeyboardInterrupt:
        status = INTERRUPTED
    sys.exit(status)


if __name__ == "__main__":
    main()
