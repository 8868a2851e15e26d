"""The shipped action controllers on the simulated robot: the arm's trajectories and the grip."""

from __future__ import annotations

import math
import threading

import genpy
import pybullet
import pytest
from control_msgs.msg import (
    FollowJointTrajectoryGoal,
    FollowJointTrajectoryResult,
    GripperCommand,
    GripperCommandGoal,
)
from trajectory_msgs.msg import JointTrajectoryPoint

pytestmark = pytest.mark.slow

FINGER_TIPS = ("left_finger_tip_link", "right_finger_tip_link")


def switch(tested, start, stop):
    answer = []
    manager = tested.simulation.controllers
    worker = threading.Thread(target=lambda: answer.append(manager.switch_controller(start, stop)))
    worker.start()
    while worker.is_alive():
        tested.simulation.step()
        worker.join(0.001)
    assert answer == [True]


@pytest.fixture
def acting(robot):
    """The robot after ``controller_group switch actions``."""
    tested = robot()
    tested.run(0.3)
    groups = tested.node.find_param("controller_groups", {})
    switch(tested, groups["actions"], groups["manual"])
    return tested


def follow(tested, seconds, **targets):
    joints = tested.node.find_param("arm_trajectory_controller/joints", [])
    positions = tested.positions()
    goal = FollowJointTrajectoryGoal()
    goal.trajectory.joint_names = joints
    rest = [0.0] * len(joints)
    goal.trajectory.points = [
        JointTrajectoryPoint(
            positions=[targets.get(name, positions[name]) for name in joints],
            velocities=rest,
            accelerations=rest,
            time_from_start=genpy.Duration.from_sec(seconds),
        )
    ]
    sent = tested.node.send_goal("arm_trajectory_controller/follow_joint_trajectory", goal)
    tested.run(seconds + 0.5)
    return sent


def test_the_arm_follows_a_trajectory_within_the_shipped_tolerances(acting):
    targets = {"turret_joint": 0.3, "elbow_joint": 2.2, "telescope_joint": 0.02}
    goal = follow(acting, 2.0, **targets)
    assert goal.status == "succeeded", goal.result
    assert goal.result.error_code == FollowJointTrajectoryResult.SUCCESSFUL
    positions = acting.positions()
    for name, target in targets.items():
        assert positions[name] == pytest.approx(target, abs=1e-3), name


def test_a_trajectory_faster_than_the_arm_is_aborted(acting):
    goal = follow(acting, 0.3, shoulder_joint=-0.9)
    assert goal.status == "aborted"
    assert goal.result.error_code == FollowJointTrajectoryResult.PATH_TOLERANCE_VIOLATED


def command(tested, opening, force, seconds):
    goal = GripperCommandGoal(command=GripperCommand(opening, force))
    sent = tested.node.send_goal("gripper_controller/gripper_cmd", goal)
    tested.run(seconds)
    return sent


def test_the_gripper_opens_and_closes(acting):
    for opening in (0.12, 0.02):
        goal = command(acting, opening, 0.0, 2.0)
        assert goal.status == "succeeded"
        assert goal.result.reached_goal
        assert goal.result.position == pytest.approx(opening, abs=2e-3)


def tool_pose(body):
    return body.pose("tool_link")


def grip(tested, mass, half_extents, force):
    """Close the fingers on a box of friction 1, and let go of it; returns its number, the goal."""
    command(tested, 0.1, 0.0, 1.2)
    body = tested.simulation.body
    place = tool_pose(body)
    shape = pybullet.createCollisionShape(
        pybullet.GEOM_BOX, halfExtents=half_extents, physicsClientId=body.client
    )
    box = pybullet.createMultiBody(mass, shape, -1, *place, physicsClientId=body.client)
    pybullet.changeDynamics(box, -1, lateralFriction=1.0, physicsClientId=body.client)
    # It floats until it is gripped.
    held = pybullet.createConstraint(
        *(box, -1, -1, -1, pybullet.JOINT_FIXED),
        *((0, 0, 0), (0, 0, 0), place[0], (0, 0, 0, 1), place[1]),
        physicsClientId=body.client,
    )
    goal = command(tested, 0.0, force, 2.0)
    pybullet.removeConstraint(held, physicsClientId=body.client)
    tested.run(0.5)
    return box, goal


@pytest.mark.parametrize("force", [40.0, 250.0])
def test_the_pads_press_with_the_force_that_is_asked_for(acting, force):
    box, goal = grip(acting, 0.5, (0.02, 0.025, 0.02), force)
    body = acting.simulation.body
    assert goal.status == "succeeded"
    assert goal.result.stalled
    assert goal.result.position == pytest.approx(0.05, abs=3e-3)
    for name in FINGER_TIPS:
        contacts = pybullet.getContactPoints(
            body.uid, box, body.links[name], -1, physicsClientId=body.client
        )
        assert sum(contact[9] for contact in contacts) == pytest.approx(force, rel=0.05), name


def in_the_hand(body, box):
    """Place of the box in the tool's frame (m)."""
    place = pybullet.getBasePositionAndOrientation(box, physicsClientId=body.client)
    return pybullet.multiplyTransforms(*pybullet.invertTransform(*tool_pose(body)), *place)[0]


def test_a_light_cube_does_not_creep_out_of_the_hand(acting):
    """It is the worst case: friction without an anchor lets it slip by 9 mm."""
    # The body is another one then; its pads must be the same.
    acting.simulation.reset()
    acting.run(0.3)
    box, _ = grip(acting, 0.3, (0.025, 0.025, 0.025), 100.0)
    body = acting.simulation.body
    before = in_the_hand(body, box)
    acting.run(10.0)
    assert math.dist(in_the_hand(body, box), before) < 0.1e-3


@pytest.mark.parametrize(("share", "holds"), [(0.85, True), (1.1, False)])
def test_the_pads_hold_what_their_friction_can_carry(acting, share, holds):
    force = 50.0
    mass = share * 2.0 * 0.8 * force / 9.81
    box, _ = grip(acting, mass, (0.025, 0.025, 0.025), force)
    body = acting.simulation.body
    before = in_the_hand(body, box)
    acting.run(1.0)
    assert (math.dist(in_the_hand(body, box), before) < 5e-3) == holds
