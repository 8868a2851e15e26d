#!/usr/bin/env python3
"""Clients that watch: watchers.py BRIDGE VIDEO COUNT. They tell delays until stdin ends.

Each subscribes to what the console subscribes to, at its rates, and takes the pictures of all
cameras as the console does, each picture acknowledged when it has come. Once a second a line of
JSON says what all together have met since the last one: delays (s) of messages of the bridge, of
its answers, and of pictures.

A process of its own, so that it does not share the interpreter with who measures the console.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import struct
import sys
import time
from typing import Any, Dict, List

import aiohttp

CLOCK = "/benchmark/clock"
"""std_msgs/Float64: monotonic time at which it was published (s)."""

TOPICS = {
    "/telex/joint_states": ("sensor_msgs/JointState", 100),
    "/telex/imu": ("sensor_msgs/Imu", 200),
    "/telex/sim/stability": ("telex_msgs/Stability", 100),
    "/telex/sim/status": ("telex_msgs/SimStatus", 0),
    "/telex/arm_teleop/status": ("telex_msgs/JointTeleopStatus", 0),
    "/telex/arm_teleop/cartesian_status": ("telex_msgs/CartesianTeleopStatus", 0),
    "/telex/gripper_teleop/status": ("telex_msgs/JointTeleopStatus", 0),
    "/telex/flipper_teleop/status": ("telex_msgs/JointTeleopStatus", 0),
    "/telex/track_teleop/status": ("telex_msgs/TrackTeleopStatus", 0),
    "/telex/bridge/clients": ("telex_msgs/BridgeClients", 0),
    CLOCK: ("std_msgs/Float64", 0),
}
"""What is heard: type, and least time between two messages (ms)."""

PING_PERIOD = 0.5
"""Time (s) between two questions to the bridge."""

HEADER = struct.Struct("<BBHId")
MAIN_RATE, OTHER_RATE = 30.0, 10.0
"""Most pictures per second of the first camera, and of each other one."""


class Watchers:
    """What some clients have met since it was told last."""

    def __init__(self) -> None:
        self.delays: Dict[str, List[float]] = {"message": [], "answer": [], "picture": []}

    def tell(self) -> None:
        """Print it as a line, and forget it."""
        print(json.dumps(self.delays), flush=True)
        for values in self.delays.values():
            values.clear()

    async def listen(self, socket: Any) -> None:
        """Hear what the bridge says."""
        for topic, (kind, throttle) in TOPICS.items():
            await socket.send_json(
                {
                    "op": "subscribe",
                    "topic": topic,
                    "type": kind,
                    "throttle_rate": throttle,
                    "queue_length": 1,
                }
            )
        async for news in socket:
            message: Any = json.loads(news.data)
            now = time.monotonic()
            if message["op"] == "service_response":
                self.delays["answer"].append(now - float(message["id"]))
            elif message.get("topic") == CLOCK:
                self.delays["message"].append(now - message["msg"]["data"])

    async def ask(self, socket: Any) -> None:
        """Ask for the time, again and again."""
        while True:
            question = {"op": "call_service", "service": "/rosapi/get_time"}
            await socket.send_json({**question, "id": repr(time.monotonic())})
            await asyncio.sleep(PING_PERIOD)

    async def watch(self, socket: Any) -> None:
        """Take the pictures of all cameras."""
        async for news in socket:
            if news.type == aiohttp.WSMsgType.BINARY:
                _, camera, _, number, captured = HEADER.unpack_from(news.data)
                self.delays["picture"].append(time.time() - captured)
                await socket.send_json({"ack": [camera, number]})
                continue
            message = json.loads(news.data)
            if "cameras" in message:
                names = [each["name"] for each in message["cameras"]]
                rates = [MAIN_RATE if name == "front" else OTHER_RATE for name in names]
                wishes = [{"camera": name, "rate": rate} for name, rate in zip(names, rates)]
                await socket.send_json({"show": wishes})


async def _run(bridge: str, video: str, count: int) -> None:
    watchers = Watchers()
    ended = asyncio.get_running_loop().run_in_executor(None, sys.stdin.read)
    async with aiohttp.ClientSession() as http, contextlib.AsyncExitStack() as stack:
        tasks = []
        for _ in range(count):
            ears = await stack.enter_async_context(http.ws_connect(bridge))
            eyes = await stack.enter_async_context(http.ws_connect(video))
            work = watchers.listen(ears), watchers.ask(ears), watchers.watch(eyes)
            tasks += [asyncio.ensure_future(each) for each in work]
        while not ended.done():
            await asyncio.wait([ended, *tasks], timeout=1.0, return_when=asyncio.FIRST_COMPLETED)
            for task in tasks:
                if task.done():
                    raise SystemExit(f"a connection has ended: {task.exception()}")
            watchers.tell()
        for task in tasks:
            task.cancel()


if __name__ == "__main__":
    asyncio.run(_run(sys.argv[1], sys.argv[2], int(sys.argv[3])))
