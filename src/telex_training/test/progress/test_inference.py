"""Statistics of learning and of groups, against published and independently computed values."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from telex_training.progress.inference import curve, difference_of_medians, fisher, student_quantile


class TestStudent:
    @pytest.mark.parametrize(
        ("share", "freedom", "table"),
        [  # the usual table of critical values
            (0.9, 1, 3.078),
            (0.975, 1, 12.706),
            (0.9, 2, 1.886),
            (0.95, 3, 2.353),
            (0.9, 4, 1.533),
            (0.975, 4, 2.776),
            (0.975, 5, 2.571),
            (0.99, 7, 2.998),
            (0.975, 8, 2.306),
            (0.995, 10, 3.169),
            (0.975, 30, 2.042),
            (0.95, 120, 1.658),
        ],
    )
    def test_its_quantiles_are_those_of_the_tables(self, share, freedom, table):
        assert student_quantile(share, freedom) == pytest.approx(table, abs=6e-4)

    def test_it_is_symmetric(self):
        assert student_quantile(0.1, 4) == -student_quantile(0.9, 4)


class TestCurve:
    def test_there_is_none_below_six_repetitions(self):
        assert curve([60.0, 50.0, 45.0, 40.0, 38.0]) is None

    def test_a_power_law_is_continued_exactly(self):
        points = curve([100.0 * n**-0.3 for n in range(1, 9)])
        assert len(points) == 18
        assert points[-1].number == 18
        assert points[-1].expected == pytest.approx(100.0 * 18**-0.3)
        assert points[-1].high - points[-1].low < 1e-6

    def test_its_band_is_that_of_the_regression_of_the_logarithms(self):
        times = [60.0, 52.0, 55.0, 41.0, 44.0, 39.0, 40.0]
        point = curve(times, ahead=10, confidence=0.8)[-1]
        # by the normal equations of the design matrix, with the table's t(0.9, 5) = 1.476
        design = np.column_stack([np.ones(7), np.log(np.arange(1, 8))])
        found, rest, _, _ = np.linalg.lstsq(design, np.log(times), rcond=None)
        at = np.array([1.0, math.log(17)])
        spread = rest[0] / 5 * (1.0 + at @ np.linalg.inv(design.T @ design) @ at)
        assert point.expected == pytest.approx(math.exp(at @ found))
        assert math.log(point.high / point.expected) == pytest.approx(
            1.476 * math.sqrt(spread), rel=1e-3
        )
        assert point.low * point.high == pytest.approx(point.expected**2)

    def test_the_band_holds_what_it_promises(self):
        numbers = np.random.default_rng(3)
        n = np.arange(1, 21)
        inside = 0
        for _ in range(600):
            times = 80.0 * n**-0.25 * np.exp(numbers.normal(0.0, 0.2, 20))
            point = curve(times[:10].tolist())[-1]
            inside += point.low <= times[19] <= point.high
        assert 0.75 < inside / 600 < 0.85


class TestFisher:
    @pytest.mark.parametrize(
        ("passed", "failed", "value"),
        [
            ((3, 1), (1, 3), 34 / 70),  # the lady and her tea
            ((8, 2), (1, 5), 0.0349650),
            ((1, 11), (9, 3), 0.0027595),
            ((5, 5), (5, 5), 1.0),
            ((4, 7), (0, 0), 1.0),
            ((0, 0), (0, 0), 1.0),
        ],
    )
    def test_it_gives_the_published_values(self, passed, failed, value):
        assert fisher(passed, failed) == pytest.approx(value, abs=1e-6)

    @given(*[st.integers(0, 12)] * 4)
    def test_it_is_a_probability_and_knows_no_first_group(self, a, b, c, d):
        assert 0.0 < fisher((a, b), (c, d)) <= 1.0
        assert fisher((a, b), (c, d)) == fisher((b, a), (d, c)) == fisher((c, d), (a, b))


class TestDifferenceOfMedians:
    def test_it_is_the_second_less_the_first(self):
        found = difference_of_medians([10.0, 12.0, 14.0], [20.0, 22.0, 24.0])
        assert found.value == 10.0
        assert 6.0 <= found.low <= 10.0 <= found.high <= 14.0

    def test_it_is_the_same_each_time(self):
        first, second = [1.0, 5.0, 3.0, 8.0], [2.0, 6.0, 9.0]
        assert difference_of_medians(first, second) == difference_of_medians(first, second)

    def test_its_ends_are_those_of_all_samples_that_can_be_drawn(self):
        # Of two values, the median of a sample is a, (a + b) / 2 or b with 1/4, 1/2, 1/4: for
        # 0, 1 and 0, 10 the extreme differences have 1/16 each.
        found = difference_of_medians([0.0, 1.0], [0.0, 10.0])
        assert (found.low, found.high) == (-1.0, 10.0)

    def test_one_value_is_no_group(self):
        assert difference_of_medians([1.0], [2.0, 3.0]) is None

    def test_the_interval_of_large_samples_is_that_of_the_normal_distribution(self):
        numbers = np.random.default_rng(5)
        first, second = numbers.normal(0.0, 1.0, 400), numbers.normal(1.0, 1.0, 400)
        found = difference_of_medians(first.tolist(), second.tolist())
        # the standard error of a median is 1.2533 sigma / sqrt(n)
        expected = 2 * 1.96 * 1.2533 * math.sqrt(2 / 400)
        assert found.high - found.low == pytest.approx(expected, rel=0.25)
