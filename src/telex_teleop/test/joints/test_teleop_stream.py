"""Command streams: the watchdog on two clocks, the latch, steps of sim time."""

import pytest

from telex_teleop.motion.stream import Clocks, CommandStream, SimTicks, StartingTime, TimeStep

TIMEOUT = 0.28


def at(time, sim=None):
    return Clocks(time, time if sim is None else sim)


@pytest.fixture
def stream():
    return CommandStream(TIMEOUT)


def test_command_holds_until_the_timeout(stream):
    assert stream.command(at(0.0)) is None
    assert stream.receive("go", at(1.0))
    assert stream.command(at(1.28)) == "go"
    assert stream.command(at(1.29)) is None


def test_stale_command_does_not_come_back(stream):
    stream.receive("go", at(1.0))
    assert stream.command(at(1.3)) is None
    assert stream.command(at(1.1)) is None


@pytest.mark.parametrize("later", [Clocks(1.3, 1.0), Clocks(1.0, 1.3)])
def test_either_clock_makes_it_stale(stream, later):
    stream.receive("go", at(1.0))
    assert stream.command(later) is None


def test_validity_shortens_but_never_lengthens(stream):
    stream.receive("go", at(1.0), validity=0.1)
    assert stream.command(at(1.09)) == "go"
    assert stream.command(at(1.11)) is None
    stream.receive("go", at(2.0), validity=5.0)
    assert stream.command(at(2.29)) is None


def test_newest_command_wins(stream):
    stream.receive("left", at(1.0))
    stream.receive("right", at(1.1))
    assert stream.command(at(1.1)) == "right"


def test_a_command_ends_with_its_client(stream):
    stream.receive("left", at(1.0), "a")
    stream.receive("right", at(1.1), "b")
    stream.keep({"b"})
    assert stream.command(at(1.1)) == "right"
    stream.keep({"a"})
    assert stream.command(at(1.1)) is None
    assert stream.receive("right", at(1.2), "b")


def test_end_stops_at_once(stream):
    stream.receive("go", at(1.0))
    stream.end()
    assert stream.command(at(1.0)) is None


class TestInhibition:
    @pytest.fixture
    def running(self, stream):
        stream.receive("go", at(1.0))
        stream.inhibit(True)
        return stream

    def test_nothing_is_obeyed_meanwhile(self, running):
        assert running.command(at(1.0)) is None
        assert not running.receive("go", at(1.1))
        assert not running.receive("go", at(9.0))
        running.end()
        assert not running.receive("go", at(9.5))

    def test_running_stream_stays_ignored_until_it_pauses(self, running):
        for tick in range(20):
            assert not running.receive("go", at(1.0 + 0.05 * tick))
        running.inhibit(False)
        assert not running.receive("go", at(2.0))
        assert running.waiting(2.1)
        assert not running.receive("go", at(2.2))
        assert not running.waiting(2.5)
        assert running.receive("go", at(2.5))
        assert running.receive("go", at(2.52))

    def test_running_stream_stays_ignored_until_it_sends_a_stop(self, running):
        running.inhibit(False)
        assert not running.receive("go", at(1.02))
        running.end()
        assert running.receive("go", at(1.04))

    def test_stream_begun_meanwhile_is_not_a_new_command(self, running):
        running.end()
        running.receive("go", at(5.0))
        running.inhibit(False)
        assert not running.receive("go", at(5.1))

    def test_first_command_afterwards_is_new(self, running):
        running.inhibit(False)
        assert running.receive("go", at(2.0))


def test_latch_needs_a_pause_too(stream):
    stream.receive("go", at(1.0))
    stream.latch()
    assert stream.command(at(1.0)) is None
    assert not stream.receive("go", at(1.1))
    assert stream.receive("go", at(1.4))


class TestTwoClients:
    @pytest.fixture
    def latched(self, stream):
        stream.receive("go", at(1.0), "a")
        stream.latch()
        assert not stream.receive("go", at(1.02), "a")
        return stream

    def test_stop_of_another_does_not_release_a_held_key(self, latched):
        latched.end("b")
        assert not latched.receive("go", at(1.04), "a")
        latched.end("a")
        assert latched.receive("go", at(1.06), "a")

    def test_press_of_another_is_obeyed_and_lets_nobody_else_in(self, latched):
        assert latched.receive("back", at(1.04), "b")
        assert not latched.receive("go", at(1.06), "a")
        assert latched.command(at(1.06)) == "back"

    def test_stop_of_another_stops(self, stream):
        stream.receive("go", at(1.0), "a")
        stream.end("b")
        assert stream.command(at(1.0)) is None

    def test_pause_of_one_is_not_filled_by_the_other(self, latched):
        for tick in range(20):
            latched.receive("back", at(1.04 + 0.02 * tick), "b")
        assert latched.receive("go", at(1.5), "a")


def test_starting_time_counts_from_the_first_joint_state_and_ends_once():
    starting = StartingTime(TIMEOUT)
    assert [starting.ends(100.0 + 0.25 * tick) for tick in range(5)] == [
        False,
        False,
        False,
        True,
        False,
    ]
    assert not starting.lasts


def test_ticks_are_differences_of_stamps():
    ticks = SimTicks(0.5)
    assert ticks.now is None
    assert ticks.advance(5.0) is None
    assert ticks.advance(5.25) == TimeStep(0.25, False)
    assert ticks.advance(5.25) is None
    assert ticks.now == 5.25


@pytest.mark.parametrize("stamp", [4.99, 0.0, 5.51])
def test_ticks_backwards_or_too_long_are_jumps(stamp):
    ticks = SimTicks(0.5)
    ticks.advance(5.0)
    assert ticks.advance(stamp) == TimeStep(0.0, True)
    following = ticks.advance(stamp + 0.125)
    assert following is not None
    assert not following.jumped
