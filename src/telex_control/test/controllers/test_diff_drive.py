from __future__ import annotations

import math
import sys

import pytest
from control_msgs.msg import JointTrajectoryControllerState
from drive_rig import DriveRig
from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry
from tf2_msgs.msg import TFMessage

from telex_control.hardware.hardware_interface import (
    JointHandle,
    JointStateHandle,
    JointStateInterface,
    RobotHW,
    VelocityJointInterface,
)
from telex_control.urdf.joints import parse_urdf
from telex_control.urdf.wheel_geometry import wheel_separation

WHEELS = ("front_left", "front_right", "rear_left", "rear_right")


def urdf(radius="0.11", geometry="cylinder", y=0.25):
    shape = {
        "cylinder": f'<cylinder radius="{radius}" length="0.1"/>',
        "sphere": f'<sphere radius="{radius}"/>',
        "box": '<box size="1 1 1"/>',
    }[geometry]
    links = "".join(
        f'<link name="{name}_link"><collision><geometry>{shape}</geometry></collision></link>'
        f'<joint name="{name}" type="continuous"><parent link="base_link"/>'
        f'<child link="{name}_link"/><limit velocity="50" effort="9"/>'
        f'<origin xyz="{0.2 if "front" in name else -0.2} {y if "left" in name else -y} 0"/>'
        '<axis xyz="0 1 0"/></joint>'
        for name in WHEELS
    )
    return f'<robot name="cart"><link name="base_link"/>{links}</robot>'


CART = urdf()


class CartHW(RobotHW):
    """Four wheels that turn as they are told."""

    def __init__(self):
        super().__init__()
        states, velocities = JointStateInterface(), VelocityJointInterface()
        self.wheels = {name: JointHandle(JointStateHandle(name)) for name in WHEELS}
        for wheel in self.wheels.values():
            states.register_handle(wheel.state)
            velocities.register_handle(wheel)
        for interface in (states, velocities):
            self.register_interface(interface)

    def advance(self, period):
        for wheel in self.wheels.values():
            wheel.state.velocity = wheel.command
            wheel.state.position += wheel.command * period


PARAMS = {
    "type": "diff_drive_controller/DiffDriveController",
    "left_wheel": ["front_left", "rear_left"],
    "right_wheel": ["front_right", "rear_right"],
    "wheel_radius": 0.1,
    "wheel_separation": 0.5,
    "cmd_vel_timeout": 0.5,
    "pose_covariance_diagonal": [1, 2, 3, 4, 5, 6],
    "twist_covariance_diagonal": [0.1] * 6,
}


class Cart(DriveRig):
    def __init__(self, bench, description, params):
        super().__init__(bench, CartHW(), description, {**PARAMS, **params})

    def speeds(self):
        """Speed of the left and of the right wheels (rad/s)."""
        commands = {name: wheel.command for name, wheel in self.hw.wheels.items()}
        assert commands["front_left"] == commands["rear_left"]
        assert commands["front_right"] == commands["rear_right"]
        return commands["front_left"], commands["front_right"]

    def pose(self):
        odometry = self.controller._odometry
        return odometry.x, odometry.y, odometry.heading


@pytest.fixture
def cart(bench):
    return lambda description=CART, **params: Cart(bench, description, params).start()


@pytest.fixture
def refused(bench, caplog):
    def load(description=CART, **params):
        assert not Cart(bench, description, params).loaded
        return caplog.text

    return load


LINEAR = {
    "x": {
        "has_velocity_limits": True,
        "max_velocity": 1.0,
        "min_velocity": -0.5,
        "has_acceleration_limits": True,
        "max_acceleration": 1.0,
        "min_acceleration": -0.5,
    }
}
ANGULAR = {
    "z": {
        "has_velocity_limits": True,
        "max_velocity": 2.0,
        "has_acceleration_limits": True,
        "max_acceleration": 2.0,
    }
}


# --- motion ----------------------------------------------------------------------------------


def test_no_command_no_motion(cart):
    tested = cart()
    tested.run(1.0)
    assert tested.pose() == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("speed", [0.3, -0.3])
def test_forward_and_backward(cart, speed):
    tested = cart()
    tested.drive(speed, 0.0, 2.0)
    assert tested.pose() == pytest.approx((2.0 * speed, 0.0, 0.0), abs=0.003)
    assert tested.speeds() == pytest.approx((10.0 * speed, 10.0 * speed))


@pytest.mark.parametrize("rate", [0.5, -0.5])
def test_turning_on_the_spot(cart, rate):
    tested = cart()
    tested.drive(0.0, rate, 2.0)
    assert tested.pose() == pytest.approx((0.0, 0.0, 2.0 * rate), abs=0.003)
    assert tested.speeds() == pytest.approx((-2.5 * rate, 2.5 * rate))


def test_a_quarter_circle(cart):
    tested = cart()
    tested.drive(0.5, 0.5, math.pi)
    assert tested.pose() == pytest.approx((1.0, 1.0, math.pi / 2), abs=0.05)
    assert tested.pose()[0] ** 2 + (tested.pose()[1] - 1.0) ** 2 == pytest.approx(1.0, abs=1e-4)


def test_a_single_wheel_a_side_may_be_a_string(cart):
    tested = cart(left_wheel="front_left", right_wheel="front_right")
    tested.send(0.2, 0.0)
    tested.run(0.1)
    wheels = tested.hw.wheels
    assert wheels["front_left"].command == pytest.approx(2.0)
    assert wheels["rear_left"].command == 0.0


# --- time-out, limits ------------------------------------------------------------------------


def test_a_command_holds_until_the_time_out(cart):
    tested = cart(cmd_vel_timeout=0.3)
    tested.send(0.2, 0.0)
    tested.run(0.29)
    assert tested.speeds() == pytest.approx((2.0, 2.0))
    tested.run(0.02)
    assert tested.speeds() == (0.0, 0.0)


def test_after_the_time_out_it_brakes_and_does_not_jump(cart):
    tested = cart(cmd_vel_timeout=0.3, linear=LINEAR)
    tested.drive(1.0, 0.0, 1.5)
    tested.run(0.25)
    before = tested.speeds()[0]
    assert before == pytest.approx(10.0, rel=0.02)
    tested.run(0.2)
    assert tested.speeds()[0] == pytest.approx(before - 0.5 * 0.2 * 10.0, abs=0.3)
    tested.run(2.0)
    assert tested.speeds() == (0.0, 0.0)


def test_linear_acceleration_and_velocity_are_limited(cart):
    tested = cart(linear=LINEAR)
    tested.drive(10.0, 0.0, 0.5)
    assert tested.speeds()[0] == pytest.approx(5.0, rel=0.01)
    tested.drive(10.0, 0.0, 1.0)
    assert tested.speeds()[0] == pytest.approx(10.0)
    tested.drive(-10.0, 0.0, 1.0)
    assert tested.speeds()[0] == pytest.approx(5.0, rel=0.01)
    tested.drive(-10.0, 0.0, 3.0)
    assert tested.speeds()[0] == pytest.approx(-5.0)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_braking_has_a_limit_of_its_own(cart, way):
    tested = cart(linear={"x": {**LINEAR["x"], "min_velocity": -1.0, "max_deceleration": 4.0}})
    tested.drive(way, 0.0, 2.5)
    assert tested.speeds()[0] == pytest.approx(10.0 * way)
    tested.drive(0.0, 0.0, 0.15)
    assert tested.speeds()[0] == pytest.approx(4.0 * way, rel=0.03)
    tested.drive(0.0, 0.0, 0.15)
    assert tested.speeds()[0] == 0.0


def test_a_publisher_that_is_gone_stops_it(cart):
    tested = cart(cmd_vel_timeout=0.3)
    tested.send(0.2, 0.0)
    tested.run(0.1)
    assert tested.speeds() == pytest.approx((2.0, 2.0))
    tested.command.close()
    tested.run(0.002)
    assert tested.speeds() == (0.0, 0.0)


def test_angular_acceleration_and_velocity_are_limited(cart):
    tested = cart(angular=ANGULAR)
    tested.drive(0.0, 10.0, 0.5)
    assert tested.speeds()[1] == pytest.approx(2.5, rel=0.01)
    tested.drive(0.0, 10.0, 1.0)
    assert tested.speeds()[1] == pytest.approx(5.0)


def test_jerk_is_limited(cart):
    tested = cart(linear={"x": {"has_jerk_limits": True, "max_jerk": 5.0}})
    speeds = [0.0]
    tested.send(1.0, 0.0)
    for _ in range(100):
        tested.run(0.002)
        speeds.append(0.1 * tested.speeds()[0])
    changes = [b - a for a, b in zip(speeds, speeds[1:])]
    seconds = [b - a for a, b in zip(changes, changes[1:])]
    assert max(map(abs, seconds)) == pytest.approx(2.0 * 5.0 * 0.002**2)
    assert speeds[100] > 0.1


def test_without_limits_commands_are_followed_at_once(cart):
    tested = cart()
    tested.send(5.0, 0.0)
    tested.run(0.002)
    assert tested.speeds()[0] == pytest.approx(50.0)


def test_limits_of_the_product_bound_each_twist_component(cart):
    tested = cart(linear=LINEAR, angular=ANGULAR)
    tested.drive(9.0, 9.0, 2.0)
    assert tested.speeds() == pytest.approx(((1.0 - 0.5) / 0.1, (1.0 + 0.5) / 0.1))


# --- faults ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "bad", [(math.nan, 0.0), (0.0, math.nan), (math.inf, 0.0), (0.0, -math.inf)]
)
def test_commands_that_are_no_numbers_are_dropped(cart, bad, caplog):
    tested = cart()
    tested.send(0.2, 0.0)
    tested.run(0.1)
    tested.send(*bad)
    tested.run(0.1)
    assert tested.speeds() == pytest.approx((2.0, 2.0))  # the good one still holds
    assert "cmd_vel" in caplog.text


def test_stopping_brakes_at_once(cart):
    tested = cart(linear=LINEAR)
    tested.drive(1.0, 0.0, 1.0)
    assert tested.bench.switch(stop=["d"])
    assert tested.speeds() == (0.0, 0.0)


def test_commands_from_before_the_start_are_forgotten(cart):
    tested = cart()
    tested.drive(1.0, 0.0, 0.5)
    assert tested.bench.switch(stop=["d"])
    tested.send(1.0, 0.0)
    assert tested.bench.switch(start=["d"])
    tested.run(0.1)
    assert tested.speeds() == (0.0, 0.0)


def test_an_interruption_forgets_the_command_and_brakes_within_the_limits(cart):
    tested = cart(linear=LINEAR)
    tested.drive(0.8, 0.0, 1.5)
    before = tested.speeds()[0]
    assert before > 0.0
    tested.send(0.8, 0.0)
    tested.bench.manager.interrupt(tested.bench.time)
    tested.run(tested.bench.period)
    once = before - tested.speeds()[0]
    tested.run(tested.bench.period)
    twice = before - tested.speeds()[0]
    assert 0.0 < once < 0.2 * before
    assert twice == pytest.approx(2.0 * once, rel=1e-6)
    tested.run(2.0)
    assert tested.speeds() == (0.0, 0.0)


def test_a_command_that_is_old_by_the_wall_is_not_driven(cart, monkeypatch):
    tested = cart()
    now = [100.0]
    module = sys.modules[type(tested.controller).__module__]
    monkeypatch.setattr(module.wall, "monotonic", lambda: now[0])
    tested.send(0.2, 0.0)  # while the simulation is paused, and the pause goes on
    now[0] += 5.0
    tested.run(0.1)
    assert tested.speeds() == (0.0, 0.0)


def test_a_second_publisher_brakes_when_only_one_is_allowed(cart, caplog):
    tested = cart(allow_multiple_cmd_vel_publishers=False, linear=LINEAR)
    tested.drive(0.5, 0.0, 1.0)
    assert tested.speeds()[0] == pytest.approx(5.0)
    other = tested.node.advertise("d/cmd_vel", Twist)
    other.publish(Twist())
    tested.run(0.002)
    assert tested.speeds() == (0.0, 0.0)
    assert "2 publishers" in caplog.text
    tested.drive(0.5, 0.0, 0.5)
    assert tested.speeds() == (0.0, 0.0)
    other.close()
    tested.drive(0.5, 0.0, 1.0)
    assert tested.speeds()[0] == pytest.approx(5.0)


def test_several_publishers_are_allowed_by_default(cart):
    tested = cart()
    tested.node.advertise("d/cmd_vel", Twist)
    tested.drive(0.5, 0.0, 0.2)
    assert tested.speeds()[0] == pytest.approx(5.0)


# --- geometry --------------------------------------------------------------------------------


@pytest.mark.parametrize("geometry", ["cylinder", "sphere"])
def test_geometry_comes_from_the_robot_description(cart, geometry):
    tested = cart(urdf(geometry=geometry), wheel_radius=None, wheel_separation=None)
    tested.send(0.0, 1.0)
    tested.run(0.01)
    assert tested.speeds()[1] == pytest.approx(0.25 / 0.11)


def test_wheels_on_suspensions_are_as_far_apart_as_they_stand(cart):
    sprung = urdf(y=0.05).replace(
        '<robot name="cart"><link name="base_link"/>',
        '<robot name="cart"><link name="base_link"/>'
        + "".join(
            f'<link name="{side}_arm"/><joint name="{side}_spring" type="prismatic">'
            f'<parent link="base_link"/><child link="{side}_arm"/><axis xyz="0 0 1"/>'
            f'<origin xyz="0 {y} 0.1" rpy="0 0 {turn}"/>'
            '<limit lower="-0.1" upper="0.1" effort="1" velocity="1"/></joint>'
            for side, y, turn in (("left", 0.2, 0.0), ("right", -0.2, 3.141592653589793))
        ),
    )
    for name in WHEELS:
        side = "left" if "left" in name else "right"
        sprung = sprung.replace(
            f'"{name}" type="continuous"><parent link="base_link"/>',
            f'"{name}" type="continuous"><parent link="{side}_arm"/>',
        )
    description = parse_urdf(sprung)
    assert wheel_separation(description, "front_left", "rear_right") == pytest.approx(0.4)


def test_parameters_are_preferred_to_the_robot_description(cart):
    tested = cart(urdf(geometry="box"), wheel_separation=None)
    tested.send(0.2, 0.0)
    tested.run(0.01)
    assert tested.speeds()[1] == pytest.approx(2.0)


def test_multipliers_scale_the_geometry(cart):
    tested = cart(wheel_radius_multiplier=2.0, wheel_separation_multiplier=3.0)
    tested.send(0.2, 0.4)
    tested.run(0.01)
    assert tested.speeds() == pytest.approx(((0.2 - 0.3) / 0.2, (0.2 + 0.3) / 0.2))


def test_each_side_may_have_its_own_multiplier(cart):
    tested = cart(left_wheel_radius_multiplier=0.5, right_wheel_radius_multiplier=2.0)
    tested.send(0.2, 0.0)
    tested.run(0.01)
    assert tested.speeds() == pytest.approx((4.0, 1.0))
    tested.drive(0.2, 0.0, 1.0)
    assert tested.pose()[2] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(
    ("description", "params", "logged"),
    [
        (urdf(geometry="box"), {"wheel_radius": None}, "does not collide as a cylinder"),
        (urdf(radius="-1"), {"wheel_radius": None}, "radius of its cylinder is -1 m"),
        (urdf(y=0.0), {"wheel_separation": None}, "in the same place"),
        ("<robot/>", {"wheel_radius": None}, "no wheel joint 'front_left'"),
        ("no robot", {"wheel_separation": None}, "is no XML"),
        (urdf(), {"left_wheel": ["front_left"]}, "same number"),
        (urdf(), {"left_wheel": []}, "left_wheel"),
        (urdf(), {"left_wheel": [3]}, "left_wheel"),
        (urdf(), {"left_wheel": None}, "left_wheel is missing"),
        (urdf(), {"right_wheel": ["nose", "ear"]}, "'nose'"),
        (urdf(), {"wheel_radius": 0.0}, "wheel_radius is 0.0"),
        (urdf(), {"wheel_separation": "wide"}, "wheel_separation is 'wide'"),
        (urdf(), {"wheel_separation_multiplier": -1.0}, "wheel_separation_multiplier is -1.0"),
        (urdf(), {"pose_covariance_diagonal": None}, "pose_covariance_diagonal is missing"),
        (urdf(), {"pose_covariance_diagonal": [1.0]}, "six finite numbers"),
        (urdf(), {"twist_covariance_diagonal": [math.nan] * 6}, "six finite numbers"),
        (urdf(), {"linear": {"x": {"has_jerk_limits": True}}}, "linear/x/max_jerk"),
        (urdf(), {"linear": {"x": {"max_speed": 1.0}}}, "linear/x/max_speed is unknown"),
        (urdf(), {"velocity_rolling_window_size": 0}, "velocity_rolling_window_size"),
        (urdf(), {"publish_rate": 0.0}, "publish_rate is 0.0"),
        (urdf(), {"cmd_vel_timeout": -1.0}, "cmd_vel_timeout is -1.0"),
    ],
)
def test_wrong_parameters_are_named(refused, description, params, logged):
    assert logged in refused(description, **params)


# --- what it publishes -----------------------------------------------------------------------


def test_odometry_and_its_frames(cart):
    tested = cart(publish_rate=50.0)
    odometry = tested.listen("d/odom", Odometry)
    tested.drive(0.3, 0.2, 1.0)
    assert len(odometry) in (50, 51)
    last = odometry[-1]
    assert (last.header.frame_id, last.child_frame_id) == ("odom", "base_link")
    assert last.pose.covariance[::7] == (1, 2, 3, 4, 5, 6)
    assert last.twist.covariance[::7] == (0.1,) * 6
    assert last.twist.twist.linear.x == pytest.approx(0.3, rel=1e-6)
    assert last.twist.twist.angular.z == pytest.approx(0.2, rel=1e-6)
    assert 2.0 * math.asin(last.pose.pose.orientation.z) == pytest.approx(0.2, abs=0.01)


def test_other_frames(cart):
    tested = cart(odom_frame_id="world", base_frame_id="hull")
    transforms = tested.listen("/tf", TFMessage)
    odometry = tested.listen("d/odom", Odometry)
    tested.run(0.1)
    (transform,) = transforms[-1].transforms
    assert (transform.header.frame_id, transform.child_frame_id) == ("world", "hull")
    assert (odometry[-1].header.frame_id, odometry[-1].child_frame_id) == ("world", "hull")


def test_the_transform_is_that_of_the_odometry(cart):
    tested = cart()
    transforms = tested.listen("/tf", TFMessage)
    tested.drive(0.5, 0.0, 1.0)
    (transform,) = transforms[-1].transforms
    assert transform.transform.translation.x == pytest.approx(0.49, abs=0.02)


def test_without_a_transform(cart):
    tested = cart(enable_odom_tf=False)
    transforms = tested.listen("/tf", TFMessage)
    tested.run(0.2)
    assert transforms == []


def test_open_loop_odometry_believes_the_commands(cart):
    tested = cart(open_loop=True)
    tested.hw.advance = lambda period: None  # the wheels are stuck
    tested.drive(0.3, 0.0, 1.0)
    assert tested.pose()[0] == pytest.approx(0.3, abs=0.002)


def test_odometry_measures_what_the_wheels_do(cart):
    tested = cart()
    tested.hw.advance = lambda period: None
    tested.drive(0.3, 0.0, 1.0)
    assert tested.pose() == (0.0, 0.0, 0.0)


def test_a_reset_puts_the_odometry_back(cart):
    tested = cart()
    tested.drive(0.3, 0.1, 1.0)
    tested.bench.manager.reset(tested.bench.time)
    assert tested.pose() == (0.0, 0.0, 0.0)
    assert tested.speeds() == (0.0, 0.0)


def test_the_limited_command_is_published_when_asked_for(cart):
    tested = cart(publish_cmd=True, linear=LINEAR)
    commands = tested.listen("d/cmd_vel_out", TwistStamped)
    tested.send(9.0, 0.5)
    tested.run(0.4)
    assert len(commands) == 200  # every cycle
    assert commands[-1].twist.linear.x == pytest.approx(0.4)
    assert commands[-1].twist.angular.z == 0.5
    assert commands[-1].header.frame_id == "base_link"


def test_commands_are_not_published_by_default(cart):
    tested = cart()
    commands = tested.listen("d/cmd_vel_out", TwistStamped)
    states = tested.listen("d/wheel_joint_controller_state", JointTrajectoryControllerState)
    tested.drive(0.3, 0.0, 0.2)
    assert commands == states == []


def test_the_state_of_the_wheels_is_published_when_asked_for(cart):
    tested = cart(publish_wheel_joint_controller_state=True)
    states = tested.listen("d/wheel_joint_controller_state", JointTrajectoryControllerState)
    tested.send(0.3, 0.0)
    tested.run(0.2)
    assert len(states) == 100
    last = states[-1]
    assert last.joint_names == ["front_left", "rear_left", "front_right", "rear_right"]
    assert last.desired.velocities == pytest.approx([3.0] * 4)
    assert last.actual.velocities == pytest.approx([3.0] * 4)
    assert last.desired.positions == pytest.approx([0.6] * 4)
    assert last.error.positions == pytest.approx([0.006] * 4)  # measured a cycle ago
    assert states[0].desired.accelerations == pytest.approx([1500.0] * 4)
    assert all(map(math.isnan, last.desired.effort))


# --- run-time changes ------------------------------------------------------------------------


def test_geometry_changes_at_run_time(cart):
    tested = cart()
    tested.send(0.2, 0.4)
    tested.run(0.01)
    tested.node.reconfigure(
        "d",
        left_wheel_radius_multiplier=0.5,
        right_wheel_radius_multiplier=1.5,
        wheel_separation_multiplier=1.2,
    )
    tested.run(0.002)
    assert tested.speeds() == pytest.approx(((0.2 - 0.12) / 0.05, (0.2 + 0.12) / 0.15))


def test_values_out_of_range_are_bounded(cart):
    tested = cart()
    values = tested.node.reconfigure("d", wheel_separation_multiplier=9.0)
    assert values["wheel_separation_multiplier"] == 1.5


def test_rate_and_transform_change_at_run_time(cart):
    tested = cart()
    transforms = tested.listen("/tf", TFMessage)
    tested.node.reconfigure("d", publish_rate=10.0)
    tested.run(1.0)
    assert len(transforms) in (10, 11)
    tested.node.reconfigure("d", enable_odom_tf=False)
    transforms.clear()
    tested.run(0.5)
    assert transforms == []
    with pytest.raises(ValueError, match="publish_rate"):
        tested.node.reconfigure("d", publish_rate=0.0)
