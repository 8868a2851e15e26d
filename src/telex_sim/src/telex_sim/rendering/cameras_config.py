"""Parameters of the ``cameras`` node."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Dict

from telex_control.params import require

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
        for key in ("width", "height"):
            size = getattr(self, key)
            require(
                16 <= size <= _MAX_SIZE, f"{key} is {size}; 16 to {_MAX_SIZE} pixels are possible"
            )
        require(
            0.05 <= self.horizontal_fov <= _MAX_FOV,
            f"horizontal_fov is {self.horizontal_fov}; 0.05 to {_MAX_FOV} rad are possible",
        )
        require(self.near >= 0.001, f"near is {self.near}; it must be at least 0.001 m")
        require(
            self.far > self.near, f"far is {self.far}; it must be beyond near, which is {self.near}"
        )
        require(
            0.0 < self.rate <= _MAX_RATE,
            f"rate is {self.rate}; it must be above 0, up to {_MAX_RATE:.0f} per second",
        )
        require(
            1 <= self.jpeg_quality <= 100,
            f"jpeg_quality is {self.jpeg_quality}; 1 to 100 are possible",
        )

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
        require(bool(self.model), "model is empty; the robot's name in the scene is needed")
        require(
            self.quality == AUTO or self.quality in TIERS,
            f"quality is '{self.quality}'; {', '.join([AUTO, *TIERS])} are possible",
        )
        require(
            self.shadow_radius > 0.0,
            f"shadow_radius is {self.shadow_radius}; it must be above 0 m",
        )
        require(
            self.repeat_rate > 0.0,
            f"repeat_rate is {self.repeat_rate}; it must be above 0 per second",
        )
        require(0 <= self.niceness <= 19, f"niceness is {self.niceness}; 0 to 19 are possible")
        require(
            0 <= self.software_threads <= 16,
            f"software_threads is {self.software_threads}; 0 to 16 are possible",
        )
        require(self.egl_device >= 0, f"egl_device is {self.egl_device}; 0 or more is needed")
