"""Statistics of repetitions: rate, reliability with its bound, learning, workload."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import List, Optional, Sequence, Tuple

CONFIDENCE = 0.8
"""Of the bound of reliability, as ASTM's test methods state it."""
FEWEST_FOR_LEARNING = 6
"""Repetitions, below which no learning curve is shown."""


def rate(times: Sequence[float]) -> Optional[float]:
    """Repetitions per minute, 60 n / sum T; None without any.

    Parameters
    ----------
    times : sequence of float
        Of the completed repetitions, with penalties (s).
    """
    total = sum(times)
    return 60.0 * len(times) / total if total > 0.0 else None


def completeness(completed: int, faults: int) -> Optional[float]:
    """Share of the repetitions that were completed; None without any."""
    return completed / (completed + faults) if completed + faults else None


def reliability_bound(count: int, faults: int, confidence: float = CONFIDENCE) -> Optional[float]:
    """One-sided lower bound of the reliability by Clopper and Pearson.

    The p for which ``P(X <= faults | count, 1 - p) = 1 - confidence``: with any lower reliability,
    so few faults would be less probable than that.

    Parameters
    ----------
    count : int
        Repetitions, with those that had a fault.

    Returns
    -------
    float or None
        None without repetitions; 0 where all had a fault.
    """
    if count <= 0:
        return None
    if faults >= count:
        return 0.0
    low, high = 0.0, 1.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        if _at_most(faults, count, 1.0 - middle) <= 1.0 - confidence:
            low = middle
        else:
            high = middle
    return low


def _at_most(faults: int, count: int, chance: float) -> float:
    """P(X <= faults) of a binomial distribution, faults < count."""
    if not 0.0 < chance < 1.0:
        return 1.0 - chance
    # Binomial coefficients of a thousand are beyond what a float can be; their logarithms are not.
    all_ways = math.lgamma(count + 1)
    return math.fsum(
        math.exp(
            all_ways
            - math.lgamma(k + 1)
            - math.lgamma(count - k + 1)
            + k * math.log(chance)
            + (count - k) * math.log1p(-chance)
        )
        for k in range(faults + 1)
    )


@dataclass(frozen=True)
class Learning:
    """A learning curve T_n = first * n**-slope, and what it predicts for the next repetition.

    The asymptote of a curve with three parameters cannot be estimated from so few repetitions.
    """

    first: float
    slope: float
    predicted: float


def learning(times: Sequence[float]) -> Optional[Learning]:
    """Fit a power law to the times of repetitions (s), by least squares of the logarithms.

    Returns
    -------
    Learning or None
        None below `FEWEST_FOR_LEARNING` repetitions, or where a time is not above 0.
    """
    count = len(times)
    if count < FEWEST_FOR_LEARNING or min(times) <= 0.0:
        return None
    x = [math.log(n) for n in range(1, count + 1)]
    y = [math.log(t) for t in times]
    mean_x, mean_y = sum(x) / count, sum(y) / count
    slope = sum((a - mean_x) * (b - mean_y) for a, b in zip(x, y)) / sum(
        (a - mean_x) ** 2 for a in x
    )
    first = math.exp(mean_y - slope * mean_x)
    return Learning(first, -slope, first * (count + 1) ** slope)


@dataclass(frozen=True)
class Cusum:
    """A CUSUM chart of failures.

    Attributes
    ----------
    step : float
        By which a success lowers the sum; a failure raises it by one less this.
    limit : float
        The sum's rise by it says that the failures are no longer acceptable, its fall that they
        are.
    sums : tuple of float
        After each attempt.
    """

    step: float
    limit: float
    sums: Tuple[float, ...]


def cusum(
    failures: Sequence[bool], acceptable: float, unacceptable: float, error: float = 0.1
) -> Cusum:
    """Make the CUSUM chart of attempts.

    Wald's sequential test of two failure rates, as surgery's learning curves use it (S. M.
    Williams, B. R. Parry, M. M. Schlup, Quality control: an application of the cusum, BMJ 304
    (1992)).

    Parameters
    ----------
    failures : sequence of bool
        Whether each attempt failed.
    acceptable, unacceptable : float
        Failure rates, above 0 and below 1; the latter is the greater.
    error : float
        Probability of each of the two wrong decisions.
    """
    worse = math.log(unacceptable / acceptable)
    better = math.log((1.0 - acceptable) / (1.0 - unacceptable))
    step = better / (worse + better)
    sums: List[float] = []
    for failed in failures:
        sums.append((sums[-1] if sums else 0.0) + (1.0 - step if failed else -step))
    return Cusum(step, math.log((1.0 - error) / error) / (worse + better), tuple(sums))


def raw_tlx(ratings: Sequence[float]) -> float:
    """Raw NASA-TLX: mean of the six ratings (0 to 100)."""
    return sum(ratings) / len(ratings)


def percentile(values: Sequence[float], share: float) -> float:
    """Return the value below which a share (0 to 1) of the values lies, by linear interpolation."""
    ordered = sorted(values)
    at = share * (len(ordered) - 1)
    low = int(at)
    high = min(low + 1, len(ordered) - 1)
    return ordered[low] + (at - low) * (ordered[high] - ordered[low])


def median(values: Sequence[float]) -> float:
    """Return the middle of the values."""
    return percentile(values, 0.5)
