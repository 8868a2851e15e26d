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
from .video_server_app import RobotVideo, VideoServer

WARNING_PERIOD = 5.0
"""Shortest time (s) between two warnings."""


def _make_app(config: VideoServerConfig) -> web.Application:
    console = Path(package_path("telex_teleop")) / "console"

    def warn(sentence: str) -> None:
        rospy.logwarn_throttle(WARNING_PERIOD, f"{rospy.get_name()}: {sentence}")

    server = VideoServer(config, RosPictureSource(), rospy.get_namespace(), console, warn)
    for robot in server.robots.values():
        _follow_link(robot, warn)
        _follow_exam(robot)
    return server.make_app()


def _follow_link(robot: RobotVideo, warn: Callable[[str], None]) -> None:
    """Let a robot's line be the one that its bridge tells of."""
    loop = asyncio.get_running_loop()

    def take(state: LinkState) -> None:
        try:
            fields = LineFields.of(state)
        except ConfigError as error:
            warn(f"link/state cannot be used: {error}")
            return
        with contextlib.suppress(RuntimeError):  # the loop may have ended
            loop.call_soon_threadsafe(robot.line.configure, fields, state.since.to_sec())

    rospy.Subscriber(f"{robot.namespace}link/state", LinkState, take, queue_size=10)


def _follow_exam(robot: RobotVideo) -> None:
    """Let the exam's list hold for a robot as its bridge tells."""
    loop = asyncio.get_running_loop()
    rospy.Subscriber(
        f"{robot.namespace}{BRIDGE_TOPIC}",
        String,
        lambda message: loop.call_soon_threadsafe(robot.gate.hear_of_exam, message.data),
        queue_size=10,
    )


def main() -> int:
    """Run the node and return its exit status."""
    return run_node("video_server", "http", VideoServerConfig, _make_app)
