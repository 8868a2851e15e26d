"""The robot's cameras as the ``cameras`` node shows them, picture by picture and without it."""

from __future__ import annotations

import os
from dataclasses import replace
from typing import Dict, List, Mapping, Optional, Sequence, Tuple

import numpy as np
from telex_msgs.msg import SceneDescription, ScenePoses

from telex_control.common.file_catalog import package_path
from telex_control.common.params import ConfigError

from ...scene.content_store import shared_store
from ..cameras_config import CameraConfig, CamerasConfig
from ..drawing.gl_context import create_context
from ..drawing.light.daylight import Lighting
from ..drawing.quality import choose_quality
from ..drawing.renderer import Renderer
from ..optics.camera_sensor import CameraSensor
from ..optics.exposure import ExposureControl, exposure_factor
from ..optics.flaws import SOUND, Flaws
from ..ros.messages import frames_from_message, scene_from_message, shadow_focus


class StillCameras:
    """Takes pictures of a scene that is described as for the ``cameras`` node.

    All calls must come from the thread that made it. The same calls make the same pictures.

    Parameters
    ----------
    names : sequence of str
        Cameras that are wanted.
    width : int, optional
        Of the pictures (pixels), the height in proportion; None: as each camera has it.

    Attributes
    ----------
    cameras : dict of str to CameraConfig
        Those that are wanted, in the size of the pictures.

    Raises
    ------
    ConfigError
        There is no such camera, or it cannot have this width.
    NoContextError
        There is no way to render on this machine.
    """

    def __init__(
        self, config: CamerasConfig, names: Sequence[str], width: Optional[int] = None
    ) -> None:
        self.cameras = sized(config, names, width)
        self._config = config
        # Mesa would otherwise start a thread for each core.
        os.environ.setdefault("LP_NUM_THREADS", str(config.software_threads))
        self._context = create_context(config.egl_device)
        with self._context:
            self._renderer = Renderer(
                self._context,
                choose_quality(config.quality, self._context.info["GL_RENDERER"]),
                replace(Lighting(), shadow_radius=config.shadow_radius),
                package_path,
                shared_store(),
            )
        self._numbers: Dict[str, int] = {}
        self._placed: List[ScenePoses] = []
        self._frames = np.zeros((0, 4, 4))
        self._exposures: Dict[str, ExposureControl] = {}
        self._sensors: Dict[str, Tuple[float, CameraSensor]] = {}
        self._frozen: Dict[str, np.ndarray] = {}

    def show(self, message: SceneDescription) -> List[str]:
        """Begin anew with a scene; returns what of it is not shown, and why."""
        scene, problems = scene_from_message(message)
        self._numbers = {name: number for number, name in enumerate(scene.frames)}
        with self._context:
            problems += self._renderer.load_scene(scene.with_lamps(self._config.scene_lamps()))
        self._placed, self._frozen = [], {}
        self._exposures = {name: ExposureControl() for name in self.cameras}
        self._sensors = {}
        return problems

    def place(self, message: ScenePoses, levels: Mapping[str, float]) -> None:
        """Move everything to where it is now, and set the levels of the lamps, 0 to 1."""
        self._placed = [*self._placed[-1:], message]
        with self._context:
            self._move(0.0)
            self._renderer.set_lamp_levels(levels)

    def _move(self, back: float) -> None:
        """Move everything to where it was a moment (s) before."""
        earlier = self._placed[0] if len(self._placed) > 1 else None
        count = len(self._numbers)
        self._frames = frames_from_message(self._placed[-1], count, earlier, back)
        eyes = [self._frame(camera.frame) for camera in self._config.cameras.values()]
        seen = [self._numbers[eye] for eye in eyes if eye in self._numbers]
        self._renderer.place(self._frames, shadow_focus(self._frames, seen))

    def picture(
        self,
        name: str,
        zoom: float = 1.0,
        exposed: Tuple[float, float] = (0.0, 0.0),
        flaws: Flaws = SOUND,
    ) -> np.ndarray:
        """Take a camera's picture of what was placed last.

        Parameters
        ----------
        zoom : float
            Factor on the focal length.
        exposed, flaws
            As for `CameraSensor.develop`.

        Returns
        -------
        ndarray, shape (height, width, 3), uint8
            RGB; black where the robot has no such camera.
        """
        if flaws.frozen and name in self._frozen:
            return self._frozen[name]
        camera = self.cameras[name]
        frame = self._frame(camera.frame)
        if frame not in self._numbers:
            return np.zeros((camera.height, camera.width, 3), np.uint8)
        sensor, stamp = self._sensor(name, zoom), self._placed[-1].header.stamp.to_nsec()
        ev = sensor.expose(stamp)
        pictures = []
        with self._context:
            for back in sensor.moments:
                if len(sensor.moments) > 1:
                    self._move(back)
                pose = self._frames[self._numbers[frame]]
                drawn = self._renderer.render(sensor.pinhole, pose, exposure_factor(ev))
                pictures.append(drawn.copy())
        made = sensor.develop(pictures, False, ev, stamp, exposed, flaws)[..., :3].copy()
        self._frozen[name] = made
        return made

    def _sensor(self, name: str, zoom: float) -> CameraSensor:
        if name not in self._sensors or self._sensors[name][0] != zoom:
            seed = self._config.seed_of(name)
            made = CameraSensor(self.cameras[name], zoom, seed, self._exposures[name])
            self._sensors[name] = (zoom, made)
        return self._sensors[name][1]

    def _frame(self, link: str) -> str:
        return f"{self._config.model}/{link}"

    def release(self) -> None:
        """Free what draws."""
        self._renderer.release()


def sized(
    config: CamerasConfig, names: Sequence[str], width: Optional[int]
) -> Dict[str, CameraConfig]:
    """Return cameras in the size of the pictures that are wanted; see `StillCameras`.

    Raises
    ------
    ConfigError
    """
    for name in names:
        if name not in config.cameras:
            raise ConfigError(f"camera is '{name}'; there are {', '.join(sorted(config.cameras))}")
    wanted = {name: config.cameras[name] for name in names}
    if width is not None:
        wanted = {name: camera.reduced(width) for name, camera in wanted.items()}
    return wanted
