"""One press of faster or slower."""

from __future__ import annotations

import pytest

from telex_teleop.motion.speed import STEP, stepped


def test_up_and_down_meet_the_same_values():
    up, scale = [], 0.05
    for _ in range(11):
        scale = stepped(scale, 1, STEP, 0.05, 1.0)
        up.append(scale)
    assert up == pytest.approx([0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.0])
    down = []
    for _ in range(11):
        scale = stepped(scale, -1, STEP, 0.05, 1.0)
        down.append(scale)
    assert down == pytest.approx([0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2, 0.1, 0.05, 0.05])


def test_what_lies_between_goes_to_the_next_value():
    assert stepped(0.35, 1, STEP, 0.05, 1.0) == pytest.approx(0.4)
    assert stepped(0.35, -1, STEP, 0.05, 1.0) == pytest.approx(0.3)
