"""A stuck key: whose command goes on, and what ends it."""

from __future__ import annotations

import asyncio

import genpy
import pytest
from bridge_bench import JOG, TWIST, Bench, Client
from std_msgs.msg import Bool
from telex_msgs.msg import ActiveMalfunction, Malfunctions
from waiting import wait_until_async
from web_fakes import on_loop

DRIVE, ARM = "/telex/track_teleop/cmd_vel", "/telex/arm_teleop/delta_joint_cmds"
AHEAD, STILL = {"linear": {"x": 1.0}}, {"linear": {"x": 0.0}}


class Rig:
    """A bridge whose keys can get stuck, and a client that drives."""

    def __init__(self):
        self.bench = Bench()
        self.client = Client(self.bench)

    async def __aenter__(self):
        self.task = asyncio.ensure_future(self.bench.shared.stuck_key.run())
        for topic, kind in ((DRIVE, TWIST), (ARM, JOG)):
            self.client.say("advertise", topic=topic, type=kind)
        await self.bench.settle()
        return self

    async def __aexit__(self, *exception):
        self.task.cancel()

    async def stick(self, since=1):
        key = ActiveMalfunction(what="key", group="key", kind="stuck", since=genpy.Time(since))
        await self.tell("/telex/sim/malfunctions", Malfunctions(active=[key] if since else []))

    async def tell(self, topic, message):
        self.bench.ros.receivers[topic](message, None)
        await asyncio.sleep(0.01)

    def drive(self, x):
        self.client.say("publish", topic=DRIVE, msg={"linear": {"x": x}})

    def jog(self, *joints, rate=0.2):
        message = {"joint_names": list(joints), "velocities": [rate] * len(joints)}
        self.client.say("publish", topic=ARM, msg=message)

    def driven(self):
        return [message.linear.x for topic, message in self.bench.ros.published if topic == DRIVE]

    def jogged(self):
        published = self.bench.ros.published
        return [(*m.joint_names, *m.velocities) for topic, m in published if topic == ARM]

    async def goes_on(self):
        """Whether anything is still driven in the next moments."""
        before = len(self.driven())
        await asyncio.sleep(0.15)
        return len(self.driven()) > before


@on_loop
async def test_a_key_that_is_not_stuck_stops_when_it_is_released():
    async with Rig() as rig:
        rig.drive(1.0)
        rig.drive(0.0)
        assert rig.driven() == [1.0, 0.0]
        assert not await rig.goes_on()


@on_loop
async def test_the_last_command_goes_on_when_the_key_is_released():
    async with Rig() as rig:
        await rig.stick()
        rig.drive(0.5)
        rig.drive(1.0)
        rig.drive(0.0)
        assert rig.driven() == [0.5, 1.0]
        assert await rig.goes_on()
        assert set(rig.driven()[2:]) == {1.0}
        # Pressed again it does as it is told, and sticks with that.
        rig.drive(-1.0)
        rig.drive(0.0)
        assert await rig.goes_on()
        assert rig.driven()[-1] == -1.0
        await rig.stick(since=0)
        assert rig.driven()[-1] == 0.0
        assert not await rig.goes_on()


@on_loop
async def test_a_stream_that_falls_silent_is_a_key_that_was_released():
    async with Rig() as rig:
        await rig.stick()
        rig.drive(1.0)
        assert await rig.goes_on()


@on_loop
async def test_other_axes_stop_as_they_are_told():
    async with Rig() as rig:
        await rig.stick()
        rig.jog("turret_joint")
        rig.jog("elbow_joint")
        rig.jog("elbow_joint", rate=0.0)
        rig.jog("turret_joint", rate=0.0)
        rig.drive(1.0)
        rig.drive(0.0)
        await wait_until_async(lambda: len(rig.jogged()) > 5)
        assert rig.jogged()[:3] == [
            ("turret_joint", 0.2),
            ("elbow_joint", 0.2),
            ("elbow_joint", 0.0),
        ]
        assert set(rig.jogged()[3:]) == {("turret_joint", 0.2)}
        assert rig.driven() == [1.0, 0.0]


@pytest.mark.parametrize("how", ["e-stop", "hand-over", "vanished", "unadvertised"])
def test_what_ends_it(how):
    on_loop(lambda: ending(how))()


async def ending(how):
    async with Rig() as rig:
        await rig.stick()
        rig.drive(1.0)
        rig.drive(0.0)
        assert await rig.goes_on()
        if how == "e-stop":
            await rig.tell("/telex/e_stop", Bool(False))
            assert await rig.goes_on()
            await rig.tell("/telex/e_stop", Bool(True))
        elif how == "hand-over":
            await Client(rig.bench, instructor=True).ask("bridge/take_control")
        elif how == "vanished":
            rig.client.session.close()
        else:
            rig.client.say("unadvertise", topic=DRIVE)
        assert rig.driven()[-1] == 0.0
        assert not await rig.goes_on()


@on_loop
async def test_it_sticks_once_and_again_with_the_next_malfunction():
    async with Rig() as rig:
        await rig.stick()
        rig.drive(1.0)
        await rig.tell("/telex/e_stop", Bool(True))
        rig.drive(1.0)
        rig.drive(0.0)
        assert not await rig.goes_on()
        await rig.stick()  # the same, told once more
        rig.drive(1.0)
        rig.drive(0.0)
        assert not await rig.goes_on()
        await rig.stick(since=5)
        rig.drive(1.0)
        rig.drive(0.0)
        assert await rig.goes_on()
