"""Detail of previews and size of full pictures, by the load of what renders."""

from __future__ import annotations

import math
from typing import NamedTuple


class SizeStep(NamedTuple):
    """How far pictures give way.

    Attributes
    ----------
    scale : float
        Of the width and height of full pictures.
    preview_detail : float
        Factor on the pixels that are drawn for one of a preview, along each axis.
    coarse_previews, coarse : bool
        Whether previews, and full pictures, are drawn with coarser shapes.
    shadow_spacing : float
        Factor on the time between shadows.
    """

    scale: float
    preview_detail: float
    coarse_previews: bool
    coarse: bool
    shadow_spacing: float


# Previews first; full pictures are as small as previews in the end.
STEPS = (
    SizeStep(1.0, 1.0, False, False, 1.0),
    SizeStep(1.0, 0.75, True, False, 2.0),
    SizeStep(0.75, 0.75, True, False, 2.0),
    SizeStep(0.5, 0.75, True, True, 4.0),
    SizeStep(0.4, 0.6, True, True, 6.0),
)

# Full pictures in more than their size, where there is time to spare; the largest first.
_LARGER = (SizeStep(2.0, 1.0, False, False, 1.0), SizeStep(1.5, 1.0, False, False, 1.0))

# Time over which is judged (s), and how many of them in a row make pictures smaller, or larger.
_PERIOD = 1.0
_TOO_BUSY_FOR, _AT_EASE_FOR = 2, 5

# Making pictures larger is tried ever more seldom where it was too much, at most after so many
# periods.
_MOST_PATIENCE = 80

# Share of the time that is spent drawing: from the one on there is no time left for previews that
# fall behind (the rest goes by waiting for poses), below the other there is enough for larger
# pictures.
_FULL, _EASY = 0.88, 0.75

# Previews may fall to this share of their rate before pictures lose detail; from the other on, they
# lose two steps of it at once.
_LEAST_PREVIEWS, _FAR_BEHIND = 0.9, 0.75


class SizeByLoad:
    """Has pictures lose detail, then size, while previews fall behind for want of time.

    Parameters
    ----------
    smallest
        Least scale of width and height of full pictures; 1: none gives way.
    largest
        Largest scale of full pictures, where there is time to spare; 1: none grows.
    """

    def __init__(self, smallest: float, largest: float = 1.0) -> None:
        given = [step for step in STEPS if step.scale >= smallest]
        if smallest >= 1.0:
            given = given[:1]
        larger = [step for step in _LARGER if step.scale <= largest]
        self._steps = [*larger, *given]
        self._number = len(larger)
        self._patience = _AT_EASE_FOR
        self._since_larger = _MOST_PATIENCE
        self._streak = 0
        # Since when: time without work (s), previews, and the least rate that was asked.
        self._began = -math.inf
        self._rest, self._previews, self._asked = 0.0, 0, math.inf

    @property
    def step(self) -> SizeStep:
        """How far pictures give way at present."""
        return self._steps[self._number]

    def rested(self, seconds: float) -> None:
        """Tell of time in which there was nothing to draw (s)."""
        self._rest += seconds

    def shown(self) -> None:
        """Tell of a preview."""
        self._previews += 1

    def judge(self, now: float, asked: float) -> None:
        """Choose anew; to be called often.

        Parameters
        ----------
        now
            Monotonic time (s).
        asked
            Previews per second that are wanted; 0 where nobody watches any.
        """
        self._asked = min(self._asked, asked)
        passed = now - self._began
        if passed < _PERIOD:
            return
        # After a long silence, this would tell nothing.
        if passed < 2.0 * _PERIOD:
            asked = self._asked * passed
            behind = self._previews < _LEAST_PREVIEWS * asked
            far = self._previews < _FAR_BEHIND * asked
            self._weigh(1.0 - self._rest / passed, behind, 2 if far else 1)
        self._begin(now)

    def _begin(self, now: float) -> None:
        self._began = now
        self._rest, self._previews, self._asked = 0.0, 0, math.inf

    def _easy(self) -> float:
        """Share of the time below which the next larger step will probably fit into it."""
        larger = self._steps[max(self._number - 1, 0)].scale
        growth = larger / self.step.scale if larger > 1.0 else 1.0
        return _EASY / growth**2

    def _weigh(self, busy: float, behind: bool, stride: int) -> None:
        self._since_larger += 1
        # What is larger than asked for gives way before anything falls behind.
        behind = behind or self.step.scale > 1.0
        verdict = 1 if busy > _FULL and behind else -1 if busy < self._easy() else 0
        if not verdict:
            self._streak = 0
            return
        # So many periods in a row: too busy where positive, at ease where negative.
        self._streak = verdict if self._streak * verdict < 0 else self._streak + verdict
        if self._streak >= _TOO_BUSY_FOR and self._number < len(self._steps) - 1:
            if self._since_larger < _MOST_PATIENCE:
                self._patience = min(2 * self._patience, _MOST_PATIENCE)
            self._number = min(self._number + stride, len(self._steps) - 1)
            self._streak = 0
        elif -self._streak >= self._patience and self._number:
            self._number -= 1
            self._streak = self._since_larger = 0
