"""Belts that run."""

import math

import numpy as np
import pytest

from telex_control.common.geometry.matrices import pose_matrices
from telex_control.urdf.elements import UrdfError
from telex_sim.cameras.drawing.gl_context import create_context
from telex_sim.cameras.drawing.light.daylight import Lighting
from telex_sim.cameras.drawing.meshes.batching import VERTEX
from telex_sim.cameras.drawing.meshes.belts import (
    Riders,
    belt_outline,
    carried,
    subdivided,
    wheel_radius,
)
from telex_sim.cameras.drawing.quality import TIERS
from telex_sim.cameras.drawing.renderer import Renderer
from telex_sim.cameras.optics.pinhole import PinholeCamera
from telex_sim.cameras.preview.still import Still, looking
from telex_sim.robot.urdf.visuals import urdf_visuals
from telex_sim.scene.visual_scene import Daylight, Visual, VisualScene, VisualShape

RADIUS, LENGTH, WIDTH = 0.1, 0.4, 0.06
STATIONS = 64


def stadium(outwards):
    """Corners (x, z) around wheels at x = 0 and x = LENGTH."""
    angles = np.linspace(-math.pi / 2, math.pi / 2, STATIONS // 2)
    half = (RADIUS + outwards) * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return np.concatenate([half + np.array([LENGTH, 0.0]), -half])


def positions(outwards=0.0):
    flat = stadium(outwards)
    return np.array([(x, y, z) for x, z in flat for y in (-WIDTH / 2, WIDTH / 2)])


def belt_obj(path):
    """A band with one cleat, a box on top in the middle."""
    lines = [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in positions()]
    count = 2 * STATIONS
    for k in range(0, count, 2):
        a, b, c, d = (1 + (k + i) % count for i in range(4))
        lines.append(f"f {b} {a} {c} {d}")
    middle = LENGTH / 2
    corners = [
        (x, y, z)
        for z in (RADIUS, RADIUS + 0.03)
        for x, y in (
            (middle - 0.02, -0.03),
            (middle + 0.02, -0.03),
            (middle + 0.02, 0.03),
            (middle - 0.02, 0.03),
        )
    ]
    lines += [f"v {x} {y} {z}" for x, y, z in corners]
    faces = ((5, 6, 7, 8), (1, 2, 6, 5), (2, 3, 7, 6), (3, 4, 8, 7), (4, 1, 5, 8))
    lines += ["f " + " ".join(str(count + k) for k in face) for face in faces]
    path.write_text("\n".join(lines))


class TestOutline:
    def test_it_is_as_long_as_the_belt(self):
        outline = belt_outline(positions())
        assert outline.length == pytest.approx(2 * LENGTH + 2 * math.pi * RADIUS, rel=0.01)

    def test_the_wheel_drives_it_at_its_radius(self):
        outline = belt_outline(positions())
        assert wheel_radius(outline, np.zeros(2)) == pytest.approx(RADIUS, rel=0.01)

    def test_without_travel_everything_stays_where_it_is(self):
        points = positions(-0.01)
        outline = belt_outline(positions())
        there, _ = Riders(outline, carried(outline, points), points).at(0.0)
        assert there == pytest.approx(points, abs=1e-6)

    def test_the_top_runs_forwards_and_over_the_tip_downwards(self):
        outline = belt_outline(positions())
        point = np.array([[0.1, 0.0, RADIUS]])
        up = np.array([[0.0, 0.0, 1.0]])
        riders = Riders(outline, carried(outline, point), point, up)
        there, normal = riders.at(0.2)
        assert there[0] == pytest.approx((0.3, 0.0, RADIUS), abs=2e-3)
        assert normal[0] == pytest.approx((0.0, 0.0, 1.0), abs=0.02)
        # On by half of the wheel.
        there, normal = riders.at(0.3 + math.pi * RADIUS)
        assert there[0] == pytest.approx((LENGTH, 0.0, -RADIUS), abs=4e-3)
        assert normal[0] == pytest.approx((0.0, 0.0, -1.0), abs=0.1)

    def test_once_around_it_is_where_it_was(self):
        outline = belt_outline(positions())
        points = positions()
        there, _ = Riders(outline, carried(outline, points), points).at(-outline.length)
        assert there == pytest.approx(points, abs=1e-5)

    def test_a_sheet_is_no_belt(self):
        with pytest.raises(ValueError, match="flat"):
            belt_outline(np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0)], dtype=float))


def test_long_edges_are_halved_and_nothing_else_changes():
    vertices = np.zeros(4, dtype=VERTEX)
    vertices["position"] = [(0, 0, 0), (1, 0, 0), (1, 0, 0.01), (0, 0, 0.01)]
    vertices["normal"] = (0, -1, 0)
    fine, triangles = subdivided(vertices, np.array([(0, 1, 2), (0, 2, 3)], dtype=np.int32))
    corners = fine["position"][triangles].astype(float)
    edges = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
    assert edges.max() < 0.051
    areas = 0.5 * np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    assert areas.sum() == pytest.approx(0.01, rel=1e-4)
    # No edge inside belongs to one triangle only: no gap can open.
    points, place = np.unique(np.round(fine["position"], 6), axis=0, return_inverse=True)
    corner = place.reshape(-1)[triangles]
    pairs = np.sort(np.stack([corner, np.roll(corner, -1, axis=1)], axis=2).reshape(-1, 2))
    middles = points[pairs].mean(axis=1)
    _, first, counts = np.unique(pairs, axis=0, return_index=True, return_counts=True)
    x, z = middles[first[counts == 1]][:, 0], middles[first[counts == 1]][:, 2]
    on_the_rim = np.minimum.reduce([x, 1 - x, z, 0.01 - z]) < 1e-6
    assert on_the_rim.all()


@pytest.mark.parametrize(
    ("length", "height", "complaint"),
    [
        (400.0, 200.0, "extends over 400 m; 0.02 to 10 m is possible"),
        (0.0004, 0.0002, "extends over 0.0004 m"),
        (9.0, 9.0, "has .* triangles and .* vertices or more; 50000 of each are possible"),
    ],
)
def test_what_would_take_all_memory_is_no_belt(length, height, complaint):
    vertices = np.zeros(4, dtype=VERTEX)
    vertices["position"] = [(0, 0, 0), (length, 0, 0), (length, 0, height), (0, 0, height)]
    with pytest.raises(ValueError, match=complaint):
        subdivided(vertices, np.array([(0, 1, 2), (0, 2, 3)], dtype=np.int32))


def test_a_belt_in_another_unit_is_drawn_and_does_not_run(tmp_path):
    belt_obj(tmp_path / "belt.obj")
    belt = Visual(
        "flipper",
        VisualShape.MESH,
        (50.0, 50.0, 50.0),
        mesh=f"file://{tmp_path}/belt.obj",
        drive="wheel",
    )
    still = Still(TIERS["software"], Lighting(), lambda name: name)
    try:
        (problem,) = still.load(VisualScene(1, ("world", "flipper", "wheel"), (belt,)))
        assert "does not run: its mesh extends over 30 m" in problem
    finally:
        still.release()


def turned(angle):
    return (0.0, 0.0, 0.0, 0.0, math.sin(angle / 2), 0.0, math.cos(angle / 2))


def test_a_cleat_is_seen_to_run_with_the_wheel(tmp_path):
    belt_obj(tmp_path / "belt.obj")
    belt = Visual(
        "flipper",
        VisualShape.MESH,
        (1.0, 1.0, 1.0),
        mesh=f"file://{tmp_path}/belt.obj",
        drive="wheel",
    )
    still = Still(TIERS["software"], Lighting(), lambda name: name)
    try:
        daylight = Daylight(to_sun=(0.0, 1.0, 1.0))
        assert (
            still.load(VisualScene(1, ("world", "flipper", "wheel"), (belt,), (), daylight)) == []
        )
        camera = PinholeCamera(320, 240, 0.9, 0.05, 20.0)
        pose = looking((LENGTH / 2, -1.0, 0.2), (LENGTH / 2, 0.0, 0.1))

        def cleat(angle):
            """Columns of what stands out above the belt's upper run; it is darker than the sky."""
            frames = pose_matrices([turned(0.0), turned(0.0), turned(angle)])
            picture = still.picture(camera, pose, frames, (0.0, 0.0, 0.0)).astype(int)
            level = (np.linalg.inv(pose) @ [LENGTH / 2, 0.0, RADIUS + 0.02, 1.0])[:3]
            row = round(float(camera.project(level[None])[0, 1]))
            strip, sky = picture[row], picture[row, 0]
            return np.flatnonzero(np.abs(strip - sky).sum(axis=1) > 60).mean()

        rest, moving = cleat(0.0), cleat(0.5)
        per_metre = camera.focal_length / 1.0
        assert rest == pytest.approx(159.5, abs=3.0)
        assert moving - rest == pytest.approx(0.5 * RADIUS * per_metre, rel=0.15)
        # Turns are counted, so that a belt runs on beyond half a turn of its wheel.
        for angle in np.arange(0.5, -0.8, -0.2):
            back = cleat(angle)
        assert back < rest - 10
    finally:
        still.release()


def test_a_coarser_belt_runs_with_the_finer_one(tmp_path):
    belt_obj(tmp_path / "belt.obj")
    belt = Visual(
        "world", VisualShape.MESH, (1.0,) * 3, mesh=f"file://{tmp_path}/belt.obj", drive="wheel"
    )
    renderer = Renderer(create_context(), TIERS["software"], Lighting(), lambda name: name)
    camera = PinholeCamera(320, 240, 0.9, 0.05, 20.0)
    pose = looking((LENGTH / 2, -1.0, 0.2), (LENGTH / 2, 0.0, 0.1))
    try:
        assert renderer.load_scene(VisualScene(1, ("world", "wheel"), (belt,))) == []
        pictures = []
        for angle in (0.0, 0.5, 1.0):
            renderer.place(pose_matrices([turned(0.0), turned(angle)]), np.zeros(3))
            for coarse in (False, True):
                picture = renderer.render(camera, pose, coarse=coarse)
                pictures.append(picture[..., :3].astype(int))
    finally:
        renderer.release()

    def changed(a, b):
        return np.count_nonzero(np.abs(pictures[a] - pictures[b]).max(axis=2) > 40)

    # It is not the same mesh, but it is where the finer one is.
    assert (pictures[0] != pictures[1]).any()
    for fine in (0, 2, 4):
        assert changed(fine, fine + 1) < 0.3 * min(changed(0, 2), changed(2, 4))


LINK = '<link name="%s"/>'
JOINT = """<joint name="j%s" type="continuous"><parent link="flipper"/><child link="%s"/>
<axis xyz="0 1 0"/></joint>"""
FLIPPER = """<link name="flipper"><visual name="belt"><geometry>
<mesh filename="package://r/belt.obj"/></geometry></visual></link>"""


def test_the_belt_of_a_link_is_driven_by_its_wheel():
    text = "<robot name='r'>" + FLIPPER + LINK % "wheel" + JOINT % (1, "wheel") + "</robot>"
    (belt,) = urdf_visuals(text)
    assert belt.drive == "wheel"
    assert belt.mesh_materials


@pytest.mark.parametrize("wheels", [(), ("left", "right")])
def test_a_belt_without_its_one_wheel_is_refused(wheels):
    links = "".join(LINK % name + JOINT % (name, name) for name in wheels)
    with pytest.raises(UrdfError, match=f"link 'flipper' .* {len(wheels)} continuous"):
        urdf_visuals(f"<robot name='r'>{FLIPPER}{links}</robot>")
