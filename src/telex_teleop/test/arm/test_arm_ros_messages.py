"""What arm_teleop makes of messages on what is near, and of joints in requests; what it refuses."""

import math

import numpy as np
import pytest
from telex_msgs.msg import Proximity, ProximityPair

from telex_teleop.motion.joint_jog import InvalidCommand
from telex_teleop.ros.arm_teleop_node import proximity_state
from telex_teleop.ros.kinematics_services import given_positions


def message(**pair):
    near = Proximity(joints=["a", "b"], positions=[0.1, 0.2])
    near.header.stamp.secs = 3
    given = {"link": "gripper_link", "other": "wall", "distance": 0.04, "gradient": [0.5, -1.0]}
    near.pairs = [ProximityPair(**{**given, **pair})]
    near.pairs[0].normal.x = -1.0
    near.pairs[0].point.y = 2.0
    return near


def test_pairs_are_taken_with_what_the_base_does_to_them():
    state = proximity_state(message(contact=ProximityPair.TOUCHABLE), ["base_link"])
    [pair] = state.pairs
    assert (state.stamp, dict(state.positions)) == (3.0, {"a": 0.1, "b": 0.2})
    assert (pair.link, pair.other, pair.touchable, pair.distance) == (
        "gripper_link",
        "wall",
        True,
        0.04,
    )
    assert dict(pair.gradient) == {"a": 0.5, "b": -1.0}
    # a base that goes forward brings the wall nearer, and one that turns left takes it away
    assert np.array(pair.base_gradient) == pytest.approx([-1, 0, 0, 0, 0, 2])


def test_what_rides_on_the_base_is_not_moved_by_it():
    state = proximity_state(message(other="base_link"), ["base_link"])
    assert state.pairs[0].base_gradient == (0.0,) * 6


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"gradient": [0.5]}, "gradient has 1 numbers for 2 joints"),
        ({"gradient": [0.5, math.nan]}, "a number of gripper_link and wall is nan"),
        ({"distance": math.inf}, "a number of gripper_link and wall is inf"),
    ],
)
def test_pairs_that_make_no_sense_are_refused(change, says):
    with pytest.raises(InvalidCommand, match=says):
        proximity_state(message(**change), [])


@pytest.mark.parametrize(
    ("positions", "says"),
    [([0.1], "positions has 1 numbers for 2 joints"), ([0.1, math.nan], "position of b is nan")],
)
def test_positions_that_make_no_sense_are_refused(positions, says):
    near = message()
    near.positions = positions
    with pytest.raises(InvalidCommand, match=says):
        proximity_state(near, [])


def test_positions_of_a_request_are_by_joint():
    assert given_positions("seed_names", ["b", "a"], [0.5, -1e4], ["a", "b", "c"]) == {
        "a": -1e4,
        "b": 0.5,
    }


@pytest.mark.parametrize(
    ("names", "values", "says"),
    [
        (["a"], [0.0, 1.0], "2 positions for 1 joint names"),
        (["x"], [0.0], "joint 'x' does not carry the tool; these do: a, b"),
        (["a", "b", "a"], [0.0, 0.0, 1.0], "seed_names: a stands there twice; give it once"),
        (["a"], [math.nan], "position of a is nan; must be a finite number, of at most 10000"),
        (["b"], [-1e5], "position of b is -100000.0; must be a finite number, of at most 10000"),
    ],
)
def test_positions_that_mean_nothing_are_refused(names, values, says):
    with pytest.raises(InvalidCommand, match=says):
        given_positions("seed_names", names, values, ["a", "b"])
