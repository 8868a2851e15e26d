"""The video server as a ROS node."""

from __future__ import annotations

import asyncio
import contextlib
from pathlib import Path
from typing import Callable

import rospy
from aiohttp import web
from std_msgs.msg import String
from telex_msgs.msg import LinkState

from telex_control.common.file_catalog import package_path
from telex_control.common.params import ConfigError

from ..exam.exam_list import BRIDGE_TOPIC
from ..line.fields import LineFields
from ..server_config import VideoServerConfig
from ..serving import run_node
from .ros_source import RosPictureSource
from .video_server_app import VideoServer

WARNING_PERIOD = 5.0
"""Shortest time (s) between two warnings."""


def _make_app(config: VideoServerConfig) -> web.Application:
    console = Path(package_path("telex_teleop")) / "console"

    def warn(sentence: str) -> None:
        rospy.logwarn_throttle(WARNING_PERIOD, f"{rospy.get_name()}: {sentence}")

    server = VideoServer(config, RosPictureSource(), rospy.get_namespace(), console, warn)
    _follow_link(server, warn)
    _follow_exam(server)
    return server.make_app()


def _follow_link(server: VideoServer, warn: Callable[[str], None]) -> None:
    """Let the server's line be the one that the bridge's node tells of."""
    loop = asyncio.get_running_loop()

    def take(state: LinkState) -> None:
        try:
            fields = LineFields.of(state)
        except ConfigError as error:
            warn(f"link/state cannot be used: {error}")
            return
        with contextlib.suppress(RuntimeError):  # the loop may have ended
            loop.call_soon_threadsafe(server.line.configure, fields, state.since.to_sec())

    rospy.Subscriber("link/state", LinkState, take, queue_size=10)


def _follow_exam(server: VideoServer) -> None:
    """Let the exam's list hold as the bridge's node tells."""
    loop = asyncio.get_running_loop()
    rospy.Subscriber(
        BRIDGE_TOPIC,
        String,
        lambda message: loop.call_soon_threadsafe(server.hear_of_exam, message.data),
        queue_size=10,
    )


def main() -> int:
    """Run the node and return its exit status."""
    return run_node("video_server", "http", VideoServerConfig, _make_app)
