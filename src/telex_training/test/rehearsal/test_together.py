"""Several operators share a simulation: whose turn it is, and how it ends."""

from __future__ import annotations

import pytest

from telex_training.rehearsal.together import Together


class Clock:
    """Counts the steps, and runs out after some."""

    def __init__(self, last=1000):
        self.steps = 0
        self.last = last

    def advance(self, steps):
        if self.steps + steps > self.last:
            raise TimeoutError
        self.steps += steps


@pytest.fixture
def clock():
    return Clock()


def worker(clock, together, seen, name, *waits):
    def work():
        for steps in waits:
            together.wait(steps)
            seen.append((clock.steps, name))

    return work


def test_each_goes_on_when_his_time_has_come_in_the_same_order(clock):
    together, seen = Together(clock.advance), []
    together.run([worker(clock, together, seen, "a", 2, 2), worker(clock, together, seen, "b", 4)])
    assert seen == [(2, "a"), (4, "a"), (4, "b")]


def test_who_has_done_holds_nobody_up(clock):
    together, seen = Together(clock.advance), []
    together.run([worker(clock, together, seen, "a"), worker(clock, together, seen, "b", 1, 1)])
    assert seen == [(1, "b"), (2, "b")]


def test_what_one_raises_ends_it_for_all(clock):
    together, seen, left = Together(clock.advance), [], []

    def fails():
        together.wait(3)
        raise ValueError("gave up")

    def waits():
        try:
            together.wait(500)
        finally:
            left.append("cleaned up")

    with pytest.raises(ValueError, match="gave up"):
        together.run([fails, waits, worker(clock, together, seen, "c", 500)])
    assert (clock.steps, left, seen) == (3, ["cleaned up"], [])


def test_the_end_of_the_simulation_is_the_end_for_all():
    clock = Clock(last=5)
    together, seen = Together(clock.advance), []
    with pytest.raises(TimeoutError):
        together.run([worker(clock, together, seen, name, 3, 3) for name in "ab"])
    assert seen == [(3, "a"), (3, "b")]


def test_outside_of_a_turn_time_passes_at_once(clock):
    Together(clock.advance).wait(7)
    assert clock.steps == 7
