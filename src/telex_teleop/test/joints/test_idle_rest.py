"""An idle node rests between joint states; a command ends the rest at once."""

from __future__ import annotations

import threading

import pytest

from telex_teleop.motion import idle_rest
from telex_teleop.motion.idle_rest import LONGEST_REST, IdleRest


@pytest.fixture
def rests(monkeypatch):
    """How long a thread was to rest at most (s)."""
    durations = []

    def wait_for(self, condition, seconds):
        if not condition():
            durations.append(seconds)

    monkeypatch.setattr(threading.Condition, "wait_for", wait_for)
    return durations


def test_only_an_idle_node_rests(rests):
    rest = IdleRest()
    for number, idle in enumerate((True, False, True)):
        rest.settle(idle, rest.commands, 0.01 * number, 0.01 * number)
    assert rests == [pytest.approx(LONGEST_REST)]  # the first has nothing to go by


def test_a_fast_simulation_is_looked_at_as_often_in_its_own_time(rests):
    rest = IdleRest()
    rest.settle(True, 0, 1.0, 7.0)
    rest.settle(True, 0, 1.1, 7.01)
    rest.follow()
    assert rests == [pytest.approx(0.1 * LONGEST_REST)] * 2


def test_a_command_that_came_during_the_update_ends_the_rest_before_it_begins(rests):
    rest = IdleRest()
    rest.settle(True, rest.commands, 0.0, 0.0)
    commands = rest.commands
    rest.wake()
    rest.settle(True, commands, 0.01, 0.01)
    assert rests == []


def test_other_threads_rest_while_that_of_the_joint_states_is_idle(rests):
    rest = IdleRest()
    rest.follow()
    rest.settle(True, rest.commands, 0.0, 0.0)
    rest.follow()
    rest.wake()
    rest.follow()
    rest.settle(False, rest.commands, 0.01, 0.01)
    rest.follow()
    assert rests == [LONGEST_REST]


def test_a_command_wakes_who_rests(monkeypatch):
    monkeypatch.setattr(idle_rest, "LONGEST_REST", 1000.0)
    rest = IdleRest()
    rest.settle(True, rest.commands, 0.0, 0.0)
    begun = threading.Event()

    def work():
        commands = rest.commands
        begun.set()
        rest.settle(True, commands, 0.01, 0.01)

    thread = threading.Thread(target=work, daemon=True)
    thread.start()
    assert begun.wait(60.0)
    rest.wake()
    thread.join(60.0)
    assert not thread.is_alive()
