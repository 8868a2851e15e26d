"""Parameters of the ``cameras`` node."""

from __future__ import annotations

import math
import re
import zlib
from dataclasses import dataclass, field, replace
from typing import Any, Dict, List, Optional, Tuple, TypeVar

from telex_control.common.file_catalog import package_yaml
from telex_control.common.params import (
    ConfigError,
    Declared,
    choice,
    number,
    parameter,
    read_config,
    require,
    required,
    word,
)

from ..scene.visual_scene import VisualLamp
from .drawing.quality import AUTO, TIERS
from .optics.exposure import ExposureConfig
from .optics.lens import NO_DISTORTION, Distortion, DistortionError, LensCamera, drawn_size
from .optics.noise import RadiationConfig
from .optics.pinhole import PinholeCamera

# What draws; with or without a graphics card.
OPENGL = "opengl"

# Name of the instructor's camera, and how it may go about.
OVERVIEW = "overview"
FOLLOW, ORBIT, FIXED = VIEW_MODES = ("follow", "orbit", "fixed")

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*\Z")
_MIN_SIZE, _MAX_SIZE = 16, 4096
# What is drawn of a picture, which a lens and detail make larger, along each side, and of all the
# moments that a shutter is open for: what any driver takes, and 1 GiB (pixels).
_MAX_DRAWN, _MAX_EXPOSED = 8192, 2**28
LEAST_DETAIL = 0.1
_MAX_FOV = 3.0
_MAX_RATE = 240.0
_MAX_ZOOM = 100.0
_FAR_AWAY = 1e4

Optics = TypeVar("Optics", bound="OpticsConfig")


@dataclass(frozen=True)
class PreviewConfig(Declared):
    """The small pictures of a camera that stands beside the one the operator looks at.

    Raises
    ------
    telex_control.common.params.ConfigError
    """

    width: int = number(
        320,
        "Pixels, if the camera's own pictures are not smaller; the height follows.",
        _MIN_SIZE,
        _MAX_SIZE,
    )
    rate: float = number(
        10.0, "Pictures per second of wall time while somebody looks.", maximum=_MAX_RATE, above=0.0
    )
    jpeg_quality: int = number(75, "1 to 100.", 1, 100)


@dataclass(frozen=True)
class OpticsConfig(Declared):
    """Lens, sensor and pictures of a camera.

    Raises
    ------
    telex_control.common.params.ConfigError
    """

    width: int = number(required, "Of the picture (pixels).", _MIN_SIZE, _MAX_SIZE)
    height: int = number(required, "Of the picture (pixels).", _MIN_SIZE, _MAX_SIZE)
    horizontal_fov: float = number(
        required, "Full angle of view across the width (rad), with the distortion.", 0.05, _MAX_FOV
    )
    near: float = number(0.03, "Distance from which on things are drawn (m).", 0.001)
    far: float = parameter(60.0, "Distance up to which things are drawn (m).")
    distortion: Distortion = parameter(
        NO_DISTORTION, 'k1, k2, p1, p2, k3 of the lens, as in sensor_msgs/CameraInfo ("plumb_bob").'
    )
    vignetting: float = number(
        0.0, "Share of the light that the corners of the picture lack.", 0.0, 0.9
    )
    detail: float = number(
        1.0,
        "Pixels that are drawn for one of the picture, along each axis; fewer take less time.",
        LEAST_DETAIL,
        4.0,
    )
    rate: float = number(
        25.0, "Pictures per second of wall time while somebody looks.", maximum=_MAX_RATE, above=0.0
    )
    priority: int = number(
        0,
        "When there is not enough time for all, pictures of full size are shared out by"
        " rate times (1 + priority).",
        0,
        100,
    )
    jpeg_quality: int = number(80, "1 to 100.", 1, 100)
    exposure: ExposureConfig = parameter(ExposureConfig, "By hand or automatic.")
    noise: float = number(
        0.0,
        "Of the sensor: standard deviation at the exposure of a bright day (grey levels of 255).",
        0.0,
        64.0,
    )
    radiation: RadiationConfig = parameter(RadiationConfig, "What it does to the pictures.")
    shutter: float = number(
        0.0,
        "Time for which a picture is exposed, in which motion blurs it (s of sim time); 0: none.",
        0.0,
        1.0,
    )
    shutter_samples: int = number(
        4, "Moments of that time that are drawn; a blurred picture takes as much more time.", 2, 64
    )
    depth: bool = parameter(False, "Whether depths are offered as well.")
    preview: PreviewConfig = parameter(PreviewConfig, "Small pictures of the same field.")
    zoom_max: float = number(
        1.0,
        "Largest zoom, a factor on the focal length; 1: the camera cannot zoom.",
        1.0,
        _MAX_ZOOM,
    )

    def check(self) -> None:
        """Check what concerns several of them; see `Declared.check`."""
        require(
            self.far > self.near, f"far is {self.far}; it must be beyond near, which is {self.near}"
        )
        try:
            width, height = self._drawn()
        except DistortionError as error:
            raise ConfigError(str(error)) from None
        drawn = (
            f"with width {self.width} and height {self.height}, {width}x{height} pixels are drawn"
        )
        require(
            max(width, height) <= _MAX_DRAWN,
            f"detail is {self.detail}; {drawn}, and at most {_MAX_DRAWN} along a side are possible",
        )
        samples = _MAX_EXPOSED // (width * height)
        require(
            self.shutter == 0.0 or self.shutter_samples <= samples,
            f"shutter_samples is {self.shutter_samples}; {drawn} at detail {self.detail}, and at "
            f"most {samples} samples of them are possible",
        )
        # No picture has fewer rows than the least size, so that a narrow one may see further up.
        if self.preview.width < self.width:
            try:
                self.small()
            except ConfigError as error:
                raise ConfigError(f"preview/width is {self.preview.width}: {error}") from None

    def optics(self, zoom: float = 1.0) -> LensCamera:
        """Return how the camera maps what it sees, zoomed in by a factor."""
        wide = LensCamera.of_field(
            self.width, self.height, self.horizontal_fov, self.distortion, self.near, self.far
        )
        return replace(wide, focal_length=zoom * wide.focal_length)

    def _drawn(self) -> Tuple[int, int]:
        """Largest width and height of what is drawn of a picture (pixels).

        Of a lens that draws a smaller one, zoom sees the middle alone, which it hardly bends.
        """
        plain = round(self.detail * self.width), round(self.detail * self.height)
        width, height = map(max, plain, drawn_size(self.optics(), self.detail))
        return width, height

    def _growth(self) -> float:
        """Factor of width and height up to which larger pictures can be drawn, rounded too."""
        width, height = self._drawn()
        exposed = width * height * (self.shutter_samples if self.shutter else 1)
        return 0.99 * min(_MAX_DRAWN / max(width, height), math.sqrt(_MAX_EXPOSED / exposed))

    def small(self: Optics) -> Optics:
        """Return the same camera as its previews show it."""
        reduced = self.reduced(min(self.preview.width, self.width))
        return replace(reduced, rate=self.preview.rate, jpeg_quality=self.preview.jpeg_quality)

    def reduced(self: Optics, width: int) -> Optics:
        """Return the same camera with smaller pictures, or larger ones, so many pixels wide.

        Neither side becomes longer than a picture's may be, or than what can be drawn. Reducing a
        picture takes the mean of pixels, and noise from it in proportion.
        """
        width = min(width, _MAX_SIZE * self.width // max(self.width, self.height))
        if width > self.width:
            width = max(self.width, min(width, int(self._growth() * self.width)))
        scale = width / self.width
        height = max(round(scale * self.height), _MIN_SIZE)
        return replace(self, width=width, height=height, noise=min(scale, 1.0) * self.noise)

    def pinhole(self, zoom: float = 1.0) -> PinholeCamera:
        """Return a camera without distortion that has the same field of view."""
        fov = 2.0 * math.atan(math.tan(0.5 * self.horizontal_fov) / zoom)
        return PinholeCamera(self.width, self.height, fov, self.near, self.far)


ROLES = ("ahead", "back", "whole", "look", "arm", "tool")
"""Roles of cameras: what they show. Where the robot drives, what is behind it, the robot itself
from some way off, whatever its head turns to, what is before the arm, what the tool does."""


@dataclass(frozen=True)
class CameraConfig(OpticsConfig):
    """A camera of the robot.

    Attributes
    ----------
    frame
        Its optical frame, a link of the model: z forward, x right, y down.

    Raises
    ------
    telex_control.common.params.ConfigError
    """

    frame: str = field(default_factory=required)
    role: str = choice("", ("", *ROLES), "What it is for, by which the console arranges its views.")

    def check(self) -> None:
        """Check what concerns several of them; see `Declared.check`."""
        _require_link(self.frame)
        super().check()


@dataclass(frozen=True)
class ViewConfig(Declared):
    """Where the instructor's camera is: on a sphere about a point at which it looks."""

    mode: str = choice(
        FOLLOW,
        VIEW_MODES,
        '"follow": about the robot, turning with it. "orbit": about the robot, turning with '
        'nothing. "fixed": about a point of the world.',
    )
    azimuth: float = number(
        2.6,
        'Of the camera as seen from the point (rad): from the robot\'s x axis to "follow", '
        "otherwise from the world's, counter-clockwise; pi is behind the robot.",
        -100.0,
        100.0,
    )
    # Straight from above, nothing would say where the top of the picture is.
    elevation: float = number(0.45, "Above the horizontal (rad).", -1.55, 1.55)
    distance: float = number(3.0, "From the point (m).", 0.1, 1000.0)
    turn_rate: float = number(
        0.0, "By which the azimuth goes on by itself (rad/s of wall time).", -10.0, 10.0
    )
    center: Tuple[float, float, float] = parameter(
        (0.0, 0.0, 0.3),
        'The point (m): in the world for "fixed"; otherwise from the link that is followed, '
        "along the robot's heading, to its left and upwards for \"follow\", along the world's "
        'axes for "orbit".',
    )

    def check(self) -> None:
        """Check what concerns single ones in a way of its own; see `Declared.check`."""
        require(
            all(abs(number) <= _FAR_AWAY for number in self.center),
            f"center is {list(self.center)}; finite numbers up to {_FAR_AWAY:g} m are needed",
        )


@dataclass(frozen=True)
class OverviewConfig(OpticsConfig):
    """The instructor's camera, which flies about the robot.

    Raises
    ------
    telex_control.common.params.ConfigError
    """

    follow: str = parameter("base_link", "Link of the model that it looks at.")
    start: ViewConfig = parameter(ViewConfig, "Where it is at first.")
    smoothing: float = number(
        0.25,
        "Time constant with which it follows, and goes where it is sent (s of wall "
        "time, because it can be moved while the simulation is paused).",
        0.0,
        60.0,
    )

    def check(self) -> None:
        """Check what concerns several of them; see `Declared.check`."""
        _require_link(self.follow)
        super().check()


@dataclass(frozen=True)
class LampConfig(Declared):
    """A lamp of the robot; it can be dimmed while the node runs.

    Raises
    ------
    telex_control.common.params.ConfigError
    """

    frame: str = parameter(
        required, "Link of the model; the lamp is at its origin and shines along its x."
    )
    angle: float = number(
        1.2, "Full angle of the cone (rad).", maximum=2.0 * math.pi + 0.01, above=0.0
    )
    intensity: float = number(
        4.0,
        "At full level; 1: a surface 1 m away that faces it is lit like by a bright day's sun.",
        0.0,
        1.0e4,
    )
    reach: float = number(
        10.0, "Distance at which its light has faded to nothing (m).", maximum=1.0e4, above=0.0
    )
    color: Tuple[float, float, float] = parameter(
        (1.0, 0.97, 0.92), "Red, green, blue, each 0 to 1, sRGB."
    )
    level: float = number(0.0, "With which it starts: 0 is off, 1 full.", 0.0, 1.0)
    beam: bool = parameter(
        False, "Whether it is a laser: in place of a cone, it makes a dot on what it meets."
    )

    def check(self) -> None:
        """Check what concerns several of them; see `Declared.check`."""
        _require_link(self.frame)
        require(
            all(0.0 <= component <= 1.0 for component in self.color),
            f"color is {list(self.color)}; numbers from 0 to 1 are needed",
        )

    def lamp(self, name: str, model: str) -> VisualLamp:
        """Return the lamp as a part of a scene in which the robot is called ``model``."""
        return VisualLamp(
            frame=f"{model}/{self.frame}",
            position=(0.0, 0.0, 0.0),
            direction=(1.0, 0.0, 0.0),
            angle=self.angle,
            intensity=self.intensity,
            reach=self.reach,
            color=self.color,
            name=name,
            beam=self.beam,
        )


def _require_link(frame: str) -> None:
    require(
        bool(frame) and not frame.startswith("/"),
        f"frame is '{frame}'; the name of a link is needed",
    )


@dataclass(frozen=True)
class CamerasConfig(Declared):
    """All parameters of the node.

    Raises
    ------
    telex_control.common.params.ConfigError
    """

    cameras: Dict[str, CameraConfig] = parameter(required, "By name; topics and messages use it.")
    lamps: Dict[str, LampConfig] = parameter(dict, "Of the robot, by name.")
    overview: Optional[OverviewConfig] = parameter(
        None, "The instructor's camera; None: there is none."
    )
    model: str = word("telex", 'Name of the robot in the scene; its frames are "<model>/<link>".')
    robots: Tuple[str, ...] = parameter(
        (),
        "Namespaces of further robots in the scene, after which they are called there; `cameras` "
        "in each has parameters like these for its cameras, lamps and overview.",
    )
    renderer: str = choice(AUTO, (AUTO, OPENGL), '"opengl", or "auto", which is the same.')
    quality: str = choice(
        AUTO, (AUTO, *TIERS), 'Tier of quality, or "auto" to choose it by what renders.'
    )
    shadow_radius: float = number(
        9.0, "Distance from the robot up to which the sun casts shadows (m).", above=0.0
    )
    repeat_rate: float = number(
        5.0, "Pictures per second while the simulation is paused.", above=0.0
    )
    max_pose_age: float = number(
        0.004,
        "How old poses may be that a picture is drawn of while newer ones wait (s): "
        "cameras that share poses share what these cost.",
        0.0,
        1.0,
    )
    shadow_period: float = number(
        0.05,
        "Time between the shadows of moving things (s), as far as newer ones are "
        "needed: when pictures follow each other closely, several share them. Longer "
        "while pictures give way to load.",
        0.0,
        1.0,
    )
    smallest: float = number(
        1.0,
        "While somebody watches previews and they fall behind for want of time, these "
        "lose detail, and then pictures of full size become smaller, at most by this "
        "factor of width and height; 1: all stay as they are.",
        maximum=1.0,
        above=0.0,
    )
    largest: float = number(
        1.0,
        "With a graphics card, or enough processors, pictures of full size become larger while "
        "there is time to spare, at most by this factor of width and height; 1: never.",
        1.0,
        4.0,
    )
    seed: int = number(0, "Of all noise.", 0, 2**31 - 1)
    niceness: Optional[int] = number(
        None,
        "By how much the process steps back for others, above all for the physics, -20 to"
        " 19; below 0 it comes before them, where its user may have that. Left out, it is -5, or"
        " 10 where the simulator does not come before ordinary processes.",
        -20,
        19,
    )
    software_threads: int = number(
        0,
        "Further threads for rendering without a graphics card. More give each picture "
        "sooner and take the cores from the physics; with 0 the node never uses more "
        "than one.",
        0,
        16,
    )
    egl_device: int = number(0, "Which graphics card, as EGL numbers them.", 0)

    def scene_lamps(self, prefix: str = "") -> List[VisualLamp]:
        """Return the lamps as parts of a scene, with something before their names."""
        return [lamp.lamp(f"{prefix}{name}", self.model) for name, lamp in self.lamps.items()]

    def seed_of(self, camera: str) -> int:
        """Seed of a camera's noise and dirt: by its name, so that it is the same beside others.

        Parameters
        ----------
        camera
            Of a further robot, with its namespace before it.
        """
        return self.seed + zlib.crc32(camera.encode())

    def check(self) -> None:
        """Check what concerns several of them; see `Declared.check`."""
        require(bool(self.cameras), "cameras is empty; at least one camera is needed")
        for group, names in (("cameras", self.cameras), ("lamps", self.lamps)):
            for name in names:
                require(
                    bool(_NAME.match(name)),
                    f"{group} has the key '{name}'; letters, digits and _ make a name",
                )
        require(
            OVERVIEW not in self.cameras,
            f"cameras has the key '{OVERVIEW}', which is the instructor's camera",
        )
        for robot in self.robots:
            require(
                bool(_NAME.match(robot)) and self.robots.count(robot) == 1 and robot != self.model,
                f"robots has '{robot}'; names of namespaces are needed, each once, and not the "
                f"first robot's",
            )


def shipped_params() -> Dict[str, Any]:
    """Read the shipped parameters of cameras and lamps."""
    return {
        **package_yaml("telex_description", "config", "cameras.yaml"),
        **package_yaml("telex_description", "config", "lamps.yaml"),
    }


def shipped_cameras() -> CamerasConfig:
    """Read the shipped configuration of the cameras and lamps."""
    return read_config(CamerasConfig, shipped_params(), "cameras")
