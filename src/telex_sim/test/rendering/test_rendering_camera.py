import math

import numpy as np
import pytest

from telex_control.common.geometry.matrices import pose_matrices
from telex_sim.cameras.drawing.culling import (
    Cones,
    boxes_in_view,
    cones_in_view,
    spheres_in_cones,
    spheres_in_view,
    spheres_in_world,
)
from telex_sim.cameras.drawing.gl_context import NEEDED_PACKAGES, NoContextError, create_context
from telex_sim.cameras.drawing.light.daylight import sun_view
from telex_sim.cameras.drawing.quality import TIERS, choose_quality
from telex_sim.cameras.optics.pinhole import PinholeCamera

CAMERA = PinholeCamera(640, 480, 1.2, 0.1, 50.0)


class TestPinholeCamera:
    def test_field_of_view_ends_at_the_outer_edges_of_the_pixels(self):
        edge = math.tan(0.6)
        ((left, _), (right, _)) = CAMERA.project([(-edge, 0.0, 1.0), (edge, 0.0, 1.0)])
        assert left == pytest.approx(-0.5)
        assert right == pytest.approx(639.5)

    def test_optical_axis_goes_through_the_middle(self):
        np.testing.assert_allclose(CAMERA.project([(0.0, 0.0, 7.0)]), [(319.5, 239.5)])

    def test_clip_coordinates_agree_with_the_intrinsics(self):
        points = np.array([(0.3, -0.2, 1.0), (-1.0, 2.0, 9.0), (0.0, 0.0, 0.2)])
        clip = np.column_stack([points, np.ones(3)]) @ CAMERA.clip_from_optical().T
        ndc = clip[:, :2] / clip[:, 3:]
        pixels = (ndc + 1.0) * [320.0, 240.0] - 0.5
        np.testing.assert_allclose(pixels, CAMERA.project(points), atol=1e-9)

    def test_depth_range(self):
        for distance, depth in ((0.1, -1.0), (50.0, 1.0)):
            clip = CAMERA.clip_from_optical() @ [0.0, 0.0, distance, 1.0]
            assert clip[2] / clip[3] == pytest.approx(depth)


class TestCulling:
    def test_drops_what_a_camera_stands_at_and_looks_away_from(self):
        # A flat body, whose sphere the camera is in; turned about, it reaches into the view.
        centers, halves = np.tile((0.0, 0.0, -0.2), (2, 1)), np.tile((0.5, 0.5, 0.15), (2, 1))
        axes = np.stack([np.eye(3), np.eye(3)[[2, 1, 0]]])
        clip = CAMERA.clip_from_optical()
        assert spheres_in_view(clip, centers, np.linalg.norm(halves, axis=1)).all()
        assert boxes_in_view(clip, centers, axes, halves).tolist() == [False, True]

    def test_keeps_every_box_of_which_something_is_in_the_view(self):
        generator = np.random.default_rng(3)
        poses = np.column_stack(
            [generator.uniform(-4.0, 4.0, (400, 3)), generator.normal(size=(400, 4))]
        )
        poses[:, 3:] /= np.linalg.norm(poses[:, 3:], axis=1, keepdims=True)
        boxes, halves = pose_matrices(poses), generator.uniform(0.01, 1.0, (400, 3))
        inside = generator.uniform(-1.0, 1.0, (400, 300, 3)) * halves[:, None]
        points = np.einsum("nij,npj->npi", boxes[:, :3, :3], inside) + boxes[:, None, :3, 3]
        clip = CAMERA.clip_from_optical()
        at = points @ clip[:, :3].T + clip[:, 3]
        visible = (np.abs(at[..., :3]) <= at[..., 3:]).all(axis=2).any(axis=1)
        kept = boxes_in_view(clip, boxes[:, :3, 3], boxes[:, :3, :3], halves)
        assert kept[visible].all()
        assert visible.sum() < kept.sum() < 200

    def test_keeps_what_touches_the_view_and_drops_the_rest(self):
        edge = math.tan(0.6)
        centers = np.array(
            [
                (0.0, 0.0, 5.0),
                (0.0, 0.0, -5.0),
                (0.0, 0.0, -0.5),
                (edge * 5.0 + 0.5, 0.0, 5.0),
                (edge * 5.0 + 2.0, 0.0, 5.0),
                (0.0, -30.0, 5.0),
                (0.0, 0.0, 50.5),
                (0.0, 0.0, 52.0),
            ]
        )
        seen = spheres_in_view(CAMERA.clip_from_optical(), centers, np.full(8, 1.0))
        assert seen.tolist() == [True, False, True, True, False, False, True, False]

    def test_never_drops_a_sphere_with_a_visible_point(self):
        generator = np.random.default_rng(7)
        clip = CAMERA.clip_from_optical()
        centers = generator.uniform(-20.0, 20.0, (500, 3))
        radii = generator.uniform(0.1, 4.0, 500)
        directions = generator.normal(size=(400, 3))
        directions /= np.linalg.norm(directions, axis=1, keepdims=True)
        points = centers[:, None] + radii[:, None, None] * directions
        clipped = np.concatenate([points, np.ones((500, 400, 1))], axis=2) @ clip.T
        visible = (np.abs(clipped[..., :3]) < clipped[..., 3:]).all(axis=2).any(axis=1)
        assert visible.sum() > 50
        assert spheres_in_view(clip, centers, radii)[visible].all()

    def test_cones_that_point_away_from_the_view_are_dropped_whatever_their_reach(self):
        axes = np.array([(0.0, 0.0, -1.0), (0.0, 0.0, 1.0), (-1.0, 0.0, 0.0), (0.0, 0.0, -1.0)])
        tips = np.array([(0.0, 0.0, -0.2), (0.0, 0.0, -0.2), (-2.0, 0.0, 1.0), (0.0, 0.0, -0.2)])
        cones = Cones(tips, axes, np.array([1.2, 1.2, 0.5, math.pi]), np.full(4, 30.0))
        seen = cones_in_view(CAMERA.clip_from_optical(), cones)
        assert seen.tolist() == [False, True, False, True]

    def test_never_drops_a_cone_or_a_sphere_that_shares_a_point(self):
        generator = np.random.default_rng(3)
        tips = generator.uniform(-6.0, 6.0, (120, 3))
        axes = generator.normal(size=(120, 3))
        axes /= np.linalg.norm(axes, axis=1, keepdims=True)
        half_angles = generator.uniform(0.1, math.pi, 120)
        cones = Cones(tips, axes, half_angles, generator.uniform(0.5, 8.0, 120))
        directions = generator.normal(size=(600, 3))
        directions /= np.linalg.norm(directions, axis=1, keepdims=True)
        directions *= generator.uniform(0.0, 1.0, (600, 1)) ** (1.0 / 3.0)
        offsets = cones.reaches[:, None, None] * directions
        lengths = np.linalg.norm(offsets, axis=2)
        lit = np.einsum("nki,ni->nk", offsets, axes) >= np.cos(half_angles)[:, None] * lengths
        points = tips[:, None] + offsets

        clip = CAMERA.clip_from_optical()
        clipped = np.concatenate([points, np.ones((120, 600, 1))], axis=2) @ clip.T
        visible = lit & (np.abs(clipped[..., :3]) < clipped[..., 3:]).all(axis=2)
        kept = cones_in_view(clip, cones)
        assert visible.any(axis=1).sum() > 15
        assert kept[visible.any(axis=1)].all()
        assert (~kept).sum() > 15

        centers, radii = generator.uniform(-8.0, 8.0, (25, 3)), generator.uniform(0.05, 1.0, 25)
        kept = spheres_in_cones(centers, radii, cones)
        for number in range(25):
            inside = lit & (np.linalg.norm(points - centers[number], axis=2) < radii[number])
            assert kept[number][inside.any(axis=1)].all()
        assert 0.05 < kept.mean() < 0.5

    def test_a_sphere_beside_or_beyond_a_cone_is_not_in_it(self):
        cones = Cones(np.zeros((1, 3)), np.array([(1.0, 0.0, 0.0)]), np.array([0.5]), np.array([4]))
        beside = 2.0 * np.array([math.cos(0.7), math.sin(0.7), 0.0])
        # Of its edge it is 2 sin 0.2 = 0.397 m off.
        for center, radius, inside in (
            (beside, 0.39, False),
            (beside, 0.41, True),
            ((5.0, 0.0, 0.0), 0.9, False),
            ((5.0, 0.0, 0.0), 1.1, True),
            ((-1.0, 0.0, 0.0), 0.9, False),
        ):
            kept = spheres_in_cones(np.array([center]), np.array([radius]), cones)
            assert kept.tolist() == [[inside]]

    def test_spheres_move_with_their_visuals(self):
        half = math.sqrt(0.5)
        model = pose_matrices([[1.0, 0.0, 0.0, 0.0, 0.0, half, half]])
        moved = spheres_in_world(model, np.array([(2.0, 0.0, 0.0)]))
        np.testing.assert_allclose(moved, [(1.0, 2.0, 0.0)], atol=1e-12)


class TestSunView:
    to_sun = (-1.0, 0.5, 2.0)
    centers = np.array([(0.0, 0.0, 1.0), (100.0, 0.0, 1.0)])
    radii = np.array([0.5, 0.5])

    def view(self, focus):
        return sun_view(self.to_sun, 3.0, 100, np.array(focus), self.centers, self.radii)

    def project(self, view, point):
        return (view.clip_from_world @ [*point, 1.0])[:3]

    def test_points_along_a_ray_fall_together(self):
        view = self.view((0.0, 0.0, 0.0))
        high = self.project(view, (0.0, 0.0, 1.0))
        low = self.project(view, np.array([0.0, 0.0, 1.0]) - self.to_sun)
        np.testing.assert_allclose(high[:2], low[:2], atol=1e-9)
        assert high[2] < low[2]

    def test_casters_over_the_map_lie_within_its_depths(self):
        view = self.view((0.0, 0.0, 0.0))
        to_sun = np.array(self.to_sun) / np.linalg.norm(self.to_sun)
        assert self.project(view, self.centers[0] + 0.5 * to_sun)[2] == pytest.approx(-1.0)
        assert self.project(view, self.centers[0] - 0.5 * to_sun)[2] == pytest.approx(1.0)

    def test_follows_its_focus_by_whole_pixels(self):
        still = np.array([0.3, 0.2, 0.1])
        here = self.project(self.view((0.0, 0.0, 0.0)), still)[:2]
        there = self.project(self.view((1.0, 0.37, 0.0)), still)[:2]
        pixels = (here - there) * 50.0
        assert np.abs(pixels).max() > 5.0
        np.testing.assert_allclose(pixels, np.round(pixels), atol=1e-6)

    @pytest.mark.parametrize("to_sun", [(0.0, 0.0, 1.0), (0.0, 0.0, -1.0), (1.0, 0.0, 0.0)])
    def test_any_direction_of_the_sun(self, to_sun):
        view = sun_view(to_sun, 4.0, 64, np.zeros(3), np.zeros((0, 3)), np.zeros(0))
        axes = view.clip_from_world[:3, :3]
        gram = axes @ axes.T
        np.testing.assert_allclose(gram, np.diag(np.diag(gram)), atol=1e-12)
        assert np.linalg.det(axes) > 0.0


class TestQuality:
    @pytest.mark.parametrize(
        ("renderer", "tier"),
        [
            ("llvmpipe (LLVM 15.0.6, 256 bits)", "software"),
            ("softpipe", "software"),
            ("SWR (LLVM 12)", "software"),
            ("NVIDIA GeForce RTX 3060/PCIe/SSE2", "gpu"),
            ("Mesa Intel(R) UHD Graphics 620 (KBL GT2)", "gpu"),
        ],
    )
    def test_chosen_by_what_renders(self, renderer, tier):
        assert choose_quality("auto", renderer) is TIERS[tier]

    def test_chosen_by_name(self):
        assert choose_quality("gpu", "llvmpipe") is TIERS["gpu"]

    def test_unknown(self):
        with pytest.raises(ValueError, match="'ultra' is unknown, expected auto, software or gpu"):
            choose_quality("ultra", "llvmpipe")


def test_without_a_device_the_error_says_what_to_install():
    with pytest.raises(NoContextError, match=f"device 99 .*apt-get install {NEEDED_PACKAGES}"):
        create_context(99)
