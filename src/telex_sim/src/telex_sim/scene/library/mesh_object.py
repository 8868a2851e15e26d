"""Objects from a mesh of one's own."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Tuple

from telex_control.common.params import require, required

from ..addresses import absolute
from ..model import WHITE, Color, Form, Geometry, Part, SceneObject, Surface, Vector3
from .object_type import ObjectType
from .parameters import kilograms, parameter
from .shapes import rigid


@dataclass(frozen=True)
class MeshObject(ObjectType):
    """An OBJ or STL file. Static, it collides exactly; if it can move, as its convex hull."""

    mesh: str = parameter(required, "Address: relative to the scene file, absolute, or package://…")
    scale: Vector3 = parameter((1.0, 1.0, 1.0), "0.001 three times turns millimetres into metres.")
    static: bool = parameter(False, "Whether it stands fast.")
    mass: float = kilograms(1.0, "kg; of what can move.")
    friction: float = parameter(1.0, "Coefficient.")
    rolling_friction: float = parameter(0.0, "m.")
    color: Color = parameter(WHITE, "Red, green, blue, opacity, 0 to 1.")
    texture: str = parameter("", "Address of a picture, or generated:NAME.")
    texture_scale: float = parameter(
        0.0, "Length that one repetition covers (m); 0 takes the mesh's own coordinates."
    )
    solid: bool = parameter(True, "Whether it can be touched.")

    def check(self) -> None:
        """Check what concerns several parameters; see `Declared.check`."""
        require(bool(self.mesh), "mesh is ''; the address of a file is needed")
        require(all(self.scale), f"scale is {list(self.scale)}; none may be 0")
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
