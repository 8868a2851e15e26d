"""Rotations and poses, against KDL's and by their own laws."""

import math

import numpy as np
import PyKDL
import pytest
from geometry_msgs.msg import Pose

from telex_control.common.geometry import matrices, quaternions
from telex_control.ros.pose_messages import fill_pose, pose_in, pose_message

EXACT = 1e-14
"""rad, or m at 1 m: some rounding errors of double precision."""
RIGHT = 0.5 * math.pi


def turns(count=200):
    """Unit quaternions of random rotations, of nearly none, and of nearly half a turn."""
    rng = np.random.default_rng(7)
    found = rng.normal(size=(count, 4))
    found[::5, :3] *= 1e-9
    found[1::5, 3] *= 1e-9
    found[2::5, 1:3] *= 1e-12
    return [tuple(each / np.linalg.norm(each)) for each in found]


def poses(count=50):
    places = np.random.default_rng(8).uniform(-3.0, 3.0, (count, 3))
    return [(tuple(place), turn) for place, turn in zip(places.tolist(), turns(count))]


def angles():
    """Roll, pitch and yaw, at and beside the pitch of a right angle too."""
    rng = np.random.default_rng(9)
    found = rng.uniform(-math.pi, math.pi, (200, 3))
    found[:, 1] *= 0.5
    for row, off in zip(found[::4], [0.0, 1e-16, 1e-12, 1e-9, 1e-8, 1e-7, 1e-4] * 8):
        row[1] = math.copysign(RIGHT - off, row[1])
    return found.tolist()


def kdl(q):
    return PyKDL.Rotation.Quaternion(*q)


def array(rotation):
    return np.array([[rotation[row, column] for column in range(3)] for row in range(3)])


def same_turn(a, b):
    return min(np.abs(np.subtract(a, b)).max(), np.abs(np.add(a, b)).max()) < EXACT


def test_products_and_rotated_vectors_are_those_of_kdl():
    for a, b in zip(turns(), turns()[::-1]):
        assert same_turn(quaternions.product(a, b), (kdl(a) * kdl(b)).GetQuaternion())
        vector = (0.3, -0.5, 0.7)
        turned = kdl(a) * PyKDL.Vector(*vector)
        assert quaternions.rotate(a, vector) == pytest.approx(tuple(turned), abs=EXACT)
        rows = quaternions.rotation_rows(a)
        assert quaternions.transform_by_rows(rows, vector) == pytest.approx(
            tuple(turned), abs=EXACT
        )


def test_matrices_are_those_of_kdl():
    for q in turns():
        wanted = array(kdl(q))
        assert matrices.rotation_matrix(q) == pytest.approx(wanted, abs=EXACT)
        assert matrices.pose_matrices(np.array([(1.0, 2.0, 3.0, *q)]))[0] == pytest.approx(
            matrices.homogeneous(wanted, (1.0, 2.0, 3.0)), abs=EXACT
        )


def test_a_quaternion_comes_back_from_its_matrix():
    for q in turns():
        found = matrices.quaternion_of(matrices.rotation_matrix(q))
        assert same_turn(found, q)
        assert found[3] >= 0.0
        assert matrices.quaternion_tuple(matrices.rotation_matrix(q)) == tuple(found.tolist())


def test_a_pose_and_its_inverse_cancel_in_both_forms():
    for pose in poses():
        place, turn = quaternions.compose(pose, quaternions.invert(pose))
        assert place == pytest.approx((0.0, 0.0, 0.0), abs=1e-14)
        assert same_turn(turn, quaternions.UPRIGHT)
        matrix = matrices.pose_matrix(*pose)
        assert matrices.inverse(matrix) @ matrix == pytest.approx(np.eye(4), abs=1e-14)
        assert matrices.inverse(matrix) == pytest.approx(np.linalg.inv(matrix), abs=1e-13)


def test_composed_poses_are_products_of_matrices():
    for a, b in zip(poses(), poses()[::-1]):
        assert matrices.pose_matrix(*quaternions.compose(a, b)) == pytest.approx(
            matrices.pose_matrix(*a) @ matrices.pose_matrix(*b), abs=1e-14
        )


def test_a_rotation_vector_comes_back_from_its_matrix():
    for q in turns():
        rotation = matrices.rotation_matrix(q)
        vector = matrices.rotation_vector(rotation)
        assert matrices.rotation_about(vector) == pytest.approx(rotation, abs=1e-14)
        angle = float(np.linalg.norm(vector))
        assert angle == pytest.approx(quaternions.angle_between(quaternions.UPRIGHT, q), abs=1e-14)
        # KDL takes angles below 1e-6 for none.
        assert angle == pytest.approx(kdl(q).GetRotAngle()[0], abs=1e-6)


def test_rpy_is_that_of_urdf():
    for rpy in angles():
        assert matrices.rotation_from_rpy(rpy) == pytest.approx(
            array(PyKDL.Rotation.RPY(*rpy)), abs=EXACT
        )


def test_rpy_gives_the_rotation_again_at_a_right_angle_too():
    for rpy in angles():
        q = quaternions.quaternion_from_rpy(rpy)
        found = quaternions.rpy_from_quaternion(q)
        assert abs(found[1]) <= RIGHT
        assert same_turn(quaternions.quaternion_from_rpy(found), q)


def test_rpy_comes_back_away_from_a_right_angle():
    for rpy in angles():
        if abs(rpy[1]) < 1.5:
            q = quaternions.quaternion_from_rpy(rpy)
            assert quaternions.rpy_from_quaternion(q) == pytest.approx(rpy, abs=1e-13)
            ahead = quaternions.rotate(q, (1.0, 0.0, 0.0))
            assert quaternions.yaw_of(q) == pytest.approx(math.atan2(ahead[1], ahead[0]))
            assert quaternions.yaw_of(q) == pytest.approx(rpy[2], abs=1e-13)


def test_a_twist_leaves_a_rotation_across_its_axis():
    axis = (0.0, 0.6, 0.8)
    for q in turns():
        rest = quaternions.product(q, quaternions.conjugate(quaternions.twist(q, axis)))
        assert np.dot(rest[:3], axis) == pytest.approx(0.0, abs=EXACT)


def test_a_turn_about_an_axis_is_its_own_twist():
    axis = (0.0, 0.6, 0.8)
    q = quaternions.about(axis, 1.2)
    assert same_turn(quaternions.twist(q, axis), q)
    assert quaternions.twist((1.0, 0.0, 0.0, 0.0), axis) == quaternions.UPRIGHT


def test_a_long_product_stays_a_rotation():
    q = step = quaternions.about((0.6, 0.0, 0.8), 1e-3)
    for _ in range(20_000):
        q = quaternions.product(q, step)
    assert np.linalg.norm(q) == pytest.approx(1.0, abs=EXACT)


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        ([(0.0,) * 6], "shape"),
        ([(0.0, 0.0, math.nan, 0.0, 0.0, 0.0, 1.0)], "not finite"),
        ([(0.0,) * 6 + (1.0,), (0.0,) * 7], "pose 1 has a zero quaternion"),
    ],
)
def test_poses_that_are_none_are_refused(rows, said):
    with pytest.raises(ValueError, match=said):
        matrices.pose_matrices(np.array(rows))


def test_a_pose_comes_back_from_its_message():
    for position, turn in poses():
        assert pose_in(pose_message(position, turn)) == (position, turn)
        message = Pose()
        fill_pose(message, matrices.pose_matrix(position, turn))
        found = pose_in(message)
        assert found[0] == position
        assert same_turn(found[1], turn)
