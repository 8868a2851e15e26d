"""The scene as the renderer knows it: frames, what is fixed to them, and the light."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass, field, replace
from typing import Sequence, Tuple, Union

from telex_control.common.geometry.quaternions import Quaternion

Vector3 = Tuple[float, float, float]
Color = Tuple[float, float, float, float]
Rgb = Tuple[float, float, float]


class VisualShape(enum.IntEnum):
    """Kinds of visuals; the numbers are those of telex_msgs/SceneVisual."""

    BOX = 1
    SPHERE = 2
    CYLINDER = 3
    MESH = 4
    PLANE = 5


WORLD = "world"
"""Name of the frame that never moves."""

LEAST_VISIBILITY = 0.01
"""No fog is so thick that its visibility is less (m); far less would overflow in the shaders."""

# From this height on (m), what is thinner than this share of it throws no shadow: of the sun's
# disc, which is 0.009 rad wide, it hides only a part.
_HIGH, _THIN_SHARE = 4.0, 0.05

# The components of the size that a shape reads and that must therefore be lengths above zero.
_LENGTHS = {
    VisualShape.BOX: (0, 1, 2),
    VisualShape.SPHERE: (0,),
    VisualShape.CYLINDER: (0, 2),
    VisualShape.MESH: (),
    VisualShape.PLANE: (0, 1),
}


@dataclass(frozen=True)
class Visual:
    """One visible shape, fixed to a frame.

    Attributes
    ----------
    frame
        Name of the frame: "<model>/<link>" in a scene, the link's name in a model.
    shape, size
        What ``size`` means depends on the shape, as in telex_msgs/SceneVisual (m; a factor for
        meshes).
    position, orientation
        Of the shape in its frame: x y z (m), quaternion x y z w.
    color
        Red, green, blue, alpha, each 0..1, as in sRGB.
    mesh
        Address of the mesh, for ``Shape.MESH``.
    texture
        Empty, "generated:NAME", or the address of an image; it is multiplied by the colour.
    texture_scale
        Length that one repetition of the texture covers (m); 0: once over each face.
    glow
        0..1: share of the colour that is seen without any light.
    drive
        Frame of the wheel that drives this mesh as a belt, by turning about its y; empty for what
        does not run.
    mesh_materials
        Whether parts of the mesh that have a colour or texture of their own show it.
    part
        Which of those parts this is; -1: the whole mesh.

    Raises
    ------
    ValueError
        When a value is not finite or out of its range.
    """

    frame: str
    shape: VisualShape
    size: Vector3
    position: Vector3 = (0.0, 0.0, 0.0)
    orientation: Quaternion = (0.0, 0.0, 0.0, 1.0)
    color: Color = (0.7, 0.7, 0.7, 1.0)
    mesh: str = ""
    texture: str = ""
    texture_scale: float = 1.0
    glow: float = 0.0
    drive: str = ""
    mesh_materials: bool = False
    part: int = -1

    def __post_init__(self) -> None:
        pose_numbers = (*self.size, *self.position, *self.orientation)
        numbers = (*pose_numbers, *self.color, self.texture_scale, self.glow)
        if not all(math.isfinite(number) for number in numbers):
            raise ValueError(f"{self.label}: a number is not finite: {numbers}")
        if any(self.size[axis] <= 0.0 for axis in _LENGTHS[self.shape]):
            raise ValueError(f"{self.label}: size {self.size} must be above zero")
        if self.shape is VisualShape.MESH:
            if not self.mesh:
                raise ValueError(f"{self.label}: a mesh needs an address")
            if 0.0 in self.size:
                raise ValueError(f"{self.label}: scale {self.size} must not be zero")
        if sum(component * component for component in self.orientation) < 1e-12:
            raise ValueError(f"{self.label}: the quaternion is zero")
        if not all(0.0 <= component <= 1.0 for component in self.color):
            raise ValueError(f"{self.label}: colour {self.color} must lie within 0..1")
        if self.texture_scale < 0.0:
            raise ValueError(f"{self.label}: texture_scale is {self.texture_scale}, below zero")
        if not 0.0 <= self.glow <= 1.0:
            raise ValueError(f"{self.label}: glow is {self.glow}; it must lie within 0..1")

    @property
    def label(self) -> str:
        """What messages call this visual."""
        return f"{self.shape.name.lower()} {self.mesh or ''}".strip() + f" of frame '{self.frame}'"

    @property
    def casts_shadow(self) -> bool:
        """Whether it belongs in the shadow map.

        A plane is ground or wall, with nothing behind; of what is thin and hangs high in a hall,
        the sun's disc leaves no shadow that could be seen.
        """
        if self.shape is VisualShape.PLANE or self.color[3] < 0.5:
            return False
        height = self.position[2] if self.frame == WORLD else 0.0
        return height < _HIGH or self._thickness > _THIN_SHARE * height

    @property
    def _thickness(self) -> float:
        """The second of its three extents, by size (m); of a mesh, nobody knows it here."""
        if self.shape is VisualShape.BOX:
            return sorted(self.size)[1]
        if self.shape is VisualShape.CYLINDER:
            return 2.0 * self.size[0]
        return math.inf


@dataclass(frozen=True)
class VisualLamp:
    """A lamp, fixed to a frame.

    Attributes
    ----------
    frame
        Name of the frame.
    position, direction
        Where it is and where its cone points, in the frame (m; any length but zero).
    angle
        Full angle of the cone (rad); 2 pi shines all around.
    intensity
        1: a surface 1 m away that faces it gets what the sun of intensity 1 gives.
    reach
        Distance at which its light has faded to nothing (m).
    color
        sRGB, each 0..1.
    name
        Of one that can be dimmed while the scene stands; empty for others.
    casts_shadow
        Whether things stand in its light; one that shines all around casts shadows ahead only.
    beam
        Whether it is a laser: in place of a cone, it makes a dot on what it meets.

    Raises
    ------
    ValueError
        When a value is not finite or out of its range.
    """

    frame: str
    position: Vector3
    direction: Vector3 = (0.0, 0.0, -1.0)
    angle: float = 2.0 * math.pi
    intensity: float = 1.0
    reach: float = 8.0
    color: Rgb = (1.0, 1.0, 1.0)
    name: str = ""
    casts_shadow: bool = True
    beam: bool = False

    def __post_init__(self) -> None:
        place_numbers = (*self.position, *self.direction, self.reach)
        numbers = (*place_numbers, *self.color, self.angle, self.intensity)
        if not all(math.isfinite(number) for number in numbers):
            raise ValueError(f"{self.label}: a number is not finite: {numbers}")
        if math.hypot(*self.direction) < 1e-9:
            raise ValueError(f"{self.label}: the direction is zero")
        if self.angle <= 0.0 or self.reach <= 0.0:
            raise ValueError(
                f"{self.label}: angle is {self.angle} and reach is {self.reach}; both must be"
                " above zero"
            )
        if self.intensity < 0.0:
            raise ValueError(f"{self.label}: intensity is {self.intensity}, below zero")
        if not all(0.0 <= component <= 1.0 for component in self.color):
            raise ValueError(f"{self.label}: colour {self.color} must lie within 0..1")

    @property
    def label(self) -> str:
        """What messages call this lamp."""
        return f"lamp {self.name}".strip() + f" of frame '{self.frame}'"


@dataclass(frozen=True)
class Daylight:
    """The light that comes from no lamp, and the air that it shines through.

    Attributes
    ----------
    to_sun
        Direction to the sun; any length but zero, if it shines.
    sun
        Its light, linear: colour times intensity; 1 is a bright day.
    ambient
        Light from everywhere: 1 by day, 0 in the dark.
    visibility
        Distance at which 5 % of the contrast is left (m), at least `LEAST_VISIBILITY`; 0: clear
        air.
    fog
        Colour of the fog by day, sRGB.

    Raises
    ------
    ValueError
        When a value is not finite or out of its range.
    """

    to_sun: Vector3 = (-0.40, -0.50, 0.80)
    sun: Rgb = (1.0, 0.96, 0.9)
    ambient: float = 1.0
    visibility: float = 0.0
    fog: Rgb = (0.6, 0.62, 0.65)

    def __post_init__(self) -> None:
        numbers = (*self.to_sun, *self.sun, self.ambient, self.visibility, *self.fog)
        if not all(math.isfinite(number) for number in numbers):
            raise ValueError(f"the light: a number is not finite: {numbers}")
        if any(self.sun) and math.hypot(*self.to_sun) < 1e-9:
            raise ValueError("the light: the direction to the sun is zero")
        if min(*self.sun, *self.fog, self.ambient, self.visibility) < 0.0:
            raise ValueError(f"the light: a number is below zero: {numbers[3:]}")
        # Messages round to single precision.
        if 0.0 < self.visibility < LEAST_VISIBILITY * (1.0 - 1e-6):
            raise ValueError(
                f"the light: the visibility is {self.visibility:g} m; 0, for clear air, or at least"
                f" {LEAST_VISIBILITY:g} m is needed"
            )


@dataclass(frozen=True)
class VisualScene:
    """What there is to see, and by which light.

    Raises
    ------
    ValueError
        When a frame is named twice, or that of a visual or lamp is unknown.
    """

    revision: int
    frames: Tuple[str, ...]
    visuals: Tuple[Visual, ...]
    lamps: Tuple[VisualLamp, ...] = ()
    daylight: Daylight = field(default_factory=Daylight)

    def with_lamps(self, lamps: Sequence[VisualLamp]) -> VisualScene:
        """Return it with those of further lamps whose frames it has."""
        return replace(self, lamps=(*self.lamps, *(x for x in lamps if x.frame in self.frames)))

    def __post_init__(self) -> None:
        known = set(self.frames)
        if len(known) != len(self.frames):
            raise ValueError("a frame is named twice in the scene")
        things: Tuple[Union[Visual, VisualLamp], ...] = (*self.visuals, *self.lamps)
        for thing in things:
            if thing.frame not in known:
                raise ValueError(f"{thing.label}: no such frame in the scene")
        for visual in self.visuals:
            if visual.drive and visual.drive not in known:
                raise ValueError(f"{visual.label}: no frame '{visual.drive}' in the scene")
