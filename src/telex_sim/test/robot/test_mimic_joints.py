"""Joints that nothing drives: that follow others (``<mimic>``), or move freely."""

from __future__ import annotations

import pybullet
import pytest
from drive_on_bench import STEP, DriveOnBench

from telex_control.common.params import ConfigError, read_config
from telex_control.hardware.hardware_interface import JointStateInterface
from telex_control.urdf.joints import UrdfError, joints, parse_urdf
from telex_sim.engine.simulator_config import RobotConfig
from telex_sim.robot.body import RobotBody
from telex_sim.scene.model import Start

LINK = """<link name="{0}"><inertial><origin xyz="0.05 0 0"/><mass value="0.1"/>
  <inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial></link>"""
JOINT = """<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>
  <origin xyz="0.1 {y} 0"/><axis xyz="{axis}"/>
  <limit lower="{lower}" upper="{upper}" velocity="{velocity}" effort="5"/>{rest}</joint>"""
TRANSMISSION = """<transmission name="t_{0}">
  <type>transmission_interface/SimpleTransmission</type>
  <joint name="{0}"><hardwareInterface>hardware_interface/{1}JointInterface</hardwareInterface>
  </joint><actuator name="motor_{0}"><mechanicalReduction>1</mechanicalReduction></actuator>
</transmission>"""


def joint(
    name, parent="base", mimic="", y=0.0, limits=(-1.0, 1.0), velocity=3.0, axis="0 0 1", **values
):
    rest = f"<mimic {mimic}/>" if mimic else ""
    lower, upper = limits
    return JOINT.format(
        name=name,
        kind=values.get("kind", "revolute"),
        parent=parent,
        child=name + "_link",
        y=y,
        axis=axis,
        lower=lower,
        upper=upper,
        velocity=velocity,
        rest=rest,
    )


def robot(*elements, interface="Position", driven=("drive",)):
    names = [each.split('"')[1] + "_link" for each in elements]
    links = "".join(LINK.format(name) for name in ("base", *names))
    drives = "".join(TRANSMISSION.format(name, interface) for name in driven)
    return f'<robot name="gripper">{links}{"".join(elements)}{drives}</robot>'


# A finger with a tip that stays upright, and one on the other side: sliding, with an offset.
GRIPPER = (
    joint("drive", limits=(0.0, 0.8)),
    joint("tip", "drive_link", 'joint="drive" multiplier="-1"', limits=(0.0, 0.88)),
    joint(
        "other",
        mimic='joint="drive" multiplier="0.05" offset="0.01"',
        y=-0.2,
        axis="1 0 0",
        kind="prismatic",
    ),
    joint("far", "other_link", 'joint="other" multiplier="2"', limits=(-2.0, 2.0)),
)


def expected(leader):
    return {"tip": -leader, "other": 0.05 * leader + 0.01, "far": 0.1 * leader + 0.02}


class Bench(DriveOnBench):
    def place(self):
        config = read_config(RobotConfig, {"fixed_base": True, **self.start}, "test")
        figure = RobotBody.of(self.urdf, config, "/gripper")
        positions = figure.start_positions("")
        self.body = figure.load(self.world, Start(0.0, 0.0, 1.0), positions, str)
        self.hw.attach(self.body)

    def states(self):
        self.hw.read(0.0, STEP)
        interface = self.hw.get(JointStateInterface)
        return {name: interface.get_handle(name) for name in interface.names()}


@pytest.fixture
def bench(closing):
    def make(urdf, interface="Position", **start):
        kind = type("Placed", (Bench,), {"start": {"start": start} if start else {}})
        return closing(kind)(urdf, interface)

    return make


@pytest.mark.parametrize("interface", ["Position", "Velocity", "Effort"])
def test_followers_follow_whatever_drives_the_leader(bench, interface):
    tested = bench(robot(*GRIPPER, interface=interface), interface)
    tested.run({"Position": 0.5, "Velocity": 0.5, "Effort": 0.02}[interface], 0.8)
    states = tested.states()
    assert states["drive"].position > 0.3
    for name, position in expected(states["drive"].position).items():
        assert states[name].position == pytest.approx(position, abs=2e-3), name
    if interface == "Velocity":
        for name, slope in (("tip", -0.5), ("other", 0.025), ("far", 0.05)):
            assert states[name].velocity == pytest.approx(slope, rel=0.02), name


@pytest.mark.parametrize("offset", [0.0, 0.5, 2.0])
def test_one_that_does_not_move_with_its_leader_stands_at_its_offset(bench, offset):
    mimic = f'joint="drive" multiplier="0" offset="{offset}"'
    tested = bench(robot(joint("drive"), joint("still", mimic=mimic, y=0.3)))
    tested.run(0.6, 0.8)
    states = tested.states()
    assert states["drive"].position == pytest.approx(0.6, abs=1e-3)
    assert states["still"].position == pytest.approx(offset, abs=1e-3)


def test_followers_start_where_their_leader_puts_them(bench):
    start = {"pose": "half", "poses": {"half": {"drive": 0.4}}}
    states = bench(robot(*GRIPPER), **start).states()
    for name, position in expected(0.4).items():
        assert states[name].position == pytest.approx(position, abs=1e-9), name
    with pytest.raises(ConfigError, match="follows 'drive'; give that one alone"):
        bench(robot(*GRIPPER), pose="half", poses={"half": {"tip": 0.4}})


def test_a_follower_that_is_held_holds_its_leader(bench):
    tested = bench(robot(*GRIPPER))
    tested.run(0.2, 0.3)
    held = tested.body.joints["other"]
    pybullet.setJointMotorControl2(
        tested.body.uid,
        held,
        pybullet.VELOCITY_CONTROL,
        targetVelocity=0.0,
        force=1e4,
        physicsClientId=tested.world.client,
    )
    tested.run(0.7, 0.5)
    states = tested.states()
    assert states["drive"].position == pytest.approx(0.2, abs=0.02)
    assert abs(states["tip"].position + states["drive"].position) < 0.01


def test_a_joint_of_which_only_the_state_is_asked_moves_freely(bench, caplog):
    watched = TRANSMISSION.format("free", "JointState").replace("JointStateJoint", "JointState")
    text = robot(joint("drive"), joint("free", y=0.3, axis="0 1 0"), joint("unseen", y=0.6))
    tested = bench(text.replace("</robot>", watched + "</robot>"))
    assert "nothing drives 'free': the transmissions have the JointStateInterface" in caplog.text
    tested.run(0.5, 0.1)
    states = tested.states()
    assert list(states) == ["drive", "free"]
    # It falls: 9.81 m/s2 on 0.1 kg at 0.05 m, against 1e-4 kg m2 and those of its offset.
    assert states["free"].velocity == pytest.approx(9.81 * 0.005 / 3.5e-4 * 0.1, rel=0.2)


@pytest.mark.parametrize(("interface", "warned"), [("Effort", True), ("Position", False)])
def test_an_effort_on_nothing_is_warned_of(bench, caplog, interface, warned):
    text = robot(joint("drive"), interface=interface)
    bench(text.replace(LINK.format("drive_link"), '<link name="drive_link"/>'), interface)
    said = "'drive' is driven by effort, and nothing that it moves has a mass"
    assert (said in caplog.text) == warned


def test_a_leader_without_mass_moves_that_of_its_followers(bench, caplog):
    text = robot(joint("drive"), joint("tip", mimic='joint="drive"', y=0.3), interface="Effort")
    bench(text.replace(LINK.format("drive_link"), '<link name="drive_link"/>'), "Effort")
    assert "has a mass" not in caplog.text


def test_limits_of_followers_are_their_leaders():
    described = joints(
        parse_urdf(
            robot(
                joint("drive", limits=(-1.0, 1.0), velocity=3.0),
                joint("a", mimic='joint="drive" multiplier="2" offset="0.1"', velocity=4.0),
                joint("b", mimic='joint="drive" multiplier="-1"', limits=(-0.2, 2.0)),
            )
        )
    )
    drive = described["drive"]
    assert (drive.lower, drive.upper) == (pytest.approx(-0.55), pytest.approx(0.2))
    assert drive.velocity == 2.0
    # A range on the wrong side, as published grippers have it, does not count.
    tip = joints(parse_urdf(robot(*GRIPPER)))["tip"]
    assert not tip.mimic_limits
    assert (tip.lower, tip.upper) == (-0.8, 0.0)


def test_a_transmission_goes_before_mimic(bench):
    text = robot(
        joint("drive"), joint("own", mimic='joint="drive"', y=0.3), driven=("drive", "own")
    )
    tested = bench(text)
    tested.run(0.5, 0.8)
    assert tested.states()["own"].position == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize(
    ("mimic", "said"),
    [
        ('joint="nobody"', "joint 'a' mimics the joint 'nobody', which is not there"),
        ('joint="a"', "joint 'a' mimics itself"),
        ('joint="drive" multiplier="x"', "'a': <mimic multiplier=.x.>; a finite number is needed"),
    ],
)
def test_what_cannot_be_followed_is_refused(mimic, said):
    with pytest.raises(UrdfError, match=said):
        joints(parse_urdf(robot(joint("drive"), joint("a", mimic=mimic))))
