"""What a scene consists of.

Scene files and the library of objects produce these values; the physics (`telex_sim.scene.bodies`)
and the renderer's messages (`telex_sim.scene_messages`) read them. Everything here is plain data,
checked where it is made: a scene that exists can be loaded.

Units are SI; orientations are quaternions x y z w; colours are sRGB, 0 to 1.
"""

from __future__ import annotations

import enum
from dataclasses import dataclass, field
from typing import Optional, Tuple

Vector3 = Tuple[float, float, float]
Quaternion = Tuple[float, float, float, float]
Color = Tuple[float, float, float, float]

ORIGIN: Vector3 = (0.0, 0.0, 0.0)
UPRIGHT: Quaternion = (0.0, 0.0, 0.0, 1.0)
WHITE: Color = (1.0, 1.0, 1.0, 1.0)


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
    form : Form
    size : tuple of 3 floats
        BOX: full extents along x, y, z (m). SPHERE: (radius, 0, 0). CYLINDER, about z:
        (radius, 0, length). MESH: scale along x, y, z.
    mesh : str
        MESH: ``package://`` or ``file://`` address.
    """

    form: Form
    size: Vector3
    mesh: str = ""


@dataclass(frozen=True)
class Surface:
    """How a part looks.

    Attributes
    ----------
    color : tuple of 4 floats
        Multiplies the texture.
    texture : str
        Empty, ``generated:NAME`` with a name of `telex_sim.rendering.procedural_textures`
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
    """

    geometry: Geometry
    position: Vector3 = ORIGIN
    orientation: Quaternion = UPRIGHT
    surface: Optional[Surface] = field(default_factory=Surface)
    solid: bool = True


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
        m; keeps round things from rolling for ever.
    """

    name: str
    mass: float
    parts: Tuple[Part, ...]
    friction: float = 1.0
    rolling_friction: float = 0.0


class Motion(enum.Enum):
    """Kinds of joints inside an object."""

    HINGE = "hinge"
    SLIDE = "slide"
    LATCH = "latch"


@dataclass(frozen=True)
class Closer:
    """A spring that returns a joint, as a door closer does.

    The effort towards `rest` is ``preload + stiffness * |position - rest|`` (N m or N).
    """

    preload: float
    stiffness: float = 0.0
    rest: float = 0.0


@dataclass(frozen=True)
class Detents:
    """Positions in which a joint rests.

    Attributes
    ----------
    positions : tuple of float
        rad or m.
    effort : float
        Largest effort (N m or N) that the notch resists; it acts within `width` of a position.
    width : float
        rad or m, from the middle of a notch to its edge.
    """

    positions: Tuple[float, ...]
    effort: float
    width: float


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


@dataclass(frozen=True)
class SceneObject:
    """An object in a scene: its name, what it is, and the pose of its root."""

    name: str
    model: ObjectModel
    position: Vector3 = ORIGIN
    orientation: Quaternion = UPRIGHT


@dataclass(frozen=True)
class Floor:
    """The endless floor at z = 0; `size` is the edge of what is seen of it (m)."""

    surface: Surface = field(
        default_factory=lambda: Surface((0.62, 0.63, 0.64, 1.0), "generated:concrete", 4.0)
    )
    friction: float = 1.0
    size: float = 80.0


@dataclass(frozen=True)
class Sun:
    """Light from far away, with shadows.

    Attributes
    ----------
    azimuth, elevation : float
        Where it stands (rad): azimuth from x towards y, elevation above the horizon.
    intensity : float
        1 is a bright day, 0 none.
    """

    azimuth: float = -2.2
    elevation: float = 0.9
    intensity: float = 1.0
    color: Tuple[float, float, float] = (1.0, 0.96, 0.9)


@dataclass(frozen=True)
class Lamp:
    """A lamp of the scene.

    Attributes
    ----------
    position : tuple of 3 floats
    direction : tuple of 3 floats
        Where its cone points; any length but 0.
    angle : float
        Full angle of the cone (rad); 2 pi shines all around.
    intensity : float
        1 lights a surface 1 m away, facing it, like the sun of intensity 1.
    reach : float
        Distance at which its light has faded to nothing (m).
    """

    position: Vector3
    direction: Vector3 = (0.0, 0.0, -1.0)
    angle: float = 6.283185307179586
    intensity: float = 1.0
    reach: float = 8.0
    color: Tuple[float, float, float] = (1.0, 0.95, 0.85)


@dataclass(frozen=True)
class Fog:
    """Haze: at `visibility` metres, 5 % of the contrast is left. 0: clear."""

    visibility: float = 0.0
    color: Tuple[float, float, float] = (0.6, 0.62, 0.65)


@dataclass(frozen=True)
class Lights:
    """All light of a scene; `ambient` is that from everywhere, 1 by day, 0 in the dark."""

    sun: Sun = field(default_factory=Sun)
    ambient: float = 1.0
    lamps: Tuple[Lamp, ...] = ()
    fog: Fog = field(default_factory=Fog)


@dataclass(frozen=True)
class Start:
    """Where the robot begins: x and y of base_link (m), height of the ground there (m), heading.

    `pose` is a named pose of the robot, or empty for the simulator's own.
    """

    x: float = 0.0
    y: float = 0.0
    ground: float = 0.0
    yaw: float = 0.0
    pose: str = ""


@dataclass(frozen=True)
class View:
    """From where a picture of the scene is taken: eye and target (m), full width of view (rad)."""

    eye: Vector3
    target: Vector3
    fov: float = 0.9


@dataclass(frozen=True)
class Scene:
    """A whole scene."""

    name: str
    description: str = ""
    floor: Floor = field(default_factory=Floor)
    lights: Lights = field(default_factory=Lights)
    objects: Tuple[SceneObject, ...] = ()
    start: Start = field(default_factory=Start)
    views: Tuple[View, ...] = ()
