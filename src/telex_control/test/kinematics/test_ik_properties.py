"""What holds for any serial chain, any posture and any target: looked for by hypothesis."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from telex_control.common.geometry.matrices import rotation_about
from telex_control.kinematics import (
    Chain,
    IKSolver,
    KinematicsError,
    Tolerance,
    make_pose,
    move_pose,
    quaternion_of,
    rotation_vector,
)

pytestmark = pytest.mark.slow

DT = 0.02
QUIET = settings(max_examples=25, deadline=None, suppress_health_check=list(HealthCheck))
SHORT = settings(QUIET, max_examples=12)

angles = st.sampled_from([0.0, math.pi / 2, -math.pi / 2, math.pi]) | st.floats(-3.0, 3.0)
lengths = st.sampled_from([0.0, 0.3]) | st.floats(-0.5, 0.5)
axes = st.sampled_from([(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, -1.0)]) | st.tuples(
    *[st.floats(0.2, 1.0)] * 3
)


def words(values):
    return " ".join(repr(float(value)) for value in values)


@st.composite
def chains(draw):
    """Chains of 1 to 8 joints of all kinds, with axes that are skew, meet, or lie on one line."""
    kinds = draw(st.lists(st.sampled_from(KINDS), min_size=1, max_size=8))
    kinds.append(draw(st.sampled_from(["revolute", "prismatic"])))
    elements = ['<link name="l0"/>']
    for index, kind in enumerate(kinds):
        middle, half = draw(st.floats(-1.0, 1.0)), draw(st.floats(0.3, 3.0))
        limit = f'lower="{middle - half!r}" upper="{middle + half!r}" velocity="1" effort="1"'
        elements.append(
            f'<link name="l{index + 1}"/><joint name="j{index}" type="{kind}">'
            f'<parent link="l{index}"/><child link="l{index + 1}"/>'
            f'<origin xyz="{words(draw(st.tuples(lengths, lengths, lengths)))}" '
            f'rpy="{words(draw(st.tuples(angles, angles, angles)))}"/>'
            f'<axis xyz="{words(draw(axes))}"/><limit {limit}/></joint>'
        )
    text = f'<robot name="r">{"".join(elements)}</robot>'
    return Chain.from_urdf(text, "l0", f"l{len(kinds)}")


KINDS = ["revolute", "revolute", "revolute", "prismatic", "continuous", "fixed"]
seeds = st.integers(0, 2**32 - 1)


def postures(chain, seed, count):
    lower, upper = np.maximum(chain.lower, -math.pi), np.minimum(chain.upper, math.pi)
    return np.random.default_rng(seed).uniform(lower, upper, (count, lower.size))


def assert_within(chain, q):
    assert (q >= chain.lower).all()
    assert (q <= chain.upper).all()


def position_apart(chain, q, target):
    return np.linalg.norm(chain.forward(q)[:3, 3] - target[:3, 3])


def angle_apart(chain, q, target):
    return np.linalg.norm(rotation_vector(chain.forward(q)[:3, :3].T @ target[:3, :3]))


# ---- any chain


@QUIET
@given(chain=chains(), seed=seeds)
def test_the_tip_moves_as_kdl_moves_it(chain, seed):
    numerics = IKSolver(chain).numerics
    for q in postures(chain, seed, 3):
        assert abs(numerics.forward(q) - chain.forward(q)).max() < 1e-12
        assert abs(numerics.jacobian(q) - chain.jacobian(q)).max() < 1e-12


@QUIET
@given(chain=chains(), seed=seeds)
def test_the_jacobian_is_the_derivative(chain, seed):
    (q,) = postures(chain, seed, 1)
    jacobian = chain.jacobian(q)
    for index in range(q.size):
        step = np.zeros(q.size)
        step[index] = 1e-6
        ahead, behind = chain.forward(q + step), chain.forward(q - step)
        shift = (ahead[:3, 3] - behind[:3, 3]) / 2e-6
        turn = rotation_vector(ahead[:3, :3] @ behind[:3, :3].T) / 2e-6
        assert jacobian[:, index] == pytest.approx([*shift, *turn], abs=1e-7)


@QUIET
@given(chain=chains(), seed=seeds)
def test_forward_after_inverse_is_the_target(chain, seed):
    solver = IKSolver(chain)
    for q in postures(chain, seed, 2):
        target = chain.forward(q)
        # From near by: on a chain that is singular all over, from afar may lead elsewhere.
        found = solver.solve(target, q + 1e-3)
        again = IKSolver(chain).solve(target, q + 1e-3)
        assert_within(chain, found.q)
        assert found.converged
        assert position_apart(chain, found.q, target) < 1.01e-5
        assert angle_apart(chain, found.q, target) < 1.01e-5
        assert np.array_equal(found.q, again.q)


@SHORT
@given(chain=chains(), seed=seeds, place=st.tuples(*[st.floats(-9.0, 9.0)] * 3))
def test_any_pose_has_an_answer_within_the_limits(chain, seed, place):
    solver = IKSolver(chain)
    generator = np.random.default_rng(seed)
    quaternion = generator.normal(0.0, 1.0, 4)
    target = make_pose(place, quaternion / np.linalg.norm(quaternion))
    found = solver.solve(target)
    assert_within(chain, found.q)
    assert found.position_error == pytest.approx(position_apart(chain, found.q, target), abs=1e-9)
    assert found.orientation_error == pytest.approx(angle_apart(chain, found.q, target), abs=1e-6)
    position = solver.solve(target, tolerance=Tolerance.position_only())
    assert_within(chain, position.q)
    assert position.orientation_error == 0.0


@SHORT
@given(chain=chains(), seed=seeds, far=st.floats(0.0, 5.0), slow=st.floats(0.01, 1.0))
def test_tracking_is_continuous(chain, seed, far, slow):
    """Whatever the target does, jumps included: no joint is faster than it may be."""
    limits = np.full(len(chain.joints), slow)
    solver = IKSolver(chain, velocity_limits=limits)
    generator = np.random.default_rng(seed)
    q, goal = postures(chain, seed, 2)
    target = chain.forward(goal)
    for _ in range(6):
        target = move_pose(target, generator.uniform(-far, far, 6), 0.2)
        for result in (
            solver.track(target, q, DT),
            solver.track_twist(generator.uniform(-far, far, 6), q, DT),
        ):
            assert_within(chain, result.q)
            assert (abs(result.q - q) <= slow * DT * (1.0 + 1e-9)).all()
            assert np.isfinite(result.velocity).all()
            assert result.sigma >= 0.0
            assert 0.0 <= result.twist_ratio <= 1.0
        q = result.q


# ---- poses


def unit_quaternion(seed):
    drawn = np.random.default_rng(seed).normal(size=4)
    return drawn / np.linalg.norm(drawn)


unit = seeds.map(unit_quaternion)


@QUIET
@given(quaternion=unit, place=st.tuples(*[st.floats(-9.0, 9.0)] * 3))
def test_a_pose_keeps_its_quaternion(quaternion, place):
    pose = make_pose(place, quaternion)
    assert pose[:3, 3].tolist() == list(place)
    assert pose[:3, :3] @ pose[:3, :3].T == pytest.approx(np.eye(3), abs=1e-12)
    sign = -1.0 if quaternion[3] < 0.0 else 1.0
    assert quaternion_of(pose) == pytest.approx(sign * quaternion, abs=1e-9)


@QUIET
@given(turn=st.tuples(*[st.floats(-1.8, 1.8)] * 3))
def test_a_rotation_vector_comes_back(turn):
    assert rotation_vector(rotation_about(turn)) == pytest.approx(turn, abs=1e-9)


@QUIET
@given(quaternion=unit, seed=seeds)
def test_a_twist_there_and_back_is_no_move(quaternion, seed):
    pose = make_pose((0.1, -0.2, 0.3), quaternion)
    twist = np.random.default_rng(seed).normal(0.0, 1.0, 6)
    for frame in ("base", "tool"):
        moved = move_pose(pose, twist, 0.3, frame)
        back = np.array(twist)
        if frame == "tool":
            # The way back is along the axes of where it started.
            back[:3] = (moved[:3, :3].T @ pose[:3, :3]) @ twist[:3]
        assert move_pose(moved, -back, 0.3, frame) == pytest.approx(pose, abs=1e-12)
        along = pose[:3, :3] @ twist[:3] if frame == "tool" else twist[:3]
        assert moved[:3, 3] - pose[:3, 3] == pytest.approx(0.3 * along, abs=1e-12)


@pytest.mark.parametrize(
    ("position", "quaternion", "message"),
    [
        ((0, 0, 0), (0, 0, 0, 1.1), r"norm 1\.1; norm 1 is needed"),
        ((0, 0, 0), (0, 0, 0, 0), "norm 0; norm 1 is needed"),
        ((0, 0, 0), (0, 0, math.nan, 1), "quaternion is .*finite"),
        ((0, math.inf, 0), (0, 0, 0, 1), "position is .*finite"),
        ((0, 0), (0, 0, 0, 1), "3 numbers"),
        ((0, 0, 0), (0, 0, 1), "4 numbers"),
    ],
)
def test_what_makes_no_pose_is_refused(position, quaternion, message):
    with pytest.raises(KinematicsError, match=message):
        make_pose(position, quaternion)
