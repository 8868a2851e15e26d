"""What is near as bounds on the tool's twist."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from telex_teleop.arm.tool_clearance import scaled_clear, slid_clear, tool_effects

pytestmark = pytest.mark.slow

WALL = np.array([[-1.0, 0.0, 0.0, 0.0, 0.0, 0.0]])  # the tool's x closes it
CORNER = np.array([[-1.0, 0.0, 0.0, 0.0, 0.0, 0.0], [-0.6, -0.8, 0.0, 0.0, 0.0, 0.0]])


def test_what_does_not_close_in_is_free():
    twist = np.array([-0.1, 0.2, 0.0, 0.0, 0.0, 1.0])
    assert np.array_equal(slid_clear(twist, WALL, np.zeros(1)), twist)
    assert np.array_equal(scaled_clear(twist, WALL, np.zeros(1)), twist)


def test_only_what_closes_in_is_taken_away():
    twist = np.array([0.3, 0.2, -0.1, 0.0, 0.0, 1.0])
    assert slid_clear(twist, WALL, np.array([0.05])) == pytest.approx([0.05, 0.2, -0.1, 0, 0, 1])


def test_straight_way_is_slowed_as_a_whole():
    twist = np.array([0.3, 0.2, -0.1, 0.0, 0.0, 1.0])
    assert scaled_clear(twist, WALL, np.array([0.06])) == pytest.approx(0.2 * twist)


def test_in_a_corner_the_tool_slides_along_both_or_stops():
    up = slid_clear(np.array([0.3, 0.3, 0.2, 0.0, 0.0, 0.0]), CORNER, np.zeros(2))
    assert up[2] == pytest.approx(0.2)
    assert np.all(CORNER @ up >= -2e-4)


def test_rotation_is_slowed_and_moves_nothing():
    effects = np.array([[-0.5, 0.0, 0.0, 0.0, 0.0, -0.2]])
    twist = np.array([0.0, 0.0, 0.0, 0.0, 0.3, 1.0])
    assert slid_clear(twist, effects, np.array([0.05])) == pytest.approx(0.25 * twist)


numbers = st.floats(-1.0, 1.0)
rows = st.lists(st.tuples(st.tuples(*[numbers] * 6), st.floats(0.0, 0.3)), min_size=1, max_size=6)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(st.tuples(*[numbers] * 6), rows)
def test_no_distance_closes_faster_than_allowed_and_nothing_becomes_faster(twist, pairs):
    twist = np.array(twist)
    effects = np.array([row for row, _ in pairs])
    allowed = np.array([speed for _, speed in pairs])
    for clear in (slid_clear, scaled_clear):
        left = clear(twist, effects, allowed)
        assert np.all(-(effects @ left) <= allowed + 2e-4)
        for part in (slice(0, 3), slice(3, 6)):
            assert np.linalg.norm(left[part]) <= np.linalg.norm(twist[part]) + 1e-12


def test_effects_are_those_of_the_least_motion_of_the_joints():
    rng = np.random.default_rng(4)
    jacobian, gradients = rng.normal(size=(6, 7)), rng.normal(size=(3, 7))
    twist = rng.normal(size=6)
    rates = np.linalg.pinv(jacobian) @ twist
    expected = gradients @ rates
    assert tool_effects(gradients, jacobian) @ twist == pytest.approx(expected, abs=0.02)


def test_effects_stay_finite_in_a_singularity():
    jacobian = np.zeros((6, 7))
    jacobian[0, 0] = 1.0
    effects = tool_effects(np.ones((1, 7)), jacobian)
    assert effects == pytest.approx(np.array([[1.0, 0, 0, 0, 0, 0]]), abs=1e-3)
