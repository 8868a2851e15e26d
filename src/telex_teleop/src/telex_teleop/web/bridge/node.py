"""The bridge as a ROS node."""

from __future__ import annotations

import contextlib

import rospy
from aiohttp import web

from telex_control.run_memory import RunMemory

from ..config import RosbridgeConfig
from ..serving import run_node
from ..tokens import Tokens, kept, tokens_of
from .app import Rosbridge
from .ros_graph import RosGraph

WARNING_PERIOD = 5.0
"""Shortest time (s) between two warnings."""


def _make_app(config: RosbridgeConfig) -> web.Application:
    def warn(sentence: str) -> None:
        rospy.logwarn_throttle(WARNING_PERIOD, f"{rospy.get_name()}: {sentence}")

    memory = RunMemory.of_this_node()
    bridge = Rosbridge(config, RosGraph(), warn, tokens_of(config, memory.recall()))
    memory.keep(**kept(bridge.tokens))
    rospy.on_shutdown(memory.forget)
    if bridge.tokens.made_up:
        # Not by rospy's log: that is a topic, and every client may read it.
        print(
            f"{rospy.get_name()}: clients connect with ?token={bridge.tokens.client} , instructors "
            f"with ?role=instructor&token={bridge.tokens.instructor}",
            flush=True,
        )
        return _sharing_tokens(bridge.tokens, bridge.make_app())
    return bridge.make_app()


def _sharing_tokens(tokens: Tokens, app: web.Application) -> web.Application:
    """Let the video server know what was made up, by the node's own parameters while it runs.

    No client of the bridge can read them.
    """
    made_up = {"~token": tokens.client, "~instructor_token": tokens.instructor}
    for name, token in made_up.items():
        rospy.set_param(name, token)

    async def forget(_app: web.Application) -> None:
        with contextlib.suppress(OSError, KeyError):  # the master may have ended before
            for name in made_up:
                rospy.delete_param(name)

    app.on_cleanup.append(forget)
    return app


def main() -> int:
    """Run the node and return its exit status."""
    return run_node("rosbridge", "ws", RosbridgeConfig, _make_app)
