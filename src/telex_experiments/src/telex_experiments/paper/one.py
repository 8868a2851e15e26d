"""Carries out one experiment, in a process of its own.

``python -m telex_experiments.paper.one NAME FOLDER SEED [--quick] [--repeat N]``: what it says goes
to standard output, a line at a time; what it yields to ``result.json`` in the folder.
"""

from __future__ import annotations

import argparse
import os
import signal
import sys
import traceback
from pathlib import Path
from typing import Any, TextIO

from telex_control.common.scheduling import add_niceness

from .experiment import Experiment, Result, missing
from .registry import by_name
from .session import PaperSession

RESULT = "result.json"
NICENESS = 15
"""Of experiments that compute only: what drives a simulator comes first."""


def carry_out(experiment: Experiment, session: PaperSession) -> Result:
    """Run an experiment; what it raises becomes its error."""
    try:
        if not experiment.in_wall_time:
            return experiment.run(session)
        with session:
            return experiment.run(session)
    except Exception as error:
        traceback.print_exc()
        return missing(f"{type(error).__name__}: {error}")


def _end(number: int, frame: Any) -> None:
    raise KeyboardInterrupt


def main() -> None:
    """Run the program."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("name")
    parser.add_argument("folder", type=Path)
    parser.add_argument("seed", type=int)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--repeat", type=int, default=1)
    options = parser.parse_args()
    # A shell starts background jobs deaf to SIGINT; this one must hear it, and end what it started.
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, _end)
    # Libraries print, too: what they say belongs into the log.
    with os.fdopen(os.dup(sys.stdout.fileno()), "w") as progress:
        os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
        sys.exit(_work(options, progress))


def _work(options: argparse.Namespace, progress: TextIO) -> int:
    """Carry out what the command line says; returns the exit status."""
    experiment = by_name(options.name)
    session = PaperSession(
        experiment.name,
        options.folder,
        options.quick,
        options.seed,
        lambda line: print(line, file=progress, flush=True),
        options.repeat,
    )
    if not experiment.in_wall_time:
        add_niceness(NICENESS)
    try:
        result = carry_out(experiment, session)
    except KeyboardInterrupt:
        return 130
    (options.folder / RESULT).write_text(result.as_json(), encoding="utf-8")
    return 0


if __name__ == "__main__":
    main()
