"""The video server as a ROS node."""

from __future__ import annotations

from pathlib import Path

import rospkg
import rospy
from aiohttp import web

from ..server_config import VideoServerConfig
from ..serving import run_node
from .ros_source import RosPictureSource
from .video_server_app import VideoServer

WARNING_PERIOD = 5.0
"""Shortest time (s) between two warnings."""


def _make_app(config: VideoServerConfig) -> web.Application:
    console = Path(rospkg.RosPack().get_path("telex_teleop")) / "console"

    def warn(sentence: str) -> None:
        rospy.logwarn_throttle(WARNING_PERIOD, f"{rospy.get_name()}: {sentence}")

    return VideoServer(config, RosPictureSource(), rospy.get_namespace(), console, warn).make_app()


def main() -> int:
    """Run the node and return its exit status."""
    return run_node("video_server", "http", VideoServerConfig, _make_app)
