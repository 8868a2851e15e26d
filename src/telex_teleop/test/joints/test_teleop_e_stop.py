"""Whether the emergency stop is set, when its messages come in any order."""

import itertools

import pytest

from telex_teleop.motion.e_stop_state import EStopState


@pytest.fixture
def state():
    return EStopState()


def test_without_a_simulator_the_last_message_counts(state):
    assert not state.active
    state.take_request(True)
    assert state.active
    state.take_request(False)
    assert not state.active


@pytest.mark.parametrize("order", itertools.permutations(["pressed", "released", "status"]))
def test_whoever_joins_late_believes_the_status(order):
    # two operators' latched messages and the robot's, in any order
    state = EStopState()
    for message in order:
        if message == "status":
            state.take_status(True)
        else:
            state.take_request(message == "pressed")
    assert state.active


def test_press_is_obeyed_before_the_status_says_so(state):
    state.take_status(False)
    state.take_request(True)
    assert state.active


def test_release_waits_for_the_status(state):
    state.take_status(True)
    state.take_request(False)
    assert state.active
    state.take_status(False)
    assert not state.active
