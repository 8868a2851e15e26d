"""The bridge as a ROS node."""

from __future__ import annotations

import rospy
from aiohttp import web

from telex_control.run_memory import RunMemory

from ..config import RosbridgeConfig
from ..serving import run_node
from .app import Rosbridge
from .ros_graph import RosGraph
from .tokens import kept, tokens_of

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
    return bridge.make_app()


def main() -> int:
    """Run the node and return its exit status."""
    return run_node("rosbridge", "ws", RosbridgeConfig, _make_app)
