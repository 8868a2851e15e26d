"""A camera's picture in front of an operator."""

from __future__ import annotations

import cv2
import numpy as np

from .port import NotManagedError
from .station import Station
from .vision import SeenPicture

PATIENCE = 60.0
"""Sim time (s) for a renderer that has yet to start, and shares the processor."""


class Eye:
    """Looks through one of the robot's cameras; close it when done.

    Parameters
    ----------
    camera : str
        E.g. gripper.

    Raises
    ------
    NotManagedError
        There is no such camera.
    """

    def __init__(self, station: Station, camera: str) -> None:
        self._station = station
        self.camera = camera
        self._frame = f"{camera}_camera_optical_frame"
        self._view = station.port.camera(camera)

    def look(self) -> SeenPicture:
        """Wait for a picture of the present moment, while the robot rests.

        Raises
        ------
        NotManagedError
            None comes, or it cannot be read.
        """
        station, since = self._station, self._station.now

        def fresh() -> bool:
            picture = self._view.picture()
            return picture is not None and picture.time >= since

        station.until(fresh, PATIENCE, f"a picture of camera {self.camera}")
        picture = self._view.picture()
        assert picture is not None
        image = cv2.imdecode(np.frombuffer(picture.data, np.uint8), cv2.IMREAD_COLOR)
        if image is None:
            raise NotManagedError(f"camera {self.camera}: its picture cannot be read")
        return SeenPicture(image, picture.matrix, picture.distortion, station.place_of(self._frame))

    def close(self) -> None:
        """Look away."""
        self._view.close()
