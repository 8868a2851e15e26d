"""The cases of upstream's transmission_parser and loader tests, and Gazebo's view of them."""

from __future__ import annotations

import pytest

from telex_control.transmission_interface import TransmissionError
from telex_control.transmission_parser import (
    DIFFERENTIAL,
    SIMPLE,
    DrivenJoint,
    driven_joints,
    load_transmission,
    transmissions,
)
from telex_control.urdf_joints import UrdfError, parse_urdf

EFFORT = "<hardwareInterface>hardware_interface/EffortJointInterface</hardwareInterface>"
MOTOR = '<actuator name="m"><mechanicalReduction>50</mechanicalReduction></actuator>'


def robot(*bodies, names=("t", "u")):
    tags = "".join(
        f'<transmission name="{name}">{body}</transmission>' for name, body in zip(names, bodies)
    )
    return parse_urdf(
        '<robot name="r"><joint name="j1" type="continuous"/><joint name="j2" type="continuous"/>'
        f"{tags}</robot>"
    )


def simple(joint=f'<joint name="j1">{EFFORT}</joint>', actuator=MOTOR, kind=SIMPLE):
    return f"<type>{kind}</type>{joint}{actuator}"


DIFFERENTIAL_BODY = f"""<type>{DIFFERENTIAL}</type>
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
    assert (found.name, found.type) == ("t", SIMPLE)
    assert found.joints[0].hardware_interfaces == ("hardware_interface/EffortJointInterface",)
    assert found.joints[0].offset == 0.1
    assert (found.actuators[0].name, found.actuators[0].mechanical_reduction) == ("m", 50.0)


def test_simple_is_loaded():
    body = simple(f'<joint name="j1"><offset>0.1</offset>{EFFORT}</joint>')
    (info,) = transmissions(robot(body))
    assert load_transmission(info).actuator_to_joint_position([100.0]) == (2.1,)


def test_a_differential_is_loaded_by_roles_not_by_order():
    body = DIFFERENTIAL_BODY.replace("joint1", "x").replace("joint2", "joint1")
    body = body.replace("<role>x</role>", "<role>joint2</role>")
    (straight,) = transmissions(robot(DIFFERENTIAL_BODY))
    (crossed,) = transmissions(robot(body))
    assert load_transmission(straight).actuator_to_joint_velocity([40.0, 80.0]) == (-1.0, 1.5)
    assert load_transmission(crossed).actuator_to_joint_velocity([40.0, 80.0]) == (-0.5, 3.0)


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
        (
            simple(actuator=MOTOR.replace("50", "many")),
            "'m': <mechanicalReduction>many</mechanicalReduction> is no finite number",
        ),
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
    ("body", "named"),
    [
        (simple(kind="transmission_interface/FourBarLinkageTransmission"), "'t': type .* unknown"),
        (simple(actuator='<actuator name="m"/>'), "'m' has no <mechanicalReduction>"),
        (simple(actuator=MOTOR.replace("50", "0")), "reduction is 0.0"),
        (simple(actuator=MOTOR + MOTOR), "1 joints and 2 actuators"),
        (DIFFERENTIAL_BODY.replace("actuator2", "actuator1"), "the roles are"),
    ],
)
def test_what_cannot_be_loaded_is_named(body, named):
    (info,) = transmissions(robot(body))
    with pytest.raises(TransmissionError, match=named):
        load_transmission(info)


def test_a_simulation_drives_joints_whatever_the_reduction(caplog):
    found = driven_joints(robot(DIFFERENTIAL_BODY))
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
