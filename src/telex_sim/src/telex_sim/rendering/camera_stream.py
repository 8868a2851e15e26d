"""The topics of one camera."""

from __future__ import annotations

import math

import numpy as np
import rospy
from sensor_msgs.msg import CameraInfo, CompressedImage, Image
from std_msgs.msg import Float64, Header

from .camera import PinholeCamera
from .cameras_config import CameraConfig
from .frame_pacer import FramePacer
from .messages import camera_info_message, compressed_image_message, image_message


class CameraStream:
    """The topics of a camera, served as far as somebody listens.

    Parameters
    ----------
    name
        Of the camera; the topics stand under ``cameras/<name>``.
    config
        Of the camera.
    scene_frame
        Name of its optical frame in the scene.
    repeat_rate
        Pictures per second while the poses stand still.
    """

    def __init__(
        self, name: str, config: CameraConfig, scene_frame: str, repeat_rate: float
    ) -> None:
        self.scene_frame = scene_frame
        self._name = name
        self._config = config
        # Replaced as a whole by ROS's thread, read once a picture by the one that renders.
        self._optics = config.optics()
        self.pacer = FramePacer(config.rate, repeat_rate)
        topic = f"cameras/{name}"
        self._compressed = _publisher(f"{topic}/image_raw/compressed", CompressedImage)
        self._raw = _publisher(f"{topic}/image_raw", Image)
        self._info = _publisher(f"{topic}/camera_info", CameraInfo)
        if config.zoom_max > 1.0:
            self._zoom = rospy.Subscriber(
                f"{topic}/zoom", Float64, self._take_zoom, queue_size=1, tcp_nodelay=True
            )

    def _take_zoom(self, message: Float64) -> None:
        wanted, most = message.data, self._config.zoom_max
        if math.isnan(wanted):
            rospy.logwarn("camera %s: zoom is nan; 1 to %g is possible", self._name, most)
            return
        zoom = min(max(wanted, 1.0), most)
        if zoom != wanted:
            rospy.logwarn(
                "camera %s: zoom is %g; 1 to %g is possible, %g is taken",
                self._name,
                wanted,
                most,
                zoom,
            )
        self._optics = self._config.optics(zoom)

    @property
    def optics(self) -> PinholeCamera:
        """As the camera is zoomed now; ask once for each picture."""
        return self._optics

    @property
    def wants_picture(self) -> bool:
        """Whether somebody would see a picture."""
        return self._compressed.get_num_connections() > 0 or self._raw.get_num_connections() > 0

    @property
    def wanted(self) -> bool:
        """Whether somebody listens to any of the topics."""
        return self.wants_picture or self._info.get_num_connections() > 0

    def publish_info(self, optics: PinholeCamera, stamp: rospy.Time) -> None:
        """Publish the camera's description, with the sim time of the poses."""
        self._info.publish(camera_info_message(optics, self._header(stamp)))

    def publish_picture(self, picture: np.ndarray, stamp: rospy.Time) -> None:
        """Publish a picture in the forms that somebody listens to.

        Parameters
        ----------
        picture
            RGBA, shape (height, width, 4), uint8; not kept.
        stamp
            Sim time of the poses that it shows.
        """
        header = self._header(stamp)
        if self._compressed.get_num_connections():
            quality = self._config.jpeg_quality
            self._compressed.publish(compressed_image_message(picture, quality, header))
        if self._raw.get_num_connections():
            self._raw.publish(image_message(picture, header))

    def _header(self, stamp: rospy.Time) -> Header:
        return Header(stamp=stamp, frame_id=self._config.frame)


def _publisher(topic: str, kind: type) -> rospy.Publisher:
    # One message waits at most: a slow listener gets the newest picture, not the oldest.
    return rospy.Publisher(topic, kind, queue_size=1, tcp_nodelay=True)
