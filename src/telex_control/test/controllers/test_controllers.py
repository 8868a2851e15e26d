from __future__ import annotations

import math

import pytest
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

PID = {"p": 10.0, "i": 0.0, "d": 1.0}


def position_controller(joint, **pid):
    return {
        "type": "effort_controllers/JointPositionController",
        "joint": joint,
        "pid": {**PID, **pid},
    }


def test_a_started_position_controller_holds_what_it_finds(bench):
    tested = bench({"c": position_controller("elbow")})
    tested.hw.states["elbow"].position = 0.7
    (controller,) = tested.load_and_start("c")
    tested.cycle(3)
    assert controller.set_point == 0.7
    assert tested.hw.efforts["elbow"].command == pytest.approx(0.0)


def test_a_command_is_followed_and_clamped_to_the_joint(bench):
    tested = bench({"c": position_controller("elbow", d=0.0)})
    (controller,) = tested.load_and_start("c")
    command = tested.node.advertise("c/command", Float64)
    command.publish(Float64(0.5))
    tested.cycle()
    assert tested.hw.efforts["elbow"].command == pytest.approx(5.0)
    command.publish(Float64(99.0))
    assert controller.set_point == 2.0
    command.publish(Float64(-99.0))
    assert controller.set_point == -1.0


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_commands_that_are_no_number_are_dropped(bench, bad, caplog):
    tested = bench({"c": position_controller("elbow")})
    (controller,) = tested.load_and_start("c")
    tested.node.advertise("c/command", Float64).publish(Float64(bad))
    assert controller.set_point == 0.0
    assert "elbow" in caplog.text


def test_continuous_joints_take_the_short_way(bench):
    tested = bench({"c": position_controller("wheel", d=0.0)})
    tested.load_and_start("c")
    tested.hw.states["wheel"].position = 3.0
    tested.node.advertise("c/command", Float64).publish(Float64(-3.0))
    tested.cycle()
    assert tested.hw.efforts["wheel"].command == pytest.approx(10.0 * (2.0 * math.pi - 6.0))


def test_the_command_filter_takes_the_kick_out_of_a_stream(bench):
    plain = bench({"c": position_controller("elbow")})
    smooth = bench({"c": {**position_controller("elbow"), "command_filter_frequency": 100.0}})
    efforts = []
    for tested in (plain, smooth):
        tested.load_and_start("c")
        command = tested.node.advertise("c/command", Float64)
        seen = []
        for step in range(100):  # led at 0.2 rad/s by commands at 100 Hz, and following
            command.publish(Float64(0.002 * step))
            for _ in range(5):
                tested.hw.states["elbow"].velocity = 0.2
                tested.hw.states["elbow"].position += 0.2 * tested.period
                tested.cycle()
                seen.append(tested.hw.efforts["elbow"].command)
        efforts.append(max(seen[250:]) - min(seen[250:]))
    # d = 1: a step of 0.002 rad in one cycle of 0.002 s kicks by 1
    assert efforts[0] > 0.9
    assert efforts[1] < 0.1


def test_a_continuous_joint_takes_the_short_way_with_the_command_filter_too(bench):
    # With this gain alone, the effort is the way from the joint to the filtered reference.
    params = {**position_controller("wheel", p=1.0, d=0.0), "command_filter_frequency": 100.0}
    tested = bench({"c": params})
    tested.hw.states["wheel"].position = 3.1
    tested.load_and_start("c")
    tested.node.advertise("c/command", Float64).publish(Float64(-3.1))
    for _ in range(100):
        tested.cycle()
        reference = 3.1 + tested.hw.efforts["wheel"].command
        assert abs(math.remainder(reference - math.pi, 2 * math.pi)) < 0.05
    assert math.remainder(reference + 3.1, 2 * math.pi) == pytest.approx(0.0, abs=1e-6)


def test_a_stopped_position_controller_leaves_no_effort(bench):
    tested = bench({"c": position_controller("elbow")})
    tested.load_and_start("c")
    tested.node.advertise("c/command", Float64).publish(Float64(1.0))
    tested.cycle()
    assert tested.hw.efforts["elbow"].command != 0.0
    assert tested.switch(stop=["c"])
    assert tested.hw.efforts["elbow"].command == 0.0


def test_a_stopped_position_controller_obeys_no_command(bench):
    tested = bench({"c": position_controller("elbow")})
    (controller,) = tested.load_and_start("c")
    assert tested.switch(stop=["c"])
    tested.node.advertise("c/command", Float64).publish(Float64(1.0))
    tested.cycle(3)
    assert tested.hw.efforts["elbow"].command == 0.0
    assert tested.switch(start=["c"])
    assert controller.set_point == 0.0


def test_a_restart_forgets_commands(bench):
    tested = bench({"c": position_controller("elbow")})
    (controller,) = tested.load_and_start("c")
    tested.node.advertise("c/command", Float64).publish(Float64(1.0))
    tested.cycle(reset_controllers=True)
    assert controller.set_point == 0.0


def test_the_state_is_published_in_every_tenth_cycle(bench):
    tested = bench({"c": position_controller("elbow")})
    tested.load_and_start("c")
    received = []
    tested.node.subscribe("c/state", None, received.append)
    tested.node.advertise("c/command", Float64).publish(Float64(0.25))
    tested.cycle(50)
    assert len(received) == 5
    assert received[-1].set_point == 0.25
    assert received[-1].p == 10.0
    assert received[-1].header.stamp.to_sec() == pytest.approx(tested.time, abs=0.03)


@pytest.mark.parametrize(
    ("change", "logged"),
    [
        ({"joint": "nose"}, "'nose'"),
        ({"joint": None}, "/c/joint is missing"),
        ({"pid": None}, "/c/pid is missing"),
        ({"pid": {"i": 1.0}}, "/c/pid/p is missing"),
        ({"joint": 3}, "/c/joint is 3"),
        ({"command_filter_frequency": -1.0}, "/c/command_filter_frequency is -1.0"),
    ],
)
def test_wrong_parameters_are_named(bench, caplog, change, logged):
    params = {**position_controller("elbow"), **change}
    tested = bench({"c": {key: value for key, value in params.items() if value is not None}})
    assert not tested.manager.load_controller("c")
    assert logged in caplog.text


def test_a_misspelt_parameter_is_named_in_a_warning(bench, caplog):
    tested = bench({"c": {**position_controller("elbow"), "comand_filter_frequency": 1.0}})
    assert tested.manager.load_controller("c")
    assert "comand_filter_frequency; known are command_filter_frequency" in caplog.text


def test_joint_states_are_published_at_their_rate_in_alphabetical_order(bench):
    tested = bench(
        {"j": {"type": "joint_state_controller/JointStateController", "publish_rate": 100.0}}
    )
    tested.hw.states["slide"].position = 0.1
    received = []
    tested.node.subscribe("joint_states", JointState, received.append)
    tested.load_and_start("j")
    received.clear()
    tested.cycle(500)
    assert len(received) in (100, 101)
    assert received[0].name == ["elbow", "slide", "wheel"]
    assert received[0].position == [0.0, 0.1, 0.0]
    stamps = [message.header.stamp.to_nsec() for message in received]
    assert {b - a for a, b in zip(stamps, stamps[1:])} == {10_000_000}


def test_joint_states_keep_their_mean_rate_when_it_does_not_divide_the_control_rate(bench):
    tested = bench(
        {"j": {"type": "joint_state_controller/JointStateController", "publish_rate": 60}}
    )
    received = []
    tested.node.subscribe("joint_states", JointState, received.append)
    tested.load_and_start("j")
    received.clear()
    tested.cycle(500)
    assert len(received) in (60, 61)


@pytest.mark.parametrize("rate", [None, -1.0, "fast"])
def test_joint_state_controller_needs_a_rate(bench, rate, caplog):
    params = {"type": "joint_state_controller/JointStateController"}
    if rate is not None:
        params["publish_rate"] = rate
    tested = bench({"j": params})
    assert not tested.manager.load_controller("j")
    assert "publish_rate" in caplog.text
