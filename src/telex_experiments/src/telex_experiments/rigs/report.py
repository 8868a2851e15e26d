"""Common parts of the benchmarks: command line, table and JSON."""

from __future__ import annotations

import argparse
import json
import math
import os
import platform
import signal
import sys
import time
from dataclasses import dataclass
from typing import Callable, List, Optional

from telex_training.rehearsal.processor import processor

PATIENCE = 400.0
"""Longest wait (s) for anything to happen, on a machine that is busy with something else."""


class MeasurementError(RuntimeError):
    """Nothing can be measured; the message says why."""


@dataclass(frozen=True)
class Figure:
    """One measured figure.

    Attributes
    ----------
    at_least, at_most : float, optional
        What is required of it.
    goal : float, optional
        What it is to come to beyond that; nothing fails without it.
    """

    name: str
    value: float
    unit: str = ""
    at_least: Optional[float] = None
    at_most: Optional[float] = None
    goal: Optional[float] = None

    @property
    def required(self) -> str:
        """The requirement as text; empty when there is none."""
        goal = "" if self.goal is None else f", goal {self.goal:.4g}"
        if self.at_least is not None:
            return f">= {self.at_least:.4g}{goal}"
        return f"<= {self.at_most:.4g}{goal}" if self.at_most is not None else ""

    @property
    def ok(self) -> bool:
        """Whether the requirement is met."""
        if self.at_least is not None and not self.value >= self.at_least:
            return False
        return self.at_most is None or self.value <= self.at_most


def arguments(description: str) -> argparse.Namespace:
    """Read the command line that all benchmarks have: --quick, --smoke, --json FILE."""
    return read_arguments(argparse.ArgumentParser(description=description))


def read_arguments(parser: argparse.ArgumentParser) -> argparse.Namespace:
    """Add what all benchmarks have to a parser, and read the command line with it.

    A benchmark that is asked to end (SIGTERM) ends what it has started.
    """
    parser.add_argument("--quick", action="store_true", help="a coarse answer in under a minute")
    parser.add_argument(
        "--smoke", action="store_true", help="one sample of each part, none of them judged"
    )
    parser.add_argument("--json", metavar="FILE", help="write the figures to FILE as well")
    options = parser.parse_args()
    options.quick = options.quick or options.smoke
    signal.signal(signal.SIGTERM, lambda number, frame: sys.exit(128 + number))
    return options


def quantile(values: List[float], share: float) -> float:
    """Return the value that a share of all stay at or below; NaN if there are none."""
    return sorted(values)[min(int(len(values) * share), len(values) - 1)] if values else math.nan


def wait_until(
    what: str, condition: Callable[[], object], timeout: float = PATIENCE, period: float = 0.01
) -> None:
    """Wait until a condition holds, which is asked for at a period (s).

    Raises
    ------
    MeasurementError
        It does not within `timeout` (s).
    """
    end = time.monotonic() + timeout
    while not condition():
        if time.monotonic() > end:
            raise MeasurementError(f"not within {timeout:g} s: {what}")
        time.sleep(period)


def machine() -> str:
    """Processor, cores and Python, in words."""
    return f"{processor()}, {os.cpu_count()} cores, Python {platform.python_version()}"


def finish(
    title: str, figures: List[Figure], json_file: Optional[str], judged: bool = True
) -> None:
    """Print the table, write the JSON, and end with status 1 when a requirement is missed.

    What is not `judged` was too short to tell anything.
    """
    print(f"\n{title}\n{machine()}\n")
    print("| figure | measured | unit | required | |\n|---|---|---|---|---|")
    for figure in figures:
        verdict = ("ok" if figure.ok else "MISSED") if judged and figure.required else ""
        cells = (figure.name, f"{figure.value:.4g}", figure.unit, figure.required, verdict)
        print(f"| {' | '.join(cells)} |")
    if json_file:
        content = {
            "figures": {
                figure.name: {
                    "value": figure.value if math.isfinite(figure.value) else None,
                    "unit": figure.unit,
                    "required": figure.required,
                    "ok": figure.ok,
                }
                for figure in figures
            },
            "machine": machine(),
        }
        with open(json_file, "w") as file:
            json.dump(content, file, indent=2)
    sys.exit(0 if not judged or all(figure.ok for figure in figures) else 1)
