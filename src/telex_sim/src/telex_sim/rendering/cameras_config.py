"""Parameters of the ``cameras`` node."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Dict

from telex_control.params import require, require_choice, require_range, require_text

from .camera import PinholeCamera
from .quality import AUTO, TIERS

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*\Z")
_MAX_SIZE = 4096
_MAX_FOV = 3.0
_MAX_RATE = 240.0


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

    def __post_init__(self) -> None:
        require(
            bool(self.frame) and not self.frame.startswith("/"),
            f"frame is '{self.frame}'; the name of a link is needed",
        )
        require_range(self, "width", 16, _MAX_SIZE)
        require_range(self, "height", 16, _MAX_SIZE)
        require_range(self, "horizontal_fov", 0.05, _MAX_FOV)
        require_range(self, "near", 0.001)
        require(
            self.far > self.near, f"far is {self.far}; it must be beyond near, which is {self.near}"
        )
        require_range(self, "rate", above=0.0, maximum=_MAX_RATE)
        require_range(self, "jpeg_quality", 1, 100)

    def optics(self) -> PinholeCamera:
        """Return what the renderer needs to know of the camera."""
        return PinholeCamera(self.width, self.height, self.horizontal_fov, self.near, self.far)


@dataclass(frozen=True)
class CamerasConfig:
    """All parameters of the node.

    Attributes
    ----------
    cameras
        By name; topics and messages use it.
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
    model: str = "telex"
    quality: str = AUTO
    shadow_radius: float = 4.0
    repeat_rate: float = 5.0
    niceness: int = 5
    software_threads: int = 0
    egl_device: int = 0

    def __post_init__(self) -> None:
        require(bool(self.cameras), "cameras is empty; at least one camera is needed")
        for name in self.cameras:
            require(
                bool(_NAME.match(name)),
                f"cameras has the key '{name}'; letters, digits and _ make a name",
            )
        require_text(self, "model")
        require_choice(self, "quality", (AUTO, *TIERS))
        require_range(self, "shadow_radius", above=0.0)
        require_range(self, "repeat_rate", above=0.0)
        require_range(self, "niceness", 0, 19)
        require_range(self, "software_threads", 0, 16)
        require_range(self, "egl_device", 0)
