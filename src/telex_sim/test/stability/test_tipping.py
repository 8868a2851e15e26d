"""How far a robot may still rotate, and when it is warned."""

from __future__ import annotations

import math

import numpy as np
import pytest

from telex_sim.stability.force_angle import StabilityConfig, force_angles, support_polygon
from telex_sim.stability.mobility_watch import TipOverWarning
from telex_sim.stability.tipping import NO_FOOTHOLDS, Footholds, TippingAngle, tipping_angle

UP = (0.0, 0.0, 1.0)
WEIGHT = (0.0, 0.0, -1000.0)
NO_MOMENT = (0.0, 0.0, 0.0)
TABLE = support_polygon([(x, y, 0.0) for x in (-0.4, 0.4) for y in (-0.2, 0.2)])


def angle(center, footholds=(), polygon=TABLE, axes=None, force=WEIGHT):
    edges = force_angles(polygon, center, force, NO_MOMENT)
    columns = zip(*footholds) if footholds else NO_FOOTHOLDS
    footholds = Footholds(*map(np.array, columns))
    return tipping_angle(edges, center, footholds, np.eye(3) if axes is None else axes)


def foothold(point, ground, normal, gap):
    """A foothold, as a row of `Footholds`."""
    return point, ground, normal, gap


def test_without_footholds_it_is_the_angle_of_the_force_at_each_edge():
    found = angle((0.1, 0.05, 0.3))
    assert found.ahead == pytest.approx(math.atan2(0.3, 0.3))
    assert found.sideways == pytest.approx(math.atan2(0.15, 0.3))
    assert found.ahead_direction == pytest.approx(0.0)
    assert found.sideways_direction == pytest.approx(0.5 * math.pi)


def test_ahead_is_where_the_robot_looks():
    turned = np.array([(0.0, 1.0, 0.0), (-1.0, 0.0, 0.0), UP])
    along, across = angle((0.1, 0.05, 0.3), axes=turned), angle((0.1, 0.05, 0.3))
    assert (along.ahead, along.sideways) == pytest.approx((across.sideways, across.ahead))


def test_nothing_carries_it():
    assert angle((0.0, 0.0, 0.3), polygon=[]) is None
    assert angle((0.0, 0.0, 0.3), polygon=[(0.0, 0.0, 0.0)]) is None


def test_what_stands_near_catches_a_robot_that_has_passed_its_edge():
    center = (0.5, 0.0, 0.3)
    falling = angle(center)
    assert falling.ahead == pytest.approx(-math.atan2(0.1, 0.3))
    # A flipper whose tip is 5 cm over the ground, 0.5 m before the edge that it pivots over.
    tip = foothold((0.9, 0.0, 0.05), (0.9, 0.0, 0.0), UP, 0.05)
    caught = angle(center, [tip])
    down = 0.05 / 0.5
    x = 0.1 * math.cos(down) + 0.3 * math.sin(down)
    z = 0.3 * math.cos(down) - 0.1 * math.sin(down)
    tip_x = 0.5 * math.cos(down) + 0.05 * math.sin(down)
    assert caught.ahead == pytest.approx(math.atan2(tip_x - x, z), abs=0.01)
    assert caught.sideways == falling.sideways


@pytest.mark.parametrize(
    "place",
    [
        # behind the edge, so far away that the robot lies on its nose then, and a wall's face
        foothold((0.2, 0.0, 0.05), (0.2, 0.0, 0.0), UP, 0.05),
        foothold((0.5, 0.0, 0.25), (0.5, 0.0, -0.05), UP, 0.3),
        foothold((0.9, 0.0, 0.05), (0.95, 0.0, 0.05), (-1.0, 0.0, 0.0), 0.05),
    ],
)
def test_what_does_not_catch_it_changes_nothing(place):
    center = (0.5, 0.0, 0.3)
    assert angle(center, [place]) == angle(center)


def test_a_robot_that_would_lie_on_its_side_is_not_caught():
    center = (0.0, 0.21, 0.3)
    flank = foothold((0.0, 0.45, 0.08), (0.0, 0.45, 0.0), UP, 0.08)
    assert angle(center, [flank]).sideways > 0.0
    assert angle(center, [flank], axes=_rolled(-0.9)) == angle(center, axes=_rolled(-0.9))


def _rolled(roll):
    sine, cosine = math.sin(roll), math.cos(roll)
    return np.array([(1.0, 0.0, 0.0), (0.0, cosine, sine), (0.0, -sine, cosine)])


CONFIG = StabilityConfig(
    smoothing_time=0.3,
    warning_ahead=0.28,
    warning_ahead_time=0.7,
    warning_sideways=0.35,
    warning_sideways_time=0.05,
    warning_sideways_foresight=0.5,
    warning_hold=0.5,
)
SAFE = TippingAngle(0.6, 0.6, 0.0, 0.0)
RIGHT = -0.5 * math.pi


def feed(warning, begin, seconds, tipping, margin=1.0, turning=(0.0, 0.0)):
    """Look at it 20 times a second; returns when it was warned first."""
    first = None
    for look in range(round(seconds / 0.05)):
        time = begin + 0.05 * look
        warning.update(time, tipping, margin, turning)
        if warning.warned and first is None:
            first = time
    return first


def test_rocking_ahead_is_no_tipping_until_it_lasts():
    warning = TipOverWarning(CONFIG)
    assert feed(warning, 0.0, 1.0, SAFE) is None
    assert feed(warning, 1.0, 0.6, TippingAngle(-0.2, 0.6, math.pi, RIGHT)) is None
    assert feed(warning, 1.6, 0.5, SAFE) is None
    assert feed(warning, 2.1, 1.0, TippingAngle(0.2, 0.6, math.pi, RIGHT)) == pytest.approx(2.8)
    assert warning.direction == math.pi


def test_sideways_it_warns_at_once_and_for_a_while():
    warning = TipOverWarning(CONFIG)
    feed(warning, 0.0, 1.0, SAFE)
    assert feed(warning, 1.0, 0.2, TippingAngle(0.6, 0.3, math.pi, RIGHT)) == pytest.approx(1.05)
    feed(warning, 1.2, 0.45, SAFE)
    assert warning.warned
    assert warning.direction == RIGHT
    feed(warning, 1.65, 0.2, SAFE)
    assert not warning.warned


def test_it_warns_sooner_while_it_turns_over_that_side():
    # 0.5 rad to the right are left; half a second at 0.4 rad/s takes 0.2 of them.
    for turning, warned in (
        ((0.4, 0.0), pytest.approx(0.05)),
        ((-0.4, 0.0), None),  # back on its tracks
        ((0.0, 0.4), None),  # over its nose
        ((0.2, 0.0), None),
    ):
        right = TippingAngle(0.6, 0.5, math.pi, RIGHT)
        assert feed(TipOverWarning(CONFIG), 0.0, 0.5, right, turning=turning) == warned


def test_a_hop_is_no_tipping():
    warning = TipOverWarning(CONFIG)
    feed(warning, 0.0, 1.0, SAFE)
    assert feed(warning, 1.0, 0.5, None, margin=0.0) is None


def test_an_impact_leaves_the_margin():
    warning = TipOverWarning(CONFIG)
    feed(warning, 0.0, 2.0, SAFE)
    warning.update(2.0, SAFE, -3.0)
    assert warning.margin == pytest.approx(1.0 - 4.0 * (1.0 - math.exp(-0.05 / 0.3)), abs=1e-6)
    feed(warning, 2.05, 2.0, SAFE)
    assert warning.margin == pytest.approx(1.0, abs=0.01)


def test_what_was_before_a_pause_in_looking_is_forgotten():
    warning = TipOverWarning(CONFIG)
    feed(warning, 0.0, 1.0, TippingAngle(0.6, 0.1, math.pi, RIGHT))
    assert warning.warned
    warning.update(5.0, SAFE, 0.7)
    assert not warning.warned
    assert warning.margin == 0.7
    # The time stands still in a pause.
    warning.update(5.0, TippingAngle(0.6, 0.1, math.pi, RIGHT), 0.1)
    assert warning.margin == 0.7
