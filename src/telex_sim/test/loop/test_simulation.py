"""The shipped robot, through the topics that a client would use."""

from __future__ import annotations

import math
import re

import pybullet
import pytest
from geometry_msgs.msg import Twist
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from telex_control.common.params import ConfigError
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


def command(robot, joint, position):
    name = joint[: -len("_joint")]
    topic = f"{name}_position_controller/command"
    robot.node.advertise(topic, Float64).publish(Float64(position))


def drive(robot, linear, angular, seconds):
    """Send cmd_vel at 20 Hz, and return the turned angle (rad)."""
    publisher = robot.node.advertise("track_controller/cmd_vel", Twist)
    message = Twist()
    message.linear.x, message.angular.z = linear, angular
    turned, last = 0.0, heading(robot)
    for _ in range(round(seconds / 0.05)):
        publisher.publish(message)
        robot.run(0.05)
        turned += math.remainder(heading(robot) - last, 2.0 * math.pi)
        last = heading(robot)
    return turned


def heading(robot):
    return pybullet.getEulerFromQuaternion(robot.simulation.body.base_pose()[1])[2]


def place(robot):
    return robot.simulation.body.base_pose()[0]


def glide(robot, joint, target, rate):
    """Move a reference at a constant rate, as teleoperation does."""
    start = robot.positions()[joint]
    steps = max(1, round(abs(target - start) / rate / 0.01))
    for index in range(1, steps + 1):
        command(robot, joint, start + (target - start) * index / steps)
        robot.run(0.01)


@pytest.mark.parametrize("pose", ["ready", "drive", "look_front"])
def test_joints_hold_their_pose_under_gravity(robot, pose):
    tested = robot(start__pose=pose)
    wanted = tested.simulation.config.start.joint_positions()
    tested.run(2.0)
    for joint, position in tested.positions().items():
        if "track" not in joint:
            assert position == pytest.approx(wanted.get(joint, 0.0), abs=2e-3), joint


def test_the_robot_stands_still_on_its_tracks(robot):
    tested = robot()
    tested.run(1.0)
    before = place(tested)
    tested.run(2.0)
    assert math.dist(before, place(tested)) < 1e-3
    assert before[2] == pytest.approx(0.110, abs=2e-3)


def test_a_joint_goes_where_it_is_told_and_stays(robot):
    tested = robot()
    tested.run(0.5)
    glide(tested, "turret_joint", 0.4, 0.3)
    tested.run(1.0)
    assert tested.positions()["turret_joint"] == pytest.approx(0.4, abs=2e-3)
    others = {joint: tested.positions()[joint] for joint in ARM[1:]}
    wanted = tested.simulation.config.start.joint_positions()
    for joint, position in others.items():
        assert position == pytest.approx(wanted[joint], abs=5e-3)


def test_all_four_flippers_lift_the_robot(robot):
    tested = robot(start__pose="stow")
    tested.run(0.5)
    low = place(tested)[2]
    for angle in (1.0, 0.5, 0.0, -0.5, -1.0):
        for end in ("front", "rear"):
            for side in ("left", "right"):
                command(tested, f"{end}_{side}_flipper_joint", angle)
        tested.run(1.5)
    assert place(tested)[2] > low + 0.15


@pytest.mark.parametrize("speed", [0.3, 1.0, -0.5])
def test_driving_straight(robot, speed):
    tested = robot()
    tested.run(0.5)
    drive(tested, speed, 0.0, 1.0)
    start = place(tested)
    turned = drive(tested, speed, 0.0, 1.0)
    end = place(tested)
    assert end[0] - start[0] == pytest.approx(speed, rel=0.02)
    assert abs(end[1] - start[1]) < 0.01
    assert abs(turned) < 0.01


@pytest.mark.parametrize("rate", [0.5, -1.0])
def test_turning_in_place(robot, rate):
    tested = robot(start__pose="drive")
    tested.run(0.5)
    assert drive(tested, 0.0, rate, 3.0) == pytest.approx(3.0 * rate, rel=0.15)


def test_the_belts_accelerate_as_the_drive_controller_allows(robot):
    tested = robot()
    tested.run(0.5)
    drive(tested, 1.2, 0.0, 0.25)
    belt = tested.simulation.hw.joint_state("front_left_track_joint")
    # 2 m/s2 for 0.25 s over the drive wheel of 0.110 m
    assert belt.velocity == pytest.approx(2.0 * 0.25 / 0.110, rel=0.05)


def test_the_shipped_controllers_know_all_their_parameters(robot, caplog):
    robot()
    assert "does not know" not in caplog.text


def test_a_silent_command_stream_stops_the_tracks(robot):
    tested = robot()
    drive(tested, 0.5, 0.0, 1.0)
    tested.run(0.3 + 0.5)
    stopped = place(tested)
    tested.run(1.0)
    assert math.dist(stopped, place(tested)) < 2e-3


def test_same_inputs_give_bit_identical_states(robot):
    def run():
        tested = robot()
        tested.run(0.2)
        command(tested, "elbow_joint", 2.0)
        drive(tested, 0.4, 0.3, 0.5)
        return tested.simulation.link_poses()

    assert run() == run()


def test_reset_restores_poses_controllers_and_tracks_but_not_the_clock(robot):
    tested = robot()
    tested.run(0.5)
    fresh = tested.simulation.link_poses()
    glide(tested, "shoulder_joint", -1.2, 0.3)
    drive(tested, 0.5, 0.2, 1.0)
    time = tested.simulation.time
    tested.simulation.reset()
    assert tested.simulation.time == time
    tested.run(0.5)
    # to the last bit as after a fresh start: nothing of the past is left
    assert tested.simulation.link_poses() == fresh


def test_commands_from_before_a_reset_are_forgotten(robot):
    tested = robot()
    tested.run(0.1)
    command(tested, "elbow_joint", 2.2)
    tested.simulation.reset()
    tested.run(1.0)
    wanted = tested.simulation.config.start.joint_positions()["elbow_joint"]
    assert tested.positions()["elbow_joint"] == pytest.approx(wanted, abs=2e-3)


def test_emergency_stop_brakes_and_holds_until_released_and_commanded_anew(robot):
    tested = robot()
    tested.run(0.5)
    drive(tested, 1.0, 0.0, 1.0)
    tested.simulation.request_e_stop(True)
    tested.run(0.3)
    held, where = tested.positions(), place(tested)
    # whatever comes while it is set is not obeyed, then or later
    command(tested, "elbow_joint", held["elbow_joint"] - 0.5)
    drive(tested, 1.0, 0.0, 0.5)
    assert math.dist(where, place(tested)) < 5e-3
    tested.simulation.request_e_stop(False)
    tested.run(1.0)
    assert math.dist(where, place(tested)) < 5e-3
    for joint in ARM:
        assert tested.positions()[joint] == pytest.approx(held[joint], abs=3e-3), joint
    glide(tested, "elbow_joint", held["elbow_joint"] - 0.2, 0.3)
    tested.run(0.5)
    assert tested.positions()["elbow_joint"] == pytest.approx(held["elbow_joint"] - 0.2, abs=5e-3)


def test_an_emergency_stop_while_paused_is_obeyed_too(robot):
    tested = robot()
    tested.run(0.2)
    command(tested, "elbow_joint", 2.0)
    tested.simulation.request_e_stop(True)
    tested.simulation.idle()
    assert tested.simulation.hw.e_stop
    tested.simulation.request_e_stop(False)
    tested.simulation.idle()
    before = tested.positions()["elbow_joint"]
    tested.run(0.5)
    assert tested.positions()["elbow_joint"] == pytest.approx(before, abs=2e-3)


def test_a_stop_that_is_released_at_once_still_stops(robot):
    tested = robot()
    tested.run(0.2)
    command(tested, "turret_joint", 0.5)
    tested.simulation.request_e_stop(True)
    tested.simulation.request_e_stop(False)
    tested.run(1.0)
    assert tested.positions()["turret_joint"] == pytest.approx(0.0, abs=2e-3)
    assert not tested.simulation.hw.e_stop


def test_braked_joints_show_the_brakes_effort_not_a_command(robot):
    tested = robot()
    tested.run(0.5)
    tested.simulation.request_e_stop(True)
    command(tested, "turret_joint", 1.0)
    tested.run(0.5)
    efforts = {name: tested.simulation.hw.joint_state(name).effort for name in ARM}
    assert abs(efforts["turret_joint"]) < 5.0  # nothing pulls at it
    assert abs(efforts["shoulder_joint"]) > 5.0  # the brake carries the arm


def test_a_controller_that_ends_badly_leaves_its_joint_to_the_next(robot):
    tested = robot()
    tested.run(0.2)
    loaded = tested.simulation.controllers.loaded
    first = loaded["turret_position_controller"]
    hw = tested.simulation.hw
    second = type(first.info)("other", first.info.type, first.info.claimed_resources)
    hw.do_switch([second], [first.info])
    hw.do_switch([], [first.info])
    assert not hw._joints["turret_joint"].braked
    hw.do_switch([], [second])
    assert hw._joints["turret_joint"].braked


def test_joints_without_a_controller_are_held_by_their_brakes(robot):
    tested = robot()
    tested.run(0.2)
    before = tested.positions()["shoulder_joint"]
    loaded = tested.simulation.controllers.loaded
    shoulder = loaded["shoulder_position_controller"]
    shoulder.stop(tested.simulation.time)
    tested.simulation.hw.do_switch([], [shoulder.info])
    tested.run(1.0)
    assert tested.positions()["shoulder_joint"] == pytest.approx(before, abs=0.01)


def test_joint_states_show_effort(robot):
    tested = robot()
    received = []
    tested.node.subscribe("joint_states", JointState, received.append)
    tested.run(1.0)
    state = dict(zip(received[-1].name, received[-1].effort))
    assert len(received) in (100, 101)
    assert abs(state["shoulder_joint"]) > 5.0  # it carries the arm
    assert len(state) == 23


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"tracks__belts": {"nose": 0.1}, "tracks__drives": {}}, "tracks/belts/nose"),
        ({"start__poses": {"ready": {"nose": 0.1}}}, "start/poses/ready/nose"),
        ({"start__poses": {"ready": {"shoulder_joint": 9.0}}}, "shoulder_joint is 9.0"),
    ],
)
def test_joints_that_are_not_there_or_out_of_range_are_named(urdf, change, named):
    with pytest.raises(ConfigError) as caught:
        OfflineSimulation(urdf, **change)
    assert named in str(caught.value)


def test_a_belt_around_a_link_that_touches_nothing_is_named(urdf):
    link = re.search(r'<link name="front_left_flipper_link">.*?</link>', urdf, re.DOTALL).group()
    bare = urdf.replace(link, re.sub("<collision>.*</collision>", "", link, flags=re.DOTALL))
    assert bare != urdf
    says = r"tracks/belts/(\w+): the link 'front_left_flipper_link', .* has no <collision>"
    with pytest.raises(ConfigError, match=says):
        OfflineSimulation(bare)


def test_belts_of_two_drives_around_one_link_are_named(urdf):
    parent = r'(<joint name="front_right_track_joint".*?<parent link=")front_right(_flipper_link")'
    moved = re.sub(parent, r"\1front_left\2", urdf, flags=re.DOTALL)
    assert moved != urdf
    says = "front_right_track_joint: it runs around the link 'front_left_flipper_link', as front_l"
    with pytest.raises(ConfigError, match=says):
        OfflineSimulation(moved)


def test_control_runs_at_its_own_period(robot):
    tested = robot(timing__step_size=0.001, timing__control_period=0.002)
    received = []
    tested.node.subscribe("joint_states", JointState, received.append)
    tested.run(0.5)
    assert tested.simulation.steps == 500
    assert len(received) in (50, 51)
    assert tested.positions()["shoulder_joint"] == pytest.approx(
        tested.simulation.config.start.joint_positions()["shoulder_joint"], abs=2e-3
    )
