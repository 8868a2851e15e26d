"""Objects whose parts stand in the scene file itself."""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Optional, Tuple

from telex_control.common.geometry.quaternions import quaternion_from_rpy
from telex_control.common.params import ConfigError, parameter, require, required

from ..addresses import absolute
from ..model import (
    ORIGIN,
    Closer,
    Detents,
    Form,
    Geometry,
    Joint,
    Link,
    Motion,
    ObjectModel,
    Part,
    SceneObject,
    Source,
    Surface,
    Vector3,
)
from .object_type import ObjectType, single


@dataclass(frozen=True)
class CylinderSize:
    """Radius and length (m)."""

    radius: float
    length: float


@dataclass(frozen=True)
class CustomPart:
    """A shape: one of box, sphere, cylinder and mesh.

    Attributes
    ----------
    box : tuple of 3 floats, optional
        Full extents (m).
    sphere : float, optional
        Radius (m).
    cylinder : CylinderSize, optional
        Along z: {radius, length} (m).
    mesh : str
        Address of an OBJ or STL file.
    scale : tuple of 3 floats
        Of the mesh.
    position, rpy : tuple of 3 floats
        In the link (m, rad).
    surface : Surface
        {color, texture, texture_scale, glow}.
    solid, visible : bool
        Whether it is touched, whether it is seen.
    shield : str
        Material that attenuates radiation; empty: none.
    """

    box: Optional[Vector3] = None
    sphere: Optional[float] = None
    cylinder: Optional[CylinderSize] = None
    mesh: str = ""
    scale: Vector3 = (1.0, 1.0, 1.0)
    position: Vector3 = ORIGIN
    rpy: Vector3 = ORIGIN
    surface: Surface = field(default_factory=Surface)
    solid: bool = True
    visible: bool = True
    shield: str = ""

    def __post_init__(self) -> None:
        given = [self.box, self.sphere, self.cylinder, self.mesh or None]
        require(
            sum(shape is not None for shape in given) == 1,
            "one of box, sphere, cylinder and mesh is needed",
        )
        require(self.solid or self.visible, "solid and visible are both false; then it is nothing")

    def part(self, folder: Path) -> Part:
        """Make the shape for the model."""
        if self.box is not None:
            geometry = Geometry(Form.BOX, self.box)
        elif self.sphere is not None:
            geometry = Geometry(Form.SPHERE, (self.sphere, 0.0, 0.0))
        elif self.cylinder is not None:
            size = (self.cylinder.radius, 0.0, self.cylinder.length)
            geometry = Geometry(Form.CYLINDER, size)
        else:
            geometry = Geometry(Form.MESH, self.scale, absolute(self.mesh, folder))
        surface = replace(self.surface, texture=absolute(self.surface.texture, folder))
        return Part(
            geometry,
            self.position,
            quaternion_from_rpy(self.rpy),
            surface if self.visible else None,
            self.solid,
            self.shield,
        )


@dataclass(frozen=True)
class CustomLink:
    """A rigid body.

    Attributes
    ----------
    mass : float
        kg, spread evenly over the solid parts; a static root needs none.
    friction : float
        Coefficient.
    rolling_friction : float
        m.
    source : Source, optional
        Of radiation: {nuclide, activity, position}: Bq, m in the link.
    """

    name: str
    parts: Tuple[CustomPart, ...]
    mass: float = 0.0
    friction: float = 1.0
    rolling_friction: float = 0.0
    source: Optional[Source] = None


@dataclass(frozen=True)
class CustomJoint:
    """How one link moves against another; see `telex_sim.scene.model.Joint`.

    Attributes
    ----------
    motion : str
        hinge, slide or latch.
    position, rpy : tuple of 3 floats
        The child's frame in the parent's, with the joint at 0 (m, rad).
    axis : tuple of 3 floats
        Of length 1, in the child's frame.
    lower, upper, start : float
        rad or m.
    friction : float
        Breakaway (N m or N).
    damping : float
        N m s/rad or N s/m.
    closer : Closer, optional
        {preload, stiffness, rest}: N m, N m/rad, rad (N, N/m, m).
    detents : Detents, optional
        {positions, effort, width}: rad, N m, rad (m, N, m).
    hold, across, capture : float
        Latch: force that lets it go (N); how many times more it bears across and against its axis;
        distance within which it holds again (m).
    """

    name: str
    motion: str
    parent: str
    child: str
    position: Vector3 = ORIGIN
    rpy: Vector3 = ORIGIN
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
        motions = [motion.value for motion in Motion]
        require(
            self.motion in motions,
            f"motion is '{self.motion}'; {', '.join(motions)} are possible",
        )

    def joint(self) -> Joint:
        """Make the joint for the model."""
        same = {each.name for each in fields(Joint)} - {"motion", "orientation"}
        try:
            return Joint(
                motion=Motion(self.motion),
                orientation=quaternion_from_rpy(self.rpy),
                **{name: getattr(self, name) for name in same},
            )
        except ConfigError as error:
            raise ConfigError(f"joint '{self.name}': {error}") from None


@dataclass(frozen=True)
class Custom(ObjectType):
    """Any object, described by its links and joints."""

    links: Tuple[CustomLink, ...] = parameter(
        required,
        "The first is the root: {name, mass, friction, rolling_friction, source, parts}.",
    )
    joints: Tuple[CustomJoint, ...] = parameter((), "One for each further link.")
    static: bool = parameter(False, "Whether the root stands fast.")

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make the object."""
        links = []
        for link in self.links:
            try:
                parts = tuple(part.part(folder) for part in link.parts)
                links.append(
                    Link(
                        link.name,
                        link.mass,
                        parts,
                        link.friction,
                        link.rolling_friction,
                        link.source,
                    )
                )
            except ConfigError as error:
                raise ConfigError(f"link '{link.name}': {error}") from None
        joints = tuple(joint.joint() for joint in self.joints)
        return single(ObjectModel(tuple(links), joints, self.static))


TYPES = {"custom": Custom}
