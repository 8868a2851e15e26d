"""Shadows of lamps and of the sun, exposure and depth."""

import numpy as np
import pytest

from telex_control.common.geometry.matrices import pose_matrices
from telex_sim.cameras.drawing.light.daylight import Lighting
from telex_sim.cameras.drawing.quality import TIERS
from telex_sim.cameras.optics.pinhole import PinholeCamera
from telex_sim.cameras.preview.still import Still, looking
from telex_sim.scene.visual_scene import Daylight, Visual, VisualLamp, VisualScene, VisualShape

CAMERA = PinholeCamera(320, 240, 1.2, 0.05, 60.0)
GRAY = (0.5, 0.5, 0.5, 1.0)
FLOOR = Visual("world", VisualShape.PLANE, (60.0, 60.0, 0.0), color=GRAY)
WALL = Visual("world", VisualShape.BOX, (0.1, 8.0, 4.0), (4.0, 0.0, 2.0), color=GRAY)
POST = Visual("thing", VisualShape.BOX, (0.1, 0.3, 0.6), color=GRAY)
NIGHT = Daylight(sun=(0.0, 0.0, 0.0), ambient=0.02)
EYE, TARGET = (-1.0, 0.0, 2.5), (3.0, 0.0, 1.0)


def at(x, y, z):
    return (x, y, z, 0.0, 0.0, 0.0, 1.0)


def headlight(**changes):
    values = {
        "frame": "robot",
        "position": (0.0, 0.0, 0.0),
        "direction": (1.0, 0.0, 0.0),
        "angle": 1.2,
        "intensity": 6.0,
        "reach": 12.0,
        "name": "front",
        **changes,
    }
    return VisualLamp(**values)


@pytest.fixture(scope="module", params=sorted(TIERS))
def still(request):
    made = Still(TIERS[request.param], Lighting(), lambda name: name)
    yield made
    made.release()


def load(still, *visuals, lamps=(), daylight=NIGHT):
    scene = VisualScene(1, ("world", "robot", "thing"), visuals, tuple(lamps), daylight)
    assert still.load(scene) == []
    still.renderer.set_lamp_levels({lamp.name: 1.0 for lamp in lamps})


def picture(still, robot=(0.0, 0.0, 1.0), thing=(2.0, 0.0, 1.0), **options):
    frames = pose_matrices([at(0.0, 0.0, 0.0), at(*robot), at(*thing)])
    return still.picture(CAMERA, looking(EYE, TARGET), frames, (0.0, 0.0, 0.0), **options)


def brightness(image, point):
    optical = (np.linalg.inv(looking(EYE, TARGET)) @ [*point, 1.0])[:3]
    u, v = np.round(CAMERA.project(optical[None])[0]).astype(int)
    return float(image[v - 1 : v + 2, u - 1 : u + 2].mean())


class TestHeadlight:
    def test_night_is_dark_and_the_headlight_lights_it(self, still):
        load(still, FLOOR, WALL, lamps=[headlight()])
        lit = picture(still)
        still.renderer.set_lamp_levels({"front": 0.0})
        dark = picture(still)
        assert dark.max() < 40
        assert brightness(lit, (3.95, 0.0, 1.0)) > 90

    def test_things_stand_in_its_light_where_geometry_says(self, still):
        load(still, WALL, POST, lamps=[headlight()])
        image = picture(still)
        # The post at half the way to the wall throws a shadow of twice its width.
        shadow = [brightness(image, (3.95, y, 1.0)) for y in (-0.22, 0.0, 0.22)]
        light = [brightness(image, (3.95, y, 1.0)) for y in (-0.42, 0.42)]
        assert max(shadow) < 30
        assert min(light) > 80

    def test_the_shadow_moves_with_the_thing_and_with_the_lamp(self, still):
        load(still, WALL, POST, lamps=[headlight()])
        aside = (3.95, 0.8, 1.0)
        assert brightness(picture(still), aside) > 80
        assert brightness(picture(still, thing=(2.0, 0.4, 1.0)), aside) < 30
        assert brightness(picture(still, robot=(0.0, -0.8, 1.0)), aside) < 30

    def test_each_picture_has_the_shadows_of_the_lamps_in_it(self, still):
        behind = headlight(direction=(-1.0, 0.0, 0.0))
        load(still, WALL, POST, lamps=[headlight(), behind])
        elsewhere = looking((0.0, 0.0, 1.0), (-5.0, 0.0, 1.0))
        frames = pose_matrices([at(0.0, 0.0, 0.0), at(0.0, 0.0, 1.0), at(2.0, 0.0, 1.0)])
        still.picture(CAMERA, elsewhere, frames, (0.0, 0.0, 0.0))
        image = picture(still, recast=False)
        assert brightness(image, (3.95, 0.0, 1.0)) < 30
        assert brightness(image, (3.95, -0.42, 1.0)) > 80

    def test_a_lamp_that_casts_none_shines_through(self, still):
        load(still, WALL, POST, lamps=[headlight(casts_shadow=False)])
        assert brightness(picture(still), (3.95, 0.0, 1.0)) > 80

    @pytest.mark.parametrize("reach", [0.01, 0.06])
    def test_one_that_reaches_no_further_than_its_housing_is_drawn(self, still, reach):
        load(still, WALL, POST, lamps=[headlight(reach=reach)])
        frames = pose_matrices([at(0.0, 0.0, 0.0), at(0.0, 0.0, 1.0), at(0.1, 0.0, 1.0)])
        behind = looking((-0.5, 0.0, 1.0), (3.0, 0.0, 1.0))
        assert still.picture(CAMERA, behind, frames, (0.0, 0.0, 0.0)).max() > 0

    def test_its_own_surfaces_have_no_speckles(self, still):
        load(still, WALL, FLOOR, lamps=[headlight(angle=1.6)])
        image = picture(still)
        row = [brightness(image, (3.95, y, 1.0)) for y in np.linspace(-0.6, 0.6, 25)]
        assert np.abs(np.diff(row)).max() < 6
        # Stripes along the rows of the shadow map, pixel by pixel.
        column = image[60:120, 160].mean(axis=1)
        assert np.abs(np.diff(column, 2)).max() < 4

    def test_one_that_shines_all_around_has_shadows_ahead_and_light_beside(self, still):
        lamp = headlight(angle=2 * np.pi, direction=(1.0, 0.0, 0.0))
        load(still, WALL, POST, FLOOR, lamps=[lamp])
        image = picture(still, robot=(1.5, 0.0, 1.0))
        assert brightness(image, (3.95, 0.0, 1.0)) < 30
        assert brightness(image, (1.7, 0.0, 0.0)) > 60


class TestSun:
    DAY = Daylight(to_sun=(-1.0, 0.0, 1.0))

    def test_far_from_the_robot_there_are_shadows_as_well(self, still):
        near = Visual("thing", VisualShape.BOX, (0.4, 0.4, 0.8), (0.0, 0.0, 0.4), color=GRAY)
        load(still, FLOOR, near, daylight=Daylight(to_sun=(0.0, -1.0, 1.0)))
        for x in (1.8, 6.0):
            image = picture(still, thing=(x, 0.0, 0.0))
            lit = brightness(image, (x, -0.6, 0.0))
            assert brightness(image, (x, 0.6, 0.0)) < 0.75 * lit

    def test_where_sharp_and_wide_map_meet_there_is_no_seam(self, still):
        load(still, FLOOR, daylight=self.DAY)
        image = picture(still)
        line = [brightness(image, (x, 0.0, 0.0)) for x in np.linspace(1.7, 6.0, 40)]
        assert np.abs(np.diff(line)).max() < 5

    def test_the_foot_of_things_is_in_the_shade_on_the_sunny_side_as_well(self, still):
        cone = Visual("thing", VisualShape.CYLINDER, (0.12, 0.0, 0.5), (0.0, 0.0, 0.25), color=GRAY)
        load(still, FLOOR, cone, daylight=Daylight(to_sun=(0.0, -1.0, 1.0)))

        def on_floor(x, y):
            return brightness(picture(still, thing=(x, 0.0, 0.0)), (2.0, y, 0.0))

        foot, beside, moved = on_floor(2.0, -0.16), on_floor(2.0, -0.8), on_floor(3.0, -0.16)
        assert foot < 0.93 * beside
        assert abs(moved - beside) < 3

    def test_shadows_stay_behind_only_when_told_to(self, still):
        load(still, FLOOR, POST, daylight=self.DAY)
        picture(still, thing=(2.0, 0.0, 0.3))
        # As the cameras node does with every set of poses; no lamp has changed.
        still.renderer.set_lamp_levels({})
        moved = picture(still, thing=(2.0, 1.0, 0.3), recast=False)
        stale = brightness(moved, (2.35, 0.0, 0.0))
        fresh = brightness(picture(still, thing=(2.0, 1.0, 0.3)), (2.35, 0.0, 0.0))
        assert stale < 0.8 * fresh


def test_exposure_makes_a_picture_brighter(still):
    load(still, FLOOR, WALL, daylight=Daylight(sun=(0.0, 0.0, 0.0), ambient=0.3))
    means = [picture(still, exposure=value).mean() for value in (0.5, 1.0, 2.0)]
    assert means[0] < 0.85 * means[1] < 0.7 * means[2]


class TestDepth:
    def test_it_is_the_distance_along_the_axis(self, still):
        load(still, WALL, daylight=Daylight())
        frames = pose_matrices([at(0.0, 0.0, 0.0)] * 3)
        pose = looking((0.0, 0.0, 2.0), (1.0, 0.0, 2.0))
        still.picture(CAMERA, pose, frames, (0.0, 0.0, 0.0))
        depth = still.depth(CAMERA)
        assert (depth.shape, depth.dtype) == ((240, 320), np.float32)
        assert depth[100:140, 40:280] == pytest.approx(3.95, abs=0.002)
        assert np.isposinf(depth[0, 0])

    def test_that_of_another_picture_is_refused(self, still):
        load(still, WALL, daylight=Daylight())
        picture(still)
        with pytest.raises(ValueError, match="64x48"):
            still.depth(PinholeCamera(64, 48, 1.0, 0.05, 60.0))


def test_sizes_of_pictures_may_change_without_end(still):
    load(still, FLOOR, daylight=Daylight())
    frames = pose_matrices([at(0.0, 0.0, 0.0)] * 3)
    for width in range(32, 64, 2):
        camera = PinholeCamera(width, 24, 1.0, 0.05, 60.0)
        image = still.picture(camera, looking(EYE, TARGET), frames, (0.0, 0.0, 0.0))
        assert image.shape == (24, width, 3)
        assert still.depth(camera).shape == (24, width)
