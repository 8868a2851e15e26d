"""The shipped gains and limits: steps of the stretched arm neither overshoot nor leave an error."""

from __future__ import annotations

import math

import numpy as np
import pytest
from std_msgs.msg import Float64

STRETCHED = {"shoulder_joint": 0.0, "telescope_joint": 0.25, "elbow_joint": 0.0}
STEPS = {
    "turret_joint": math.radians(15.0),
    "shoulder_joint": -math.radians(15.0),
    "telescope_joint": -0.05,
    "elbow_joint": -math.radians(15.0),
    "forearm_roll_joint": math.radians(15.0),
    "wrist_pitch_joint": math.radians(15.0),
    "gripper_roll_joint": math.radians(15.0),
}


@pytest.fixture
def stretched(robot):
    standard = robot().simulation.config.start.poses
    poses = {"stretched": {**standard["look_front"], "wrist_pitch_joint": 0.0, **STRETCHED}}
    tested = robot(start__poses=poses, start__pose="stretched", start__default_pose="")
    tested.run(2.0)
    return tested


def test_all_joints_of_the_arm_stepped_at_once(stretched):
    hw, node = stretched.simulation.hw, stretched.node
    states = {name: hw.joint_state(name) for name in STEPS}
    start = {name: round(state.position, 2) for name, state in states.items()}
    for name, step in STEPS.items():
        topic = f"/{name[: -len('_joint')]}_position_controller/command"
        node.advertise(topic, Float64).publish(Float64(start[name] + step))
    samples = {name: [] for name in STEPS}
    for _ in range(1250):
        stretched.simulation.step()
        for name, state in states.items():
            samples[name].append(state.position)
    for name, step in STEPS.items():
        response = (np.array(samples[name]) - start[name]) / step
        assert response.max() < 1.05, name
        late = np.abs(response[750:] - 1.0)  # from 1.5 s on
        assert late.max() < 0.02, name
        error = abs(np.mean(samples[name][1000:]) - start[name] - step)
        assert error < (0.2e-3 if name == "telescope_joint" else math.radians(0.05)), name
