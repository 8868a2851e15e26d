"""One of the two sizes in which a camera's pictures are taken, and when."""

from __future__ import annotations

from typing import Callable, Optional, Tuple

from ..cameras_config import OpticsConfig
from ..optics.camera_sensor import CameraSensor
from .frame_pacer import FramePacer

Setting = Tuple[OpticsConfig, float]
"""How a camera is set, and its zoom."""


class PictureSize:
    """Takes a camera's pictures in full size, or its previews.

    Parameters
    ----------
    make_sensor
        Makes what takes the pictures, of a setting and a scale.
    """

    def __init__(
        self, make_sensor: Callable[[Setting, float], CameraSensor], pacer: FramePacer
    ) -> None:
        self.pacer = pacer
        self._make_sensor = make_sensor
        self._made_for: Optional[Tuple[Setting, float]] = None
        self._sensor: Optional[CameraSensor] = None

    def sensor(self, setting: Setting, scale: float = 1.0) -> CameraSensor:
        """Return the camera as it is set now; ask once for each picture."""
        wanted = (setting, scale)
        if self._sensor is None or wanted != self._made_for:
            self._sensor = self._make_sensor(*wanted)
            self.pacer.rate = self._sensor.config.rate
            self._made_for = wanted
        return self._sensor
