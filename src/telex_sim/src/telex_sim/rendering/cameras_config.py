"""Parameters of the ``cameras`` node."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from typing import Dict, Tuple

from telex_control.params import require, require_choice, require_range, require_text

from .camera import PinholeCamera
from .quality import AUTO, TIERS
from .scene import Lamp

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*\Z")
_MAX_SIZE = 4096
_MAX_FOV = 3.0
_MAX_RATE = 240.0
_MAX_ZOOM = 100.0


@dataclass(frozen=True)
class CameraConfig:
    """One camera.

    Attributes
    ----------
    frame
        Its optical frame, a link of the model: z forward, x right, y down.
    width, height
        Size of the picture (pixels).
    horizontal_fov
        Full angle of view across the width (rad).
    near, far
        What is drawn lies between these distances (m).
    rate
        Pictures per second of wall time while somebody looks.
    jpeg_quality
        1 to 100.
    zoom_max
        Largest zoom, a factor on the focal length; 1: the camera cannot zoom.

    Raises
    ------
    telex_control.params.ConfigError
    """

    frame: str
    width: int
    height: int
    horizontal_fov: float
    near: float = 0.03
    far: float = 60.0
    rate: float = 25.0
    jpeg_quality: int = 80
    zoom_max: float = 1.0

    def __post_init__(self) -> None:
        _require_link(self.frame)
        require_range(self, "width", 16, _MAX_SIZE)
        require_range(self, "height", 16, _MAX_SIZE)
        require_range(self, "horizontal_fov", 0.05, _MAX_FOV)
        require_range(self, "near", 0.001)
        require(
            self.far > self.near, f"far is {self.far}; it must be beyond near, which is {self.near}"
        )
        require_range(self, "rate", above=0.0, maximum=_MAX_RATE)
        require_range(self, "jpeg_quality", 1, 100)
        require_range(self, "zoom_max", 1.0, _MAX_ZOOM)

    def optics(self, zoom: float = 1.0) -> PinholeCamera:
        """Return what the renderer needs to know of the camera, zoomed in by a factor."""
        fov = 2.0 * math.atan(math.tan(0.5 * self.horizontal_fov) / zoom)
        return PinholeCamera(self.width, self.height, fov, self.near, self.far)


@dataclass(frozen=True)
class LampConfig:
    """A lamp of the robot; it can be dimmed while the node runs.

    Attributes
    ----------
    frame
        Link of the model; the lamp is at its origin and shines along its x.
    angle
        Full angle of the cone (rad).
    intensity
        At full level; 1: a surface 1 m away that faces it is lit like by a bright day's sun.
    reach
        Distance at which its light has faded to nothing (m).
    color
        Red, green, blue, each 0 to 1, sRGB.
    level
        With which it starts: 0 is off, 1 full.

    Raises
    ------
    telex_control.params.ConfigError
    """

    frame: str
    angle: float = 1.2
    intensity: float = 4.0
    reach: float = 10.0
    color: Tuple[float, float, float] = (1.0, 0.97, 0.92)
    level: float = 0.0

    def __post_init__(self) -> None:
        _require_link(self.frame)
        require_range(self, "angle", maximum=2.0 * math.pi + 0.01, above=0.0)
        require_range(self, "intensity", 0.0, 1.0e4)
        require_range(self, "reach", maximum=1.0e4, above=0.0)
        require(
            all(0.0 <= component <= 1.0 for component in self.color),
            f"color is {list(self.color)}; numbers from 0 to 1 are needed",
        )
        require_range(self, "level", 0.0, 1.0)

    def lamp(self, name: str, model: str) -> Lamp:
        """Return the lamp as a part of a scene in which the robot is called ``model``."""
        return Lamp(
            frame=f"{model}/{self.frame}",
            position=(0.0, 0.0, 0.0),
            direction=(1.0, 0.0, 0.0),
            angle=self.angle,
            intensity=self.intensity,
            reach=self.reach,
            color=self.color,
            name=name,
        )


def _require_link(frame: str) -> None:
    require(
        bool(frame) and not frame.startswith("/"),
        f"frame is '{frame}'; the name of a link is needed",
    )


@dataclass(frozen=True)
class CamerasConfig:
    """All parameters of the node.

    Attributes
    ----------
    cameras
        By name; topics and messages use it.
    lamps
        Of the robot, by name.
    model
        Name of the robot in the scene; its frames are "<model>/<link>".
    quality
        Tier of quality, or "auto" to choose it by what renders.
    shadow_radius
        Distance from the robot up to which the sun casts shadows (m).
    repeat_rate
        Pictures per second while the simulation is paused.
    niceness
        By how much the process steps back for others, above all for the physics, 0 to 19.
    software_threads
        Further threads for rendering without a graphics card. More give each picture sooner and
        take the cores from the physics; with 0 the node never uses more than one.
    egl_device
        Which graphics card, as EGL numbers them.

    Raises
    ------
    telex_control.params.ConfigError
    """

    cameras: Dict[str, CameraConfig]
    lamps: Dict[str, LampConfig] = field(default_factory=dict)
    model: str = "telex"
    quality: str = AUTO
    shadow_radius: float = 4.0
    repeat_rate: float = 5.0
    niceness: int = 5
    software_threads: int = 0
    egl_device: int = 0

    def __post_init__(self) -> None:
        require(bool(self.cameras), "cameras is empty; at least one camera is needed")
        for group, names in (("cameras", self.cameras), ("lamps", self.lamps)):
            for name in names:
                require(
                    bool(_NAME.match(name)),
                    f"{group} has the key '{name}'; letters, digits and _ make a name",
                )
        require_text(self, "model")
        require_choice(self, "quality", (AUTO, *TIERS))
        require_range(self, "shadow_radius", above=0.0)
        require_range(self, "repeat_rate", above=0.0)
        require_range(self, "niceness", 0, 19)
        require_range(self, "software_threads", 0, 16)
        require_range(self, "egl_device", 0)
