"""Model of a camera: lens, exposure and noise of the renderer's pictures."""

from __future__ import annotations

import math
from typing import Optional, Sequence, Tuple

import numpy as np

from ..cameras_config import OpticsConfig
from .exposure import ExposureControl, exposure_factor
from .flaws import SOUND, FlawedGlass, Flaws
from .lens import LensCamera, LensMap
from .noise import SensorNoise
from .pinhole import PinholeCamera
from .vignetting import Vignette


class CameraSensor:
    """One setting of one camera; when the setting changes, another takes its place.

    Parameters
    ----------
    zoom
        Factor on the focal length.
    seed
        Of the noise.
    control
        Of the exposure; outlives the setting.

    Attributes
    ----------
    camera : LensCamera
        That the pictures are of; what sensor_msgs/CameraInfo describes.

    Raises
    ------
    DistortionError
    """

    def __init__(
        self,
        config: OpticsConfig,
        zoom: float,
        seed: int,
        control: ExposureControl,
    ) -> None:
        self.config = config
        self.camera: LensCamera = config.optics(zoom)
        self._control = control
        self._lens = LensMap(self.camera, config.detail)
        self._vignette: Optional[Vignette] = None
        if config.vignetting:
            self._vignette = Vignette(config.width, config.height, config.vignetting)
        self._noise = SensorNoise(config.width, config.height, seed)
        self._glass = FlawedGlass(config.width, config.height, seed)
        # By the lens, while the renderer repeats its picture.
        self._bent: Optional[np.ndarray] = None

    @property
    def moments(self) -> Tuple[float, ...]:
        """Times before a picture's stamp (s) at which the scene is looked at; the last is 0."""
        if self.config.shutter == 0.0:
            return (0.0,)
        return tuple(np.linspace(self.config.shutter, 0.0, self.config.shutter_samples).tolist())

    @property
    def pinhole(self) -> PinholeCamera:
        """The camera whose pictures `develop` takes; wider than this one where the lens bends."""
        return self._lens.pinhole

    def expose(self, stamp: int) -> float:
        """Choose the exposure (EV) of the picture of a sim time (ns), the next one."""
        return self._control.expose(self.config.exposure, stamp)

    def develop(
        self,
        pictures: Sequence[np.ndarray],
        repeated: bool,
        ev: float,
        stamp: int,
        exposed: Tuple[float, float] = (0.0, 0.0),
        flaws: Flaws = SOUND,
    ) -> np.ndarray:
        """Make the sensor's picture of what the pinhole camera saw.

        Parameters
        ----------
        pictures
            RGBA, shape (pinhole.height, pinhole.width, 4), uint8, one for each of `moments`; one
            alone may be written to.
        repeated
            Whether they are what this sensor's last ones were: nothing has moved.
        ev
            The exposure that `expose` chose, with which they were taken.
        stamp
            Sim time (ns).
        exposed
            Dose rate (Gy/h) and dose (Gy) beyond those of the configuration.
        flaws
            What is wrong with it; whether it is frozen does not matter here.

        Returns
        -------
        numpy.ndarray
            RGBA, shape (height, width, 4), uint8; good until the next picture is taken.
        """
        picture = _mean(pictures)
        if self.config.exposure.auto:
            self._control.meter(picture)
        picture = self._bend(picture, repeated)
        if flaws != SOUND:
            self._glass.show(picture, flaws)
        radiation = self.config.radiation.exposed(*exposed)
        self._noise.age(picture, radiation)
        # What is amplified twice as much is sqrt(2) times as noisy, because half the light came.
        noise = self.config.noise * exposure_factor(0.5 * max(ev, 0.0))
        self._noise.add(picture, math.hypot(noise, flaws.noisy), stamp)
        self._noise.irradiate(picture, radiation, stamp)
        return picture

    def _bend(self, picture: np.ndarray, repeated: bool) -> np.ndarray:
        if not repeated:
            self._bent = None
        if self._bent is None:
            bent = self._lens.bend(picture)
            if self._vignette is not None:
                self._vignette.darken(bent)
            if not repeated or bent is picture:
                return bent
            self._bent = bent
        return self._bent.copy()  # for what follows writes into it

    def depth(self, depths: np.ndarray) -> np.ndarray:
        """Show depths along z (m, inf for none) as the lens does.

        Parameters
        ----------
        depths
            Of the pinhole camera, shape (pinhole.height, pinhole.width), float32.

        Returns
        -------
        numpy.ndarray
            Shape (height, width), float32.
        """
        return self._lens.bend_depth(depths)


def _mean(pictures: Sequence[np.ndarray]) -> np.ndarray:
    """Mean light of pictures."""
    if len(pictures) == 1:
        return pictures[0]
    # Dark values are stretched when they are shown, about as a square root does.
    light = sum(np.square(picture, dtype=np.float32) for picture in pictures)
    return np.sqrt(light / len(pictures)).astype(np.uint8)
