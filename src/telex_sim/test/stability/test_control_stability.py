"""The joints' PID loops are stable in every posture, at the shipped step, gains and armatures."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pybullet
import pytest
import yaml

from telex_control.common.file_catalog import package_file
from telex_control.urdf.joints import joints, parse_urdf
from telex_sim.offline.simulation import OfflineSimulation

pytestmark = pytest.mark.slow

ARM = (
    "turret_joint",
    "shoulder_joint",
    "telescope_joint",
    "elbow_joint",
    "forearm_roll_joint",
    "wrist_pitch_joint",
    "gripper_roll_joint",
)


def derivative_gains():
    with open(package_file("telex_control", "config", "telex_controllers.yaml")) as file:
        params = yaml.safe_load(file)
    return {each["joint"]: each["pid"]["d"] for each in params.values() if "pid" in each}


def postures(limits, count):
    """Half of them anywhere, half nearly straight, where the joints' motions couple most."""
    generator = np.random.default_rng(11)
    for index in range(count):
        posture = {name: generator.uniform(limits[name].lower, limits[name].upper) for name in ARM}
        if index % 2:
            posture["elbow_joint"] = generator.normal(0.0, 0.2)
            posture["wrist_pitch_joint"] = generator.normal(0.0, 0.2)
        yield posture


# Those whose arms differ in what they carry
@pytest.mark.parametrize("variant", ["standard", "six_axis", "inspection", "carrier"])
def test_the_explicit_dampers_are_stable_in_every_posture(urdf, variant):
    # An explicit damper acts on the velocity of the step before: v' = v - step * M^-1 * D * v, with
    # the mass matrix M of the whole robot. An eigenvalue of step * M^-1 * D above 2 chatters.
    script = package_file("telex_description", "scripts", "robot_description")
    described = subprocess.run(
        [sys.executable, str(script), variant], check=True, capture_output=True, text=True
    ).stdout
    tested = OfflineSimulation(described)
    body, step = tested.simulation.body, tested.simulation.config.timing.step_size
    movable = [
        (index, name)
        for name, index in body.joints.items()
        if info(body, index)[2] != pybullet.JOINT_FIXED
    ]
    gains = derivative_gains()
    damping = np.diag([0.0] * 6 + [gains.get(name, 0.0) for _, name in movable])
    for posture in postures(joints(parse_urdf(urdf)), 150):
        for name, position in posture.items():
            if info(body, body.joints[name])[2] == pybullet.JOINT_FIXED:
                continue
            pybullet.resetJointState(
                body.uid, body.joints[name], position, physicsClientId=body.client
            )
        mass = np.array(
            pybullet.calculateMassMatrix(
                body.uid,
                [
                    pybullet.getJointState(body.uid, index, physicsClientId=body.client)[0]
                    for index, _ in movable
                ],
                physicsClientId=body.client,
            )
        )
        worst = abs(np.linalg.eigvals(step * np.linalg.solve(mass, damping))).max()
        assert worst < 1.8, posture
    tested.simulation.close()


def info(body, index):
    return pybullet.getJointInfo(body.uid, index, physicsClientId=body.client)


@pytest.mark.parametrize(
    "pose",
    [
        {"shoulder_joint": -0.1, "elbow_joint": 0.0, "wrist_pitch_joint": 0.0},
        {"shoulder_joint": -1.5, "elbow_joint": 0.2, "wrist_pitch_joint": 0.0},
    ],
    ids=["straight ahead", "straight up"],
)
def test_a_straight_arm_does_not_chatter_after_a_blow(robot, pose):
    tested = robot()
    poses = dict(tested.simulation.config.start.poses)
    poses["test"] = {**poses["look_front"], **pose}
    tested = robot(start__poses=poses, start__pose="test")
    tested.run(0.5)
    body = tested.simulation.body
    for _ in range(20):
        pybullet.applyExternalForce(
            body.uid,
            body.links["wrist_link"],
            (0.0, 0.0, 300.0),
            (0.0, 0.0, 0.0),
            pybullet.LINK_FRAME,
            physicsClientId=body.client,
        )
        tested.run(0.002)
    tested.run(1.5)
    for _ in range(100):
        tested.run(0.002)
        for name in ("shoulder_joint", "elbow_joint", "wrist_pitch_joint"):
            assert abs(tested.simulation.hw.joint_state(name).velocity) < 0.02
