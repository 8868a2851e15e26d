from __future__ import annotations

import math

import pytest
from control_msgs.msg import JointControllerState, PidState
from std_msgs.msg import Float64, Float64MultiArray

from telex_control.common.params import ConfigError
from telex_control.hardware.hardware_interface import EffortJointInterface, VelocityJointInterface
from telex_control.hardware.joint_limits import JointLimits
from telex_control.hardware.joint_limits_interface import EffortJointSaturationHandle
from telex_control.laws.pid import PidGains
from telex_control.laws.pid_reconfigure import PARAMETERS, PidSet
from telex_control.ros.local_node_handle import LocalNodeHandle

PID = {"p": 10.0, "i": 0.0, "d": 0.0}


def command_of(tested, interface, joint="elbow"):
    return tested.hw.get(interface).get_handle(joint).command


# --- gains at run time -------------------------------------------------------------------------


def test_the_parameters_are_those_of_control_toolbox():
    described = {each.name: (each.default, each.minimum, each.maximum) for each in PARAMETERS}
    assert described == {
        "p": (10.0, -100000.0, 100000.0),
        "i": (0.1, -100000.0, 100000.0),
        "d": (1.0, -1000.0, 1000.0),
        "i_clamp_min": (-10.0, -100000.0, 0.0),
        "i_clamp_max": (10.0, 0.0, 100000.0),
        "antiwindup": (False, False, True),
    }


def test_gains_change_at_once_and_show_in_the_state(bench):
    tested = bench(
        {"c": {"type": "effort_controllers/JointPositionController", "joint": "elbow", "pid": PID}}
    )
    tested.load_and_start("c")
    states = []
    tested.node.subscribe("c/state", JointControllerState, states.append)
    tested.node.advertise("c/command", Float64).publish(Float64(0.5))
    tested.cycle()
    assert command_of(tested, EffortJointInterface) == pytest.approx(5.0)
    values = tested.node.reconfigure("c/pid", p=30.0, i_clamp_max=4.0, antiwindup=True)
    assert values == {
        "p": 30.0,
        "i": 0.0,
        "d": 0.0,
        "i_clamp_min": 0.0,
        "i_clamp_max": 4.0,
        "antiwindup": True,
    }
    tested.cycle()
    assert command_of(tested, EffortJointInterface) == pytest.approx(15.0)
    tested.cycle(20)
    assert (states[-1].p, states[-1].i_clamp, states[-1].antiwindup) == (30.0, 4.0, True)


def test_gains_beyond_their_range_are_bounded():
    node = LocalNodeHandle({"pid": {"p": 18000.0, "d": 988.0, "i_clamp": 96.0}})
    pid = PidSet(node).open("pid")
    node.reconfigure("pid", p=1e9, d=-1e9)
    assert pid.gains == PidGains(1e5, 0.0, -1e3, 96.0, -96.0)


def test_an_unloaded_controller_offers_no_gains(bench):
    tested = bench(
        {"c": {"type": "effort_controllers/JointPositionController", "joint": "elbow", "pid": PID}}
    )
    assert tested.manager.load_controller("c")
    assert tested.node.offers_reconfiguration() == ["/c/pid"]
    assert tested.manager.unload_controller("c")
    assert tested.node.offers_reconfiguration() == []


def test_wrong_gains_are_refused_by_name():
    with pytest.raises(ConfigError, match="/c/pid/p is missing"):
        PidSet(LocalNodeHandle({"c": {"pid": {"i": 1.0}}}, "/c")).open("pid")


def test_the_inside_of_a_loop_is_published_when_asked_for(bench):
    gains = {"p": 10.0, "i": 2.0, "d": 0.5, "i_clamp": 3.0, "publish_state": True}
    tested = bench(
        {
            "c": {
                "type": "effort_controllers/JointPositionController",
                "joint": "elbow",
                "pid": gains,
            }
        }
    )
    tested.load_and_start("c")
    received = []
    tested.node.subscribe("c/pid/state", PidState, received.append)
    tested.node.advertise("c/command", Float64).publish(Float64(0.5))
    tested.cycle(5)
    assert len(received) == 5  # every cycle
    last = received[-1]
    assert last.error == last.p_error == pytest.approx(0.5)
    assert last.i_error == pytest.approx(0.5 * 5 * 0.002)
    assert (last.p_term, last.i_term, last.d_term) == (10.0, 2.0, 0.5)
    assert (last.i_max, last.i_min) == (3.0, -3.0)
    assert last.output == pytest.approx(command_of(tested, EffortJointInterface))
    assert last.timestep.to_sec() == pytest.approx(0.002)


# --- controllers -------------------------------------------------------------------------------


def test_effort_follows_a_velocity(bench):
    tested = bench(
        {"c": {"type": "effort_controllers/JointVelocityController", "joint": "elbow", "pid": PID}}
    )
    tested.hw.states["elbow"].velocity = 0.5
    tested.load_and_start("c")
    states = []
    tested.node.subscribe("c/state", JointControllerState, states.append)
    tested.cycle()
    assert command_of(tested, EffortJointInterface) == pytest.approx(-5.0)  # to rest
    command = tested.node.advertise("c/command", Float64)
    command.publish(Float64(2.0))
    command.publish(Float64(math.nan))
    tested.cycle(10)
    assert command_of(tested, EffortJointInterface) == pytest.approx(15.0)
    assert states[-1].set_point == 2.0
    assert states[-1].process_value == 0.5
    assert states[-1].error == 1.5
    assert tested.switch(stop=["c"])
    assert command_of(tested, EffortJointInterface) == 0.0
    command.publish(Float64(3.0))
    assert tested.switch(start=["c"])
    tested.cycle()
    assert command_of(tested, EffortJointInterface) == pytest.approx(-5.0)


def test_a_velocity_follows_a_position(bench):
    tested = bench(
        {
            "c": {
                "type": "velocity_controllers/JointPositionController",
                "joint": "wheel",
                "pid": PID,
            }
        }
    )
    tested.hw.states["wheel"].position = 3.0
    tested.load_and_start("c")
    tested.cycle()
    assert command_of(tested, VelocityJointInterface, "wheel") == 0.0
    tested.node.advertise("c/command", Float64).publish(Float64(-3.0))
    tested.cycle()
    assert command_of(tested, VelocityJointInterface, "wheel") == pytest.approx(
        10.0 * (2.0 * math.pi - 6.0)
    )


def group(bench, **changes):
    tested = bench(
        {
            "c": {
                "type": "effort_controllers/JointGroupPositionController",
                "joints": ["wheel", "elbow"],
                "wheel": {"pid": {"p": 2.0}},
                "elbow": {"pid": PID},
                **changes,
            }
        }
    )
    tested.hw.states["elbow"].position = 0.5
    tested.hw.states["wheel"].position = 3.0
    return tested


def test_a_group_of_positions(bench):
    tested = group(bench)
    tested.load_and_start("c")
    tested.cycle()
    assert command_of(tested, EffortJointInterface) == 0.0  # holds what it found
    command = tested.node.advertise("c/command", Float64MultiArray)
    command.publish(Float64MultiArray(data=[-3.0, 99.0]))
    tested.cycle()
    # the wheel the short way round, the elbow only to its limit
    assert command_of(tested, EffortJointInterface, "wheel") == pytest.approx(
        2.0 * (2.0 * math.pi - 6.0)
    )
    assert command_of(tested, EffortJointInterface) == pytest.approx(10.0 * 1.5)
    tested.node.reconfigure("c/elbow/pid", p=1.0)
    tested.cycle()
    assert command_of(tested, EffortJointInterface) == pytest.approx(1.5)
    assert tested.switch(stop=["c"])
    assert command_of(tested, EffortJointInterface) == 0.0


@pytest.mark.parametrize("bad", [[1.0], [], [1.0, 2.0, 3.0], [math.nan, 0.0]])
def test_a_group_of_positions_refuses_wrong_commands(bench, bad, caplog):
    tested = group(bench)
    tested.load_and_start("c")
    tested.node.advertise("c/command", Float64MultiArray).publish(Float64MultiArray(data=bad))
    tested.cycle()
    assert command_of(tested, EffortJointInterface) == 0.0
    assert "/c/command" in caplog.text


@pytest.mark.parametrize(
    ("change", "logged"),
    [
        ({"joints": ["nose"]}, "'nose'"),
        ({"elbow": {}}, "/c/elbow/pid is missing"),
        ({"elbow": {"pid": {"d": 1.0}}}, "/c/elbow/pid/p is missing"),
        ({"gravity_compensation": "yes"}, "gravity_compensation is 'yes'"),
    ],
)
def test_wrong_parameters_of_a_group_are_named(bench, caplog, change, logged):
    assert not group(bench, **change).manager.load_controller("c")
    assert logged in caplog.text


def led(bench, limits):
    """Command a step of 1 rad to a joint that stays at 0; return the references of 2 s."""
    params = {
        "type": "effort_controllers/JointPositionController",
        "joint": "elbow",
        "pid": {"p": 1.0},
        "command_limits": limits,
    }
    tested = bench({"c": params})
    tested.load_and_start("c")
    tested.node.advertise("c/command", Float64).publish(Float64(1.0))
    references = []
    for _ in range(1000):
        tested.cycle()
        # By a gain of 1 the effort is the reference.
        references.append(tested.hw.efforts["elbow"].command)
    return references


def test_a_jump_is_led_within_the_limits(bench):
    references = led(bench, {"velocity": 0.8, "acceleration": 2.0})
    speeds = [(b - a) / 0.002 for a, b in zip([0.0, *references], references)]
    changes = [(b - a) / 0.002 for a, b in zip([0.0, *speeds], speeds)]
    assert max(speeds) == pytest.approx(0.8)
    assert max(map(abs, changes)) <= 2.0 * 1.01
    assert max(references) <= 1.0
    assert references[-1] == 1.0
    # a trapezoid takes way / v + v / a
    arrival = next(k for k, x in enumerate(references) if x > 1.0 - 1e-6) * 0.002
    assert arrival == pytest.approx(1.0 / 0.8 + 0.8 / 2.0, abs=0.02)


def test_command_limits_of_zero_are_refused(bench, caplog):
    with pytest.raises(AssertionError):
        led(bench, {"velocity": 0.0, "acceleration": 1.0})
    assert "command_limits" in caplog.text
    assert "velocity is 0.0" in caplog.text


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_integral_holds_while_limits_take_away_what_it_asks_for_more_of(bench, sign):
    gains = {"p": 10.0, "i": 20.0, "d": 0.0, "i_clamp": 100.0}
    tested = bench(
        {
            "c": {
                "type": "effort_controllers/JointPositionController",
                "joint": "elbow",
                "pid": {**gains, "publish_state": True},
            }
        }
    )
    tested.load_and_start("c")
    inside = []
    tested.node.subscribe("c/pid/state", PidState, inside.append)
    handle = tested.hw.get(EffortJointInterface).get_handle("elbow")
    limits = EffortJointSaturationHandle(handle, JointLimits(max_velocity=1.0, max_effort=4.0))

    def run(cycles):
        for _ in range(cycles):
            tested.cycle()
            limits.enforce(0.002)

    command = tested.node.advertise("c/command", Float64)
    command.publish(Float64(sign * 0.3))
    run(50)
    assert inside[-1].i_error == pytest.approx(sign * 0.3 * 50 * 0.002)
    run(2000)
    held = inside[-1].i_error
    assert 10.0 * sign * 0.3 + 20.0 * held == pytest.approx(sign * 4.0, abs=0.05)
    # towards less of what is cut off, it goes on at once
    command.publish(Float64(sign * -0.3))
    run(10)
    assert sign * inside[-1].i_error < sign * held
