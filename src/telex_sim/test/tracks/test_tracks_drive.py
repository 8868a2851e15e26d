"""The drive of belts: limits, balance of forces, and stability against stiff traction."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from telex_control.common.params import ConfigError
from telex_sim.tracks.belt_drive import BeltDrive, BeltDriveConfig
from telex_sim.tracks.law import Patch, TractionLaw

pytestmark = pytest.mark.slow

CONFIG = BeltDriveConfig(
    force=540.0, power=250.0, acceleration=5.0, inertia=15.0, brake_force=900.0
)
FRICTION, DAMPING = 18.0, 8.0


def drive_at(speed=0.0, config=CONFIG, step=0.002):
    drive = BeltDrive(config, FRICTION, DAMPING, step)
    drive.speed = speed
    return drive


def no_load(speed):
    return 0.0


def test_it_accelerates_as_its_controller_allows_and_no_faster():
    drive = drive_at()
    speeds = []
    for _ in range(150):
        drive.follow(1.0, no_load)
        speeds.append(drive.speed)
    assert speeds[49] == pytest.approx(50 * 0.002 * 5.0)
    assert speeds[-1] == 1.0
    assert drive.force == pytest.approx(FRICTION + DAMPING)


def test_a_blocked_belt_stalls_with_all_the_force():
    drive = drive_at(0.5)
    for _ in range(300):
        drive.follow(1.0, lambda speed: 1.0e6 * speed)
    assert abs(drive.speed) < 1e-3
    assert drive.force == CONFIG.force


def test_power_limits_the_speed_under_load():
    drive = drive_at()
    load = 300.0
    for _ in range(2000):
        drive.follow(1.2, lambda speed: load)
    assert drive.force * drive.speed == pytest.approx(CONFIG.power, rel=1e-3)
    # (load + friction + damping * v) * v = power
    expected = (math.sqrt(318.0**2 + 4.0 * DAMPING * 250.0) - 318.0) / (2.0 * DAMPING)
    assert drive.speed == pytest.approx(expected, rel=1e-3)


def test_braking_downhill_is_limited_by_force_not_by_power():
    drive = drive_at(1.2)
    for _ in range(200):
        drive.follow(1.2, lambda speed: -400.0)
    assert drive.speed == pytest.approx(1.2)
    assert drive.force * drive.speed < -CONFIG.power


def test_a_load_beyond_the_motor_drives_the_belt_back():
    drive = drive_at()
    for _ in range(100):
        drive.follow(0.3, lambda speed: 700.0)
    assert drive.speed < -0.1


@pytest.mark.parametrize("load", [10.0, -17.0])
def test_dry_friction_bears_what_it_can_at_rest(load):
    drive = drive_at()
    drive.follow(0.0, lambda speed: load)
    assert (drive.speed, drive.force) == (0.0, 0.0)


@pytest.mark.parametrize("load", [890.0, -890.0])
def test_the_brake_holds(load):
    drive = drive_at()
    for _ in range(100):
        drive.brake(lambda speed: load)
    assert drive.speed == 0.0


def test_the_brake_stops_the_belt_with_its_force():
    drive = drive_at(1.2)
    drive.brake(no_load)
    assert drive.speed < 1.2 - 900.0 / 15.0 * 0.002
    for _ in range(20):
        drive.brake(no_load)
    assert drive.speed == 0.0


def test_effort_accelerates_against_inertia_and_friction():
    drive = drive_at()
    for _ in range(10):
        drive.push(168.0, no_load)
    assert drive.speed == pytest.approx(10 * 0.002 * 150.0 / 15.0, rel=0.02)
    drive.push(0.0, lambda speed: 0.0)
    assert drive.force == 0.0


def test_effort_below_friction_does_not_move():
    drive = drive_at()
    for _ in range(10):
        drive.push(15.0, no_load)
    assert drive.speed == 0.0


def bristles(load, grip, slip, step):
    patch = Patch()
    law = TractionLaw(1.0e5, 1500.0, step)
    patch.touches = [(load, grip, 0.7 * grip, slip, 0.0, (1, 0, 0), (0, 1, 0), (0, 0, 0))]
    patch.prepare(law, load, (1.0, 1.0), 0.49)
    return patch


@given(
    st.floats(-2.0, 2.0),
    st.floats(-2.0, 2.0),
    st.floats(-2.0, 2.0),
    st.floats(1.0, 1000.0),
    st.floats(0.1, 1.5),
    st.floats(0.05, 50.0),
    st.sampled_from([0.004, 0.002, 0.001]),
    st.sampled_from(["follow", "push", "brake"]),
)
def test_forces_balance_within_the_limits(speed, command, slip, load, grip, inertia, step, way):
    config = BeltDriveConfig(inertia=inertia)
    drive = BeltDrive(config, FRICTION, DAMPING, step)
    drive.speed = speed
    patch = bristles(load, grip, slip, step)
    calls = []

    def traction(at):
        calls.append(at)
        return patch.pull(at)

    if way == "follow":
        drive.follow(command, traction)
    elif way == "push":
        drive.push(300.0 * command, traction)
    else:
        drive.brake(traction)
    assert calls[-1] == drive.speed
    rest = drive.force - inertia * (drive.speed - speed) / step - patch.pull(drive.speed)
    rest -= DAMPING * drive.speed
    if drive.speed == 0.0:
        assert abs(rest) <= FRICTION + 0.2
    else:
        assert rest == pytest.approx(math.copysign(FRICTION, drive.speed), abs=0.2)
    if way == "brake":
        assert abs(drive.force) <= config.brake_force
        assert abs(drive.speed) <= abs(speed) + abs(patch.pull(0.0)) * step / inertia
    else:
        assert abs(drive.force) <= config.force + 1e-9
        assert drive.force * drive.speed <= config.power * (1.0 + 1e-9) + 1e-9


@given(st.floats(-2.0, 2.0), st.floats(-2.0, 2.0), st.floats(-2.0, 2.0), st.floats(1.0, 1000.0))
def test_forward_and_backward_are_alike(speed, command, slip, load):
    one, other = drive_at(speed), drive_at(-speed)
    one.follow(command, bristles(load, 0.8, slip, 0.002).pull)
    other.follow(-command, bristles(load, 0.8, -slip, 0.002).pull)
    assert other.speed == pytest.approx(-one.speed, abs=1e-12)
    assert other.force == pytest.approx(-one.force, abs=1e-9)


@pytest.mark.parametrize("step", [0.004, 0.002, 0.001])
@pytest.mark.parametrize("inertia", [0.05, 1.0, 15.0])
def test_belt_and_robot_settle_together(step, inertia):
    """A body on one track, its motor at the force limit and then at rest: nothing shakes."""
    config = BeltDriveConfig(inertia=inertia, force=100.0)
    drive = BeltDrive(config, 2.0, 0.0, step)
    mass, velocity = 40.0, 0.0
    patch = Patch()
    law = TractionLaw(1.0e5, 1500.0, step)
    tail = []
    for count in range(round(2.0 / step)):
        patch.touches = [(400.0, 0.8, 0.56, velocity, 0.0, (1, 0, 0), (0, 1, 0), (0, 0, 0))]
        patch.prepare(law, 400.0, (1.0, 1.0), 0.49)
        drive.follow(1.0 if count * step < 0.3 else 0.0, patch.pull)
        patch.commit()
        velocity += patch.forces[0][0] / mass * step
        if count * step > 1.5:
            tail.append((velocity, drive.speed))
    assert max(abs(value) for pair in tail for value in pair) < 1e-7


@pytest.mark.parametrize(
    "figures", [{"force": 0.0}, {"power": -1.0}, {"inertia": 0.0}, {"brake_force": math.nan}]
)
def test_impossible_figures_are_refused(figures):
    with pytest.raises(ConfigError, match=next(iter(figures))):
        BeltDriveConfig(**figures)
