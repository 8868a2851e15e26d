"""The visuals of a robot model."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Dict, List, Optional, Tuple
from xml.etree import ElementTree

from telex_control.common.geometry.quaternions import Quaternion, quaternion_from_rpy
from telex_control.urdf.elements import UrdfError, end, number, numbers, origin, vector
from telex_control.urdf.joints import CONTINUOUS, parse_urdf

from ...scene.visual_scene import Color, Vector3, VisualShape

# Name of visuals that run around wheels.
_BELT = "belt"

# Of visuals without a material.
DEFAULT_COLOR: Color = (0.7, 0.7, 0.7, 1.0)


_Element = ElementTree.Element


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
        When the text is no URDF, or a belt has not one drive wheel.
    """
    robot = parse_urdf(text)
    materials = _materials(robot)
    return [
        _visual(link.get("name", ""), visual, materials, robot)
        for link in robot.findall("link")
        for visual in link.findall("visual")
    ]


def _materials(robot: _Element) -> Dict[str, _Element]:
    materials: Dict[str, _Element] = {}
    for material in (*robot.findall("material"), *robot.findall("link/visual/material")):
        if _is_defined(material):
            materials.setdefault(material.get("name", ""), material)
    return materials


def _is_defined(material: _Element) -> bool:
    return material.find("color") is not None or material.find("texture") is not None


def _visual(
    link: str, visual: _Element, materials: Dict[str, _Element], robot: _Element
) -> UrdfVisual:
    where = f"link '{link}': visual"
    shape, size, mesh = _geometry(where, visual.find("geometry"))
    place = origin(visual, where)
    material = visual.find("material")
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
        drive=_drive(link, robot) if visual.get("name") == _BELT and mesh else "",
        mesh_materials=bool(mesh) and material is None,
    )


def _drive(link: str, robot: _Element) -> str:
    wheels = [
        end(joint, "child")
        for joint in robot.findall("joint")
        if end(joint, "parent") == link and joint.get("type") == CONTINUOUS
    ]
    if len(wheels) != 1:
        raise UrdfError(
            f"robot_description: link '{link}' has a visual '{_BELT}' and {len(wheels)} continuous"
            " joints; a belt needs one, which drives it"
        )
    return wheels[0]


def _geometry(where: str, geometry: Optional[_Element]) -> Tuple[VisualShape, Vector3, str]:
    for shape in () if geometry is None else geometry:
        if shape.tag == "box":
            x, y, z = numbers(shape, "size", 3, where)
            return VisualShape.BOX, (x, y, z), ""
        if shape.tag == "sphere":
            return VisualShape.SPHERE, (number(shape, "radius", where), 0.0, 0.0), ""
        if shape.tag == "cylinder":
            radius, length = (number(shape, key, where) for key in ("radius", "length"))
            return VisualShape.CYLINDER, (radius, 0.0, length), ""
        if shape.tag == "mesh":
            scale = vector(shape, "scale", where, (1.0, 1.0, 1.0))
            return VisualShape.MESH, scale, shape.get("filename", "")
    raise UrdfError(
        f"robot_description: {where} has no known geometry; box, sphere, cylinder or mesh is needed"
    )


def _appearance(
    where: str, material: Optional[_Element], materials: Dict[str, _Element]
) -> Tuple[Color, str]:
    if material is not None and not _is_defined(material):
        material = materials.get(material.get("name", ""))
    if material is None:
        return DEFAULT_COLOR, ""
    picture, color = material.find("texture"), material.find("color")
    texture = "" if picture is None else picture.get("filename", "")
    if color is None:
        return (1.0, 1.0, 1.0, 1.0), texture
    red, green, blue, alpha = numbers(color, "rgba", 4, where)
    return (red, green, blue, alpha), texture
