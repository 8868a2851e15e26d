"""What the benchmarks share: their command line, their table and their JSON."""

from __future__ import annotations

import argparse
import json
import os
import platform
import sys
from dataclasses import dataclass
from typing import List, Optional


@dataclass(frozen=True)
class Figure:
    """One measured figure.

    Attributes
    ----------
    name, unit : str
    value : float
    at_least, at_most : float, optional
        What is required of it.
    """

    name: str
    value: float
    unit: str = ""
    at_least: Optional[float] = None
    at_most: Optional[float] = None

    @property
    def required(self) -> str:
        """The requirement as text; empty when there is none."""
        if self.at_least is not None:
            return f">= {self.at_least:g}"
        return f"<= {self.at_most:g}" if self.at_most is not None else ""

    @property
    def ok(self) -> bool:
        """Whether the requirement is met."""
        if self.at_least is not None and not self.value >= self.at_least:
            return False
        return self.at_most is None or self.value <= self.at_most


def arguments(description: str) -> argparse.Namespace:
    """Read the command line that all benchmarks have: --quick, --json FILE."""
    return read_arguments(argparse.ArgumentParser(description=description))


def read_arguments(parser: argparse.ArgumentParser) -> argparse.Namespace:
    """Add what all benchmarks have to a parser, and read the command line with it."""
    parser.add_argument("--quick", action="store_true", help="a coarse answer in under a minute")
    parser.add_argument("--json", metavar="FILE", help="write the figures to FILE as well")
    return parser.parse_args()


def machine() -> str:
    """Processor, cores and Python, in words."""
    model = "unknown processor"
    with open("/proc/cpuinfo") as file:
        for line in file:
            if line.startswith("model name"):
                model = line.split(":", 1)[1].strip()
                break
    return f"{model}, {os.cpu_count()} cores, Python {platform.python_version()}"


def finish(title: str, figures: List[Figure], json_file: Optional[str]) -> None:
    """Print the table, write the JSON, and end with status 1 when a requirement is missed."""
    print(f"\n{title}\n{machine()}\n")
    print("| figure | measured | unit | required | |\n|---|---|---|---|---|")
    for figure in figures:
        verdict = "" if not figure.required else ("ok" if figure.ok else "MISSED")
        cells = (figure.name, f"{figure.value:.4g}", figure.unit, figure.required, verdict)
        print(f"| {' | '.join(cells)} |")
    if json_file:
        content = {
            "figures": {
                figure.name: {
                    "value": figure.value,
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
    sys.exit(0 if all(figure.ok for figure in figures) else 1)
