"""Core of the track node: limits, schedule, the stop at the end, e-stop and pauses."""

import math

import pytest

from telex_control.common.params import ConfigError, read_config
from telex_teleop.motion.joint_jog import InvalidCommand
from telex_teleop.motion.speed import SpeedScale
from telex_teleop.tracks.track_drive import TrackDrive, TrackSettings, Velocity, parse_twist

DT = 0.01
STOP = Velocity(0.0, 0.0)


class Base:
    def __init__(self):
        self.core = TrackDrive(TrackSettings(), SpeedScale())
        self.time = 10.0
        self.wall_offset = 0.0
        self.sent = []
        self.run(0.6)  # a new node is deaf for a while

    @property
    def wall(self):
        return self.time + self.wall_offset

    def step(self):
        self.time = round(self.time + DT, 6)
        velocity = self.core.update(self.time, self.wall)
        if velocity is not None:
            self.sent.append((self.time, velocity))

    def run(self, duration):
        for _ in range(round(duration / DT)):
            self.step()

    def hold(self, duration, linear, angular=0.0):
        for tick in range(round(duration / DT)):
            if tick % 2 == 0:
                self.core.receive(Velocity(linear, angular), self.wall)
            self.step()


@pytest.fixture
def base():
    return Base()


def test_drives_at_fifty_hertz(base):
    base.hold(1.0, 0.5, -0.25)
    assert len(base.sent) == 50
    assert {velocity for _, velocity in base.sent} == {Velocity(0.5, -0.25)}


def test_clamps_then_scales(base):
    base.core.speed.set(0.5)
    base.hold(0.1, 99.0, -99.0)
    assert base.sent[-1][1] == Velocity(0.6, -0.5)


def test_silence_ends_with_a_repeated_stop_then_nothing(base):
    base.hold(0.5, 0.5)
    last_command = base.time - 2 * DT
    base.run(2.0)
    stops = [time for time, velocity in base.sent if velocity == STOP]
    assert 0.25 <= stops[0] - last_command <= 0.27
    assert stops[-1] - stops[0] == pytest.approx(0.2, abs=0.021)


def test_zero_stops_with_the_next_joint_state(base):
    base.hold(0.5, 0.5)
    base.core.receive(STOP, base.wall)
    base.step()
    assert base.sent[-1] == (base.time, STOP)


def test_idle_node_and_stream_of_zeros_leave_the_controller_to_others(base):
    base.hold(1.0, 0.0)
    assert base.sent == []


def test_new_command_during_the_stop_is_obeyed(base):
    base.hold(0.5, 0.5)
    base.core.receive(STOP, base.wall)
    base.step()
    base.hold(0.1, -0.5)
    assert base.sent[-1][1] == Velocity(-0.5, 0.0)


def test_e_stop_stops_and_needs_a_new_press(base):
    base.hold(0.5, 0.5)
    base.core.set_e_stop(True)
    base.hold(0.5, 0.5)
    base.core.set_e_stop(False)
    base.sent.clear()
    base.hold(1.0, 0.5)
    assert base.sent == []
    assert "press it again" in base.core.state(base.wall).message
    base.run(0.3)
    base.hold(0.1, 0.5)
    assert base.sent[-1][1] == Velocity(0.5, 0.0)


def test_stale_command_drives_nothing_after_a_pause(base):
    base.hold(0.5, 0.5)
    base.wall_offset += 5.0
    base.run(1.0)
    assert base.sent[-1][1] == STOP
    assert base.core.state(base.wall).command == STOP


def test_a_stream_that_outlives_a_standstill_needs_a_new_press(base):
    base.hold(0.5, 0.5)
    base.wall_offset += 1.0  # the simulator hung; the operator has never let go
    base.sent.clear()
    base.hold(1.0, 0.5)
    assert {velocity for _, velocity in base.sent} == {STOP}
    assert base.sent[0][0] == pytest.approx(base.time - 0.99)
    base.run(0.3)
    base.hold(0.1, 0.5)
    assert base.sent[-1][1] == Velocity(0.5, 0.0)


def test_a_client_that_is_gone_stops_at_once_and_another_does_not(base):
    for _ in range(10):
        base.core.receive(Velocity(0.5, 0.0), base.wall, "/bridge")
        base.core.keep({"/bridge", "/joy_teleop"})
        base.step()
    base.core.keep({"/bridge"})
    base.step()
    assert base.sent[-1][1] == Velocity(0.5, 0.0)
    base.core.keep({"/joy_teleop"})
    base.step()
    assert base.sent[-1] == (base.time, STOP)
    base.core.receive(Velocity(0.5, 0.0), base.wall, "/bridge")  # it is back
    base.run(0.02)
    assert base.sent[-1][1] == Velocity(0.5, 0.0)


def test_reset_stops_and_needs_a_new_press(base):
    base.hold(0.5, 0.5)
    base.core.restart(base.time)
    base.sent.clear()
    base.hold(1.0, 0.5)
    assert base.sent[0][0] == pytest.approx(base.time - 0.99)
    assert {velocity for _, velocity in base.sent} == {STOP}
    base.run(0.3)
    base.hold(0.1, 0.5)
    assert base.sent[-1][1] == Velocity(0.5, 0.0)


def test_stream_from_before_the_start_needs_a_new_press(base):
    base.core = TrackDrive(base.core.settings, SpeedScale())
    base.hold(2.0, 0.5)
    assert base.sent == []
    base.run(0.3)
    base.hold(0.1, 0.5)
    assert base.sent[-1][1] == Velocity(0.5, 0.0)


@pytest.mark.parametrize("jump", [-5.0, 3.0])
def test_jump_of_the_sim_time_stops(base, jump):
    base.hold(0.5, 0.5)
    base.time += jump
    base.sent.clear()
    base.hold(1.0, 0.5)
    assert {velocity for _, velocity in base.sent} == {STOP}


def test_state(base):
    assert (
        TrackDrive(base.core.settings, SpeedScale())
        .state(0.0)
        .message.startswith("no joint_states")
    )
    base.hold(0.1, 0.5)
    state = base.core.state(base.wall)
    assert (state.commanders, state.command, state.message) == (("",), Velocity(0.5, 0.0), "")
    assert "paused" in base.core.state(base.wall + 1.0).message


def test_state_names_who_is_obeyed(base):
    base.hold(0.1, 0.5)
    base.core.receive(Velocity(0.2, 0.0), base.wall, "/pad")
    assert base.core.state(base.wall).commanders == ("/pad",)
    base.core.set_e_stop(True)
    assert base.core.state(base.wall).commanders == ()


def components(**values):
    names = [f"{part}.{axis}" for part in ("linear", "angular") for axis in "xyz"]
    return {name: values.get(name.replace(".", "_"), 0.0) for name in names}


def test_twist_is_read():
    assert parse_twist(components(linear_x=0.5, angular_z=-1.0)) == (Velocity(0.5, -1.0), ())


def test_useless_components_are_named():
    velocity, ignored = parse_twist(components(linear_x=0.5, linear_y=1.0, angular_x=2.0))
    assert velocity == Velocity(0.5, 0.0)
    assert ignored == ("linear.y", "angular.x")


@pytest.mark.parametrize("value", [math.nan, math.inf, 1e308, -1e39])
def test_twist_without_numbers_is_refused(value):
    with pytest.raises(InvalidCommand, match="linear.z is"):
        parse_twist(components(linear_z=value))


def test_unknown_track_settings_are_refused():
    with pytest.raises(ConfigError, match="f/max_speed is unknown"):
        read_config(TrackSettings, {"max_speed": 1.0}, "f")


@pytest.mark.parametrize(
    "settings",
    [
        {"max_linear": 0.0},
        {"max_angular": math.nan},
        {"publish_rate": 5.0},
        {"stop_time": -0.1},
        {"command_timeout": 0.31},
    ],
)
def test_bad_track_settings_are_refused(settings):
    (name,) = settings
    with pytest.raises(ConfigError, match=f"{name} is .*; it must be"):
        read_config(TrackSettings, settings, "f")


def test_a_drive_leaves_nothing_to_do_when_its_stop_has_been_repeated(base):
    assert base.core.idle
    base.hold(0.1, 0.5)
    base.run(0.3)
    assert not base.core.idle
    base.run(0.3)
    assert base.core.idle
