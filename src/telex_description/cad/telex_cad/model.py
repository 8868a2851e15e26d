"""All links, and the files of the package that are made of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Dict, List, Sequence

from . import hull, running_gear, tools
from .figures import Figures
from .files.mesh_files import LIBRARY, hull_obj, material_library, visual_obj
from .files.xacro_files import (
    body_macro,
    collision_mesh,
    document,
    hull_indices,
    material_element,
    visual_mesh,
)
from .link_model import HullShape, LinkModel, MassProperties
from .materials import MATERIALS
from .upper import arm, gripper, turret

GENERATED = "urdf/generated"


@dataclass(frozen=True)
class BodySummary:
    """What the table says of one body.

    Attributes
    ----------
    count
        How many of them the standard robot has.
    """

    name: str
    count: int
    triangles: int
    properties: MassProperties


@dataclass(frozen=True)
class GeneratedModel:
    """Texts of the generated files by their path in the package, and the table's rows."""

    files: Dict[str, str]
    bodies: List[BodySummary]


def generate(figures: Figures, lengths: Sequence[int]) -> GeneratedModel:
    """Make every generated file.

    Parameters
    ----------
    figures
        Dimensions.
    lengths
        Lengths of flippers that there are to be (mm between the axles), the standard one among
        them.
    """
    standard = running_gear.millimetres(figures.flipper["length"])
    alternatives = {link.name for link in tools.links(figures)}
    files: Dict[str, str] = {}
    bodies: List[BodySummary] = []

    def body(link: LinkModel, count: int) -> str:
        properties = link.mass_properties()
        solids = link.merged()
        triangles = 0
        for material, solid in solids.items():
            text, faces = visual_obj(solid, material)
            files[f"meshes/{visual_mesh(link.name, material)}"] = text
            triangles += faces
        for number, k in enumerate(hull_indices(link)):
            shape = link.shapes[k]
            if isinstance(shape, HullShape):
                files[f"meshes/{collision_mesh(link.name, number)}"] = hull_obj(shape.points)
        bodies.append(BodySummary(link.name, count, triangles, properties))
        return body_macro(link, properties, list(solids))

    links = [
        body(link, 0 if link.name in alternatives else 1)
        for module in (hull, turret, arm, gripper, tools)
        for link in module.links(figures)
    ]
    links.append(body(running_gear.track(figures), 4))
    files[f"{GENERATED}/links.xacro"] = document(links)
    for length in lengths:
        flippers = [
            body(running_gear.flipper(figures, end, length), 2 if length == standard else 0)
            for end in ("front", "rear")
        ]
        files[f"{GENERATED}/flipper_{length}.xacro"] = document(flippers)
    colours = {
        name: material.colour for name, material in MATERIALS.items() if material.colour is not None
    }
    files[f"{GENERATED}/materials.xacro"] = document(
        [material_element(name, colour) for name, colour in colours.items()]
    )
    files[f"meshes/visual/{LIBRARY}"] = material_library(colours)
    return GeneratedModel(files, bodies)
