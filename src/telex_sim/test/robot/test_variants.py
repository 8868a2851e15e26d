"""Robots that lack joints run on the same files; a misspelt joint is still a mistake."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import pytest

from telex_control.common.params import ConfigError
from telex_control.urdf.joints import UrdfError
from telex_sim.offline.simulation import OfflineSimulation, shipped_config

FINGER = re.compile(r"(left|right)_(finger_(base|middle|tip)|pad)")


def without_telescope(urdf):
    robot = ElementTree.fromstring(urdf)
    for joint in robot.findall("joint"):
        if joint.get("name") == "telescope_joint":
            joint.set("type", "fixed")
    remove(robot, "transmission", lambda name: name == "telescope_transmission")
    return ElementTree.tostring(robot, encoding="unicode")


def without_fingers(urdf):
    robot = ElementTree.fromstring(urdf)
    for tag in ("transmission", "joint", "link"):
        remove(robot, tag, FINGER.match)
    return ElementTree.tostring(robot, encoding="unicode")


def remove(robot, tag, fits):
    for element in robot.findall(tag):
        if fits(element.get("name", "")):
            robot.remove(element)


@pytest.fixture
def variant(urdf):
    made = []

    def make(change, **changes):
        made.append(OfflineSimulation(change(urdf), **changes))
        return made[-1]

    yield make
    for each in made:
        each.simulation.close()


@pytest.mark.parametrize(
    ("change", "lacking"),
    [
        (without_telescope, {"telescope_joint"}),
        (
            without_fingers,
            {f"{s}_finger_{p}_joint" for s in ("left", "right") for p in ("base", "middle", "tip")},
        ),
    ],
)
def test_a_variant_holds_its_pose_and_is_reset(variant, robot, change, lacking):
    tested, standard = variant(change), robot()
    assert set(standard.positions()) - set(tested.positions()) == lacking
    wanted = tested.simulation.config.start.joint_positions()
    tested.run(0.5)
    for joint, position in tested.positions().items():
        if "track" not in joint:
            assert position == pytest.approx(wanted[joint], abs=3e-3), joint
    tested.simulation.reset()
    tested.run(0.1)


def test_poses_may_name_the_joints_of_other_variants_and_no_others(variant):
    poses = {"test": {"telescope_joint": 0.2, "shoulder_joint": -1.5, "elbow_joint": 1.0}}
    start = {"start__poses": poses, "start__pose": "test", "start__default_pose": ""}
    tested = variant(without_telescope, **start)
    assert tested.positions()["elbow_joint"] == pytest.approx(1.0)
    poses["test"]["telescop_joint"] = 0.2
    with pytest.raises(ConfigError, match="start/poses/test/telescop_joint: the robot has no"):
        variant(without_telescope, **start)


def test_drives_may_be_those_of_other_variants_and_no_others(variant):
    joints = {"left_finger_tip_joint": {"armature": 0.05}, "elbw_joint": {"armature": 0.3}}
    with pytest.raises(UrdfError, match="hardware/joints/elbw_joint: the robot has no driven"):
        variant(without_fingers, hardware__joints=joints)


def test_surfaces_may_be_those_of_other_variants_and_no_others(variant):
    surfaces = {"left_finger_tip_link": {"friction": 0.8}, "palm": {"friction": 0.8}}
    with pytest.raises(ConfigError, match="hardware/contacts/palm: the robot has no such link"):
        variant(without_fingers, hardware__contacts=surfaces)
    del surfaces["palm"]
    variant(without_fingers, hardware__contacts=surfaces).run(0.1)


def test_all_optional_joints_are_joints_of_the_standard_robot(robot):
    optional = shipped_config().hardware.optional_joints
    assert set(optional) <= set(robot().positions())
