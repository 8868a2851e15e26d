"""The instructor's camera as ROS moves it."""

from __future__ import annotations

import numpy as np
import rospy
from geometry_msgs.msg import PoseStamped
from telex_msgs.msg import OverviewView

from telex_control.common.params import ConfigError
from telex_control.ros.pose_messages import fill_pose

from ...scene.model import WORLD_FRAME
from ..cameras_config import OVERVIEW, OverviewConfig, ViewConfig
from .camera_topics import SMALL_WEIGHT, CameraStream
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
    """

    def __init__(self, config: OverviewConfig, model: str, seed: int, prefix: str = "") -> None:
        self._rig = OverviewRig(config.start, config.smoothing)
        # Where it is on the newest picture: who points at something in that has to know.
        self._pose = rospy.Publisher(
            f"{prefix}cameras/{OVERVIEW}/pose", PoseStamped, queue_size=1, latch=True
        )
        self.stream = CameraStream(
            OVERVIEW,
            config,
            optical_frame=f"{OVERVIEW}_camera_optical_frame",
            scene_frame=f"{model}/{config.follow}",
            locate=self._locate,
            # It moves while the poses stand still.
            repeat_rate=config.rate,
            seed=seed,
            prefix=prefix,
            # Whoever drives comes before whoever watches.
            weight=SMALL_WEIGHT,
        )
        self._subscriber = rospy.Subscriber(
            f"{prefix}cameras/{OVERVIEW}/view",
            OverviewView,
            self._take,
            queue_size=1,
            tcp_nodelay=True,
        )

    def _locate(self, followed_in_world: np.ndarray, now: float) -> np.ndarray:
        pose = self._rig.pose(followed_in_world, now)
        if self._pose.get_num_connections():
            message = PoseStamped()
            message.header.stamp, message.header.frame_id = rospy.get_rostime(), WORLD_FRAME
            fill_pose(message.pose, pose)
            self._pose.publish(message)
        return pose

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
