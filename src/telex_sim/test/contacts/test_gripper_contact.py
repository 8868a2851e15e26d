"""What is told of the gripper's contacts; tests/test_grasping.py has what is held."""

from __future__ import annotations

from types import SimpleNamespace

import pybullet
import pytest
from std_msgs.msg import Float64

from telex_control.common.params import ConfigError, read_config
from telex_control.controllers.parallel_gripper_controller import FingerGeometry
from telex_sim.robot.gripper.contact import GripperContacts
from telex_sim.robot.gripper.contact_config import GripperContactConfig

PADS = ["left_tip", "right_tip"]


def read(**params):
    return read_config(GripperContactConfig, params, "gripper_contact")


def contact(offline):
    return offline.simulation.gripper_contact(offline.simulation.robots[0])


def test_the_opening_is_that_of_the_fingers(robot):
    offline = robot(start__pose="floor_pick")
    geometry = offline.node.find_param("gripper_controller/geometry", {})
    offline.run(0.1)
    felt = contact(offline)
    angle = offline.positions()["left_finger_base_joint"]
    wanted = read_config(FingerGeometry, geometry, "geometry").opening(angle)
    assert felt.opening == pytest.approx(wanted, abs=1e-3)
    assert (felt.object, felt.force, felt.slip_speed, felt.slipping) == ("", 0.0, 0.0, False)
    for pad, side in zip(felt.pads, ("left", "right")):
        assert pad == (f"{side}_finger_tip_link", (), 0.0, 0.0, 0.0, 0.0)


def test_pads_that_rest_on_the_floor_hold_nothing(robot):
    offline = robot(start__pose="floor_pick")
    offline.run(0.1)
    shoulder = offline.simulation.hw.joint_state("shoulder_joint").position
    command = offline.node.advertise("shoulder_position_controller/command", Float64)
    command.publish(Float64(shoulder + 0.12))
    offline.run(1.0)
    felt = contact(offline)
    assert [pad.objects for pad in felt.pads] == [("floor",), ("floor",)]
    assert all(pad.normal_force > 1.0 for pad in felt.pads)
    assert (felt.object, felt.force, felt.slipping) == ("", 0.0, False)


@pytest.fixture
def sled():
    """A body of one link, "pad", that slides over two others: made before it and after it."""
    client = pybullet.connect(pybullet.DIRECT)
    pybullet.setGravity(0.0, 0.0, -9.81, physicsClientId=client)

    def make(mass, half_extents, position):
        shape = pybullet.createCollisionShape(
            pybullet.GEOM_BOX, halfExtents=half_extents, physicsClientId=client
        )
        uid = pybullet.createMultiBody(mass, shape, -1, position, physicsClientId=client)
        pybullet.changeDynamics(uid, -1, lateralFriction=1.0, physicsClientId=client)
        return uid

    make(0.0, (2.0, 0.5, 0.1), (0.0, -0.5, -0.1))
    sled = make(2.0, (0.3, 0.3, 0.05), (0.0, 0.0, 0.05))
    pybullet.changeDynamics(sled, -1, lateralFriction=0.4, physicsClientId=client)
    make(0.0, (2.0, 0.5, 0.1), (0.0, 0.5, -0.1))
    yield SimpleNamespace(client=client, uid=sled, links={"pad": -1, "none": 7})
    pybullet.disconnect(client)


def test_friction_adds_up_over_all_that_a_pad_rubs_on(sled):
    config = GripperContactConfig(pads=("pad", "none"))
    contacts = GripperContacts(sled, config)
    client = sled.client
    for _ in range(30):
        pybullet.stepSimulation(client)
    pybullet.resetBaseVelocity(sled.uid, (1.0, 0.0, 0.0), physicsClientId=client)
    for _ in range(5):
        pybullet.stepSimulation(client)
    pad, _ = contacts.measure("plate {}".format).pads
    assert pad.objects == ("plate 0", "plate 2")
    assert pad.normal_force == pytest.approx(2.0 * 9.81, rel=0.02)
    assert pad.friction_force == pytest.approx(0.4 * 2.0 * 9.81, rel=0.02)
    assert pad.friction_use == pytest.approx(1.0, rel=0.02)


def test_a_robot_without_pads_has_no_gripper():
    config = read(pads=PADS)
    assert config.present(["base_link", *PADS], ())
    assert not config.present(["base_link"], PADS)
    assert not read().present(["base_link"], ())


@pytest.mark.parametrize(
    ("params", "message"),
    [
        ({"pads": ["left_tip"]}, "pads names left_tip; two links are needed, or none"),
        ({"pads": ["tip", "tip"]}, "two links are needed"),
        ({"rate": -1.0}, "rate is -1"),
        ({"rate": float("nan")}, "rate"),
        ({"slip_speed": 0.0}, "slip_speed is 0"),
        ({"stick_speed": 0.1}, "stick_speed is 0.1"),
    ],
)
def test_wrong_parameters_are_refused(params, message):
    with pytest.raises(ConfigError, match=message):
        read(**params)


def test_a_pad_that_no_variant_may_lack_is_missed():
    with pytest.raises(ConfigError, match="pads: the robot has no link 'right_tip'"):
        read(pads=PADS).present(["left_tip"], ["left_tip"])
