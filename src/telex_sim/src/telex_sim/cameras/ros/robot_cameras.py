"""Cameras and lamps of one robot, as ROS asks for them and switches them."""

from __future__ import annotations

from typing import Callable, Dict, List, Mapping

import numpy as np
import rospy
from std_msgs.msg import Float64

from ..cameras_config import OVERVIEW, CamerasConfig, LampConfig
from ..optics.flaws import Flaws
from .camera_topics import CameraStream
from .failures import HeardMalfunctions, Received, ReceivedDose
from .overview import Overview
from .parameter_service import CameraService


class RobotCameras:
    """All cameras of a robot with the instructor's, its lamps, and what of them does not work.

    Parameters
    ----------
    config
        Of its cameras and lamps.
    namespace
        Of a further robot; empty for the one in whose namespace the node is.

    Attributes
    ----------
    streams : list of CameraStream
        The cameras; that of the instructor is the last, if there is one.
    frames : list of str
        Of the robot's own cameras, in the scene.
    lamps : list of VisualLamp
        On frames of the scene.
    service : CameraService
        That sets the cameras.
    """

    def __init__(self, config: CamerasConfig, namespace: str = "") -> None:
        prefix = f"{namespace}/" if namespace else ""
        self._own = frozenset(config.cameras)
        self.streams = [
            CameraStream(
                name,
                camera,
                optical_frame=camera.frame,
                scene_frame=f"{config.model}/{camera.frame}",
                locate=_itself,
                repeat_rate=config.repeat_rate,
                # Robots alike have cameras of the same names.
                seed=config.seed_of(f"{prefix}{name}"),
                prefix=prefix,
            )
            for name, camera in sorted(config.cameras.items())
        ]
        self.frames = [stream.scene_frame for stream in self.streams]
        if config.overview is not None:
            seed = config.seed_of(f"{prefix}{OVERVIEW}")
            self._overview = Overview(config.overview, config.model, seed, prefix)
            self.streams.append(self._overview.stream)
        # Lamps of several robots have the same names.
        self._lamp = f"{config.model}/" if namespace else ""
        self.lamps = config.scene_lamps(self._lamp)
        self._switches = LampSwitches(config.lamps, prefix)
        self._received = ReceivedDose(prefix)
        self._malfunctions = HeardMalfunctions(prefix)
        self.service = CameraService(config, self.streams, namespace)

    def works(self, stream: CameraStream) -> bool:
        """Whether a camera sends pictures; the view from outside is none of the robot's."""
        powered = self._malfunctions.cameras_work or stream.name not in self._own
        return powered and not self._received.of(stream.name).failed

    def received(self, stream: CameraStream) -> Received:
        """What a camera has received of radiation."""
        return self._received.of(stream.name)

    def flaws(self, stream: CameraStream) -> Flaws:
        """What is wrong with a camera."""
        return self._malfunctions.flaws(stream.name)

    def freezes(self, stream: CameraStream) -> int:
        """How often a camera has frozen."""
        return self._malfunctions.freezes(stream.name)

    def levels(self) -> Dict[str, float]:
        """Level of each lamp, 0 (off) to 1, by its name in the scene."""
        levels = self._switches.levels(self._malfunctions.burns)
        return {f"{self._lamp}{name}": level for name, level in levels.items()}


def _itself(frame_in_world: np.ndarray, now: float) -> np.ndarray:
    """Pose of a camera whose optical frame is part of the scene."""
    return frame_in_world


class LampSwitches:
    """Hears on ``lamps/<name>/command`` how brightly each lamp shall burn.

    Tells it on ``lamps/<name>/level``, latched: how a lamp is switched, not whether it burns.

    Parameters
    ----------
    lamps
        By name.
    prefix
        Of its topics.
    """

    def __init__(self, lamps: Mapping[str, LampConfig], prefix: str = "") -> None:
        # Single items are replaced by ROS's threads, which needs no lock.
        self._levels: Dict[str, float] = {name: lamp.level for name, lamp in lamps.items()}
        self._told: Dict[str, rospy.Publisher] = {
            name: rospy.Publisher(
                f"{prefix}lamps/{name}/level", Float64, queue_size=1, latch=True, tcp_nodelay=True
            )
            for name in lamps
        }
        for name in lamps:
            self._tell(name)
        self._subscribers: List[rospy.Subscriber] = [
            rospy.Subscriber(
                f"{prefix}lamps/{name}/command",
                Float64,
                self._take,
                callback_args=name,
                queue_size=1,
            )
            for name in lamps
        ]

    def levels(self, burns: Callable[[str], bool]) -> Dict[str, float]:
        """Level of each lamp, 0 (off) to 1, by its name; `burns` says which are whole."""
        return {name: level if burns(name) else 0.0 for name, level in self._levels.items()}

    def _take(self, message: Float64, name: str) -> None:
        # Also false for NaN.
        if not 0.0 <= message.data <= 1.0:
            rospy.logwarn(
                "lamp %s: level is %g; 0 to 1 is possible, it stays at %g",
                name,
                message.data,
                self._levels[name],
            )
            return
        self._levels[name] = message.data
        self._tell(name)

    def _tell(self, name: str) -> None:
        self._told[name].publish(Float64(self._levels[name]))
