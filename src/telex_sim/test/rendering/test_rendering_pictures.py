"""What the renderer draws, judged by its pixels; llvmpipe does where there is no graphics card."""

import math

import cv2
import numpy as np
import pytest

from telex_control.common.geometry.matrices import pose_matrices
from telex_sim.cameras.drawing.light.daylight import Lighting
from telex_sim.cameras.drawing.quality import TIERS
from telex_sim.cameras.optics.pinhole import PinholeCamera
from telex_sim.cameras.preview.still import Still, looking
from telex_sim.scene.visual_scene import Daylight, Visual, VisualScene, VisualShape

pytestmark = pytest.mark.slow

CAMERA = PinholeCamera(320, 240, 1.2, 0.05, 60.0)
RED, GREEN, BLUE = (0.9, 0.05, 0.05, 1.0), (0.05, 0.8, 0.05, 1.0), (0.05, 0.1, 0.9, 1.0)
MAGENTA, GRAY = (1.0, 0.0, 1.0, 1.0), (0.5, 0.5, 0.5, 1.0)
FLOOR = Visual("world", VisualShape.PLANE, (60.0, 60.0, 0.0), color=GRAY)


def at(*position):
    return (*position, 0.0, 0.0, 0.0, 1.0)


class Studio:
    """A renderer with what a test needs around it."""

    def __init__(self, quality):
        self._still = Still(quality, Lighting(), self.package_path)
        self.packages = {}

    def package_path(self, name):
        return self.packages[name]

    def load(self, *visuals, frames=("world", "thing")):
        daylight = Daylight(to_sun=(-1.0, 0.0, 2.0))
        return self._still.load(VisualScene(1, tuple(frames), tuple(visuals), (), daylight))

    def picture(self, eye, target, *poses, camera=CAMERA, focus=(0.0, 0.0, 0.0)):
        frames = pose_matrices([at(0.0, 0.0, 0.0), *(poses or [at(0.0, 0.0, 0.0)])])
        return self._still.picture(camera, looking(eye, target), frames, focus).astype(int)

    def release(self):
        self._still.release()


@pytest.fixture(scope="module", params=sorted(TIERS))
def studio(request):
    made = Studio(TIERS[request.param])
    yield made
    made.release()


@pytest.fixture(scope="module")
def software():
    made = Studio(TIERS["software"])
    yield made
    made.release()


def pixel(camera, eye, target, point):
    optical = np.linalg.inv(looking(eye, target)) @ [*point, 1.0]
    return camera.project([optical[:3]])[0]


def color_at(picture, camera, eye, target, point):
    u, v = np.round(pixel(camera, eye, target, point)).astype(int)
    return picture[v, u, :3]


def reddish(color):
    return color[..., 0] > 2 * np.maximum(color[..., 1], color[..., 2])


EYE, TARGET = (-3.0, 0.0, 1.0), (0.0, 0.0, 0.5)


class TestShapes:
    def test_a_box_is_where_it_should_be_and_nothing_elsewhere(self, studio):
        studio.load(Visual("thing", VisualShape.BOX, (0.4, 0.6, 0.8), color=RED))
        picture = studio.picture(EYE, TARGET, at(0.0, 0.5, 0.5))
        # Its front face, by the corners that CameraInfo predicts.
        corners = [(-0.2, y, z) for y in (0.2, 0.8) for z in (0.1, 0.9)]
        pixels = np.array([pixel(CAMERA, EYE, TARGET, corner) for corner in corners])
        left, top = np.ceil(pixels.min(axis=0)).astype(int) + 3
        right, bottom = np.floor(pixels.max(axis=0)).astype(int) - 3
        assert reddish(picture[top:bottom, left:right]).all()
        assert not reddish(picture[:, : left - 8]).any()
        assert not reddish(picture[:, right + 20 :]).any()

    def test_each_shape_in_its_colour(self, studio, tmp_path):
        (tmp_path / "tetra.obj").write_text(
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
        )
        studio.packages["shapes"] = str(tmp_path)
        problems = studio.load(
            Visual("world", VisualShape.SPHERE, (0.3, 0.0, 0.0), (0.0, 1.0, 0.5), color=RED),
            Visual("world", VisualShape.CYLINDER, (0.2, 0.0, 0.8), (0.0, 0.0, 0.5), color=GREEN),
            Visual(
                "world",
                VisualShape.MESH,
                (0.5, 0.5, 0.5),
                (0.0, -1.0, 0.3),
                mesh="package://shapes/tetra.obj",
                color=BLUE,
            ),
            FLOOR,
        )
        assert problems == []
        picture = studio.picture(EYE, TARGET)
        for point, channel in (((0.0, 1.0, 0.5), 0), ((0.0, 0.0, 0.5), 1), ((0.1, -0.9, 0.4), 2)):
            color = color_at(picture, CAMERA, EYE, TARGET, point)
            assert color.argmax() == channel
            assert color[channel] > 1.5 * np.delete(color, channel).max()

    def test_near_things_hide_far_ones_however_they_are_listed(self, studio):
        near = Visual("world", VisualShape.BOX, (0.1, 1.0, 1.0), (-1.0, 0.0, 0.7), color=RED)
        far = Visual("world", VisualShape.BOX, (0.1, 3.0, 3.0), (1.0, 0.0, 0.7), color=GREEN)
        for order in ((near, far), (far, near)):
            studio.load(*order)
            picture = studio.picture(EYE, TARGET)
            assert reddish(color_at(picture, CAMERA, EYE, TARGET, (-1.0, 0.0, 0.7)))

    def test_projection_agrees_with_camera_info(self, studio):
        camera = PinholeCamera(640, 480, 1.4, 0.05, 60.0)
        eye, target = (-2.0, 0.3, 1.0), (0.0, 0.0, 0.6)
        points = [
            (0.0, 0.0, 0.6),
            (-0.5, 1.0, 1.3),
            (-0.7, -0.9, 1.2),
            (0.5, 1.5, 0.1),
            (-0.8, -0.6, 0.2),
            (2.0, -0.5, 0.9),
        ]
        studio.load(Visual("thing", VisualShape.SPHERE, (0.02, 0.0, 0.0), color=MAGENTA))
        for point in points:
            picture = studio.picture(eye, target, at(*point), camera=camera)
            rows, columns = np.nonzero(picture[..., 0] - picture[..., 1] > 40)
            assert len(rows) > 8
            u, v = pixel(camera, eye, target, point)
            assert columns.mean() == pytest.approx(u, abs=0.5)
            assert rows.mean() == pytest.approx(v, abs=0.5)

    def test_a_moved_thing_moves(self, studio):
        studio.load(Visual("thing", VisualShape.SPHERE, (0.2, 0.0, 0.0), color=RED))
        left = reddish(studio.picture(EYE, TARGET, at(0.0, 0.8, 0.5)))
        right = reddish(studio.picture(EYE, TARGET, at(0.0, -0.8, 0.5)))
        assert np.nonzero(left)[1].max() < 160 < np.nonzero(right)[1].min()
        assert left.sum() == pytest.approx(right.sum(), rel=0.1)

    def test_glass_lets_the_background_through(self, studio):
        studio.load(
            Visual(
                "world", VisualShape.BOX, (0.1, 1.0, 1.0), (-1.0, 0.0, 0.7), color=(1, 0, 0, 0.4)
            ),
            Visual("world", VisualShape.BOX, (0.1, 3.0, 3.0), (1.0, 0.0, 0.7), color=GREEN),
        )
        red, green, _ = color_at(studio.picture(EYE, TARGET), CAMERA, EYE, TARGET, (-1, 0, 0.7))
        assert red > 60
        assert green > 60

    def test_what_is_wholly_transparent_is_not_there(self, software):
        software.load(Visual("world", VisualShape.BOX, (1.0, 1.0, 1.0), color=(1.0, 0.0, 0.0, 0.0)))
        assert not reddish(software.picture(EYE, TARGET)).any()


class TestCulling:
    def test_turning_right_round_shows_everything_that_should_be_seen(self, software):
        around = [
            (2.0 * math.cos(angle), 2.0 * math.sin(angle), 1.0)
            for angle in np.linspace(0.0, 2.0 * math.pi, 12, endpoint=False)
        ]
        software.load(
            *(
                Visual("world", VisualShape.BOX, (0.2, 0.2, 0.2), place, color=RED)
                for place in around
            ),
        )
        for place in around:
            picture = software.picture((0.0, 0.0, 1.0), place)
            assert reddish(picture[120, 160])

    def test_a_thing_that_only_reaches_into_the_picture_is_drawn(self, software):
        software.load(Visual("world", VisualShape.BOX, (0.2, 8.0, 0.2), (0.0, 4.5, 0.5), color=RED))
        picture = software.picture(EYE, TARGET)
        assert reddish(picture[:, :40]).any()

    def test_a_thing_whose_bounding_sphere_holds_the_camera_is_drawn(self, software):
        software.load(
            Visual("world", VisualShape.BOX, (0.1, 0.1, 20.0), (0.5, 0.0, 0.0), color=RED),
            FLOOR,
        )
        assert reddish(software.picture((0.0, 0.0, 5.0), (0.5, 0.0, 5.0))[:, 160]).all()


class TestLight:
    def test_the_floor_is_darker_under_a_box_than_beside_it(self, studio):
        studio.load(FLOOR, Visual("thing", VisualShape.BOX, (0.6, 0.6, 0.1), color=RED))
        eye, target = (-2.0, -2.0, 2.0), (0.0, 0.0, 0.0)
        picture = studio.picture(eye, target, at(0.0, 0.0, 0.8))
        # The sun stands two up for each one back: 0.8 m high, the shadow falls 0.4 m ahead.
        shade = color_at(picture, CAMERA, eye, target, (0.4, 0.0, 0.0)).mean()
        for beside in ((0.4, 0.5, 0.0), (0.4, -0.5, 0.0), (-0.8, 0.0, 0.0), (1.0, 0.0, 0.0)):
            assert shade < 0.8 * color_at(picture, CAMERA, eye, target, beside).mean()

    def test_the_shadow_follows_and_goes_with_its_thing(self, studio):
        studio.load(FLOOR, Visual("thing", VisualShape.BOX, (0.6, 0.6, 0.1), color=RED))
        eye, target, spot = (-2.0, -2.0, 2.0), (0.0, 0.0, 0.0), (0.4, 0.0, 0.0)
        shade = color_at(
            studio.picture(eye, target, at(0.0, 0.0, 0.8)), CAMERA, eye, target, spot
        ).mean()
        moved = color_at(
            studio.picture(eye, target, at(-1.5, 0.0, 0.8)), CAMERA, eye, target, spot
        ).mean()
        studio.load(FLOOR)
        gone = color_at(studio.picture(eye, target), CAMERA, eye, target, spot).mean()
        assert shade < 0.8 * moved
        assert moved == pytest.approx(gone, abs=2)

    def test_surfaces_do_not_shade_themselves(self, studio):
        studio.load(
            FLOOR,
            Visual("world", VisualShape.BOX, (2.0, 2.0, 0.5), (0.0, 0.0, 0.25), color=GRAY),
            Visual("world", VisualShape.CYLINDER, (0.3, 0.0, 0.5), (0.0, 0.0, 0.75), color=GRAY),
        )
        eye, target = (-1.5, 0.3, 2.0), (-0.5, 0.0, 0.5)
        picture = studio.picture(eye, target)
        # On the lid of the box, clear of the cylinder's shadow, which falls ahead, and of the shade
        # at its foot.
        lid = [(x, y, 0.5) for x in np.linspace(-0.9, -0.7, 12) for y in np.linspace(-0.8, 0.8, 12)]
        tones = [color_at(picture, CAMERA, eye, target, point).mean() for point in lid]
        assert np.ptp(tones) < 6

    def test_nor_do_those_that_the_sun_grazes(self, studio):
        # Turned about y until the sun stands 15 degrees above its face.
        turn = math.radians(75.0) - math.atan2(1.0, 2.0)
        tilted = (0.0, math.sin(turn / 2.0), 0.0, math.cos(turn / 2.0))
        studio.load(
            Visual(
                "world",
                VisualShape.BOX,
                (1.0, 2.0, 0.2),
                orientation=tilted,
                color=(0.9, 0.9, 0.9, 1),
            )
        )
        eye, target = (1.5, 0.2, 1.2), (0.0, 0.0, 0.0)
        picture = studio.picture(eye, target)
        along, normal = (math.cos(turn), -math.sin(turn)), (math.sin(turn), math.cos(turn))
        tones = [
            color_at(
                picture,
                CAMERA,
                eye,
                target,
                (a * along[0] + 0.1 * normal[0], y, a * along[1] + 0.1 * normal[1]),
            ).mean()
            for a in np.linspace(-0.4, 0.4, 15)
            for y in np.linspace(-0.5, 0.5, 15)
        ]
        assert np.ptp(tones) < 8

    def test_a_shadow_begins_at_the_foot_of_its_thing(self, studio):
        studio.load(
            FLOOR, Visual("world", VisualShape.BOX, (0.3, 0.6, 0.6), (0.0, 0.0, 0.3), color=RED)
        )
        eye, target = (1.2, 1.2, 1.2), (0.15, 0.0, 0.0)
        picture = studio.picture(eye, target)
        lit = color_at(picture, CAMERA, eye, target, (0.3, 0.6, 0.0)).mean()
        for distance in (0.03, 0.06, 0.15):
            foot = color_at(picture, CAMERA, eye, target, (0.15 + distance, 0.0, 0.0)).mean()
            assert foot < 0.8 * lit

    def test_beyond_the_shadow_map_the_sun_shines(self, studio):
        studio.load(
            FLOOR, Visual("world", VisualShape.BOX, (2.0, 40.0, 0.5), (0, 0, 3.0), color=RED)
        )
        tones = {}
        for y in (0.0, 12.0):
            eye, target = (-4.0, y, 1.0), (1.5, y, 0.0)
            picture = studio.picture(eye, target)
            tones[y] = color_at(picture, CAMERA, eye, target, target).mean()
        # The box is as long as that, its shadow ends with the map.
        assert tones[0.0] < 0.8 * tones[12.0]

    def test_sides_to_the_sun_are_brighter(self, studio):
        studio.load(Visual("world", VisualShape.BOX, (1.0, 1.0, 1.0), color=GRAY))
        sunny = studio.picture((-3.0, 0.1, 0.0), (0.0, 0.0, 0.0))[120, 160, :3].mean()
        shady = studio.picture((3.0, 0.1, 0.0), (0.0, 0.0, 0.0))[120, 160, :3].mean()
        assert sunny > shady + 15


class TestBackground:
    def test_sky_above_and_haze_at_the_horizon(self, studio):
        studio.load(FLOOR)
        level = studio.picture((0.0, 0.0, 1.0), (5.0, 0.0, 1.0))
        horizon = np.multiply(Lighting().horizon, 255)
        # Hills end a little above the horizon; over them it is bright.
        ridge, above = level[117, 160, :3].mean(), level[104, 160, :3].mean()
        assert ridge < above - 20
        assert abs(above - horizon.mean()) < 25
        up = studio.picture((0.0, 0.0, 1.0), (0.1, 0.0, 5.0))
        np.testing.assert_allclose(up[120, 160, :3], np.multiply(Lighting().zenith, 255), atol=4)
        # Far floor fades, near floor does not.
        assert abs(level[129, 160, :3] - horizon).mean() < abs(level[230, 160, :3] - horizon).mean()

    def test_an_empty_scene_is_all_sky(self, studio):
        studio.load()
        picture = studio.picture(EYE, TARGET)
        assert (picture[..., 2] > picture[..., 0]).all()


class TestTextures:
    def test_checker_has_two_tones_of_the_wanted_size(self, studio):
        studio.load(
            Visual(
                "world",
                VisualShape.PLANE,
                (40.0, 40.0, 0.0),
                texture="generated:checker",
                texture_scale=2.0,
            )
        )
        eye, target = (-0.1, 0.0, 4.0), (0.0, 0.0, 0.0)
        picture = studio.picture(eye, target)

        def tone(x, y):
            return color_at(picture, CAMERA, eye, target, (x, y, 0.0)).mean()

        step = tone(0.4, 0.4) - tone(0.4, -0.4)
        assert abs(step) > 10
        assert tone(-0.6, 0.4) - tone(-0.6, -0.4) == pytest.approx(-step, abs=4)
        assert tone(0.9, 0.9) - tone(0.9, -0.9) == pytest.approx(step, abs=4)

    def test_the_far_floor_does_not_shimmer(self, studio):
        studio.load(
            Visual(
                "world",
                VisualShape.PLANE,
                (80.0, 80.0, 0.0),
                texture="generated:checker",
                texture_scale=2.0,
            )
        )
        level = studio.picture((0.0, 0.0, 0.3), (5.0, 0.0, 0.3))[..., :3].mean(axis=2)
        far = level[122:126]
        assert np.abs(np.diff(far, axis=1)).max() < 12

    def test_a_picture_file_stands_upright(self, studio, tmp_path):
        pixels = np.zeros((32, 32, 3), np.uint8)
        pixels[:16] = (0, 0, 255)
        pixels[16:] = (0, 255, 0)
        cv2.imwrite(str(tmp_path / "flag.png"), pixels)
        address = f"file://{tmp_path}/flag.png"
        problems = studio.load(
            Visual("thing", VisualShape.BOX, (1.0, 1.0, 1.0), texture=address, color=(1, 1, 1, 1))
        )
        assert problems == []
        picture = studio.picture((-3.0, 0.0, 0.0), (0.0, 0.0, 0.0))
        # Centred: the middle of the picture lies in the middle of the face.
        above = color_at(picture, CAMERA, (-3.0, 0, 0), (0, 0, 0), (-0.5, 0.2, -0.25))
        below = color_at(picture, CAMERA, (-3.0, 0, 0), (0, 0, 0), (-0.5, 0.2, 0.25))
        assert above[0] > 2 * above[1]
        assert below[1] > 2 * below[0]


class TestProblems:
    def test_a_broken_mesh_alone_is_left_out(self, software, tmp_path):
        (tmp_path / "broken.obj").write_text("v 0 0 0\nf 1 2 3\n")
        software.packages["bad"] = str(tmp_path)
        problems = software.load(
            Visual("thing", VisualShape.MESH, (1.0, 1.0, 1.0), mesh="package://bad/broken.obj"),
            Visual("thing", VisualShape.MESH, (1.0, 1.0, 1.0), mesh="package://bad/missing.stl"),
            Visual("thing", VisualShape.MESH, (1.0, 1.0, 1.0), mesh="package://nobody/a.stl"),
            Visual("thing", VisualShape.SPHERE, (0.3, 0.0, 0.0), color=RED),
        )
        assert len(problems) == 3
        assert "broken.obj: line 2" in problems[0]
        assert "missing.stl: No such file" in problems[1]
        assert "package 'nobody' is not found" in problems[2]
        assert reddish(software.picture(EYE, (0.0, 0.0, 0.0))[120, 160])

    def test_without_its_texture_a_visual_keeps_its_colour(self, software):
        problems = software.load(
            Visual(
                "thing",
                VisualShape.SPHERE,
                (0.3, 0.0, 0.0),
                color=RED,
                texture="file:///no/where.png",
            )
        )
        (problem,) = problems
        assert "/no/where.png: no such file" in problem
        assert reddish(software.picture(EYE, (0.0, 0.0, 0.0))[120, 160])

    def test_a_mesh_file_that_changes_is_read_anew(self, software, tmp_path):
        path = tmp_path / "a.obj"
        triangle = "v 0 -1 {0}\nv 0 1 {0}\nv 0 0 {1}\nf 1 3 2\n"
        thing = Visual("thing", VisualShape.MESH, (1.0, 1.0, 1.0), mesh=f"file://{path}", color=RED)
        path.write_text(triangle.format(-1, 1))
        software.load(thing)
        assert reddish(software.picture(EYE, (0.0, 0.0, 0.0))[120, 160])
        path.write_text(triangle.format(8, 9))
        software.load(thing)
        assert not reddish(software.picture(EYE, (0.0, 0.0, 0.0))[120, 160])

    def test_poses_of_another_scene_are_refused(self, software):
        software.load(FLOOR)
        with pytest.raises(ValueError, match="3 frames for a scene of 2"):
            software.picture(EYE, TARGET, at(0.0, 0.0, 0.0), at(0.0, 0.0, 0.0))


def test_pictures_of_several_sizes_do_not_mix(software):
    software.load(FLOOR, Visual("thing", VisualShape.SPHERE, (0.3, 0.0, 0.0), color=RED))
    other = PinholeCamera(97, 61, 1.0, 0.05, 60.0)
    first = software.picture(EYE, (0.0, 0.0, 0.0))
    small = software.picture(EYE, (0.0, 0.0, 0.0), camera=other)
    again = software.picture(EYE, (0.0, 0.0, 0.0))
    assert small.shape == (61, 97, 3)
    assert reddish(small[30, 48])
    np.testing.assert_array_equal(first, again)
