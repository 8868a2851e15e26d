"""Statistics and smoothness against published values."""

from __future__ import annotations

import math

import numpy as np
import pytest

from telex_training.judging import stats
from telex_training.judging.records.smoothness import mean_sparc, sparc, sub_movements


def reach(duration=1.0, length=0.3, rate=50.0):
    """Speeds of a minimum-jerk movement (Flash and Hogan 1985)."""
    share = np.arange(0.0, duration + 1e-9, 1.0 / rate) / duration
    return length / duration * 30.0 * share**2 * (1.0 - share) ** 2


@pytest.mark.parametrize(
    ("count", "faults", "bound"),
    # ASTM's tables for a confidence of 80 %, as quoted for 10 to 30 repetitions.
    [(10, 0, 0.851), (10, 1, 0.729), (20, 1, 0.858), (30, 0, 0.948), (30, 3, 0.824)],
)
def test_reliability_has_the_bound_of_the_standards_tables(count, faults, bound):
    assert stats.reliability_bound(count, faults) == pytest.approx(bound, abs=6e-4)


def test_the_bound_of_no_fault_is_a_root_and_29_are_needed():
    assert stats.reliability_bound(7, 0, 0.95) == pytest.approx(0.05 ** (1 / 7))
    assert stats.reliability_bound(28, 0, 0.95) < 0.9 <= stats.reliability_bound(29, 0, 0.95)
    assert stats.reliability_bound(5, 5) == 0.0
    assert stats.reliability_bound(0, 0) is None


def test_bounds_of_thousands_have_no_number_that_is_too_large():
    # Of so many, a normal distribution is near enough: 0.9 less 0.84 standard deviations.
    assert stats.reliability_bound(10_000, 1_000) == pytest.approx(0.8975, abs=3e-4)
    assert stats.reliability_bound(1_100, 1_095) < 0.01
    assert stats.reliability_bound(100_000, 0) == pytest.approx(0.2**1e-5, abs=1e-9)


def test_rate_and_completeness():
    assert stats.rate([20.0, 40.0]) == pytest.approx(2.0)
    assert stats.rate([]) is None
    assert stats.completeness(9, 1) == pytest.approx(0.9)
    assert stats.completeness(0, 0) is None


def test_learning_finds_the_power_law_from_six_repetitions_on():
    times = [120.0 * n**-0.4 for n in range(1, 9)]
    found = stats.learning(times)
    assert found.first == pytest.approx(120.0)
    assert found.slope == pytest.approx(0.4)
    assert found.predicted == pytest.approx(120.0 * 9**-0.4)
    assert stats.learning(times[:5]) is None


def test_cusum_has_the_published_step_and_limit():
    # Acceptable 5 %, unacceptable 10 %, both errors 10 %: step 0.07, limits 2.94.
    chart = stats.cusum([True, False], 0.05, 0.10)
    assert chart.step == pytest.approx(0.0724, abs=1e-4)
    assert chart.limit == pytest.approx(2.94, abs=0.01)
    assert chart.sums == pytest.approx((0.9276, 0.8552), abs=1e-4)


def test_raw_tlx_and_percentiles():
    assert stats.raw_tlx([0, 100, 50, 50, 20, 80]) == 50.0
    assert stats.median([3.0, 1.0, 2.0]) == 2.0
    assert stats.percentile([0.0, 1.0], 0.95) == pytest.approx(0.95)


def test_sparc_of_a_minimum_jerk_movement():
    # The figure of the measure's authors for a minimum-jerk movement is -1.4 whatever its duration;
    # no spectrum that falls from 1 to 0.05 over the unit band has an arc below sqrt(1 + 0.95^2).
    for duration in (0.6, 1.0, 2.0):
        value = sparc(reach(duration))
        assert -1.42 < value < -1.395
        assert value < -math.hypot(1.0, 0.95)


def test_sparc_does_not_depend_on_size_and_falls_with_every_submovement():
    one = sparc(reach())
    assert sparc(3.0 * reach()) == pytest.approx(one)
    two = np.concatenate([reach(), reach()])
    jerky = reach() * (1.0 + 0.5 * np.sin(2.0 * np.pi * 6.0 * np.arange(51) / 50.0))
    assert sparc(two) < one - 0.3
    assert sparc(jerky) < one - 0.2


def test_pauses_between_movements_do_not_count():
    values = []
    for pause in (0.5, 1.0, 3.0, 10.0):
        rest = np.zeros(round(50 * pause))
        values.append(mean_sparc(np.concatenate([reach(), rest, reach(), rest, reach()]).tolist()))
    assert max(values) - min(values) < 1e-9
    assert values[0] == pytest.approx(sparc(reach()), abs=0.05)
    assert mean_sparc([0.0] * 100) is None


def test_sub_movements_join_short_gaps_and_leave_short_moves_out():
    move, gap, short = [0.1] * 20, [0.0] * 4, [0.1] * 10
    assert sub_movements(move + gap + move) == [(0, 44)]
    assert sub_movements(move + [0.0] * 5 + move) == [(0, 20), (25, 45)]
    assert sub_movements(short + [0.0] * 50) == []
