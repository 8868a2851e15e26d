"""What scripts/generate_model writes: the same on every run, within budget, true to the solids."""

from __future__ import annotations

import math
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Dict, List, Tuple

import numpy as np
import pytest
from assembly import Assembly
from manifold3d import Manifold
from shipped_robot import PACKAGE, expanded
from telex_cad import hull, running_gear
from telex_cad.figures import Figures
from telex_cad.files.mesh_files import visual_obj
from telex_cad.link_model import LinkModel, volume_moments
from telex_cad.materials import MATERIALS
from telex_cad.solids import box, cylinder, hose, outline_of, ring, warning_stripes
from urdf_parser_py.urdf import URDF, Mesh

pytestmark = pytest.mark.slow

SCRIPT = PACKAGE / "scripts" / "generate_model"
MESH_ADDRESS = "package://telex_description"


TRIANGLES = 60_000
HULL_AND_RUNNING_GEAR = 40_000
ENDS = ("front", "rear")


def generate(*arguments: str) -> subprocess.CompletedProcess:
    return subprocess.run(
        [sys.executable, str(SCRIPT), *arguments], capture_output=True, text=True, check=False
    )


def mesh_file(address: str) -> Path:
    assert address.startswith(MESH_ADDRESS)
    return Path(address.replace(MESH_ADDRESS, str(PACKAGE)))


def read_obj(file: Path) -> Tuple[np.ndarray, np.ndarray]:
    """Return vertices (n, 3) and triangles (m, 3) as an independent reader sees them."""
    lines = [line.split() for line in file.read_text(encoding="ascii").splitlines()]
    vertices = [[float(word) for word in line[1:]] for line in lines if line[0] == "v"]
    faces = [[int(word.split("/")[0]) - 1 for word in line[1:]] for line in lines if line[0] == "f"]
    return np.array(vertices), np.array(faces)


def visual_meshes(robot: URDF) -> List[Tuple[str, Path]]:
    """Return link and file of every visual."""
    return [
        (link.name, mesh_file(visual.geometry.filename))
        for link in robot.links
        for visual in link.visuals
        if isinstance(visual.geometry, Mesh)
    ]


# ---- the files in the repository


def test_check_names_nothing_but_what_differs_and_generating_mends_it(tmp_path: Path) -> None:
    for folder in ("meshes", "urdf"):
        shutil.copytree(PACKAGE / folder, tmp_path / folder)
    visual = tmp_path / "meshes" / "visual"
    with (visual / "track_metal.obj").open("a") as file:
        file.write("# touched\n")
    (visual / "track_dark.obj").unlink()
    (visual / "track_velvet.obj").write_text("")
    result = generate("--check", "--package", str(tmp_path))
    assert result.returncode == 1
    assert re.search(r"differs: +meshes/visual/track_metal.obj", result.stderr)
    assert re.search(r"missing: +meshes/visual/track_dark.obj", result.stderr)
    assert re.search(r"left over: +meshes/visual/track_velvet.obj", result.stderr)
    # What else is shipped is what regeneration gives.
    assert len(re.findall(r"differs:|missing:|left over:", result.stderr)) == 3
    assert not (visual / "track_dark.obj").exists()

    mended = generate("--package", str(tmp_path), "--flipper-length", "0.405")
    assert mended.returncode == 0, mended.stderr
    assert not (visual / "track_velvet.obj").exists()
    for name in ("track_metal.obj", "track_dark.obj"):
        assert (visual / name).read_bytes() == (PACKAGE / "meshes/visual" / name).read_bytes()

    # Flippers of a further length are kept from then on.
    made = tmp_path / "urdf" / "generated" / "flipper_405.xacro"
    assert "flipper_front_405_body" in made.read_text()
    vertices, _ = read_obj(tmp_path / "meshes" / "collision" / "flipper_front_405_2.obj")
    assert vertices[:, 0].max() == pytest.approx(math.sqrt(0.405**2 - 0.04**2) + 0.07, abs=1e-3)
    assert generate("--check", "--package", str(tmp_path)).returncode == 0


@pytest.mark.parametrize("length", ["0.1", "nan"])
def test_impossible_flipper_length_is_refused(length: str) -> None:
    result = generate("--check", "--flipper-length", length)
    assert result.returncode == 2
    assert f"'{length}' is no length of a flipper: give 0.3 to 0.6 (m)" in result.stderr


def test_file_without_figures_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "robot.xacro"
    file.write_text('<robot xmlns:xacro="http://www.ros.org/wiki/xacro"/>')
    result = generate("--check", "--robot", str(file))
    assert result.returncode == 1
    assert f"{file}: no xacro:property named 'flipper'" in result.stderr


# ---- meshes


def test_robot_has_at_most_60_000_triangles(robot: URDF) -> None:
    counts: Dict[str, int] = {}
    for link, file in visual_meshes(robot):
        counts[link] = counts.get(link, 0) + len(read_obj(file)[1])
    assert sum(counts.values()) <= TRIANGLES
    below = [link for link in counts if re.search("^base_link|flipper|track", link)]
    assert len(below) == 9
    assert sum(counts[link] for link in below) <= HULL_AND_RUNNING_GEAR


def test_every_visual_has_its_mesh_and_a_defined_material(robot: URDF) -> None:
    colours = {material.name: material.color.rgba for material in robot.materials}
    assert len(visual_meshes(robot)) > 50
    for link in robot.links:
        for visual in link.visuals:
            file = mesh_file(visual.geometry.filename)
            assert file.stem.endswith(f"_{visual.material.name}")
            assert file.is_file(), link.name
            assert colours[visual.material.name][:3] == pytest.approx(
                MATERIALS[visual.material.name].colour
            )


def test_every_mesh_in_the_folder_is_used() -> None:
    used = set()
    files = (PACKAGE / "urdf" / "generated").glob("flipper_*.xacro")
    lengths = [f"flipper_length:={int(file.stem[len('flipper_') :]) / 1000}" for file in files]
    assert len(lengths) >= 3
    for arguments in (*lengths, "tool:=probe", "tool:=none"):
        for link in expanded(arguments).links:
            shapes = [*link.visuals, *link.collisions]
            used |= {mesh_file(s.geometry.filename) for s in shapes if isinstance(s.geometry, Mesh)}
    assert used == set((PACKAGE / "meshes").rglob("*.obj"))


@pytest.mark.parametrize(
    "name", ["base_link_hull", "flipper_front_440_shell", "flipper_rear_440_rubber", "track_metal"]
)
def test_visual_mesh_is_closed_and_faces_outwards(name: str) -> None:
    vertices, faces = read_obj(PACKAGE / "meshes" / "visual" / f"{name}.obj")
    corners = vertices[faces]
    volume = np.linalg.det(corners).sum() / 6
    assert volume > 0
    # Each edge is walked once in each direction, apart from slivers that rounding made vanish.
    edges = {(a, b) for face in faces for a, b in zip(face, np.roll(face, -1))}
    open_edges = sum((b, a) not in edges for a, b in edges)
    assert open_edges <= 0.01 * len(edges)


def test_normals_are_smooth_on_round_and_sharp_on_flat_surfaces() -> None:
    text, triangles = visual_obj(cylinder(0.05, 0.10, bevel=0.0, segments=24), "metal")
    normals = {tuple(map(float, line.split()[1:])) for line in text.splitlines() if "vn" in line}
    assert triangles == 24 * 4
    # Two caps, and one direction for each of the 24 edges of the wall
    assert len(normals) == 26
    assert (0.0, 0.0, 1.0) in normals
    wall = [normal for normal in normals if abs(normal[2]) < 0.5]
    assert all(math.hypot(*normal) == pytest.approx(1, abs=2e-3) for normal in wall)
    sharp, _ = visual_obj(box((0.1, 0.1, 0.1), bevel=0.0), "metal")
    assert sharp.count("vn ") == 6


def test_every_mesh_names_its_material_in_the_library() -> None:
    folder = PACKAGE / "meshes" / "visual"
    library = (folder / "materials.mtl").read_text()
    for mesh in folder.glob("*.obj"):
        lines = mesh.read_text().splitlines()
        assert "mtllib materials.mtl" in lines
        (used,) = [line.split()[1] for line in lines if line.startswith("usemtl ")]
        assert mesh.stem.endswith(f"_{used}")
        assert f"newmtl {used}\n" in library


# ---- mass properties


def test_moments_of_a_box_are_those_of_the_formula() -> None:
    link = LinkModel("brick", 3.0)
    link.add("metal", box((0.1, 0.2, 0.3), (1.0, 2.0, 3.0), 0.0))
    properties = link.mass_properties()
    assert properties.centre == pytest.approx([1.0, 2.0, 3.0])
    expected = 3.0 / 12 * np.diag([0.2**2 + 0.3**2, 0.1**2 + 0.3**2, 0.1**2 + 0.2**2])
    assert properties.inertia == pytest.approx(expected, abs=1e-12)


def test_dense_material_draws_the_centre_towards_itself() -> None:
    link = LinkModel("rod", 1.0)
    link.add("rubber", box((1.0, 0.1, 0.1), (-0.5, 0, 0), 0.0))
    link.add_inside("metal", box((1.0, 0.1, 0.1), (0.5, 0, 0), 0.0))
    light, heavy = MATERIALS["rubber"].density, MATERIALS["metal"].density
    expected = 0.5 * (heavy - light) / (heavy + light)
    assert link.mass_properties().centre[0] == pytest.approx(expected)
    assert sorted(link.merged()) == ["rubber"]


def test_tilted_box_keeps_its_principal_moments() -> None:
    link = LinkModel("brick", 2.0)
    link.add("metal", box((0.1, 0.2, 0.4), bevel=0.0).rotate((20, 30, 40)).translate((1, 0, 0)))
    found = np.linalg.eigvalsh(link.mass_properties().inertia)
    expected = sorted(2.0 / 12 * np.array([0.2**2 + 0.4**2, 0.1**2 + 0.4**2, 0.1**2 + 0.2**2]))
    assert found == pytest.approx(expected)


def test_link_without_volume_or_of_unknown_material_is_refused() -> None:
    with pytest.raises(ValueError, match="ghost: its solids have no volume"):
        LinkModel("ghost", 1.0).mass_properties()
    with pytest.raises(ValueError, match="hat: no material 'felt'; there are hull"):
        LinkModel("hat", 1.0).add("felt", box((1, 1, 1)))


@pytest.mark.parametrize("end", ENDS)
def test_urdf_carries_the_mass_properties_of_the_solids(
    figures: Figures, robot: URDF, end: str
) -> None:
    expected = running_gear.flipper(figures, end, 440).mass_properties()
    for side in ("left", "right"):
        inertial = robot.link_map[f"{end}_{side}_flipper_link"].inertial
        assert inertial.mass == pytest.approx(figures.flipper["mass"])
        assert inertial.origin.xyz == pytest.approx(expected.centre, abs=1e-6)
        tensor = np.array(inertial.inertia.to_matrix())
        assert tensor == pytest.approx(expected.inertia, rel=1e-5, abs=2e-7)


def test_hull_is_heavy_low_and_makes_up_for_the_arm_beside_the_middle(robot: URDF) -> None:
    inertial = robot.link_map["base_link"].inertial
    assert inertial.mass == pytest.approx(33.0)
    x, y, z = inertial.origin.xyz
    assert abs(x) < 0.02
    assert 0.01 < y < 0.02
    assert z < 0.07


# ---- primitives


def test_primitives_have_the_sizes_that_they_are_given() -> None:
    assert box((0.1, 0.2, 0.3), bevel=0.0).volume() == pytest.approx(0.006)
    assert np.ptp(np.reshape(box((0.1, 0.2, 0.3)).bounding_box(), (2, 3)), axis=0) == pytest.approx(
        [0.1, 0.2, 0.3], abs=1e-6
    )
    tube = ring(0.05, 0.04, 0.10, "x", (1, 0, 0), 0.0, 256)
    assert tube.volume() == pytest.approx(math.pi * (0.05**2 - 0.04**2) * 0.10, rel=1e-3)
    assert volume_moments(tube)[1] / tube.volume() == pytest.approx([1, 0, 0], abs=1e-9)
    straight = hose([(0, 0, 0), (0.1, 0, 0), (0.2, 0, 0)], 0.01, 64)
    expected = math.pi * 0.01**2 * 0.2 + 4 / 3 * math.pi * 0.01**3
    assert straight.volume() == pytest.approx(expected, rel=0.02)
    corners = [(0, 0), (0, 1), (1, 1), (1, 0)]
    assert outline_of(corners).area() == outline_of(corners[::-1]).area() == pytest.approx(1)


def test_warning_stripes_cover_the_plate_from_end_to_end() -> None:
    plate, bars = warning_stripes(0.2, 0.03, 0.001, 0.04)
    found = np.reshape(bars.bounding_box(), (2, 3))
    assert found[:, [0, 2]] == pytest.approx(
        np.reshape(plate.bounding_box(), (2, 3))[:, [0, 2]], abs=1e-6
    )
    covered = bars.volume() / (bars.bounding_box()[4] - bars.bounding_box()[1]) / (0.2 * 0.03)
    assert covered == pytest.approx(0.5, abs=0.06)


# ---- flippers


@pytest.mark.parametrize("length", [360, 440, 520])
def test_flipper_hulls_are_the_belt_at_the_tips_of_its_cleats(
    figures: Figures, length: int
) -> None:
    meshes = PACKAGE / "meshes" / "collision"
    hub, tip = figures.flipper["hub_radius"], figures.flipper["tip_radius"]
    axle = np.array([math.sqrt((length / 1000) ** 2 - (hub - tip) ** 2), tip - hub])
    wheels = ((np.zeros(2), hub), (axle, tip))
    for number, (centre, radius) in enumerate(wheels, 1):
        vertices, _ = read_obj(meshes / f"flipper_front_{length}_{number}.obj")
        middle = vertices[abs(vertices[:, 1]) < 1e-5]
        assert len(middle) == figures.flipper["wheel_segments"]
        to_axle = np.hypot(*(middle[:, [0, 2]] - centre).T)
        assert to_axle == pytest.approx(radius, abs=2e-5)
        lowest = vertices[vertices[:, 2] < vertices[:, 2].min() + 2e-5]
        # One point that bears, below the wheel's axle and in the middle of the belt.
        assert lowest == pytest.approx(np.array([[centre[0], 0.0, -hub]]), abs=2e-5)
        assert np.ptp(vertices[:, 1]) == pytest.approx(figures.flipper["width"], abs=2e-5)
        rear, _ = read_obj(meshes / f"flipper_rear_{length}_{number}.obj")
        assert {tuple(v) for v in rear} == {(-x + 0.0, y, z) for x, y, z in vertices}
    runs, _ = read_obj(meshes / f"flipper_front_{length}_3.obj")
    lowest = runs[runs[:, 2] < runs[:, 2].min() + 2e-5]
    assert lowest == pytest.approx(np.array([[axle[0] / 2, 0.0, -hub]]), abs=2e-5)


def test_cleats_end_at_the_collision_hull(figures: Figures) -> None:
    model = running_gear.flipper(figures, "front", 440)
    solid = model.merged()["rubber"]
    points = np.asarray(solid.to_mesh64().vert_properties)[:, :3]
    outline = running_gear.BeltOutline(0.110, 0.070, 0.440)
    for inwards, inside in ((-0.001, True), (0.004, False)):
        section = Manifold.batch_hull(
            [
                Manifold.hull_points(
                    [(x, y, z) for x, z in outline.points(inwards, 90) for y in (-1, 1)]
                )
            ]
        )
        beyond = (solid - section).volume()
        assert (beyond < 1e-9) == inside
    assert np.abs(points[:, 1]).max() <= figures.flipper["width"] / 2 + 1e-6


def test_longer_flippers_weigh_more(figures: Figures) -> None:
    masses = [running_gear.flipper(figures, "front", length).mass for length in (360, 440, 520)]
    assert masses[1] == pytest.approx(figures.flipper["mass"])
    assert masses[0] < masses[1] < masses[2]
    assert masses[2] - masses[1] == pytest.approx(masses[1] - masses[0], rel=0.2)


def test_drive_wheel_turns_inside_its_flipper(figures: Figures) -> None:
    wheel = Manifold.compose(list(running_gear.track(figures).merged().values()))
    flipper = Manifold.compose(list(running_gear.flipper(figures, "front", 440).merged().values()))
    for angle in (0, 10, 25, 30):
        assert (wheel.rotate((0, angle, 0)) ^ flipper).volume() < 1e-9


# ---- cameras and lamps of the hull


@pytest.mark.parametrize(("camera", "seen_from"), [("front", 0.25), ("rear", 0.25), ("mast", 0.10)])
def test_hull_camera_sits_at_its_lens_and_does_not_see_its_housing(
    figures: Figures, robot: URDF, camera: str, seen_from: float
) -> None:
    (model,) = hull.links(figures)
    assembly = Assembly(robot, {"base_link": model})
    pose = assembly.frames({})[f"{camera}_camera_link"]
    solid, eye, forward = assembly.solids["base_link"], pose[:3, 3], pose[:3, 0]
    assert solid.ray_cast(tuple(eye), tuple(eye - 0.010 * forward))
    # Rays of a 90 x 74 degree view, up to where the rest of the robot may be seen
    for across in np.linspace(-1.0, 1.0, 9):
        for up in np.linspace(-0.75, 0.75, 7):
            ray = pose[:3, :3] @ [1.0, across, up]
            start, end = eye + 0.002 * ray, eye + seen_from * ray
            assert not solid.ray_cast(tuple(start), tuple(end)), (across, up)


@pytest.mark.parametrize("lamp", ["front_left", "front_right", "rear_left", "rear_right"])
def test_hull_lamp_frame_lies_on_its_light(figures: Figures, robot: URDF, lamp: str) -> None:
    (model,) = hull.links(figures)
    assembly = Assembly(robot, {"base_link": model})
    pose = assembly.frames({})[f"{lamp}_lamp_link"]
    eye, beam = pose[:3, 3], pose[:3, 0]
    light = model.merged()["lamp"]
    assert light.ray_cast(tuple(eye + 0.002 * beam), tuple(eye - 0.006 * beam))
    start, end = eye + 0.002 * beam, eye + 0.3 * beam
    assert not assembly.solids["base_link"].ray_cast(tuple(start), tuple(end))
