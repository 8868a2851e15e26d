"""Who may command the robot through the bridge, and what stops when that changes."""

from __future__ import annotations

import asyncio
import json
from dataclasses import asdict
from unittest import mock

import pytest
from bridge_bench import JOG, TWIST, Bench, Client
from std_msgs.msg import Bool
from std_srvs.srv import SetBoolResponse
from telex_msgs.msg import FlipperPresetActionResult
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint
from waiting import wait_until_async
from web_fakes import FakeRos, on_loop

from telex_teleop.web.bridge.clients.access import Access
from telex_teleop.web.bridge.clients.control import Control, ControlError, Member
from telex_teleop.web.bridge.clients.other_robots import OtherRobots
from telex_teleop.web.bridge.protocol.operations import OperationError
from telex_teleop.web.bridge.topics.command_age import CommandAge
from telex_teleop.web.bridge.topics.commands import stop_for
from telex_teleop.web.bridge.topics.goals import MAX_GOALS
from telex_teleop.web.bridge.topics.publish import MAX_HELD
from telex_teleop.web.bridge.topics.shared_topics import SharedPublisher
from telex_teleop.web.rights import Rights, UseLists

DRIVE, E_STOP = "/telex/track_teleop/cmd_vel", "/telex/e_stop"
AHEAD, STILL = {"linear": {"x": 1.0}}, {"linear": {"x": 0.0}}


async def driver(bench, **kind):
    client = Client(bench, **kind)
    client.say("advertise", topic=DRIVE, type=TWIST)
    await bench.settle()
    return client


class Clock:
    """The bridge's time for one client (s), which goes on only as a test says."""

    def __init__(self, client):
        self.now = 100.0
        client.session._gate.clock = lambda: self.now

    def said_at(self, late=0.0):
        """What the client tells of when it sent something (ms), by the same clock."""
        return 1e3 * (self.now - late)


def driven(bench):
    return [message.linear.x for topic, message in bench.ros.published if topic == DRIVE]


# Control


@on_loop
async def test_the_first_command_takes_control_and_others_are_not_obeyed():
    bench = Bench()
    first, second = await driver(bench), await driver(bench)
    first.say("publish", topic=DRIVE, msg=AHEAD)
    second.say("publish", topic=DRIVE, msg={"linear": {"x": 0.5}})
    assert driven(bench) == [1.0]
    assert bench.control.holder is first.member
    assert (first.member.dropped, second.member.dropped) == (0, 1)
    # A client that has not asked for warnings hears none: roslibpy could not read them.
    assert len(second.outbox) == 0
    assert await second.ask("switch", {"data": True}) == (
        False,
        "client 1 holds control; it can release it, or an instructor take it",
    )
    second.say("publish", topic="/elsewhere", type=TWIST, msg=AHEAD)
    await bench.settle()
    assert bench.ros.published[-1][0] == "/elsewhere"


@on_loop
async def test_who_asks_for_warnings_is_told_once_a_second():
    bench = Bench()
    first, second = await driver(bench), await driver(bench)
    first.say("publish", topic=DRIVE, msg=AHEAD)
    second.say("set_level", level="warning")
    for _ in range(2):
        second.say("publish", topic=DRIVE, msg=AHEAD, id="p")
    status = await second.hear()
    assert (status["level"], status["id"]) == ("warning", "p")
    assert status["msg"].startswith(f"publish to {DRIVE}: client 1 holds control")
    assert len(second.outbox) == 0


@on_loop
async def test_control_is_lost_with_the_connection():
    bench = Bench()
    first, second = await driver(bench), await driver(bench)
    first.say("publish", topic=DRIVE, msg=AHEAD)
    first.session.close()
    assert bench.control.holder is None
    second.say("publish", topic=DRIVE, msg={"linear": {"x": 0.5}})
    assert driven(bench) == [1.0, 0.0, 0.5]


@on_loop
async def test_take_release_and_hand_over():
    bench = Bench()
    first, second = await driver(bench), await driver(bench)
    teacher = Client(bench, instructor=True)
    ask = "bridge/take_control", "bridge/release_control", "bridge/hand_over"
    assert (await first.ask(ask[0]))[1] == {"success": True, "message": "you hold control"}
    refused = (await second.ask("/telex/bridge/take_control"))[1]
    assert refused["success"] is False
    assert refused["message"].startswith("client 1 holds control")
    first.say("publish", topic=DRIVE, msg=AHEAD)
    assert (await teacher.ask(ask[0]))[1]["success"]
    assert driven(bench) == [1.0, 0.0]  # what the operator drove has stopped
    first.say("publish", topic=DRIVE, msg=AHEAD)
    assert driven(bench) == [1.0, 0.0]
    assert (await teacher.ask(ask[2], {"client": second.id}))[1]["success"]
    assert bench.control.holder is second.member
    assert not (await first.ask(ask[2], {"client": first.id}))[1]["success"]
    absent = (await teacher.ask(ask[2], ["nobody"]))[1]
    assert absent["message"] == ("there is no client 'nobody'; connected are 1, 2, 3")
    assert (await second.ask(ask[1]))[1] == {"success": True, "message": "control is free"}
    assert not (await second.ask(ask[1]))[1]["success"]
    assert (await second.ask("bridge/who_am_i"))[1]["message"] == second.id


@on_loop
async def test_what_an_operator_sees_is_told_by_who_has_control_and_takes_none():
    """A page tells it on, until it has heard that it has no control any more."""
    bench = Bench()
    first, second = await driver(bench), await driver(bench)
    topic = "/telex/console/telemetry"
    for client in (first, second):
        client.say("advertise", topic=topic, type="std_msgs/String")
    await bench.settle()
    first.say("publish", topic=topic, msg={"data": "before"})
    assert bench.control.holder is None
    first.say("publish", topic=DRIVE, msg=AHEAD)
    for client in (first, second):
        client.say("publish", topic=topic, msg={"data": client.id})
    assert (await first.ask("bridge/release_control"))[1]["success"]
    first.say("publish", topic=topic, msg={"data": "after"})
    assert bench.control.holder is None
    told = [message.data for name, message in bench.ros.published if name == topic]
    assert told == [first.id]
    assert (first.member.dropped, second.member.dropped) == (0, 0)


@on_loop
async def test_an_instructor_may_do_some_things_without_control():
    every = {"publish": ["/*"], "call": ["/*"], "set": ["/*"]}
    bench = Bench(
        rights={
            "operator": every,
            "instructor": every,
            "commands": {"publish": ["*"], "call": ["*"], "set": ["*"]},
            "without_control": {"publish": [DRIVE], "call": ["switch"]},
        }
    )
    operator, teacher = await driver(bench), await driver(bench, instructor=True)
    operator.say("publish", topic=DRIVE, msg=AHEAD)
    teacher.say("publish", topic=DRIVE, msg={"linear": {"x": 0.2}})
    assert driven(bench) == [1.0, 0.2]
    assert (await teacher.ask("switch", {"data": True}))[0]
    assert bench.control.holder is operator.member
    value = {"name": "limit", "value": "2"}
    assert not (await teacher.ask("rosapi/set_param", value))[0]
    assert (await operator.ask("rosapi/set_param", value))[0]
    assert (await teacher.ask("rosapi/set_param", {**value, "name": "/elsewhere"}))[0]


@on_loop
async def test_what_an_instructor_does_to_the_scene_is_told_with_his_name():
    bench = Bench(rights=asdict(Rights.read("")))
    on = {"data": True}
    answers = iter([SetBoolResponse(success=True), SetBoolResponse(success=False)])
    bench.ros.services_offered = {
        "/telex/sim/move": lambda _: next(answers),
        "/telex/sim/reset": lambda _: SetBoolResponse(success=True),
    }
    await bench.shared.actions.run()
    teacher, trainee = Client(bench, instructor=True), Client(bench)
    bench.control.rename(teacher.member, "Bob")
    assert (await teacher.ask("sim/move", on))[0]
    assert not (await teacher.ask("sim/move", on))[1]["success"]  # refused: nothing was done
    assert (await teacher.ask("sim/reset", on))[0]  # the simulator tells of it itself
    done, why = await trainee.ask("sim/move", on)
    assert not done
    assert "open to instructors only" in why
    told = [message for topic, message in bench.ros.published if topic == "/telex/bridge/actions"]
    assert [(each.by, each.service, json.loads(each.request)) for each in told] == [
        ("Bob", "sim/move", on)
    ]


@on_loop
async def test_a_key_that_was_held_while_refused_must_be_pressed_anew():
    bench = Bench()
    first, second = await driver(bench), await driver(bench)
    clock = Clock(second)
    first.say("publish", topic=DRIVE, msg=AHEAD)
    for _ in range(3):
        second.say("publish", topic=DRIVE, msg={"linear": {"x": 0.5}})
        clock.now += 0.02
    first.session.close()
    second.say("publish", topic=DRIVE, msg={"linear": {"x": 0.5}})
    assert driven(bench) == [1.0, 0.0]
    second.say("publish", topic=DRIVE, msg=STILL)
    second.say("publish", topic=DRIVE, msg={"linear": {"x": 0.5}})
    assert driven(bench) == [1.0, 0.0, 0.0, 0.5]


@on_loop
async def test_a_watchers_stop_does_not_release_the_operators_key():
    bench = Bench()
    first, second = await driver(bench), await driver(bench)
    first.say("publish", topic=DRIVE, msg=AHEAD)
    second.say("publish", topic=DRIVE, msg=STILL)
    second.session.close()
    assert driven(bench) == [1.0]
    assert second.member.dropped == 0
    first.say("publish", topic=DRIVE, msg=STILL)
    assert driven(bench) == [1.0, 0.0]


@on_loop
async def test_a_stop_takes_no_control():
    bench = Bench()
    client = await driver(bench)
    client.say("publish", topic=DRIVE, msg=STILL)
    assert driven(bench) == [0.0]
    assert bench.control.holder is None


# Emergency stop


@on_loop
async def test_everybody_may_set_the_e_stop_and_only_the_operator_release_it():
    bench = Bench()
    operator, watcher = await driver(bench), Client(bench)
    operator.say("publish", topic=DRIVE, msg=AHEAD)
    teacher = Client(bench, instructor=True)
    for client in (operator, watcher, teacher):
        client.say("advertise", topic=E_STOP, type="std_msgs/Bool")
    await bench.settle()
    del bench.ros.published[:]
    watcher.say("publish", topic=E_STOP, msg={"data": True}, sent=1000)
    watcher.say("publish", topic=E_STOP, msg={"data": False})
    assert bench.ros.published == [(E_STOP, Bool(True))]
    teacher.say("publish", topic=E_STOP, msg={"data": False})
    operator.say("publish", topic=E_STOP, msg={"data": False})
    assert bench.ros.published[1:] == [(E_STOP, Bool(False))] * 2
    assert watcher.member.dropped == 1


@on_loop
async def test_the_e_stop_depends_on_no_list_of_rights():
    bench = Bench(rights={"operator": {"publish": ["*", "!stop_all"]}}, e_stop_topic="stop_all")
    client, other = Client(bench), Client(bench)
    client.say("publish", topic="stop_all", type="std_msgs/Bool", msg={"data": True})
    await bench.settle()
    assert [(topic, message.data) for topic, message in bench.ros.published] == [
        ("/telex/stop_all", True)
    ]
    bench.control.take(other.member)
    client.say("publish", topic="stop_all", msg={"data": False})
    await bench.settle()
    assert len(bench.ros.published) == 1


@on_loop
async def test_the_first_e_stop_does_not_wait_for_a_publisher_of_its_own():
    bench = Bench(connect_timeout=5.0)
    ready = await bench.publishers.acquire(E_STOP, "std_msgs/Bool", latch=False, queue_size=1)
    await ready.settle(0.0)
    client = Client(bench)
    client.say("publish", topic=E_STOP, type="std_msgs/Bool", msg={"data": True})
    assert bench.ros.published == [(E_STOP, Bool(True))]


# Age


@on_loop
async def test_old_commands_are_dropped_and_old_stops_are_not():
    bench = Bench(max_command_age=0.15)
    client = await driver(bench)
    client.say("publish", topic=DRIVE, msg=AHEAD, sent=5000.0)
    client.say("publish", topic=DRIVE, msg={"linear": {"x": 2.0}}, sent=4700.0)
    assert driven(bench) == [1.0]
    assert client.member.dropped == 1
    client.say("publish", topic=DRIVE, msg=STILL, sent=4700.0)
    client.say("publish", topic=DRIVE, msg={"linear": {"x": 3.0}})  # does not tell
    assert driven(bench) == [1.0, 0.0, 3.0]
    for sent in ("now", True, [1], float("1e308") * 10):
        client.say("publish", topic=DRIVE, msg=AHEAD, sent=sent)
        said = (await client.hear())["msg"]
        assert "'sent' must be a number" in said or "no JSON number" in said
    assert driven(bench) == [1.0, 0.0, 3.0]


@on_loop
async def test_a_command_ages_while_it_waits_for_its_publisher():
    bench = Bench(max_command_age=0.01, connect_timeout=0.2)
    bench.ros.expected = 1
    client = Client(bench)
    client.say("advertise", topic=DRIVE, type=TWIST)
    client.say("publish", topic=DRIVE, msg=AHEAD, sent=5000.0)
    await asyncio.sleep(0.05)
    bench.ros.connected = 1
    await bench.settle()
    assert driven(bench) == []
    assert client.member.dropped == 1


@on_loop
async def test_a_key_that_is_held_while_its_publisher_connects_drives_once_it_has():
    bench = Bench(max_command_age=0.09, connect_timeout=10.0)
    bench.ros.expected = 1
    client = Client(bench)
    clock = Clock(client)
    client.say("set_level", level="warning")
    client.say("advertise", topic=DRIVE, type=TWIST)
    for number in range(1, 10):
        msg = {"linear": {"x": float(number)}}
        client.say("publish", topic=DRIVE, msg=msg, sent=clock.said_at())
        clock.now += 0.02
    await bench.settle()
    assert driven(bench) == []
    bench.ros.connected = 1
    await wait_until_async(lambda: driven(bench))
    client.say("publish", topic=DRIVE, msg={"linear": {"x": 10.0}}, sent=clock.said_at())
    # What waited too long is dropped, and counts for nothing: the key is the one that was pressed.
    assert driven(bench) == [6.0, 7.0, 8.0, 9.0, 10.0]
    assert client.member.dropped == 5
    assert len(client.outbox) == 0


@on_loop
async def test_what_is_said_once_is_not_lost_while_its_publisher_connects():
    bench = Bench(max_command_age=0.02, connect_timeout=5.0)
    bench.ros.expected = 1
    client = Client(bench)
    lamp = "/telex/lamps/front/command"
    client.say("advertise", topic=lamp, type="std_msgs/Float64")
    sent = 1e3 * asyncio.get_running_loop().time()
    client.say("publish", topic=lamp, msg={"data": 1.0}, sent=sent)
    await asyncio.sleep(0.1)
    bench.ros.connected = 1
    await bench.settle()
    assert [message.data for topic, message in bench.ros.published if topic == lamp] == [1.0]


def test_age_is_told_by_the_quickest_message():
    age = CommandAge(0.15, 1.0)
    assert age.of(100.0, 7.0) == 0.0
    assert age.of(100.02, 7.05) == pytest.approx(0.03, abs=1e-4)
    assert age.of(101.0, 7.9) == 0.0  # quicker by 0.1 s: the first was slow itself
    assert age.of(101.02, 8.02) == pytest.approx(0.1, abs=1e-3)


def test_a_burst_after_a_gap_is_old():
    age = CommandAge(0.15, 1.0)
    for tick in range(50):
        age.of(0.02 * tick, 10.0 + 0.02 * tick)
    held_up = [age.of(1.0 + 0.02 * tick, 13.0) for tick in range(50)]
    assert held_up[0] == pytest.approx(2.0, abs=0.01)
    assert held_up[-1] == pytest.approx(1.02, abs=0.01)


class Line:
    """A client whose messages take a while, and what the bridge makes of them."""

    def __init__(self):
        self.age = CommandAge(0.15, 1.0)
        self.now = 100.0  # s, on the client's clock
        self.free = 0.0  # when the line has carried all that was sent before
        self.told = []

    def _send(self, delay, *, command):
        arrival = max(self.now + delay, self.free) + 900.0  # the clocks need not agree
        self.free = arrival - 900.0
        self.told.append((self.now, self.age.of(self.now, arrival)))
        if command:
            self.age.note_command(self.told[-1][1], arrival)

    def press(self, duration, delay):
        """Send commands for a while (s); return the ages of those."""
        first = len(self.told)
        end = self.now + duration
        while self.now < end:
            self._send(delay, command=True)
            self.now += 0.02
        return [age for _, age in self.told[first:]]

    def rest(self, duration, delay, ping=0.5):
        end = self.now + duration
        while self.now + ping <= end:
            self.now += ping
            self._send(delay, command=False)
        self.now = end

    def obeyed_after(self, ages):
        """Return the time (s) after which all of a press is obeyed."""
        late = [index for index, age in enumerate(ages) if age > 0.15]
        return 0.02 * (late[-1] + 1) if late else 0.0


@pytest.mark.parametrize("pings", [0.5, 1e9])
@pytest.mark.parametrize("slower", [0.2, 0.35, 0.9])
def test_a_line_that_has_become_slower_is_learnt_once_keys_were_pressed_anew(pings, slower):
    line = Line()
    line.press(1.0, 0.01)
    held = line.press(20.0, 0.01 + slower)
    assert min(held) > 0.15  # however long the key is held
    line.rest(0.32, 0.01 + slower, pings)
    assert line.obeyed_after(line.press(2.0, 0.01 + slower)) < 0.6
    assert line.age.slower == pytest.approx(slower, abs=0.02)
    assert max(line.press(0.2, 0.01 + slower + 0.3)) > 0.15  # and now this is late
    line.press(2.0, 0.01)
    assert line.age.slower < 0.001
    assert max(line.press(0.5, 0.01 + slower)) > 0.15


def test_a_line_that_has_become_slower_in_a_pause_is_learnt_by_pings():
    line = Line()
    line.press(1.0, 0.01)
    line.rest(2.0, 0.4)
    assert max(line.press(1.0, 0.4)) < 0.15


def test_a_line_that_is_too_slow_is_never_learnt():
    line = Line()
    line.press(1.0, 0.01)
    for _ in range(3):
        line.rest(2.0, 1.2)
        assert min(line.press(2.0, 1.2)) > 0.15


@pytest.mark.parametrize("gap", [0.4, 1.0, 3.0])
@pytest.mark.parametrize("drain", [0.0, 0.005, 0.01])
def test_what_a_gap_held_up_is_never_obeyed(gap, drain):
    """However the operator taps meanwhile, and however fast the queue is emptied afterwards."""
    line = Line()
    line.press(1.0, 0.01)
    begins, ends = line.now, line.now + gap
    while line.now < ends + 3.0:
        for _ in range(8):  # taps of 0.16 s with 0.36 s between them
            behind = max(0.0, ends - line.now) if line.now >= begins else 0.0
            line.free += drain
            line._send(0.01 + behind, command=True)
            line.now += 0.02
        line.now += 0.36
    for sent, age in line.told:
        if begins <= sent < ends - 0.2:
            assert age > 0.15


def test_clocks_that_drift_apart_do_not_make_commands_old():
    age = CommandAge(0.15, 1.0)
    drifting = [age.of(second * 0.9998, float(second)) for second in range(7200)]
    assert max(drifting) < 0.001


@on_loop
async def test_the_page_is_told_when_a_slower_line_counts():
    bench = Bench(max_command_age=0.15)
    client = await driver(bench)
    clock = Clock(client)
    client.say("set_level", level="warning")

    def press(duration, late):
        for _ in range(round(duration / 0.02)):
            client.say("publish", topic=DRIVE, msg=AHEAD, sent=clock.said_at(late))
            clock.now += 0.02

    press(0.1, 0.0)
    obeyed = len(driven(bench))
    press(0.1, 0.35)
    status = (await client.hear())["msg"]
    assert "the command came 0.35 s late; 0.15 s are allowed. Let go, and press anew" in status
    assert len(driven(bench)) == obeyed
    clock.now += 0.35
    press(0.6, 0.35)
    said = [(await client.hear())["msg"] for _ in range(len(client.outbox))]
    assert said[-2:] == [
        "commands came late, and will count again when the line is steady",
        "the line has become slower, by 0.35 s; commands count again",
    ]
    assert len(driven(bench)) > obeyed
    assert bench.control.holder is client.member


# What stops

GOAL = "/telex/flipper_teleop/preset/goal"
CANCEL = "/telex/flipper_teleop/preset/cancel"
GOAL_TYPE = "telex_msgs/FlipperPresetActionGoal"
HIGH = {"goal_id": {"id": "g1"}, "goal": {"preset": "high"}}


@on_loop
async def test_goals_are_cancelled_with_their_client():
    bench = Bench()
    client = Client(bench)
    client.say("advertise", topic=GOAL, type=GOAL_TYPE)
    client.say("publish", topic=GOAL, msg=HIGH)
    client.say("publish", topic=GOAL, msg={"goal": {"preset": "low"}})
    await wait_until_async(lambda: len(bench.ros.published) == 2)
    (_, first), (_, second) = bench.ros.published
    assert first.goal_id.id == "g1"
    assert second.goal_id.id  # made up, so that it can be cancelled
    del bench.ros.published[:]
    client.session.close()
    assert [(topic, message.id) for topic, message in bench.ros.published] == [
        (CANCEL, "g1"),
        (CANCEL, second.goal_id.id),
    ]
    await wait_until_async(lambda: len(bench.publishers) == 0)


@on_loop
async def test_goals_end_with_their_results_and_are_bounded():
    bench = Bench()
    client = Client(bench)
    client.say("advertise", topic=GOAL, type=GOAL_TYPE)

    def send(number):
        client.say("publish", topic=GOAL, msg={"goal_id": {"id": f"g{number}"}})

    for number in range(MAX_GOALS):
        send(number)
        if number % 10 == 9:  # of more that wait for their servers the oldest would be lost
            await wait_until_async(lambda number=number: len(bench.ros.published) == number + 1)
    send(MAX_GOALS)
    assert f"the results of {MAX_GOALS} goals of this client" in (await client.hear())["msg"]
    for number in range(3):
        result = FlipperPresetActionResult()
        result.status.goal_id.id = f"g{number}"
        bench.ros.receivers[GOAL.replace("goal", "result")](result, None)
    await bench.settle()
    send(MAX_GOALS + 1)
    await wait_until_async(lambda: len(bench.ros.published) == MAX_GOALS + 1)
    del bench.ros.published[:]
    client.session.close()
    left = [*range(3, MAX_GOALS), MAX_GOALS + 1]
    assert [message.id for _, message in bench.ros.published] == [f"g{number}" for number in left]


TF = "/tf2_web_republisher"
TF_GOAL = "tf2_web_republisher/TFSubscriptionActionGoal"


@on_loop
async def test_goals_of_other_clients_are_neither_cancelled_nor_taken_over():
    bench = Bench()
    owner, other = Client(bench), Client(bench, instructor=True)
    goal = {"topic": f"{TF}/goal", "type": TF_GOAL}
    cancel = {"topic": f"{TF}/cancel", "type": "actionlib_msgs/GoalID", "msg": {"id": "g1"}}
    owner.say("publish", **goal, msg={"goal_id": {"id": "g1"}})
    await wait_until_async(lambda: len(bench.ros.published) == 1)
    other.say("publish", **cancel)
    assert "this goal is another client's" in (await other.hear())["msg"]
    other.say("publish", **goal, msg={"goal_id": {"id": "g1"}})
    assert "another client's goal has this id" in (await other.hear())["msg"]
    for all_of_them in ({}, {"id": "g2", "stamp": {"secs": 2_000_000_000}}):
        other.say("publish", topic=f"{TF}/cancel", msg=all_of_them)
        assert "would cancel goals of other clients" in (await other.hear())["msg"]
    other.session.close()
    await bench.settle()
    assert len(bench.ros.published) == 1
    owner.say("publish", **cancel)
    await wait_until_async(lambda: len(bench.ros.published) == 2)
    assert bench.ros.published[1][1].id == "g1"
    owner.say("publish", topic=f"{TF}/cancel", msg={})  # all of one's own
    await wait_until_async(lambda: len(bench.ros.published) == 3)


@on_loop
async def test_the_id_of_a_goal_is_bounded():
    bench = Bench()
    client = Client(bench)
    client.say("publish", topic=GOAL, type=GOAL_TYPE, msg={"goal_id": {"id": "g" * 1001}})
    assert "the goal's id has 1001 characters; at most 1000" in (await client.hear())["msg"]
    client.say("publish", topic=GOAL, msg={"goal_id": {"id": "g" * 1000}})
    await wait_until_async(lambda: len(bench.ros.published) == 1)


@on_loop
async def test_goals_are_forgotten_though_they_cannot_be_cancelled():
    bench = Bench()
    clients = [Client(bench), Client(bench)]
    for number, client in enumerate(clients, start=1):
        client.say("publish", topic=f"{TF}/goal", type=TF_GOAL, msg={"goal_id": {"id": "g1"}})
        await wait_until_async(lambda number=number: len(bench.ros.published) == number)
        with mock.patch.object(SharedPublisher, "publish", side_effect=OperationError("closed")):
            client.session.close()


@on_loop
async def test_a_goal_waits_until_its_answers_can_come_back():
    bench = Bench(action_timeout=5.0, max_command_age=0.01)
    bench.ros.action_ready = False
    client = Client(bench)
    now = 1e3 * asyncio.get_running_loop().time()
    client.say("advertise", topic=GOAL, type=GOAL_TYPE, sent=now)
    client.say("publish", topic=GOAL, msg=HIGH, sent=now)
    await bench.settle()
    client.say("publish", topic=GOAL, msg={"goal": {"preset": "low"}})
    await bench.settle()
    assert bench.ros.published == []
    assert ("ask", "/telex/flipper_teleop/preset") in bench.ros.events
    bench.ros.action_ready = True
    await wait_until_async(lambda: len(bench.ros.published) == 2)
    assert [message.goal.preset for _, message in bench.ros.published] == ["high", "low"]


@on_loop
async def test_of_more_goals_than_can_wait_each_that_is_dropped_is_told():
    bench = Bench(action_timeout=5.0)
    bench.ros.action_ready = False
    client = Client(bench)
    for number in range(MAX_HELD + 2):
        goal = {"goal": {"preset": f"p{number}"}}
        client.say("publish", topic=GOAL, type=GOAL_TYPE, id=f"op{number}", msg=goal)
    for number in range(2):
        status = await client.hear()
        assert (status["op"], status["id"]) == ("status", f"op{number}")
        assert f"publish to {GOAL}: dropped; {MAX_HELD} newer goals wait" in status["msg"]
    bench.ros.action_ready = True
    await wait_until_async(lambda: len(bench.ros.published) == MAX_HELD)
    assert bench.ros.published[0][1].goal.preset == "p2"


@on_loop
async def test_a_goal_waits_only_so_long():
    bench = Bench(action_timeout=0.05)
    bench.ros.action_ready = False
    client = Client(bench)
    client.say("set_level", level="warning")
    client.say("publish", topic=GOAL, type=GOAL_TYPE, msg=HIGH)
    said = (await client.hear())["msg"]
    sentence = f"servers of {GOAL} are not connected within 0.05 s; answers may be lost"
    assert said == f"publish: {sentence}"
    assert [message.goal.preset for _, message in bench.ros.published] == ["high"]


@on_loop
async def test_a_goal_that_waits_is_forgotten_with_its_client():
    bench = Bench(action_timeout=5.0)
    bench.ros.action_ready = False
    client = Client(bench)
    client.say("publish", topic=GOAL, type=GOAL_TYPE, msg=HIGH)
    await bench.settle()
    client.session.close()
    bench.ros.action_ready = True
    await wait_until_async(lambda: len(bench.publishers) == 0)
    assert bench.ros.published == []


def test_a_trajectory_is_stopped_by_an_empty_one():
    trajectory = JointTrajectory(joint_names=["a"], points=[JointTrajectoryPoint(positions=[1.0])])
    assert stop_for(trajectory) == JointTrajectory()
    assert stop_for(JointTrajectory(joint_names=["a"])) is None


@on_loop
async def test_old_commands_are_not_replayed_to_nodes_that_start_later():
    bench = Bench()
    client = Client(bench)
    client.say("advertise", topic=DRIVE, type=TWIST, latch=True)
    client.say("advertise", topic="/telex/jog", type=JOG, latch=True)
    client.say("advertise", topic="/telex/text", type="std_msgs/String", latch=True)
    await bench.settle()
    latched = {event[1]: event[3] for event in bench.ros.events}
    assert latched == {DRIVE: False, "/telex/jog": False, "/telex/text": True}


@on_loop
async def test_a_command_that_waits_is_forgotten_when_control_is_lost():
    bench = Bench(connect_timeout=5.0)
    bench.ros.expected = 1
    client = Client(bench)
    client.say("advertise", topic=DRIVE, type=TWIST)
    client.say("publish", topic=DRIVE, msg=AHEAD)
    await bench.settle()
    client.member.stop()
    bench.ros.connected = 1
    await bench.settle()
    assert driven(bench) == []


# Lists


@on_loop
async def test_only_what_is_listed_may_be_used():
    names = {"publish": ["*", "!secret"], "subscribe": ["joint_states"], "serve": ["/mine/*"]}
    bench = Bench(rights={"operator": names, "instructor": {"call": ["/*"]}})
    client = Client(bench)
    for op, name in (
        ("advertise", "/other/chat"),
        ("publish", "secret"),
        ("subscribe", "/known"),
    ):
        client.say(op, topic=name, type="std_msgs/String", id=op)
        status = await client.hear()
        assert (status["id"], status["op"]) == (op, "status")
        assert "is not open to clients (" in status["msg"]
    client.say("advertise_service", service="/other/x", type="std_srvs/Empty")
    assert "'serve' in the file" in (await client.hear())["msg"]
    assert "is open to instructors only" in (await client.ask("switch", {"data": True}))[1]
    assert "'set' in the file" in (await client.ask("rosapi/set_param", ["limit", "1"]))[1]
    assert "'set' in the file" in (await client.ask("rosapi/delete_param", ["limit"]))[1]
    assert "'get' in the file" in (await client.ask("rosapi/get_param", ["limit"]))[1]
    client.say("subscribe", topic="joint_states")
    client.say("advertise", topic="chat", type="std_msgs/String")
    client.say("advertise_service", service="/mine/x", type="std_srvs/Empty")
    await bench.settle()
    assert [event[:2] for event in bench.ros.events] == [
        ("subscribe", "/telex/joint_states"),
        ("advertise", "/telex/chat"),
    ]
    assert list(bench.ros.services_offered) == ["/mine/x"]
    assert len(client.outbox) == 0


_ALL = UseLists(**dict.fromkeys(vars(UseLists()), ("/*",)))
EVERYTHING = Rights(operator=_ALL, instructor=_ALL)
"""A file that gives everything to everybody."""


def shipped(*, instructor, **kind):
    return Access(Rights.read(), FakeRos().resolve, "e_stop", instructor=instructor, **kind)


OPERATORS_OWN = {
    "publish": (
        *("e_stop", "arm_teleop/delta_joint_cmds", "arm_teleop/delta_twist_cmds"),
        *("arm_teleop/named_pose_cmds", "arm_teleop/pose_cmds", "gripper_teleop/delta_joint_cmds"),
        *("flipper_teleop/delta_joint_cmds", "flipper_teleop/preset_cmds"),
        *("track_teleop/cmd_vel", "track_teleop/speed_scale", "arm_teleop/speed_scale"),
        *("cameras/turret/zoom", "lamps/front/command", "turret_position_controller/command"),
        *("flipper_teleop/preset/goal", "track_controller/cmd_vel", "/chatter"),
        "arm_trajectory_controller/follow_joint_trajectory/goal",
        *("/tf2_web_republisher/goal", "/tf2_web_republisher/cancel"),
    ),
    "subscribe": (
        *("joint_states", "/tf", "/clock", "imu", "sim/status", "sim/stability"),
        *("sim/gripper_contact", "arm_teleop/status", "bridge/clients", "/chatter", "battery"),
        "/tf2_web_republisher/feedback",
        *("cameras/front/image_raw/compressed", "arm_teleop/cartesian_status"),
    ),
    "call": (
        *("arm_teleop/set_mode", "arm_teleop/hold_tool", "arm_teleop/compute_ik"),
        *("controller_manager/list_controllers", "controller_manager/switch_controller"),
        "/add_two_ints",
    ),
    "serve": ("/add_two_ints",),
    "set": (),
    "get": (
        *("robot_description", "gripper_controller/geometry", "/run_id"),
        "cameras/cameras/turret/zoom_max",
    ),
}
INSTRUCTORS_ONLY = {
    "publish": (*("cameras/overview/view", "imu", "track_controller/odom", "arm_teleop/status"),),
    "subscribe": (
        *("sim/base_pose", "sim/scene", "sim/poses", "/rosout", "/rosout_agg"),
        *("cameras/overview/image_raw/compressed", "cameras/overview/view", "/crane/sim/poses"),
        *("/crane/cameras/overview/image_raw/compressed", "/cameras/overview/image_raw"),
        *("sim/malfunctions", "/crane/sim/malfunctions"),
        *("cameras/radiation", "/crane/cameras/radiation", "bridge/actions"),
        "/crane/bridge/actions",
    ),
    "call": (
        *("sim/move", "sim/delete", "sim/find_place", "sim/list_objects", "sim/set_light"),
        "training/tell",
        *("sim/reset", "sim/pause", "sim/step", "sim/spawn", "sim/load_scene", "sim/list_scenes"),
        *(
            "sim/bookmark",
            "sim/restore",
            "sim/malfunction",
            "sim/list_bookmarks",
            "sim/add_robot",
            "cameras/configure",
            "controller_manager/unload_controller",
        ),
        *("arm_teleop/set_logger_level", "/crane/sim/reset", "/rosout/set_logger_level"),
        *("simulator/anything", "robot_state_publisher/set_logger_level"),
    ),
    "serve": ("switch", "sim/reset"),
    "set": ("robot_description", "limit", "/elsewhere", "/robot_description"),
    "get": (
        *("simulator", "simulator/world", "cameras/overview/start", "sim/x", "/roslaunch/uris"),
        *("/crane/simulator/world", "/crane/cameras/cameras/overview/start"),
    ),
}
NOBODYS = {
    "publish": (
        *("tf", "tf_static"),
        *("/clock", "/tf", "/tf_static", "joint_states", "sim/status", "bridge/clients"),
        *(f"/tf2_web_republisher/{topic}" for topic in ("status", "feedback", "result")),
    ),
    "serve": ("/rosapi/topics", "bridge/time"),
    "set": ("/telex", "/", "/use_sim_time", "/roslaunch", "rosbridge/url", "video_server/token"),
}


OTHER_ROBOTS = {
    "publish": (
        *("/crane/e_stop", "/crane/track_teleop/cmd_vel", "/crane/arm_teleop/delta_joint_cmds"),
        *("/crane/turret_position_controller/command", "/crane/flipper_teleop/preset/goal"),
        *("/crane/cameras/turret/zoom", "/crane/lamps/front/command", "/crane/sim/x"),
        *("/e_stop", "/track_teleop/cmd_vel", "/crane/arm_teleop/speed_scale"),
        *("/crane/cameras/overview/view", "/crane/console/telemetry", "/crane/training/exam"),
        *("/crane/bridge/exam", "/crane/link/state"),
        "/crane/arm_trajectory_controller/follow_joint_trajectory/goal",
    ),
    "call": (
        *("/crane/cameras/configure", "/crane/controller_manager/load_controller"),
        *("/crane/arm_teleop/set_mode", "/crane/track_controller/query_state"),
        *("/crane/sim/malfunction", "/crane/link/configure", "/crane/training/start"),
        *("/crane/controller_manager/switch_controller", "/crane/bridge/end_exam"),
    ),
    "serve": ("/crane/link/configure", "/crane/sim/reset", "/crane/arm_teleop/set_mode"),
    "set": ("/crane/arm_teleop/command_timeout", "/crane/track_controller/linear"),
}
"""What only a robot has by these names, of one that the bridge has not found yet."""
FOUND = {
    "publish": ("/husky/cmd_vel", "/telex/trailer/cmd_vel", "/crane/arm/goal"),
    "call": ("/husky/dock", "/crane/arm_teleop/set_logger_level", "/telex/trailer/dock"),
    "serve": ("/husky/dock",),
    "set": ("/husky/limit", "/husky", "/telex/trailer", "/"),
}
"""What is of a robot that it has found, by whatever name."""


def fitting(access, names):
    resolve = FakeRos().resolve
    pairs = [(use, resolve(name)) for use, listed in names.items() for name in listed]
    return [access.allows(use, name) for use, name in pairs]


@pytest.mark.parametrize(
    ("kind", "expected"),
    [
        ({"instructor": False}, (True, False, False)),
        ({"instructor": False, "plain": True}, (True, True, False)),
        ({"instructor": True}, (True, True, False)),
    ],
)
def test_what_operators_and_instructors_may_as_shipped(kind, expected):
    access = shipped(**kind)
    for names, allowed in zip((OPERATORS_OWN, INSTRUCTORS_ONLY, NOBODYS), expected):
        assert set(fitting(access, names)) == {allowed}


KINDS = [
    {"instructor": instructor, "plain": plain}
    for instructor in (False, True)
    for plain in (False, True)
]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("rights", [Rights.read(), EVERYTHING])
def test_no_client_touches_what_is_another_robots(kind, rights):
    others = OtherRobots("/telex/")
    access = Access(rights, FakeRos().resolve, "e_stop", others=others, **kind)
    before = fitting(access, FOUND)
    assert set(fitting(access, OTHER_ROBOTS)) == {False}
    reviewed = []
    others.changed = lambda: reviewed.append(fitting(access, FOUND))
    marks = [
        f"{robot}/controller_manager/list_controllers"
        for robot in ("", "/telex", "/husky", "/crane", "/telex/trailer")
    ]
    for _ in range(2):  # told of once
        others.note([*marks, "/husky/dock"])
    assert reviewed == [[False] * len(before)]
    own = fitting(access, OPERATORS_OWN)
    assert set(own) == {True}
    with pytest.raises(OperationError, match="/husky/cmd_vel is another robot's, and this bridge"):
        access.check("publish", "/husky/cmd_vel")
    # Its own bridge has its line and its exam, which are for operators.
    hears = access.allows("subscribe", "/husky/odom")
    assert hears == (kind["instructor"] or kind["plain"])
    # The simulator is one for all; only who may call it at all calls it there.
    for name in ("pause", "reset", "spawn", "load_scene", "add_robot", "restore"):
        shared = access.allows("call", f"/crane/sim/{name}")
        assert shared == (kind["instructor"] or kind["plain"] or rights is EVERYTHING)


@on_loop
async def test_what_was_opened_before_a_robot_came_ends_with_its_coming():
    bench = Bench(rights=asdict(EVERYTHING))
    client = Client(bench, instructor=True)
    client.say("advertise", topic="/husky/cmd_vel", type=TWIST)
    client.say("advertise_service", service="/husky/dock", type="std_srvs/Empty")
    await bench.settle()
    client.say("publish", topic="/husky/cmd_vel", msg=AHEAD)
    bench.shared.other_robots.note(["/husky/controller_manager/list_controllers"])
    told = [(await client.hear())["msg"] for _ in range(2)]
    assert all("is another robot's, and this bridge touches nothing but /telex" in m for m in told)
    await bench.settle()
    assert list(bench.ros.services_offered) == []
    client.say("publish", topic="/husky/cmd_vel", type=TWIST, msg=AHEAD, id="late")
    assert (await client.hear())["id"] == "late"
    # What it drove has been stopped, and nothing came after that.
    assert [message.linear.x for _, message in bench.ros.published] == [1.0, 0.0]


def test_a_plain_bridge_asks_operators_for_control_all_the_same():
    operator = shipped(instructor=False, plain=True)
    assert operator.needs_control("call", "/telex/sim/reset")
    assert not shipped(instructor=True).needs_control("call", "/telex/sim/reset")


@on_loop
async def test_with_nobody_in_control_an_operator_may_do_no_more():
    bench = Bench(rights=asdict(Rights.read()))
    client, teacher = Client(bench), Client(bench, instructor=True)
    bench.ros.params.update(
        {"/telex/simulator": {"world": "exam"}, "/telex/robot_description": "x"}
    )
    for service, arguments in (
        ("sim/reset", {}),
        ("sim/pause", {}),
        ("cameras/configure", {}),
        ("rosapi/set_param", {"name": "robot_description", "value": "1"}),
        ("rosapi/get_param", {"name": "simulator"}),
    ):
        succeeded, reason = await client.ask(service, arguments)
        assert not succeeded
        assert "is open to instructors only, who connect with ?role=instructor" in reason
    assert bench.control.holder is None
    assert await teacher.ask("sim/reset") == (False, "there is no service /telex/sim/reset")
    for topic in ("sim/base_pose", "sim/scene", "sim/poses", "cameras/overview/image_raw"):
        client.say("subscribe", topic=topic, type="std_msgs/String")
        assert "is open to instructors only" in (await client.hear())["msg"]
        teacher.say("subscribe", topic=topic, type="std_msgs/String")
    await bench.settle()
    assert len(bench.ros.receivers) == 4
    assert len(teacher.outbox) == 0


@on_loop
async def test_rosapi_tells_of_what_the_client_may_use():
    bench = Bench(rights=asdict(Rights.read()))
    bench.ros.active |= {"/telex/sim/base_pose", "/rosout"}
    bench.ros.expected = 1
    bench.ros.types["/telex/sim/base_pose"] = "geometry_msgs/PoseStamped"
    tree = {"simulator": {"world": "exam"}, "cameras": {"overview": {"start": 1}, "rate": 5}}
    bench.ros.params.update({"/telex": tree, "/telex/simulator/world": "exam"})
    client, teacher = Client(bench), Client(bench, instructor=True)

    async def told(who):
        pose = {"type": "geometry_msgs/PoseStamped"}
        return [
            (await who.ask("rosapi/topics"))[1]["topics"],
            (await who.ask("rosapi/topics_for_type", pose))[1]["topics"],
            "/telex/switch" in (await who.ask("rosapi/services"))[1]["services"],
            "/telex/simulator/world" in (await who.ask("rosapi/get_param_names"))[1]["names"],
            (await who.ask("rosapi/has_param", ["simulator/world"]))[1]["exists"],
            bool((await who.ask("rosapi/topic_type", ["sim/base_pose"]))[1]["type"]),
            bool((await who.ask("rosapi/subscribers", ["sim/base_pose"]))[1]["subscribers"]),
            bool((await who.ask("rosapi/service_type", ["switch"]))[1]["type"]),
            bool((await who.ask("rosapi/service_node", ["switch"]))[1]["node"]),
            bool((await who.ask("rosapi/service_host", ["switch"]))[1]["host"]),
            bool((await who.ask("rosapi/node_details", ["simulator/x"]))[1]["services"]),
            json.loads((await who.ask("rosapi/get_param", ["/telex"]))[1]["value"]),
        ]

    assert await told(client) == [
        *(["/known", "/telex/joint_states"], [], *[False] * 9),
        {"cameras": {"rate": 5}},
    ]
    base_pose = "/telex/sim/base_pose"
    assert await told(teacher) == [
        *(["/known", "/rosout", "/telex/joint_states", base_pose], [base_pose]),
        *[True] * 9,
        tree,
    ]


# Who is who


def test_control_by_itself():
    changes = []
    control = Control(lambda: changes.append(control.holder))
    first, second = (Member(number, "", False, 0.0) for number in "12")
    stopped = []
    first.stop = lambda: stopped.append(control.holder)
    control.join(first)
    control.join(second)
    control.take(first)
    control.take(first)
    assert stopped == []
    control.rename(first, "Ann")
    with pytest.raises(ControlError, match=r"^Ann \(client 1\) holds control"):
        control.take(second)
    for name in ("x" * 41, "two\nlines"):
        with pytest.raises(OperationError, match="a name is one line"):
            control.rename(second, name)
    control.release(first)
    assert stopped == [first]  # it is the holder until it has stopped
    control.leave(first)
    assert control.members == [second]
    assert changes == [None, None, first, first, None, None]


@on_loop
async def test_clients_can_have_a_name_and_ask_the_time():
    client = Client(Bench())
    assert (await client.ask("bridge/set_name", ["Ann"]))[1]["success"]
    assert client.member.shown == "Ann (client 1)"
    assert not (await client.ask("bridge/set_name", {"name": 5}))[1]["success"]
    now = (await client.ask("bridge/time"))[1]["time"]
    assert now["secs"] > 1.7e9
    kind = {"service": "bridge/time"}
    assert (await client.ask("rosapi/service_type", kind))[1] == {"type": "telex_msgs/GetWallTime"}
