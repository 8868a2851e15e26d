import math
import struct

import numpy as np
import pytest

from telex_sim.cameras.drawing.gl_context import create_context
from telex_sim.cameras.drawing.light.daylight import Lighting
from telex_sim.cameras.drawing.meshes.batching import VERTEX
from telex_sim.cameras.drawing.meshes.gpu_mesh import DETAILS, GpuMesh
from telex_sim.cameras.drawing.meshes.simplification import coarser, simplified
from telex_sim.cameras.drawing.programs import depth_program
from telex_sim.cameras.drawing.quality import TIERS
from telex_sim.cameras.drawing.renderer import Renderer
from telex_sim.cameras.optics.pinhole import PinholeCamera
from telex_sim.cameras.preview.still import looking
from telex_sim.scene.content_store import ContentStore
from telex_sim.scene.meshes import mesh_files
from telex_sim.scene.meshes.mesh_files import MeshFileError, load_mesh
from telex_sim.scene.meshes.meshes import (
    Mesh,
    box_mesh,
    cylinder_mesh,
    plane_mesh,
    rounded_box_mesh,
    sphere_mesh,
)
from telex_sim.scene.meshes.normals import mesh_from_corners
from telex_sim.scene.meshes.texture_mapping import box_mapped
from telex_sim.scene.visual_scene import Visual, VisualScene, VisualShape

CUBE = """
# a cube without normals
o cube
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
v 0 0 1
v 1 0 1
v 1 1 1
v 0 1 1
f 4 3 2 1
f 5 6 7 8
f 1 2 6 5
f 2 3 7 6
f 3 4 8 7
f 4 1 5 8
"""
TRIANGLE = np.array([[(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)]])


def corners_of(mesh):
    return mesh.positions[mesh.triangles].astype(float)


def volume_of(mesh):
    """Of a closed mesh; positive when its triangles are counter-clockwise from outside."""
    a, b, c = corners_of(mesh).transpose(1, 0, 2)
    return np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0


def assert_sound(mesh):
    np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1.0, atol=1e-5)
    corners = corners_of(mesh)
    faces = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert (np.linalg.norm(faces, axis=1) > 0.0).all()
    assert (np.einsum("tci,ti->tc", mesh.normals[mesh.triangles], faces) > 0.0).all()


def write(path, content):
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def binary_stl(corners, title=b"part"):
    facets = b"".join(struct.pack("<12fH", 0, 0, 0, *np.ravel(triangle), 0) for triangle in corners)
    return title.ljust(80, b"\0") + struct.pack("<I", len(corners)) + facets


def ascii_stl(corners):
    lines = ["solid part"]
    for triangle in corners:
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += ["vertex " + " ".join(map(str, point)) for point in triangle]
        lines += ["endloop", "endfacet"]
    return "\n".join([*lines, "endsolid part"])


class TestPrimitives:
    @pytest.mark.parametrize(
        ("mesh", "volume"),
        [
            (box_mesh((1.0, 2.0, 3.0)), 6.0),
            (rounded_box_mesh((1.0, 2.0, 3.0)), 6.0),
            (sphere_mesh(0.5), 4.0 / 3.0 * math.pi * 0.5**3),
            (sphere_mesh(0.002), 4.0 / 3.0 * math.pi * 0.002**3),
            (cylinder_mesh(0.2, 1.5), math.pi * 0.2**2 * 1.5),
        ],
    )
    def test_closed_with_the_outside_out(self, mesh, volume):
        assert_sound(mesh)
        # Facets lie within the round surface; small spheres have few.
        assert 0.75 * volume < volume_of(mesh) <= volume * 1.0001

    def test_extents(self):
        extents = np.ptp(rounded_box_mesh((1.0, 2.0, 3.0)).positions, axis=0)
        np.testing.assert_allclose(extents, (1.0, 2.0, 3.0))
        extents = np.ptp(box_mesh((1.0, 2.0, 3.0)).positions, axis=0)
        np.testing.assert_allclose(extents, [1.0, 2.0, 3.0], rtol=1e-6)
        extents = np.ptp(cylinder_mesh(0.2, 1.5).positions, axis=0)
        np.testing.assert_allclose(extents, [0.4, 0.4, 1.5], rtol=1e-2)

    def test_plane_faces_up(self):
        mesh = plane_mesh(4.0, 2.0)
        assert_sound(mesh)
        assert (mesh.normals == [0.0, 0.0, 1.0]).all()

    def test_mirroring_keeps_the_outside_out(self):
        mesh = sphere_mesh(0.5).scaled((-1.0, 2.0, 1.0))
        assert_sound(mesh)
        assert volume_of(mesh) == pytest.approx(2.0 * volume_of(sphere_mesh(0.5)), rel=1e-5)


class TestTextureMapping:
    @pytest.mark.parametrize("scale", [0.0, 0.5])
    @pytest.mark.parametrize(
        "make",
        [
            lambda scale: box_mapped(box_mesh((1.0, 2.0, 3.0)), np.zeros(3), scale),
            lambda scale: box_mapped(plane_mesh(1.0, 2.0), np.zeros(3), scale),
            lambda scale: cylinder_mesh(0.3, 1.0, scale),
            lambda scale: sphere_mesh(0.3, scale),
        ],
    )
    def test_nothing_is_mirrored(self, make, scale):
        mesh = make(scale)
        along = mesh.uvs[mesh.triangles].astype(float)
        turn = along[:, 1:] - along[:, :1]
        area = turn[:, 0, 0] * turn[:, 1, 1] - turn[:, 0, 1] * turn[:, 1, 0]
        assert (area > 0.0).all()

    def test_once_over_each_face_of_a_box(self):
        mesh = box_mapped(box_mesh((1.0, 2.0, 3.0)), np.zeros(3), 0.0)
        corners = {tuple(uv) for uv in mesh.uvs.tolist()}
        assert corners == {(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)}
        # On the four sides, the picture's top is the box's.
        sides = np.abs(mesh.normals[:, 2]) < 0.5
        np.testing.assert_allclose(mesh.uvs[sides, 1], mesh.positions[sides, 2] / 3.0 + 0.5)

    def test_in_metres_it_keeps_its_proportions(self):
        mesh = box_mapped(box_mesh((1.0, 2.0, 3.0)), np.zeros(3), 0.5)
        edges = np.diff(mesh.positions[mesh.triangles], axis=1).astype(float)
        turns = np.diff(mesh.uvs[mesh.triangles], axis=1).astype(float)
        np.testing.assert_allclose(
            np.linalg.norm(turns, axis=2), np.linalg.norm(edges, axis=2) / 0.5, rtol=1e-5
        )

    def test_neighbours_in_one_frame_continue_one_another(self):
        left, right = (
            box_mapped(box_mesh((1.0, 1.0, 1.0)), np.array([x, 0.0, 0.0]), 0.7) for x in (0.0, 1.0)
        )

        def on_top_edge(mesh, x):
            """Texture where the upper face ends."""
            rows = (mesh.normals[:, 2] > 0.5) & np.isclose(mesh.positions[:, 0], x)
            return sorted(mesh.uvs[rows].tolist())

        np.testing.assert_allclose(on_top_edge(left, 0.5), on_top_edge(right, -0.5), atol=1e-6)

    def test_round_a_cylinder_it_closes_without_a_seam(self):
        mesh = cylinder_mesh(0.29, 0.88, 0.5)
        side = np.abs(mesh.normals[:, 2]) < 0.5
        around = np.ptp(mesh.uvs[side, 0])
        assert around == round(2.0 * math.pi * 0.29 / 0.5)
        assert np.ptp(mesh.uvs[side, 1]) == pytest.approx(0.88 / 0.5)
        # A small one still gets the whole picture once.
        thin = cylinder_mesh(0.01, 0.5, 1.0)
        assert np.ptp(thin.uvs[np.abs(thin.normals[:, 2]) < 0.5, 0]) == 1.0

    def test_a_smooth_mesh_is_cut_where_it_turns_to_another_side(self):
        ball = sphere_mesh(0.5)
        mesh = box_mapped(ball, np.zeros(3), 0.25)
        assert len(mesh.triangles) == len(ball.triangles)
        assert len(mesh.positions) > len(ball.positions)
        turns = np.ptp(mesh.uvs[mesh.triangles], axis=1)
        edges = np.ptp(mesh.positions[mesh.triangles], axis=1).max(axis=1)
        # Nowhere does a triangle reach across the texture.
        assert (turns.max(axis=1) <= edges / 0.25 + 1e-5).all()


class TestSimplification:
    def test_a_box_stays_what_it_is(self):
        box = box_mesh((0.5, 0.3, 0.2))
        positions, triangles = simplified(box.positions, box.triangles, 0.01)
        assert (len(positions), len(triangles)) == (8, 12)
        mesh = Mesh(positions, positions, None, triangles)
        assert volume_of(mesh) == pytest.approx(0.03)

    def test_a_fine_mesh_becomes_coarse_and_keeps_its_form(self):
        ball = sphere_mesh(0.05)
        positions, triangles = simplified(ball.positions, ball.triangles, 0.02)
        assert len(triangles) < len(ball.triangles) / 2
        distances = np.linalg.norm(positions, axis=1)
        assert 0.05 - 0.02 * math.sqrt(3.0) < distances.min() <= distances.max() <= 0.0501
        # Its outside is still outside.
        mesh = Mesh(positions, positions, None, triangles)
        assert volume_of(mesh) > 0.6 * volume_of(ball)

    def test_without_a_grid_only_doubles_go(self):
        ball = sphere_mesh(0.05)
        positions, triangles = simplified(ball.positions, ball.triangles, 0.0)
        assert len(positions) == len(np.unique(ball.positions, axis=0))
        assert len(triangles) == len(ball.triangles)

    def test_what_is_smaller_than_a_cell_does_not_vanish(self):
        grain = box_mesh((0.001, 0.001, 0.001))
        _, triangles = simplified(grain.positions + 0.005, grain.triangles, 0.02)
        assert len(triangles) == 12


def vertices_of(mesh, color=(200, 0, 0, 0)):
    vertices = np.zeros(len(mesh.positions), VERTEX)
    vertices["position"], vertices["normal"] = mesh.positions, mesh.normals
    vertices["color"] = color
    return vertices


class TestCoarser:
    def test_a_box_keeps_its_edges(self):
        box = box_mesh((0.5, 0.3, 0.2))
        vertices, triangles = coarser(vertices_of(box), box.triangles, 0.01)
        assert (len(vertices), len(triangles)) == (24, 12)
        sides = np.abs(vertices["normal"]).max(axis=1)
        assert sides == pytest.approx(np.ones(24))

    def test_a_fine_mesh_becomes_coarse_and_has_no_gaps(self):
        ball = sphere_mesh(0.05)
        vertices, triangles = coarser(vertices_of(ball), ball.triangles, 0.02)
        assert len(triangles) < len(ball.triangles) / 2
        mesh = Mesh(vertices["position"], vertices["normal"], None, triangles)
        assert volume_of(mesh) > 0.6 * volume_of(ball)
        # Each edge has a triangle on both sides.
        _, corner = np.unique(vertices["position"], axis=0, return_inverse=True)
        edges = corner.reshape(-1)[triangles][:, [(0, 1), (1, 2), (2, 0)]].reshape(-1, 2)
        there, back = (set(map(tuple, each.tolist())) for each in (edges, edges[:, ::-1]))
        assert there == back
        outwards = vertices["position"] / np.linalg.norm(
            vertices["position"], axis=1, keepdims=True
        )
        assert np.einsum("ij,ij->i", outwards, vertices["normal"]).min() > 0.8

    def test_colours_stay_apart(self):
        ball = sphere_mesh(0.05)
        vertices = vertices_of(ball)
        vertices["color"][ball.positions[:, 2] > 0.0, 1] = 255
        colors = np.unique(coarser(vertices, ball.triangles, 0.02)[0]["color"], axis=0)
        assert colors.tolist() == [[200, 0, 0, 0], [200, 255, 0, 0]]

    def test_paint_stays_before_the_plate_that_it_lies_on(self):
        plate, paint = box_mesh((0.2, 0.0195, 0.1)), box_mesh((0.18, 0.0198, 0.04))
        ball = sphere_mesh(0.1)
        parts = [
            vertices_of(plate, (30, 30, 30, 0)),
            vertices_of(paint, (240, 130, 10, 0)),
            vertices_of(ball),
        ]
        parts[2]["position"] += (0.4, 0.0, 0.0)
        begins = np.cumsum([0, *(len(part) for part in parts)])
        triangles = np.concatenate(
            [mesh.triangles + begin for mesh, begin in zip((plate, paint, ball), begins.tolist())]
        )
        merged, left = coarser(np.concatenate(parts), triangles, 0.01)
        assert len(left) < len(triangles)
        faces = merged[left]
        towards = (faces["normal"][:, :, 1] > 0.9).all(axis=1)
        heights = {
            color: faces["position"][towards & (faces["color"][:, 0, 0] == color)][:, :, 1]
            for color in (30, 240)
        }
        assert heights[30] == pytest.approx(0.00975)
        assert heights[240] == pytest.approx(0.0099)

    def test_a_texture_that_goes_around_is_not_drawn_back_where_it_ends(self):
        drum = cylinder_mesh(0.3, 0.9)
        vertices = vertices_of(drum)
        vertices["uv"] = drum.uvs
        merged, triangles = coarser(vertices, drum.triangles, 0.09)
        assert len(triangles) < 0.7 * len(drum.triangles)
        # Along no triangle of the side does it run further than it did, but for the cells' width.
        side = np.abs(merged["normal"][triangles][:, :, 2]).max(axis=1) < 0.5
        runs = np.ptp(merged["uv"][triangles][side][:, :, 0], axis=1)
        assert runs.max() < 0.2

    def test_what_is_smaller_than_a_cell_does_not_vanish(self):
        grain = box_mesh((0.001, 0.001, 0.001))
        vertices = vertices_of(grain)
        vertices["position"] += 0.005
        assert len(coarser(vertices, grain.triangles, 0.02)[1]) == 12


class TestNormalsByAngle:
    def test_edges_of_a_box_stay_sharp(self):
        mesh = mesh_from_corners(corners_of(box_mesh((1.0, 1.0, 1.0))), None, None)
        assert_sound(mesh)
        assert len(mesh.positions) == 24
        assert np.isclose(np.abs(mesh.normals).max(axis=1), 1.0).all()

    def test_a_ball_is_round(self):
        ball = sphere_mesh(0.5)
        mesh = mesh_from_corners(corners_of(ball), None, None)
        # The seam of the texture is gone: vertices are shared all around.
        assert len(mesh.positions) < len(ball.positions)
        np.testing.assert_allclose(mesh.normals, mesh.positions / 0.5, atol=0.03)

    def test_a_disc_of_many_triangles_around_one_point(self):
        mesh = mesh_from_corners(corners_of(cylinder_mesh(1.0, 0.1)), None, None)
        assert_sound(mesh)

    def test_triangles_without_area_are_dropped(self):
        flat = np.zeros((1, 3, 3))
        mesh = mesh_from_corners(np.concatenate([TRIANGLE, flat]), None, None)
        assert len(mesh.triangles) == 1

    def test_useless_normals_of_a_file_are_replaced(self):
        normals = np.array([[(0.0, 0.0, 2.0), (0.0, 0.0, 0.0), (math.nan, 0.0, 0.0)]])
        mesh = mesh_from_corners(TRIANGLE, normals, None)
        np.testing.assert_allclose(mesh.normals, np.tile([0.0, 0.0, 1.0], (3, 1)))


class TestObj:
    def test_faces_of_more_than_three_corners(self, tmp_path):
        mesh = load_mesh(write(tmp_path / "cube.obj", CUBE))
        assert_sound(mesh)
        assert volume_of(mesh) == pytest.approx(1.0)
        assert mesh.uvs is None

    def test_own_normals_and_texture_coordinates(self, tmp_path):
        text = (
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nvn 0 0.6 0.8\nf 1/1/1 2/2/1 3/3/1"
        )
        mesh = load_mesh(write(tmp_path / "a.obj", text))
        np.testing.assert_allclose(mesh.normals, np.tile([0.0, 0.6, 0.8], (3, 1)), atol=1e-6)
        corners = dict(zip(map(tuple, mesh.positions), map(tuple, mesh.uvs)))
        assert corners[(1.0, 0.0, 0.0)] == (1.0, 0.0)

    @pytest.mark.parametrize("face", ["f -3 -2 -1", "f 1// 2// 3//", "f 1/ 2/ 3/", "f 1 \\\n2 3"])
    def test_ways_to_name_corners(self, tmp_path, face):
        mesh = load_mesh(write(tmp_path / "a.OBJ", f"v 0 0 0\nv 1 0 0\nv 0 1 0\n{face}\n"))
        np.testing.assert_allclose(mesh.normals[:, 2], 1.0)

    @pytest.mark.parametrize(
        ("text", "complaint"),
        [
            ("", "no face"),
            ("v 0 0 0\nv 1 0 0\nv 0 1 0\n", "no face"),
            ("v 0 0\n", "line 1: expected 3 numbers"),
            ("v 0 0 x\n", "line 1"),
            ("v 0 0 0\nv 1 0 0\nf 1 2\n", "line 3: a face needs 3"),
            ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "line 4: '4' refers to 4, of 3"),
            ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 0\n", "line 4"),
            ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf -4 2 1\n", "line 4"),
            ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/1 2/1 3/1\n", "line 4"),
            ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/// 2 3\n", "line 4"),
            ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf / 2 3\n", "line 4"),
            ("v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", "no triangle with an area"),
            ("v 0 0 0\nv 1 0 0\nv nan 1 0\nf 1 2 3\n", "not finite"),
        ],
    )
    def test_broken_files_are_named(self, tmp_path, text, complaint):
        path = write(tmp_path / "broken.obj", text)
        with pytest.raises(MeshFileError, match=rf"broken\.obj: .*{complaint}"):
            load_mesh(path)


class TestStl:
    @pytest.mark.parametrize("title", [b"part", b"solid part"])
    def test_binary(self, tmp_path, title):
        corners = corners_of(box_mesh((1.0, 2.0, 3.0)))
        mesh = load_mesh(write(tmp_path / "box.stl", binary_stl(corners, title)))
        assert_sound(mesh)
        assert volume_of(mesh) == pytest.approx(6.0)

    def test_text(self, tmp_path):
        corners = corners_of(box_mesh((1.0, 2.0, 3.0)))
        mesh = load_mesh(write(tmp_path / "box.STL", ascii_stl(corners)))
        assert_sound(mesh)
        assert volume_of(mesh) == pytest.approx(6.0)

    @pytest.mark.parametrize(
        ("content", "complaint"),
        [
            (b"", "less than a header"),
            (binary_stl(TRIANGLE)[:-1], "1 triangles take 134 bytes, the file has 133"),
            (binary_stl(TRIANGLE * math.nan), "not finite"),
            (binary_stl([]), "no triangle"),
            (b"solid part\nendsolid part", "0 vertices"),
            (b"solid part\nvertex 0 0 0\nvertex 1 0 0\n", "2 vertices"),
            (b"solid part\nvertex 0 0\n", "line 2: expected 3 numbers"),
        ],
    )
    def test_broken_files_are_named(self, tmp_path, content, complaint):
        path = write(tmp_path / "broken.stl", content)
        with pytest.raises(MeshFileError, match=rf"broken\.stl: .*{complaint}"):
            load_mesh(path)


def test_missing_file_is_named(tmp_path):
    with pytest.raises(MeshFileError, match=r"nowhere\.stl: No such file"):
        load_mesh(tmp_path / "nowhere.stl")


def test_unknown_kind_is_named(tmp_path):
    with pytest.raises(MeshFileError, match=r"a\.3ds: unknown kind .* \.obj or \.stl or \.dae"):
        load_mesh(write(tmp_path / "a.3ds", "4D4D"))


@pytest.mark.parametrize(
    ("name", "content", "complaint"),
    [
        ("a.obj", b"\x89PNG\r\n\x1a\n" + bytes(range(256)), "no face"),
        ("a.stl", b"\x89PNG\r\n\x1a\n" + bytes(range(256)), "triangles take"),
        ("a.obj", "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3", "not finite"),
        ("a.obj", "v 1e9 0 0\nv 0 0 0\nv 0 1e9 0\nf 1 2 3", "beyond 1e\\+06"),
        ("a.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3", "no triangle with an area"),
    ],
)
def test_what_is_no_mesh_is_refused(tmp_path, name, content, complaint):
    with pytest.raises(MeshFileError, match=rf"{name}: .*{complaint}"):
        load_mesh(write(tmp_path / name, content))


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("a.obj", CUBE),
        ("a.stl", binary_stl(np.repeat(TRIANGLE, 12, axis=0))),
        ("a.stl", ascii_stl(np.repeat(TRIANGLE, 12, axis=0))),
    ],
)
def test_too_many_triangles_are_refused(tmp_path, monkeypatch, name, content):
    monkeypatch.setattr(mesh_files, "MOST_TRIANGLES", 11)
    with pytest.raises(MeshFileError, match=rf"{name}: .*it has more than 11 triangles"):
        load_mesh(write(tmp_path / name, content))
    monkeypatch.setattr(mesh_files, "MOST_TRIANGLES", 12)
    assert load_mesh(write(tmp_path / name, content))


class TestDetail:
    """A ball without and one with a texture, side by side, drawn by a renderer."""

    CAMERA = PinholeCamera(320, 240, 1.2, 0.05, 60.0)

    @pytest.fixture
    def renderer(self):
        renderer = Renderer(create_context(), TIERS["software"], Lighting(), lambda name: name)
        yield renderer
        renderer.release()

    def pictures(self, renderer, distance, radius=0.3):
        """Fine and coarse, as numbers of either sign."""
        balls = [
            Visual("world", VisualShape.SPHERE, (radius, 0.0, 0.0), (0.0, y, 0.5), texture=texture)
            for y, texture in ((-1.2 * radius, ""), (1.2 * radius, "generated:checker"))
        ]
        assert renderer.load_scene(VisualScene(1, ("world",), tuple(balls))) == []
        renderer.place(np.eye(4)[None], np.zeros(3))
        pose = looking((-distance, 0.0, 0.55), (0.0, 0.0, 0.5))
        return [
            renderer.render(self.CAMERA, pose, coarse=coarse)[..., :3].astype(int)
            for coarse in (False, True)
        ]

    def test_a_texture_that_is_seen_from_near_is_not_pulled_about(self, renderer):
        fine, coarse = self.pictures(renderer, 0.3, radius=0.05)
        changed = np.abs(fine - coarse).max(axis=2) > 2
        assert changed[:, 160:].any()
        assert not changed[:, :160].any()

    @pytest.mark.parametrize("distance", [4.0, 10.0, 25.0])
    def test_what_is_far_away_looks_alike_with_fewer_triangles(self, renderer, distance):
        fine, coarse = self.pictures(renderer, distance)
        off = np.abs(fine - coarse).max(axis=2)
        balls = 2.0 * math.pi * (0.3 * self.CAMERA.focal_length / distance) ** 2
        assert off.any()
        # No more than their rims, by half a pixel or two.
        assert (off > 40).sum() < max(0.2 * balls, 12)

    def test_each_detail_has_fewer_triangles(self):
        context = create_context()
        ball = sphere_mesh(0.5)
        mesh = GpuMesh(context, vertices_of(ball), ball.triangles, 0.0, ContentStore())
        program = depth_program(context)
        counts = [mesh.array(program, detail).vertices for detail in range(len(DETAILS) + 1)]
        assert counts == sorted(counts, reverse=True)
        assert counts[-1] < 0.5 * counts[0]
        mesh.release()
        context.release()
