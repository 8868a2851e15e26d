from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from telex_control.laws.reference_filter import ReferenceFilter


def test_it_goes_to_the_set_point_without_overshoot():
    tested = ReferenceFilter(50.0)
    positions = [tested.update(1.0, 0.002)[0] for _ in range(500)]
    assert positions == sorted(positions)
    assert positions[-1] == pytest.approx(1.0, abs=1e-9)
    assert max(positions) <= 1.0 + 1e-12
    assert tested.velocity == pytest.approx(0.0, abs=1e-9)


def test_a_ramp_is_followed_with_its_stated_delay():
    tested = ReferenceFilter(100.0)
    for step in range(1000):
        position, velocity = tested.update(0.2 * (step + 1) * 0.002, 0.002)
    # a held input is a staircase; its ripple remains
    assert velocity == pytest.approx(0.2, rel=0.01)
    # 2 / w, less the half cycle by which a held input leads its mean
    assert 0.2 * 2.0 - position == pytest.approx(0.2 * 2.0 / 100.0, abs=0.2 * 0.002)


@given(st.floats(-10, 10), st.floats(-10, 10), st.floats(1.0, 500.0), st.floats(1e-4, 0.1))
def test_two_half_cycles_are_one_whole(position, target, frequency, period):
    one, two = ReferenceFilter(frequency), ReferenceFilter(frequency)
    for each in (one, two):
        each.reset(position)
    one.update(target, 2.0 * period)
    two.update(target, period)
    two.update(target, period)
    assert one.position == pytest.approx(two.position, abs=1e-9)
    assert one.velocity == pytest.approx(two.velocity, abs=1e-6)


@pytest.mark.parametrize("bad", [0.0, -1.0, math.nan, math.inf])
def test_the_frequency_must_be_usable(bad):
    with pytest.raises(ValueError, match="frequency"):
        ReferenceFilter(bad)
