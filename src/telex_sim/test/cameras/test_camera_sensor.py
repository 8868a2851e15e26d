"""What cameras show is what sensor_msgs/CameraInfo says that they show."""

from __future__ import annotations

import math
import os
import tracemalloc
from dataclasses import replace

import cv2
import numpy as np
import pytest
import rospkg
from std_msgs.msg import Header

from telex_sim.cameras.cameras_config import CameraConfig, OverviewConfig, ViewConfig
from telex_sim.cameras.drawing.gl_context import create_context
from telex_sim.cameras.drawing.light.daylight import Lighting
from telex_sim.cameras.drawing.quality import TIERS
from telex_sim.cameras.drawing.renderer import Renderer
from telex_sim.cameras.optics.camera_sensor import CameraSensor
from telex_sim.cameras.optics.exposure import ExposureConfig, ExposureControl, exposure_factor
from telex_sim.cameras.optics.lens import (
    NO_DISTORTION,
    DistortionError,
    LensCamera,
    LensMap,
    bending_threads,
)
from telex_sim.cameras.optics.noise import RadiationConfig, SensorNoise
from telex_sim.cameras.ros.messages import camera_info_message
from telex_sim.cameras.ros.overview_rig import OverviewRig
from telex_sim.scene.visual_scene import Daylight, Visual, VisualScene, VisualShape

pytestmark = pytest.mark.slow

SECOND = 10**9
BARREL = (-0.12, 0.02, 0.002, -0.003, 0.0)
CONFIG = CameraConfig(640, 480, 1.5708, distortion=BARREL, zoom_max=4.0, frame="optical")
NIGHT = Daylight(sun=(0.0, 0.0, 0.0), ambient=0.0)
POSE = np.eye(4)


@pytest.fixture(scope="module")
def renderer():
    renderer = Renderer(create_context(), TIERS["software"], Lighting(), rospkg.RosPack().get_path)
    yield renderer
    renderer.release()


def show(renderer, *visuals, daylight=None):
    """Put shapes into the camera's own frame: x right, y down, z forward."""
    problems = renderer.load_scene(
        VisualScene(1, ("world",), visuals, daylight=daylight or Daylight())
    )
    assert problems == []
    renderer.place(np.eye(4)[None], np.zeros(3))


def ball(point, radius=0.03):
    black = (0.0, 0.0, 0.0, 1.0)
    return Visual(
        "world", VisualShape.SPHERE, (radius, 0.0, 0.0), position=tuple(point), color=black
    )


def sensor(config=CONFIG, zoom=1.0):
    return CameraSensor(config, zoom, 7, ExposureControl())


def take(renderer, camera, stamp=SECOND):
    ev = camera.expose(stamp)
    picture = renderer.render(camera.pinhole, POSE, exposure_factor(ev))
    return camera.develop([picture], renderer.repeats, ev, stamp)


def balls_in(picture):
    """Middles of all black spots before the sky (u, v)."""
    black = (picture[..., 1] < 0.5 * np.median(picture[..., 1])).astype(np.uint8)
    return cv2.connectedComponentsWithStats(black)[3][1:]


def predicted(info, points):
    """What somebody computes who knows nothing but the message."""
    pixels, _ = cv2.projectPoints(
        np.asarray(points, dtype=float),
        np.zeros(3),
        np.zeros(3),
        np.reshape(info.K, (3, 3)),
        np.array(info.D),
    )
    return pixels.reshape(-1, 2)


def spread(camera, distances=(1.5, 2.0, 3.0)):
    """Points all over the picture of a camera, to near its edges."""
    pixels = [(u, v) for u in np.linspace(12, 627, 6) for v in np.linspace(12, 467, 5)]
    depths = np.resize(distances, len(pixels))
    rays = np.column_stack([camera.rays(pixels), np.ones(len(pixels))])
    return rays * depths[:, None]


class TestProjection:
    @pytest.mark.parametrize(
        ("distortion", "zoom", "detail"),
        [
            (BARREL, 1.0, 1.0),
            (BARREL, 1.0, 0.8),
            (BARREL, 2.5, 1.0),
            ((0.05, -0.01, 0.0, 0.0, 0.0), 1.0, 1.0),
            ((0.0,) * 5, 1.0, 1.0),
            ((0.0,) * 5, 1.0, 0.7),
        ],
    )
    def test_points_are_where_camera_info_says(self, renderer, distortion, zoom, detail):
        camera = sensor(replace(CONFIG, distortion=distortion, detail=detail), zoom)
        points = spread(camera.camera)
        show(renderer, *(ball(point, 0.012 * point[2] / zoom) for point in points))
        seen = balls_in(take(renderer, camera))
        wanted = predicted(camera_info_message(camera.camera, Header()), points)
        assert len(seen) == len(wanted)
        gaps = np.linalg.norm(seen[:, None] - wanted[None], axis=2).min(axis=0)
        assert gaps.max() < 1.0

    def test_distortion_matters_in_these_tests(self):
        points = spread(sensor().camera)
        straight = replace(sensor().camera, distortion=(0.0,) * 5).project(points)
        assert np.abs(straight - sensor().camera.project(points)).max() > 20.0

    def test_no_pixel_is_left_empty(self, renderer):
        red = (0.9, 0.1, 0.1, 1.0)
        wall = Visual("world", VisualShape.BOX, (200.0, 200.0, 0.1), (0.0, 0.0, 10.0), color=red)
        show(renderer, wall, daylight=Daylight(to_sun=(0.0, 0.0, -1.0)))
        picture = take(renderer, sensor())
        assert picture.shape == (480, 640, 4)
        assert picture[..., 0].min() > 100
        # The sky is blue.
        assert (picture[..., 0] > picture[..., 2]).all()


class TestDepth:
    def test_is_along_the_optical_axis(self, renderer):
        """A wall square to the axis has one depth, however far its corners are."""
        wall = Visual("world", VisualShape.BOX, (30.0, 30.0, 0.2), (0.0, 0.0, 4.1))
        show(renderer, wall)
        camera = sensor()
        take(renderer, camera)
        depth = camera.depth(renderer.depth(camera.pinhole))
        assert depth.shape == (480, 640)
        assert depth.dtype == np.float32
        np.testing.assert_allclose(depth, 4.0, atol=0.01)

    def test_edges_are_where_camera_info_says_and_behind_them_is_nothing(self, renderer):
        box = Visual("world", VisualShape.BOX, (0.6, 0.4, 0.2), (0.9, -0.5, 2.1))
        show(renderer, box)
        camera = sensor()
        take(renderer, camera)
        seen = np.isfinite(camera.depth(renderer.depth(camera.pinhole)))
        corners = [(x, y, 2.0) for x in (0.6, 1.2) for y in (-0.7, -0.3)]
        pixels = predicted(camera_info_message(camera.camera, Header()), corners)
        for (u, v), (x, y) in zip(pixels, ((-1, -1), (-1, 1), (1, -1), (1, 1))):
            # The inner side of the box shows as well; its outer one ends at the corner.
            inside = seen[int(v - 4 * y), int(u - 4 * x)]
            beyond = seen[int(v + (4 if y > 0 else -4)), int(u + 4 * x)]
            assert inside
            assert not beyond or x < 0
        assert not seen[240, 100]

    def test_nothing_lies_between_near_and_far(self, renderer):
        near = Visual("world", VisualShape.BOX, (0.5, 20.0, 0.2), (-0.75, 0.0, 2.1))
        far = Visual("world", VisualShape.BOX, (40.0, 40.0, 0.2), (0.0, 0.0, 8.1))
        show(renderer, near, far)
        camera = sensor()
        take(renderer, camera)
        depth = camera.depth(renderer.depth(camera.pinhole))
        either = (np.abs(depth - 2.0) < 0.02) | (np.abs(depth - 8.0) < 0.1)
        # The box's own side is in between.
        assert either.mean() > 0.97
        assert (depth < 3.0).any()


class TestLens:
    def test_rays_are_the_inverse_of_the_projection(self):
        camera = LensCamera.of_field(640, 480, 1.5708, BARREL, 0.1, 50.0)
        pixels = np.random.default_rng(3).uniform((-0.5, -0.5), (639.5, 479.5), (500, 2))
        rays = np.column_stack([camera.rays(pixels), np.ones(500)])
        np.testing.assert_allclose(camera.project(rays), pixels, atol=1e-3)

    def test_zoom_narrows_the_field(self):
        wide, narrow = CONFIG.optics(), CONFIG.optics(4.0)
        assert narrow.focal_length == pytest.approx(4.0 * wide.focal_length)
        assert narrow.field()[0] < 0.3 * wide.field()[0]

    def test_detail_is_what_is_drawn(self):
        full, half = (LensMap(CONFIG.optics(), detail).pinhole for detail in (1.0, 0.5))
        assert half.width == pytest.approx(0.5 * full.width, abs=4)
        assert half.focal_length == pytest.approx(0.5 * full.focal_length)

    def test_without_distortion_pictures_stay_as_they_are(self):
        lens = LensMap(replace(CONFIG, distortion=(0.0,) * 5).optics(), 1.0)
        picture = np.zeros((480, 640, 4), np.uint8)
        assert lens.bend(picture) is picture
        assert (lens.pinhole.width, lens.pinhole.height) == (640, 480)

    @pytest.mark.parametrize("detail", [0.1, 0.35, 0.6, 0.85, 1.3])
    @pytest.mark.parametrize("size", [(640, 480), (101, 67), (75, 150), (333, 16), (97, 31)])
    def test_every_pixel_has_a_depth_whatever_the_detail(self, size, detail):
        camera = LensCamera.of_field(*size, 1.2, NO_DISTORTION, 0.1, 50.0)
        lens = LensMap(camera, detail)
        assert lens.pinhole.height >= size[1] * lens.pinhole.width / size[0]
        depth = np.full((lens.pinhole.height, lens.pinhole.width), 3.0, np.float32)
        assert (lens.bend_depth(depth) == 3.0).all()

    @pytest.mark.parametrize("distortion", [(-0.5, 0.0, 0.0, 0.0, 0.0), (9.0,) * 5])
    def test_what_no_lens_can_do(self, distortion):
        with pytest.raises(DistortionError, match=r"^distortion \["):
            LensCamera.of_field(640, 480, 1.5708, distortion, 0.1, 50.0)

    @pytest.mark.parametrize(
        ("on_card", "processors", "threads"),
        [(False, 16, 1), (True, 1, 1), (True, 2, 1), (True, 4, 2), (True, 16, 4)],
    )
    def test_several_threads_bend_pictures_where_a_graphics_card_draws(
        self, monkeypatch, on_card, processors, threads
    ):
        monkeypatch.setattr(os, "sched_getaffinity", lambda _: set(range(processors)))
        assert bending_threads(on_card) == threads


class TestExposure:
    auto = ExposureConfig(auto=True, min_ev=-3.0, max_ev=2.0, time_constant=0.5)

    def gray(self, value):
        return np.full((64, 64, 4), value, np.uint8)

    def test_by_hand_is_what_is_asked_for(self):
        control = ExposureControl()
        control.expose(self.auto, 0)
        control.meter(self.gray(250))
        assert control.expose(ExposureConfig(ev=1.5), SECOND) == 1.5

    @pytest.mark.parametrize("size", [(64, 64), (2, 4), (64, 1)])
    @pytest.mark.parametrize(("value", "end"), [(255, -3.0), (0, 2.0)])
    def test_follows_the_light_as_far_as_it_may(self, value, end, size):
        control, gray = ExposureControl(), np.full((*size, 4), value, np.uint8)
        for step in range(100):
            ev = control.expose(self.auto, step * SECOND // 10)
            control.meter(gray)
        assert ev == pytest.approx(end, abs=1e-3)

    def test_makes_up_for_a_change_in_its_time(self):
        control = ExposureControl()
        control.expose(self.auto, 0)
        control.meter(self.gray(0))
        assert control.expose(self.auto, SECOND // 2) == pytest.approx(2.0 * (1.0 - math.exp(-1)))

    def test_time_that_stands_still_or_jumps_back_changes_nothing(self):
        control = ExposureControl()
        control.expose(self.auto, SECOND)
        control.meter(self.gray(0))
        assert control.expose(self.auto, SECOND) == control.expose(self.auto, 0) == 0.0

    def test_settles_at_a_medium_brightness(self, renderer):
        wall = Visual("world", VisualShape.BOX, (200.0, 200.0, 0.1), (0.0, 0.0, 10.0), glow=1.0)
        config = replace(CONFIG, exposure=replace(self.auto, min_ev=-8.0, max_ev=8.0))
        shown = []
        for color in ((0.2, 0.2, 0.2, 1.0), (0.9, 0.9, 0.9, 1.0)):
            show(renderer, replace(wall, color=color), daylight=NIGHT)
            camera = sensor(config)
            for step in range(16):
                picture = take(renderer, camera, step * SECOND // 4)
            shown.append(float(picture[..., 1].mean()))
        assert shown == pytest.approx([135.0, 135.0], abs=8.0)


class TestNoise:
    def grain(self, strength, stamp=SECOND, seed=7):
        picture = np.full((480, 640, 4), 128, np.uint8)
        SensorNoise(640, 480, seed).add(picture, strength, stamp)
        return picture[..., :3].astype(float) - 128.0

    def test_is_as_strong_as_asked_for_and_has_no_mean(self):
        for strength in (1.0, 4.0):
            grain = self.grain(strength)
            assert grain.std() == pytest.approx(strength, rel=0.1)
            assert abs(grain.mean()) < 0.02

    def test_is_the_same_for_the_same_seed_and_stamp_alone(self):
        first = self.grain(4.0)
        assert (first == self.grain(4.0)).all()
        for other in (self.grain(4.0, stamp=2 * SECOND), self.grain(4.0, seed=8)):
            correlation = (first * other).mean() / first.var()
            assert abs(correlation) < 0.02

    def test_is_at_most_as_strong_as_a_picture_is_bright(self):
        assert (self.grain(4000.0) == self.grain(255.0)).all()

    def test_memory_does_not_grow_with_the_strengths(self):
        noise, picture = SensorNoise(64, 48, 7), np.zeros((48, 64, 4), np.uint8)

        def use(strengths):
            for strength in strengths:
                noise.add(picture, float(strength), SECOND)
            return tracemalloc.get_traced_memory()[0]

        tracemalloc.start()
        try:
            before = use(range(1, 11))
            grown = use(range(11, 200)) - before
        finally:
            tracemalloc.stop()
        assert grown < 100_000

    def test_none_by_default(self, renderer):
        show(renderer, ball((0.0, 0.0, 2.0)))
        camera = sensor()
        assert (take(renderer, camera, 1).copy() == take(renderer, camera, 2)).all()

    def test_grows_with_the_exposure(self, renderer):
        show(renderer, daylight=NIGHT)
        noisy = [
            take(renderer, sensor(replace(CONFIG, noise=4.0, exposure=ExposureConfig(ev=ev))))
            for ev in (0.0, 2.0)
        ]
        dark, amplified = (picture[..., :3].astype(float).std() for picture in noisy)
        assert amplified == pytest.approx(2.0 * dark, rel=0.1)


class TestRadiation:
    def dots(self, config, stamp=SECOND, noise=None):
        picture = np.zeros((480, 640, 4), np.uint8)
        (noise or SensorNoise(640, 480, 7)).irradiate(picture, config, stamp)
        return picture[..., :3].max(axis=2) > 0

    def test_dots_come_and_go_with_the_dose_rate(self):
        noise = SensorNoise(640, 480, 7)
        counts = {}
        for rate in (10.0, 100.0):
            config = RadiationConfig(dose_rate=rate, dots=30.0)
            pictures = [self.dots(config, stamp, noise) for stamp in range(1, 21)]
            counts[rate] = np.mean([picture.sum() for picture in pictures])
            assert not (pictures[0] & pictures[1]).sum() > 0.05 * pictures[0].sum()
        # 30 per million pixels and Gy/h, of 1.6 pixels each in the mean.
        assert counts[10.0] == pytest.approx(30.0 * 0.3072 * 10.0 * 1.65, rel=0.15)
        assert counts[100.0] == pytest.approx(10.0 * counts[10.0], rel=0.1)

    def test_what_the_dose_has_spoilt_stays(self):
        noise = SensorNoise(640, 480, 7)
        few, many = (
            self.dots(RadiationConfig(dose=dose, hot_pixels=20.0), 1, noise) for dose in (10, 40)
        )
        again = self.dots(RadiationConfig(dose=10.0, hot_pixels=20.0), 99)
        assert (few == again).all()
        assert (few & many).sum() == few.sum() == 61
        assert many.sum() == pytest.approx(4 * few.sum(), abs=3)

    def test_none_by_default(self):
        assert not self.dots(RadiationConfig()).any()
        picture = np.full((480, 640, 4), 128, np.uint8)
        SensorNoise(640, 480, 7).age(picture, RadiationConfig(dose_rate=50.0))
        assert (picture == 128).all()

    def relative_snr(self, grey, config):
        """Ratio of signal and noise (dB) to that of the same camera elsewhere, of 100 pictures."""
        spread = {}
        for exposed in (RadiationConfig(), config):
            noise, found = SensorNoise(640, 480, 7), []
            for stamp in range(100):
                picture = np.full((480, 640, 4), grey, np.uint8)
                noise.age(picture, exposed)
                noise.add(picture, 1.5, stamp)
                noise.irradiate(picture, exposed, stamp)
                found.append(picture[..., :3].std())
            spread[exposed] = np.mean(found)
        light = 1.0 - config.dose * config.loss
        return 20.0 * math.log10(light * spread[RadiationConfig()] / spread[config])

    def test_signal_to_noise_is_as_published_and_worse_in_the_dark(self):
        """Sensors 2018, 18, 514: 5 dB less at 10 Gy/h after 8 h, and less in dark areas."""
        config = RadiationConfig().exposed(10.0, 80.0)
        gray, dark = (self.relative_snr(grey, config) for grey in (120, 40))
        assert gray == pytest.approx(-5.0, abs=2.0)
        assert dark <= gray - 5.0

    def test_the_dose_lays_a_veil_over_the_picture_and_takes_contrast(self):
        means = {}
        for dose in (0.0, 40.0, 80.0):
            picture = np.full((480, 640, 4), 20, np.uint8)
            picture[240:] = 200
            SensorNoise(640, 480, 7).age(picture, RadiationConfig(dose=dose))
            means[dose] = float(picture[0, 0, 0]), float(picture[-1, 0, 0])
        assert means[0.0] == (20.0, 200.0)
        assert means[80.0][0] > means[40.0][0] > 20.0
        contrast = [bright - dark for dark, bright in means.values()]
        assert contrast[1] == pytest.approx(180.0 * 0.92, abs=1.0)
        assert contrast[2] == pytest.approx(180.0 * 0.84, abs=1.0)

    def test_what_the_camera_receives_adds_to_what_it_is_set_to(self, renderer):
        show(renderer, daylight=NIGHT)
        ages = []
        for radiation, exposed in (
            (RadiationConfig(dose_rate=20.0, dose=50.0), (0.0, 0.0)),
            (RadiationConfig(dose_rate=5.0, dose=20.0), (15.0, 30.0)),
        ):
            camera = sensor(replace(CONFIG, radiation=radiation))
            ev = camera.expose(SECOND)
            picture = renderer.render(camera.pinhole, POSE, exposure_factor(ev))
            ages.append(camera.develop([picture], False, ev, SECOND, exposed).copy())
        assert (ages[0] == ages[1]).all()
        assert ages[0][..., :3].any()

    def test_no_exposure_is_too_much(self):
        most = RadiationConfig(dose_rate=9e4).exposed(9e4, 1e9)
        assert (most.dose_rate, most.dose) == (1e5, 1e5)
        picture = np.full((48, 64, 4), 100, np.uint8)
        noise = SensorNoise(64, 48, 7)
        noise.age(picture, most)
        noise.irradiate(picture, most, 1)
        assert picture[..., :3].min() >= 100


class TestShutter:
    def test_what_moves_is_smeared_over_its_way(self, renderer):
        """The scene is placed anew for each moment of the exposure."""
        wall = Visual("world", VisualShape.BOX, (0.2, 0.2, 0.1), (0.0, 0.0, 2.0), glow=1.0)
        show(renderer, wall, daylight=NIGHT)
        config = replace(CONFIG, distortion=(0.0,) * 5, shutter=0.02, shutter_samples=8)
        camera = sensor(config)
        assert camera.moments == pytest.approx(np.linspace(0.02, 0.0, 8))
        ev = camera.expose(SECOND)
        pictures = []
        for back in camera.moments:
            frame = np.eye(4)
            frame[0, 3] = -10.0 * back
            renderer.place(frame[None], np.zeros(3))
            pictures.append(renderer.render(camera.pinhole, POSE, exposure_factor(ev)).copy())
        lit = camera.develop(pictures, renderer.repeats, ev, SECOND)[240, :, 1] > 10
        still = sensor(replace(config, shutter=0.0))
        sharp = take(renderer, still)[240, :, 1] > 10
        # 0.2 m at 1.95 m, with 320 pixels of focal length.
        assert lit.sum() - sharp.sum() == pytest.approx(0.2 / 1.95 * 320.0, abs=3)
        # It ends where the scene is at the stamp.
        assert np.flatnonzero(lit)[-1] == pytest.approx(np.flatnonzero(sharp)[-1], abs=1)

    def test_off_by_default(self):
        assert sensor().moments == (0.0,)


class TestOverviewRig:
    def robot(self, x=0.0, y=0.0, heading=0.0):
        pose = np.eye(4)
        cosine, sine = math.cos(heading), math.sin(heading)
        pose[:2, :2] = [[cosine, -sine], [sine, cosine]]
        pose[:2, 3] = x, y
        return pose

    def rig(self, smoothing=0.0, **view):
        values = {"azimuth": math.pi, "elevation": 0.0, "distance": 3.0, "center": (0.0, 0.0, 0.5)}
        return OverviewRig(ViewConfig(**{**values, **view}), smoothing)

    def test_follow_stays_behind(self):
        pose = self.rig().pose(self.robot(1.0, 2.0, math.pi / 2.0), 0.0)
        np.testing.assert_allclose(pose[:3, 3], (1.0, -1.0, 0.5), atol=1e-9)
        # Looks ahead, upright.
        np.testing.assert_allclose(pose[:3, 2], (0.0, 1.0, 0.0), atol=1e-9)
        np.testing.assert_allclose(pose[:3, 1], (0.0, 0.0, -1.0), atol=1e-9)

    def test_orbit_does_not_turn_with_the_robot(self):
        rig = self.rig(mode="orbit")
        before, after = (rig.pose(self.robot(1.0, 0.0, h), h)[:3, 3] for h in (0.0, 1.5))
        np.testing.assert_allclose(before, (-2.0, 0.0, 0.5), atol=1e-9)
        np.testing.assert_allclose(after, before, atol=1e-9)

    def test_fixed_stays(self):
        rig = self.rig(mode="fixed", center=(5.0, 5.0, 1.0))
        for x in (0.0, 3.0):
            np.testing.assert_allclose(rig.pose(self.robot(x), x)[:3, 3], (2, 5, 1), atol=1e-9)

    def test_stays_close_to_a_point_far_away(self):
        place = np.array([1e4, 1e4, 1e4])
        rig = self.rig(mode="fixed", center=tuple(place), distance=0.1)
        pose = rig.pose(self.robot(), 0.0)
        np.testing.assert_allclose(pose[:3, 3] - place, (-0.1, 0.0, 0.0), atol=1e-9)

    def test_turns_on_by_itself(self):
        rig = self.rig(mode="orbit", turn_rate=math.pi / 2.0)
        rig.pose(self.robot(), 10.0)
        np.testing.assert_allclose(rig.pose(self.robot(), 11.0)[:3, 3], (0, -3, 0.5), atol=1e-9)

    def test_goes_smoothly_and_the_short_way_round(self):
        rig = self.rig(0.5, mode="orbit", azimuth=3.0)
        rig.pose(self.robot(), 0.0)
        rig.view = replace(rig.view, azimuth=-3.0)
        places = [rig.pose(self.robot(), 0.1 * step)[:3, 3] for step in range(40)]
        assert max(place[0] for place in places) < -2.9
        steps = np.linalg.norm(np.diff(places, axis=0), axis=1)
        assert steps.max() < 0.25
        target = (3.0 * math.cos(-3.0), 3.0 * math.sin(-3.0), 0.5)
        np.testing.assert_allclose(places[-1], target, atol=0.01)

    def test_shipped_start_is_possible(self):
        OverviewConfig(640, 480, 1.0)
