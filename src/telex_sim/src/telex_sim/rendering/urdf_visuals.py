"""The visuals of a robot model."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Dict, List, Sequence, Tuple

from urdf_parser_py import urdf

from .scene import Color, Shape, Vector3
from .transforms import Quaternion, quaternion_from_rpy

# Name of visuals that run around wheels.
_BELT = "belt"

# Of visuals without a material.
DEFAULT_COLOR: Color = (0.7, 0.7, 0.7, 1.0)


class UrdfVisualError(ValueError):
    """The model's text cannot be read; the message says where it is wrong."""


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
    shape: Shape
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
    UrdfVisualError
        When the text is no URDF, or a belt has not one drive wheel.
    """
    try:
        # Bytes, because lxml refuses a str that declares its encoding.
        robot = urdf.URDF.from_xml_string(text.encode("utf-8"))
    except Exception as error:  # the parser raises whatever fails first
        raise UrdfVisualError(f"robot description: {error}") from error
    materials = _materials(robot)
    return [
        _visual(link.name, visual, materials, robot)
        for link in robot.links
        for visual in link.visuals
    ]


def _materials(robot: Any) -> Dict[str, Any]:
    in_visuals = [visual.material for link in robot.links for visual in link.visuals]
    materials: Dict[str, Any] = {}
    for material in (*robot.materials, *in_visuals):
        if material is not None and _is_defined(material):
            materials.setdefault(material.name, material)
    return materials


def _is_defined(material: Any) -> bool:
    return material.color is not None or material.texture is not None


def _visual(link: str, visual: Any, materials: Dict[str, Any], robot: Any) -> UrdfVisual:
    shape, size, mesh = _geometry(link, visual.geometry)
    position, orientation = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)
    if visual.origin is not None:
        position = _vector3(visual.origin.xyz or position)
        orientation = quaternion_from_rpy(visual.origin.rpy or (0.0, 0.0, 0.0))
    color, texture = _appearance(visual.material, materials)
    return UrdfVisual(
        link,
        shape,
        size,
        position,
        orientation,
        color,
        mesh,
        texture,
        drive=_drive(link, robot) if visual.name == _BELT and mesh else "",
        mesh_materials=bool(mesh) and visual.material is None,
    )


def _drive(link: str, robot: Any) -> str:
    wheels = [
        joint.child for joint in robot.joints if joint.parent == link and joint.type == "continuous"
    ]
    if len(wheels) != 1:
        raise UrdfVisualError(
            f"robot description: link '{link}' has a visual '{_BELT}' and {len(wheels)} continuous"
            " joints; a belt needs one, which drives it"
        )
    return wheels[0]


def _geometry(link: str, geometry: Any) -> Tuple[Shape, Vector3, str]:
    if isinstance(geometry, urdf.Box):
        return Shape.BOX, _vector3(geometry.size), ""
    if isinstance(geometry, urdf.Sphere):
        return Shape.SPHERE, (float(geometry.radius), 0.0, 0.0), ""
    if isinstance(geometry, urdf.Cylinder):
        return Shape.CYLINDER, (float(geometry.radius), 0.0, float(geometry.length)), ""
    if isinstance(geometry, urdf.Mesh):
        return Shape.MESH, _vector3(geometry.scale or (1.0, 1.0, 1.0)), geometry.filename
    raise UrdfVisualError(f"robot description: a visual of link '{link}' has no known geometry")


def _appearance(material: Any, materials: Dict[str, Any]) -> Tuple[Color, str]:
    if material is not None and not _is_defined(material):
        material = materials.get(material.name)
    if material is None:
        return DEFAULT_COLOR, ""
    texture = material.texture.filename if material.texture is not None else ""
    if material.color is None:
        return (1.0, 1.0, 1.0, 1.0), texture
    red, green, blue, alpha = (float(component) for component in material.color.rgba)
    return (red, green, blue, alpha), texture


def _vector3(values: Sequence[float]) -> Vector3:
    x, y, z = (float(value) for value in values)
    return x, y, z
