"""Findings of a check, and how a command line tells them."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Sequence


@dataclass(frozen=True)
class Finding:
    """What a check found.

    Attributes
    ----------
    wrong : bool
        Otherwise it is worth knowing, and no more.
    """

    where: str
    text: str
    wrong: bool = True

    def __str__(self) -> str:
        return f"{'' if self.wrong else 'note: '}{self.where}: {self.text}"


def print_findings(path: Path, findings: Sequence[Finding], fine: str) -> bool:
    """Print what was found in a file, or that all is fine, with `fine`; return which."""
    for finding in findings:
        print(f"{path}: {finding}", file=sys.stderr if finding.wrong else sys.stdout)
    is_fine = not any(finding.wrong for finding in findings)
    if is_fine:
        print(f"{path}: OK, {fine}")
    return is_fine
