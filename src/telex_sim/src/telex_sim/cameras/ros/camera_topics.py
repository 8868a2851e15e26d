"""The topics of one camera."""

from __future__ import annotations

import math
import threading
from dataclasses import replace
from typing import Callable, List, NamedTuple, Optional

import cv2
import numpy as np
import rospy
from sensor_msgs.msg import CameraInfo, CompressedImage, Image
from std_msgs.msg import Float64, Header

from ..cameras_config import LEAST_DETAIL, OpticsConfig
from ..optics.camera_sensor import CameraSensor
from ..optics.exposure import ExposureControl
from .frame_pacer import FramePacer
from .messages import camera_info_message, compressed_image_message, depth_message, image_message
from .picture_size import PictureSize, Setting
from .size_by_load import STEPS, SizeStep

Locate = Callable[[np.ndarray, float], np.ndarray]
"""Gives the pose of the optical frame in the world, of that of the frame in the scene on which the
camera depends, and of the monotonic time (s)."""


LARGE_WEIGHT, SMALL_WEIGHT = 1.5, 1.0
"""What pictures of full size count for beside previews when there is too little time: they keep
their rate until previews have fallen to two thirds of theirs, whichever camera somebody looks
through.
"""


class Wanted(NamedTuple):
    """Pictures of a camera that somebody waits for.

    Attributes
    ----------
    stream : CameraStream
        The camera's topics.
    is_preview : bool
        Whether they are previews.
    pacer : FramePacer
        Says when they are due.
    weight : float
        By which their rate counts, when there is too little time for all.
    """

    stream: CameraStream
    is_preview: bool
    pacer: FramePacer
    weight: float


class StreamView(NamedTuple):
    """How to take a picture.

    Attributes
    ----------
    sensor : CameraSensor
        That takes it.
    coarse : bool
        Whether shapes may be coarser.
    """

    sensor: CameraSensor
    coarse: bool


class CameraStream:
    """The topics of a camera, served as far as somebody listens.

    Parameters
    ----------
    name
        Of the camera; the topics stand under ``cameras/<name>``.
    optical_frame
        What messages call the frame that they are in.
    scene_frame
        The frame in the scene on which the camera depends.
    repeat_rate
        Pictures per second while the poses stand still.
    seed
        Of its noise.
    prefix
        Of its topics: namespace of another robot, with a slash at its end.
    weight
        What its pictures of full size count for.
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
        prefix: str = "",
        weight: float = LARGE_WEIGHT,
    ) -> None:
        self.name = name
        self._weight = weight
        self._topic = f"{prefix}cameras/{name}"
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
            config, zoom = setting
            small = config.small()
            reduced = replace(small, detail=max(scale * small.detail, LEAST_DETAIL))
            return CameraSensor(reduced, zoom, seed, exposure)

        self._full = PictureSize(full_size, FramePacer(config.rate, repeat_rate))
        self._small = PictureSize(small_size, FramePacer(config.preview.rate, repeat_rate))
        # Replaced as a whole by ROS's threads, read once a picture by the one that renders.
        self._writing = threading.Lock()
        self._setting: Setting = (config, 1.0)
        self._step = STEPS[0]
        self._publishers: List[rospy.Publisher] = []
        self._depth: Optional[rospy.Publisher] = None
        self._zoom: Optional[rospy.Subscriber] = None
        self._zoom_factor: Optional[rospy.Publisher] = None

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
        if not math.isfinite(wanted):
            rospy.logwarn("camera %s: zoom is %g; 1 to %g is possible", self.name, wanted, most)
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
        self._tell_zoom()

    def _tell_zoom(self) -> None:
        told = self._zoom_factor
        if told is not None:
            told.publish(Float64(self._setting[1]))

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
        topic = self._topic
        self._compressed = _publisher(f"{topic}/image_raw/compressed", CompressedImage)
        self._raw = _publisher(f"{topic}/image_raw", Image)
        self._info = _publisher(f"{topic}/camera_info", CameraInfo)
        self._preview = _publisher(f"{topic}/preview/compressed", CompressedImage)
        self._publishers = [self._compressed, self._raw, self._info, self._preview]
        if self.config.zoom_max > 1.0:
            self._zoom_factor = rospy.Publisher(
                f"{topic}/zoom_factor", Float64, queue_size=1, latch=True, tcp_nodelay=True
            )
            self._tell_zoom()
            self._zoom = rospy.Subscriber(
                f"{topic}/zoom", Float64, self._take_zoom, queue_size=1, tcp_nodelay=True
            )

    def _close(self) -> None:
        self._offer_depth(False)
        for publisher in self._publishers:
            publisher.unregister()
        self._publishers = []
        if self._zoom is not None and self._zoom_factor is not None:
            self._zoom.unregister()
            self._zoom_factor.unregister()
            self._zoom = self._zoom_factor = None

    def _offer_depth(self, wanted: bool) -> None:
        if wanted and self._depth is None:
            self._depth = _publisher(f"{self._topic}/depth", Image)
        elif not wanted and self._depth is not None:
            self._depth.unregister()
            self._depth = None

    @property
    def wanted(self) -> List[Wanted]:
        """What somebody waits for, in each of the sizes.

        Where pictures of full size are taken, previews are made of them.
        """
        if not self._publishers:
            return []
        wanted = []
        if self.wants_picture or _is_heard(self._info):
            weight = self._weight * (1.0 + self.config.priority)
            wanted.append(Wanted(self, False, self._full.pacer, weight))
        if _is_heard(self._preview) and not self.wants_picture:
            wanted.append(Wanted(self, True, self._small.pacer, SMALL_WEIGHT))
        return wanted

    @property
    def wants_picture(self) -> bool:
        """Whether pictures of full size must be drawn."""
        if not self._publishers:
            return False
        return _is_heard(self._compressed) or _is_heard(self._raw) or self.wants_depth

    @property
    def wants_depth(self) -> bool:
        """Whether somebody listens to depths."""
        return self._depth is not None and _is_heard(self._depth)

    def begin(self, preview: bool, stamp: rospy.Time, now: float) -> StreamView:
        """Note that a picture is being taken, and return how to take it.

        Parameters
        ----------
        preview
            Whether it is a preview.
        stamp
            Sim time of its poses.
        now
            Monotonic time (s).
        """
        if preview:
            view = StreamView(self._small_sensor(), self._step.coarse_previews)
            self._small.pacer.sent(now, stamp.to_nsec())
            return view
        # Where others than eyes have use of pictures, they stay as they are.
        used = _is_heard(self._raw) or _is_heard(self._info) or self.wants_depth
        step = STEPS[0] if used else self._step
        view = StreamView(self._full.sensor(self._setting, step.scale), step.coarse)
        self._full.pacer.sent(now, stamp.to_nsec())
        if _is_heard(self._info):
            self._info.publish(camera_info_message(view.sensor.camera, self._header(stamp)))
        return view

    def full_sensor(self) -> CameraSensor:
        """Return what takes pictures of full size, without loss of detail."""
        return self._full.sensor(self._setting, STEPS[0].scale)

    def _small_sensor(self) -> CameraSensor:
        return self._small.sensor(self._setting, self._step.preview_detail)

    def publish_preview(self, sensor: CameraSensor, picture: np.ndarray, stamp: rospy.Time) -> None:
        """Publish a small picture."""
        quality = sensor.config.jpeg_quality
        self._preview.publish(compressed_image_message(picture, quality, self._header(stamp)))

    def publish(
        self,
        sensor: CameraSensor,
        picture: np.ndarray,
        depth: Optional[np.ndarray],
        stamp: rospy.Time,
        now: float,
    ) -> None:
        """Publish a picture of full size in the forms that somebody listens to, previews as well.

        Parameters
        ----------
        sensor
            That took it, as `begin` returned it.
        picture
            RGBA, shape (height, width, 4), uint8.
        depth
            Along z (m, inf for none), shape (height, width), float32; None where nobody asks.
        stamp, now
            As for `begin`.
        """
        header = self._header(stamp)
        if _is_heard(self._compressed):
            quality = sensor.config.jpeg_quality
            self._compressed.publish(compressed_image_message(picture, quality, header))
        if _is_heard(self._raw):
            self._raw.publish(image_message(picture, header))
        if self._depth is not None and depth is not None:
            self._depth.publish(depth_message(depth, header))
        small = self._small_sensor()
        if _is_heard(self._preview) and self._small.pacer.is_due(now, stamp.to_nsec()):
            self._small.pacer.sent(now, stamp.to_nsec())
            shape = (small.config.width, small.config.height)
            reduced = cv2.resize(picture, shape, interpolation=cv2.INTER_AREA)
            self.publish_preview(small, reduced, stamp)

    def give_way(self, step: SizeStep) -> None:
        """Have pictures lose so much detail, where nobody but eyes has use of them."""
        self._step = step

    def _header(self, stamp: rospy.Time) -> Header:
        return Header(stamp=stamp, frame_id=self._optical_frame)


def _is_heard(publisher: rospy.Publisher) -> bool:
    return publisher.get_num_connections() > 0


def _publisher(topic: str, kind: type) -> rospy.Publisher:
    # One message waits at most: a slow listener gets the newest picture, not the oldest.
    return rospy.Publisher(topic, kind, queue_size=1, tcp_nodelay=True)
