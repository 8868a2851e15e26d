from __future__ import annotations

import pytest

from telex_control.laws.speed_limiter import Range, SpeedLimiter


def test_without_limits_nothing_changes():
    assert SpeedLimiter().limit(5.0, 0.0, 0.0, 0.01) == 5.0


def test_velocity():
    limiter = SpeedLimiter(velocity=Range(-0.5, 1.0))
    assert limiter.limit(2.0, 0.0, 0.0, 0.01) == 1.0
    assert limiter.limit(-2.0, 0.0, 0.0, 0.01) == -0.5


def test_acceleration():
    limiter = SpeedLimiter(acceleration=Range(-4.0, 2.0))
    assert limiter.limit(5.0, 1.0, 1.0, 0.1) == pytest.approx(1.2)
    assert limiter.limit(-5.0, 1.0, 1.0, 0.1) == pytest.approx(0.6)


def test_deceleration_bounds_braking_alone_and_in_both_directions():
    limiter = SpeedLimiter(acceleration=Range(-1.0, 1.0), deceleration=4.0)
    assert limiter.limit(0.0, 1.0, 1.0, 0.1) == pytest.approx(0.6)
    assert limiter.limit(0.0, -1.0, -1.0, 0.1) == pytest.approx(-0.6)
    assert limiter.limit(2.0, 1.0, 1.0, 0.1) == pytest.approx(1.1)
    assert limiter.limit(-2.0, -1.0, -1.0, 0.1) == pytest.approx(-1.1)
    assert limiter.limit(-2.0, 0.0, 0.0, 0.1) == pytest.approx(-0.1)


def test_braking_may_be_limited_further():
    limiter = SpeedLimiter(acceleration=Range(-1.0, 1.0), deceleration=4.0)
    assert limiter.limit(0.0, 1.0, 1.0, 0.1, braking=2.0) == pytest.approx(0.8)
    assert limiter.limit(0.0, -1.0, -1.0, 0.1, braking=2.0) == pytest.approx(-0.8)
    assert limiter.limit(0.0, 1.0, 1.0, 0.1, braking=9.0) == pytest.approx(0.6)
    assert SpeedLimiter().limit(0.0, 1.0, 1.0, 0.1, braking=2.0) == pytest.approx(0.8)


def test_jerk_bounds_the_second_difference():
    limiter = SpeedLimiter(jerk=Range(-5.0, 5.0))
    # change 0.1 before; 2 j dt^2 = 0.1 more or less now
    assert limiter.limit(9.0, 1.0, 0.9, 0.1) == pytest.approx(1.2)
    assert limiter.limit(-9.0, 1.0, 0.9, 0.1) == pytest.approx(1.0)


def test_parameters():
    limiter = SpeedLimiter.from_params(
        {"has_velocity_limits": True, "max_velocity": 2, "max_jerk": 1.0}, "/x"
    )
    assert limiter == SpeedLimiter(velocity=Range(-2.0, 2.0))
    limiter = SpeedLimiter.from_params({"max_deceleration": 3}, "/x")
    assert limiter == SpeedLimiter(deceleration=3.0)


@pytest.mark.parametrize(
    ("params", "named"),
    [
        ({"speed": 1}, "/x/speed is unknown"),
        ({"has_velocity_limits": True}, "/x/max_velocity"),
        ({"has_velocity_limits": True, "max_velocity": float("nan")}, "/x/max_velocity"),
        ({"has_velocity_limits": True, "max_velocity": 1, "min_velocity": 2}, "min_velocity"),
        ({"has_velocity_limits": True, "max_velocity": 2, "min_velocity": 1}, "0 between them"),
        ({"max_deceleration": -3.0}, "/x/max_deceleration is -3.0; it must be above 0"),
        ({"max_deceleration": None}, "/x/max_deceleration is None; a number"),
        ({"has_velocity_limits": "false", "max_velocity": 2}, "true or false is needed"),
    ],
)
def test_wrong_parameters_are_named(params, named):
    with pytest.raises(ValueError, match=named):
        SpeedLimiter.from_params(params, "/x")
