"""Everything that is measured of one robot in a repetition."""

from __future__ import annotations

from typing import Any, Dict, FrozenSet, List, NamedTuple, Optional, Tuple

from ...exercises.model import Exercise, Metric
from ..activity import ActivityRecord
from ..conditions import Context
from .contacts import ContactRecord
from .handling import HandlingRecord
from .motion import BalanceRecord, MotionRecord

_CONTACTS = ("contacts", "peak_force", "impulse", "pushing")
_MOTION = (
    "base_path",
    "tool_path",
    "base_path_ratio",
    "tool_path_ratio",
    "reversals",
    "sparc",
    "move_and_wait",
)
_BALANCE = ("margin", "caution", "tips")
Happening = Tuple[str, str, Dict[str, Any]]
"""An event without its time: kind, name, details."""


class RobotRecord(NamedTuple):
    """What a robot touched, held and did since the repetition began, and what was commanded."""

    contacts: ContactRecord
    handling: HandlingRecord
    motion: MotionRecord
    balance: BalanceRecord
    activity: ActivityRecord

    @classmethod
    def of(
        cls, exercise: Exercise, goals: Dict[str, FrozenSet[str]], activity: ActivityRecord
    ) -> RobotRecord:
        """Begin the record of a repetition.

        Parameters
        ----------
        goals : dict of str to frozenset of str
            See `handling.goal_zones`.
        activity : ActivityRecord
            Lasts beyond it.
        """
        return cls(
            ContactRecord(exercise.contacts),
            HandlingRecord(goals, [metric.height for metric in exercise.metrics]),
            MotionRecord(),
            BalanceRecord(),
            activity,
        )

    def sample(self, context: Context, span: float, steps: int) -> List[Happening]:
        """Take a sample, `span` (s) and a number of physics steps after the one before."""
        world, time = context.world, context.time
        happened: List[Happening] = [
            ("contact", f"{new['group']} {new['object']}", new)
            for new in self.contacts.sample(world, time, span, steps)
        ]
        happened += [("drop", name, {}) for name in self.handling.sample(context, span)]
        self.motion.sample(world, time, span)
        if self.balance.sample(world, time, span):
            happened.append(("tipped", "", {}))
        self.activity.sample(time, span)
        return happened

    def figure(self, metric: Metric) -> Optional[float]:
        """Measure a metric; None where it could not be measured."""
        kind = metric.kind
        if kind in _CONTACTS:
            return self.contacts.figure(kind, metric.object)
        if kind in ("drops", "slip"):
            return self.handling.figure(kind, metric.object, metric.height)
        if kind in _MOTION:
            return self.motion.figure(kind, metric.length)
        if kind in _BALANCE:
            return self.balance.figure(kind)
        return self.activity.figure(kind)
