"""Dots of lasers: where the beams end, and what hides them."""

import numpy as np
import pytest

from telex_control.common.geometry.matrices import pose_matrices
from telex_sim.cameras.drawing.light.daylight import Lighting
from telex_sim.cameras.drawing.quality import TIERS
from telex_sim.cameras.optics.pinhole import PinholeCamera
from telex_sim.cameras.preview.still import Still, looking
from telex_sim.scene.visual_scene import Daylight, Visual, VisualLamp, VisualScene, VisualShape

CAMERA = PinholeCamera(320, 240, 1.2, 0.05, 60.0)
EYE, TARGET = (0.0, -1.0, 1.5), (3.0, 0.0, 1.0)
GRAY = (0.5, 0.5, 0.5, 1.0)
WALL = Visual("world", VisualShape.BOX, (0.1, 8.0, 4.0), (3.05, 0.0, 2.0), color=GRAY)
FACE = 3.0  # of the wall, towards camera and tool
POST = Visual("thing", VisualShape.BOX, (0.1, 0.3, 0.6), color=GRAY)
GLASS = Visual("thing", VisualShape.BOX, (0.02, 2.0, 2.0), color=(0.8, 0.9, 0.9, 0.3))
APART = 0.04
ASIDE = (0.0, 3.0, 1.0)  # where the thing is in nobody's way


def at(x, y, z):
    return (x, y, z, 0.0, 0.0, 0.0, 1.0)


def lasers(**changes):
    return [
        VisualLamp(
            "tool",
            (0.0, side * 0.5 * APART, 0.0),
            (1.0, 0.0, 0.0),
            intensity=8.0,
            color=(1.0, 0.12, 0.1),
            name=f"laser_{side}",
            beam=True,
            **{"reach": 8.0, **changes},
        )
        for side in (1, -1)
    ]


@pytest.fixture(scope="module", params=sorted(TIERS))
def still(request):
    made = Still(TIERS[request.param], Lighting(), lambda name: name)
    yield made
    made.release()


class Bench:
    """A wall, a thing before it, and a tool with two lasers."""

    def __init__(self, still):
        self._still = still
        self.load()

    def load(self, *visuals, daylight=None, **changes):
        light = daylight or Daylight(sun=(0.0, 0.0, 0.0), ambient=0.3)
        shown = visuals or (WALL, POST)
        scene = VisualScene(1, ("world", "tool", "thing"), shown, tuple(lasers(**changes)), light)
        assert self._still.load(scene) == []

    def added(self, tool=(0.0, 0.0, 1.0), thing=ASIDE, eye=EYE, target=TARGET, turned=None):
        """What the dots add to a picture."""
        frames = pose_matrices([at(0.0, 0.0, 0.0), turned or at(*tool), at(*thing)])
        pictures = []
        for level in (0.0, 1.0):
            self._still.renderer.set_lamp_levels({"laser_1": level, "laser_-1": level})
            pose = looking(eye, target)
            pictures.append(self._still.picture(CAMERA, pose, frames, (0.0, 0.0, 0.0)).astype(int))
        assert (pictures[1] >= pictures[0] - 1).all()
        return (pictures[1] - pictures[0]).sum(axis=2)


@pytest.fixture
def bench(still):
    return Bench(still)


def pixel(point, eye=EYE, target=TARGET):
    optical = (np.linalg.inv(looking(eye, target)) @ [*point, 1.0])[:3]
    return CAMERA.project(optical[None])[0]


def middle(added):
    """Mean place of what was added: column and row."""
    rows, columns = np.nonzero(added > 60)
    weights = added[rows, columns]
    return np.average(columns, weights=weights), np.average(rows, weights=weights)


def test_two_dots_are_where_the_beams_meet_the_wall_and_move_with_the_tool(bench):
    for tool in ((0.0, 0.0, 1.0), (0.5, 0.4, 0.7)):
        added = bench.added(tool)
        assert 4 <= (added > 60).sum() < 150
        np.testing.assert_allclose(middle(added), pixel((FACE, *tool[1:])), atol=0.8)


def test_they_are_as_far_apart_as_the_beams_are(bench):
    eye = (2.7, 0.0, 1.0)
    row = bench.added(eye=eye, target=(FACE, 0.0, 1.0)).max(axis=0)
    left, right = (
        pixel((FACE, y, 1.0), eye, (FACE, 0.0, 1.0))[0] for y in (0.5 * APART, -0.5 * APART)
    )
    assert min(row[round(left)], row[round(right)]) > 200
    assert row[round(0.5 * (left + right))] < 20


def test_what_stands_in_the_beams_has_the_dots(bench):
    added = bench.added(thing=(1.5, 0.0, 1.0))
    np.testing.assert_allclose(middle(added), pixel((1.45, 0.0, 1.0)), atol=0.8)


def test_what_stands_before_the_camera_hides_them(bench):
    assert bench.added(eye=(6.0, 0.0, 1.5), target=(FACE, 0.0, 1.0)).max() == 0
    way = np.subtract((FACE, 0.0, 1.0), EYE)
    assert bench.added(thing=tuple(EYE + 0.5 * way)).max() == 0


def test_glass_lets_them_through(bench):
    bench.load(WALL, GLASS)
    added = bench.added(thing=(1.5, 0.0, 1.0))
    np.testing.assert_allclose(middle(added), pixel((FACE, 0.0, 1.0)), atol=0.8)


def test_beyond_their_reach_and_into_the_sky_there_is_none(bench):
    up = (0.0, 0.0, 1.0, 0.0, -0.7071, 0.0, 0.7071)
    assert bench.added(turned=up).max() == 0
    bench.load(reach=2.5)
    assert bench.added().max() == 0


def test_a_sunny_wall_shows_them_as_well(bench):
    bench.load(WALL, POST, daylight=Daylight(to_sun=(-1.0, 0.0, 0.5)))
    assert bench.added().max() > 60


def test_a_laser_lights_nothing_beside_its_dot(bench):
    added = bench.added()
    column, row = np.round(pixel((FACE, 0.0, 1.0))).astype(int)
    added[row - 8 : row + 9, column - 12 : column + 13] = 0
    assert added.max() == 0
