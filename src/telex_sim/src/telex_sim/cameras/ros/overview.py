"""The instructor's camera as ROS moves it."""

from __future__ import annotations

import rospy
from telex_msgs.msg import OverviewView

from telex_control.common.params import ConfigError

from ..cameras_config import OVERVIEW, OverviewConfig, ViewConfig
from .camera_topics import CameraStream
from .overview_rig import OverviewRig


class Overview:
    """A camera that goes where ``cameras/overview/view`` sends it.

    Parameters
    ----------
    model
        Name in the scene of the robot that it follows.
    seed
        As for `CameraStream`.
    prefix
        Of its topics.

    Attributes
    ----------
    stream : CameraStream
    """

    def __init__(self, config: OverviewConfig, model: str, seed: int, prefix: str = "") -> None:
        self._rig = OverviewRig(config.start, config.smoothing)
        self.stream = CameraStream(
            OVERVIEW,
            config,
            optical_frame=f"{OVERVIEW}_camera_optical_frame",
            scene_frame=f"{model}/{config.follow}",
            locate=self._rig.pose,
            # It moves while the poses stand still.
            repeat_rate=config.rate,
            seed=seed,
            prefix=prefix,
        )
        self._subscriber = rospy.Subscriber(
            f"{prefix}cameras/{OVERVIEW}/view",
            OverviewView,
            self._take,
            queue_size=1,
            tcp_nodelay=True,
        )

    def _take(self, message: OverviewView) -> None:
        center = message.center
        try:
            self._rig.view = ViewConfig(
                message.mode,
                message.azimuth,
                message.elevation,
                message.distance,
                message.turn_rate,
                (center.x, center.y, center.z),
            )
        except ConfigError as error:
            rospy.logwarn("camera %s: %s; it stays where it is", OVERVIEW, error)
