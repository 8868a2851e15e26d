"""The visuals of a robot model."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Dict, List, Optional, Tuple

from telex_control.common.geometry.quaternions import Quaternion, quaternion_from_rpy
from telex_control.urdf.elements import UrdfError, number, numbers, origin, vector
from telex_control.urdf.joints import CONTINUOUS, parse_urdf
from telex_control.urdf.model import Box, Cylinder, Material, Mesh, Robot, Sphere, Visual

from ...scene.visual_scene import Color, Vector3, VisualShape

# Name of visuals that run around wheels.
_BELT = "belt"

# Of visuals without a material.
DEFAULT_COLOR: Color = (0.7, 0.7, 0.7, 1.0)


@dataclass(frozen=True)
class UrdfVisual:
    """One visual of one link.

    Attributes
    ----------
    link
        Whose frame it is fixed to.
    shape, size
        As in telex_msgs/SceneVisual (m; a factor for meshes).
    position, orientation
        Of the shape in the link's frame: x y z (m), quaternion x y z w.
    color
        Red, green, blue, alpha of the material, each 0..1.
    mesh
        Address of the mesh, empty for primitives.
    texture
        Address of the material's picture, or empty.
    drive
        Link whose turning drives it as a belt, or empty.
    mesh_materials
        Whether the mesh shows colours and textures of its own: where the robot says nothing.
    """

    link: str
    shape: VisualShape
    size: Vector3
    position: Vector3
    orientation: Quaternion
    color: Color
    mesh: str
    texture: str
    drive: str = ""
    mesh_materials: bool = False


def urdf_visuals(text: str) -> List[UrdfVisual]:
    """List the visuals of all links, in the order of the text.

    A material that is only named takes the colour and picture of the material of that name in the
    robot or, where the robot has none, in a visual. A visual with the name "belt" runs around the
    wheels of its link, driven by the one link that a continuous joint hangs there.

    Parameters
    ----------
    text
        URDF, after xacro.

    Raises
    ------
    UrdfError
        When the text is no URDF, a colour is none, or a belt has not one drive wheel.
    """
    robot = parse_urdf(text)
    materials = _materials(robot)
    return [
        _visual(link.name, visual, materials, robot)
        for link in robot.links
        for visual in link.visuals
    ]


def _materials(robot: Robot) -> Dict[str, Material]:
    materials: Dict[str, Material] = {}
    shown = [visual.material for link in robot.links for visual in link.visuals]
    for material in (*robot.materials, *filter(None, shown)):
        if _is_defined(material):
            materials.setdefault(material.name, material)
    return materials


def _is_defined(material: Material) -> bool:
    return material.color is not None or material.texture is not None


def _visual(link: str, visual: Visual, materials: Dict[str, Material], robot: Robot) -> UrdfVisual:
    where = f"link '{link}': visual"
    shape, size, mesh = _geometry(where, visual.geometry)
    place = origin(visual, where)
    material = visual.material
    color, texture = _appearance(where, material, materials)
    return UrdfVisual(
        link,
        shape,
        size,
        place.xyz,
        quaternion_from_rpy(place.rpy),
        color,
        mesh,
        texture,
        drive=_drive(link, robot) if visual.name == _BELT and mesh else "",
        mesh_materials=bool(mesh) and material is None,
    )


def _drive(link: str, robot: Robot) -> str:
    wheels = [
        joint.child for joint in robot.joints if joint.parent == link and joint.type == CONTINUOUS
    ]
    if len(wheels) != 1:
        raise UrdfError(
            f"robot_description: link '{link}' has a visual '{_BELT}' and {len(wheels)} continuous"
            " joints; a belt needs one, which drives it"
        )
    return wheels[0]


def _geometry(where: str, shape: Any) -> Tuple[VisualShape, Vector3, str]:
    if isinstance(shape, Box):
        x, y, z = numbers(shape, "size", 3, where)
        return VisualShape.BOX, (x, y, z), ""
    if isinstance(shape, Sphere):
        return VisualShape.SPHERE, (number(shape, "radius", where), 0.0, 0.0), ""
    if isinstance(shape, Cylinder):
        radius, length = (number(shape, key, where) for key in ("radius", "length"))
        return VisualShape.CYLINDER, (radius, 0.0, length), ""
    if isinstance(shape, Mesh):
        return VisualShape.MESH, vector(shape, "scale", where, (1.0, 1.0, 1.0)), shape.filename
    raise UrdfError(
        f"robot_description: {where} has no known geometry; box, sphere, cylinder or mesh is needed"
    )


def _appearance(
    where: str, material: Optional[Material], materials: Dict[str, Material]
) -> Tuple[Color, str]:
    if material is not None and not _is_defined(material):
        material = materials.get(material.name)
    if material is None:
        return DEFAULT_COLOR, ""
    texture = "" if material.texture is None else material.texture.filename
    if material.color is None:
        return (1.0, 1.0, 1.0, 1.0), texture
    red, green, blue, alpha = numbers(material.color, "rgba", 4, where)
    for value in (red, green, blue, alpha):
        if not 0.0 <= value <= 1.0:  # urdfdom, and with it rviz, takes no others either
            raise UrdfError(f"{where}: <color rgba> has the value {value:g}; 0 to 1 is needed")
    return (red, green, blue, alpha), texture
