"""The bridge as a ROS node."""

from __future__ import annotations

import contextlib
import os
from typing import Mapping

import rospy
from aiohttp import web

from telex_control.ros.run_memory import RunMemory, run_path

from ..server_config import RosbridgeConfig
from ..serving import run_node
from ..tokens import FILES, INSTRUCTOR_FILE, files_of, read_tokens
from .bridge_app import Rosbridge
from .ros_graph import RosGraph

WARNING_PERIOD = 5.0
"""Shortest time (s) between two warnings."""


def _make_app(config: RosbridgeConfig) -> web.Application:
    def warn(sentence: str) -> None:
        rospy.logwarn_throttle(WARNING_PERIOD, f"{rospy.get_name()}: {sentence}")

    name = rospy.get_name()
    makeshift = {each: run_path(name, each) for each in FILES}
    files = files_of(config, makeshift)
    own = {each: path for each, path in files.items() if path == makeshift[each]}
    for path in own.values():
        with contextlib.suppress(OSError):  # which then says why it cannot be made
            os.makedirs(os.path.dirname(path), exist_ok=True)
    tokens = read_tokens(files, name)
    for each, path in files.items():
        who = "instructors" if each == INSTRUCTOR_FILE else "clients"
        rospy.loginfo("%s: %s must know the token in %s", name, who, path)
    memory = RunMemory.of_this_node()
    app = Rosbridge(config, RosGraph(), warn, tokens, memory).make_app()

    async def forget(_app: web.Application) -> None:
        memory.forget()

    app.on_cleanup.append(forget)
    return _sharing(own, app)


def _sharing(own: Mapping[str, str], app: web.Application) -> web.Application:
    """Let the video server know which files were made for this run, by the node's own parameters.

    An end in order deletes them. A crash leaves them to the successor, whose clients know no other
    tokens.
    """
    for name, path in own.items():
        rospy.set_param(f"~{name}", path)

    async def forget(_app: web.Application) -> None:
        for path in own.values():
            with contextlib.suppress(OSError):
                os.remove(path)
        with contextlib.suppress(OSError, KeyError):  # the master may have ended before
            for name in own:
                rospy.delete_param(f"~{name}")

    app.on_cleanup.append(forget)
    return app


def main() -> int:
    """Run the node and return its exit status."""
    return run_node("rosbridge", "ws", RosbridgeConfig, _make_app, coarse_clock=True, prompt=True)
