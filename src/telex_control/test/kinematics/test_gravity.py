from __future__ import annotations

import math

import pytest

from telex_control.hardware.hardware_interface import (
    EffortJointInterface,
    ImuSensorHandle,
    ImuSensorInterface,
    JointStateHandle,
)
from telex_control.laws.gravity import GRAVITY, HOLD, GravityError, GravityModel, gravity_of


def body(mass, x):
    return (
        f'<inertial><origin xyz="{x} 0 0"/><mass value="{mass}"/>'
        '<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>'
    )


# A mast that turns, an arm on it, a slide on the arm, with a lamp fixed to it, and a second arm.
URDF = f"""
<robot name="crane">
  <link name="base"/>
  <link name="imu_link"/>
  <link name="mast">{body(1.0, 0.0)}</link>
  <link name="arm">{body(2.0, 0.5)}</link>
  <link name="hook">{body(3.0, 0.0)}</link>
  <link name="lamp">{body(0.5, 0.0)}</link>
  <link name="other">{body(4.0, -0.25)}</link>
  <joint name="imu_fixed" type="fixed"><parent link="base"/><child link="imu_link"/>
    <origin rpy="0 0 1.5707963267948966"/></joint>
  <joint name="turn" type="revolute"><parent link="base"/><child link="mast"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" velocity="1" effort="99"/></joint>
  <joint name="lift" type="revolute"><parent link="mast"/><child link="arm"/><axis xyz="0 -1 0"/>
    <origin xyz="0 0 1"/><limit lower="-3" upper="3" velocity="1" effort="99"/></joint>
  <joint name="reach" type="prismatic"><parent link="arm"/><child link="hook"/><axis xyz="1 0 0"/>
    <origin xyz="1 0 0"/><limit lower="-3" upper="3" velocity="1" effort="99"/></joint>
  <joint name="lamp_fixed" type="fixed"><parent link="hook"/><child link="lamp"/>
    <origin xyz="0.5 0 0"/></joint>
  <joint name="tip" type="revolute"><parent link="mast"/><child link="other"/><axis xyz="0 -1 0"/>
    <limit lower="-3" upper="3" velocity="1" effort="99"/></joint>
</robot>
"""
JOINTS = ("turn", "lift", "reach", "tip")


class Crane:
    def __init__(self, joints=JOINTS, imus=()):
        self.states = {name: JointStateHandle(name) for name in JOINTS}
        self.model = GravityModel(URDF, self.states, imus)
        self.joints = {name: self.model.joint(name) for name in joints}
        self.time = 0.0

    def efforts(self, **positions):
        for name, position in positions.items():
            self.states[name].position = position
        self.time += HOLD
        return {name: joint.effort(self.time) for name, joint in self.joints.items()}


def test_a_stretched_arm():
    efforts = Crane().efforts()
    assert efforts["turn"] == pytest.approx(0.0)
    assert efforts["lift"] == pytest.approx(GRAVITY * (2.0 * 0.5 + 3.0 * 1.0 + 0.5 * 1.5))
    assert efforts["reach"] == pytest.approx(0.0)
    assert efforts["tip"] == pytest.approx(-GRAVITY * 4.0 * 0.25)


def test_a_raised_arm():
    angle = 0.6
    efforts = Crane().efforts(lift=angle, reach=0.5, turn=1.0)
    moment = 2.0 * 0.5 + 3.0 * 1.5 + 0.5 * 2.0
    assert efforts["lift"] == pytest.approx(GRAVITY * math.cos(angle) * moment)
    assert efforts["reach"] == pytest.approx(GRAVITY * math.sin(angle) * 3.5)


def test_joints_that_are_not_asked_for_count_as_they_stand():
    crane = Crane(joints=("lift",))
    assert crane.efforts(reach=1.0) == {
        "lift": pytest.approx(GRAVITY * (2.0 * 0.5 + 3.0 * 2.0 + 0.5 * 2.5))
    }


def test_a_tilted_base_is_felt_through_the_inertial_sensor():
    imu = ImuSensorHandle("imu", "imu_link")
    crane = Crane(imus=[imu])
    level = crane.efforts()
    # nose up by 0.3 rad about the base's -y; the sensor is turned by 90 deg about z on it
    half, quarter = 0.15, math.pi / 4.0
    pitch = (0.0, -math.sin(half), 0.0, math.cos(half))
    turn = (0.0, 0.0, math.sin(quarter), math.cos(quarter))
    imu.orientation = multiply(pitch, turn)
    tilted = crane.efforts()
    moment = GRAVITY * (2.0 * 0.5 + 3.0 * 1.0 + 0.5 * 1.5)
    assert level["lift"] == pytest.approx(moment)
    # as fine as gravity's direction is taken up
    assert tilted["lift"] == pytest.approx(moment * math.cos(0.3), rel=1e-3)
    assert tilted["reach"] == pytest.approx(GRAVITY * 3.5 * math.sin(0.3), rel=2e-3)
    # rolled on its side by 90 deg, the mast carries the moment
    imu.orientation = multiply((math.sin(quarter), 0.0, 0.0, math.cos(quarter)), turn)
    rolled = crane.efforts()
    assert rolled["lift"] == pytest.approx(0.0, abs=1e-9)
    assert abs(rolled["turn"]) == pytest.approx(moment - GRAVITY * 4.0 * 0.25)


def multiply(a, b):
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def test_a_sensor_on_a_moving_link_is_not_taken():
    imu = ImuSensorHandle("imu", "arm")
    imu.orientation = (1.0, 0.0, 0.0, 0.0)
    assert Crane(imus=[imu]).efforts()["lift"] > 0.0


def test_efforts_are_held_for_some_cycles_of_all_joints(monkeypatch):
    crane = Crane()
    solved = []
    solve = crane.model._solvers.__class__.solve
    monkeypatch.setattr(
        crane.model._solvers.__class__, "solve", lambda self: solved.append(1) or solve(self)
    )
    crane.efforts()
    crane.efforts()
    assert len(solved) == 2
    for cycle in range(1, 100):
        for joint in crane.joints.values():
            joint.effort(crane.time + cycle * 0.002)
    # every fifth of the 99 cycles
    assert len(solved) == 2 + 19


def test_a_joint_that_is_asked_for_later_is_served_too():
    crane = Crane(joints=("lift",))
    crane.efforts()
    crane.joints["tip"] = crane.model.joint("tip")
    assert crane.efforts()["tip"] == pytest.approx(-GRAVITY)


def test_a_joint_that_is_not_there_is_named():
    with pytest.raises(GravityError, match="'nose'"):
        Crane(joints=("nose",))
    with pytest.raises(GravityError, match="roots"):
        GravityModel("<robot/>", {})


def with_mass(urdf):
    return urdf.replace('<link name="a"/>', f'<link name="a">{body(2.0, 0.5)}</link>').replace(
        'name="elbow" type="revolute">', 'name="elbow" type="revolute"><axis xyz="0 -1 0"/>'
    )


@pytest.mark.parametrize(
    "params",
    [
        {
            "type": "effort_controllers/JointPositionController",
            "joint": "elbow",
            "pid": {"p": 0.0},
        },
        {
            "type": "effort_controllers/JointGroupPositionController",
            "joints": ["elbow"],
            "elbow": {"pid": {"p": 0.0}},
        },
        {
            "type": "effort_controllers/JointTrajectoryController",
            "joints": ["elbow"],
            "gains": {"elbow": {"p": 0.0}},
        },
    ],
)
@pytest.mark.parametrize("compensated", [True, False])
def test_effort_controllers_carry_gravity_when_asked_to(bench, bench_urdf, params, compensated):
    tested = bench(
        {
            "robot_description": with_mass(bench_urdf),
            "c": {**params, "gravity_compensation": compensated},
        }
    )
    imus = ImuSensorInterface()
    imus.register_handle(ImuSensorHandle("imu", "base"))
    tested.hw.register_interface(imus)
    tested.load_and_start("c")
    tested.cycle()
    handle = tested.hw.get(EffortJointInterface).get_handle("elbow")
    assert handle.command == pytest.approx(GRAVITY * 2.0 * 0.5 if compensated else 0.0)
    info, _ = tested.manager.list_controllers()[0]
    assert [claim.resources for claim in info.claimed_resources] == [("elbow",)]


def test_controllers_of_one_robot_share_one_model(bench):
    tested = bench({})
    assert gravity_of(tested.hw, tested.node) is gravity_of(tested.hw, tested.node)
    other = bench({})
    assert gravity_of(other.hw, other.node) is not gravity_of(tested.hw, tested.node)
