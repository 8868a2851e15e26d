from __future__ import annotations

import pytest

from telex_control.common.periodic import Periodic


@pytest.mark.parametrize("rate", [1.0, 50.0, 60.0, 250.0, 499.0, 500.0])
def test_the_mean_rate_is_kept(rate):
    tested = Periodic(rate)
    assert sum(tested.is_due(0.002 * k) for k in range(5000)) == pytest.approx(10 * rate, abs=1)


def test_a_rate_above_the_loop_s_is_every_cycle():
    tested = Periodic(2000.0)
    assert all(tested.is_due(0.002 * k) for k in range(100))


def test_what_was_missed_is_not_made_up_for():
    tested = Periodic(10.0)
    assert tested.is_due(0.0)
    assert tested.is_due(5.0)
    assert not tested.is_due(5.05)


def test_after_a_restart_it_is_due_at_once():
    tested = Periodic(10.0)
    tested.is_due(0.0)
    assert not tested.is_due(0.01)
    tested.restart()
    assert tested.is_due(0.01)
