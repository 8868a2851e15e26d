"""The ``cameras`` node: shows the simulator's scene as the robot's cameras see it."""

from __future__ import annotations

import math
import os
import sys
import time
from dataclasses import replace
from typing import List, Optional

import cv2
import rospkg
import rospy
from telex_msgs.msg import SceneDescription, ScenePoses

from telex_control.node_start import init_node, until_shutdown
from telex_control.params import ConfigError, read_config

from .camera_stream import CameraStream
from .cameras_config import CamerasConfig
from .gl_context import NoContextError, create_context
from .lamp_switches import LampSwitches
from .lighting import Lighting
from .quality import choose_quality
from .renderer import Renderer
from .scene_inbox import SceneInbox
from .scene_mirror import SceneMirror

# Longest wait for the simulator before looking at who listens again (s).
_PATIENCE = 0.1

# How long poses are still followed when nobody looks any more (s): whoever takes a snapshot now and
# then need not wait for a new connection each time.
_FOLLOW_ON = 5.0

# More than the largest message, so that rospy reads on to the newest of those that wait.
_BUFFER_SIZE = 2**24


class CamerasNode:
    """Renders the cameras that somebody looks at, in the thread that calls ``run``.

    ROS's own threads only leave messages in an inbox, because OpenGL belongs to one thread.

    Parameters
    ----------
    config
        Of the node.
    renderer
        Made by the thread that will call ``run``.
    """

    def __init__(self, config: CamerasConfig, renderer: Renderer) -> None:
        self._renderer = renderer
        self._streams = [
            CameraStream(name, camera, f"{config.model}/{camera.frame}", config.repeat_rate)
            for name, camera in config.cameras.items()
        ]
        self._lamps = LampSwitches(config.lamps)
        self._mirror = SceneMirror(
            renderer,
            (stream.scene_frame for stream in self._streams),
            [lamp.lamp(name, config.model) for name, lamp in config.lamps.items()],
        )
        self._inbox = SceneInbox()
        self._scene_subscriber = rospy.Subscriber(
            "sim/scene", SceneDescription, self._inbox.put_scene, queue_size=1
        )
        self._poses_subscriber: Optional[rospy.Subscriber] = None
        self._last_wanted = -math.inf

    def run(self) -> None:
        """Serve until ROS shuts down."""
        while not rospy.is_shutdown():
            self._inbox.wait(_PATIENCE)
            scene = self._inbox.take_scene()
            if scene is not None:
                self._mirror.load(scene)
            now = time.monotonic()
            wanted = [stream for stream in self._streams if stream.wanted]
            self._follow_poses(bool(wanted), now)
            poses = self._inbox.newest_poses()
            if poses is not None:
                self._show(poses, wanted, now)

    def _follow_poses(self, wanted: bool, now: float) -> None:
        """Listen to the poses only while somebody looks: they come many times a second."""
        if wanted:
            self._last_wanted = now
            if self._poses_subscriber is None:
                self._poses_subscriber = rospy.Subscriber(
                    "sim/poses",
                    ScenePoses,
                    self._inbox.put_poses,
                    queue_size=1,
                    buff_size=_BUFFER_SIZE,
                    tcp_nodelay=True,
                )
        elif self._poses_subscriber is not None and now - self._last_wanted > _FOLLOW_ON:
            self._poses_subscriber.unregister()
            self._poses_subscriber = None
            self._inbox.drop_poses()

    def _show(self, poses: ScenePoses, wanted: List[CameraStream], now: float) -> None:
        """Publish what is due of these poses."""
        stamp = poses.header.stamp
        due = [stream for stream in wanted if stream.pacer.is_due(now, stamp.to_nsec())]
        if not due or not self._mirror.place(poses):
            return
        self._renderer.set_lamp_levels(self._lamps.levels())
        for stream in due:
            stream.pacer.sent(now, stamp.to_nsec())
            camera_in_world = self._mirror.camera_in_world(stream.scene_frame)
            if camera_in_world is None:
                continue
            optics = stream.optics
            stream.publish_info(optics, stamp)
            if stream.wants_picture:
                stream.publish_picture(self._renderer.render(optics, camera_in_world), stamp)


def main() -> None:
    """Run the node; a mistake in the configuration ends it with one line that says what to do."""
    init_node("cameras")
    try:
        config = read_config(CamerasConfig, rospy.get_param("~", {}), rospy.get_name())
        renderer = _renderer(config)
    except (ConfigError, NoContextError) as error:
        rospy.logfatal("%s", error)
        sys.exit(1)
    try:
        with until_shutdown():
            CamerasNode(config, renderer).run()
    finally:
        renderer.release()


def _renderer(config: CamerasConfig) -> Renderer:
    os.nice(config.niceness)
    # OpenCV and Mesa would otherwise start a thread for each core, which the physics needs.
    cv2.setNumThreads(1)
    os.environ.setdefault("LP_NUM_THREADS", str(config.software_threads))
    context = create_context(config.egl_device)
    name = context.info["GL_RENDERER"]
    rospy.loginfo("rendering with %s, quality %s", name, config.quality)
    return Renderer(
        context,
        choose_quality(config.quality, name),
        replace(Lighting(), shadow_radius=config.shadow_radius),
        rospkg.RosPack().get_path,
    )
