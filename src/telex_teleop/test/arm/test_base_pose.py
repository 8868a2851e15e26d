"""The base's pose between its reports."""

from __future__ import annotations

import pytest
from arm_rig import base_at

from telex_teleop.arm.base_pose import BasePose

MAX_AGE = 0.25


@pytest.fixture
def base():
    """One that drives along x at 1 m/s and has reported at 1.0 s and 1.1 s."""
    base = BasePose(MAX_AGE)
    base.take(1.0, base_at(x=0.0))
    base.take(1.1, base_at(x=0.1))
    return base


def x_at(base, stamp):
    pose = base.at(stamp)
    return None if pose is None else pytest.approx(pose[0, 3])


def test_it_is_carried_on_at_its_last_velocity(base):
    assert x_at(base, 1.2) == 0.2
    assert x_at(base, 1.36) is None


@pytest.mark.parametrize("stamp", [1.05, 1.1])
def test_a_report_that_comes_late_is_dropped(base, stamp):
    base.take(stamp, base_at(x=7.0))
    assert x_at(base, 1.1) == 0.1


@pytest.mark.parametrize("ahead", [0.3, 1000.0])
def test_one_report_stamped_in_the_future_costs_no_later_one(base, ahead):
    base.take(1.1 + ahead, base_at(x=7.0))
    assert x_at(base, 1.1) is None
    base.take(1.12, base_at(x=0.12))
    assert x_at(base, 1.14) == 0.12  # of a new beginning no velocity is known
    base.take(1.14, base_at(x=0.14))
    assert x_at(base, 1.2) == 0.2
