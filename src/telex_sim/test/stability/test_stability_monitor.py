"""Attitude, tip-over margin and trouble of the shipped robot in the simulation."""

from __future__ import annotations

import math

import numpy as np
import pybullet
import pytest
from geometry_msgs.msg import Twist
from std_msgs.msg import Float64

from telex_sim.engine.world import GRAVITY
from telex_sim.offline.simulation import OfflineSimulation
from telex_sim.stability.force_angle import force_angle
from telex_sim.stability.monitor import StabilityMonitor

pytestmark = pytest.mark.slow


def put(tested, position, roll=0.0, pitch=0.0):
    """Put the robot's root link somewhere else."""
    body = tested.simulation.body
    inertial = pybullet.getDynamicsInfo(body.uid, -1, physicsClientId=body.client)[3:5]
    turned = pybullet.getQuaternionFromEuler((roll, pitch, 0.0))
    pose = pybullet.multiplyTransforms(position, turned, *inertial)
    pybullet.resetBasePositionAndOrientation(body.uid, *pose, physicsClientId=body.client)


def look(monitor, tested, seconds=0.2):
    """Run on, looking ten times a second; returns the last margin."""
    for _ in range(round(seconds * 10)):
        tested.run(0.1)
        monitor.observe(tested.simulation.time)
    return monitor.margin(tested.simulation.time)


def drive(monitor, tested, linear, angular, seconds):
    publisher = tested.node.advertise("track_controller/cmd_vel", Twist)
    message = Twist()
    message.linear.x, message.angular.z = linear, angular
    margins = []
    for _ in range(round(seconds * 10)):
        publisher.publish(message)
        margins.append(look(monitor, tested, 0.1))
    return margins


def shove(tested):
    """Give the robot a speed of 0.5 m/s to its right, at once."""
    body = tested.simulation.body
    pybullet.resetBaseVelocity(body.uid, (0.0, -0.5, 0.0), physicsClientId=body.client)


def block_under_the_belly(tested):
    """Put the robot on a block that holds its belts off the ground; returns PyBullet's number."""
    client, height = tested.simulation.world.client, 0.12
    x, y, _ = tested.simulation.body.base_pose()[0]
    put(tested, (x, y, height + 0.05))
    shape = pybullet.createCollisionShape(
        pybullet.GEOM_BOX, halfExtents=(0.2, 0.12, 0.5 * height), physicsClientId=client
    )
    return pybullet.createMultiBody(0.0, shape, -1, (x, y, 0.5 * height), physicsClientId=client)


def wall_before(tested, distance):
    """Put a wall of 0.5 m across the robot's way, so far before it (m)."""
    client = tested.simulation.world.client
    x, y, _ = tested.simulation.body.base_pose()[0]
    shape = pybullet.createCollisionShape(
        pybullet.GEOM_BOX, halfExtents=(0.3, 1.0, 0.25), physicsClientId=client
    )
    pybullet.createMultiBody(0.0, shape, -1, (x + distance + 0.3, y, 0.25), physicsClientId=client)


@pytest.fixture
def watched(robot):
    def make(**changes):
        tested = robot(**changes)
        return tested, StabilityMonitor(tested.simulation.robots[0])

    return make


def test_level_in_the_start_pose_the_margin_is_1(watched):
    tested, monitor = watched(start__pose="stow")
    margin = look(monitor, tested, 1.0)
    assert margin.margin == pytest.approx(1.0, abs=0.03)
    assert monitor.attitude.roll == pytest.approx(0.0, abs=0.002)
    assert monitor.attitude.pitch == pytest.approx(0.0, abs=0.005)
    x, y, z = margin.center_of_mass
    assert abs(x) < 0.1
    assert abs(y) < 0.02
    assert 0.0 < z < 0.3
    # Four corners: on the belts' hubs, as the flippers stand upright.
    assert len(margin.support) == 4
    assert [abs(corner[0]) for corner in margin.support] == pytest.approx([0.285] * 4, abs=0.02)
    assert [abs(corner[1]) for corner in margin.support] == pytest.approx([0.2] * 4, abs=0.005)
    # The centre of mass lies a little to the right.
    assert math.sin(margin.direction) == pytest.approx(-1.0, abs=0.01)
    assert margin.angle == pytest.approx(math.atan2(0.2 + y, 0.11 + z), abs=0.02)


def test_flat_flippers_lengthen_the_support(watched):
    tested, monitor = watched(start__pose="ready")  # rear flippers flat
    margin = look(monitor, tested, 1.0)
    assert min(corner[0] for corner in margin.support) == pytest.approx(-0.72, abs=0.02)
    assert max(corner[0] for corner in margin.support) == pytest.approx(0.285, abs=0.02)


def test_the_margin_does_not_flicker_while_it_drives(watched):
    tested, monitor = watched(start__pose="ready")
    drive(monitor, tested, 0.5, 0.3, 1.0)
    margins = [each.margin for each in drive(monitor, tested, 0.5, 0.3, 1.5)]
    assert min(margins) > 0.85
    assert max(margins) < 1.1


def test_leaning_against_a_wall_is_not_tipping_until_it_rears(watched):
    tested, monitor = watched(start__pose="stow")
    wall_before(tested, distance=0.9)
    for side in ("left", "right"):
        topic = f"front_{side}_flipper_position_controller/command"
        tested.node.advertise(topic, Float64).publish(Float64(0.5))
    look(monitor, tested, 2.0)
    # Its belts push it up the wall: the ground carries its rear end only, and the wall the rest.
    margins = {}
    while monitor.attitude.pitch > -0.75:
        margin = drive(monitor, tested, 0.3, 0.0, 0.1)[-1]
        margins[math.degrees(-monitor.attitude.pitch)] = margin
    leaning = [margin.margin for pitch, margin in margins.items() if pitch < 25.0]
    assert len(leaning) > 5
    assert min(leaning) > 0.5
    # The steeper it stands, the nearer it is to falling over backwards.
    steepest = margins[max(margins)]
    assert steepest.margin < 0.6
    assert math.cos(steepest.direction) == pytest.approx(-1.0, abs=0.01)


def test_a_hand_that_presses_against_a_wall_pushes_the_robot_as_it_must(watched):
    tested, monitor = watched(world="training_hall")  # 1.5 m before a wall
    # The hand meets the wall first, and its push lifts the front of the belts a little: the robot
    # stands in balance on their rear ends, and falls neither forwards nor backwards.
    margins = [each.margin for each in drive(monitor, tested, 1.2, 0.0, 4.0)[-20:]]
    assert abs(monitor.attitude.pitch) < 0.1
    assert sorted(margins)[1] > -0.5
    assert min(margins) < 0.5


def test_a_stretched_arm_tips_it_forwards_sooner(watched):
    tested, monitor = watched(start__pose="stow")
    before = look(monitor, tested, 0.5)
    goal = {"shoulder": 0.0, "elbow": 0.0, "wrist_pitch": 0.0}
    body = tested.simulation.body
    for joint, position in goal.items():
        index = body.joints[f"{joint}_joint"]
        pybullet.resetJointState(body.uid, index, position, physicsClientId=body.client)
    for joint, position in goal.items():
        topic = f"{joint}_position_controller/command"
        tested.node.advertise(topic, Float64).publish(Float64(position))
    after = monitor.margin(tested.simulation.time)
    assert after.center_of_mass[0] > before.center_of_mass[0] + 0.1
    assert after.margin < 0.8
    assert math.cos(after.direction) == pytest.approx(1.0, abs=0.01)


def test_a_load_counts_by_its_pull(watched):
    tested, monitor = watched(start__pose="look_front")
    empty = look(monitor, tested, 0.5)
    body, mass = tested.simulation.body, 20.0
    shape = pybullet.createCollisionShape(
        pybullet.GEOM_BOX, halfExtents=(0.08, 0.08, 0.02), physicsClientId=body.client
    )
    # On the right edge of the deck.
    plate = pybullet.createMultiBody(
        mass, shape, -1, (-0.05, -0.08, 0.32), physicsClientId=body.client
    )
    loaded = look(monitor, tested, 0.6)
    place = pybullet.getBasePositionAndOrientation(plate, physicsClientId=body.client)[0]
    lever = np.subtract(place, body.base_pose()[0]) - loaded.center_of_mass
    pull = np.array([0.0, 0.0, -mass * GRAVITY])
    weight = np.array(
        [
            0.0,
            0.0,
            -GRAVITY
            * sum(
                pybullet.getDynamicsInfo(body.uid, link, physicsClientId=body.client)[0]
                for link in range(-1, len(body.joints))
            ),
        ]
    )
    without = force_angle(empty.support, empty.center_of_mass, tuple(weight), (0.0, 0.0, 0.0))
    expected = force_angle(
        loaded.support,
        loaded.center_of_mass,
        tuple(weight + pull),
        tuple(np.cross(lever, pull)),
    )
    assert loaded.margin / empty.margin == pytest.approx(
        expected.measure / without.measure, rel=0.02
    )
    assert loaded.angle == pytest.approx(expected.angle, abs=0.01)
    assert loaded.angle < empty.angle
    assert math.sin(loaded.direction) < -0.99  # over the right side
    # As a load, not as a part of the robot.
    assert loaded.center_of_mass[0] == pytest.approx(empty.center_of_mass[0], abs=0.02)


def test_it_has_tipped_over_on_its_side_and_on_its_back(watched):
    tested, monitor = watched(start__pose="stow")
    for roll, height in ((1.6, 0.35), (3.1, 0.7)):
        put(tested, (0.0, 0.0, height), roll)
        look(monitor, tested, 0.3)
        assert not monitor.tipped
        look(monitor, tested, 1.2)
        assert monitor.tipped
        tested.simulation.reset()
        look(monitor, tested, 0.2)
        assert not monitor.tipped


def test_attitude_is_that_of_the_hull_and_nothing_carries_it_in_the_air(watched):
    tested, monitor = watched(start__pose="stow")
    for roll, pitch in ((0.3, 0.0), (0.0, -0.2)):
        put(tested, (0.0, 0.0, 2.0), roll, pitch)
        tested.run(0.02)
        monitor.observe(tested.simulation.time)
        assert monitor.attitude.roll == pytest.approx(roll, abs=0.02)
        assert monitor.attitude.pitch == pytest.approx(pitch, abs=0.02)
        assert monitor.attitude.tilt == pytest.approx(math.hypot(roll, pitch), abs=0.02)
    in_the_air = monitor.margin(tested.simulation.time)
    assert in_the_air.margin == 0.0
    assert in_the_air.support == []


def test_on_its_belly_it_is_stuck_and_free_again_when_its_belts_grip(watched):
    tested, monitor = watched(start__pose="stow")
    look(monitor, tested, 0.3)
    block = block_under_the_belly(tested)
    drive(monitor, tested, 0.3, 0.0, 1.5)
    assert not monitor.stuck  # may still get away
    drive(monitor, tested, 0.3, 0.0, 1.5)
    assert monitor.stuck
    look(monitor, tested, 1.0)
    assert not monitor.stuck  # it has given up
    drive(monitor, tested, 0.0, 0.5, 3.0)
    assert monitor.stuck
    pybullet.removeBody(block, physicsClientId=tested.simulation.world.client)
    drive(monitor, tested, 0.3, 0.0, 1.5)
    assert not monitor.stuck


def test_driving_and_turning_are_not_stuck(watched):
    tested, monitor = watched(start__pose="stow")
    look(monitor, tested, 0.5)
    for linear, angular in ((0.06, 0.0), (0.0, 0.3), (-0.5, 0.2)):
        for _ in range(23):
            drive(monitor, tested, linear, angular, 0.1)
            assert not monitor.stuck


def test_going_to_and_fro_is_not_stuck(watched):
    tested, monitor = watched(start__pose="stow")
    look(monitor, tested, 0.5)
    for sign in (1.0, -1.0) * 3:
        for _ in range(10):
            drive(monitor, tested, 0.5 * sign, 0.0, 0.1)
            assert not monitor.stuck


def test_acceleration_counts_while_time_stands_and_not_when_it_is_long_ago(watched):
    tested, monitor = watched(start__pose="stow")
    at_rest = look(monitor, tested, 0.5).margin
    look(monitor, tested, 0.1)
    tested.run(0.1)
    monitor.observe(tested.simulation.time)
    shove(tested)
    shoved = monitor.margin(tested.simulation.time)
    # 5 m/s2 to the right, over 0.1 s: it leans to the left.
    assert shoved.margin < 0.5 * at_rest
    assert math.sin(shoved.direction) == pytest.approx(1.0, abs=0.01)
    paused = [monitor.margin(tested.simulation.time) for _ in range(2)]
    assert [margin.margin for margin in paused] == pytest.approx([shoved.margin] * 2)
    # Nobody asks for a second.
    for _ in range(10):
        tested.run(0.1)
        monitor.observe(tested.simulation.time)
    shove(tested)
    assert monitor.margin(tested.simulation.time).margin == pytest.approx(at_rest, abs=0.02)


def test_an_emergency_stop_is_not_stuck(watched):
    tested, monitor = watched(start__pose="stow")
    look(monitor, tested, 0.5)
    tested.simulation.request_e_stop(True)
    drive(monitor, tested, 0.3, 0.0, 4.0)
    assert not monitor.stuck


@pytest.mark.parametrize(
    ("shape", "margin", "reach"),
    [('<box size="0.6 0.06 0.2"/>', 1.0, 0.3), ('<sphere radius="0.1"/>', 0.0, 0.0)],
)
def test_belts_of_a_shape_without_a_mesh_bear_where_they_touch(shape, margin, reach):
    offline = OfflineSimulation(
        _belts_round(shape),
        {},
        start={"place": (0.0, 0.0, 0.1, 0.0)},
        tracks={"belts": {"left_belt": 0.1, "right_belt": 0.1}},
        **{name: {} for name in ("hardware", "self_collision", "proximity", "gripper_contact")},
    )
    try:
        found = look(StabilityMonitor(offline.simulation.robots[0]), offline)
    finally:
        offline.simulation.close()
    assert found.margin == pytest.approx(margin, abs=0.05)
    assert max(x for x, _, _ in found.support) == pytest.approx(reach, abs=0.01)


def _belts_round(shape):
    """Describe a robot on two belts of one collision shape."""
    inertia = '<inertia ixx="0.2" iyy="0.2" izz="0.2" ixy="0" ixz="0" iyz="0"/>'
    parts = "".join(
        f"""<link name="{side}_track"><inertial><mass value="2"/>{inertia}</inertial>
          <collision><geometry>{shape}</geometry></collision></link>
          <joint name="{side}_mount" type="fixed"><parent link="base_link"/>
          <child link="{side}_track"/><origin xyz="0 {y} 0"/></joint>
          <link name="{side}_drum"><inertial><mass value="0.1"/>{inertia}</inertial></link>
          <joint name="{side}_belt" type="continuous"><parent link="{side}_track"/>
          <child link="{side}_drum"/><axis xyz="0 1 0"/></joint>
          <transmission name="{side}_drive"><type>transmission_interface/SimpleTransmission</type>
          <joint name="{side}_belt"><hardwareInterface>hardware_interface/VelocityJointInterface
          </hardwareInterface></joint>
          <actuator name="{side}_motor"><mechanicalReduction>1</mechanicalReduction></actuator>
          </transmission>"""
        for side, y in (("left", 0.2), ("right", -0.2))
    )
    return f"""<robot name="belts"><link name="base_link"><inertial><mass value="20"/>{inertia}
      </inertial></link>{parts}</robot>"""
