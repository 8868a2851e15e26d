"""The topics of one camera."""

from __future__ import annotations

import math
import threading
from typing import Callable, List, Optional, Tuple

import numpy as np
import rospy
from sensor_msgs.msg import CameraInfo, CompressedImage, Image
from std_msgs.msg import Float64, Header

from .camera_sensor import CameraSensor
from .cameras_config import OpticsConfig
from .exposure import ExposureControl
from .frame_pacer import FramePacer
from .messages import (
    camera_info_message,
    compressed_image_message,
    depth_message,
    image_message,
)
from .scene_renderer import SceneRenderer

Locate = Callable[[np.ndarray, float], np.ndarray]
"""Gives the pose of the optical frame in the world, of that of the frame in the scene on which the
camera depends, and of the monotonic time (s)."""


class CameraStream:
    """The topics of a camera, served as far as somebody listens.

    Parameters
    ----------
    name
        Of the camera; the topics stand under ``cameras/<name>``.
    config
        Of the camera.
    optical_frame
        What messages call the frame that they are in.
    scene_frame
        The frame in the scene on which the camera depends.
    locate
        Gives the camera's pose.
    repeat_rate
        Pictures per second while the poses stand still.
    seed
        Of its noise.
    detail
        By which the configured detail is multiplied.
    """

    def __init__(
        self,
        name: str,
        config: OpticsConfig,
        optical_frame: str,
        scene_frame: str,
        locate: Locate,
        repeat_rate: float,
        seed: int,
        detail: float = 1.0,
    ) -> None:
        self.name = name
        self.scene_frame = scene_frame
        self.locate = locate
        self.pacer = FramePacer(config.rate, repeat_rate)
        self._optical_frame = optical_frame
        self._seed = seed
        self._detail = detail
        self._exposure = ExposureControl()
        # Replaced as a whole by ROS's threads, read once a picture by the one that renders.
        self._writing = threading.Lock()
        self._setting: Tuple[OpticsConfig, float] = (config, 1.0)
        self._made_for: Optional[Tuple[OpticsConfig, float]] = None
        self._sensor: Optional[CameraSensor] = None
        self._publishers: List[rospy.Publisher] = []
        self._depth: Optional[rospy.Publisher] = None
        self._zoom: Optional[rospy.Subscriber] = None

    # ------------------------------------------------------------ any thread

    @property
    def config(self) -> OpticsConfig:
        """As the camera is set now."""
        return self._setting[0]

    def configure(self, config: OpticsConfig) -> None:
        """Set the camera anew, from its next picture on."""
        with self._writing:
            self._setting = (config, self._setting[1])

    def _take_zoom(self, message: Float64) -> None:
        wanted, most = message.data, self.config.zoom_max
        if math.isnan(wanted):
            rospy.logwarn("camera %s: zoom is nan; 1 to %g is possible", self.name, most)
            return
        zoom = min(max(wanted, 1.0), most)
        if zoom != wanted:
            rospy.logwarn(
                "camera %s: zoom is %g; 1 to %g is possible, %g is taken",
                self.name,
                wanted,
                most,
                zoom,
            )
        with self._writing:
            self._setting = (self._setting[0], zoom)

    # ------------------------------------------------------------ the thread that renders

    def advertise(self, there: bool) -> None:
        """Offer the topics while the robot has the camera, and take them back when it has not."""
        if there != bool(self._publishers):
            if there:
                self._open()
            else:
                self._close()
        if self._publishers:
            self._offer_depth(self.config.depth)

    def _open(self) -> None:
        topic = f"cameras/{self.name}"
        self._compressed = _publisher(f"{topic}/image_raw/compressed", CompressedImage)
        self._raw = _publisher(f"{topic}/image_raw", Image)
        self._info = _publisher(f"{topic}/camera_info", CameraInfo)
        self._publishers = [self._compressed, self._raw, self._info]
        if self.config.zoom_max > 1.0:
            self._zoom = rospy.Subscriber(
                f"{topic}/zoom", Float64, self._take_zoom, queue_size=1, tcp_nodelay=True
            )

    def _close(self) -> None:
        self._offer_depth(False)
        for publisher in self._publishers:
            publisher.unregister()
        self._publishers = []
        if self._zoom is not None:
            self._zoom.unregister()
            self._zoom = None

    def _offer_depth(self, wanted: bool) -> None:
        if wanted and self._depth is None:
            self._depth = _publisher(f"cameras/{self.name}/depth", Image)
        elif not wanted and self._depth is not None:
            self._depth.unregister()
            self._depth = None

    @property
    def priority(self) -> int:
        """When there is not time for all, those of a higher one come first."""
        return self.config.priority

    @property
    def wanted(self) -> bool:
        """Whether somebody listens to any of the topics."""
        return any(_is_heard(publisher) for publisher in self._publishers) or self._wants_depth

    @property
    def wants_picture(self) -> bool:
        """Whether something must be drawn."""
        if not self._publishers:
            return False
        return _is_heard(self._compressed) or _is_heard(self._raw) or self._wants_depth

    @property
    def _wants_depth(self) -> bool:
        return self._depth is not None and _is_heard(self._depth)

    def sensor(self) -> CameraSensor:
        """Return the camera as it is set now; ask once for each picture."""
        setting = self._setting
        if self._sensor is None or setting is not self._made_for:
            config, zoom = setting
            self.pacer.rate = config.rate
            self._sensor = CameraSensor(config, zoom, self._seed, self._exposure, self._detail)
            self._made_for = setting
        return self._sensor

    def publish_info(self, sensor: CameraSensor, stamp: rospy.Time) -> None:
        """Publish the camera's description, with the sim time of the poses."""
        if _is_heard(self._info):
            self._info.publish(camera_info_message(sensor.camera, self._header(stamp)))

    def publish_picture(
        self, sensor: CameraSensor, picture: np.ndarray, renderer: SceneRenderer, stamp: rospy.Time
    ) -> None:
        """Publish a picture in the forms that somebody listens to.

        Parameters
        ----------
        sensor
            That has taken it.
        picture
            RGBA, shape (height, width, 4), uint8; not kept.
        renderer
            With which it was taken.
        stamp
            Sim time of the poses that it shows.
        """
        header = self._header(stamp)
        if _is_heard(self._compressed):
            quality = sensor.config.jpeg_quality
            self._compressed.publish(compressed_image_message(picture, quality, header))
        if _is_heard(self._raw):
            self._raw.publish(image_message(picture, header))
        if self._depth is not None and self._wants_depth:
            self._depth.publish(depth_message(sensor.depth(renderer), header))

    def _header(self, stamp: rospy.Time) -> Header:
        return Header(stamp=stamp, frame_id=self._optical_frame)


def _is_heard(publisher: rospy.Publisher) -> bool:
    return publisher.get_num_connections() > 0


def _publisher(topic: str, kind: type) -> rospy.Publisher:
    # One message waits at most: a slow listener gets the newest picture, not the oldest.
    return rospy.Publisher(topic, kind, queue_size=1, tcp_nodelay=True)
