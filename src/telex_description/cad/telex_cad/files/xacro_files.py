"""Xacro texts of the generated parts of the robot: materials, and one macro per body."""

from __future__ import annotations

from typing import Dict, Iterable, List, Mapping, Sequence

from ..link_model import BoxShape, CylinderShape, HullShape, LinkModel, MassProperties, Shape

MESHES = "package://telex_description/meshes"
_HEAD = (
    '<?xml version="1.0"?>\n'
    "<!-- Written by scripts/generate_model; change the solids in cad/telex_cad instead. -->\n"
    '<robot xmlns:xacro="http://www.ros.org/wiki/xacro">\n'
)


def document(parts: Iterable[str]) -> str:
    """Return a xacro file with these parts."""
    return _HEAD + "".join(f"{part}\n" for part in parts) + "</robot>\n"


def material_element(name: str, colour: Sequence[float]) -> str:
    """Return the definition of a material; colour: red, green, blue, 0 to 1."""
    text = " ".join(f"{value:.3f}" for value in colour)
    return f'  <material name="{name}"><color rgba="{text} 1"/></material>'


def visual_mesh(body: str, material: str) -> str:
    """Return the path of a visual mesh below the folder of meshes."""
    return f"visual/{body}_{material}.obj"


def collision_mesh(body: str, index: int) -> str:
    """Return the path of a body's collision mesh below the folder of meshes; counted from 0."""
    return f"collision/{body}_{index + 1}.obj"


def body_macro(link: LinkModel, properties: MassProperties, materials: Sequence[str]) -> str:
    """Return the macro <name>_body: what stands inside the <link> element.

    The macro's parameter `inertial` leaves the mass out when false.
    """
    lines = [f'  <xacro:macro name="{link.name}_body" params="inertial:=true">']
    lines += ['    <xacro:if value="${inertial}">', *_inertial(properties), "    </xacro:if>"]
    for material in materials:
        mesh = f'<mesh filename="{MESHES}/{visual_mesh(link.name, material)}"/>'
        name = ' name="belt"' if material == link.belt else ""
        lines.append(
            f'    <visual{name}><geometry>{mesh}</geometry><material name="{material}"/></visual>'
        )
    hulls: Dict[int, str] = {
        k: collision_mesh(link.name, number) for number, k in enumerate(hull_indices(link))
    }
    lines += [_collision(shape, hulls.get(k, "")) for k, shape in enumerate(link.shapes)]
    return "\n".join([*lines, "  </xacro:macro>"])


def hull_indices(link: LinkModel) -> List[int]:
    """Return which of a link's collision shapes are meshes."""
    return [k for k, shape in enumerate(link.shapes) if isinstance(shape, HullShape)]


def _inertial(properties: MassProperties) -> List[str]:
    inertia = properties.inertia
    entries: Mapping[str, float] = {
        "ixx": inertia[0, 0],
        "ixy": inertia[0, 1],
        "ixz": inertia[0, 2],
        "iyy": inertia[1, 1],
        "iyz": inertia[1, 2],
        "izz": inertia[2, 2],
    }
    # Products far below the moments are rounding errors of the symmetric solids.
    negligible = 1e-6 * max(entries.values())
    text = " ".join(
        f'{name}="{0.0 if abs(value) < negligible else value:.6g}"'
        for name, value in entries.items()
    )
    return [
        "      <inertial>",
        f'        <origin xyz="{_numbers(properties.centre)}"/>',
        f'        <mass value="{properties.mass:.6g}"/>',
        f"        <inertia {text}/>",
        "      </inertial>",
    ]


def _collision(shape: Shape, mesh: str) -> str:
    if isinstance(shape, HullShape):
        geometry = f'<mesh filename="{MESHES}/{mesh}"/>'
        return f"    <collision><geometry>{geometry}</geometry></collision>"
    if isinstance(shape, BoxShape):
        geometry = f'<box size="{_numbers(shape.size)}"/>'
    elif isinstance(shape, CylinderShape):
        geometry = f'<cylinder radius="{shape.radius:.6g}" length="{shape.length:.6g}"/>'
    origin = f'<origin xyz="{_numbers(shape.at)}" rpy="{_numbers(shape.rpy, 9)}"/>'
    return f"    <collision>{origin}<geometry>{geometry}</geometry></collision>"


def _numbers(values: Iterable[float], decimals: int = 6) -> str:
    return " ".join(f"{round(float(value), decimals) + 0.0:.10g}" for value in values)
