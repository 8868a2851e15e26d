"""CPU time of the parts of the control cycle."""

from __future__ import annotations

import time
from typing import Dict, List, Tuple

PHASES = ("read", "update", "write", "traction", "mechanisms", "step", "publish", "proximity")


class PhaseTimer:
    """Adds up the CPU time of the calling thread between marks, by phase."""

    def __init__(self) -> None:
        self._totals: Dict[str, int] = dict.fromkeys(PHASES, 0)
        self._cycles = 0
        self._mark = 0

    def begin(self) -> None:
        """Start the clock."""
        self._mark = time.thread_time_ns()

    def end(self, phase: str) -> None:
        """Count the time since the last call to `phase`, and go on."""
        now = time.thread_time_ns()
        self._totals[phase] += now - self._mark
        self._mark = now

    def count_cycle(self) -> None:
        """One control cycle is over."""
        self._cycles += 1

    def take_means(self) -> List[Tuple[str, float]]:
        """Mean CPU time (s) per cycle of each phase since the last call."""
        cycles = max(self._cycles, 1)
        means = [(phase, total * 1e-9 / cycles) for phase, total in self._totals.items()]
        self._totals = dict.fromkeys(PHASES, 0)
        self._cycles = 0
        return means
