"""Settings: what is refused and what the refusal says; the files that come with the package."""

import math
from pathlib import Path

import pytest
import yaml

from telex_teleop.limits import JointLimits, LimitsError, limits_from_urdf
from telex_teleop.motion_settings import CoupledSettings, JointTeleopSettings
from telex_teleop.settings import Section, SettingsError
from telex_teleop.speed import SpeedScale
from telex_teleop.track_drive import TrackSettings

CONFIG = Path(__file__).parents[1] / "config"


@pytest.mark.parametrize("value", ["fast", None, True, math.nan, math.inf, 0.5, 3.5])
def test_bad_number_is_refused_with_place_value_and_remedy(value):
    section = Section({"rate": value}, "file.yaml")
    with pytest.raises(SettingsError) as refusal:
        section.number("rate", minimum=1.0, maximum=3.0)
    for part in ("file.yaml/rate", repr(value), "at least 1 and at most 3"):
        assert part in str(refusal.value)


def test_missing_and_unknown_settings_are_refused():
    section = Section({"ratte": 1.0}, "file.yaml")
    with pytest.raises(SettingsError, match="rate: is missing"):
        section.number("rate")
    with pytest.raises(SettingsError, match="unknown setting ratte; known here: rate"):
        section.finish()


@pytest.mark.parametrize("value", ["a", [], ["a", "a"], ["a", 1], [""], None])
def test_bad_names_are_refused(value):
    with pytest.raises(SettingsError, match="distinct names"):
        Section({"joints": value}, "f").names("joints")


def test_no_mapping_is_refused():
    with pytest.raises(SettingsError, match="must be a mapping"):
        Section([1, 2], "f")
    assert Section(None, "f").names_given() == []


def test_nested_source_is_named():
    with pytest.raises(SettingsError, match="f/inner/x: is 'y'"):
        Section({"inner": {"x": "y"}}, "f").section("inner").number("x")


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
        "slide": JointLimits("prismatic", 0.0, 0.3, 0.05),
        "hinge": JointLimits("revolute", -0.9, 1.9, 0.5),
        "wheel": JointLimits("revolute", -math.inf, math.inf, 3.0),
    }


@pytest.mark.parametrize(
    ("text", "joint", "says"),
    [
        (URDF, "arm", "no joint arm"),
        (URDF, "glue", "fixed"),
        (URDF, "still", "velocity"),
        (URDF.replace('lower="0"', 'lower="0.4"'), "slide", "below upper"),
        (URDF.replace('velocity="0.05"', ""), "slide", "velocity"),
        ("<robot", "slide", "not a valid URDF"),
        ("", "slide", "not a valid URDF"),
    ],
)
def test_useless_descriptions_are_refused(text, joint, says):
    with pytest.raises(LimitsError, match=says):
        limits_from_urdf(text, [joint])


HINGE = JointLimits("revolute", -1.0, 1.0, 0.6)


def read(values):
    section = Section({"joints": ["hinge"], **values}, "/node")
    settings = JointTeleopSettings.from_settings(section)
    section.finish()
    return settings


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
            "max_velocity: is 0.7; must be at most",
        ),
        ({"joint_settings": {"elbow": {}}}, "unknown setting elbow"),
        ({"joint_settings": {"hinge": {"lead": 1.0}}}, "unknown setting lead"),
        ({"revolute": {"max_lead": 0.01}}, "braking distance"),
        ({"revolute": {"max_velocity": 0.1}}, "unknown setting max_velocity"),
        ({"command_timeout": 0.5}, "at most 0.3"),
        ({"comand_timeout": 0.2}, "unknown setting comand_timeout"),
    ],
)
def test_bad_motion_settings_are_refused(values, says):
    with pytest.raises(SettingsError, match=says):
        read(values).axes({"hinge": HINGE})


COUPLING = {"ratios": {"a": 1.0, "b": -2.0}, "measured_by": ["a"], "align_velocity": 0.1}


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"ratios": {"a": 1.0}}, "ratios/b: is missing"),
        ({"ratios": {"a": 1.0, "b": 0.0}}, "other than 0"),
        ({"ratios": {"a": 1.0, "b": 1.0, "c": 1.0}}, "unknown setting c"),
        ({"measured_by": ["c"]}, "names out of joints"),
    ],
)
def test_bad_couplings_are_refused(changes, says):
    with pytest.raises(SettingsError, match=says):
        CoupledSettings.from_settings(Section({**COUPLING, **changes}, "f"), ("a", "b"))


def coupled_axes(**limits):
    return JointTeleopSettings.from_settings(Section({"joints": list(limits)}, "f")).axes(
        {name: JointLimits("revolute", *bounds) for name, bounds in limits.items()}
    )


def test_group_gets_the_limits_that_all_its_joints_allow():
    coupled = CoupledSettings.from_settings(Section(COUPLING, "f"), ("a", "b"))
    limits = coupled.limits(coupled_axes(a=(-0.102, 0.502, 1.0), b=(-1.202, 0.102, 1.0)))
    assert limits.lower == pytest.approx(-0.05)
    assert limits.upper == pytest.approx(0.5)
    assert limits.max_velocity == pytest.approx(0.45)


def test_group_without_common_values_is_refused():
    coupled = CoupledSettings.from_settings(Section(COUPLING, "f"), ("a", "b"))
    with pytest.raises(SettingsError, match="suits the position limits"):
        coupled.limits(coupled_axes(a=(0.1, 0.5, 1.0), b=(0.1, 0.5, 1.0)))
    with pytest.raises(SettingsError, match="align_velocity"):
        coupled.limits(coupled_axes(a=(-0.5, 0.5, 0.1), b=(-0.5, 0.5, 1.0)))


@pytest.mark.parametrize("node", ["arm", "flipper"])
def test_joint_files_of_the_package_are_complete(node):
    section = Section(yaml.safe_load((CONFIG / f"{node}_teleop.yaml").read_text()), node)
    JointTeleopSettings.from_settings(section)
    SpeedScale.from_settings(section)
    section.finish()


def test_gripper_file_of_the_package_fits_a_parallel_gripper():
    section = Section(yaml.safe_load((CONFIG / "gripper_teleop.yaml").read_text()), "gripper")
    coupled = CoupledSettings.from_settings(section.section("coupling"), section.names("joints"))
    settings = JointTeleopSettings.from_settings(section, coupled.name)
    SpeedScale.from_settings(section)
    section.finish()
    limits = {joint: JointLimits("revolute", -1.2, 1.2, 2.0) for joint in settings.joints}
    axes = settings.axes(limits)
    group = settings.axis(coupled.name, coupled.limits(axes)).motion
    assert group.max_velocity == 0.16
    assert group.upper == pytest.approx(0.6, abs=0.01)


def test_track_file_of_the_package_is_complete():
    section = Section(yaml.safe_load((CONFIG / "track_teleop.yaml").read_text()), "track")
    settings = TrackSettings.from_settings(section)
    SpeedScale.from_settings(section)
    section.finish()
    assert (settings.max_linear, settings.max_angular) == (1.2, 1.0)
