from __future__ import annotations

import math

import pytest

from telex_control.laws.pid import Pid, PidGains


def test_proportional_integral_and_derivative_terms():
    pid = Pid(PidGains(p=2.0, i=10.0, d=0.5, i_max=100.0, i_min=-100.0))
    assert pid.update(1.0, 0.1) == pytest.approx(2.0 + 10.0 * 0.1)
    # the second sample: derivative (0.6 - 1.0) / 0.1, integral 0.1 + 0.06
    assert pid.update(0.6, 0.1) == pytest.approx(1.2 + 1.6 - 2.0)


def test_first_sample_has_no_derivative_kick():
    pid = Pid(PidGains(p=0.0, d=100.0))
    assert pid.update(1.0, 0.002) == 0.0
    pid.update(1.0, 0.002)
    pid.reset()
    assert pid.update(-3.0, 0.002) == 0.0


def test_given_derivative_is_used():
    pid = Pid(PidGains(p=0.0, d=3.0))
    assert pid.update(5.0, 0.002, error_dot=2.0) == pytest.approx(6.0)


def test_zero_clamp_silences_the_integral_as_upstream_does():
    pid = Pid(PidGains(p=0.0, i=5.0))
    for _ in range(10):
        assert pid.update(1.0, 0.1) == 0.0


@pytest.mark.parametrize("antiwindup", [False, True])
def test_integral_term_is_clamped(antiwindup):
    pid = Pid(PidGains(p=0.0, i=10.0, i_max=1.0, i_min=-1.0, antiwindup=antiwindup))
    for _ in range(100):
        pid.update(1.0, 0.1)
    assert pid.output == pytest.approx(1.0)
    samples = 0
    while pid.update(-1.0, 0.1) >= 1.0:
        samples += 1
    # Without antiwindup, all that was integrated must be undone first.
    assert samples == 0 if antiwindup else samples > 90


@pytest.mark.parametrize("antiwindup", [False, True])
def test_negative_integral_gain_with_antiwindup(antiwindup):
    pid = Pid(PidGains(p=0.0, i=-10.0, i_max=1.0, i_min=-1.0, antiwindup=antiwindup))
    for _ in range(50):
        pid.update(1.0, 0.1)
    assert pid.output == pytest.approx(-1.0)


@pytest.mark.parametrize(
    ("error", "period"),
    [(math.nan, 0.1), (math.inf, 0.1), (1.0, 0.0), (1.0, -0.1)],
)
def test_unusable_samples_give_zero_and_change_nothing(error, period):
    pid = Pid(PidGains(p=1.0, i=1.0, d=1.0, i_max=10.0, i_min=-10.0))
    twin = Pid(pid.gains)
    for each in (pid, twin):
        each.update(1.0, 0.1)
    assert pid.update(error, period) == 0.0
    assert pid.update(0.5, 0.1) == twin.update(0.5, 0.1)


def test_gains_from_parameters():
    gains = PidGains.from_params({"p": 1, "i": 2.0, "d": 3, "i_clamp": 4.0}, "/x/pid")
    assert gains == PidGains(1.0, 2.0, 3.0, 4.0, -4.0)
    gains = PidGains.from_params({"p": 1, "i_clamp": 4.0, "i_clamp_min": -1.0}, "/x/pid")
    assert (gains.i_min, gains.i_max) == (-1.0, 4.0)


@pytest.mark.parametrize(
    ("params", "named"),
    [
        ({}, "/x/pid/p is missing"),
        ({"p": "high"}, "/x/pid/p is 'high'"),
        ({"p": math.nan}, "/x/pid/p is nan"),
        ({"p": True}, "/x/pid/p is True"),
        ({"p": 1.0, "k": 2.0}, "/x/pid/k is unknown"),
        ({"p": 1.0, "i_clamp_min": 2.0, "i_clamp_max": 1.0}, "above"),
        ([1.0], "a struct"),
        ({"p": 1.0, "antiwindup": "false"}, "antiwindup is 'false'; true or false is needed"),
    ],
)
def test_wrong_gains_are_refused_by_name(params, named):
    with pytest.raises(ValueError, match=named.replace("/", "/")):
        PidGains.from_params(params, "/x/pid")
