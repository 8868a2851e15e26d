"""Model of a camera: lens, exposure and noise of the renderer's pictures."""

from __future__ import annotations

from typing import Iterable, Iterator, Optional, Tuple

import numpy as np

from ..cameras_config import OpticsConfig
from ..drawing.scene_renderer import SceneRenderer
from .exposure import ExposureControl, exposure_factor
from .lens import LensCamera, LensMap
from .noise import SensorNoise


class CameraSensor:
    """One setting of one camera; when the setting changes, another takes its place.

    Parameters
    ----------
    config
        Of the camera.
    zoom
        Factor on the focal length.
    seed
        Of the noise.
    control
        Of the exposure; outlives the setting.

    Attributes
    ----------
    config : OpticsConfig
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
        self._noise = SensorNoise(config.width, config.height, seed)
        # By the lens, while the renderer repeats its picture.
        self._bent: Optional[np.ndarray] = None

    @property
    def moments(self) -> Tuple[float, ...]:
        """Times before a picture's stamp (s) at which the scene is looked at; the last is 0."""
        if self.config.shutter == 0.0:
            return (0.0,)
        return tuple(np.linspace(self.config.shutter, 0.0, self.config.shutter_samples).tolist())

    def take(self, renderer: SceneRenderer, poses: Iterable[np.ndarray], stamp: int) -> np.ndarray:
        """Take a picture.

        Parameters
        ----------
        renderer
            Of the scene.
        poses
            Of the camera's optical frame in the world, shape (4, 4), one for each of `moments`; the
            iterator places the scene for a moment before it gives the pose.
        stamp
            Sim time (ns).

        Returns
        -------
        numpy.ndarray
            RGBA, shape (height, width, 4), uint8; good until the next picture is taken.
        """
        ev = self._control.expose(self.config.exposure, stamp)
        pinhole, factor = self._lens.pinhole, exposure_factor(ev)
        pictures = (renderer.render(pinhole, pose, factor) for pose in poses)
        picture = _mean(pictures, len(self.moments))
        if self.config.exposure.auto:
            self._control.meter(picture)
        picture = self._bend(picture, renderer.repeats)
        # What is amplified twice as much is sqrt(2) times as noisy, because half the light came.
        self._noise.add(picture, self.config.noise * exposure_factor(0.5 * max(ev, 0.0)), stamp)
        self._noise.irradiate(picture, self.config.radiation, stamp)
        return picture

    def _bend(self, picture: np.ndarray, repeated: bool) -> np.ndarray:
        if not repeated:
            self._bent = None
        if self._bent is None:
            bent = self._lens.bend(picture)
            if not repeated or bent is picture:
                return bent
            self._bent = bent
        return self._bent.copy()  # for what follows writes into it

    def depth(self, renderer: SceneRenderer) -> np.ndarray:
        """Return depths along z (m, inf for none) of what `take` took last.

        Returns
        -------
        numpy.ndarray
            Shape (height, width), float32.
        """
        return self._lens.bend_depth(renderer.depth(self._lens.pinhole))


def _mean(pictures: Iterator[np.ndarray], count: int) -> np.ndarray:
    """Mean light of so many pictures, each of which may overwrite the one before."""
    if count == 1:
        return next(pictures)
    # Dark values are stretched when they are shown, about as a square root does.
    light = sum(np.square(picture, dtype=np.float32) for picture in pictures)
    return np.sqrt(light / count).astype(np.uint8)
