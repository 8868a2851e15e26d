"""Robots on wheels: how these give way, who says so, and what comes of it."""

from __future__ import annotations

import math

import pybullet
import pytest
from geometry_msgs.msg import Twist

from telex_control.common.params import ConfigError, read_config
from telex_control.urdf.joints import UrdfError, parse_urdf
from telex_sim.engine.contacts import contacts
from telex_sim.engine.simulator_config import HardwareConfig
from telex_sim.offline.simulation import OfflineSimulation
from telex_sim.robot.link_surfaces import frictions, wheels

WHEELS = ("front_left", "front_right", "rear_left", "rear_right")
MASS = 50.0
LOAD = MASS * 9.81 / 4.0
INERTIA = '<inertia ixx="{0}" iyy="{0}" izz="{0}" ixy="0" ixz="0" iyz="0"/>'


def wheel(name, x, y, driven=True, shape='<cylinder radius="0.15" length="0.1"/>'):
    drive = f"""
  <transmission name="{name}_drive"><type>transmission_interface/SimpleTransmission</type>
    <joint name="{name}"><hardwareInterface>hardware_interface/VelocityJointInterface
    </hardwareInterface></joint>
    <actuator name="{name}_motor"><mechanicalReduction>1</mechanicalReduction></actuator>
  </transmission>"""
    return f"""
  <link name="{name}_link"><inertial><mass value="2.5"/>{INERTIA.format(0.03)}</inertial>
    <collision><origin rpy="1.5707963 0 0"/><geometry>{shape}</geometry></collision></link>
  <joint name="{name}" type="continuous"><parent link="base_link"/><child link="{name}_link"/>
    <origin xyz="{x} {y} 0"/><axis xyz="0 1 0"/></joint>{drive if driven else ""}"""


def rover(extra=""):
    parts = "".join(
        wheel(name, 0.26 if "front" in name else -0.26, 0.29 if "left" in name else -0.29)
        for name in WHEELS
    )
    return f"""<robot name="rover">
  <link name="base_link"><inertial><origin xyz="0 0 0.05"/><mass value="{MASS - 10.0}"/>
    {INERTIA.format(1.0)}</inertial></link>{parts}{extra}
</robot>"""


CONTROLLERS = {
    "controller_groups": {"actions": []},
    "base": {
        "type": "diff_drive_controller/DiffDriveController",
        "left_wheel": ["front_left", "rear_left"],
        "right_wheel": ["front_right", "rear_right"],
        "wheel_separation": 0.58,
        "wheel_separation_multiplier": 1.8,
        "wheel_radius": 0.15,
        "pose_covariance_diagonal": [0.001] * 6,
        "twist_covariance_diagonal": [0.001] * 6,
        "cmd_vel_timeout": 1.0,
    },
}


@pytest.fixture
def drive():
    made = []

    def make(urdf, **changes):
        plain = {
            "tracks": {},
            "hardware": {},
            "self_collision": {},
            "proximity": {},
            "gripper_contact": {},
            "start": {"height": 0.15},
        }
        offline = OfflineSimulation(urdf, CONTROLLERS, **{**plain, **changes})
        made.append(offline)
        return offline

    yield make
    for offline in made:
        offline.simulation.close()


def loads(offline):
    body = offline.simulation.body
    found = dict.fromkeys(WHEELS, 0.0)
    names = {index: name for name, index in body.links.items()}
    for contact in contacts(body):
        found[names[contact.link][: -len("_link")]] += contact.force
    return list(found.values())


@pytest.mark.parametrize("step", [0.004, 0.002, 0.001])
@pytest.mark.parametrize("rate", [0.8, -0.8])
def test_four_wheels_share_the_load_and_turn_in_place(drive, rate, step):
    rover_on_floor = drive(rover(), timing__step_size=step, timing__control_period=0.004)
    rover_on_floor.run(1.0)
    assert loads(rover_on_floor) == pytest.approx([LOAD] * 4, rel=0.05)
    command = rover_on_floor.node.advertise("base/cmd_vel", Twist)
    message = Twist()
    message.angular.z = rate
    body = rover_on_floor.simulation.body
    start, turned, last = body.base_pose()[0], 0.0, 0.0
    for _ in range(40):
        command.publish(message)
        rover_on_floor.run(0.1)
        heading = pybullet.getEulerFromQuaternion(body.base_pose()[1])[2]
        turned, last = turned + math.remainder(heading - last, math.tau), heading
        assert math.dist(body.base_pose()[0], start) < 0.05
    assert 0.4 < turned / (4.0 * rate) < 1.8


CASTER = wheel("caster", 0.0, 0.0, driven=False, shape='<sphere radius="0.1"/>')
OWN = CASTER.replace("<collision>", '<contact><stiffness value="1e5"/></contact><collision>')
BOX = wheel("bumper", 0.0, 0.0, driven=False, shape='<box size="0.1 0.1 0.1"/>')
SWIVEL = """<link name="fork"><collision><geometry><sphere radius="0.1"/></geometry></collision>
</link><joint name="swivel" type="continuous"><parent link="base_link"/><child link="fork"/></joint>
<joint name="roll" type="continuous"><parent link="fork"/><child link="lone"/></joint>
<link name="lone"><collision><geometry><mesh filename="wheel.obj"/></geometry></collision></link>"""

HUB = """<link name="hub"/><link name="cap"/>
<joint name="hub" type="fixed"><parent link="caster_link"/><child link="hub"/></joint>
<joint name="cap" type="fixed"><parent link="hub"/><child link="cap"/></joint>"""
FINGER = """<link name="finger"/><joint name="finger" type="prismatic"><parent link="cap"/>
<child link="finger"/><limit lower="0" upper="0.05" effort="9" velocity="1"/></joint>"""
FLANGE = wheel("flange", 0.5, 0.0).replace("VelocityJointInterface", "PositionJointInterface")
TIP = wheel("tip", 0.5, 0.0, driven=False).replace(
    '<axis xyz="0 1 0"/></joint>', '<axis xyz="0 1 0"/><mimic joint="front_left"/></joint>'
)


@pytest.mark.parametrize(
    ("extra", "more"),
    [
        (CASTER, {"caster_link"}),
        (OWN, set()),
        (BOX, set()),
        (SWIVEL, {"lone"}),
        (CASTER + HUB, {"caster_link"}),
        (CASTER + HUB + FINGER, set()),
        (FLANGE, set()),
        (TIP, set()),
    ],
    ids=[
        "caster",
        "with a stiffness of its own",
        "not round",
        "only what a swivel carries",
        "with a cap",
        "a wrist with a gripper",
        "held by position",
        "a fingertip that mimics another joint",
    ],
)
def test_wheels_are_round_links_that_turn_and_carry_nothing(extra, more):
    assert wheels(parse_urdf(rover(extra))) == {f"{name}_link" for name in WHEELS} | more


def dynamics(offline, link):
    body = offline.simulation.body
    return pybullet.getDynamicsInfo(body.uid, body.links[link], physicsClientId=body.client)


GAZEBO = """<gazebo reference="front_left_link"><mu1>0.3</mu1><mu2 value="0.1"/></gazebo>
<gazebo reference="rear_left_link"><mu1>0.9</mu1><kp>1e12</kp></gazebo><gazebo/>"""


def test_links_have_what_urdf_and_configuration_say(drive):
    hardware = {
        "contacts": {
            "rear_left_link": {"stiffness": 2.0e5, "damping": 4.0e3},
            "rear_right_link": {"friction": 0.7},
        }
    }
    made = drive(rover(GAZEBO), hardware=hardware)
    # Friction, and at the end damping and stiffness.
    found = {name: dynamics(made, f"{name}_link") for name in WHEELS}
    assert {name: values[1] for name, values in found.items()} == pytest.approx(
        {"front_left": 0.2, "front_right": 0.5, "rear_left": 0.9, "rear_right": 0.7}
    )
    assert {name: values[8:10] for name, values in found.items()} == {
        "front_left": (1.0e3, 3.0e4),
        "front_right": (1.0e3, 3.0e4),
        "rear_left": (4.0e3, 2.0e5),
        "rear_right": (1.0e3, 3.0e4),
    }


@pytest.mark.parametrize("text", ["slippery", "-0.1", "nan", "inf", ""])
def test_a_friction_that_is_none_is_refused(text):
    root = parse_urdf(rover(f'<gazebo reference="front_left_link"><mu1>{text}</mu1></gazebo>'))
    with pytest.raises(UrdfError, match="front_left_link.*<mu1> is"):
        frictions(root)


def test_a_stiffness_without_damping_is_refused():
    with pytest.raises(ConfigError, match="both or neither"):
        read_config(HardwareConfig, {"contacts": {"wheel": {"stiffness": 1.0e4}}}, "hardware")
