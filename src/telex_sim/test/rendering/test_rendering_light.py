"""Lamps, darkness, fog and zoom, judged by pixels."""

import math
import re

import moderngl
import numpy as np
import pytest

from telex_sim.cameras.cameras_config import CameraConfig
from telex_sim.cameras.drawing import programs, shaders
from telex_sim.cameras.drawing.light.daylight import Lighting
from telex_sim.cameras.drawing.light.lamps import LampRig
from telex_sim.cameras.drawing.quality import TIERS
from telex_sim.cameras.drawing.shaders import EXPOSURE, LitVariant, lit_source
from telex_sim.cameras.optics.pinhole import PinholeCamera
from telex_sim.cameras.preview.still import Still, looking
from telex_sim.scene.visual_scene import Daylight, Visual, VisualLamp, VisualScene, VisualShape

CAMERA = PinholeCamera(320, 240, 1.2, 0.05, 200.0)
NIGHT = Daylight(sun=(0.0, 0.0, 0.0), ambient=0.0)
WHITE = (1.0, 1.0, 1.0, 1.0)
WALL = Visual("world", VisualShape.BOX, (0.2, 20.0, 20.0), (5.1, 0.0, 0.0), color=WHITE)
EYE, AHEAD = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0)


class Studio:
    def __init__(self):
        self.still = Still(TIERS["software"], Lighting(), str)

    def shoot(self, *visuals, lamps=(), daylight=NIGHT, camera=CAMERA, eye=EYE, target=AHEAD):
        problems = self.still.load(VisualScene(1, ("world",), visuals, tuple(lamps), daylight))
        assert problems == []
        return self.again(camera=camera, eye=eye, target=target)

    def again(self, camera=CAMERA, eye=EYE, target=AHEAD):
        picture = self.still.picture(camera, looking(eye, target), np.eye(4)[None], (0, 0, 0))
        return picture.astype(int)


@pytest.fixture(scope="module")
def studio():
    made = Studio()
    yield made
    made.still.release()


def light_of(pixels):
    """Undo the renderer's display curve: linear light of pixels 0..255."""
    return -np.log2(1.0 - np.square(np.minimum(np.asarray(pixels), 254.5) / 255.0)) / EXPOSURE


def off_axis(camera):
    """Angle between each pixel's ray and the optical axis (rad)."""
    v, u = np.indices((camera.height, camera.width))
    k = camera.intrinsic_matrix()
    rays = np.stack([(u - k[0, 2]) / k[0, 0], (v - k[1, 2]) / k[1, 1], np.ones(u.shape)], -1)
    return np.arccos(1.0 / np.linalg.norm(rays, axis=-1))


def head_lamp(**changes):
    return VisualLamp("world", **{"position": EYE, "direction": AHEAD, "reach": 20.0, **changes})


def test_programs_of_lights_long_ago_are_released(studio, monkeypatch):
    made = []

    def noting(make):
        def noted(*arguments, **named):
            made.append(make(*arguments, **named))
            return made[-1]

        return noted

    for kind in ("program", "vertex_array"):
        monkeypatch.setattr(moderngl.Context, kind, noting(getattr(moderngl.Context, kind)))

    def show(step):
        return studio.shoot(WALL, lamps=[head_lamp()], daylight=Daylight(ambient=1.0 - 0.01 * step))

    def alive():
        return sum(not isinstance(each.mglo, moderngl.InvalidObject) for each in made)

    first, *_ = [show(step) for step in range(12)]
    before, count = alive(), len(made)
    for step in range(12, 24):
        show(step)
    assert len(made) > count
    assert alive() == before
    assert (show(0) == first).all()


def test_pixels_fetch_nothing_but_textures_and_lamps():
    # llvmpipe takes a fifth of a picture's time to fetch some thirty numbers for each few pixels.
    for sun in (True, False):
        variant = LitVariant(textured=True, sun=sun, cover=False, fog=True, lamps=2)
        fragment = lit_source(variant, 2, 1, {"haze": (1.0,)}).fragment
        fetched = re.findall(r"^uniform (?!sampler)\w+ (\w+)", fragment, re.MULTILINE)
        assert {name for name in fetched if not name.startswith("lamp_")} == set()


class TestDark:
    def test_without_any_light_all_is_black(self, studio):
        assert studio.shoot(WALL).max() == 0
        assert studio.shoot().max() == 0

    def test_what_glows_is_seen_and_nothing_else(self, studio):
        sign = Visual(
            "world", VisualShape.BOX, (0.1, 1, 1), (3, 0, 0), color=(1, 0, 0, 1), glow=1.0
        )
        picture = studio.shoot(WALL, sign)
        red, green, blue = picture[120, 160]
        assert red > 235
        assert green == blue == 0
        assert picture[120, 10].max() == 0

    def test_half_the_ambient_is_half_the_light(self, studio):
        # The middle of a floor; what is left of the sun would cast a shadow.
        floor = Visual(
            "world", VisualShape.PLANE, (50.0, 50.0, 0.0), (0, 0, -2), color=(0.5, 0.5, 0.5, 1)
        )
        view = {"eye": (0.0, 0.0, 0.0), "target": (0.01, 0.0, -2.0)}
        full, half = (
            studio.shoot(floor, daylight=Daylight(sun=(0, 0, 0), ambient=ambient), **view)
            for ambient in (1.0, 0.5)
        )
        ratio = light_of(half[120, 160]) / light_of(full[120, 160])
        np.testing.assert_allclose(ratio, 0.5, atol=0.02)


class TestLamps:
    def test_what_vertices_work_out_for_few_lamps_pixels_do_for_many(self, monkeypatch):
        floor = Visual("world", VisualShape.PLANE, (50.0, 50.0, 0.0), (0.0, 0.0, -1.0), color=WHITE)
        ball = Visual("world", VisualShape.SPHERE, (0.4, 0.0, 0.0), (2.5, 0.3, -0.3), color=WHITE)
        lamps = [
            head_lamp(position=(0.0, 0.6 * side, 0.3), angle=1.2, intensity=3.0) for side in (-1, 1)
        ]
        pictures = []
        for most in (4, 0):
            monkeypatch.setattr(shaders, "MOST_LAMPS_BY_VERTEX", most)
            studio = Studio()
            pictures.append(studio.shoot(WALL, floor, ball, lamps=lamps))
            studio.still.release()
        # There are shadows to compare.
        assert np.ptp(pictures[0][..., 1]) > 150
        off = np.abs(pictures[0] - pictures[1]).max(axis=2)
        assert np.mean(off > 2) < 0.003

    def test_a_cone_and_nothing_outside_it(self, studio):
        picture = studio.shoot(WALL, lamps=[head_lamp(angle=0.6, intensity=10.0)])[..., 1]
        angle = off_axis(CAMERA)
        # Smoothing reaches over one pixel.
        pixel = 1.0 / CAMERA.focal_length
        assert picture[angle > 0.3 + 2 * pixel].max() == 0
        assert picture[angle < 0.15].min() > 60
        # From its even middle it fades to its edge.
        row = picture[120, 160:]
        assert (np.diff(row) <= 1).all()

    def test_twice_as_far_is_a_quarter(self, studio):
        def at(distance):
            wall = Visual(
                "world", VisualShape.BOX, (0.2, 9, 9), (distance + 0.1, 0, 0), color=WHITE
            )
            # Rough: a highlight would tell of the shader's angle, not of the distance.
            lamp = head_lamp(position=(0.0, 0.0, 0.02), angle=1.0, intensity=0.5, reach=500.0)
            return light_of(studio.shoot(wall, lamps=[lamp])[120, 160].mean())

        assert at(4.0) / at(2.0) == pytest.approx(0.25, rel=0.1)

    def test_at_one_metre_it_is_like_the_sun(self, studio):
        wall = Visual("world", VisualShape.BOX, (0.2, 9, 9), (1.1, 0, 0), color=(0.4, 0.4, 0.4, 1))
        view = {"eye": (0.0, 0.8, 0.0), "target": (1.0, 0.0, 0.0)}
        lamp = head_lamp(angle=1.0, reach=500.0)
        lit = studio.shoot(wall, lamps=[lamp], **view)
        sun = Daylight(to_sun=(-1.0, 0.0, 0.0), sun=(1.0, 1.0, 1.0), ambient=0.0)
        sunny = studio.shoot(wall, daylight=sun, **view)
        np.testing.assert_allclose(light_of(lit[120, 160]), light_of(sunny[120, 160]), rtol=0.05)

    def test_beyond_its_reach_nothing(self, studio):
        assert studio.shoot(WALL, lamps=[head_lamp(intensity=100.0, reach=4.9)]).max() == 0
        assert studio.shoot(WALL, lamps=[head_lamp(intensity=100.0, reach=7.0)]).max() > 100

    def test_all_around(self, studio):
        behind = Visual("world", VisualShape.BOX, (0.2, 9, 9), (-5.1, 0, 0), color=WHITE)
        picture = studio.shoot(
            WALL, behind, lamps=[head_lamp(angle=2.0 * math.pi)], target=(-1, 0, 0)
        )
        assert picture[120, 160].min() > 20

    def test_it_has_its_colour(self, studio):
        picture = studio.shoot(WALL, lamps=[head_lamp(color=(1.0, 0.5, 0.0), intensity=3.0)])
        red, green, blue = light_of(picture[120, 160])
        assert blue == 0.0
        assert green / red == pytest.approx(0.25, abs=0.02)

    def test_it_is_switched_and_dimmed_by_name(self, studio):
        lamp = head_lamp(name="head")
        full = light_of(studio.shoot(WALL, lamps=[lamp, head_lamp(intensity=0.0)])[120, 160])
        studio.still.renderer.set_lamp_levels({"head": 0.5})
        np.testing.assert_allclose(light_of(studio.again()[120, 160]), 0.5 * full, rtol=0.05)
        studio.still.renderer.set_lamp_levels({"head": 0.0})
        assert studio.again().max() == 0
        studio.still.renderer.set_lamp_levels({})
        np.testing.assert_allclose(light_of(studio.again()[120, 160]), full)

    def test_two_add_up(self, studio):
        one = light_of(studio.shoot(WALL, lamps=[head_lamp()])[120, 160])
        two = light_of(studio.shoot(WALL, lamps=[head_lamp(), head_lamp()])[120, 160])
        np.testing.assert_allclose(two, 2.0 * one, rtol=0.05)

    def test_it_moves_with_its_frame(self, studio):
        lamp = VisualLamp("thing", (0.0, 0.0, 0.0), AHEAD, angle=0.3, intensity=9.0, reach=30.0)
        studio.still.load(VisualScene(1, ("world", "thing"), (WALL,), (lamp,), NIGHT))
        frames = np.stack([np.eye(4), np.eye(4)])
        turn = 0.35
        frames[1, :2, :2] = [
            [math.cos(turn), -math.sin(turn)],
            [math.sin(turn), math.cos(turn)],
        ]
        picture = studio.still.picture(CAMERA, looking(EYE, AHEAD), frames, (0, 0, 0))
        _, columns = np.nonzero(picture[..., 1] > 40)
        # Turned to the left, by as much as the camera's focal length says.
        expected = 159.5 - CAMERA.focal_length * math.tan(turn)
        assert columns.mean() == pytest.approx(expected, abs=4.0)

    def test_many_lamps_are_no_trouble(self, studio):
        lamps = [head_lamp(intensity=0.1) for _ in range(40)]
        assert studio.shoot(WALL, lamps=lamps)[120, 160].min() > 0

    def test_one_program_draws_the_first_picture_whatever_lamps_reach_what(self, monkeypatch):
        compiled = []

        class Counted(programs.LitProgram):
            def __init__(self, context, variant, *others):
                compiled.append(variant)
                super().__init__(context, variant, *others)

        monkeypatch.setattr(programs, "LitProgram", Counted)
        studio = Studio()
        # Boxes side by side, with the light of no lamp, of one, and of three.
        boxes = [
            Visual("world", VisualShape.BOX, (0.2, 0.7, 3.0), (6.0, y, 0.0), color=WHITE)
            for y in (-4.5, -1.5, 1.5)
        ]
        lamps = [
            head_lamp(position=(3.0, y, 0.0), angle=0.4, reach=5.0) for y in (-1.5, 1.5, 1.4, 1.3)
        ]
        first = studio.shoot(*boxes, lamps=lamps)
        assert [variant.lamps for variant in compiled] == [3]
        while True:
            seen = len(compiled)
            exposed = studio.still.picture(CAMERA, looking(EYE, AHEAD), np.eye(4)[None], EYE, 0.5)
            if len(compiled) == seen:
                break
        assert exposed.max() < first.max()
        # By now each number of lamps has a program of its own, and all looks the same.
        assert sorted(variant.lamps for variant in compiled) == [0, 1, 2, 3, 4]
        last = studio.again()
        assert np.abs(last - first).max() <= 1
        assert np.ptp(first[..., 1]) > 100
        studio.still.release()

    def test_surfaces_that_no_lamp_reaches_look_as_without_lamps(self, studio):
        day = Daylight()
        near = head_lamp(position=(0.0, 0.0, -50.0), direction=(0, 0, -1), reach=2.0)
        without = studio.shoot(WALL, daylight=day)
        np.testing.assert_array_equal(without, studio.shoot(WALL, lamps=[near], daylight=day))


class TestChoiceOfLamps:
    def rig(self, *lamps):
        rig = LampRig(lamps, ("world",), 1.0)
        rig.place(np.eye(4)[None])
        return rig

    def view(self):
        return CAMERA.clip_from_optical() @ np.linalg.inv(looking(EYE, AHEAD))

    def test_the_brightest_and_nearest_first(self):
        far, dim, near = (
            VisualLamp("world", (x, 0.0, 0.0), intensity=intensity, reach=2.0)
            for x, intensity in ((20.0, 1.0), (3.0, 0.01), (3.0, 1.0))
        )
        chosen = self.rig(far, dim, near).choose(self.view(), np.zeros(3), 3)
        assert chosen.numbers[0] == 2
        assert chosen.levels.tolist() == [1.0, 1.0, 1.0]
        assert not chosen.rest.any()

    def test_what_shines_away_from_the_view_is_left_out(self):
        behind = VisualLamp("world", (-1.0, 0.0, 0.0), (-1.0, 0.0, 0.0), angle=1.0, reach=5.0)
        dark = VisualLamp("world", (1.0, 0.0, 0.0), intensity=0.0)
        assert self.rig(behind, dark).choose(self.view(), np.zeros(3), 4).numbers.size == 0

    def test_the_last_one_to_be_had_comes_in_softly(self):
        lamps = [
            VisualLamp("world", (3.0, 0.0, 0.0), intensity=value) for value in (2.0, 1.01, 1.0)
        ]
        chosen = self.rig(*lamps).choose(self.view(), np.zeros(3), 2)
        assert chosen.levels[0] == 1.0
        assert 0.0 < chosen.levels[1] < 0.1

    def test_the_light_of_those_that_cannot_be_had_is_not_lost(self):
        lamps = [VisualLamp("world", (3.0, 0.0, 0.0))] * 10
        chosen = self.rig(*lamps).choose(self.view(), np.zeros(3), 4)
        assert chosen.rest.min() > 0.1


class TestCover:
    """Soft shadows where no sun shines."""

    FLOOR = Visual("world", VisualShape.PLANE, (40.0, 40.0, 0.0), color=(0.6, 0.6, 0.6, 1.0))
    CRATE = Visual(
        "world", VisualShape.BOX, (0.8, 0.8, 0.6), (0.0, 0.0, 0.3), color=(0.6, 0.6, 0.6, 1)
    )
    OVERCAST = Daylight(sun=(0.0, 0.0, 0.0))
    EYE, TARGET = (-2.5, 0.0, 1.4), (0.0, 0.0, 0.2)

    def tones(self, studio, *visuals, points, daylight=OVERCAST, lamps=()):
        view = {"eye": self.EYE, "target": self.TARGET}
        picture = studio.shoot(self.FLOOR, *visuals, daylight=daylight, lamps=lamps, **view)
        optical_from_world = np.linalg.inv(looking(self.EYE, self.TARGET))
        found = []
        for point in points:
            u, v = CAMERA.project([(optical_from_world @ [*point, 1.0])[:3]])[0]
            found.append(light_of(picture[round(v), round(u)].mean()))
        return found

    def test_at_the_foot_of_a_thing_it_is_darker(self, studio):
        points = [(-0.45, 0.0, 0.0), (-0.6, 0.0, 0.0), (-0.8, 0.0, 0.0), (-1.0, 0.6, 0.0)]
        foot, near, beside, away = self.tones(studio, self.CRATE, points=points)
        assert foot < 0.7 * away
        assert foot < near < beside
        assert beside == pytest.approx(away, rel=0.1)

    def test_on_top_of_it_it_is_not(self, studio):
        bare = Visual(
            "world", VisualShape.PLANE, (3.0, 3.0, 0.0), (0, 0, 0.6), color=(0.6, 0.6, 0.6, 1)
        )
        (top,) = self.tones(studio, self.CRATE, points=[(0.0, 0.0, 0.6)])
        (alone,) = self.tones(studio, bare, points=[(0.0, 0.0, 0.6)])
        assert top == pytest.approx(alone, rel=0.05)

    def test_lamps_above_throw_it_too_and_those_beside_do_not(self, studio):
        dark = {"daylight": NIGHT, "points": [(-0.5, 0.0, 0.0)]}
        for height, darker in ((4.0, True), (0.02, False)):
            # The lamp stands before the crate, so that it lights the whole of the floor there.
            lamp = [VisualLamp("world", (-1.5, 0.0, height), intensity=8.0, reach=20.0)]
            (foot,) = self.tones(studio, self.CRATE, lamps=lamp, **dark)
            (open_floor,) = self.tones(studio, lamps=lamp, **dark)
            assert (foot < 0.8 * open_floor) == darker

    def test_a_ceiling_does_not_darken_the_room(self, studio):
        ceiling = Visual("world", VisualShape.BOX, (20.0, 20.0, 0.2), (0.0, 0.0, 2.6))
        points = [(-1.2, 0.5, 0.0)]
        assert self.tones(studio, ceiling, points=points) == self.tones(studio, points=points)

    def test_by_sunlight_the_sun_throws_the_shadow(self, studio):
        day = Daylight(to_sun=(1.0, 0.0, 1.0))
        points = [(-0.6, 0.0, 0.0), (-1.0, 0.6, 0.0)]
        shade, lit = self.tones(studio, self.CRATE, points=points, daylight=day)
        assert shade < 0.6 * lit


class TestFog:
    def board(self, distance, tone):
        color = (tone, tone, tone, 1.0)
        size = 0.6 * distance
        return Visual("world", VisualShape.BOX, (0.1, size, size), (distance, 0, 0), color=color)

    def test_at_the_distance_of_visibility_a_twentieth_of_the_contrast_is_left(self, studio):
        def contrast(distance, visibility):
            day = Daylight(to_sun=(-1.0, 0.0, 1.0), visibility=visibility)
            white, black = (
                light_of(studio.shoot(self.board(distance, tone), daylight=day)[120, 160].mean())
                for tone in (0.9, 0.0)
            )
            return white - black

        clear = contrast(2.0, 1e5)
        assert contrast(10.0, 10.0) / clear == pytest.approx(0.05, abs=0.015)
        assert contrast(5.0, 10.0) / clear == pytest.approx(math.sqrt(0.05), abs=0.03)

    def test_beyond_there_is_only_its_colour_and_so_is_the_sky(self, studio):
        day = Daylight(visibility=5.0, fog=(0.6, 0.5, 0.4))
        for picture in (
            studio.shoot(self.board(40.0, 0.0), daylight=day),
            studio.shoot(daylight=day, target=(1.0, 0.0, 0.6)),
        ):
            np.testing.assert_allclose(picture[120, 160], [153, 127, 102], atol=3)

    def test_in_the_dark_it_does_not_shine(self, studio):
        night = Daylight(sun=(0, 0, 0), ambient=0.0, visibility=5.0)
        assert studio.shoot(self.board(4.0, 1.0), daylight=night).max() == 0

    def test_overcast_the_sky_is_gray(self, studio):
        picture = studio.shoot(daylight=Daylight(sun=(0, 0, 0)), target=(0.1, 0.0, 1.0))
        assert np.ptp(picture[120, 160]) <= 2
        assert picture[120, 160].min() > 100


@pytest.mark.parametrize("zoom", [1.0, 2.5, 10.0])
def test_zoom_narrows_the_view_as_camera_info_says(studio, zoom):
    camera = CameraConfig(640, 480, 1.2, zoom_max=10.0, frame="head").pinhole(zoom)
    assert camera.focal_length == pytest.approx(zoom * 320.0 / math.tan(0.6))
    offset = np.array([0.35, -0.2]) / zoom
    ball = Visual(
        "world",
        VisualShape.SPHERE,
        (0.05 / zoom, 0.0, 0.0),
        (2.0, -offset[0], -offset[1]),
        color=(1.0, 0.0, 0.0, 1.0),
        glow=1.0,
    )
    rows, columns = np.nonzero(studio.shoot(ball, camera=camera)[..., 0] > 100)
    u, v = camera.project([[*offset, 2.0]])[0]
    assert columns.mean() == pytest.approx(u, abs=0.7)
    assert rows.mean() == pytest.approx(v, abs=0.7)
    # The ball is as large in each picture.
    assert np.ptp(columns) == pytest.approx(2 * 0.05 / 2.0 * 320.0 / math.tan(0.6), abs=3)
