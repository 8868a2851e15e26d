"""The bridge as a ROS node."""

from __future__ import annotations

import contextlib
from typing import Mapping

import rospy
from aiohttp import web

from telex_control.run_memory import RunMemory

from ..config import RosbridgeConfig
from ..serving import run_node
from ..tokens import tokens_of
from .app import Rosbridge
from .ros_graph import RosGraph

WARNING_PERIOD = 5.0
"""Shortest time (s) between two warnings."""


def _make_app(config: RosbridgeConfig) -> web.Application:
    def warn(sentence: str) -> None:
        rospy.logwarn_throttle(WARNING_PERIOD, f"{rospy.get_name()}: {sentence}")

    memory = RunMemory.of_this_node()
    bridge = Rosbridge(config, RosGraph(), warn, tokens_of(config, memory.recall()))
    tokens = bridge.tokens
    memory.keep(**tokens.made_up)
    rospy.on_shutdown(memory.forget)
    if tokens.made_up:
        # Not by rospy's log: that is a topic, and every client may read it.
        print(
            f"{rospy.get_name()}: clients connect with ?token={tokens.client} , instructors "
            f"with ?role=instructor&token={tokens.instructor}",
            flush=True,
        )
    return _sharing(tokens.made_up, bridge.make_app())


def _sharing(made_up: Mapping[str, str], app: web.Application) -> web.Application:
    """Let the video server know what was made up, by the node's own parameters while it runs.

    No client of the bridge can read them.
    """
    for name, token in made_up.items():
        rospy.set_param(f"~{name}", token)

    async def forget(_app: web.Application) -> None:
        with contextlib.suppress(OSError, KeyError):  # the master may have ended before
            for name in made_up:
                rospy.delete_param(f"~{name}")

    app.on_cleanup.append(forget)
    return app


def main() -> int:
    """Run the node and return its exit status."""
    return run_node("rosbridge", "ws", RosbridgeConfig, _make_app)
