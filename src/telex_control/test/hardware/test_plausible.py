"""Numbers that no operator could mean are told from those that lie beyond a limit."""

from __future__ import annotations

import math

import pytest

from telex_control.common.plausible import effort_problem, position_problem, speed_problem

HUGE = (1e308, -1e308, 1e39, 1e17, -1e5, math.inf, math.nan)


@pytest.mark.parametrize("value", HUGE)
def test_what_cannot_be_meant_has_a_problem(value):
    assert position_problem(value)
    assert position_problem(value, -1.0, 2.0)
    assert speed_problem(value)
    assert speed_problem(value, 2.0)
    assert effort_problem(1e3 * value)


def test_what_overshoots_has_none():
    assert not position_problem(99.0, -1.0, 2.0)
    assert not position_problem(2.0e3)
    assert not speed_problem(150.0, 2.0)
    assert not speed_problem(0.1, 0.0)
    assert not effort_problem(1e4)
    assert "limits, -1 to 2," in position_problem(103.0, -1.0, 2.0)
    assert "100 times the limit, 2," in speed_problem(-201.0, 2.0)
