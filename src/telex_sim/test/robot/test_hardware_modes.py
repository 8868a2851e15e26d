"""Every mode of the simulated hardware does what the equations of motion say, within its limits."""

from __future__ import annotations

import math

import pybullet
import pytest
from drive_on_bench import STEP, DriveOnBench

from telex_control.common.params import ConfigError
from telex_control.urdf.joints import UrdfError
from telex_sim.engine.simulator_config import HardwareConfig, JointHardware

INERTIA = 0.5  # kg m2
EFFORT = 10.0
RIG = """
<robot name="rig">
  <link name="base"/>
  <link name="rotor"><inertial><mass value="1"/>
    <inertia ixx="{inertia}" iyy="{inertia}" izz="{inertia}" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
  <link name="loose"><inertial><mass value="1"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="drive" type="{kind}"><parent link="base"/><child link="rotor"/><axis xyz="0 0 1"/>
    <limit lower="-2" upper="2" velocity="{velocity}" effort="{effort}"/>{safety}</joint>
  <joint name="passive" type="continuous"><parent link="base"/><child link="loose"/>
    <axis xyz="0 0 1"/></joint>
  <transmission name="drive"><type>transmission_interface/SimpleTransmission</type>
    <joint name="drive">
      <hardwareInterface>hardware_interface/{interface}JointInterface</hardwareInterface></joint>
    <actuator name="motor"><mechanicalReduction>1</mechanicalReduction></actuator></transmission>
</robot>
"""
SAFETY = (
    '<safety_controller k_position="20" k_velocity="100" soft_lower_limit="-1.5" '
    'soft_upper_limit="1.5"/>'
)


class Rig(DriveOnBench):
    """With a vertical axis, on a base that is fixed to the world."""

    def __init__(
        self,
        interface,
        params=None,
        kind="revolute",
        velocity=1000.0,
        safety="",
        effort=EFFORT,
        hardware=None,
    ):
        urdf = RIG.format(
            inertia=INERTIA,
            kind=kind,
            velocity=velocity,
            effort=effort,
            interface=interface,
            safety=safety,
        )
        super().__init__(urdf, interface, params, hardware)


@pytest.fixture
def rig(closing):
    return closing(Rig)


def gains(**values):
    return {"pid_gains": {"drive": values}}


def test_effort_accelerates_and_is_clamped_to_its_limit(rig):
    tested = rig("Effort")
    tested.run(4.0, 0.2)
    assert tested.state.velocity == pytest.approx(4.0 * 0.2 / INERTIA, rel=1e-6)
    assert tested.state.effort == 4.0
    tested = rig("Effort")
    tested.run(1000.0, 0.2)
    assert tested.state.velocity == pytest.approx(EFFORT * 0.2 / INERTIA, rel=1e-6)
    assert tested.state.effort == EFFORT


def test_a_velocity_motor_is_as_strong_as_its_effort_limit(rig):
    tested = rig("Velocity", kind="continuous")
    tested.run(8.0, 0.2)
    assert tested.state.velocity == pytest.approx(EFFORT * 0.2 / INERTIA, rel=1e-6)
    tested.run(8.0, 0.5)
    assert tested.state.velocity == pytest.approx(8.0)


def test_positions_of_joints_without_end_grow_from_turn_to_turn(rig):
    tested = rig("Velocity", kind="continuous")
    tested.run(50.0, 3.0)
    assert tested.state.position > 3.0 * 2.0 * math.pi
    before = tested.state.position
    tested.run(50.0, 1.0)
    assert tested.state.position - before == pytest.approx(50.0, rel=1e-3)


def test_a_position_joint_moves_at_its_limit_and_catches_up(rig):
    tested = rig("Position", velocity=1.0)
    tested.run(1.0, 0.2)
    # effort/inertia takes it to its speed in 0.05 s, in which it falls 0.025 behind
    assert tested.state.position == pytest.approx(0.2 - 0.025 + 0.05 * 0.15, abs=4e-3)
    assert tested.state.velocity == pytest.approx(1.05, abs=1e-3)
    tested.run(1.5, 1.0)
    assert tested.state.position == pytest.approx(1.2, abs=3e-3)
    assert tested.state.velocity == pytest.approx(1.0, abs=1e-3)
    tested.run(1.5, 1.0)
    assert tested.state.position == pytest.approx(1.5, abs=1e-6)


def test_a_position_joint_is_moved_by_force_not_carried(rig):
    tested = rig("Position")
    tested.run(2.0, 0.2)
    assert tested.state.position == pytest.approx(0.5 * EFFORT / INERTIA * 0.2**2, rel=0.02)
    assert tested.state.effort == pytest.approx(EFFORT, rel=1e-6)


def test_a_position_pid_swings_as_a_damped_oscillator(rig):
    frequency, damping = 4.0, 0.5
    stiffness = INERTIA * frequency**2
    tested = rig("Position", gains(p=stiffness, d=2.0 * damping * frequency * INERTIA))
    swing = frequency * math.sqrt(1.0 - damping**2)
    for _ in range(20):
        before = tested.hw.joint_state("drive").position
        tested.run(1.0, 0.1)
        assert tested.state.position != before
    highest = 1.0 + math.exp(-math.pi * damping / math.sqrt(1.0 - damping**2))
    tested = rig("Position", gains(p=stiffness, d=2.0 * damping * frequency * INERTIA))
    track = []
    for _ in range(round(2.0 * math.pi / swing / STEP)):
        tested.run(1.0, STEP)
        track.append(tested.state.position)
    assert max(track) == pytest.approx(highest, abs=0.01)
    assert track.index(max(track)) * STEP == pytest.approx(math.pi / swing, rel=0.02)


def test_a_position_pid_turns_a_joint_without_end_the_short_way(rig):
    tested = rig("Position", gains(p=8.0, d=4.0), kind="continuous")
    tested.run(2.0 * math.pi - 0.5, 0.1)
    assert tested.state.velocity < 0.0


@pytest.mark.parametrize("place", ["pid_gains", "gazebo_ros_control"])
def test_a_velocity_pid_approaches_exponentially(rig, place):
    params = gains(p=5.0)
    if place == "gazebo_ros_control":
        params = {place: params}
    tested = rig("Velocity", params, kind="continuous")
    tested.run(1.0, 0.1)
    assert tested.state.velocity == pytest.approx(1.0 - math.exp(-5.0 * 0.1 / INERTIA), rel=0.01)


@pytest.mark.parametrize("interface", ["Velocity", "Position"])
def test_the_effort_of_a_pid_is_clamped(rig, interface):
    tested = rig(interface, gains(p=1e4))
    tested.run(1.0, 0.02)
    assert tested.state.effort == EFFORT
    assert tested.state.velocity == pytest.approx(EFFORT * 0.02 / INERTIA, rel=1e-6)


def test_gains_change_while_it_runs(rig):
    tested = rig("Velocity", gains(p=1.0), kind="continuous")
    tested.node.reconfigure("pid_gains/drive", p=2.0)
    tested.run(1.0, STEP)
    assert tested.state.effort == pytest.approx(2.0)


@pytest.mark.parametrize("interface", ["Effort", "Velocity", "Position"])
def test_missing_gains_are_nothing_to_complain_about(rig, interface, caplog):
    rig(interface)
    assert not [record for record in caplog.records if "gain" in record.message.lower()]


@pytest.mark.parametrize("interface", ["Effort", "Velocity", "Position"])
@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_a_command_that_is_not_finite_moves_nothing(rig, interface, value):
    tested = rig(interface)
    tested.run(value, 0.2)
    assert abs(tested.state.position) < 1e-9


@pytest.mark.parametrize(
    ("interface", "command"), [("Effort", 1000.0), ("Velocity", 3.0), ("Position", 1.9)]
)
def test_soft_limits_bring_a_joint_to_rest_without_chatter(rig, interface, command):
    # a position motor follows what the limits leave of its command, if it is strong enough
    effort = 4.0 * EFFORT if interface == "Position" else EFFORT
    tested = rig(interface, velocity=2.0, safety=SAFETY, effort=effort)
    fastest = 0.0
    for _ in range(100):
        tested.run(command, 0.02)
        fastest = max(fastest, tested.state.velocity)
        assert tested.state.position < 1.52
    # rated speed is reached, although the soft limits' handle alone would take effort away there
    assert fastest == pytest.approx(2.0, rel=0.08)
    tested.run(command, 1.0)
    assert tested.state.position == pytest.approx(1.5, abs=0.01)
    for _ in range(50):
        tested.run(command, STEP)
        assert abs(tested.state.velocity) < 1e-3


def test_parameters_prevail_over_the_limits_of_the_urdf(rig):
    limits = {"drive": {"has_velocity_limits": True, "max_velocity": 0.5}}
    tested = rig("Velocity", {"joint_limits": limits})
    tested.run(3.0, 0.5)
    assert tested.state.velocity == pytest.approx(0.5)
    limits["drive"].update(has_acceleration_limits=True, max_acceleration=2.0)
    tested = rig("Velocity", {"joint_limits": limits})
    tested.run(3.0, 0.1)
    assert tested.state.velocity == pytest.approx(0.2)


@pytest.mark.parametrize(
    ("params", "named"),
    [
        ({"joint_limits": {"drive": {"max_speed": 1.0}}}, "joint_limits/drive/max_speed"),
        ({"joint_limits": 3}, "joint_limits is 3"),
        (gains(i=1.0), "pid_gains/drive/p is missing"),
    ],
)
def test_wrong_parameters_are_named(rig, params, named):
    with pytest.raises(ConfigError, match=named):
        rig("Position", params)


@pytest.mark.parametrize(
    ("interface", "command", "quantity", "expected"),
    [
        ("Effort", 10.0 * EFFORT, "velocity", 10.0 * EFFORT / INERTIA * 0.1),
        ("Velocity", 9.0, "velocity", 9.0),
        ("Position", 1.0, "position", 1.0),
    ],
)
def test_a_joint_without_limits_obeys_and_refuses_only_what_is_no_number(
    rig, interface, command, quantity, expected
):
    flags = [f"has_{kind}_limits" for kind in ("position", "velocity", "effort", "soft")]
    tested = rig(interface, {"joint_limits": {"drive": dict.fromkeys(flags, False)}}, safety=SAFETY)
    tested.run(command, 0.1)
    assert getattr(tested.state, quantity) == pytest.approx(expected, rel=0.01)
    tested.run(math.nan, STEP)
    assert math.isfinite(tested.handle.command)


def test_a_limit_that_is_wrong_is_named(rig):
    with pytest.raises(UrdfError, match="'drive': max_effort is 0.0; it must be above 0"):
        rig("Effort", effort=0.0)


@pytest.mark.parametrize(
    ("interface", "command", "safety", "end"),
    [
        ("Effort", 5.0, "", 2.1),
        ("Effort", 5.0, SAFETY, 1.6),
        ("Velocity", 1.0, "", 2.1),
        ("Velocity", 1.0, SAFETY, 1.6),
        # commands stay within the limits
        ("Position", 3.0, "", 2.0),
    ],
)
def test_stops_and_soft_limits_lie_beyond_the_limits_by_the_overtravel(
    rig, interface, command, safety, end
):
    hardware = HardwareConfig(joints={"drive": JointHardware(overtravel=0.1)})
    tested = rig(interface, velocity=5.0, safety=safety, hardware=hardware)
    for _ in range(2):
        tested.run(command, 2.5)
        assert tested.state.position == pytest.approx(end, abs=0.005)
        tested.world.clear()
        tested.place()


@pytest.mark.parametrize("params", [{}, gains(p=50.0, d=5.0)])
def test_a_position_joint_stays_where_an_emergency_stop_has_left_it(rig, params):
    tested = rig("Position", params, velocity=1.0)
    tested.run(1.5, 0.5)
    tested.hw.set_e_stop(True)
    for _ in range(200):
        tested.hw.read(0.0, STEP)
        tested.hw.write(0.0, STEP)
        tested.world.step()
    tested.hw.read(0.0, STEP)
    held = tested.state.position
    tested.hw.set_e_stop(False)
    assert tested.handle.command == held
    tested.run(1.5, STEP)
    # limits begin anew where the joint is, not where the last command was
    assert tested.handle.command == pytest.approx(held + 1.0 * STEP)


def test_limits_begin_anew_with_the_world(rig):
    tested = rig("Position", velocity=1.0)
    tested.run(1.5, 1.0)
    tested.world.clear()
    tested.place()
    tested.run(1.5, STEP)
    assert tested.handle.command == pytest.approx(1.0 * STEP)


def test_joints_without_a_transmission_are_free(rig):
    tested = rig("Effort")
    index = tested.body.joints["passive"]
    pybullet.resetJointState(tested.body.uid, index, 0.0, 3.0, physicsClientId=tested.world.client)
    tested.run(0.0, 0.5)
    state = pybullet.getJointState(tested.body.uid, index, physicsClientId=tested.world.client)
    assert state[1] == pytest.approx(3.0)
