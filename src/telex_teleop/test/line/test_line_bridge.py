"""The line before the bridge: what clients send and get comes late, in order."""

from __future__ import annotations

import asyncio
import random
import time

import pytest
from bridge_bench import TWIST, Bench, Client
from std_msgs.msg import Bool
from waiting import wait_until_async
from web_fakes import HUNG, on_loop

from telex_teleop.web.bridge.clients.outbox import Outbox
from telex_teleop.web.bridge.link.downlink import Downlink
from telex_teleop.web.line.fields import PERFECT, LineFields
from telex_teleop.web.line.line import Line
from telex_teleop.web.link.waits import LONGEST, LinePump

DRIVE, E_STOP = "/telex/track_teleop/cmd_vel", "/telex/e_stop"
AHEAD, STILL = {"linear": {"x": 1.0}}, {"linear": {"x": 0.0}}


class Delayed:
    """A bench whose sim time a test moves on, and one driver on a line with a delay of 0.5 s."""

    def __init__(self, rights=None, **fields):
        self.bench = Bench(rights)
        self.fields = LineFields(**{"delay": 0.5, **fields})

    async def driver(self, **kind):
        client = Client(self.bench, **kind)
        client.say("advertise", topic=DRIVE, type=TWIST)
        client.say("advertise", topic=E_STOP, type="std_msgs/Bool")
        await self.bench.settle()
        return client

    def begin(self):
        self.bench.ros.time = 100.0
        self.bench.shared.line.configure(self.fields, 100.0)

    async def go_to(self, moment):
        self.bench.ros.time = 100.0 + moment
        await asyncio.sleep(LONGEST + 0.03)

    @property
    def driven(self):
        return [message.linear.x for topic, message in self.bench.ros.published if topic == DRIVE]


@on_loop
async def test_commands_and_stops_come_late_and_in_order():
    delayed = Delayed()
    client = await delayed.driver()
    delayed.begin()
    for value in (AHEAD, STILL):
        client.say("publish", topic=DRIVE, msg=value, sent=1000.0 * time.time())
    await delayed.go_to(0.45)
    assert delayed.driven == []
    await delayed.go_to(0.5)
    # 0.26 s have passed by the clock by which the age of commands is judged
    assert delayed.driven == [1.0, 0.0]
    assert client.member.dropped == 0


@on_loop
async def test_the_age_that_is_judged_is_that_on_arrival():
    delayed = Delayed()
    client = await delayed.driver()
    delayed.begin()
    now = 1000.0 * time.time()
    client.say("publish", topic=DRIVE, msg=AHEAD, sent=now)
    client.say("publish", topic=DRIVE, msg=AHEAD, sent=now - 400.0)
    await delayed.go_to(0.6)
    assert delayed.driven == [1.0]
    assert client.member.dropped == 1


@on_loop
async def test_the_end_of_a_client_is_the_last_that_it_sends():
    delayed = Delayed()
    client = await delayed.driver()
    delayed.begin()
    client.say("publish", topic=DRIVE, msg=AHEAD)
    await delayed.go_to(0.3)
    client.say("publish", topic=DRIVE, msg=AHEAD)
    client.session.close()
    await delayed.go_to(0.6)
    assert delayed.driven == [1.0]
    assert delayed.bench.control.holder is client.member
    await delayed.go_to(0.8)
    assert delayed.driven == [1.0, 1.0, 0.0]
    assert delayed.bench.control.holder is None


@on_loop
async def test_nothing_ages_while_the_simulation_is_paused():
    delayed = Delayed()
    client = await delayed.driver()
    delayed.begin()
    client.say("publish", topic=E_STOP, msg={"data": True})
    await asyncio.sleep(0.7)
    assert not any(isinstance(message, Bool) for _, message in delayed.bench.ros.published)
    await delayed.go_to(0.5)
    assert delayed.bench.ros.published[-1] == (E_STOP, Bool(True))


@on_loop
async def test_an_instructor_has_no_line_and_his_hand_over_calls_commands_back():
    delayed = Delayed()
    client = await delayed.driver()
    instructor = await delayed.driver(instructor=True)
    client.say("publish", topic=DRIVE, msg=AHEAD)
    delayed.begin()
    client.say("publish", topic=DRIVE, msg={"linear": {"x": 0.7}})
    client.say("publish", topic=E_STOP, msg={"data": True})
    client.say("call_service", service="switch", args={"data": True}, id="s")
    assert (await instructor.ask("bridge/take_control"))[0]
    instructor.say("publish", topic=DRIVE, msg={"linear": {"x": 0.3}})
    answer = await client.hear()
    assert (answer["id"], answer["result"]) == ("s", False)
    assert "client 2 took control" in answer["values"]
    await delayed.go_to(0.6)
    assert delayed.driven == [1.0, 0.0, 0.3]
    assert client.member.dropped == 1
    # An emergency stop is not called back.
    assert (E_STOP, Bool(True)) in delayed.bench.ros.published


def _release_and_drive(client):
    client.say("publish", topic=E_STOP, msg={"data": False})
    client.say("publish", topic=DRIVE, msg=AHEAD)


def _published(delayed):
    return [
        (topic, message.data if topic == E_STOP else message.linear.x)
        for topic, message in delayed.bench.ros.published
    ]


@on_loop
async def test_an_instructors_e_stop_calls_back_a_release_though_it_was_set_already():
    delayed = Delayed()
    client = await delayed.driver()
    instructor = await delayed.driver(instructor=True)
    delayed.begin()
    client.say("publish", topic=E_STOP, msg={"data": True})
    await delayed.go_to(0.5)
    _release_and_drive(client)
    client.say("publish", topic=E_STOP)  # what is left out is false
    await delayed.go_to(0.7)
    instructor.say("publish", topic=E_STOP, msg={"data": True})
    await delayed.go_to(1.2)
    assert _published(delayed) == [(E_STOP, True), (E_STOP, True)]
    assert client.member.dropped == 3
    client.say("publish", topic=E_STOP, msg={"data": False})
    await delayed.go_to(1.8)
    assert _published(delayed)[2:] == [(E_STOP, False)]


@on_loop
async def test_an_operators_e_stop_calls_back_what_others_sent_and_not_his_own_release():
    delayed = Delayed()
    client, other = await delayed.driver(), await delayed.driver()
    delayed.begin()
    _release_and_drive(client)
    await delayed.go_to(0.3)
    other.say("publish", topic=E_STOP, msg={"data": True})
    await delayed.go_to(0.5)
    _release_and_drive(client)
    await delayed.go_to(1.1)
    assert _published(delayed) == [(E_STOP, False), (DRIVE, 1.0), (E_STOP, True)]
    assert client.member.dropped == 2
    client.say("publish", topic=E_STOP, msg={"data": True})
    _release_and_drive(client)
    await delayed.go_to(1.6)
    assert _published(delayed)[3:] == [(E_STOP, True), (E_STOP, False), (DRIVE, 1.0)]


@on_loop
async def test_an_e_stop_is_never_called_back_nor_does_another_topic_call_back():
    delayed = Delayed()
    client = await delayed.driver()
    instructor = await delayed.driver(instructor=True)
    delayed.begin()
    _release_and_drive(client)
    instructor.say("publish", topic="/rover/e_stop", type="std_msgs/Bool", msg={"data": True})
    instructor.say("publish", topic=E_STOP, msg={"data": False})
    await delayed.go_to(0.6)
    assert [each for each in _published(delayed) if each[0] != "/rover/e_stop"] == [
        *((E_STOP, False), (E_STOP, False), (DRIVE, 1.0))
    ]
    client.say("publish", topic=E_STOP, msg={"data": True})
    instructor.say("publish", topic=E_STOP, msg={"data": True})
    await delayed.go_to(1.2)
    assert [value for topic, value in _published(delayed) if topic == E_STOP][-2:] == [True, True]
    assert client.member.dropped == 0


@on_loop
async def test_no_release_gets_lost_on_a_bad_line():
    delayed = Delayed(delay=0.0, loss=0.9)
    client = await delayed.driver()
    delayed.begin()
    for _ in range(20):
        client.say("publish", topic=E_STOP, msg={"data": False})
    for moment in range(1, 4):
        await delayed.go_to(moment)
    assert _published(delayed) == [(E_STOP, False)] * 20


@on_loop
async def test_of_commands_some_get_lost_and_no_stop():
    delayed = Delayed(delay=0.0, loss=0.5)
    client = await delayed.driver()
    delayed.begin()
    for _ in range(200):
        client.say("publish", topic=DRIVE, msg=AHEAD)
    for _ in range(20):
        client.say("publish", topic=DRIVE, msg=STILL)
    for moment in range(1, 12):
        delayed.bench.ros.time = 100.0 + moment
        await asyncio.sleep(0.03)
    await wait_until_async(lambda: delayed.driven.count(0.0) == 20)
    assert 60 < delayed.driven.count(1.0) < 140


@on_loop
async def test_what_is_under_way_when_the_line_becomes_perfect_keeps_its_order():
    delayed = Delayed()
    client = await delayed.driver()
    delayed.begin()
    client.say("publish", topic=DRIVE, msg=AHEAD)
    delayed.bench.shared.line.configure(PERFECT, 100.1)
    client.say("publish", topic=DRIVE, msg=STILL)
    assert delayed.driven == []
    await delayed.go_to(0.5)
    assert delayed.driven == [1.0, 0.0]
    client.say("publish", topic=DRIVE, msg=AHEAD)
    assert delayed.driven[-1] == 1.0


@on_loop
async def test_bad_messages_are_complained_of_and_hold_nothing_up():
    delayed = Delayed(delay=0.0, jitter=0.01)
    client = await delayed.driver()
    delayed.begin()
    client.session.receive("{")
    client.say("fly")
    client.say("publish", topic=17)
    client.say("call_service", service=["x"])
    client.say("publish", topic=DRIVE, msg=AHEAD)
    await delayed.go_to(0.1)
    texts = [(await client.hear())["msg"] for _ in range(4)]
    assert any("no operation 'fly'" in text for text in texts)
    assert delayed.driven == [1.0]


@on_loop
async def test_messages_to_a_client_come_late_and_in_order():
    now = [100.0]
    outbox, line = Outbox(10000), Line(random.Random(1))
    downlink = Downlink(outbox, line, lambda: now[0])
    outbox.put_reply("a")
    assert await downlink.get() == "a"
    line.configure(LineFields(delay=0.5), 100.0)
    outbox.put_reply("b")
    getting = asyncio.ensure_future(downlink.get())
    await asyncio.sleep(0.05)
    line.configure(PERFECT, 100.1)
    outbox.put_reply("c")
    await asyncio.sleep(0.15)
    assert not getting.done()
    now[0] = 100.5
    assert [await getting, await downlink.get()] == ["b", "c"]
    outbox.put_reply("d")
    assert await asyncio.wait_for(downlink.get(), HUNG) == "d"
    downlink.close()


@on_loop
async def test_the_pump_outlives_work_that_fails():
    done = []

    def work(_now):
        done.append(1)
        if len(done) == 1:
            raise ValueError("broken")

    asyncio.get_running_loop().set_exception_handler(lambda *_: None)
    pump = LinePump(time.monotonic, work)
    with pytest.raises(ValueError, match="broken"):
        pump.run()
    await wait_until_async(lambda: len(done) == 2)
