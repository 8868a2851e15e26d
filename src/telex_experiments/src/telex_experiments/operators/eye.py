"""A camera's picture in front of an operator."""

from __future__ import annotations

from typing import Any, Optional

import cv2
import numpy as np
from sensor_msgs.msg import CameraInfo, CompressedImage

from telex_experiments.mobility.scripted_operator import NotManagedError

from .film import PATIENCE
from .station import Station
from .vision import View


class Eye:
    """Looks through one of the robot's cameras, by its compressed pictures; close it when done.

    Parameters
    ----------
    station : Station
    camera : str
        E.g. gripper.
    """

    def __init__(self, station: Station, camera: str) -> None:
        self._station = station
        self.camera = camera
        self._frame = f"{camera}_camera_optical_frame"
        self._picture: Optional[CompressedImage] = None
        self._info: Optional[CameraInfo] = None
        # A handle of its own: nothing is drawn for an eye that is closed.
        self._node = station.link.node.child(f"cameras/{camera}")
        self._node.subscribe("image_raw/compressed", CompressedImage, self._on_picture)
        self._node.subscribe("camera_info", CameraInfo, self._on_info)

    def _on_picture(self, message: Any) -> None:
        self._picture = message

    def _on_info(self, message: Any) -> None:
        self._info = message

    def look(self) -> View:
        """Wait for a picture of the present moment, while the robot rests.

        Raises
        ------
        NotManagedError
            None comes.
        """
        station = self._station
        since = station.link.now()

        def stamp() -> float:
            if self._picture is None or self._info is None:
                return -1.0
            return float(self._picture.header.stamp.to_sec())

        station.until(lambda: stamp() >= since, PATIENCE, f"a picture of camera {self.camera}")
        picture: Any = self._picture
        info: Any = self._info
        image = cv2.imdecode(np.frombuffer(picture.data, np.uint8), cv2.IMREAD_COLOR)
        if image is None:
            raise NotManagedError(f"camera {self.camera}: its picture cannot be read")
        matrix, distortion = np.array(info.K).reshape(3, 3), np.array(info.D)
        return View(image, matrix, distortion, station.place_of(self._frame))

    def close(self) -> None:
        """Look away."""
        self._node.shutdown()
