"""The library's types as scene files use them: parameters, defaults, and what is refused."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import pytest

from telex_control.common.file_catalog import package_file
from telex_control.common.geometry.matrices import rotation_matrix
from telex_control.common.params import ConfigError
from telex_sim.scene.catalog import preview_of_type, small_jpeg
from telex_sim.scene.files.scene_file import build_entry
from telex_sim.scene.library import object_types, types_by_name
from telex_sim.scene.library.mesh_shapes import shape_files
from telex_sim.scene.model import Form
from telex_sim.scene.type_texts import parameters, summary

OWN = list(types_by_name())


def build(type_name, **given):
    return build_entry({"type": type_name, **given}, Path("/"), "it")


@pytest.mark.parametrize("kind", OWN)
def test_every_type_and_every_parameter_is_explained(kind):
    assert summary(object_types()[kind]).endswith(".")
    for name, _, meaning in parameters(object_types()[kind]):
        assert meaning, name


def test_every_type_has_its_picture():
    """Those that lack one: ``rosrun telex_sim scene pictures FOLDER TYPE...`` draws it."""
    folder = preview_of_type("any").parent
    assert sorted(path.stem for path in folder.iterdir()) == OWN
    assert [kind for kind in OWN if not small_jpeg(preview_of_type(kind))] == []


@pytest.mark.parametrize("kind", OWN)
def test_nothing_reaches_into_the_floor(kind):
    for item in build(kind):
        root = item.model.links[0]
        for part in (part for part in root.parts if part.solid):
            axis_z = rotation_matrix(part.orientation)[2]
            size = part.geometry.size
            if part.geometry.form is Form.BOX:
                reach = sum(abs(a) * s / 2.0 for a, s in zip(axis_z, size))
            elif part.geometry.form is Form.SPHERE:
                reach = size[0]
            elif part.geometry.form is Form.MESH:
                # The library's meshes stand on their origin.
                reach = 0.0
            else:
                reach = abs(axis_z[2]) * size[2] / 2.0
                reach += math.sqrt(max(0.0, 1.0 - axis_z[2] ** 2)) * size[0]
            # The slab of a ramp begins with its upper edge on the floor.
            assert part.position[2] - reach > -0.021


@pytest.mark.parametrize(
    "kind",
    [
        "crate",
        "pallet",
        "bin",
        "barrel",
        "briefcase",
        "cube",
        "cylinder",
        "pipe",
        "bottle",
        "sphere",
        "wedge",
        "plate",
    ],  # fmt: skip
)
def test_a_thing_weighs_what_is_said(kind):
    (item,) = build(kind, mass=3.5)
    assert item.model.links[0].mass == 3.5
    assert not item.model.static


REFUSED = [
    ("crate", {"mass": -1.0}, "mass is -1.0; it must be above 0"),
    ("crate", {"mass": 0}, "mass is 0.0; it must be above 0"),
    ("crate", {"mass": math.nan}, "mass"),
    ("crate", {"size": [0.3, 0.3]}, "size has 2 elements; 3 are needed"),
    ("crate", {"size": [0.3, 0.3, 0.0]}, "size[2] is 0.0; it must be at least 0.05"),
    ("crate", {"material": "gold"}, "material is 'gold'; wood, cardboard, aluminium are possible"),
    ("crate", {"weight": 3.0}, "weight is unknown"),
    ("pallet", {"height": 0.05}, "height is 0.05"),
    ("pallet_stack", {"count": 0}, "count is 0; it must be at least 1"),
    ("pallet_stack", {"count": 2.5}, "an integer is needed"),
    ("bin", {"size": [0.1, 0.1, 0.1], "wall": 0.06}, "has no room inside"),
    ("bin", {"color": [1.0, 2.0, 0.0]}, "color[1] is 2.0"),
    ("bin", {"label": "a&b"}, "label is 'a&b'"),
    ("briefcase", {"size": [0.1, 0.1, 0.3]}, "a handle needs at least 0.2"),
    ("cube", {"edge": 0.0}, "edge is 0.0"),
    ("cube", {"edge": "big"}, "edge is 'big'; a number is needed"),
    ("bottle", {"height": -0.2}, "height is -0.2"),
    ("sphere", {"radius": 0.0}, "radius is 0.0"),
    ("wedge", {"height": -0.1}, "height is -0.1"),
    ("plate", {"size": [0.1, 0.001, 0.1]}, "size[1] is 0.001"),
    ("valve", {"handle": "knob"}, "wheel, lever are possible"),
    ("drawers", {"count": 8, "height": 0.5}, "8 drawers need at least 0.96"),
    ("drawers", {"opened": [0.1, 0.2, 0.3, 0.1]}, "at most 3 numbers from 0 to 0.4"),
    ("drawers", {"opened": [0.6]}, "from 0 to 0.4"),
    ("valve", {"height": 0.15, "radius": 0.2}, "needs at least 0.25"),
    ("valve", {"facing": "down"}, "front, up are possible"),
    ("valve", {"friction": -1.0}, "friction is -1.0"),
    ("lever", {"notches": [0.5]}, "at least two rising angles"),
    ("lever", {"notches": [0.5, -0.5]}, "at least two rising angles"),
    ("lever", {"start": 1.0}, "start is 1.0"),
    ("connector", {"clearance": 0.02}, "clearance is 0.02"),
    ("connector", {"hold": math.inf}, "hold"),
    ("door", {"damping": 600.0}, "damping is 600.0; above 500"),
    ("door", {"start": 2.0}, "start is 2.0"),
    ("door", {"hinges": "top"}, "left, right are possible"),
    ("wall", {"opening": 1.0, "opening_at": 2.0}, "has no room there"),
    ("wall", {"finish": "glass"}, "finish is 'glass'"),
    ("sign", {"text": "ä"}, "characters of ASCII"),
    ("sign", {"text": "x" * 41}, "at most 40 characters"),
    ("chart", {"kind": "Z"}, "E, C are possible"),
    ("rails", {"heights": [0.1, 3.0]}, "heights[1] is 3.0"),
    ("rails", {"gauge": 0.1}, "gauge is 0.1"),
    ("beam_line", {"elements": ["pipe", "laser"]}, "elements is ['pipe', 'laser']"),
    ("beam_line", {"elements": []}, "elements is []"),
    ("beam_line", {"radius": 1.0}, "radius is 1.0"),
    ("source_container", {"hole": 0.12}, "can be at most 0.0975"),
    ("source_container", {"lid": "hinged", "static": False}, "a hinged lid needs a static pot"),
    ("inspection_pipes", {"height": 0.1}, "needs at least 0.52"),
    ("place_panel", {"height": 0.05}, "height is 0.05"),
    ("stairs", {"rise": 0.0}, "rise is 0.0"),
    ("stairs", {"steps": 61}, "steps is 61; it must be at least 1 and at most 60"),
    ("stairs", {"railings": "top"}, "none, left, right, both are possible"),
    ("gap", {"ramp": 0.05, "height": 0.3}, "needs at least 0.15"),
    ("hurdle", {"edge": "pipe", "height": 0.06}, "has no room for it"),
    ("inclined_plane", {"angle": 45.0}, "angle is 45.0"),
    ("crossing_ramps", {"rows": 3}, "rows is 3; it must be even"),
    ("stepfield", {"pattern": "wave"}, "flat, hill, diagonal are possible"),
    ("stepfield", {"seed": -1}, "seed is -1"),
    ("maze", {"corridor": 0.2}, "corridor is 0.2"),
    ("maze", {"columns": True}, "an integer is needed"),
    ("tunnel", {"radius": 2.0}, "it must be 0, or at least 6.3662 to either side"),
    ("tunnel", {"niches": [{"at": 9.9}]}, "niches[0] does not fit into the wall"),
    ("tunnel", {"niches": [{"at": 0.0, "height": 2.5}]}, "niches[0] does not fit into the wall"),
    ("tunnel", {"niches": [{"side": "left"}]}, "at is missing"),
    ("tunnel", {"niches": [{"at": 1.0}, {"at": 2.0}]}, "niches[0] and niches[1] are 1 apart"),
]


@pytest.mark.parametrize(("kind", "wrong", "message"), REFUSED)
def test_a_bad_parameter_is_refused_with_its_name_and_what_would_be_right(kind, wrong, message):
    with pytest.raises(ConfigError) as refusal:
        build(kind, **wrong)
    assert message in str(refusal.value)


def test_the_shipped_meshes_are_those_that_the_code_makes():
    shipped = package_file("telex_sim", "meshes")
    assert {path.stem: path.read_text() for path in shipped.glob("*.obj")} == shape_files()


def test_a_static_crate_stands_fast_and_a_free_one_does_not():
    (static,) = build("crate", static=True)
    (free,) = build("crate")
    assert static.model.static
    assert not free.model.static


def test_a_cube_weighs_as_hardwood_unless_it_is_said():
    (cube,) = build("cube", edge=0.1)
    (heavy,) = build("cube", edge=0.1, mass=5.0)
    assert cube.model.links[0].mass == pytest.approx(0.7)
    assert heavy.model.links[0].mass == 5.0


@pytest.mark.parametrize(("height", "glazed"), [(1.3, False), (1.42, False), (1.43, True)])
def test_a_door_has_a_pane_where_there_is_room_for_one(height, glazed):
    (door,) = build("door", height=height)
    leaf = door.model.links[1].parts
    assert all(min(part.geometry.size) > 0.0 for part in leaf)
    assert any(part.surface and part.surface.color[3] < 1.0 for part in leaf) is glazed


def test_a_lever_without_notches_to_hold_it_has_only_friction():
    (lever,) = build("lever", notch_torque=0.0)
    (hinge,) = lever.model.joints
    assert (hinge.detents, hinge.friction) == (None, 1.0)


@pytest.mark.parametrize("kind", OWN)
def test_the_catalogue_names_every_type_with_its_parameters(kind):
    catalogue = package_file("telex_sim").parent.parent / "docs" / "instructor" / "scene_objects.md"
    rows = [line.split(" | ") for line in catalogue.read_text().splitlines()]
    (listed,) = [row[2] for row in rows if row[0] == f"| `{kind}`"]
    fields = {field.name: field.default for field in dataclasses.fields(object_types()[kind])}
    for name, shown, _ in parameters(object_types()[kind]):
        assert (name if fields[name] in (None, "", ()) else f"{name} {shown}") in listed
