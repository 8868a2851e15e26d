"""Statistics of learning and of groups: forecast with its band, bootstrap, exact test."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import List, Optional, Sequence, Tuple

import numpy as np

from ..judging.stats import CONFIDENCE, learning, median

AHEAD = 10
"""Repetitions after the last one, up to which a learning curve predicts."""
RESAMPLES = 10_000
GROUP_CONFIDENCE = 0.95
"""Of the interval of a difference between two groups."""
_SEED = 20_001
"""Of the bootstrap: the same people give the same interval."""


@dataclass(frozen=True)
class CurvePoint:
    """A learning curve at one repetition (s).

    Attributes
    ----------
    number : int
        Of the repetition, from 1.
    expected, low, high : float
        What the curve says, and the ends of the band in which that repetition's time lies with the
        confidence `CONFIDENCE`.
    """

    number: int
    expected: float
    low: float
    high: float


def curve(
    times: Sequence[float], ahead: int = AHEAD, confidence: float = CONFIDENCE
) -> Optional[Tuple[CurvePoint, ...]]:
    """Fit a power law to the times of repetitions, and say where the next ones will lie.

    The band is the prediction interval of the least-squares line through the logarithms, by
    Student's distribution with n - 2 degrees of freedom.

    Parameters
    ----------
    times : sequence of float
        Of completed repetitions, in their order (s).
    ahead : int
        Repetitions after the last one to predict.
    confidence : float
        Of the band.

    Returns
    -------
    tuple of CurvePoint or None
        From repetition 1 to the last predicted one; None below `stats.FEWEST_FOR_LEARNING`
        repetitions, or where a time is not above 0.
    """
    fitted = learning(times)
    if fitted is None:
        return None
    count = len(times)
    x = np.log(np.arange(1, count + 1))
    rest = np.log(times) - (math.log(fitted.first) - fitted.slope * x)
    spread = math.sqrt(float(rest @ rest) / (count - 2))
    factor = student_quantile(0.5 + 0.5 * confidence, count - 2) * spread
    mean, width = float(x.mean()), float(((x - x.mean()) ** 2).sum())
    made = []
    for number in range(1, count + ahead + 1):
        at = math.log(number)
        expected = math.log(fitted.first) - fitted.slope * at
        half = factor * math.sqrt(1.0 + 1.0 / count + (at - mean) ** 2 / width)
        made.append(
            CurvePoint(
                number, math.exp(expected), math.exp(expected - half), math.exp(expected + half)
            )
        )
    return tuple(made)


def student_quantile(share: float, freedom: int) -> float:
    """Quantile of Student's distribution.

    Parameters
    ----------
    share : float
        Above 0 and below 1.
    freedom : int
        Degrees of freedom, from 1.
    """
    if share < 0.5:
        return -student_quantile(1.0 - share, freedom)
    low, high = 0.0, 1.0
    while _student_below(high, freedom) < share:
        high *= 2.0
    for _ in range(80):
        middle = 0.5 * (low + high)
        if _student_below(middle, freedom) < share:
            low = middle
        else:
            high = middle
    return low


def _student_below(value: float, freedom: int) -> float:
    """P(T <= value) for a value from 0 and whole degrees of freedom, by its finite series."""
    angle = math.atan2(value, math.sqrt(freedom))
    sine, cosine = math.sin(angle), math.cos(angle)
    term = cosine if freedom % 2 else 1.0
    total = 0.0 if freedom == 1 else term
    for k in range(2 + freedom % 2, freedom - 1, 2):
        term *= cosine * cosine * (k - 1) / k
        total += term
    inside = (angle + sine * total) * 2.0 / math.pi if freedom % 2 else sine * total
    return 0.5 + 0.5 * inside


@dataclass(frozen=True)
class Difference:
    """Difference of two groups' medians, second less first, with its bootstrap interval."""

    value: float
    low: float
    high: float


def difference_of_medians(first: Sequence[float], second: Sequence[float]) -> Optional[Difference]:
    """Compare two groups by their medians.

    The interval is the percentile bootstrap's: both groups are drawn anew with replacement. With
    very few values it is too narrow, which is why n belongs beside it.

    Parameters
    ----------
    first, second : sequence of float
        One value for each person.

    Returns
    -------
    Difference or None
        None where a group has fewer than two values.
    """
    if min(len(first), len(second)) < 2:
        return None
    numbers = np.random.default_rng(_SEED)
    medians = []
    for values in (first, second):
        given = np.asarray(values, dtype=float)
        drawn = given[numbers.integers(0, len(given), (RESAMPLES, len(given)))]
        medians.append(np.median(drawn, axis=1))
    edge = 50.0 * (1.0 - GROUP_CONFIDENCE)
    low, high = np.percentile(medians[1] - medians[0], [edge, 100.0 - edge])
    return Difference(median(second) - median(first), float(low), float(high))


def fisher(passed: Tuple[int, int], failed: Tuple[int, int]) -> float:
    """Fisher's exact test, two-sided: probability of a table at least as improbable as this one.

    Parameters
    ----------
    passed, failed : tuple of int
        Of the first and the second group.

    Returns
    -------
    float
        1 where a row or a column is empty.
    """
    first, second = passed[0] + failed[0], passed[1] + failed[1]
    good = sum(passed)
    ways: List[int] = [
        math.comb(first, k) * math.comb(second, good - k)
        for k in range(max(0, good - second), min(first, good) + 1)
    ]
    own = math.comb(first, passed[0]) * math.comb(second, passed[1])
    # Whole numbers: equally probable tables are equal to the last digit.
    return sum(way for way in ways if way <= own) / sum(ways)
