"""Solving at once: what is found, what is kept, what is refused."""

from __future__ import annotations

import math
import sys
import time

import numpy as np
import pytest

from telex_control.common.params import ConfigError, read_config
from telex_control.kinematics import (
    FREE,
    Chain,
    Goal,
    IKOptions,
    IKSolver,
    IKStatus,
    KinematicsError,
    Mode,
    Tolerance,
    make_pose,
    rotation_vector,
)
from telex_control.kinematics.inverse.task import DISTANCE, SINGULARITY, GoalFunction, TaskShape

pytestmark = pytest.mark.slow


def joint(index, kind, xyz, axis, lower, upper):
    return (
        f'<link name="l{index + 1}"/><joint name="j{index}" type="{kind}">'
        f'<parent link="l{index}"/><child link="l{index + 1}"/><origin xyz="{xyz}"/>'
        f'<axis xyz="{axis}"/><limit lower="{lower}" upper="{upper}" velocity="1" effort="1"/>'
        "</joint>"
    )


def urdf(*joints):
    return f'<robot name="r"><link name="l0"/>{"".join(joints)}</robot>'


# As Telex has them: turret, shoulder, telescope, elbow, and a wrist of three.
ARM = urdf(
    joint(0, "revolute", "0 0 0.3", "0 0 1", -3.5, 3.5),
    joint(1, "revolute", "0.04 0 0", "0 1 0", -3, 1),
    joint(2, "prismatic", "0 0 0.5", "0 0 1", 0, 0.3),
    joint(3, "revolute", "0 0 0", "0 1 0", -3, 3),
    joint(4, "continuous", "0 0 0.46", "0 0 1", 0, 0),
    joint(5, "revolute", "0 0 0", "0 1 0", -2.2, 2.2),
    joint(6, "revolute", "0 0 0.3", "0 0 1", -6.3, 6.3),
)
PLANAR = urdf(
    joint(0, "revolute", "0 0 0", "0 0 1", -3, 3),
    joint(1, "revolute", "0.5 0 0", "0 0 1", -2, 2),
    joint(2, "prismatic", "0.5 0 0", "1 0 0", 0, 0.2),
)
CHAIN = Chain.from_urdf(ARM, "l0", "l7")
LIMITS = CHAIN.lower, CHAIN.upper
BENT = np.array([0.3, -1.2, 0.1, 1.9, 0.4, 0.8, -0.5])


@pytest.fixture
def solver():
    return IKSolver(CHAIN)


def postures(count, seed=0):
    generator = np.random.default_rng(seed)
    lower, upper = np.maximum(CHAIN.lower, -math.pi), np.minimum(CHAIN.upper, math.pi)
    return generator.uniform(lower, upper, (count, 7))


def apart(pose, other):
    """Distance (m) and angle (rad) between two poses."""
    turn = np.linalg.norm(pose[:3, :3] - other[:3, :3]) / math.sqrt(8.0)
    return np.linalg.norm(pose[:3, 3] - other[:3, 3]), 2.0 * math.asin(min(turn, 1.0))


def assert_reaches(result, target, place=1e-5, turn=1e-5):
    assert result.status is IKStatus.CONVERGED
    assert result.converged
    assert_within(result.q)
    # 1e-9: of the forward kinematics of another implementation
    distance, angle = apart(CHAIN.forward(result.q), target)
    assert distance <= place + 1e-9
    assert angle <= turn + 1e-7


def assert_within(q):
    assert (q >= CHAIN.lower).all()
    assert (q <= CHAIN.upper).all()


def task_of(target, tolerance=None):
    return TaskShape.of(tolerance or Tolerance(), IKOptions().length_weight).at(target)


# ---- what it computes with


def test_compiled_kinematics_are_those_of_kdl(solver):
    numerics = solver.numerics
    for q in postures(50):
        assert abs(numerics.forward(q) - CHAIN.forward(q)).max() < 1e-12
        assert abs(numerics.jacobian(q) - CHAIN.jacobian(q)).max() < 1e-12


def errors_by_kdl(task, q):
    """Distance (m) and angle (rad) from the target, along its axes, beyond the task's bounds."""
    there, here = task.target, CHAIN.forward(q)
    shift = there[:3, :3].T @ (there[:3, 3] - here[:3, 3])
    if task.free_axis >= 0:
        axes = there[:3, task.free_axis], here[:3, task.free_axis]
        turn = np.array([math.atan2(np.linalg.norm(np.cross(*axes)), np.dot(*axes)), 0.0, 0.0])
        bounds = np.array([*task.bounds[:3], 0.0, 0.0, 0.0])
    else:
        turn, bounds = rotation_vector(here[:3, :3].T @ there[:3, :3]), task.bounds
    beyond = np.maximum(abs(np.concatenate([shift, turn])) - bounds, 0.0)
    return np.linalg.norm(beyond[:3]), np.linalg.norm(beyond[3:])


def jacobian_by_kdl(task, q):
    """Weighted Jacobian along the target's axes, of the directions that a task asks for."""
    into = task.target[:3, :3].T
    made = CHAIN.jacobian(q)
    made[:3] = task.length_weight * (into @ made[:3])
    made[3:] = into @ made[3:]
    return made[~np.isinf(task.bounds)]


@pytest.mark.parametrize(
    "tolerance",
    [
        Tolerance(),
        Tolerance.position_only(),
        Tolerance.free_roll("y"),
        Tolerance(position_bounds=(0.3, 0.0, FREE), rotation_bounds=(0.5, FREE, FREE)),
    ],
)
def test_it_measures_what_kdl_and_numpy_do(solver, tolerance):
    numerics = solver.numerics
    for q, other in zip(postures(20, 1), postures(20, 2)):
        task = task_of(CHAIN.forward(other), tolerance)
        measured = numerics.descend(task, q, (q, q), 0)
        place, turn = errors_by_kdl(task, q)
        assert measured.position_error == pytest.approx(place, abs=1e-12)
        assert measured.orientation_error == pytest.approx(turn, abs=1e-7)
        left, values, _ = np.linalg.svd(jacobian_by_kdl(task, q), full_matrices=False)
        tick = numerics.tick(task, q, LIMITS, np.zeros(7), 0)
        assert tick.sigma == pytest.approx(values[-1], abs=1e-9)
        worst = np.zeros(6)
        worst[~np.isinf(task.bounds)] = left[:, -1]
        worst = np.concatenate([task.target[:3, :3] @ part for part in (worst[:3], worst[3:])])
        assert abs(tick.direction @ worst) == pytest.approx(1.0, abs=1e-6)
        away = GoalFunction(DISTANCE, other, np.arange(1.0, 8.0))
        distance = 0.5 * np.sum(((q - away.reference) / away.scale) ** 2)
        assert numerics.goal_value(task, q, away) == pytest.approx(distance, abs=1e-9)
        singularity = numerics.goal_value(task, q, away._replace(kind=SINGULARITY))
        assert singularity == pytest.approx(-np.log(values).sum(), abs=1e-9)


def test_half_a_turn_is_measured():
    solver = IKSolver(CHAIN)
    for axis in np.eye(4)[:3]:
        target = CHAIN.forward(BENT) @ make_pose((0, 0, 0), axis)
        found = solver.numerics.descend(task_of(target), BENT, (BENT, BENT), 0)
        assert found.orientation_error == pytest.approx(math.pi, abs=1e-9)
        assert found.position_error == pytest.approx(0.0, abs=1e-12)


# ---- solving


@pytest.mark.parametrize("given", [True, False], ids=["random seed", "nominal seed"])
def test_reachable_poses_are_reached(solver, given):
    for q, seed in zip(postures(60, 3), postures(60, 4)):
        target = CHAIN.forward(q)
        assert_reaches(solver.solve(target, seed if given else None), target)


def test_the_same_question_has_the_same_answer():
    solver, other = (IKSolver(CHAIN) for _ in range(2))
    targets = [CHAIN.forward(q) for q in postures(20, 5)]
    answers = [solver.solve(target).q for target in targets]
    for target, answer in zip(reversed(targets), reversed(answers)):
        assert np.array_equal(other.solve(target).q, answer)


def test_another_random_seed_restarts_elsewhere():
    target = CHAIN.forward(BENT)
    target[0, 3] += 4.0
    one, two = (IKSolver(CHAIN, IKOptions(random_seed=seed, iterations=200)) for seed in (1, 2))
    assert not np.array_equal(one.solve(target).q, two.solve(target).q)


def test_a_solution_near_the_seed_is_found_from_it(solver):
    generator = np.random.default_rng(6)
    for q in postures(40, 7):
        target = CHAIN.forward(q)
        seed = q + generator.normal(0.0, 0.01, 7)
        found = solver.solve(target, seed)
        assert_reaches(found, target)
        assert found.restarts == 0
        if abs(q[5]) > 0.2 and abs(q[3]) > 0.2:
            assert abs(found.q - seed).max() < 0.3


def test_full_turns_are_taken_off(solver):
    seed = BENT.copy()
    seed[4] += 4.0 * math.pi
    found = solver.solve(CHAIN.forward(BENT), seed)
    assert abs(found.q - seed).max() < 1e-3


def test_out_of_reach_it_comes_near(solver):
    target = CHAIN.forward(BENT)
    target[:3, 3] = (3.0, 0.0, 0.3)
    found = solver.solve(target)
    assert found.status is IKStatus.BEST_EFFORT
    assert not found.converged
    assert_within(found.q)
    pose = CHAIN.forward(found.q)
    assert found.position_error == pytest.approx(np.linalg.norm(pose[:3, 3] - target[:3, 3]))
    # 1.6 m are the arm's own length from the turret.
    assert 1.3 < found.position_error < 1.7
    assert found.orientation_error == pytest.approx(apart(pose, target)[1], abs=1e-6)


def test_a_seed_beyond_the_limits_is_taken(solver):
    target = CHAIN.forward(BENT)
    assert_reaches(solver.solve(target, [9, 9, 9, 9, 9, 9, 9]), target)


def test_limits_of_ones_own_are_kept():
    lower = np.array([-0.5, -2, 0.05, 0, -1, -1, -1])
    upper = np.array([0.5, 0, 0.2, 2.5, 1, 1, 1])
    solver = IKSolver(CHAIN, position_limits=(lower, upper))
    for q in np.random.default_rng(8).uniform(lower, upper, (30, 7)):
        found = solver.solve(CHAIN.forward(q))
        assert_reaches(found, CHAIN.forward(q))
        assert (found.q >= lower).all()
        assert (found.q <= upper).all()


def test_a_joint_without_room_stays():
    lower, upper = CHAIN.lower.copy(), CHAIN.upper.copy()
    lower[2] = upper[2] = 0.1
    solver = IKSolver(CHAIN, position_limits=(lower, upper))
    q = BENT.copy()
    q[2] = 0.1
    found = solver.solve(CHAIN.forward(q), q + 0.2)
    assert_reaches(found, CHAIN.forward(q))
    assert found.q[2] == 0.1


# ---- tolerances


def test_position_only(solver):
    for q in postures(15, 9):
        target = CHAIN.forward(q)
        target[:3, :3] = np.eye(3)  # mostly not reachable in full
        found = solver.solve(target, tolerance=Tolerance.position_only())
        assert found.converged
        assert found.orientation_error == 0.0
        assert apart(CHAIN.forward(found.q), target)[0] < 1.1e-5


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_free_roll(solver, axis):
    index = "xyz".index(axis)
    turn = np.zeros(4)
    turn[index], turn[3] = math.sin(1.2), math.cos(1.2)
    for q in postures(10, 10):
        goal = CHAIN.forward(q)
        target = goal @ make_pose((0, 0, 0), turn)
        found = solver.solve(target, q, tolerance=Tolerance.free_roll(axis))
        assert found.converged
        pose = CHAIN.forward(found.q)
        assert np.linalg.norm(pose[:3, 3] - target[:3, 3]) < 1.1e-5
        assert pose[:3, index] @ target[:3, index] > math.cos(1.1e-5) - 1e-12
        # From where it points there already, nothing needs to move.
        assert abs(found.q - q).max() < 1e-9


def test_bounds_are_along_the_targets_axes(solver):
    tolerance = Tolerance(position_bounds=(0.0, 0.02, FREE), rotation_bounds=(0.1, 0.1, 0.1))
    for q in postures(10, 11):
        target = CHAIN.forward(q)
        asked = target @ make_pose((0.0, 0.05, 0.4), (0.0, 0.0, math.sin(0.2), math.cos(0.2)))
        found = solver.solve(asked, q, tolerance=tolerance)
        if not found.converged:
            continue
        x, y, _ = asked[:3, :3].T @ (CHAIN.forward(found.q)[:3, 3] - asked[:3, 3])
        assert abs(x) < 1.1e-5
        assert abs(y) < 0.02 + 1.1e-5
        assert apart(CHAIN.forward(found.q)[:3], np.c_[asked[:3, :3], [0, 0, 0]])[1] < 0.18


def test_fewer_joints_than_directions():
    chain = Chain.from_urdf(PLANAR, "l0", "l3")
    solver = IKSolver(chain)
    target = np.eye(4)
    target[:3, 3] = (0.3, 0.6, 0.0)
    assert solver.solve(target).status is IKStatus.BEST_EFFORT
    found = solver.solve(target, tolerance=Tolerance.position_only())
    assert found.converged
    assert np.linalg.norm(chain.forward(found.q)[:3, 3] - target[:3, 3]) < 1.1e-5
    q = [0.4, 1.1, 0.1]
    assert solver.solve(chain.forward(q), q).converged


# ---- secondary goals


def goal_value(goal, q, seed):
    """What a goal makes small."""
    if goal is Goal.MANIPULABILITY:
        values = np.linalg.svd(jacobian_by_kdl(task_of(CHAIN.forward(q)), q), compute_uv=False)
        return -np.log(values).sum()
    away = q - seed
    if goal is Goal.MID_RANGE:
        lower, upper = LIMITS
        bounded = np.isfinite(upper - lower)
        away = ((q - 0.5 * (lower + upper)) / (0.5 * (upper - lower)))[bounded]
    return 0.5 * away @ away


@pytest.mark.parametrize("goal", [Goal.SEED, Goal.MID_RANGE, Goal.MANIPULABILITY])
def test_a_goal_is_followed_and_the_target_kept(goal):
    plain = IKSolver(CHAIN)
    fast = IKSolver(CHAIN, IKOptions(goal=goal))
    best = IKSolver(CHAIN, IKOptions(goal=goal, mode=Mode.BEST, iterations=200))
    gained = 0
    for q, seed in zip(postures(4, 12), postures(4, 13)):
        target = CHAIN.forward(q)
        first, slid, chosen = (each.solve(target, seed) for each in (plain, fast, best))
        for found in (first, slid, chosen):
            assert_reaches(found, target)
        values = [goal_value(goal, each.q, seed) for each in (first, slid, chosen)]
        assert values[1] <= values[0] + 1e-9
        assert values[2] <= values[1] + 1e-3
        gained += values[1] < values[0] - 1e-3
    assert gained >= 2


def test_the_goal_is_at_a_minimum_along_the_self_motion():
    solver = IKSolver(CHAIN, IKOptions(goal=Goal.MID_RANGE))
    target = CHAIN.forward(BENT)
    q = solver.solve(target, BENT).q
    motion = np.linalg.svd(CHAIN.jacobian(q))[2][-1]
    least = goal_value(Goal.MID_RANGE, q, BENT)
    for step in (0.05, -0.05):
        moved = solver.numerics.descend(task_of(target), q + step * motion, LIMITS, 20)
        assert moved.converged
        assert goal_value(Goal.MID_RANGE, moved.q, BENT) > least


def test_the_best_of_many_is_hardly_worse_than_the_best_of_very_many():
    def solver(iterations):
        options = IKOptions(goal=Goal.SEED, mode=Mode.BEST, iterations=iterations)
        return IKSolver(CHAIN, options)

    solvers = IKSolver(CHAIN), solver(1000), solver(10_000)
    moves = np.zeros(3)
    for q, seed in zip(postures(10, 14), postures(10, 15)):
        target = CHAIN.forward(q)
        moves += [np.linalg.norm(each.solve(target, seed).q - seed) for each in solvers]
    first, many, very_many = moves
    assert first > 1.15 * very_many
    assert many < 1.05 * very_many


# ---- budgets


def test_iterations_are_kept():
    target = CHAIN.forward(BENT)
    target[0, 3] += 5.0
    found = IKSolver(CHAIN, IKOptions(iterations=100)).solve(target)
    assert found.iterations <= 100
    assert found.restarts > 0


def test_a_time_limit_ends_a_search():
    options = IKOptions(iterations=10**9, time_limit=0.02)
    solver = IKSolver(CHAIN, options)
    solver.warm_up()
    target = CHAIN.forward(BENT)
    assert_reaches(solver.solve(target), target)
    target[0, 3] += 5.0
    before = time.thread_time()
    found = solver.solve(target)
    # No more than the budget of its own time, however busy the machine is.
    assert time.thread_time() - before < 0.5
    assert found.status is IKStatus.BEST_EFFORT
    assert_within(found.q)


# ---- what is refused


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda pose: pose[:3], r"target has shape \(3, 4\)"),
        (lambda pose: pose * np.nan, "finite"),
        (lambda pose: np.where(pose == 1.0, np.inf, pose), "finite"),
        (lambda pose: pose @ np.diag([1, 1, 1.01, 1]), "no rotation"),
        (lambda pose: pose @ np.diag([1, 1, -1, 1]), "no rotation"),
        (lambda pose: pose + np.eye(4)[3][:, None] * 0.5, "last row"),
        (lambda pose: "here", "numbers are needed"),
    ],
)
def test_what_is_no_pose_is_refused(solver, change, message):
    with pytest.raises(KinematicsError, match=message):
        solver.solve(change(CHAIN.forward(BENT)))


@pytest.mark.parametrize("row", range(3))
@pytest.mark.parametrize("column", range(4))
def test_no_number_of_a_target_may_be_other_than_finite(solver, row, column):
    for wrong in (math.nan, math.inf, -math.inf):
        target = CHAIN.forward(BENT)
        target[row, column] = wrong
        with pytest.raises(KinematicsError, match="finite"):
            solver.solve(target)
    target[row, column] = 1e300
    with pytest.raises(KinematicsError, match="no rotation" if column < 3 else "up to 10000"):
        solver.solve(target)


def test_a_joint_without_limits_stays_near_a_seed_many_turns_away(solver):
    target, seed = CHAIN.forward(BENT), BENT + 1500.0 * 2.0 * math.pi
    result = solver.solve(target, seed)
    assert_reaches(result, target, 1.1e-5, 1.1e-5)
    free = np.isinf(CHAIN.upper)
    assert free.any()
    assert (abs(result.q - seed)[free] <= math.pi).all()


def test_rounding_errors_of_a_rotation_are_taken_off(solver):
    target = CHAIN.forward(BENT)
    rounded = target.astype(np.float32).astype(float)
    assert_reaches(solver.solve(rounded, BENT + 0.1), target, 1.1e-5, 1.1e-5)


@pytest.mark.parametrize(
    ("seed", "message"),
    [
        ([0.0] * 6, "7 numbers"),
        ([math.nan] * 7, "finite"),
        ([1e200] * 7, "up to 10000"),
        ([0.0, 1e17, *[0.0] * 5], "up to 10000"),
        ([0.0, -1e8, *[0.0] * 5], "up to 10000"),
    ],
)
def test_what_is_no_posture_is_refused(solver, seed, message):
    with pytest.raises(KinematicsError, match=message):
        solver.solve(np.eye(4), seed)


def test_chains_that_cannot_move_are_refused():
    with pytest.raises(KinematicsError, match="no joint from l3 to l3 can move"):
        IKSolver(Chain.from_urdf(ARM, "l3", "l3"))
    stuck = urdf(joint(0, "revolute", "0 0 1", "0 0 1", 0.5, 0.5))
    with pytest.raises(KinematicsError, match="no joint from l0 to l1 can move"):
        IKSolver(Chain.from_urdf(stuck, "l0", "l1"))


def test_limits_that_are_wrong_are_refused():
    wide = (CHAIN.lower, CHAIN.upper + 0.1)
    with pytest.raises(KinematicsError, match="position_limits of j0 are -3.5 to 3.6"):
        IKSolver(CHAIN, position_limits=wide)
    with pytest.raises(KinematicsError, match="7 numbers"):
        IKSolver(CHAIN, position_limits=([0.0], [1.0]))
    for limits in (1.0, (CHAIN.lower,), (CHAIN.lower, ["high"] * 7)):
        with pytest.raises(KinematicsError, match="lower and upper limits are needed"):
            IKSolver(CHAIN, position_limits=limits)
    with pytest.raises(KinematicsError, match="velocity_limits is"):
        IKSolver(CHAIN, velocity_limits=[0.0] * 7)


def test_a_numba_that_does_not_load_is_told(monkeypatch):
    # None in sys.modules: its import fails.
    monkeypatch.setitem(sys.modules, "telex_control.kinematics.inverse.numerics", None)
    with pytest.raises(KinematicsError, match=r"needs numba, which does not load: .*setup\.sh"):
        IKSolver(CHAIN)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"goal": "up"}, "none, seed, mid_range, manipulability are possible"),
        ({"mode": "best"}, "the best needs one of"),
        ({"iterations": 0}, "iterations is 0"),
        ({"length_weight": 0.0}, "length_weight is 0.0"),
        ({"time_limit": -1.0}, "time_limit is -1.0"),
        ({"tolerance": {"position": 0.0}}, "position is 0.0"),
        ({"tolerance": {"rotation_bounds": [-1.0, 0.0, 0.0]}}, "rotation_bounds is"),
        ({"speed": 1.0}, "speed is unknown"),
    ],
)
def test_options_that_are_wrong_are_refused(options, message):
    with pytest.raises(ConfigError, match=message):
        read_config(IKOptions, options, "ik")


def test_asking_for_nothing_is_refused():
    with pytest.raises(ConfigError, match="nothing would be asked for"):
        Tolerance(position_bounds=(FREE,) * 3, rotation_bounds=(FREE,) * 3)
    with pytest.raises(ConfigError, match="x, y and z are possible"):
        Tolerance.free_roll("w")


def test_questions_that_each_have_their_own_tolerance_fill_no_memory():
    solver = IKSolver(Chain.from_urdf(PLANAR, "l0", "l3"))
    target = solver.chain.forward([0.3, 0.4, 0.1])
    for number in range(100):
        assert solver.solve(target, [0.0] * 3, Tolerance(position=1e-5 + 1e-9 * number)).converged
    assert len(solver._shapes) <= 64
    assert solver.solve(target, [0.0] * 3).converged
