"""Tracking tick by tick: speed limits, boundaries, statuses, twists."""

from __future__ import annotations

import math

import numpy as np
import pytest

from telex_control.kinematics import (
    Chain,
    Goal,
    IKOptions,
    IKSolver,
    IKStatus,
    KinematicsError,
    Tolerance,
    make_pose,
    move_pose,
)

pytestmark = pytest.mark.slow

DT = 0.02
SPEED = 0.7


def joint(index, kind, xyz, axis, lower, upper, speed=SPEED):
    return (
        f'<link name="l{index + 1}"/><joint name="j{index}" type="{kind}">'
        f'<parent link="l{index}"/><child link="l{index + 1}"/><origin xyz="{xyz}"/>'
        f'<axis xyz="{axis}"/><limit lower="{lower}" upper="{upper}" velocity="{speed}" '
        'effort="1"/></joint>'
    )


def chain(*joints):
    text = f'<robot name="r"><link name="l0"/>{"".join(joints)}</robot>'
    return Chain.from_urdf(text, "l0", f"l{len(joints)}")


ARM = (
    joint(0, "revolute", "0 0 0.3", "0 0 1", -3.5, 3.5),
    joint(1, "revolute", "0.04 0 0", "0 1 0", -3, 1),
    joint(2, "prismatic", "0 0 0.5", "0 0 1", 0, 0.3, 0.1),
    joint(3, "revolute", "0 0 0", "0 1 0", -3, 3),
    joint(4, "continuous", "0 0 0.46", "0 0 1", 0, 0, 1.5),
    joint(5, "revolute", "0 0 0", "0 1 0", -2.2, 2.2, 1.5),
    joint(6, "revolute", "0 0 0.3", "0 0 1", -6.3, 6.3, 1.5),
)
CHAIN = chain(*ARM)
BENT = np.array([0.3, -1.2, 0.1, 1.9, 0.4, 0.8, -0.5])


@pytest.fixture
def solver():
    return IKSolver(CHAIN)


def assert_kept(result, before, reach=CHAIN.velocity_limits * DT):
    """Neither a position limit nor a speed limit is passed, to the last bit but one."""
    assert (result.q >= CHAIN.lower).all()
    assert (result.q <= CHAIN.upper).all()
    assert (abs(result.q - before) <= reach * (1.0 + 1e-12)).all()
    assert result.velocity == pytest.approx((result.q - before) / DT)


def offset(pose, *change):
    moved = pose.copy()
    moved[:3, 3] += change
    return moved


# ---- reached, on the way


def test_a_near_target_is_reached_in_a_tick(solver):
    target = offset(CHAIN.forward(BENT), 0.002, 0.001, -0.001)
    result = solver.track(target, BENT, DT, acceleration_time=None)
    assert result.status is IKStatus.CONVERGED
    assert result.converged
    assert_kept(result, BENT)
    assert np.linalg.norm(CHAIN.forward(result.q)[:3, 3] - target[:3, 3]) < 1.1e-5
    assert result.at_limits == result.at_speed == ()
    assert result.margins == pytest.approx(
        np.minimum(result.q - CHAIN.lower, CHAIN.upper - result.q)
    )
    assert result.margins[4] == math.inf
    assert result.twist_ratio == 1.0


def test_a_target_reached_stays_reached_without_a_move(solver):
    result = solver.track(CHAIN.forward(BENT), BENT, DT)
    assert result.status is IKStatus.CONVERGED
    assert np.array_equal(result.q, BENT)


def test_a_far_target_is_approached_at_the_speed_limit(solver):
    target = offset(CHAIN.forward(BENT), 0.2, 0.1, 0.1)
    q, errors = BENT, []
    for _ in range(200):
        result = solver.track(target, q, DT, acceleration_time=None)
        assert_kept(result, q)
        q = result.q
        # What is lessened: lengths weighted, as IKOptions.length_weight says.
        errors.append(math.hypot(3.0 * result.position_error, result.orientation_error))
        if result.converged:
            break
        assert result.status is IKStatus.LAGGING
        assert result.at_speed
        moves = dict(zip(CHAIN.joint_names, abs(result.velocity) / CHAIN.velocity_limits))
        assert all(moves[name] == pytest.approx(1.0) for name in result.at_speed)
    assert result.converged
    assert len(errors) < 150
    assert errors == sorted(errors, reverse=True)


def test_a_spiral_within_reach_is_followed(solver):
    start = CHAIN.forward(BENT)
    q = BENT
    for tick in range(300):
        angle = 0.01 * tick
        target = offset(
            start, 0.05 * math.sin(angle), 0.05 * (1.0 - math.cos(angle)), 0.0004 * tick
        )
        result = solver.track(target, q, DT, acceleration_time=None)
        assert_kept(result, q)
        assert result.converged, tick
        q = result.q


def test_own_speed_limits_replace_those_of_the_urdf():
    slow = 0.1 * CHAIN.velocity_limits
    solver = IKSolver(CHAIN, velocity_limits=slow)
    result = solver.track(offset(CHAIN.forward(BENT), 0.3, 0.0, 0.0), BENT, DT)
    assert_kept(result, BENT, slow * DT)
    assert result.status is IKStatus.LAGGING


# ---- on the boundary


def test_a_target_that_leaves_and_returns_is_regained(solver):
    """Out along a line by 1.2 m, back, and on: no jump, and the target met again."""
    generator = np.random.default_rng(1)
    regained = 0
    for _ in range(5):
        posture = BENT + generator.normal(0.0, 0.2, 7)
        posture = np.clip(posture, CHAIN.lower, CHAIN.upper)
        start = CHAIN.forward(posture)
        direction = generator.normal(0.0, 1.0, 3)
        direction /= np.linalg.norm(direction)
        way = [*np.linspace(0.0, 1.2, 120), *np.linspace(1.2, 0.0, 120), *np.zeros(150)]
        q, away = posture, False
        for distance in way:
            target = offset(start, *(distance * direction))
            result = solver.track(target, q, DT, acceleration_time=None)
            assert_kept(result, q)
            q = result.q
            away = away or result.position_error > 0.05
        assert away
        regained += result.converged
    assert regained == 5


def test_out_of_reach_it_stands_at_the_boundary_and_says_so(solver):
    target = offset(CHAIN.forward(BENT), 1.0, 0.5, 3.0)
    q = BENT
    for _ in range(400):
        result = solver.track(target, q, DT, Tolerance.position_only())
        assert_kept(result, q)
        q = result.q
    assert result.status is IKStatus.BEST_EFFORT
    assert result.posture is None
    assert result.at_speed == ()
    # Stretched out towards it, the telescope against its end.
    assert "j2" in result.at_limits
    assert result.margins[2] == 0.0
    assert result.singular
    assert result.sigma < 0.05
    outward = target[:3, 3] - CHAIN.forward(q)[:3, 3]
    outward /= np.linalg.norm(outward)
    lost = result.singular_direction[:3] / np.linalg.norm(result.singular_direction[:3])
    assert abs(lost @ outward) > 0.98
    shoulder = np.array([0.04 * math.cos(q[0]), 0.04 * math.sin(q[0]), 0.3])
    reach = np.linalg.norm(CHAIN.forward(q)[:3, 3] - shoulder)
    assert reach == pytest.approx(0.5 + 0.3 + 0.46 + 0.3, abs=2e-3)


def test_a_target_for_another_posture_needs_reconfiguring(solver):
    """With the elbow against its limit, the hand reaches the target only bent the other way."""
    two = chain(
        joint(0, "revolute", "0 0 0", "0 0 1", -1.2, 0.8),
        joint(1, "revolute", "0.5 0 0", "0 0 1", -2.5, 2.5),
        joint(2, "prismatic", "0.5 0 0", "1 0 0", 0, 0.01),
    )
    tracker = IKSolver(two, IKOptions(reconfigure_after=None))
    goal = np.array([-0.9, 2.3, 0.0])
    target = two.forward(goal)
    q = np.array([0.5, -2.4, 0.0])
    statuses = []
    for _ in range(300):
        result = tracker.track(target, q, DT, Tolerance.position_only())
        q = result.q
        statuses.append(result.status)
        if result.status is IKStatus.NEEDS_RECONFIGURE:
            break
    assert statuses[-1] is IKStatus.NEEDS_RECONFIGURE
    assert result.position_error > 0.01
    # Nobody is moved there unasked; walked to, it is the target.
    for _ in range(100):
        q = tracker.track(target, q, DT, Tolerance.position_only()).q
    assert q[1] < 0.0
    distance = np.linalg.norm(two.forward(result.posture)[:3, 3] - target[:3, 3])
    assert distance < 1.1e-5
    assert tracker.track(target, result.posture, DT, Tolerance.position_only()).converged


@pytest.mark.parametrize("moving", [False, True])
def test_it_walks_to_the_other_posture_while_the_target_is_still(solver, moving):
    two = chain(
        joint(0, "revolute", "0 0 0", "0 0 1", -1.2, 0.8),
        joint(1, "revolute", "0.5 0 0", "0 0 1", -2.5, 2.5),
        joint(2, "prismatic", "0.5 0 0", "1 0 0", 0, 0.01),
    )
    tracker = IKSolver(two)
    target = two.forward([-0.9, 2.3, 0.0])
    q = np.array([0.5, -2.4, 0.0])
    for tick in range(500):
        # A millimetre to and fro is moving.
        seen = offset(target, 0.0, 0.0005 * (-1.0) ** tick if moving else 0.0, 0.0)
        result = tracker.track(seen, q, DT, Tolerance.position_only())
        assert (abs(result.q - q) <= two.velocity_limits * DT * (1.0 + 1e-12)).all()
        assert (result.q >= two.lower).all()
        assert (result.q <= two.upper).all()
        q = result.q
    assert result.converged == (not moving)
    assert (q[1] > 0.0) == (not moving)


def test_the_same_ticks_end_the_same(solver):
    def run():
        tracker = IKSolver(CHAIN)
        q, ends = BENT, []
        for tick in range(60):
            result = tracker.track(offset(CHAIN.forward(BENT), 0.05 * tick, 0.0, 0.0), q, DT)
            q = result.q
            ends.append((q.tolist(), result.status, result.posture is None))
        return ends

    assert run() == run()


def test_joints_beyond_their_limits_come_back_at_the_speed_limit(solver):
    outside = BENT.copy()
    outside[5] = 2.3
    target = CHAIN.forward(outside)
    q = outside
    for _ in range(10):
        result = solver.track(target, q, DT, acceleration_time=None)
        assert (abs(result.q - q) <= CHAIN.velocity_limits * DT * (1.0 + 1e-12)).all()
        assert result.q[5] <= max(2.2, q[5] - 1.5 * DT + 1e-12)
        q = result.q
    assert q[5] <= 2.2


def test_what_the_target_leaves_open_goes_to_the_goal(solver):
    centred = IKSolver(CHAIN, IKOptions(goal=Goal.MID_RANGE))
    target = CHAIN.forward(BENT)
    q = BENT
    for _ in range(100):
        result = centred.track(target, q, DT)
        assert_kept(result, q)
        assert result.converged
        q = result.q
    lower, upper = CHAIN.lower, CHAIN.upper
    bounded = np.isfinite(upper - lower)
    values = [
        0.5 * np.sum((((each - 0.5 * (lower + upper)) / (0.5 * (upper - lower)))[bounded]) ** 2)
        for each in (BENT, q)
    ]
    assert values[1] < values[0] - 0.01
    again = centred.track(target, q, DT)
    assert abs(again.velocity).max() < 1e-3


# ---- accelerations


def assert_smooth(postures, dt=DT, allowed=CHAIN.velocity_limits / 0.3):
    """From rest, and never by more than the limits (rad/s^2) from one tick to the next."""
    moves = np.diff(np.vstack([postures[:1], postures]), axis=0) / dt
    assert (abs(moves) <= CHAIN.velocity_limits * (1.0 + 1e-9)).all()
    assert (abs(np.diff(moves, axis=0)) / dt <= allowed * (1.0 + 1e-9)).all()


def followed(solver, targets, **options):
    q, postures, results = BENT, [BENT], []
    for target in targets:
        results.append(solver.track(target, q, DT, **options))
        q = results[-1].q
        postures.append(q)
    return np.array(postures), results


def beside(postures, corners):
    """Farthest that the tip is from a line with corners (m)."""
    places = np.array([CHAIN.forward(q)[:3, 3] for q in postures])
    farthest = np.full(len(places), math.inf)
    for begin, end in zip(corners, corners[1:]):
        way = end - begin
        shares = np.clip((places - begin) @ way / (way @ way), 0.0, 1.0)
        off = np.linalg.norm(places - begin - shares[:, None] * way, axis=1)
        farthest = np.minimum(farthest, off)
    return farthest.max()


def test_late_at_corners_it_is_never_beside_its_path(solver):
    """Three sides of a square, faster than the joints can, to and fro on the last, and an end."""
    start = CHAIN.forward(BENT)
    way, corners, targets = np.zeros(3), [start[:3, 3]], []
    for direction in ((0, 1, 0), (0, 0, 1), (0, -1, 0), (0, 1, 0), (0, -1, 0)):
        for _ in range(20):
            way = way + 0.003 * np.array(direction)
            targets.append(offset(start, *way))
        corners.append(targets[-1][:3, 3])
    postures, results = followed(solver, [*targets, *targets[-1:] * 120])
    assert_smooth(postures)
    assert beside(postures, corners) < 1e-4
    late = [result for result in results if result.position_error > 1e-3]
    assert late
    assert all(result.status is IKStatus.LAGGING for result in late)
    assert results[-1].converged
    assert np.array_equal(postures[-1], postures[-2])


def test_a_target_that_jumps_is_reached_on_a_straight_line(solver):
    start = CHAIN.forward(BENT)
    target = offset(start, 0.1, 0.05, 0.05)
    postures, results = followed(solver, [target] * 120)
    assert_smooth(postures)
    assert beside(postures, [start[:3, 3], target[:3, 3]]) < 1e-4
    assert results[-1].converged
    errors = [result.position_error for result in results]
    assert errors == sorted(errors, reverse=True)


@pytest.mark.parametrize("dt", [0.008, 0.002])
def test_two_jumps_at_once_are_two_straight_lines_at_any_rate(dt):
    """The second comes while the first line is hardly begun."""
    tracker = IKSolver(CHAIN)
    start = CHAIN.forward(BENT)
    ends = [offset(start, 0.1, 0.05, -0.1), offset(start, 0.1, -0.05, 0.0)]
    q, postures = BENT, [BENT]
    for tick in range(round(6.0 / dt)):
        result = tracker.track(ends[tick >= 3], q, dt)
        q = result.q
        postures.append(q)
    assert result.converged
    assert_smooth(np.array(postures), dt)
    corners = [pose[:3, 3] for pose in (start, *ends)]
    assert beside(postures[:: round(0.04 / dt)], corners) < 1e-4
    off = [np.linalg.norm(CHAIN.forward(q)[:3, 3] - corners[1]) for q in postures]
    assert min(off) < 2e-3


def test_a_shorter_acceleration_time_is_faster(solver):
    target = offset(CHAIN.forward(BENT), 0.02, 0.0, 0.0)
    ticks = []
    for seconds in (0.1, 0.3):
        solver.rest()
        postures, results = followed(solver, [target] * 60, acceleration_time=seconds)
        assert_smooth(postures, allowed=CHAIN.velocity_limits / seconds)
        ticks.append([result.converged for result in results].index(True))
    assert ticks[0] < ticks[1]


def test_ticks_of_uneven_length_keep_the_limits(solver):
    """A third shorter and longer, along corners that the joints take late, to the end."""
    lengths = DT * np.random.default_rng(1).uniform(0.7, 1.3, 230)
    start, way, q, before = CHAIN.forward(BENT), np.zeros(3), BENT, np.zeros(7)
    for tick, dt in enumerate(lengths):
        if tick < 100:
            way = way + 0.003 * np.array(((0, 1, 0), (0, 0, 1), (0, -1, 0))[tick // 20 % 3])
        result = solver.track(offset(start, *way), q, dt)
        assert (abs(result.velocity) <= CHAIN.velocity_limits * (1.0 + 1e-9)).all()
        change = abs(result.velocity - before) / dt
        assert (change <= CHAIN.velocity_limits / 0.3 * (1.0 + 1e-9)).all(), tick
        q, before = result.q, result.velocity
    assert result.converged
    assert not before.any()


def test_joints_found_elsewhere_begin_at_rest(solver):
    target = offset(CHAIN.forward(BENT), 0.2, 0.0, 0.0)
    followed(solver, [target] * 10)
    elsewhere = BENT + 0.01
    first = solver.track(target, elsewhere, DT)
    change = CHAIN.velocity_limits / 0.3 * DT * DT
    assert (abs(first.q - elsewhere) <= change * (1.0 + 1e-9)).all()
    solver.track(target, first.q, DT)
    solver.rest()
    again = solver.track(target, first.q, DT)
    assert (abs(again.q - first.q) <= change * (1.0 + 1e-9)).all()


def test_out_of_reach_and_back_accelerations_are_kept(solver):
    start = CHAIN.forward(BENT)
    distances = [*np.linspace(0.0, 0.6, 60), *np.linspace(0.6, 0.0, 60), *np.zeros(250)]
    postures, results = followed(solver, [offset(start, d, 0.0, d) for d in distances])
    assert_smooth(postures)
    assert results[60].position_error > 0.05
    assert results[-1].converged


# ---- twists


@pytest.mark.parametrize("frame", ["base", "tool"])
@pytest.mark.parametrize("axis", range(6))
def test_a_twist_moves_the_tip_that_way(solver, frame, axis):
    twist = np.zeros(6)
    twist[axis] = 0.03 if axis < 3 else 0.1
    result = solver.track_twist(twist, BENT, DT, frame)
    assert_kept(result, BENT)
    assert result.status is IKStatus.CONVERGED
    assert result.twist_ratio == pytest.approx(1.0, abs=1e-6)
    wanted = move_pose(CHAIN.forward(BENT), twist, DT, frame)
    assert abs(CHAIN.forward(result.q) - wanted).max() < 1e-8


def test_a_twist_that_is_too_fast_is_slowed_down_not_bent(solver):
    twist = np.array([0.6, 0.3, 0.0, 0.0, 0.0, 0.0])
    result = solver.track_twist(twist, BENT, DT)
    assert_kept(result, BENT)
    assert result.status is IKStatus.LAGGING
    assert result.at_speed
    begin, end = CHAIN.forward(BENT), CHAIN.forward(result.q)
    move = end[:3, 3] - begin[:3, 3]
    assert 0.05 < result.twist_ratio < 0.9
    assert move == pytest.approx(result.twist_ratio * DT * twist[:3], rel=1e-2, abs=1e-6)
    assert abs(end[:3, :3] - begin[:3, :3]).max() < 1e-6
    assert (abs(result.velocity) / CHAIN.velocity_limits).max() == pytest.approx(1.0, rel=2e-2)


def test_a_long_way_by_twists_does_not_drift(solver):
    q, start = BENT, CHAIN.forward(BENT)
    for _ in range(250):
        q = solver.track_twist([0.0, 0.04, 0.0, 0.0, 0.0, 0.0], q, DT).q
    end = CHAIN.forward(q)
    assert end[:3, 3] == pytest.approx(start[:3, 3] + [0.0, 0.2, 0.0], abs=1e-5)
    assert abs(end[:3, :3] - start[:3, :3]).max() < 1e-5


def test_no_twist_is_no_move(solver):
    result = solver.track_twist(np.zeros(6), BENT, DT)
    assert result.status is IKStatus.CONVERGED
    assert np.array_equal(result.q, BENT)
    assert result.twist_ratio == 1.0


def test_pushed_outwards_a_stretched_arm_stands_and_comes_back(solver):
    q = BENT
    for _ in range(1500):
        result = solver.track_twist([0.1, 0.0, 0.0, 0.0, 0.0, 0.0], q, DT)
        assert_kept(result, q)
        q = result.q
    assert result.status is IKStatus.BEST_EFFORT
    assert result.twist_ratio < 0.05
    assert result.singular
    edge = CHAIN.forward(q)
    for _ in range(150):
        result = solver.track_twist([-0.1, 0.0, 0.0, 0.0, 0.0, 0.0], q, DT)
        assert_kept(result, q)
        q = result.q
    # Back inside at the asked speed, no wind-up to be undone.
    assert result.twist_ratio > 0.95
    assert edge[0, 3] - CHAIN.forward(q)[0, 3] > 0.1


def test_along_a_limit_the_tip_slides(solver):
    """Down and to the side, the shoulder at its end: to the side it goes on."""
    low = BENT.copy()
    low[1] = 1.0
    low[3] = 0.7
    result = solver.track_twist(
        [0.02, 0.02, 0.0, 0, 0, 0], low, DT, tolerance=Tolerance.position_only()
    )
    assert_kept(result, low)
    assert result.q[1] <= 1.0
    assert result.twist_ratio > 0.3


def test_free_components_of_a_twist_are_free(solver):
    twist = [0.03, 0.0, 0.0, 5.0, 5.0, 5.0]
    result = solver.track_twist(twist, BENT, DT, tolerance=Tolerance.position_only())
    assert result.twist_ratio == pytest.approx(1.0, abs=1e-3)
    move = CHAIN.forward(result.q)[:3, 3] - CHAIN.forward(BENT)[:3, 3]
    assert move == pytest.approx([0.03 * DT, 0.0, 0.0], abs=1e-7)


def test_through_a_singular_wrist_speeds_stay_bounded(solver):
    """Turned about the direction that a straight wrist has lost."""
    straight = BENT.copy()
    straight[5] = 0.0
    assert solver.track(CHAIN.forward(straight), straight, DT).sigma < 0.3
    q = straight
    for _ in range(50):
        result = solver.track_twist([0, 0, 0, 0.3, 0, 0], q, DT, "tool")
        assert_kept(result, q)
        q = result.q
    assert result.twist_ratio > 0.5


# ---- what is refused


@pytest.mark.parametrize("dt", [0.0, -0.1, math.nan, math.inf, "1"])
def test_a_wrong_tick_is_refused(solver, dt):
    for call in (
        lambda: solver.track(np.eye(4), BENT, dt),
        lambda: solver.track(np.eye(4), BENT, DT, acceleration_time=dt),
        lambda: solver.track_twist(np.zeros(6), BENT, dt),
    ):
        with pytest.raises(KinematicsError, match="(dt|acceleration_time) is"):
            call()


def test_a_tick_that_is_too_short_or_long_ends_no_movement(solver):
    target = offset(CHAIN.forward(BENT), 0.2, 0.0, 0.0)
    postures, _ = followed(solver, [target] * 5)
    for dt in (1e-200, 1e-9, 1e9):
        with pytest.raises(KinematicsError, match="1e-06 to 86400"):
            solver.track(target, postures[-1], dt)
    # Limits whose product is 0 must not hold the solver up.
    braked = solver.track(target, postures[-1], 1e-6, acceleration_time=1e308)
    assert (abs(braked.velocity) <= CHAIN.velocity_limits * (1.0 + 1e-9)).all()
    assert solver.track(target, braked.q, DT).status is IKStatus.LAGGING


def test_wrong_arguments_are_refused(solver):
    with pytest.raises(KinematicsError, match="q has shape"):
        solver.track(np.eye(4), BENT[:6], DT)
    with pytest.raises(KinematicsError, match="q is .*finite"):
        solver.track(np.eye(4), BENT * math.nan, DT)
    with pytest.raises(KinematicsError, match="target is .*finite"):
        solver.track(np.eye(4) * math.nan, BENT, DT)
    with pytest.raises(KinematicsError, match="twist has shape"):
        solver.track_twist([0.0] * 5, BENT, DT)
    with pytest.raises(KinematicsError, match="twist is .*finite"):
        solver.track_twist([math.inf] * 6, BENT, DT)
    with pytest.raises(KinematicsError, match="frame is 'world'; base and tool are possible"):
        solver.track_twist([0.0] * 6, BENT, DT, "world")


@pytest.mark.parametrize("speed", ["", 'velocity="0"'])
def test_joints_without_speed_limit_are_named(speed):
    text = (
        '<robot name="r"><link name="l0"/><link name="l1"/><joint name="hinge" type="revolute">'
        f'<parent link="l0"/><child link="l1"/><limit lower="-1" upper="1" effort="1" {speed}/>'
        "</joint></robot>"
    )
    made = Chain.from_urdf(text, "l0", "l1")
    solver = IKSolver(made)
    with pytest.raises(KinematicsError, match="no speed limit above 0 for hinge"):
        solver.track(np.eye(4), [0.0], DT)
    assert solver.solve(np.eye(4), [0.3]).converged
    given = IKSolver(made, velocity_limits=[1.0])
    assert given.track(make_pose((0, 0, 0), (0, 0, 0, 1)), [0.001], DT).converged
