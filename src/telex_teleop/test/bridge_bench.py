"""A bridge without sockets and ROS, and clients of it, for tests."""

from __future__ import annotations

import asyncio
import json

from web_fakes import HUNG, FakeRos

from telex_control.common.params import read_config, read_struct
from telex_teleop.web.bridge.clients.control import Member
from telex_teleop.web.bridge.clients.outbox import Outbox
from telex_teleop.web.bridge.session import ClientSession, Shared
from telex_teleop.web.rights import Rights
from telex_teleop.web.server_config import RosbridgeConfig

TWIST = "geometry_msgs/Twist"
JOG = "control_msgs/JointJog"


class Client:
    """A session of the bridge with what it sends."""

    def __init__(self, bench, *, instructor=False):
        self.outbox = Outbox(1000000)
        self.dropped = []
        bench.clients += 1
        self.id = str(bench.clients)
        self.member = Member(self.id, "127.0.0.1", instructor, 0.0)
        self.session = ClientSession(self.member, bench.shared, self.outbox, self.dropped.append)

    def say(self, op, **fields):
        self.session.receive(json.dumps({"op": op, **fields}))

    async def hear(self):
        return json.loads(await asyncio.wait_for(self.outbox.get(), HUNG))

    async def ask(self, service, args=None):
        self.say("call_service", service=service, args=args, id="q")
        answer = await self.hear()
        assert (answer["op"], answer["service"], answer["id"]) == ("service_response", service, "q")
        return answer["result"], answer["values"]


class Bench:
    """Everything that clients share; make it on the loop.

    As a plain rosbridge, unless a test is about who may do what: rights, by sections.
    """

    def __init__(self, rights=None, *, exam_rights=None, proven=True, **config):
        params = {"connect_timeout": 0.2, "plain": rights is None, **config}
        self.config = read_config(RosbridgeConfig, params, "~")
        self.ros = FakeRos()
        self.clients = 0
        lists = read_struct(Rights, rights) if rights else Rights.read(self.config.rights)
        self.shared = Shared(
            self.config, self.ros, lists, exam_rights=exam_rights, proven=proven, linger=0.05
        )
        self.worker, self.control = self.shared.worker, self.shared.control
        self.publishers, self.subscribers = self.shared.publishers, self.shared.subscribers

    async def settle(self):
        """Let everything happen that has been begun."""
        for _ in range(3):
            await self.worker.submit(lambda: None)
            await asyncio.sleep(0.015)
