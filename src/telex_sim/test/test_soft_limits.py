"""The shipped robot's joints at their soft limits: they come to rest there, and stay at rest."""

from __future__ import annotations

import pytest
from std_msgs.msg import Float64

from telex_control.urdf_joints import joints, parse_urdf

ARM = (
    "turret_joint",
    "shoulder_joint",
    "telescope_joint",
    "elbow_joint",
    "forearm_roll_joint",
    "wrist_pitch_joint",
    "gripper_roll_joint",
)


@pytest.mark.parametrize("end", ["lower", "upper"])
def test_arm_joints_run_into_their_limits_without_chatter(robot, urdf, end):
    limits = {name: joint for name, joint in joints(parse_urdf(urdf)).items() if name in ARM}
    sign = 1.0 if end == "lower" else -1.0
    pose = {
        name: getattr(joint, end) + sign * min(0.15, 0.15 * (joint.upper - joint.lower))
        for name, joint in limits.items()
    }
    # high above the ground, so that nothing but the limits stops a joint
    tested = robot(
        fixed_base=True,
        start__place=[0.0, 0.0, 5.0, 0.0],
        start__poses={"test": pose},
        start__pose="test",
        start__default_pose="test",
        self_collision__enabled=False,
    )
    tested.run(0.1)
    for name, joint in limits.items():
        command = tested.node.advertise(f"{name[:-6]}_position_controller/command", Float64)
        command.publish(Float64(getattr(joint, end)))
    tested.run(2.0)
    hw = tested.simulation.hw
    for name, joint in limits.items():
        position = hw.joint_state(name).position
        assert joint.lower - 1e-3 <= position <= joint.upper + 1e-3, name
        assert position == pytest.approx(getattr(joint.soft, end), abs=0.012), name
    fastest = dict.fromkeys(limits, 0.0)
    for _ in range(50):
        tested.run(0.002)
        for name in limits:
            fastest[name] = max(fastest[name], abs(hw.joint_state(name).velocity))
    assert max(fastest.values()) < 5e-3, fastest
