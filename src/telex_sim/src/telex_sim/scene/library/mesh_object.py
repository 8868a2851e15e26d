"""Objects from a mesh of one's own."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Tuple

from telex_control.common.params import require, require_range, required

from ..addresses import absolute
from ..model import (
    WHITE,
    Color,
    Form,
    Geometry,
    Part,
    SceneObject,
    Surface,
    Vector3,
)
from .object_type import ObjectType
from .shapes import rigid


@dataclass(frozen=True)
class MeshObject(ObjectType):
    """An OBJ or STL file. Static, it collides exactly; if it can move, as its convex hull.

    Attributes
    ----------
    mesh : str
        Address: relative to the scene file, absolute, or package://…
    scale : tuple of 3 floats
        0.001 three times turns millimetres into metres.
    static : bool
        Whether it stands fast.
    mass : float
        kg; of what can move.
    friction : float
        Coefficient.
    rolling_friction : float
        m.
    color : tuple of 4 floats
        Red, green, blue, opacity, 0 to 1.
    texture : str
        Address of a picture, or generated:NAME.
    texture_scale : float
        Length that one repetition covers (m); 0 takes the mesh's own coordinates.
    solid : bool
        Whether it can be touched.
    """

    mesh: str = field(default_factory=required)
    scale: Vector3 = (1.0, 1.0, 1.0)
    static: bool = False
    mass: float = 1.0
    friction: float = 1.0
    rolling_friction: float = 0.0
    color: Color = WHITE
    texture: str = ""
    texture_scale: float = 0.0
    solid: bool = True

    def __post_init__(self) -> None:
        require(bool(self.mesh), "mesh is ''; the address of a file is needed")
        require(all(self.scale), f"scale is {list(self.scale)}; none may be 0")
        require_range(self, "mass", above=0.0)
        require(self.static or self.solid, "solid is false; what cannot be touched must be static")

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make the object."""
        surface = Surface(self.color, absolute(self.texture, folder), self.texture_scale)
        geometry = Geometry(Form.MESH, self.scale, absolute(self.mesh, folder))
        part = Part(geometry, surface=surface, solid=self.solid)
        return rigid(
            "body",
            self.mass,
            (part,),
            self.friction,
            self.rolling_friction,
            static=self.static,
        )


TYPES = {"mesh": MeshObject}
