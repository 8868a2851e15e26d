"""The line between console and robot, by its own time."""

from __future__ import annotations

import math
import random

import pytest

from telex_control.common.params import ConfigError
from telex_teleop.web.line.fields import PERFECT, LineFields
from telex_teleop.web.line.line import MOST_RETRANSMISSIONS, RETRANSMISSION, Line
from telex_teleop.web.line.line_queue import LineQueue
from telex_teleop.web.line.picture_line import PictureLine
from telex_teleop.web.line.profiles import Profiles
from telex_teleop.web.line.signal_curve import SignalCurve, SignalPoint
from telex_teleop.web.line.sim_clock import MOST_AHEAD, SimClock


def line_of(seed=1, since=0.0, **fields):
    line = Line(random.Random(seed))
    line.configure(LineFields(**fields), since)
    return line


def taken(queue, now):
    items = []
    while True:
        item = queue.take(now)
        if item is None:
            return items
        items.append(item)


# Fields and profiles


@pytest.mark.parametrize(
    ("fields", "part"),
    [
        ("{delay: -1}", "delay is -1"),
        ("{delay: .nan}", "delay is nan"),
        ("{delay: 1000}", "at most 10"),
        ("{loss: 2}", "loss is 2"),
        ("{loss: true}", "a number is needed"),
        ("{bandwidth: 3}", "at least 1000"),
        ("{bandwidth: .inf}", "finite"),
        ("{outage_every: 5}", "outage_for is 0.0"),
        ("{burst_length: 5, burst_interval: 1}", "must not be longer"),
        ("{burst_length: 1.0e-9, burst_interval: 1.0e-9}", "0 (no bursts) or at least 0.01 s"),
        ("{speed: 5}", "speed is unknown; known are bandwidth"),
        ("[1]", "a mapping is needed"),
        ("5", "a mapping is needed"),
        ("{", "no YAML"),
        ("delay: 2001-99-99", "no YAML: a value in it cannot be: month must be"),
        pytest.param("x" * 3000, "3000 characters", id="long"),
    ],
)
def test_fields_that_cannot_be_are_refused(fields, part):
    profiles = Profiles.read()
    for profile in ("perfect", "by_distance"):
        with pytest.raises(ConfigError, match=".") as error:
            profiles.choose(profile, fields)
        assert part in str(error.value)


def test_what_a_few_aliases_stand_for_is_not_written_out():
    class Part:
        written = 0

        def __repr__(self):
            Part.written += 1
            return "x"

    nested = [Part()]
    for _ in range(6):
        nested = [nested] * 9
    for changes in (nested, {"delay": nested}):
        with pytest.raises(ConfigError, match=r"is \[\[\[.*; a \w+ is needed"):
            Profiles.read().combine("", changes)
    assert Part.written < 1000
    with pytest.raises(ConfigError, match="a number is needed"):
        Profiles.read().choose("", "{delay: [&a [x, x], &b [*a, *a], &c [*b, *b], [*c, *c]]}")


def test_profiles_are_chosen_by_name_and_changed_by_fields():
    profiles = Profiles.read()
    assert set(profiles.profiles) >= {
        *("perfect", "wifi", "150", "300", "500", "1000", "lossy", "by_distance")
    }
    assert profiles.choose("").is_perfect
    assert profiles.choose("300").fields == LineFields(delay=0.3)
    changed = profiles.choose("300", "{loss: 0.1}")
    assert (changed.name, changed.fields) == ("300", LineFields(delay=0.3, loss=0.1))
    assert changed.described == "300 (loss 0.1)"
    assert profiles.choose("perfect", "{delay: 0.4}").name == "fields"
    assert profiles.choose("perfect", "{delay: 0}").name == "perfect"
    with pytest.raises(ConfigError, match="profile is 'moon'; known are perfect"):
        profiles.choose("moon")


def test_figures_follow_the_signal():
    setting = Profiles.read().choose("by_distance", "{jitter: 0}")
    assert not setting.is_perfect
    assert setting.at(None) == PERFECT
    assert setting.at(0.0).loss == 1.0
    near, far = setting.at(0.9), setting.at(0.2)
    assert near.delay < far.delay
    assert near.bandwidth > far.bandwidth
    assert near.jitter == far.jitter == 0.0
    curve = SignalCurve((SignalPoint(0.0, LineFields(delay=1.0)), SignalPoint(1.0, PERFECT)))
    assert curve.at(0.25).delay == pytest.approx(0.75)


@pytest.mark.parametrize(
    ("points", "part"),
    [
        ((SignalPoint(0.0),), "two at least"),
        ((SignalPoint(0.5), SignalPoint(0.5)), "must rise"),
        (
            (SignalPoint(0.0, LineFields(bandwidth=5000.0)), SignalPoint(0.5)),
            "with and without a bandwidth",
        ),
        (
            (SignalPoint(0.0, LineFields(burst_length=1.0, burst_interval=5.0)), SignalPoint(0.5)),
            "with and without a burst_interval",
        ),
    ],
)
def test_a_curve_that_cannot_be_is_refused(points, part):
    with pytest.raises(ConfigError, match=part):
        SignalCurve(points)


def test_figures_between_two_of_the_least_are_the_least():
    least = LineFields(burst_length=0.01, burst_interval=0.01, bandwidth=1000.0)
    curve = SignalCurve((SignalPoint(0.0, least), SignalPoint(1.0, least)))
    assert all(curve.at(step / 1000.0) == least for step in range(1000))


# Messages


def test_messages_keep_their_order_and_come_after_the_delay():
    queue = LineQueue(line_of(delay=0.3, jitter=0.2))
    for number in range(50):
        queue.send(number, 10, 0.01 * number)
    assert taken(queue, 0.29) == []
    arrived, now = [], 0.0
    while queue:
        now += 0.001
        for number in taken(queue, now):
            assert 0.3 <= now - 0.01 * number <= 0.7
            arrived.append(number)
    assert arrived == list(range(50))
    assert queue.bytes == 0


def test_a_perfect_line_lets_all_pass_once_what_was_under_way_has_arrived():
    line = line_of(delay=0.3)
    queue = LineQueue(line)
    queue.send("a", 1, 0.0)
    line.configure(PERFECT, 0.1)
    assert not queue.passes
    queue.send("b", 1, 0.1)
    assert taken(queue, 0.2) == []
    assert taken(queue, 0.3) == ["a", "b"]
    assert queue.passes


def test_what_must_arrive_comes_late_where_the_rest_is_lost():
    queue = LineQueue(line_of(loss=0.5))
    kept = [queue.send_or_lose(number, 1, 0.0) for number in range(1000)]
    assert 430 < sum(kept) < 570
    queue = LineQueue(line_of(loss=0.5))
    for number in range(100):
        queue.send(number, 1, 0.0)
    latest = MOST_RETRANSMISSIONS * RETRANSMISSION
    taken(queue, 0.0)
    assert len(queue) > 0
    taken(queue, latest)
    assert len(queue) == 0


def test_an_outage_loses_commands_and_holds_what_must_arrive():
    line = line_of(outage_every=10.0, outage_for=3.0, since=5.0)
    assert [line.in_outage(now) for now in (5.0, 11.9, 12.1, 14.9, 15.1, 22.1)] == [
        *(False, False, True, True, False, True)
    ]
    queue = LineQueue(line)
    assert queue.send_or_lose("a", 1, 11.0)
    assert not queue.send_or_lose("b", 1, 13.0)
    queue.send("stop", 1, 13.5)
    assert taken(queue, 14.9) == ["a"]
    assert taken(queue, 15.0) == ["stop"]


def test_an_outage_that_is_ended_lets_go_what_it_held():
    line = line_of(loss=1.0)
    queue = LineQueue(line)
    queue.send("stop", 1, 0.0)
    assert line.in_outage(0.0)
    assert taken(queue, 1e6) == []
    line.configure(LineFields(delay=0.2), 1e6 + 1.0)
    assert queue.next_due(1e6 + 1.0) == pytest.approx(1e6 + 1.2)


def test_bursts_lose_their_share():
    line = line_of(burst_length=0.5, burst_interval=5.0)
    lost = [line.loses(0.01 * step) for step in range(100_000)]
    assert 0.08 < sum(lost) / len(lost) < 0.12
    first = lost.index(True)
    assert not all(lost[first : first + 60])
    assert sum(lost[first : first + 50]) >= 49


def test_bursts_of_a_long_time_without_traffic_are_not_drawn():
    class Counted(random.Random):
        drawn = 0

        def random(self):
            Counted.drawn += 1
            return super().random()

    line = Line(Counted(1))
    line.configure(LineFields(burst_length=0.001, burst_interval=0.01), 0.0)
    lost = [line.loses(1e6 + 0.001 * step) for step in range(10_000)]
    assert 0.05 < sum(lost) / len(lost) < 0.2
    assert Counted.drawn < 3000
    line.configure(LineFields(burst_length=0.01, burst_interval=0.01), 2e6)
    assert line.loses(3e6)


def test_a_cap_spreads_messages():
    queue = LineQueue(line_of(bandwidth=8000.0))
    for number in range(3):
        queue.send(number, 500, 0.0)
    assert [queue.next_due(0.0), taken(queue, 1.0), taken(queue, 1.5)] == [0.5, [0, 1], [2]]


@pytest.mark.parametrize(
    ("fields", "due"),
    [
        ({}, [0.8, 0.8, 0.8, 0.8]),  # in order, however short the way is now
        ({"delay": 0.3, "bandwidth": 80_000.0}, [0.8, 0.95, 1.0, 1.05]),
        ({"delay": 0.3, "bandwidth": 4000.0}, [0.8, 1.3, 1.8, 2.8]),
        ({"delay": 0.1, "outage_every": 5.0, "outage_for": 5.0}, [0.8, 1.1, 1.6, math.inf]),
    ],
)
def test_what_waits_for_a_cap_follows_the_next_one_and_comes_no_later(fields, due):
    line = line_of(bandwidth=8000.0, delay=0.3)
    queue = LineQueue(line)
    for number in range(3):
        queue.send(number, 500, 0.0)
    for since in (0.59, 0.6):  # so a signal that changes time and again has it
        line.configure(LineFields(**fields), since)
        queue.next_due(0.6)
    queue.send(3, 500, 0.6)
    now = 0.6
    for number, each in enumerate(due):
        now = queue.next_due(now)
        assert now == pytest.approx(each)
        assert queue.take(now) == number


def test_messages_can_be_dropped_under_way():
    queue = LineQueue(line_of(delay=1.0))
    for number in range(4):
        queue.send(number, 5, 0.0)
    assert queue.drop(lambda number: number % 2 == 0) == [0, 2]
    assert (queue.bytes, taken(queue, 1.0)) == (10, [1, 3])


def test_a_clock_that_jumps_back_holds_nothing_up():
    queue = LineQueue(line_of(delay=0.3))
    queue.send("a", 1, 1000.0)
    assert queue.next_due(1.0) == pytest.approx(1.3)


def test_the_same_seed_gives_the_same_line():
    def run(seed):
        queue = LineQueue(line_of(seed, delay=0.1, jitter=0.1, loss=0.2))
        return [queue.send_or_lose(n, 1, 0.1 * n) and queue.next_due(0.0) for n in range(50)]

    assert run(3) == run(3) != run(4)


# Pictures


def test_pictures_arrive_when_their_stamp_is_as_old_as_the_delay():
    pictures = PictureLine(line_of(delay=0.5))
    pictures.offer("front", "p", 100, stamp=10.0, now=10.04)
    assert pictures.take(10.499) == []
    assert pictures.next_due(10.4) == 10.5
    assert pictures.take(10.5) == [("front", "p")]
    assert pictures.bytes == 0


def test_an_old_stamp_is_not_believed():
    pictures = PictureLine(line_of(delay=0.5))
    pictures.offer("front", "p", 100, stamp=1.0, now=10.0)
    assert pictures.take(10.4) == []
    assert pictures.take(10.5) == [("front", "p")]


def test_under_a_cap_the_newest_wins_and_cameras_take_turns():
    pictures = PictureLine(line_of(bandwidth=8e6))
    arrived = []
    for step in range(100):
        now = step / 50.0
        pictures.offer("a", step, 100_000, stamp=now, now=now)
        pictures.offer("b", step, 100_000, stamp=now, now=now)
        arrived += pictures.take(now)
    # 10 pictures a second fit
    assert 17 <= len(arrived) <= 20
    assert abs(sum(camera == "a" for camera, _ in arrived) - len(arrived) / 2) <= 1
    # one is under way for 0.1 s, and the newest had waited for the other camera's
    assert 99 - arrived[-1][1] <= 15


def test_of_an_outage_only_the_newest_picture_arrives():
    pictures = PictureLine(line_of(delay=0.1, outage_every=10.0, outage_for=3.0))
    arrived = []
    for step in range(60, 105):
        now = step / 10.0
        arrived += pictures.take(now)
        pictures.offer("a", step, 10, stamp=now, now=now)
    assert [picture for _, picture in arrived] == [*range(60, 70), 99, *range(100, 103)]


def test_pictures_under_way_are_bounded_and_can_be_forgotten():
    pictures = PictureLine(line_of(delay=5.0), most_bytes=1000)
    for step in range(30):
        pictures.offer("a", step, 100, stamp=0.01 * step, now=0.01 * step)
    assert pictures.bytes <= 1000
    pictures.forget("a")
    assert (pictures.bytes, pictures.next_due(9.0), pictures.take(9.0)) == (0, None, [])


# Time


def test_time_goes_on_between_readings_and_waits_without_them():
    clock = SimClock()
    assert clock.at(5.0, 100.0, 100.0) == 5.0
    assert clock.at(5.0, 100.0, 100.01) == pytest.approx(5.01)
    assert clock.at(5.0, 100.0, 102.0) == pytest.approx(5.0 + MOST_AHEAD)
    assert clock.at(5.02, 102.0, 102.0) == pytest.approx(5.0 + MOST_AHEAD)
    assert clock.at(5.1, 102.1, 102.1) == pytest.approx(5.1)
    assert clock.at(1.0, 103.0, 103.0) == 1.0
