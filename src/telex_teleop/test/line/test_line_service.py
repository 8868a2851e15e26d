"""The service that sets the line, and what it tells of it."""

from __future__ import annotations

import asyncio
import contextlib

import pytest
from bridge_bench import TWIST, Bench, Client
from telex_msgs.msg import Radio, SimStatus
from telex_msgs.srv import ConfigureLinkRequest
from waiting import wait_until_async
from web_fakes import LINK_CONFIGURE, LINK_STATE, FakeRos, on_loop

from telex_control.common.params import ConfigError
from telex_teleop.web.bridge.clients.access import Access
from telex_teleop.web.bridge.link.link_service import (
    LinkService,
    initial_setting,
)
from telex_teleop.web.line.fields import PERFECT, LineFields
from telex_teleop.web.line.profiles import LineSetting, Profiles
from telex_teleop.web.rights import Rights
from telex_teleop.web.workers import in_own_thread

DRIVE, E_STOP = "/telex/track_teleop/cmd_vel", "/telex/e_stop"
RADIO, STATUS = "/telex/sim/radio", "/telex/sim/status"


class Memory:
    def __init__(self):
        self.kept = {}

    def recall(self):
        return self.kept

    def keep(self, **values):
        self.kept = values

    def forget(self):
        self.kept = {}


class Served:
    """The service on a bench with one operator, at 100 s of sim time."""

    def __init__(self):
        self.bench = Bench()
        self.bench.ros.time = 100.0
        self.memory = Memory()
        shared = self.bench.shared
        self.line = shared.line
        self.service = LinkService(
            shared.line,
            shared.control,
            Profiles.read(),
            LineSetting(),
            ros=self.bench.ros,
            worker=shared.worker,
            publishers=shared.publishers,
            subscribers=shared.subscribers,
            warn=print,
            memory=self.memory,
        )

    async def call(self, profile, fields=""):
        answer = self.bench.ros.services_offered[LINK_CONFIGURE]
        response = await in_own_thread(lambda: answer(ConfigureLinkRequest(profile, fields)))
        await self.bench.settle()
        return response.success, response.message

    @property
    def told(self):
        return self.bench.ros.links[-1]


@contextlib.asynccontextmanager
async def served():
    made = Served()
    running = asyncio.ensure_future(made.service.run())
    await wait_until_async(lambda: made.bench.ros.links)
    await made.bench.settle()
    try:
        yield made
    finally:
        running.cancel()


@on_loop
async def test_profiles_and_fields_are_set_and_told():
    async with served() as link:
        assert (link.told.profile, link.told.perfect) == ("perfect", True)
        assert await link.call("300", "{loss: 0.1}") == (True, "the line is 300 (loss 0.1)")
        assert link.line.fields == LineFields(delay=0.3, loss=0.1) == LineFields.of(link.told)
        assert (link.told.profile, link.told.perfect, link.told.signal_known) == (
            "300",
            False,
            False,
        )
        assert link.told.since.to_sec() == 100.0
        assert link.memory.kept == {"profile": "300", "fields": {"loss": 0.1}}
        success, message = await link.call("300", "{loss: .nan}")
        assert not success
        assert "loss is nan" in message
        assert link.line.fields.loss == 0.1
        assert (await link.call("", "{delay: 0.2}"))[0]
        assert link.told.profile == "fields"
        assert (await link.call("perfect"))[0]
        assert (link.told.perfect, link.line.fields) == (True, PERFECT)


@on_loop
async def test_an_outage_is_told():
    async with served() as link:
        await link.call("", "{outage_every: 10, outage_for: 4}")
        assert not link.told.outage
        link.bench.ros.time = 107.0
        await wait_until_async(lambda: link.told.outage)
        assert link.told.header.stamp.to_sec() == 107.0
        count = len(link.bench.ros.links)
        await asyncio.sleep(0.3)
        assert len(link.bench.ros.links) == count
        link.bench.ros.time = 110.5
        await wait_until_async(lambda: not link.told.outage)


@on_loop
async def test_the_line_follows_the_signal_by_distance_only():
    async with served() as link:
        await link.call("300")
        assert RADIO not in link.bench.ros.receivers
        await link.call("by_distance")
        assert (link.line.fields, link.told.signal_known) == (PERFECT, False)
        hear = link.bench.ros.receivers[RADIO]
        hear(Radio(quality=0.3), None)
        await wait_until_async(lambda: link.told.signal_known)
        assert (link.told.signal, link.told.delay) == (0.3, link.line.fields.delay)
        hear(Radio(quality=float("nan")), None)
        await wait_until_async(lambda: link.told.outage)
        await link.call("300")
        assert not link.told.signal_known
        assert ("unsubscribe", RADIO) in link.bench.ros.events


@on_loop
async def test_reset_and_e_stop_call_commands_back():
    async with served() as link:
        client = Client(link.bench)
        client.say("advertise", topic=DRIVE, type=TWIST)
        await link.bench.settle()
        await link.call("300")
        watch = link.bench.ros.receivers[STATUS]
        watch(SimStatus(resets=3, e_stop=False), None)
        await link.bench.settle()
        for status in (SimStatus(resets=4), SimStatus(resets=4, e_stop=True)):
            client.say("publish", topic=DRIVE, msg={"linear": {"x": 1.0}})
            before = client.member.dropped
            watch(status, None)
            await wait_until_async(lambda n=before: client.member.dropped > n)
        link.bench.ros.time = 101.0
        await asyncio.sleep(0.15)
        assert not [topic for topic, _ in link.bench.ros.published if topic == DRIVE]


@on_loop
async def test_a_release_follows_the_stop_or_the_reset_of_the_same_client():
    async with served() as link:
        client = Client(link.bench)
        client.say("advertise", topic=DRIVE, type=TWIST)
        client.say("advertise", topic=E_STOP, type="std_msgs/Bool")
        await link.bench.settle()
        await link.call("300")
        watch = link.bench.ros.receivers[STATUS]
        watch(SimStatus(e_stop=False), None)
        for data in (True, False):
            client.say("publish", topic=E_STOP, msg={"data": data})
        client.say("publish", topic=DRIVE, msg={"linear": {"x": 1.0}})
        watch(SimStatus(e_stop=True), None)
        await wait_until_async(lambda: client.member.dropped == 1)
        link.bench.ros.time = 101.0
        await wait_until_async(lambda: len(link.bench.ros.published) == 2)
        assert [message.data for _, message in link.bench.ros.published] == [True, False]
        client.say("publish", topic=E_STOP, msg={"data": False})
        client.say("publish", topic=DRIVE, msg={"linear": {"x": 1.0}})
        watch(SimStatus(resets=1, e_stop=True), None)
        await wait_until_async(lambda: client.member.dropped == 2)
        link.bench.ros.time = 102.0
        await wait_until_async(lambda: len(link.bench.ros.published) == 3)
        assert link.bench.ros.published[-1][1].data is False


@on_loop
async def test_a_reset_calls_back_what_was_under_way_when_the_line_became_perfect():
    async with served() as link:
        client = Client(link.bench)
        client.say("advertise", topic=DRIVE, type=TWIST)
        await link.bench.settle()
        await link.call("1000")
        watch = link.bench.ros.receivers[STATUS]
        watch(SimStatus(resets=3), None)
        client.say("publish", topic=DRIVE, msg={"linear": {"x": 1.0}})
        await link.call("perfect")
        assert ("unsubscribe", STATUS) not in link.bench.ros.events
        watch(SimStatus(resets=4), None)
        await wait_until_async(lambda: client.member.dropped == 1)
        await wait_until_async(lambda: ("unsubscribe", STATUS) in link.bench.ros.events)
        link.bench.ros.time = 101.5
        await asyncio.sleep(0.15)
        assert link.bench.ros.published == []


def test_the_line_is_set_by_instructors_alone_and_without_control():
    rights = Rights.read()
    operator, instructor = (
        Access(rights, FakeRos().resolve, "e_stop", instructor=each) for each in (False, True)
    )
    assert not operator.allows("call", LINK_CONFIGURE)
    assert operator.allows("subscribe", LINK_STATE)
    assert instructor.allows("call", LINK_CONFIGURE)
    assert not instructor.needs_control("call", LINK_CONFIGURE)
    for use, name in (("publish", LINK_STATE), ("serve", LINK_CONFIGURE)):
        assert not instructor.allows(use, name)


def test_the_line_at_the_start_is_that_of_the_parameter_or_of_a_node_that_crashed():
    profiles = Profiles.read()
    assert initial_setting(profiles, "500", {}, "~link").fields.delay == 0.5
    kept = {"profile": "300", "fields": {"loss": 0.1}}
    assert initial_setting(profiles, "perfect", kept, "~link").described == "300 (loss 0.1)"
    assert initial_setting(profiles, "500", {"profile": "gone"}, "~link").name == "500"
    with pytest.raises(ConfigError, match="parameter ~link: profile is 'moon'"):
        initial_setting(profiles, "moon", {}, "~link")
