"""Model of a scene.

Scene files and the library of objects produce these values; the physics
(`telex_sim.scene.objects.bodies`) and the renderer's messages (`telex_sim.ros.scene_messages`) read
them. Everything here is plain data, checked where it is made: a scene that exists can be loaded.

Units are SI; orientations are quaternions x y z w; colours are sRGB, 0 to 1.
"""

from __future__ import annotations

import enum
import math
import re
from dataclasses import dataclass, field
from typing import Dict, Optional, Sequence, Tuple

from telex_control.common.geometry.quaternions import ORIGIN, UPRIGHT, Quaternion, Vector3
from telex_control.common.params import (
    Declared,
    checked,
    choice,
    number,
    parameter,
    require,
    require_choice,
    require_range,
    required,
)

from ..radiation.dosimetry import require_history
from ..radiation.nuclides import MATERIALS, NUCLIDES
from .visual_scene import LEAST_VISIBILITY

Color = Tuple[float, float, float, float]

WHITE: Color = (1.0, 1.0, 1.0, 1.0)

WORLD_FRAME = "world"
"""Name of the fixed frame."""
LARGEST = 1.0e4
"""No length of a scene is greater (m)."""
SMALLEST = 1.0e-4
"""No length of a shape is smaller (m), for there is no mass in it; nor a mesh's scale."""
MOST_ACTIVE = 1.0e17
"""No source has a greater activity (Bq): that of the largest irradiators."""
STRONGEST = 1.0e6
"""No effort of a joint is greater (N m or N)."""
MOST_OBJECTS = 1000
"""No scene has more, whether from its file or spawned."""
MOST_LINKS = 64
"""No object has more."""
_LIGHTEST = 1.0e-4
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]{0,63}")


def require_name(value: str, what: str) -> None:
    """Raise a `ConfigError` unless `value` can be a name: part of a frame's, and of a service's."""
    require(
        _NAME.fullmatch(value) is not None,
        f"{what} is '{value}'; a letter, then letters, digits, _ and - (64 at most) are needed",
    )


def _require_vector(config: object, name: str) -> None:
    value: Sequence[float] = getattr(config, name)
    require(
        all(math.isfinite(number) and abs(number) <= LARGEST for number in value),
        f"{name} is {list(value)}; finite numbers, of at most {LARGEST:g}, are needed",
    )


def _require_unit(config: object, name: str) -> None:
    """Check a direction or a quaternion."""
    value: Sequence[float] = getattr(config, name)
    length = math.sqrt(sum(number * number for number in value))
    require(
        math.isfinite(length) and abs(length - 1.0) < 1e-6,
        f"{name} is {list(value)}, of length {length:g}; it must have length 1",
    )


def _require_shares(config: object, name: str) -> None:
    value: Sequence[float] = getattr(config, name)
    require(
        all(0.0 <= number <= 1.0 for number in value),
        f"{name} is {list(value)}; numbers from 0 to 1 are needed",
    )


class Form(enum.Enum):
    """Kinds of geometry."""

    BOX = "box"
    SPHERE = "sphere"
    CYLINDER = "cylinder"
    MESH = "mesh"


@dataclass(frozen=True)
class Geometry:
    """A shape about its own origin.

    Attributes
    ----------
    size : tuple of 3 floats
        BOX: full extents along x, y, z (m). SPHERE: (radius, 0, 0). CYLINDER, about z:
        (radius, 0, length). MESH: scale along x, y, z.
    mesh : str
        MESH: ``package://`` or ``file://`` address.
    """

    form: Form
    size: Vector3
    mesh: str = ""

    def __post_init__(self) -> None:
        _require_vector(self, "size")
        used = {Form.SPHERE: (0,), Form.CYLINDER: (0, 2)}.get(self.form, (0, 1, 2))
        possible = all(
            (abs(self.size[index]) if self.form is Form.MESH else self.size[index]) >= SMALLEST
            and abs(self.size[index]) <= LARGEST
            for index in used
        )
        require(
            possible,
            f"size is {list(self.size)}; every length of a {self.form.value} must be above 0, "
            f"{SMALLEST:g} at least and {LARGEST:g} at most"
            + (", or below to mirror it" if self.form is Form.MESH else ""),
        )
        require(
            bool(self.mesh) == (self.form is Form.MESH),
            f"mesh is '{self.mesh}'; a mesh needs an address, and nothing else may have one",
        )


@dataclass(frozen=True)
class Surface:
    """How a part looks.

    Attributes
    ----------
    color : tuple of 4 floats
        Multiplies the texture.
    texture : str
        Empty, ``generated:NAME`` with a name of `telex_sim.scene.textures.procedural`
        (parameters as in a query: ``generated:chart?kind=E&seed=3``), or the address of an image.
    texture_scale : float
        Length that one repetition of the texture covers (m). 0 stretches it once over each face,
        which is what signs and charts need.
    glow : float
        0 to 1: share of the colour that is seen without any light (lamps, screens).
    """

    color: Color = (0.7, 0.7, 0.7, 1.0)
    texture: str = ""
    texture_scale: float = 1.0
    glow: float = 0.0

    def __post_init__(self) -> None:
        _require_shares(self, "color")
        require_range(self, "texture_scale", 0.0, LARGEST)
        require_range(self, "glow", 0.0, 1.0)

    @property
    def material(self) -> str:
        """What it looks to be made of: name of its generated texture; empty without one."""
        kind, _, name = self.texture.partition(":")
        return name.partition("?")[0] if kind == "generated" else ""


@dataclass(frozen=True)
class Part:
    """One shape of a link: seen, touched, or both.

    Attributes
    ----------
    surface : Surface, optional
        None: invisible.
    solid : bool
        Whether it collides. A mesh collides as its convex hull on a moving link, exactly on a
        static one.
    shield : str
        Of what it is made that attenuates radiation, one of `telex_sim.radiation.nuclides`'
        materials, throughout its volume; empty: radiation passes. No mesh attenuates.
    """

    geometry: Geometry
    position: Vector3 = ORIGIN
    orientation: Quaternion = UPRIGHT
    surface: Optional[Surface] = field(default_factory=Surface)
    solid: bool = True
    shield: str = ""

    def __post_init__(self) -> None:
        _require_vector(self, "position")
        _require_unit(self, "orientation")
        if self.shield:
            require_choice(self, "shield", tuple(MATERIALS))
            require(
                self.geometry.form is not Form.MESH,
                f"shield is '{self.shield}'; a box, cylinder or sphere can shield, a mesh cannot",
            )


@dataclass(frozen=True)
class Source(Declared):
    """A point that emits gamma radiation."""

    nuclide: str = choice(required, NUCLIDES, "One of `telex_sim.radiation.nuclides`.")
    activity: float = number(required, "Bq.", maximum=MOST_ACTIVE, above=0.0)
    position: Vector3 = checked(ORIGIN, "In its link (m).", _require_vector)


@dataclass(frozen=True)
class Leak(Declared):
    """A point at which gas comes out."""

    flow: float = number(required, "m3/s.", maximum=LARGEST, above=0.0)
    position: Vector3 = checked(ORIGIN, "In its link (m).", _require_vector)
    drift: Vector3 = checked(
        ORIGIN, "Velocity of the air around it, along the axes of its link (m/s).", _require_vector
    )


@dataclass(frozen=True)
class Link:
    """A rigid body of an object.

    Attributes
    ----------
    mass : float
        kg; spread evenly over the solid parts. 0 only on the root of a static object.
    friction : float
        Coefficient; that of a contact is the product of both bodies' (the floor's is 1 unless
        the scene says otherwise, the gripper's pads have 0.8).
    rolling_friction : float
        m; keeps round things from rolling, and from spinning, for ever.
    source : Source, optional
        That it carries.
    leak : Leak, optional
        That it has.
    """

    name: str
    mass: float
    parts: Tuple[Part, ...]
    friction: float = 1.0
    rolling_friction: float = 0.0
    source: Optional[Source] = None
    leak: Optional[Leak] = None

    def __post_init__(self) -> None:
        require_name(self.name, "name of a link")
        require_range(self, "mass", 0.0, 1.0e6)
        require_range(self, "friction", 0.0, 10.0)
        require_range(self, "rolling_friction", 0.0, 1.0)


class Motion(enum.Enum):
    """Kinds of joints inside an object."""

    HINGE = "hinge"
    SLIDE = "slide"
    LATCH = "latch"


@dataclass(frozen=True)
class Closer(Declared):
    """A spring that returns a joint, as a door closer does.

    The effort towards `rest` is ``preload + stiffness * |position - rest|`` (N m or N).
    """

    preload: float = number(required, "", 0.0, STRONGEST)
    stiffness: float = number(0.0, "", 0.0)
    rest: float = number(0.0, "", -LARGEST, LARGEST)


@dataclass(frozen=True)
class Detents(Declared):
    """Positions in which a joint rests."""

    positions: Tuple[float, ...] = parameter(required, "rad or m.")
    effort: float = number(
        required,
        "Largest effort (N m or N) that the notch resists; it acts within `width` of a position.",
        maximum=STRONGEST,
        above=0.0,
    )
    width: float = number(
        required,
        "rad or m, from the middle of a notch to its edge.",
        maximum=LARGEST,
        above=0.0,
    )

    def check(self) -> None:
        """Check what concerns several of them; see `Declared.check`."""
        require(bool(self.positions), "positions is []; a detent needs one at least")
        ordered = sorted(self.positions)
        require(
            all(math.isfinite(position) for position in ordered)
            and all(b - a >= 2.0 * self.width for a, b in zip(ordered, ordered[1:])),
            f"positions is {list(self.positions)}; they must lie 2 * width = "
            f"{2.0 * self.width:g} or more apart",
        )


@dataclass(frozen=True)
class Joint:
    """How one link of an object moves against another.

    Attributes
    ----------
    motion : Motion
        HINGE about `axis`, SLIDE along it. LATCH: `child` is a free body that is held in place
        until it is pulled with more than `hold` (N); back in place it is held again.
    position, orientation : tuple of float
        The child's frame in the parent's, with the joint at 0.
    axis : tuple of 3 floats
        Unit vector in the child's frame.
    lower, upper : float
        rad or m.
    start : float
        Where it begins (rad or m).
    friction : float
        Breakaway: effort below which it does not move, and which brakes it when it does (N m, N).
    damping : float
        N m s/rad or N s/m.
    hold : float
        LATCH: force that lets it go (N).
    across : float
        LATCH: what it bears across `axis`, and against it, in multiples of `hold`: a piece that is
        seated in a hole comes out along the hole only.
    capture : float
        LATCH: within this distance of its place (m), and within 0.1 rad of `axis`, a body that
        has come to rest there is held again.
    """

    name: str
    motion: Motion
    parent: str
    child: str
    position: Vector3 = ORIGIN
    orientation: Quaternion = UPRIGHT
    axis: Vector3 = (0.0, 0.0, 1.0)
    lower: float = 0.0
    upper: float = 0.0
    start: float = 0.0
    friction: float = 0.0
    damping: float = 0.0
    closer: Optional[Closer] = None
    detents: Optional[Detents] = None
    hold: float = 0.0
    across: float = 1.0
    capture: float = 0.004

    def __post_init__(self) -> None:
        require_name(self.name, "name of a joint")
        _require_vector(self, "position")
        _require_unit(self, "orientation")
        _require_unit(self, "axis")
        if self.motion is Motion.LATCH:
            require_range(self, "hold", maximum=STRONGEST, above=0.0)
            require_range(self, "across", 1.0, 50.0)
            require_range(self, "capture", maximum=LARGEST, above=0.0)
            return
        require_range(self, "lower", -LARGEST)
        require_range(self, "upper", maximum=LARGEST)
        require(
            self.lower < self.upper,
            f"lower is {self.lower} and upper is {self.upper}; lower must be less",
        )
        require_range(self, "start", self.lower, self.upper)
        require_range(self, "friction", 0.0, STRONGEST)
        require_range(self, "damping", 0.0, STRONGEST)
        for position in self.detents.positions if self.detents else ():
            require(
                self.lower <= position <= self.upper,
                f"detents/positions: {position} is not between lower and upper",
            )


@dataclass(frozen=True)
class ObjectModel:
    """An object about its own origin, which lies in the middle of its footprint, z = 0 under it.

    Attributes
    ----------
    links : tuple of Link
        The first is the root, whose frame is the object's.
    joints : tuple of Joint
        One for each further link.
    static : bool
        Whether the root stands fast.
    """

    links: Tuple[Link, ...]
    joints: Tuple[Joint, ...] = ()
    static: bool = False

    def __post_init__(self) -> None:
        require(
            1 <= len(self.links) <= MOST_LINKS,
            f"there are {len(self.links)} links; 1 to {MOST_LINKS} are possible",
        )
        links: Dict[str, Link] = {link.name: link for link in self.links}
        require(
            len(links) == len(self.links)
            and len({j.name for j in self.joints}) == len(self.joints),
            "two links, or two joints, have the same name",
        )
        parents = {joint.child: joint.parent for joint in self.joints}
        root = self.links[0].name
        require(
            len(parents) == len(self.joints) and set(parents) == set(links) - {root},
            f"joints must move every link but the root '{root}', each by one joint; "
            f"they move {', '.join(sorted(joint.child for joint in self.joints)) or 'none'}",
        )
        for child in parents:
            above, seen = child, {child}
            while above != root:
                above = parents[above]
                require(
                    above in links and above not in seen,
                    f"link '{child}' hangs on '{above}', which does not lead to the root '{root}'",
                )
                seen.add(above)
        for link in self.links:
            if self.static and link.name == root:
                continue
            require(
                link.mass >= _LIGHTEST,
                f"link '{link.name}': mass is {link.mass}; {_LIGHTEST} kg or more is needed",
            )
            require(
                any(part.solid for part in link.parts),
                f"link '{link.name}' can move, but has no solid part",
            )

    def moving_links(self) -> Tuple[Link, ...]:
        """The links that can move; those of a static object are all but the root."""
        return self.links[1:] if self.static else self.links


@dataclass(frozen=True)
class SceneObject:
    """An object in a scene: its name, what it is, and the pose of its root.

    Attributes
    ----------
    entry : str
        Name of the scene file's entry that it comes from; that of the object itself, unless the
        entry makes several.
    """

    name: str
    model: ObjectModel
    position: Vector3 = ORIGIN
    orientation: Quaternion = UPRIGHT
    entry: str = ""

    def __post_init__(self) -> None:
        _require_vector(self, "position")
        _require_unit(self, "orientation")


@dataclass(frozen=True)
class Floor(Declared):
    """The endless floor at z = 0; `size` is the edge of what is seen of it (m)."""

    surface: Surface = field(
        default_factory=lambda: Surface(
            (0.62, 0.63, 0.64, 1.0), "generated:concrete?slabs=3&worn=1", 6.0
        )
    )
    friction: float = number(1.0, "", 0.0, 10.0)
    size: float = number(160.0, "", maximum=LARGEST, above=0.0)


@dataclass(frozen=True)
class Sun(Declared):
    """Light from far away, with shadows."""

    azimuth: float = number(-2.2, "Where it stands (rad), from x towards y.", -100.0, 100.0)
    elevation: float = number(0.9, "Above the horizon (rad).", 0.0, math.pi / 2.0)
    intensity: float = number(1.0, "1 is a bright day, 0 none.", 0.0, 100.0)
    color: Tuple[float, float, float] = checked((1.0, 0.96, 0.9), "", _require_shares)


@dataclass(frozen=True)
class Lamp(Declared):
    """A lamp of the scene."""

    position: Vector3 = checked(required, "Where it is (m).", _require_vector)
    direction: Vector3 = checked(
        (0.0, 0.0, -1.0), "Where its cone points; any length but 0.", _require_vector
    )
    # A full circle written with few digits may be a little more than one.
    angle: float = number(
        6.283185307179586,
        "Full angle of the cone (rad); 2 pi shines all around.",
        maximum=2.0 * math.pi + 0.01,
        above=0.0,
    )
    intensity: float = number(
        1.0,
        "1 lights a surface 1 m away, facing it, like the sun of intensity 1.",
        0.0,
        1.0e4,
    )
    reach: float = number(
        8.0, "Distance at which its light has faded to nothing (m).", maximum=LARGEST, above=0.0
    )
    color: Tuple[float, float, float] = checked((1.0, 0.95, 0.85), "", _require_shares)

    def check(self) -> None:
        """Check what concerns single ones in a way of its own; see `Declared.check`."""
        require(
            any(abs(number) > 1e-9 for number in self.direction),
            f"direction is {list(self.direction)}; it must have a length",
        )


@dataclass(frozen=True)
class Fog(Declared):
    """Haze: at `visibility` metres, 5 % of the contrast is left. 0: clear."""

    visibility: float = number(0.0, "", 0.0, 1.0e6)
    color: Tuple[float, float, float] = checked((0.6, 0.62, 0.65), "", _require_shares)

    def check(self) -> None:
        """Check what concerns single ones in a way of its own; see `Declared.check`."""
        require(
            self.visibility == 0.0 or self.visibility >= LEAST_VISIBILITY,
            f"visibility is {self.visibility:g}; it must be 0, for clear air, or at least"
            f" {LEAST_VISIBILITY:g}",
        )


@dataclass(frozen=True)
class Lights(Declared):
    """All light of a scene; `ambient` is that from everywhere, 1 by day, 0 in the dark."""

    sun: Sun = field(default_factory=Sun)
    ambient: float = number(1.0, "", 0.0, 10.0)
    lamps: Tuple[Lamp, ...] = ()
    fog: Fog = field(default_factory=Fog)


MOST_FURTHER = 3
"""Robots beside the first one that a scene has starts for."""


@dataclass(frozen=True)
class Start(Declared):
    """Where the robot begins: x and y of base_link (m), height of the ground there (m), heading.

    `pose` is a named pose of the robot, or empty for the simulator's own.
    """

    x: float = number(0.0, "", -LARGEST, LARGEST)
    y: float = number(0.0, "", -LARGEST, LARGEST)
    ground: float = number(0.0, "", -LARGEST, LARGEST)
    yaw: float = number(0.0, "", -LARGEST, LARGEST)
    pose: str = ""


@dataclass(frozen=True)
class Viewpoint:
    """From where a picture of the scene is taken: eye and target (m), full width of view (rad)."""

    eye: Vector3
    target: Vector3
    fov: float = 0.9

    def __post_init__(self) -> None:
        _require_vector(self, "eye")
        _require_vector(self, "target")
        require(math.dist(self.eye, self.target) > 1e-6, "eye and target are the same point")
        require_range(self, "fov", 0.05, 2.9)


@dataclass(frozen=True)
class Scene:
    """A whole scene.

    Attributes
    ----------
    history : dict of str to float
        Doses that the robot's parts have received before it begins (Gy): of a camera by its name,
        and of the ``robot``.
    antenna : tuple of float, optional
        Place of the operator's radio antenna in the world (m); None: above the robot's start.
    robots : tuple of Start
        Where further robots begin, in their order; who has none here finds a place by itself.
    """

    name: str
    description: str = ""
    floor: Floor = field(default_factory=Floor)
    lights: Lights = field(default_factory=Lights)
    objects: Tuple[SceneObject, ...] = ()
    start: Start = field(default_factory=Start)
    views: Tuple[Viewpoint, ...] = ()
    history: Dict[str, float] = field(default_factory=dict)
    antenna: Optional[Vector3] = None
    robots: Tuple[Start, ...] = ()

    def __post_init__(self) -> None:
        require_history(self.history)
        require(
            len(self.robots) <= MOST_FURTHER,
            f"robots has {len(self.robots)} starts; at most {MOST_FURTHER}, of further robots, are "
            "possible",
        )
        if self.antenna is not None:
            _require_vector(self, "antenna")
