"""The shipped robot's joints at the ends of their ranges: they reach them, and rest there."""

from __future__ import annotations

import math

import pybullet
import pytest
from std_msgs.msg import Float64

from telex_control.urdf.joints import CONTINUOUS, PRISMATIC, joints, parse_urdf

pytestmark = pytest.mark.slow

UP, DOWN = -math.pi / 2.0, math.radians(60.0)  # of the shoulder
FOLDED = {"elbow_joint": 0.0, "wrist_pitch_joint": 0.0}


def in_the_air(robot, pose):
    """The robot high above the ground, so that nothing but its limits stops a joint."""
    tested = robot(
        fixed_base=True,
        start__place=[0.0, 0.0, 5.0, 0.0],
        start__poses={"test": pose},
        start__pose="test",
        start__default_pose="test",
        self_collision__enabled=False,
    )
    tested.run(0.1)
    return tested


def command(tested, name, position):
    topic = f"{name[: -len('_joint')]}_position_controller/command"
    tested.node.advertise(topic, Float64).publish(Float64(position))


def put_into_the_gripper(tested, mass):
    """A mass point at the tool; returns what takes it out again."""
    body = tested.simulation.body
    client = body.client
    link, position, orientation = body.place("tool_link")
    load = pybullet.createMultiBody(mass, -1, -1, *body.pose("tool_link"), physicsClientId=client)
    pybullet.changeDynamics(load, -1, localInertiaDiagonal=[0.01] * 3, physicsClientId=client)
    held = pybullet.createConstraint(
        *(body.uid, link, load, -1, pybullet.JOINT_FIXED),
        *((0, 0, 0), position, (0, 0, 0), orientation),
        physicsClientId=client,
    )
    pybullet.changeConstraint(held, maxForce=1.0e5, physicsClientId=client)
    return lambda: pybullet.removeConstraint(held, physicsClientId=client)


def error_allowed(joint):
    return 0.2e-3 if joint.kind == PRISMATIC else math.radians(0.05)


@pytest.mark.parametrize("end", ["lower", "upper"])
def test_joints_reach_the_ends_of_their_ranges_without_chatter(robot, urdf, end):
    limits = {
        name: joint for name, joint in joints(parse_urdf(urdf)).items() if joint.kind != CONTINUOUS
    }
    assert len(limits) == 19
    sign = 1.0 if end == "lower" else -1.0
    pose = {
        name: getattr(joint, end) + sign * min(0.15, 0.15 * (joint.upper - joint.lower))
        for name, joint in limits.items()
    }
    tested = in_the_air(robot, pose)
    for name, joint in limits.items():
        command(tested, name, getattr(joint, end))
    tested.run(2.5)
    hw = tested.simulation.hw
    fastest = dict.fromkeys(limits, 0.0)
    for _ in range(50):
        tested.run(0.002)
        for name in limits:
            fastest[name] = max(fastest[name], abs(hw.joint_state(name).velocity))
    assert max(fastest.values()) < 5e-3, fastest
    for name, joint in limits.items():
        position = hw.joint_state(name).position
        assert position == pytest.approx(getattr(joint, end), abs=error_allowed(joint)), name


@pytest.mark.parametrize(
    ("shoulder", "start", "end"),
    [(UP, 0.28, 0.3), (DOWN, 0.02, 0.0)],
)
def test_the_telescope_carries_five_kilograms_at_both_ends(robot, shoulder, start, end):
    tested = in_the_air(robot, {**FOLDED, "shoulder_joint": shoulder, "telescope_joint": start})
    put_into_the_gripper(tested, 5.0)
    tested.run(0.5)
    command(tested, "telescope_joint", end)
    tested.run(1.5)
    assert tested.positions()["telescope_joint"] == pytest.approx(end, abs=0.2e-3)


def test_a_load_too_heavy_meets_the_stop_and_leaves_no_windup(robot):
    tested = in_the_air(robot, {**FOLDED, "shoulder_joint": DOWN, "telescope_joint": 0.25})
    drop = put_into_the_gripper(tested, 100.0)
    tested.run(4.0)
    state = tested.simulation.hw.joint_state("telescope_joint")
    # 5 mm beyond the range
    assert state.position == pytest.approx(0.305, abs=0.3e-3)
    drop()
    lowest = state.position
    for _ in range(1500):
        tested.run(0.002)
        lowest = min(lowest, state.position)
    assert state.position == pytest.approx(0.25, abs=0.2e-3)
    assert lowest > 0.25 - 0.05 * 0.055
