from __future__ import annotations

import pytest

from telex_sim.engine.pacing import RealTimeFactor, RealTimePacer
from telex_sim.engine.phase_timer import PHASES, SAMPLED, PhaseTimer


class FakeTime:
    def __init__(self):
        self.now = 100.0
        self.slept = []

    def clock(self):
        return self.now

    def sleep(self, seconds):
        self.slept.append(seconds)
        self.now += seconds


def pacer(factor):
    time = FakeTime()
    return time, RealTimePacer(factor, time.clock, time.sleep)


@pytest.mark.parametrize(("factor", "wall"), [(1.0, 2.0), (2.0, 1.0), (0.5, 4.0)])
def test_sim_time_follows_the_wall(factor, wall):
    time, tested = pacer(factor)
    for step in range(1, 1001):
        tested.wait(step * 0.002)
    assert time.now - 100.0 == pytest.approx(wall)


def test_factor_zero_never_sleeps():
    time, tested = pacer(0.0)
    assert tested.wait(5.0) == 0.0
    assert time.slept == []


def test_a_short_delay_is_caught_up():
    time, tested = pacer(1.0)
    tested.wait(0.002)
    time.now += 0.05
    assert tested.wait(0.004) == pytest.approx(0.048)
    for step in range(3, 101):
        tested.wait(step * 0.002)
    assert time.now - 100.0 == pytest.approx(0.2)


def test_a_long_delay_is_forgotten_instead_of_caught_up_in_a_burst():
    time, tested = pacer(1.0)
    tested.wait(0.002)
    time.now += 3.0
    tested.wait(0.004)
    before = time.now
    tested.wait(0.104)
    assert time.now - before == pytest.approx(0.1)


def test_a_pause_is_no_delay():
    time, tested = pacer(1.0)
    tested.wait(1.0)
    time.now += 60.0
    tested.restart(1.0)
    assert tested.wait(1.5) == 0.0
    assert time.slept[-1] == pytest.approx(0.5)


def test_achieved_factor():
    time = FakeTime()
    tested = RealTimeFactor(time.clock)
    time.now += 2.0
    assert tested.since_last(1.0) == pytest.approx(0.5)
    time.now += 1.0
    assert tested.since_last(2.0) == pytest.approx(1.0)
    time.now += 0.01
    assert tested.since_last(3.0) == pytest.approx(1.0)  # too short to measure
    time.now += 1.99
    assert tested.since_last(3.0) == pytest.approx(0.5)


def test_phase_means_are_per_cycle_and_start_anew():
    timer = PhaseTimer()
    timer.begin()
    for _ in range(4):
        sum(range(20000))
        timer.end("step")
        timer.count_cycle()
    means = dict(timer.take_means())
    assert tuple(means) == PHASES
    assert means["step"] > 0.0
    assert means["read"] == 0.0
    assert dict(timer.take_means())["step"] == 0.0


def test_phases_are_measured_in_one_step_of_several():
    timer = PhaseTimer()
    for step in range(2 * SAMPLED):
        timer.begin()
        if step % SAMPLED:
            sum(range(200_000))
        timer.end("step")
        timer.count_cycle()
    assert timer._cycles == 2
    measured = dict(timer.take_means())["step"]
    timer.begin()
    sum(range(200_000))
    timer.end("step")
    timer.count_cycle()
    assert dict(timer.take_means())["step"] > measured
