"""CPU time of the parts of the control cycle."""

from __future__ import annotations

import time
from typing import Dict, List, Tuple

SAMPLED = 7
"""One step in so many is measured, for to ask for the time costs more than some phases. What recurs
every 2, 5, 8, 10, 25 or 50 steps has its share of them."""

PHASES = ("read", "update", "write", "traction", "mechanisms", "step", "publish", "proximity")


class PhaseTimer:
    """Adds up the CPU time of the calling thread between marks, by phase, in some of the steps."""

    def __init__(self) -> None:
        self._totals: Dict[str, int] = dict.fromkeys(PHASES, 0)
        self._cycles = 0
        self._mark = 0
        self._steps = -1
        self._measures = True

    def begin(self) -> None:
        """A step begins: start the clock."""
        self._steps += 1
        self._measures = self._steps % SAMPLED == 0
        if self._measures:
            self._mark = time.thread_time_ns()

    def end(self, phase: str) -> None:
        """Count the time since the last call to `phase`, and go on."""
        if not self._measures:
            return
        now = time.thread_time_ns()
        self._totals[phase] += now - self._mark
        self._mark = now

    def count_cycle(self) -> None:
        """One control cycle is over."""
        self._cycles += self._measures

    def take_means(self) -> List[Tuple[str, float]]:
        """Mean CPU time (s) per cycle of each phase since the last call."""
        cycles = max(self._cycles, 1)
        means = [(phase, total * 1e-9 / cycles) for phase, total in self._totals.items()]
        self._totals = dict.fromkeys(PHASES, 0)
        self._cycles = 0
        return means
