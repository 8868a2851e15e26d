"""Stopping at 1 m/s: soon, within a short way, and without tipping over.

All ways of it, with their figures: ``benchmarks/mobility --only stopping``.
"""

from __future__ import annotations

import pytest

from telex_experiments.mobility.balance import stopping

pytestmark = pytest.mark.slow

WAYS = {"silence": (stopping.fall_silent, 0.55, 0.45), "closed": (stopping.close, 0.30, 0.15)}


@pytest.mark.parametrize("way", WAYS)
def test_on_level_ground(way):
    end, seconds, metres = WAYS[way]
    found = stopping.on_level("ready", 1.0, end)
    assert found.braked <= 0.30
    assert found.stood <= seconds
    assert found.way <= metres


@pytest.mark.parametrize(
    "where",
    [
        "30 deg, down, flippers raised",
        "stairs 18x28 cm, down, 0.35 m/s",
        "arm out, 5 kg, flippers flat, forwards",
    ],
)
def test_where_a_short_way_would_tip_it(where):
    found = stopping.HARD[where]()
    assert found.margin >= 0.10
    # It is no shorter than need be.
    assert found.way <= 0.70


def test_across_a_slope_braking_takes_nothing_of_what_keeps_it_upright():
    found = stopping.HARD["30 deg, across, flippers flat"]()
    assert found.margin >= found.rest - 0.005
    assert found.way <= 0.70
