"""The drives' dry and viscous friction is what the URDF says, by the equations of motion."""

from __future__ import annotations

import contextlib
import math

import pybullet
import pytest
from drive_on_bench import STEP, DriveOnBench
from std_msgs.msg import Float64

from telex_control.hardware.hardware_interface import ControllerInfo, EffortJointInterface
from telex_control.ros.local_node_handle import LocalNodeHandle
from telex_control.urdf.joints import joints, parse_urdf
from telex_sim.engine.simulator_config import HardwareConfig
from telex_sim.engine.world import World
from telex_sim.offline.simulation import OfflineSimulation
from telex_sim.robot.robot_hw_sim import RobotHWSim

pytestmark = pytest.mark.slow

INERTIA = 0.5  # kg m2; kg of the sliding joint
EFFORT = 10.0
LINKS = """
  <link name="base"><inertial><mass value="1e6"/>
    <inertia ixx="1e6" iyy="1e6" izz="1e6" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="rotor"><inertial><mass value="{inertia}"/>
    <inertia ixx="{inertia}" iyy="{inertia}" izz="{inertia}" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>"""
RIG = f"""
<robot name="rig">{LINKS}
  <joint name="drive" type="{{kind}}"><parent link="base"/><child link="rotor"/>
    <axis xyz="{{axis}}"/><limit lower="-100" upper="100" velocity="1000" effort="{{effort}}"/>
    <dynamics friction="{{friction}}" damping="{{damping}}"/></joint>
  <transmission name="drive"><type>transmission_interface/SimpleTransmission</type>
    <joint name="drive">
      <hardwareInterface>hardware_interface/{{interface}}JointInterface</hardwareInterface></joint>
    <actuator name="motor"><mechanicalReduction>1</mechanicalReduction></actuator></transmission>
</robot>
"""


class Rig(DriveOnBench):
    """On a base that is too heavy to move; it falls freely, so gravity is not felt."""

    position = (0.0, 0.0, 1000.0)
    fixed_base = False

    def __init__(self, friction, damping, kind="continuous", interface="Effort"):
        urdf = RIG.format(
            inertia=INERTIA,
            kind=kind,
            axis="1 0 0" if kind == "prismatic" else "0 0 1",
            effort=EFFORT,
            friction=friction,
            damping=damping,
            interface=interface,
        )
        super().__init__(urdf, interface)

    @property
    def velocity(self):
        return self.state.velocity

    def spin(self, velocity):
        pybullet.resetJointState(self.body.uid, 0, 0.0, velocity, physicsClientId=self.world.client)


@pytest.fixture
def rig(closing):
    return closing(Rig)


@pytest.mark.parametrize("kind", ["continuous", "revolute", "prismatic"])
@pytest.mark.parametrize("friction", [0.2, 5.0])
def test_a_drive_breaks_away_at_its_dry_friction(rig, kind, friction):
    tested = rig(friction, 0.0, kind)
    tested.run(0.98 * friction, 0.5)
    assert abs(tested.velocity) < 1e-9
    tested.run(1.02 * friction, 0.5)
    assert tested.velocity == pytest.approx(0.02 * friction * 0.5 / INERTIA, rel=1e-6)


@pytest.mark.parametrize("kind", ["continuous", "prismatic"])
def test_a_drive_accelerates_against_dry_and_viscous_friction(rig, kind):
    friction, damping, effort, seconds = 1.0, 2.0, 6.0, 0.4
    tested = rig(friction, damping, kind)
    tested.run(effort, seconds)
    final = (effort - friction) / damping
    assert tested.velocity == pytest.approx(
        final * (1.0 - math.exp(-damping * seconds / INERTIA)), rel=5e-3
    )
    tested.run(effort, 5.0)
    assert tested.velocity == pytest.approx(final, rel=1e-6)


def test_a_drive_runs_down_by_viscous_friction(rig):
    tested = rig(0.0, 0.5)
    tested.spin(3.0)
    tested.run(0.0, 1.0)
    assert tested.velocity == pytest.approx(3.0 * math.exp(-0.5 * 1.0 / INERTIA), rel=5e-3)


def test_a_drive_comes_to_rest_when_its_friction_has_eaten_its_motion(rig):
    friction, damping, start = 1.0, 0.5, 3.0
    tested = rig(friction, damping)
    tested.spin(start)
    rest = INERTIA / damping * math.log(1.0 + start * damping / friction)
    tested.run(0.0, rest - 0.02)
    assert tested.velocity == pytest.approx(0.02 * friction / INERTIA, rel=0.2)
    tested.run(0.0, 0.04)
    assert tested.velocity == 0.0


def test_damping_too_large_for_the_step_only_stops_the_drive(rig):
    # As a torque it would turn the drive back, ever faster: damping * step / inertia is 8.
    tested = rig(0.0, 8.0 * INERTIA / STEP)
    tested.spin(3.0)
    for _ in range(5):
        tested.run(0.0, STEP)
        assert 0.0 <= tested.velocity < 3.0
    assert tested.velocity == pytest.approx(0.0, abs=1e-9)


FREE = f"""
<robot name="free">{LINKS}
  <joint name="free" type="continuous"><parent link="base"/><child link="rotor"/>
    <axis xyz="0 0 1"/><dynamics friction="{{friction}}" damping="{{damping}}"/></joint>
</robot>
"""


@pytest.mark.parametrize("friction", [0.0, 0.2])
@pytest.mark.parametrize("damping", [0.5, 8.0 * INERTIA / STEP])
def test_a_joint_without_a_drive_runs_down_as_its_urdf_says(friction, damping):
    urdf = FREE.format(inertia=INERTIA, friction=friction, damping=damping)
    with contextlib.closing(World(STEP, 50)) as world:
        hw = RobotHWSim(parse_urdf(urdf), HardwareConfig())
        hw.init(LocalNodeHandle({}), LocalNodeHandle({}))
        body = world.load_robot(urdf, str, (0.0, 0.0, 1000.0), 0.0, {}, fixed_base=False)
        hw.attach(body)
        pybullet.resetJointState(body.uid, 0, 0.0, 3.0, physicsClientId=world.client)
        seconds = 0.5
        for _ in range(round(seconds / STEP)):
            hw.read(0.0, STEP)
            hw.write(0.0, STEP)
            world.step()
        velocity = pybullet.getJointState(body.uid, 0, physicsClientId=world.client)[1]
    rest = friction / damping  # the velocity that it would tend to beyond standstill
    wanted = (3.0 + rest) * math.exp(-damping * seconds / INERTIA) - rest
    assert velocity == pytest.approx(max(wanted, 0.0), rel=5e-3, abs=1e-9)


def test_a_belts_motor_works_against_the_friction_of_its_drive(rig):
    friction, damping = 1.0, 0.2
    tested = rig(friction, damping, interface="Velocity")
    tested.run(20.0, STEP)
    # from standstill, with the whole effort
    assert tested.velocity == pytest.approx(EFFORT * STEP / INERTIA, rel=1e-6)
    before = tested.velocity
    tested.run(20.0, STEP)
    gain = (EFFORT - friction - damping * before) * STEP / INERTIA
    assert tested.velocity - before == pytest.approx(gain, rel=1e-6)
    for speed in (5.0, -5.0):
        tested.run(speed, 3.0)
        assert tested.velocity == pytest.approx(speed)
        assert tested.handle.state.effort == pytest.approx(
            math.copysign(friction + damping * abs(speed), speed)
        )
    tested.run(0.0, 3.0)
    assert tested.handle.state.effort == pytest.approx(0.0, abs=1e-6)


def test_the_robots_turret_breaks_away_at_the_friction_of_its_urdf(urdf):
    friction = joints(parse_urdf(urdf))["turret_joint"].friction
    robot = OfflineSimulation(urdf)
    try:
        robot.run(1.0)
        hw = robot.simulation.hw
        turret = hw.get(EffortJointInterface).get_handle("turret_joint")
        loaded = robot.simulation.controllers.loaded
        controller = loaded["turret_position_controller"]
        controller.stop(robot.simulation.time)
        hw.do_switch(
            [ControllerInfo("test", "test", controller.info.claimed_resources)], [controller.info]
        )
        for share, moves in ((0.98, False), (-0.98, False), (1.02, True)):
            before = turret.state.position
            for _ in range(250):
                turret.command = share * friction
                robot.simulation.step()
            assert (abs(turret.state.position - before) > 1e-4) is moves, share
    finally:
        robot.simulation.close()


@pytest.mark.parametrize("joint", ["shoulder_joint", "elbow_joint", "wrist_pitch_joint"])
def test_friction_leaves_no_error_and_no_hunting(urdf, joint):
    robot = OfflineSimulation(urdf)
    try:
        robot.run(0.5)
        target = robot.positions()[joint]
        command = robot.node.advertise(f"{joint[:-6]}_position_controller/command", Float64)
        for _ in range(50):
            target += 0.002
            command.publish(Float64(target))
            robot.run(0.01)
        robot.run(2.0)
        assert abs(robot.positions()[joint] - target) < math.radians(0.05)
        robot.run(1.0)  # the integral takes up what friction has held back
        track = []
        for _ in range(150):
            robot.run(0.01)
            track.append(robot.positions()[joint])
        assert max(abs(position - target) for position in track) < math.radians(0.02)
        # The hull trembles by 1e-5 rad on its rubber, which lets friction creep; it does not hunt.
        assert max(track) - min(track) < math.radians(0.015)
    finally:
        robot.simulation.close()
