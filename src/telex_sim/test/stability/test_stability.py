"""The force-angle measure against cases computed by hand, and the detectors of trouble."""

from __future__ import annotations

import math

import pytest

from telex_control.common.params import ConfigError, read_config
from telex_sim.stability.force_angle import StabilityConfig, force_angle, support_polygon
from telex_sim.stability.mobility_watch import StuckDetector, TipOverDetector

SQUARE = [(-0.3, -0.2, 0.0), (0.3, -0.2, 0.0), (0.3, 0.2, 0.0), (-0.3, 0.2, 0.0)]
WIDE = [(x, 3.0 * y, z) for x, y, z in SQUARE]
WEIGHT = 800.0
DOWN = (0.0, 0.0, -WEIGHT)
NONE = (0.0, 0.0, 0.0)


def tilted(points, angle):
    """Points turned about the x axis: the left side comes up."""
    c, s = math.cos(angle), math.sin(angle)
    return [(x, y * c - z * s, y * s + z * c) for x, y, z in points]


def test_the_polygon_is_the_hull_seen_from_above_with_its_heights():
    inner = [(0.0, 0.0, 0.5), (0.1, 0.1, 0.0), (0.0, -0.2, 0.0)]
    raised = [(x, y, 0.1 * index) for index, (x, y, _) in enumerate(SQUARE)]
    assert support_polygon([*inner, *raised[::-1]]) == raised


def test_points_that_are_almost_one_and_corners_that_are_almost_none_count_once():
    doubles = [(x + 1e-3, y - 1e-3, z + 1e-3) for x, y, z in SQUARE]
    bulge = (0.0, -0.202, 0.0)
    assert support_polygon([*SQUARE, bulge, *doubles]) == SQUARE


@pytest.mark.parametrize(
    ("points", "corners"),
    [
        ([], 0),
        ([(1.0, 2.0, 0.0)], 1),
        ([(0.0, 0.0, 0.0), (0.5, 0.0, 0.1), (1.0, 0.0, 0.2)], 2),
        ([(0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.5, 0.0)], 2),
    ],
)
def test_what_is_no_polygon_has_few_corners(points, corners):
    assert len(support_polygon(points)) == corners


def test_level_the_measure_is_angle_times_weight_times_distance():
    found = force_angle(SQUARE, (0.05, -0.01, 0.25), DOWN, NONE)
    angle = math.atan2(0.19, 0.25)  # over the right side, which is nearest
    assert found.angle == pytest.approx(angle)
    assert found.measure == pytest.approx(angle * WEIGHT * 0.19)
    assert found.outward == pytest.approx((0.0, -1.0))


def test_a_heavy_top_heavy_robot_is_less_stable_by_angle():
    low = force_angle(SQUARE, (0, 0, 0.2), DOWN, NONE)
    high = force_angle(SQUARE, (0, 0, 0.6), DOWN, NONE)
    assert high.measure < low.measure


@pytest.mark.parametrize(
    ("height", "tips_at"), [(0.2, math.atan2(0.2, 0.2)), (0.4, math.atan2(0.2, 0.4))]
)
def test_on_a_cross_slope_it_tips_where_the_weight_passes_the_lower_edge(height, tips_at):
    def measure(angle):
        polygon = tilted(SQUARE, angle)
        (center,) = tilted([(0.0, 0.0, height)], angle)
        return force_angle(support_polygon(polygon), center, DOWN, NONE)

    assert measure(tips_at - 1e-3).measure > 0.0
    assert measure(tips_at - 1e-3).angle == pytest.approx(1e-3)
    assert measure(tips_at + 1e-3).measure < 0.0
    assert measure(0.2).outward == pytest.approx((0.0, -1.0))  # its left side is up
    assert measure(-0.2).outward == pytest.approx((0.0, 1.0))


def test_braking_tips_it_forwards():
    mass, deceleration, height = WEIGHT / 9.81, 2.0, 0.5
    inertia = (mass * deceleration, 0.0, -WEIGHT)
    found = force_angle(SQUARE, (0.0, 0.0, height), inertia, NONE)
    lean = math.atan2(deceleration, 9.81)
    assert found.outward == pytest.approx((1.0, 0.0))
    assert found.angle == pytest.approx(math.atan2(0.3, height) - lean)


def test_a_moment_counts_as_the_force_that_would_have_it():
    # A load of 100 N, 0.8 m in front of the centre of mass, pulls down on the arm.
    force, moment = (0.0, 0.0, -WEIGHT - 100.0), (0.0, 80.0, 0.0)
    found = force_angle(WIDE, (0.0, 0.0, 0.25), force, moment)
    # It tips where weight and load balance about the front edge: 800 * 0.3 = 100 * (d - 0.3).
    assert found.outward == pytest.approx((1.0, 0.0))
    assert found.measure > 0.0
    limit = 800.0 * 0.3 / 100.0 + 0.3
    for distance, stable in ((limit - 0.01, True), (limit + 0.01, False)):
        moved = force_angle(WIDE, (0.0, 0.0, 0.25), force, (0.0, 100.0 * distance, 0.0))
        assert (moved.measure > 0.0) is stable


def test_a_push_from_the_left_tips_it_to_the_right():
    found = force_angle(SQUARE, (0.0, 0.0, 0.25), (0.0, -700.0, -WEIGHT), NONE)
    assert found.measure < 0.0
    assert found.outward == pytest.approx((0.0, -1.0))


def test_corners_at_different_heights_count_as_they_are():
    # As on stairs: the front carries 0.3 m higher than the rear, along the slope.
    polygon = [(x, y, 0.15 if x > 0 else -0.15) for x, y, _ in WIDE]
    center = (0.0, 0.0, 0.25)
    found = force_angle(polygon, center, DOWN, NONE)
    assert found.outward == pytest.approx((-1.0, 0.0))
    assert found.angle == pytest.approx(math.atan2(0.3, 0.25 + 0.15))


def test_on_a_line_it_is_not_stable_and_on_less_there_is_no_measure():
    edge = support_polygon([(-0.3, 0.0, 0.0), (0.3, 0.0, 0.0)])
    assert force_angle(edge, (0.0, 0.05, 0.3), DOWN, NONE).measure < 0.0
    assert force_angle(edge, (0.0, 0.0, 0.3), DOWN, NONE).measure == pytest.approx(0.0)
    assert force_angle(support_polygon([(0.0, 0.0, 0.0)]), (0, 0, 1), DOWN, NONE) is None
    assert force_angle([], (0, 0, 1), DOWN, NONE) is None


def test_in_free_fall_nothing_holds_it():
    assert force_angle(SQUARE, (0.0, 0.0, 0.25), NONE, NONE).measure == 0.0


# --- detectors -------------------------------------------------------------------------------

CONFIG = StabilityConfig(tipped_angle=1.2, tipped_time=0.5, stuck_time=2.0, stuck_ratio=0.1)


def test_it_has_tipped_over_when_it_stays_tilted():
    detector = TipOverDetector(CONFIG)
    seen = []
    for tick in range(20):
        detector.update(0.1 * tick, 1.3 if 5 <= tick < 15 else 0.7)
        seen.append(detector.tipped)
    assert seen == [False] * 10 + [True] * 5 + [False] * 5


def test_a_moment_of_tilt_is_no_tip_over():
    detector = TipOverDetector(CONFIG)
    for tick in range(40):
        detector.update(0.1 * tick, 1.3 if tick % 4 else 0.0)
        assert not detector.tipped


class Stretch:
    """Feeds a detector at 10 Hz; `belt` is the speed of both belts, or a pair (left, right)."""

    def __init__(self):
        self.detector = StuckDetector(CONFIG, 0.2)
        self.time = self.x = self.heading = 0.0

    def go(self, seconds, belt, speed=0.0, rate=0.0):
        """Move on, and return for how long it was stuck (s)."""
        stuck = 0
        for _ in range(round(seconds * 10)):
            self.time += 0.1
            self.x += 0.1 * speed
            self.heading = math.remainder(self.heading + 0.1 * rate, math.tau)
            belts = belt if isinstance(belt, tuple) else (belt, belt)
            self.detector.update(self.time, (self.x, 0.0, 0.0), self.heading, belts)
            stuck += self.detector.stuck
        return 0.1 * stuck


def test_belts_that_run_without_effect_mean_stuck_after_a_while():
    stretch = Stretch()
    assert stretch.go(2.0, belt=0.3) == 0.0
    assert stretch.go(1.0, belt=0.3, speed=0.01) == pytest.approx(1.0)


def test_driving_turning_and_standing_are_not_stuck():
    stretch = Stretch()
    assert stretch.go(5.0, belt=0.3, speed=0.28) == 0.0
    assert stretch.go(10.0, belt=(-0.4, 0.4), rate=0.5) == 0.0
    assert stretch.go(5.0, belt=0.0) == 0.0
    assert stretch.go(5.0, belt=0.01) == 0.0  # creeps
    assert stretch.go(5.0, belt=0.3, speed=0.1) == 0.0  # with much slip


def test_it_is_no_longer_stuck_when_it_gets_away_or_gives_up():
    stretch = Stretch()
    assert stretch.go(4.0, belt=0.3) > 1.5
    assert stretch.go(1.0, belt=0.3, speed=0.3) < 0.5
    stretch.go(4.0, belt=0.3)
    assert stretch.detector.stuck
    stretch.go(0.1, belt=0.0)
    assert not stretch.detector.stuck


def test_rocking_in_one_place_is_stuck():
    stretch = Stretch()
    for _ in range(6):
        stretch.go(0.5, belt=0.3, speed=0.02)
        stretch.go(0.5, belt=-0.3, speed=-0.02)
    assert stretch.detector.stuck


@pytest.mark.parametrize("period", [0.2, 0.5, 1.0, 3.0])
def test_jockeying_is_not_stuck(period):
    stretch, stuck = Stretch(), 0.0
    for _ in range(round(12.0 / period)):
        for sign in (1.0, -1.0):
            stuck += stretch.go(0.5 * period, belt=0.5 * sign, speed=0.45 * sign)
    for _ in range(round(12.0 / period)):
        for sign in (1.0, -1.0):
            stuck += stretch.go(0.5 * period, belt=(-0.3 * sign, 0.3 * sign), rate=0.8 * sign)
    assert stuck == 0.0


def test_turning_to_and_fro_in_vain_is_stuck():
    stretch = Stretch()
    for _ in range(4):
        for sign in (1.0, -1.0):
            stretch.go(0.5, belt=(-0.3 * sign, 0.3 * sign), rate=0.02 * sign)
    assert stretch.detector.stuck


def test_one_belt_that_runs_in_vain_is_stuck():
    stretch = Stretch()
    assert stretch.go(4.0, belt=(0.0, 0.3)) > 1.5


@pytest.mark.parametrize(
    ("params", "message"),
    [
        ({"warning_ahead": -0.1}, "warning_ahead is -0.1"),
        ({"smoothing_time": -0.1}, "smoothing_time is -0.1"),
        ({"tipped_angle": 0.0}, "tipped_angle is 0.0"),
        ({"stuck_ratio": 1.5}, "stuck_ratio is 1.5"),
        ({"stuck_time": math.nan}, "stuck_time is nan"),
        ({"stuck": True}, "stuck is unknown"),
    ],
)
def test_wrong_parameters_are_named(params, message):
    with pytest.raises(ConfigError, match=message):
        read_config(StabilityConfig, params, "stability")
