from __future__ import annotations

import math

import genpy
import pytest
from control_msgs.msg import FollowJointTrajectoryGoal, FollowJointTrajectoryResult, JointTolerance
from hypothesis import given
from hypothesis import strategies as st
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from telex_control.trajectory.path import JointPath, Track
from telex_control.trajectory.spline import SplineSegment, State
from telex_control.trajectory.tolerances import (
    StateTolerance,
    Tolerances,
    read_tolerances,
    with_goal,
)
from telex_control.trajectory.waypoints import Bounds, TrajectoryError, read_tracks

numbers = st.floats(-10.0, 10.0)


@given(numbers, numbers, st.floats(0.01, 20.0), st.floats(0.0, 1.0))
def test_positions_alone_give_a_straight_line(start, end, duration, share):
    segment = SplineSegment(3.0, State(start), 3.0 + duration, State(end))
    position, velocity, acceleration = segment.sample(3.0 + share * duration)
    assert position == pytest.approx(start + share * (end - start), abs=1e-6)
    assert velocity == pytest.approx((end - start) / duration, abs=1e-6)
    assert acceleration == 0.0


@given(numbers, numbers, numbers, numbers, st.floats(0.1, 20.0))
def test_velocities_give_a_cubic_that_meets_both_ends(p0, v0, p1, v1, duration):
    segment = SplineSegment(1.0, State(p0, v0), 1.0 + duration, State(p1, v1))
    assert segment.sample(1.0)[:2] == pytest.approx((p0, v0), abs=1e-5)
    assert segment.sample(1.0 + duration)[:2] == pytest.approx((p1, v1), abs=1e-5)
    # a cubic: its acceleration is linear in time
    a, b, c = (segment.sample(1.0 + x * duration)[2] for x in (0.1, 0.5, 0.9))
    assert a + c == pytest.approx(2.0 * b, abs=1e-4 * max(1.0, abs(a), abs(c)))


@given(numbers, numbers, numbers, numbers, numbers, numbers, st.floats(0.1, 20.0))
def test_accelerations_give_a_quintic_that_meets_both_ends(p0, v0, a0, p1, v1, a1, duration):
    segment = SplineSegment(0.0, State(p0, v0, a0), duration, State(p1, v1, a1))
    assert segment.sample(0.0) == pytest.approx((p0, v0, a0), abs=1e-5)
    assert segment.sample(duration) == pytest.approx((p1, v1, a1), abs=1e-3)


@pytest.mark.parametrize(
    ("start", "end"),
    [
        (State(1.0), State(-2.0)),
        (State(1.0, 0.5), State(-2.0, 0.1)),
        (State(1.0, 0.5, -1.0), State(-2.0, 0.1, 3.0)),
    ],
)
def test_velocity_and_acceleration_are_the_derivatives_of_the_position(start, end):
    segment = SplineSegment(0.0, start, 2.0, end)
    step = 1e-5
    for time in (0.3, 1.0, 1.7):
        before, now, after = (segment.sample(time + k * step) for k in (-1, 0, 1))
        assert now[1] == pytest.approx((after[0] - before[0]) / (2 * step), abs=1e-6)
        assert now[2] == pytest.approx((after[1] - before[1]) / (2 * step), abs=1e-5)


def test_what_only_one_end_knows_is_not_used():
    assert SplineSegment(0.0, State(0.0, 5.0), 1.0, State(1.0)).sample(0.0) == (0.0, 1.0, 0.0)
    cubic = SplineSegment(0.0, State(0.0, 5.0, 7.0), 1.0, State(1.0, 0.0))
    assert cubic.sample(0.0) == SplineSegment(0.0, State(0.0, 5.0), 1.0, State(1.0, 0.0)).sample(
        0.0
    )


def test_outside_of_its_time_a_segment_rests_at_its_ends():
    segment = SplineSegment(1.0, State(1.0, 2.0, 3.0), 2.0, State(4.0, 5.0, 6.0))
    assert segment.sample(0.999) == (1.0, 0.0, 0.0)
    assert segment.sample(2.001) == (4.0, 0.0, 0.0)


def test_a_segment_without_duration_is_at_its_end():
    segment = SplineSegment(1.0, State(0.0), 1.0, State(3.0, 1.0, 2.0))
    assert segment.sample(1.0) == (3.0, 1.0, 2.0)
    assert segment.sample(1.5) == (3.0, 0.0, 0.0)
    assert segment.sample(0.5) == (0.0, 0.0, 0.0)


def test_a_segment_cannot_end_before_it_starts():
    with pytest.raises(ValueError, match="ends before it starts"):
        SplineSegment(1.0, State(0.0), 0.9, State(1.0))


# --- paths -----------------------------------------------------------------------------------


def track(*points):
    return Track([time for time, *_ in points], [State(*state) for _, *state in points])


def ramp(*points):
    return JointPath.hold(0.0, 0.0).replaced(0.0, track(*points), 0, 0.0, False)


def test_a_path_holds_its_last_position():
    path = JointPath.hold(5.0, 0.7)
    assert path.sample(4.0) == path.sample(5.0) == path.sample(500.0) == (0.7, 0.0, 0.0)


def test_a_path_goes_through_its_waypoints():
    path = ramp((1.0, 1.0), (3.0, 0.0))
    assert [path.sample(time)[0] for time in (0.5, 1.0, 2.0, 3.0, 9.0)] == pytest.approx(
        [0.5, 1.0, 0.5, 0.0, 0.0]
    )
    assert path.end_time == 3.0
    # back in time, and from elsewhere, without disturbing the loop's place
    assert path.sample(0.5)[0] == pytest.approx(0.5)
    assert path.sample_at(2.5)[0] == pytest.approx(0.25)
    assert path.sample(0.6)[0] == pytest.approx(0.6)


def test_a_new_trajectory_takes_over_at_its_start_without_a_jump():
    path = ramp((1.0, 1.0), (2.0, 2.0))
    path.sample(1.2)
    path = path.replaced(1.5, track((1.0, 0.5), (2.0, 0.0)), 0, 1.5, False)
    assert path.sample(1.4)[0] == pytest.approx(1.4)  # still the old one
    assert path.sample(1.5)[0] == pytest.approx(1.5)
    assert path.sample(2.0)[0] == pytest.approx(1.0)  # on the bridge
    assert path.sample(3.0)[0] == pytest.approx(0.25)


def test_the_bridge_starts_with_the_velocity_that_it_finds():
    path = ramp((2.0, 2.0)).replaced(1.0, track((2.0, 0.0, 0.0)), 0, 0.0, False)
    assert path.sample(1.0)[:2] == pytest.approx((1.0, 1.0))
    assert path.sample(2.0)[:2] == pytest.approx((0.0, 0.0))


def test_states_before_the_first_one_that_is_wanted_are_left_out():
    path = JointPath.hold(0.0, 0.0).replaced(
        5.5, track((1.0, 9.0), (2.0, 1.0), (3.0, 3.0), (4.0, 4.0)), 1, 4.0, False
    )
    assert [path.sample(time)[0] for time in (5.75, 6.0, 6.5, 7.5, 9.0)] == pytest.approx(
        [0.5, 1.0, 2.0, 3.5, 4.0]
    )
    assert [path.sample_at(time)[0] for time in (9.0, 7.5, 6.5, 6.0, 5.75, 1.0)] == pytest.approx(
        [4.0, 3.5, 2.0, 1.0, 0.5, 0.0]
    )
    assert path.sample(6.25)[0] == pytest.approx(1.5)  # back in time


@given(st.integers(0, 10**9), st.integers(1, 1000), st.floats(0.0, 1.0))
def test_far_from_zero_time_is_as_fine_as_its_numbers(seconds, milliseconds, share):
    origin = seconds + 0.123
    path = JointPath.hold(origin, 0.0).replaced(
        origin, track((0.0, 0.0), (0.001 * milliseconds, 1.0), (2.0, 3.0)), 0, origin, False
    )
    time = origin + 0.001 * milliseconds * share
    slope = 1000.0 / milliseconds
    assert path.sample(time)[0] == pytest.approx(share, abs=1e-6 * slope + 1e-9)
    assert path.sample_at(time)[0] == pytest.approx(path.sample(time)[0], abs=1e-6 * slope)
    assert path.sample(origin)[1] == pytest.approx(slope)


def test_what_a_new_trajectory_cuts_off_never_happens():
    path = ramp((1.0, 1.0), (2.0, 9.0), (3.0, -9.0))
    path = path.replaced(0.5, track((1.0, 0.5)), 0, 0.5, False)
    assert all(0.0 <= path.sample(0.01 * k)[0] <= 0.5 + 1e-9 for k in range(400))


def test_a_waypoint_at_the_start_itself_is_there_at_once():
    path = ramp((1.0, 1.0)).replaced(0.5, track((0.0, 3.0), (1.0, 4.0)), 0, 0.5, False)
    assert path.sample(0.499)[0] == pytest.approx(0.499)
    assert path.sample(0.5)[0] == 3.0
    assert path.sample(1.0)[0] == pytest.approx(3.5)


@given(st.floats(-30.0, 30.0), st.floats(-30.0, 30.0))
def test_joints_that_wrap_take_the_nearest_turn(position, target):
    path = JointPath.hold(0.0, position).replaced(
        0.0, track((1.0, target), (2.0, target + 0.5)), 0, 0.0, True
    )
    first, second = path.sample(1.0)[0], path.sample(2.0)[0]
    assert abs(first - position) <= math.pi + 1e-9
    assert math.remainder(first - target, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-9)
    assert second - first == pytest.approx(0.5)


def test_stopping_slows_down_evenly():
    path = JointPath.stop(1.0, 0.5, 2.0, -0.4)
    samples = [path.sample(1.0 + 0.05 * k) for k in range(11)]
    assert samples[0][:2] == pytest.approx((2.0, -0.4))
    assert [a for _, _, a in samples] == pytest.approx([0.8] * 11)
    assert samples[-1][:2] == pytest.approx((1.9, 0.0))
    assert path.sample(9.0) == (pytest.approx(1.9), 0.0, 0.0)


def test_stopping_stays_inside_the_limits():
    assert JointPath.stop(0.0, 1.0, 0.9, 5.0, upper=1.0).sample(2.0)[0] == 1.0


# --- messages --------------------------------------------------------------------------------


def trajectory(*points, names=("a", "b"), stamp=0.0):
    message = JointTrajectory(joint_names=list(names))
    message.header.stamp = genpy.Time.from_sec(stamp)
    for time, positions, *rest in points:
        message.points.append(
            JointTrajectoryPoint(
                positions=positions,
                velocities=rest[0] if rest else [],
                accelerations=rest[1] if len(rest) > 1 else [],
                time_from_start=genpy.Duration.from_sec(time),
            )
        )
    return message


def bounds(*names):
    return {name: Bounds(-2.0 * math.pi, 2.0 * math.pi, 3.0) for name in names}


def test_waypoints_come_by_joint_whatever_their_order():
    read = read_tracks(
        trajectory((1.0, [1, 2], [3, 4], [5, 6]), (2.5, [7, 8]), names=("b", "a")),
        bounds("a", "b"),
        False,
    )
    assert read["a"] == track((1.0, 2, 4, 6), (2.5, 8))
    assert read["b"] == track((1.0, 1, 3, 5), (2.5, 7))


def test_some_joints_are_enough_when_that_is_allowed():
    assert list(read_tracks(trajectory((1.0, [1]), names=["b"]), bounds("a", "b"), True)) == ["b"]


@pytest.mark.parametrize(
    ("message", "partial", "code", "text"),
    [
        (trajectory((1.0, [1]), names=["a"]), False, -2, "'b' is missing"),
        (trajectory((1.0, []), names=[]), True, -2, "is missing"),
        (trajectory((1.0, [1, 2]), names=["a", "c"]), True, -2, "'c' is unknown"),
        (trajectory((1.0, [1, 2, 3]), names=["a", "b", "a"]), False, -2, "twice"),
        (trajectory((1.0, [1])), False, -1, "1 positions; 2 are needed"),
        (trajectory((1.0, [])), False, -1, "0 positions"),
        (trajectory((1.0, [1, 2], [1])), False, -1, "1 velocities"),
        (trajectory((1.0, [1, 2], [1, 2], [1, 2, 3])), False, -1, "3 accelerations"),
        (trajectory((1.0, [1, math.nan])), False, -1, "positions of joint 'b' is nan"),
        (trajectory((1.0, [1, 2], [math.inf, 0])), False, -1, "velocities of joint 'a' is inf"),
        (trajectory((1.0, [1, 2]), (1.0, [1, 2])), False, -1, "point 1 has time_from_start 1 s"),
        (trajectory((1.0, [1, 2]), (0.5, [1, 2])), False, -1, "after that of the point before"),
        (trajectory((-1e9, [1, 2]), (1.0, [1, 2])), False, -1, "at most 86400 s"),
        (trajectory((1.0, [1e308, 2])), False, -1, "'a' is 1e.308, which is more than 100 beyond"),
        (trajectory((1.0, [1, 2], [0, -301.0])), False, -1, "'b' is -301.0, .* 100 times the"),
        (trajectory((1.0, [1, 2], [0, 0], [1e39, 0])), False, -1, "accelerations of joint 'a'"),
        (trajectory((1e9, [1, 2])), False, -1, "at most 86400 s"),
    ],
)
def test_wrong_trajectories_are_refused_with_their_code(message, partial, code, text):
    with pytest.raises(TrajectoryError, match=text) as caught:
        read_tracks(message, bounds("a", "b"), partial)
    assert caught.value.code == code


# --- tolerances ------------------------------------------------------------------------------


def test_zero_checks_nothing():
    assert StateTolerance().allows(1e9, 1e9)
    assert StateTolerance(0.1).allows(-0.1, 1e9)
    assert not StateTolerance(0.1).allows(-0.11, 0.0)
    assert not StateTolerance(0.0, 0.2).allows(0.0, -0.3)


def test_tolerances_from_parameters():
    read = read_tolerances(
        {"goal_time": 2, "a": {"goal": 0.1}, "b": {"trajectory": 0.3}}, "/c", ("a", "b")
    )
    assert read.path == {"a": StateTolerance(), "b": StateTolerance(0.3)}
    assert read.goal == {"a": StateTolerance(0.1, 0.01), "b": StateTolerance(0.0, 0.01)}
    assert read.goal_time == 2.0


@pytest.mark.parametrize(
    ("params", "text"),
    [
        ({"goal_time": -1.0}, "/c/goal_time is -1.0"),
        ({"goal_time": "late"}, "/c/goal_time is 'late'"),
        ({"a": {"goal": math.nan}}, "/c/a/goal is nan"),
        ({"a": {"path": 1.0}}, "/c/a is {'path': 1.0}"),
        ({"a": 0.1}, "/c/a is 0.1"),
        ({"z": {"goal": 0.1}}, "/c/z is unknown"),
    ],
)
def test_wrong_tolerances_are_named(params, text):
    with pytest.raises(ValueError, match=text):
        read_tolerances(params, "/c", ("a", "b"))


def test_a_goal_overrides_clears_or_keeps_tolerances():
    defaults = Tolerances(
        {"a": StateTolerance(0.1, 0.2)}, {"a": StateTolerance(0.3, 0.4)}, goal_time=5.0
    )
    goal = FollowJointTrajectoryGoal(
        path_tolerance=[JointTolerance("a", 1.0, -1.0, 0.0), JointTolerance("z", 9.0, 9.0, 9.0)],
        goal_tolerance=[JointTolerance("a", -1.0, 0.0, 0.0)],
        goal_time_tolerance=genpy.Duration(0),
    )
    merged = with_goal(defaults, goal)
    assert merged.path == {"a": StateTolerance(1.0, 0.0)}
    assert merged.goal == {"a": StateTolerance(0.0, 0.4)}
    assert merged.goal_time == 5.0
    goal.goal_time_tolerance = genpy.Duration(-1)
    assert with_goal(defaults, goal).goal_time == 0.0
    goal.goal_time_tolerance = genpy.Duration(3)
    assert with_goal(defaults, goal).goal_time == 3.0


def test_a_tolerance_that_is_no_number_is_refused():
    goal = FollowJointTrajectoryGoal(path_tolerance=[JointTolerance("a", math.nan, 0.0, 0.0)])
    with pytest.raises(TrajectoryError, match="nan") as caught:
        with_goal(Tolerances({"a": StateTolerance()}, {}), goal)
    assert caught.value.code == FollowJointTrajectoryResult.INVALID_GOAL
