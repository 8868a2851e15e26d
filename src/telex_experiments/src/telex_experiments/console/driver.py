#!/usr/bin/env python3
"""A client of the bridge that drives: console_driver.py BRIDGE SPEED, 50 times a second, for ever.

A process of its own, so that it can be killed or stopped.
"""

from __future__ import annotations

import asyncio
import json
import sys

import aiohttp

TOPIC, KIND = "/telex/track_teleop/cmd_vel", "geometry_msgs/Twist"
PERIOD = 0.02


async def drive(bridge: str, speed: float) -> None:
    """Connect and drive (m/s)."""
    command = {"op": "publish", "topic": TOPIC, "type": KIND, "msg": {"linear": {"x": speed}}}
    async with aiohttp.ClientSession() as session, session.ws_connect(bridge) as socket:
        while not socket.closed:
            await socket.send_str(json.dumps(command))
            await asyncio.sleep(PERIOD)


if __name__ == "__main__":
    asyncio.run(drive(sys.argv[1], float(sys.argv[2])))
