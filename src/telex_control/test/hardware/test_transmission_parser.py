"""The cases of upstream's transmission_parser tests, and Gazebo's view of them."""

from __future__ import annotations

import pytest

from telex_control.urdf.joints import UrdfError, parse_urdf
from telex_control.urdf.transmission_parser import (
    DrivenJoint,
    driven_and_watched,
    driven_joints,
    interfaces,
    transmissions,
)

SIMPLE = "transmission_interface/SimpleTransmission"
EFFORT = "<hardwareInterface>hardware_interface/EffortJointInterface</hardwareInterface>"
MOTOR = '<actuator name="m"><mechanicalReduction>50</mechanicalReduction></actuator>'


def robot(*bodies, names=("t", "u"), more=""):
    tags = "".join(
        f'<transmission name="{name}">{body}</transmission>' for name, body in zip(names, bodies)
    )
    return parse_urdf(
        '<robot name="r"><joint name="j1" type="continuous"/><joint name="j2" type="continuous"/>'
        f"{more}{tags}</robot>"
    )


def simple(joint=f'<joint name="j1">{EFFORT}</joint>', actuator=MOTOR, kind=SIMPLE):
    return f"<type>{kind}</type>{joint}{actuator}"


DIFFERENTIAL_BODY = f"""<type>transmission_interface/DifferentialTransmission</type>
  <actuator name="a1"><role>actuator1</role>
    <mechanicalReduction>10</mechanicalReduction></actuator>
  <actuator name="a2"><role>actuator2</role>
    <mechanicalReduction>-10</mechanicalReduction></actuator>
  <joint name="j1"><role>joint1</role><offset>0.5</offset>
    <mechanicalReduction>2</mechanicalReduction>{EFFORT}</joint>
  <joint name="j2"><role>joint2</role><mechanicalReduction>4</mechanicalReduction>{EFFORT}</joint>
"""


def test_everything_is_read():
    (found,) = transmissions(
        robot(simple(f'<joint name="j1"><offset>0.1</offset>{EFFORT}</joint>'))
    )
    assert found.name == "t"
    assert found.joints[0].hardware_interfaces == ("hardware_interface/EffortJointInterface",)


@pytest.mark.parametrize(
    ("body", "logged"),
    [
        (f'<joint name="j1">{EFFORT}</joint>{MOTOR}', "no <type>"),
        (simple(kind=" "), "no <type>"),
        (simple(joint=""), "no <joint>"),
        (simple(joint=f"<joint>{EFFORT}</joint>"), "a <joint> has no name"),
        (simple(joint='<joint name="j1"/>'), "joint 'j1' has no <hardwareInterface>"),
        (simple(actuator=""), "no <actuator>"),
        (simple(actuator="<actuator/>"), "an <actuator> has no name"),
    ],
)
def test_what_cannot_be_read_is_left_out_and_named(body, logged, caplog):
    good = simple(f'<joint name="j2">{EFFORT}</joint>')
    (found,) = transmissions(robot(body, good))
    assert found.name == "u"
    assert f"transmission 't' is left out: {logged}" in caplog.text.replace("it has ", "")


def test_a_transmission_needs_a_name(caplog):
    assert transmissions(robot(simple(), names=[""])) == []
    assert "has no name" in caplog.text


@pytest.mark.parametrize(
    "change",
    [
        ("", ""),
        ("<mechanicalReduction>2</mechanicalReduction>", ""),
        (">10<", ">many<"),
        ("Differential", "FourBarLinkage"),
    ],
)
def test_a_simulation_drives_joints_whatever_the_reduction(caplog, change):
    found = driven_joints(robot(DIFFERENTIAL_BODY.replace(*change)))
    assert found == [
        DrivenJoint("j1", "t", "EffortJointInterface"),
        DrivenJoint("j2", "t", "EffortJointInterface"),
    ]
    assert caplog.text == ""


def test_an_interface_without_prefix_is_deprecated(caplog):
    bare = "<hardwareInterface>VelocityJointInterface</hardwareInterface>"
    (found,) = driven_joints(robot(simple(f'<joint name="j1">{bare}</joint>')))
    assert found.hardware_interface == "VelocityJointInterface"
    assert "deprecated; write 'hardware_interface/VelocityJointInterface'" in caplog.text


def test_of_several_interfaces_the_first_counts(caplog):
    both = EFFORT + EFFORT.replace("Effort", "Position")
    (found,) = driven_joints(robot(simple(f'<joint name="j1">{both}</joint>')))
    assert found.hardware_interface == "EffortJointInterface"
    assert "several hardware interfaces; the first one counts" in caplog.text


def test_an_interface_of_states_does_not_stand_in_the_way(caplog):
    full = EFFORT.replace("EffortJoint", "JointState")
    for states in (full, full.replace("hardware_interface/", "")):
        (found,) = driven_joints(robot(simple(f'<joint name="j1">{states}{EFFORT}</joint>')))
        assert found.hardware_interface == "EffortJointInterface"
        both = robot(simple(f'<joint name="j1">{states}</joint>'), simple())
        (found,) = driven_joints(both)
        assert (found.transmission, found.hardware_interface) == ("u", "EffortJointInterface")
    assert caplog.text == ""


def test_a_joint_with_its_state_alone_is_watched(caplog):
    state = EFFORT.replace("EffortJoint", "JointState")
    described = robot(
        simple(f'<joint name="j2">{state}</joint>', kind="hey5_transmissions/Hey5Reducer"), simple()
    )
    driven, watched = driven_and_watched(described)
    assert ([each.joint for each in driven], watched) == (["j1"], ["j2"])
    assert driven_joints(described) == driven
    assert caplog.text == ""


def test_interfaces_say_nothing_of_what_is_wrong(caplog):
    bad = simple(f'<joint name="j2">{EFFORT}</joint>', kind="")
    motor = f'<actuator name="m">{EFFORT.replace("Effort", "Position")}</actuator>'
    found = interfaces(robot(bad, simple('<joint name="j1"/>', motor)))
    assert found == {"j1": "PositionJointInterface"}
    assert caplog.text == ""


def test_one_that_is_not_simulated_gives_way_to_one_that_is(caplog):
    state = "<hardwareInterface>franka_hw/FrankaStateInterface</hardwareInterface>"
    body = simple(f'<joint name="j1">{state}</joint>', kind="franka_hw/FrankaStateTransmission")
    (found,) = driven_joints(robot(body, simple()))
    assert found == DrivenJoint("j1", "u", "EffortJointInterface")
    assert "'t': 'franka_hw/FrankaStateInterface' is not simulated; joint 'j1' is" in caplog.text


def test_what_is_not_simulated_of_a_fixed_joint_is_passed_over(caplog):
    pose = "<hardwareInterface>franka_hw/FrankaModelInterface</hardwareInterface>"
    ends = f'<joint name="j1">{pose}</joint><joint name="flange">{pose}</joint>'
    described = robot(
        simple(ends, kind="franka_hw/FrankaModelTransmission"),
        simple(),
        more='<joint name="flange" type="fixed"/>',
    )
    assert [each.joint for each in driven_joints(described)] == ["j1"]
    assert "'t': 'franka_hw/FrankaModelInterface' is not simulated\n" in caplog.text


OLD = """<robot name="r"><joint name="wheel" type="continuous"/><joint name="j1" type="continuous"/>
  <transmission name="old" type="pr2_mechanism_model/SimpleTransmission">
    <actuator name="m"/><{tag} name="wheel"/><mechanicalReduction>70</mechanicalReduction>
  </transmission>{more}</robot>"""


@pytest.mark.parametrize(
    ("text", "named"),
    [
        (OLD.format(tag="joint", more=""), "'old' has 'pr2_mechanism_model/SimpleTransmission'"),
        (OLD.format(tag="flexJoint", more=""), "for joint 'wheel'"),
    ],
)
def test_what_nothing_simulated_drives_is_refused_with_what_to_write(text, named, caplog):
    with pytest.raises(UrdfError, match=named) as caught:
        driven_joints(parse_urdf(text))
    assert caplog.text == ""
    written = str(caught.value).partition("write ")[2]
    (found,) = driven_joints(parse_urdf(OLD.format(tag="joint", more=written)))
    assert (found.joint, found.hardware_interface) == ("wheel", "EffortJointInterface")
    assert "'old' is left out: its style is pr2's" in caplog.text


@pytest.mark.parametrize(
    "interface",
    [
        "franka_hw/FrankaPoseCartesianInterface",
        "my_hardware_interface/EffortJointInterface",
        "Torque",
    ],
)
def test_an_interface_that_is_not_simulated_is_refused(interface):
    tag = f"<hardwareInterface>{interface}</hardwareInterface>"
    body = simple(f'<joint name="j1">{tag}</joint>')
    with pytest.raises(UrdfError, match=f"'t' has '{interface}' for joint 'j1'; simulated are"):
        driven_joints(robot(body))


def test_of_several_transmissions_the_first_counts(caplog):
    found = driven_joints(robot(simple(), simple()))
    assert [(each.joint, each.transmission) for each in found] == [("j1", "t")]
    assert "joint 'j1' has the transmissions 't' and 'u'" in caplog.text


def test_an_interface_at_the_actuator_is_taken_with_a_warning(caplog):
    motor = f'<actuator name="m">{EFFORT}</actuator>'
    (found,) = driven_joints(robot(simple('<joint name="j1"/>', motor)))
    assert found.hardware_interface == "EffortJointInterface"
    assert "belongs into the <joint>" in caplog.text


def test_a_joint_that_is_not_there_is_named():
    with pytest.raises(UrdfError, match="'t' names the joint 'x'"):
        driven_joints(robot(simple(f'<joint name="x">{EFFORT}</joint>')))
