"""Malfunctions in the simulation: what each does to the robot, refusals, reset and bookmarks."""

from __future__ import annotations

import math
import sys

import pytest

from telex_control.common.params import ConfigError
from telex_sim.engine.bookmarks import Bookmarks
from telex_sim.malfunctions.battery import Battery, BatteryConfig, Reach, charge_of
from telex_sim.malfunctions.described import described_parts, shipped_equipment
from telex_sim.offline.robot import OfflineRobot
from telex_sim.offline.simulation import OfflineSimulation
from telex_sim.scene.robot_in_scene import robot_description

pytestmark = pytest.mark.slow

SHOULDER, FLIPPER = "shoulder_joint", "front_left_flipper_joint"


class Bench:
    """The shipped robot on level ground, and ways to break it."""

    def __init__(self, offline):
        self.simulation = offline.simulation
        self.robot = OfflineRobot(offline)
        self.body = self.simulation.robots[0]
        self.hw = self.body.hw
        self.malfunctions = self.body.malfunctions
        self.run = offline.run

    def begin(self, what, kind, value=0.0):
        return self.malfunctions.begin(what, kind, value, False, self.simulation.time)

    def position(self, joint):
        return self.hw.joint_state(joint).position

    def effort(self, joint):
        return self.hw.joint_state(joint).effort

    def drive(self, linear, angular, seconds):
        """Drive; returns how far ahead it got (m), and its heading (rad)."""
        for _ in range(round(10 * seconds)):
            self.robot.drive(linear, angular)
            self.run(0.1)
        (x, _, _), (_, _, z, w) = self.robot.base_pose()
        return x, 2.0 * math.atan2(z, w)


@pytest.fixture(scope="module")
def made(urdf):
    offline = OfflineSimulation(urdf)
    yield Bench(offline)
    offline.simulation.close()


@pytest.fixture
def bench(made):
    made.body.request_e_stop(False)
    made.simulation.reset()
    made.run(0.2)
    return made


# --- joints


def test_a_weak_joint_gives_the_share_of_its_effort(bench):
    bench.begin(SHOULDER, "weak", 0.02)
    bench.robot.move({SHOULDER: 0.5})
    bench.run(0.01)
    efforts = []
    for _ in range(50):
        bench.run(0.002)
        efforts.append(abs(bench.effort(SHOULDER)))
    assert max(efforts) == pytest.approx(0.02 * 350.0)


def test_the_brake_of_a_weak_joint_is_as_strong_as_ever(bench):
    bench.begin(SHOULDER, "weak", 0.02)
    assert bench.hw.drive(SHOULDER).holding_force == 350.0


def test_a_stuck_joint_stays_while_its_drive_tries(bench):
    before = bench.position(SHOULDER)
    bench.begin(SHOULDER, "stuck")
    bench.robot.move({SHOULDER: before + 0.5})
    bench.run(0.5)
    assert bench.position(SHOULDER) == pytest.approx(before, abs=1e-3)
    assert bench.effort(SHOULDER) == pytest.approx(350.0)


def test_what_was_stuck_does_not_jump_when_it_is_free_again(bench):
    before = bench.position(SHOULDER)
    bench.begin(SHOULDER, "stuck")
    bench.robot.move({SHOULDER: before + 0.5})
    bench.run(0.3)
    bench.malfunctions.end(SHOULDER)
    bench.run(0.3)
    assert bench.position(SHOULDER) == pytest.approx(before, abs=0.01)
    bench.robot.move({SHOULDER: before + 0.1})
    bench.run(1.0)
    assert bench.position(SHOULDER) == pytest.approx(before + 0.1, abs=0.02)


def test_a_joint_that_becomes_less_weak_stays_where_it_is(bench):
    before = bench.position(SHOULDER)
    bench.begin(SHOULDER, "weak", 0.02)
    bench.robot.move({SHOULDER: before - 0.5})
    bench.run(0.2)
    now = bench.position(SHOULDER)
    bench.begin(SHOULDER, "weak", 0.95)
    bench.run(0.5)
    assert bench.position(SHOULDER) == pytest.approx(now, abs=0.05)


def test_nothing_holds_a_limp_joint(bench):
    before = bench.position(SHOULDER)
    bench.begin(SHOULDER, "limp")
    bench.run(0.1)
    bench.body.request_e_stop(True)
    bench.run(0.5)
    assert bench.effort(SHOULDER) == 0.0
    assert abs(bench.position(SHOULDER) - before) > 0.1


def test_a_limp_joint_that_works_again_stays_where_it_fell(bench):
    before = bench.position(SHOULDER)
    bench.begin(SHOULDER, "limp")
    bench.run(0.6)
    fallen = bench.position(SHOULDER)
    bench.malfunctions.end(SHOULDER)
    bench.run(0.5)
    assert abs(fallen - before) > 0.1
    assert bench.position(SHOULDER) == pytest.approx(fallen, abs=0.1)


def test_a_slipping_flipper_does_not_lift_the_robot_that_a_sound_one_lifts(bench):
    def press():
        for joint in (FLIPPER, "front_right_flipper_joint"):
            bench.robot.move({joint: 1.2})
        bench.run(2.0)
        return bench.position(FLIPPER)

    for joint in (FLIPPER, "front_right_flipper_joint"):
        bench.begin(joint, "slipping", 20.0)
    slipped = press()
    bench.malfunctions.end()
    bench.run(0.01)
    assert press() > slipped + 0.3
    assert bench.hw.drive(FLIPPER).holding_force == 300.0


def test_the_brake_is_behind_the_clutch_that_slips(bench):
    bench.begin(FLIPPER, "slipping", 20.0)
    assert bench.hw.drive(FLIPPER).holding_force == 20.0
    bench.body.request_e_stop(True)
    bench.run(0.1)
    assert abs(bench.effort(FLIPPER)) <= 20.0


def test_a_gripper_that_has_lost_its_force_does_not_press(bench):
    bench.begin("gripper", "lost", 0.75)
    for joint in bench.body.finger_joints():
        drive = bench.hw.drive(joint)
        assert drive.max_effort == pytest.approx(0.25 * drive.rated_effort)


# --- belts


def test_a_weak_belt_does_not_turn_the_robot_as_fast(bench):
    _, sound = bench.drive(0.0, 1.0, 0.6)
    bench.simulation.reset()
    bench.begin("left_belt", "weak", 0.05)
    bench.begin("right_belt", "weak", 0.05)
    _, weak = bench.drive(0.0, 1.0, 0.6)
    assert 0.0 <= weak < 0.5 * sound


def test_a_stuck_belt_turns_the_robot_to_its_side(bench):
    bench.begin("left_belt", "stuck")
    _, heading = bench.drive(0.5, 0.0, 1.0)
    assert bench.hw.joint_state("front_left_track_joint").velocity == pytest.approx(0.0, abs=1e-3)
    assert heading > 0.1


def test_a_limp_belt_is_turned_by_the_ground_and_not_by_its_motor(bench):
    bench.begin("left_belt", "limp")
    bench.begin("right_belt", "limp")
    x, _ = bench.drive(0.5, 0.0, 0.5)
    assert x == pytest.approx(0.0, abs=0.01)


def test_thrown_belts_run_freely_and_leave_the_robot_where_it_is(bench):
    bench.begin("left_belt", "thrown")
    bench.begin("right_belt", "thrown")
    x, _ = bench.drive(0.5, 0.0, 1.0)
    assert x == pytest.approx(0.0, abs=0.02)
    assert bench.hw.joint_state("front_left_track_joint").velocity == pytest.approx(
        0.5 / 0.110, rel=0.02
    )
    bench.malfunctions.end()
    x, _ = bench.drive(0.5, 0.0, 1.0)
    assert x > 0.3


# --- sensors


def test_the_gyroscope_of_a_biased_sensor_leads_its_heading_astray(bench):
    imu = bench.hw.imus[0]
    before = imu.handle.angular_velocity[2]
    bench.begin("imu", "bias", -0.3)
    bench.run(0.5)
    assert imu.handle.angular_velocity[2] == pytest.approx(before - 0.3, abs=0.05)
    assert 2.0 * imu.handle.orientation[2] == pytest.approx(-0.15, abs=0.01)


# --- battery


def test_power_runs_a_battery_down():
    battery = Battery(BatteryConfig(energy=10.0), 0.5)
    battery.drain(100.0, 90.0)
    assert battery.share == pytest.approx(0.25)
    assert battery.unpowered == ()


def test_cameras_live_longer_than_drives_and_lamps():
    battery = Battery(BatteryConfig(energy=1.0, camera_reserve=60.0), 0.001)
    battery.drain(100.0, 1.0)
    assert battery.unpowered == ("drives", "lamps")
    battery.drain(100.0, 61.0)
    assert battery.unpowered == ("drives", "lamps", "cameras")


def test_voltage_falls_with_charge_and_with_load():
    config = BatteryConfig()
    assert charge_of(config, 1.0, 0.0).voltage == config.voltage
    assert charge_of(config, 0.5, 500.0).voltage < charge_of(config, 0.5, 0.0).voltage
    charge = charge_of(config, 0.5, 500.0)
    assert charge.voltage * charge.current == pytest.approx(500.0)


def test_the_range_follows_what_the_robot_takes_per_metre():
    reach = Reach(BatteryConfig(energy=1.0, consumption=360.0, averaging_way=5.0))
    assert reach.of(0.5) == pytest.approx(5.0)
    for second in range(60):
        reach.be_at((0.5 * second, 0.0, 0.0), 90.0, float(second))
    assert reach.of(0.5) == pytest.approx(10.0, rel=0.01)
    # Standing takes nothing for a metre, and being put elsewhere is no way.
    for second in range(60, 120):
        reach.be_at((29.5, 0.0, 0.0), 90.0, float(second))
    reach.be_at((-10.0, 0.0, 0.0), 90.0, 120.0)
    reach.be_at((-10.5, 0.0, 0.0), 90.0, 120.0)
    assert reach.of(0.5) == pytest.approx(10.0, rel=0.01)
    assert reach.of(0.0) == 0.0


def test_a_robot_that_takes_nothing_has_a_range_all_the_same():
    config = BatteryConfig(base_power=0.0, averaging_way=1.0)
    reach = Reach(config)
    for second in range(3):
        reach.be_at((2.0 * second, 0.0, 0.0), 0.0, float(second))
    assert math.isfinite(reach.of(1.0))
    assert reach.of(1.0) > Reach(config).of(1.0)
    assert math.isfinite(Reach(BatteryConfig(consumption=1e-320)).of(1.0))


def test_driving_tells_how_far_the_charge_lasts(bench):
    bench.begin("battery", "low", 0.5)
    shipped = bench.body.config.battery
    told = []
    for _ in range(12):
        bench.drive(0.5, 0.0, 1.0)
        told.append(bench.malfunctions.reach(bench.simulation.time))
    consumption = 0.5 * shipped.energy * 3600.0 / told[-1]
    assert 0.6 * shipped.consumption < consumption < 1.5 * shipped.consumption
    bench.begin("battery", "low", 0.25)
    assert bench.malfunctions.reach(bench.simulation.time) == pytest.approx(told[-1] / 2, rel=0.02)


def test_an_empty_battery_lets_the_brakes_hold_belts_and_joints(bench):
    bench.begin("battery", "low", 0.0001)
    bench.drive(0.5, 0.0, 0.4)
    assert 0.0 < bench.malfunctions.charge().share < 0.0001
    for _ in range(40):  # 324 J at 90 W and more
        bench.drive(0.5, 0.0, 0.1)
        if bench.malfunctions.unpowered:
            break
    assert bench.malfunctions.unpowered == ("drives", "lamps")
    bench.run(0.5)
    x, _ = bench.drive(0.5, 0.0, 0.3)
    assert all(drive.braked for drive in bench.hw.drives())
    assert bench.drive(0.5, 0.0, 0.3)[0] == pytest.approx(x, abs=1e-3)
    bench.malfunctions.end("battery")
    assert bench.drive(0.5, 0.0, 0.6)[0] > x + 0.05


def test_lamps_and_motion_take_power(bench):
    rest = bench.malfunctions.charge().current
    bench.malfunctions.lamp_levels = 2.0
    lit = bench.malfunctions.charge().current
    bench.malfunctions.lamp_levels = 0.0
    bench.drive(0.8, 0.0, 0.2)
    assert lit > rest
    assert bench.malfunctions.charge().current > rest + 0.2


# --- refusals


@pytest.mark.parametrize(
    ("what", "kind", "value", "words"),
    [
        ("hull", "weak", 0.0, "there are: front_left_flipper_joint, "),
        ("", "weak", 0.0, "what is ''"),
        (SHOULDER, "thrown", 0.0, "shoulder_joint can be: weak, stuck, limp"),
        (SHOULDER, "slipping", 0.0, "can be"),
        (SHOULDER, "weak", 1.5, "0.02 to 0.95"),
        (SHOULDER, "weak", -0.1, "0.02 to 0.95"),
        (SHOULDER, "weak", math.nan, "a finite number"),
        ("imu", "bias", math.inf, "a finite number"),
        (SHOULDER, "stuck", 1.0, "0 is needed"),
        ("arm", "frozen", 0.0, "what is 'arm'"),  # nobody has told of cameras
    ],
)
def test_refusals_say_what_would_be_right(bench, what, kind, value, words):
    with pytest.raises(ConfigError, match=words):
        bench.begin(what, kind, value)
    assert bench.malfunctions.active == ()


def test_what_does_not_fail_cannot_be_ended(bench):
    bench.begin("left_belt", "thrown")
    with pytest.raises(ConfigError, match="there is: left_belt thrown"):
        bench.malfunctions.end("right_belt")
    with pytest.raises(ConfigError, match="there is: left_belt thrown"):
        bench.malfunctions.end("left_belt", "stuck")


def test_only_cameras_and_lamps_that_the_robot_has_can_fail(bench):
    bench.malfunctions.equip(
        {"arm": {"frame": "arm_camera_optical_frame"}, "far": {"frame": "nowhere"}, "odd": 3},
        {"gripper": {"frame": "gripper_lamp_link"}, "listed": {"frame": ["gripper_lamp_link"]}},
    )
    parts = bench.malfunctions.parts
    assert (parts.cameras, parts.lamps) == (("arm",), ("gripper",))
    # The gripper and its lamp have one name: their kinds differ.
    assert bench.begin("gripper", "dead").group == "lamp"
    assert bench.begin("gripper", "lost").group == "gripper"
    assert bench.begin("arm", "noisy").value == 40.0
    bench.malfunctions.equip({}, {})


# --- together, reset, bookmarks, cost


def test_several_of_one_joint_add_up(bench):
    bench.begin(SHOULDER, "weak", 0.5)
    bench.begin(SHOULDER, "limp")
    assert bench.hw.drive(SHOULDER).max_effort == 0.0
    bench.malfunctions.end(SHOULDER, "limp")
    assert bench.hw.drive(SHOULDER).max_effort == 175.0
    assert bench.begin("shoulder", "weak", 0.25).what == SHOULDER
    assert [each.value for each in bench.malfunctions.active] == [0.25]


def test_a_reset_ends_them(bench):
    bench.begin(SHOULDER, "limp")
    bench.begin("left_belt", "thrown")
    bench.begin("battery", "low")
    changes = bench.malfunctions.changes
    bench.simulation.reset()
    assert bench.malfunctions.active == ()
    assert bench.malfunctions.changes > changes
    assert bench.hw.drive(SHOULDER).max_effort == 350.0
    assert bench.drive(0.5, 0.0, 1.0)[0] > 0.3


def test_a_bookmark_has_those_that_there_were(bench):
    bookmarks = Bookmarks(bench.simulation)
    bookmarks.save("sound")
    bench.begin(SHOULDER, "stuck")
    bench.begin("battery", "low", 0.5)
    bench.run(0.1)
    bookmarks.save("broken")
    since, share = bench.malfunctions.active[0].since, bench.malfunctions.charge().share
    bench.run(1.0)
    bookmarks.restore("sound")
    assert bench.malfunctions.active == ()
    assert not bench.hw.drive(SHOULDER).stands
    bench.run(0.5)
    bookmarks.restore("broken")
    assert [each.kind for each in bench.malfunctions.active] == ["stuck", "low"]
    assert bench.malfunctions.active[0].since > since
    assert bench.malfunctions.charge().share == share
    assert bench.hw.drive(SHOULDER).stands


def reach_at(bench, place, power, time):
    """What is told of the range with the robot at a place (m), while it takes a power (W)."""
    bench.body.body.base_pose = lambda: ((*place, 0.0), (0.0, 0.0, 0.0, 1.0))
    bench.malfunctions._power = lambda: power
    try:
        return bench.malfunctions.reach(time)
    finally:
        del bench.body.body.base_pose, bench.malfunctions._power


def test_a_reset_and_a_bookmark_put_the_range_back(bench):
    shipped = reach_at(bench, (0.0, 0.0), 400.0, 0.0)
    told = [reach_at(bench, (float(second), 0.0), 400.0, second) for second in range(1, 60)]
    assert told[-1] > shipped
    bookmarks = Bookmarks(bench.simulation)
    bookmarks.save("driven")
    for second in range(60, 90):
        assert reach_at(bench, (1.0 * second, 0.0), 5000.0, second) < told[-1]
    bookmarks.restore("driven")
    # From where it was: that it was put there is no way.
    assert reach_at(bench, (59.0, 0.0), 5000.0, 90.0) == told[-1]
    bench.simulation.reset()
    assert reach_at(bench, (58.0, 0.0), 5000.0, 91.0) == shipped


def calls_of_a_step(bench):
    """Names of the functions that ten steps call, one for each call."""
    called = []

    def note(frame, event, _):
        if event == "call":
            called.append((frame.f_code.co_filename, frame.f_code.co_name))

    sys.setprofile(note)
    try:
        bench.run(0.02)
    finally:
        sys.setprofile(None)
    return called


def test_nothing_is_computed_in_a_step_while_none_is_active(bench):
    bench.run(1.0)
    before = calls_of_a_step(bench)
    assert not [name for name, _ in before if "malfunctions" in name or "belt_faults" in name]
    bench.begin("battery", "low")
    assert [name for name, _ in calls_of_a_step(bench) if "malfunctions" in name]
    bench.begin(SHOULDER, "weak", 0.9)
    bench.begin("left_belt", "weak", 0.9)
    bench.malfunctions.end()
    bench.run(1.0)
    after = calls_of_a_step(bench)
    assert not [name for name, _ in after if "malfunctions" in name or "belt_faults" in name]
    assert abs(len(after) - len(before)) <= 0.05 * len(before)


def test_a_described_robot_can_fail_as_the_one_in_the_simulation(bench, urdf):
    bench.malfunctions.equip(*shipped_equipment())
    described = described_parts(urdf)
    assert {**vars(described), "joints": set(described.joints)} == {
        **vars(bench.malfunctions.parts),
        "joints": set(bench.malfunctions.parts.joints),
        "flippers": described.flippers,
    }
    assert set(described.flippers) == set(bench.malfunctions.parts.flippers)
    bench.malfunctions.equip({}, {})


def test_a_variant_without_gripper_cannot_lose_its_force():
    parts = described_parts(robot_description("carrier"))
    assert not parts.gripper
    assert "gripper" not in parts.cameras
    with pytest.raises(ConfigError, match="gripper can be: dead"):
        parts.find("gripper", "lost")
