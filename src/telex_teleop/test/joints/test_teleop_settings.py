"""Settings: what is refused and what the refusal says; the files that come with the package."""

import math
from pathlib import Path

import pytest
import yaml

from telex_control.common.params import ConfigError, read_config
from telex_control.urdf.joints import UrdfError
from telex_teleop.arm.arm_settings import ArmTeleopSettings
from telex_teleop.flippers.flipper_settings import FlipperTeleopSettings
from telex_teleop.joints.joint_settings import GripperTeleopSettings, JointTeleopSettings
from telex_teleop.motion.limits import JointBounds, limits_from_urdf
from telex_teleop.motion.speed import SpeedScale
from telex_teleop.tracks.track_drive import TrackSettings

CONFIG = Path(__file__).parents[2] / "config"


def read(values):
    return read_config(JointTeleopSettings, {"joints": ["hinge"], **values}, "/node")


@pytest.mark.parametrize("value", ["fast", None, True, math.nan, math.inf, 0.0, 100.5])
def test_bad_number_is_refused_with_place_and_value(value):
    with pytest.raises(ConfigError) as refusal:
        read({"status_rate": value})
    for part in ("/node", "status_rate is", repr(value)):
        assert part in str(refusal.value)


def test_number_out_of_range_is_refused_with_remedy():
    with pytest.raises(ConfigError, match=r"/node: status_rate is 0.0; .* above 0 and at most 100"):
        read({"status_rate": 0})


def test_joints_are_required():
    with pytest.raises(ConfigError, match="/node/joints is missing"):
        read_config(JointTeleopSettings, {}, "/node")


@pytest.mark.parametrize(
    ("value", "says"),
    [
        ("a", "a list is needed"),
        ([], "distinct names"),
        (["a", "a"], "distinct names"),
        (["a", 1], "a string is needed"),
        ([""], "distinct names"),
        (None, "a list is needed"),
    ],
)
def test_bad_names_are_refused(value, says):
    with pytest.raises(ConfigError, match=says):
        read({"joints": value})


@pytest.mark.parametrize("value", [[1, 2], "x", None])
def test_no_mapping_is_refused(value):
    with pytest.raises(ConfigError, match="a struct is needed"):
        read_config(JointTeleopSettings, value, "f")


def test_nested_source_is_named():
    with pytest.raises(ConfigError, match="/node/revolute/max_lead is 'y'"):
        read({"revolute": {"max_lead": "y"}})


@pytest.mark.parametrize(
    ("values", "says"),
    [
        ({"min_speed_scale": 0.0}, "min_speed_scale is 0.0; it must be above 0 and at most 1"),
        ({"max_speed_scale": 1.1}, "max_speed_scale is 1.1; it must be at least 0.05 and at most"),
        ({"max_speed_scale": 0.01}, "max_speed_scale is 0.01"),
        (
            {"initial_speed_scale": 0.6, "max_speed_scale": 0.5},
            "initial_speed_scale is 0.6; it must be at least 0.05 and at most 0.5",
        ),
    ],
)
def test_bad_speed_settings_are_refused(values, says):
    with pytest.raises(ConfigError, match=says):
        read(values)


def test_speed_begins_as_it_is_set_or_with_the_largest():
    assert read({"max_speed_scale": 0.5}).speed_scale().value == 0.5
    speed = read({"initial_speed_scale": 0.3, "min_speed_scale": 0.2}).speed_scale()
    assert (speed.minimum, speed.value, speed.maximum) == (0.2, 0.3, 1.0)


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_speed_scale_refuses_what_is_no_number(value):
    speed = SpeedScale()
    with pytest.raises(ValueError, match="speed_scale"):
        speed.set(value)
    assert speed.value == 1.0


def test_speed_scale_is_clamped():
    speed = SpeedScale(0.5, 0.05, 0.8)
    speed.set(7.0)
    assert speed.value == 0.8
    speed.set(-7.0)
    assert speed.value == 0.05


def test_speed_scale_bounds_are_checked():
    for bounds in ((1.0, 0.0, 1.0), (0.01, 0.05, 1.0), (1.0, 0.05, 1.5)):
        with pytest.raises(ValueError, match="speed scale"):
            SpeedScale(*bounds)


URDF = """<?xml version="1.0" encoding="utf-8"?>
<robot name="test">
  <link name="a"/><link name="b"/><link name="c"/><link name="d"/><link name="e"/><link name="f"/>
  <joint name="slide" type="prismatic"><parent link="a"/><child link="b"/>
    <limit lower="0" upper="0.3" effort="1" velocity="0.05"/></joint>
  <joint name="hinge" type="revolute"><parent link="a"/><child link="c"/>
    <limit lower="-1" upper="2" effort="1" velocity="0.5"/>
    <safety_controller k_velocity="1" soft_lower_limit="-0.9" soft_upper_limit="1.9"/></joint>
  <joint name="wheel" type="continuous"><parent link="a"/><child link="d"/>
    <limit effort="1" velocity="3"/></joint>
  <joint name="glue" type="fixed"><parent link="a"/><child link="e"/></joint>
  <joint name="still" type="revolute"><parent link="a"/><child link="f"/>
    <limit lower="-1" upper="2" effort="1" velocity="0"/></joint>
</robot>"""


def test_limits_come_from_the_urdf():
    assert limits_from_urdf(URDF, ["slide", "hinge", "wheel"]) == {
        "slide": JointBounds("prismatic", 0.0, 0.3, 0.05),
        "hinge": JointBounds("revolute", -0.9, 1.9, 0.5),
        "wheel": JointBounds("revolute", -math.inf, math.inf, 3.0),
    }


@pytest.mark.parametrize(
    ("text", "joint", "says"),
    [
        (URDF, "arm", "no revolute, continuous or prismatic joint arm"),
        (URDF, "glue", "no revolute, continuous or prismatic joint glue"),
        (URDF, "still", "'still' needs <limit velocity"),
        (URDF.replace('lower="0"', 'lower="0.4"'), "slide", "0.4 is above upper limit 0.3"),
        (URDF.replace('lower="0"', 'lower="0.3"'), "slide", "from 0.3 to 0.3.* below upper"),
        (URDF.replace('limit="-0.9"', 'limit="2.1"'), "hinge", "2.1 must be below"),
        (URDF.replace('="-0.9"', '="2.1"').replace('="1.9"', '="3"'), "hinge", "below upper"),
        (URDF.replace('velocity="0.05"', ""), "slide", "'slide' needs <limit velocity"),
        ("<robot", "slide", "no XML"),
        ("", "slide", "no XML"),
    ],
)
def test_useless_descriptions_are_refused(text, joint, says):
    with pytest.raises(UrdfError, match=says):
        limits_from_urdf(text, [joint])


HINGE = JointBounds("revolute", -1.0, 1.0, 0.6)


def test_rules_and_limits_make_the_motion():
    motion = (
        read({"revolute": {"limit_margin": 0.1, "acceleration_time": 0.2}})
        .axes({"hinge": HINGE})["hinge"]
        .motion
    )
    assert (motion.lower, motion.upper) == (-0.9, 0.9)
    assert motion.max_acceleration == pytest.approx(3.0)


def test_single_joints_may_be_slower():
    settings = read({"joint_settings": {"hinge": {"max_velocity": 0.2}}})
    assert settings.axes({"hinge": HINGE})["hinge"].motion.max_velocity == 0.2


@pytest.mark.parametrize(
    ("values", "says"),
    [
        (
            {"joint_settings": {"hinge": {"max_velocity": 0.7}}},
            "hinge/max_velocity is 0.7; it must be at most 0.6",
        ),
        ({"joint_settings": {"elbow": {}}}, "joint_settings/elbow is unknown; known are hinge"),
        ({"joint_settings": {"hinge": {"lead": 1.0}}}, "joint_settings/hinge/lead is unknown"),
        ({"revolute": {"max_lead": 0.01}}, "braking distance"),
        ({"revolute": {"max_velocity": 0.1}}, "revolute/max_velocity is unknown"),
        ({"command_timeout": 0.5}, "at most 0.3"),
        ({"prismatic": {"limit_margin": -0.1}}, "/prismatic: limit_margin is -0.1"),
        ({"joint_settings": {"hinge": {"max_lead": 0.0}}}, "hinge: max_lead is 0.0"),
        ({"joint_settings": {"hinge": {"max_velocity": 0}}}, "hinge: max_velocity is 0.0"),
        ({"comand_timeout": 0.2}, "/node/comand_timeout is unknown"),
    ],
)
def test_bad_motion_settings_are_refused(values, says):
    with pytest.raises(ConfigError, match=says):
        read(values).axes({"hinge": HINGE})


COUPLING = {"ratios": {"a": 1.0, "b": -2.0}, "measured_by": ["a"], "align_velocity": 0.1}


def read_gripper(changes):
    coupling = {**COUPLING, **changes}
    return read_config(GripperTeleopSettings, {"joints": ["a", "b"], "coupling": coupling}, "f")


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"ratios": {"a": 1.0}}, "coupling/ratios/b is missing"),
        ({"ratios": {"a": 1.0, "b": 0.0}}, "other than 0"),
        ({"ratios": {"a": 1.0, "b": math.nan}}, "coupling/ratios/b is nan"),
        ({"ratios": {"a": 1.0, "b": 1.0, "c": 1.0}}, "ratios/c is unknown; known are a, b"),
        ({"measured_by": ["c"]}, "names out of joints"),
        ({"measured_by": []}, "distinct names"),
        ({"name": ""}, "name is ''"),
        ({"align_time": 0.0}, "align_time is 0.0; it must be above 0"),
        ({"speed": 1.0}, "coupling/speed is unknown"),
    ],
)
def test_bad_couplings_are_refused(changes, says):
    with pytest.raises(ConfigError, match=says):
        read_gripper(changes)


def test_coupling_is_required():
    with pytest.raises(ConfigError, match="f/coupling is missing"):
        read_config(GripperTeleopSettings, {"joints": ["a"]}, "f")


def coupled_axes(**limits):
    return read({"joints": list(limits)}).axes(
        {name: JointBounds("revolute", *bounds) for name, bounds in limits.items()}
    )


def test_group_gets_the_limits_that_all_its_joints_allow():
    coupling = read_gripper({}).coupling
    limits = coupling.limits(coupled_axes(a=(-0.102, 0.502, 1.0), b=(-1.202, 0.102, 1.0)))
    assert limits.lower == pytest.approx(-0.05)
    assert limits.upper == pytest.approx(0.5)
    assert limits.max_velocity == pytest.approx(0.45)


def test_group_without_common_values_is_refused():
    coupling = read_gripper({}).coupling
    with pytest.raises(ConfigError, match="suits the position limits"):
        coupling.limits(coupled_axes(a=(0.1, 0.5, 1.0), b=(0.1, 0.5, 1.0)))
    with pytest.raises(ConfigError, match="align_velocity"):
        coupling.limits(coupled_axes(a=(-0.5, 0.5, 0.1), b=(-0.5, 0.5, 1.0)))


def test_an_optional_joint_must_be_one_of_the_nodes_joints():
    with pytest.raises(ConfigError, match="optional_joints names 'hinj'; known are hinge"):
        read({"optional_joints": ["hinj"]})


def test_only_optional_joints_may_be_lacking():
    settings = read({"joints": ["a", "b", "c"], "optional_joints": ["b", "c"]})
    assert settings.lacking(["a", "b", "c", "d"]) == ()
    assert settings.lacking(["b"]) == ("c",)
    limits = JointBounds("revolute", -1.0, 1.0, 1.0)
    assert list(settings.axes({"a": limits, "b": limits})) == ["a", "b"]


def test_a_gripper_lacks_all_its_joints_or_none():
    settings = read_file(GripperTeleopSettings, "gripper")
    assert settings.lacking(settings.joints) == ()
    assert settings.lacking(["elbow_joint"]) == settings.joints
    with pytest.raises(ConfigError, match="no left_finger_base_joint; it must have all joints of"):
        settings.lacking(settings.joints[1:])


def read_file(kind, node):
    path = CONFIG / f"{node}_teleop.yaml"
    return read_config(kind, yaml.safe_load(path.read_text()), str(path))


@pytest.mark.parametrize(
    ("kind", "node"), [(ArmTeleopSettings, "arm"), (FlipperTeleopSettings, "flipper")]
)
def test_joint_files_of_the_package_are_complete(kind, node):
    assert read_file(kind, node).joints


def test_gripper_file_of_the_package_fits_a_parallel_gripper():
    settings = read_file(GripperTeleopSettings, "gripper")
    limits = {joint: JointBounds("revolute", -1.2, 1.2, 2.0) for joint in settings.joints}
    axes = settings.axes(limits)
    coupling = settings.coupling
    group = settings.axis(coupling.name, coupling.limits(axes)).motion
    assert group.max_velocity == 0.16
    assert group.upper == pytest.approx(0.6, abs=0.01)


def test_track_file_of_the_package_is_complete():
    settings = read_file(TrackSettings, "track")
    assert (settings.max_linear, settings.max_angular) == (1.2, 1.0)
