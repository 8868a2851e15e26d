"""The topics of one camera."""

from __future__ import annotations

import math
import threading
from typing import Callable, Iterator, List, Optional, Sequence, Tuple

import cv2
import numpy as np
import rospy
from sensor_msgs.msg import CameraInfo, CompressedImage, Image
from std_msgs.msg import Float64, Header

from ..cameras_config import OpticsConfig
from ..drawing.scene_renderer import SceneRenderer
from ..optics.camera_sensor import CameraSensor
from ..optics.exposure import ExposureControl
from .frame_pacer import FramePacer
from .messages import (
    camera_info_message,
    compressed_image_message,
    depth_message,
    image_message,
)

Locate = Callable[[np.ndarray, float], np.ndarray]
"""Gives the pose of the optical frame in the world, of that of the frame in the scene on which the
camera depends, and of the monotonic time (s)."""


LARGE_WEIGHT = 3.0
"""What pictures of full size count for beside previews when there is too little time: they keep
their rate until previews have fallen to a third of theirs, whichever camera somebody looks through.
"""

Setting = Tuple[OpticsConfig, float]
"""How a camera is set, and its zoom."""


class PictureSize:
    """One of the two sizes of a camera's pictures: full, or its previews.

    Parameters
    ----------
    stream
        The camera's topics.
    make_sensor
        Makes what takes the pictures, of a setting and a scale.
    pacer
        Says when they are due.
    """

    def __init__(
        self,
        stream: CameraStream,
        make_sensor: Callable[[Setting, float], CameraSensor],
        pacer: FramePacer,
    ) -> None:
        self.stream = stream
        self.pacer = pacer
        self._make_sensor = make_sensor
        self._made_for: Optional[Tuple[Setting, float]] = None
        self._sensor: Optional[CameraSensor] = None

    @property
    def weight(self) -> float:
        """By which its rate counts, when there is too little time for all."""
        return self.stream.weight_of(self)

    @property
    def is_preview(self) -> bool:
        """Whether it is that of the previews."""
        return self.stream.is_preview(self)

    def sensor(self) -> CameraSensor:
        """Return the camera as it is set now; ask once for each picture."""
        wanted = (self.stream.setting, 1.0 if self.is_preview else self.stream.scale)
        if self._sensor is None or wanted != self._made_for:
            self._sensor = self._make_sensor(*wanted)
            self.pacer.rate = self._sensor.config.rate
            self._made_for = wanted
        return self._sensor


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
    ) -> None:
        self.name = name
        self.scene_frame = scene_frame
        self.locate = locate
        self._optical_frame = optical_frame
        # Of both sizes: it is one camera.
        exposure = ExposureControl()

        def full_size(setting: Setting, scale: float) -> CameraSensor:
            config, zoom = setting
            reduced = config.reduced(max(round(scale * config.width), config.small().width))
            return CameraSensor(reduced, zoom, seed, exposure)

        def small_size(setting: Setting, scale: float) -> CameraSensor:
            return CameraSensor(setting[0].small(), setting[1], seed, exposure)

        self._full = PictureSize(self, full_size, FramePacer(config.rate, repeat_rate))
        preview_pacer = FramePacer(config.preview.rate, repeat_rate)
        self._small = PictureSize(self, small_size, preview_pacer)
        # Replaced as a whole by ROS's threads, read once a picture by the one that renders.
        self._writing = threading.Lock()
        self._setting: Setting = (config, 1.0)
        self._scale = 1.0
        self._publishers: List[rospy.Publisher] = []
        self._depth: Optional[rospy.Publisher] = None
        self._zoom: Optional[rospy.Subscriber] = None

    # ------------------------------------------------------------ any thread

    @property
    def setting(self) -> Setting:
        """How the camera is set now, and its zoom; another object whenever that changes."""
        return self._setting

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
        self._preview = _publisher(f"{topic}/preview/compressed", CompressedImage)
        self._publishers = [self._compressed, self._raw, self._info, self._preview]
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

    def is_preview(self, size: PictureSize) -> bool:
        """Whether a size is that of the previews."""
        return size is self._small

    def weight_of(self, size: PictureSize) -> float:
        """How much a size's rate counts, when there is too little time for all."""
        return LARGE_WEIGHT * (1.0 + self.config.priority) if size is self._full else 1.0

    @property
    def wanted(self) -> List[PictureSize]:
        """The sizes that somebody waits for.

        Where pictures of full size are taken, previews are made of them.
        """
        if not self._publishers:
            return []
        sizes = []
        if self.wants_picture or _is_heard(self._info):
            sizes.append(self._full)
        if _is_heard(self._preview) and not self.wants_picture:
            sizes.append(self._small)
        return sizes

    @property
    def wants_picture(self) -> bool:
        """Whether pictures of full size must be drawn."""
        if not self._publishers:
            return False
        return _is_heard(self._compressed) or _is_heard(self._raw) or self._wants_depth

    @property
    def _wants_depth(self) -> bool:
        return self._depth is not None and _is_heard(self._depth)

    def serve(
        self,
        size: PictureSize,
        renderer: SceneRenderer,
        poses: Callable[[Sequence[float]], Iterator[np.ndarray]],
        stamp: rospy.Time,
        now: float,
    ) -> None:
        """Take a picture, and publish it in the forms that somebody listens to.

        Parameters
        ----------
        size
            Which is due.
        renderer
            Of the scene, which is placed.
        poses
            As for `CameraSensor.take`, given the times before the stamp (s) at which to look.
        stamp
            Sim time of the poses.
        now
            Monotonic time (s).
        """
        sensor = size.sensor()
        size.pacer.sent(now, stamp.to_nsec())
        if size is self._small:
            picture = sensor.take(renderer, poses(sensor.moments), stamp.to_nsec())
            self._publish_preview(sensor, picture, stamp)
            return
        if _is_heard(self._info):
            self._info.publish(camera_info_message(sensor.camera, self._header(stamp)))
        if not self.wants_picture:
            return
        picture = sensor.take(renderer, poses(sensor.moments), stamp.to_nsec())
        self._publish_picture(sensor, picture, renderer, stamp)
        small = self._small.sensor()
        if _is_heard(self._preview) and self._small.pacer.is_due(now, stamp.to_nsec()):
            self._small.pacer.sent(now, stamp.to_nsec())
            shape = (small.config.width, small.config.height)
            reduced = cv2.resize(picture, shape, interpolation=cv2.INTER_AREA)
            self._publish_preview(small, reduced, stamp)

    def scale_by(self, scale: float) -> None:
        """Make pictures of full size smaller by a factor, where `scale` lets that be."""
        self._scale = scale

    @property
    def scale(self) -> float:
        """Factor on the size of full pictures: 1 where others than eyes have use of them."""
        used = _is_heard(self._raw) or _is_heard(self._info) or self._wants_depth
        return 1.0 if used else self._scale

    def _publish_preview(
        self, sensor: CameraSensor, picture: np.ndarray, stamp: rospy.Time
    ) -> None:
        quality = sensor.config.jpeg_quality
        self._preview.publish(compressed_image_message(picture, quality, self._header(stamp)))

    def _publish_picture(
        self, sensor: CameraSensor, picture: np.ndarray, renderer: SceneRenderer, stamp: rospy.Time
    ) -> None:
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
