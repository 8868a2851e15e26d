"""Robot descriptions are read as urdf_parser_py reads them, and where it would not as well."""

from __future__ import annotations

import pytest
from urdf_parser_py import urdf

from telex_control.urdf.elements import number, numbers, vector
from telex_control.urdf.model import (
    Box,
    Capsule,
    Mesh,
    UnknownShape,
    UrdfError,
    read_robot,
    read_xml,
    robot_of,
)

COMPLETE = """<?xml version="1.0"?><robot name="r">
  <!-- a comment -->
  <material name="blue"><color rgba="0 0 1 1"/></material>
  <link name="base">
    <inertial><origin xyz="0 0 1" rpy="0.1 0 0"/><mass value="2"/>
      <inertia ixx="1" ixy="0" ixz="0.1" iyy="2" iyz="0" izz="3"/></inertial>
    <visual name="hull"><origin xyz="1 2 3"/><geometry><box size="1 2 3"/></geometry>
      <material name="blue"/></visual>
    <visual><geometry><mesh filename="package://p/a.stl" scale="1 1 2"/></geometry>
      <material name=""><texture filename="package://p/a.png"/></material></visual>
    <collision><geometry><cylinder radius="0.5" length="2"/></geometry></collision>
    <collision><geometry><sphere radius="0.5"/></geometry></collision>
  </link>
  <link name="arm"/>
  <link name="tip"/>
  <joint name="swing" type="revolute"><origin rpy="0 1 0"/><axis xyz="0 0 1"/>
    <parent link="base"/><child link="arm"/>
    <limit effort="10" velocity="2" lower="-1" upper="1.5"/>
    <dynamics damping="0.1" friction="0.2"/>
    <safety_controller k_velocity="5" k_position="6" soft_lower_limit="-0.9"
                       soft_upper_limit="1.4"/></joint>
  <joint name="follow" type="continuous"><parent link="arm"/><child link="tip"/>
    <mimic joint="swing" multiplier="-2" offset="0.5"/></joint>
  <gazebo reference="arm"><mu1>0.5</mu1></gazebo>
  <transmission name="t"><type>transmission_interface/SimpleTransmission</type>
    <joint name="swing"><hardwareInterface>EffortJointInterface</hardwareInterface>
      <hardwareInterface>PositionJointInterface</hardwareInterface></joint>
    <actuator name="m"><mechanicalReduction>50</mechanicalReduction></actuator></transmission>
</robot>"""


def values(thing):
    """All that is set in an object of urdf_parser_py, as plain values."""
    if isinstance(thing, (list, tuple)):
        return [values(each) for each in thing]
    reflection = getattr(thing, "XML_REFL", None)
    if reflection is None:
        return getattr(thing, "attrib", thing)
    return {name: values(getattr(thing, name)) for name in reflection.vars}


def same(ours, theirs):
    """Compare what both have, and what is given: of the rest, there they have defaults."""
    if isinstance(theirs, dict):
        for name in theirs.keys() & ours.keys():
            if ours[name] not in (None, ""):
                same(ours[name], theirs[name])
    elif isinstance(theirs, list):
        assert len(ours) == len(theirs)
        for mine, other in zip(ours, theirs):
            same(mine, other)
    else:
        assert ours == theirs


def described(inside, name="r"):
    return read_robot(f'<robot name="{name}">{inside}</robot>')


def test_a_complete_description_is_read_as_urdf_parser_py_reads_it(capfd):
    ours, theirs = read_robot(COMPLETE), urdf.Robot.from_xml_string(COMPLETE)
    same(values(ours), values(theirs))
    assert isinstance(ours, urdf.Robot)
    assert isinstance(ours.joint_map["swing"].limit, urdf.JointLimit)
    assert list(ours.link_map) == list(theirs.link_map) == ["base", "arm", "tip"]
    assert ours.parent_map == theirs.parent_map
    assert ours.child_map == theirs.child_map
    assert ours.get_chain("base", "tip") == ["base", "swing", "arm", "follow", "tip"]
    capfd.readouterr()


def test_all_that_is_given_is_there():
    robot = read_robot(COMPLETE)
    base, swing, follow = robot.link_map["base"], *robot.joints
    assert (base.inertial.mass, base.inertial.origin.xyz) == (2.0, [0.0, 0.0, 1.0])
    assert [base.inertial.inertia.ixz, base.inertial.inertia.izz] == [0.1, 3.0]
    hull, mesh = base.visuals
    assert (hull.name, hull.origin.xyz, hull.geometry.size) == ("hull", [1, 2, 3], [1, 2, 3])
    assert (mesh.geometry.filename, mesh.geometry.scale) == ("package://p/a.stl", [1, 1, 2])
    assert (hull.material.name, hull.material.color) == ("blue", None)
    assert mesh.material.texture.filename == "package://p/a.png"
    assert robot.materials[0].color.rgba == [0, 0, 1, 1]
    assert [each.geometry.radius for each in base.collisions] == [0.5, 0.5]
    assert (swing.type, swing.parent, swing.child) == ("revolute", "base", "arm")
    assert (swing.axis, swing.origin.rpy, swing.origin.xyz) == ([0, 0, 1], [0, 1, 0], None)
    assert (swing.limit.lower, swing.limit.effort, swing.dynamics.friction) == (-1, 10, 0.2)
    assert swing.safety_controller.k_position == 6
    assert (follow.limit, follow.axis, follow.mimic.multiplier) == (None, None, -2)
    assert robot.gazebos[0].find("mu1").text == "0.5"
    assert robot.transmissions[0].joints[0].hardwareInterfaces == [
        "EffortJointInterface",
        "PositionJointInterface",
    ]


REFUSED = {
    "limit": (
        '<joint name="j" type="revolute"><parent link="a"/><child link="b"/><limit/></joint>',
        "Required attribute not set in XML: effort",
    ),
    "inertia": (
        '<link name="a"><inertial><mass value="1"/><inertia ixx="1"/></inertial></link>',
        "Required attribute not set in XML: ixy",
    ),
    "capsule": (
        '<link name="a"><collision><geometry><capsule radius="1" length="2"/></geometry>'
        "</collision></link>",
        "Invalid geometric tag: capsule",
    ),
    "visual": ('<link name="a"><visual/></link>', "Required element not set in XML: geometry"),
    "interface": (
        '<transmission name="t"><type>x</type><joint name="j"/><actuator name="m">'
        "<hardwareInterface>EffortJointInterface</hardwareInterface></actuator></transmission>",
        "no hardwareInterface defined",
    ),
    "unfilled": (
        '<joint name="j" type="fixed"><origin xyz="${x} 0 0"/><parent link="a"/><child link="b"/>'
        "</joint>",
        "could not convert string to float",
    ),
    "axis": (
        '<joint name="j" type="continuous"><axis/><parent link="a"/><child link="b"/></joint>',
        "'NoneType' object has no attribute 'split'",
    ),
}


@pytest.mark.parametrize(("inside", "said"), REFUSED.values(), ids=REFUSED)
def test_what_urdf_parser_py_refuses_is_read(inside, said, capfd):
    with pytest.raises(Exception, match=said):
        urdf.Robot.from_xml_string(f'<robot name="r">{inside}</robot>')
    capfd.readouterr()
    described(inside)
    assert capfd.readouterr() == ("", "")


def test_nothing_is_said_of_what_urdf_does_not_know(capfd):
    robot = described(
        '<xacro:macro xmlns:xacro="http://ros.org/xacro" name="left"/><sensor name="s"/>'
        '<link name="a" type="x"><contact><stiffness value="1"/></contact><color/></link>'
        '<joint name="j" type="fixed"><parent link="a"/><parent link="c"/><child link="b"/></joint>'
    )
    assert robot.links[0].contact.find("stiffness") is not None
    assert robot.joints[0].parent == "a"
    assert capfd.readouterr() == ("", "")


def test_what_is_not_given_is_none_and_names_are_empty():
    robot = described("<link/><joint><limit/></joint><transmission/>")
    (link,), (joint,), (transmission,) = robot.links, robot.joints, robot.transmissions
    assert (link.name, link.inertial, link.visuals, link.contact) == ("", None, [], None)
    assert (joint.name, joint.type, joint.parent, joint.child) == ("", "", "", "")
    assert (joint.limit.lower, joint.limit.effort, joint.mimic) == (None, None, None)
    assert (transmission.name, transmission.type, transmission.style) == ("", None, "")
    assert described("", "").name == ""
    assert read_robot("<robot/>").name is None


@pytest.mark.parametrize("text", ["nan", "inf", "-inf", "1e999", "much", "", "1 2", "${lower}"])
def test_a_number_that_is_none_is_refused_where_it_is_needed(text):
    limit = described(f'<joint name="j"><limit lower="{text}"/></joint>').joints[0].limit
    assert limit.lower == text
    with pytest.raises(UrdfError) as caught:
        number(limit, "lower", "joint 'j'", 0.0)
    assert str(caught.value) == f"joint 'j': <limit lower=\"{text}\">; a finite number is needed"


@pytest.mark.parametrize("text", ["0 0", "0 0 nan", "0 0 0 0", "a b c"])
def test_three_numbers_that_are_none_are_refused_where_they_are_needed(text):
    joint = described(f'<joint name="j"><axis xyz="{text}"/></joint>').joints[0]
    with pytest.raises(UrdfError) as caught:
        vector(joint, "axis", "joint 'j'")
    assert str(caught.value) == f"joint 'j': <axis xyz=\"{text}\">; 3 finite numbers are needed"


def test_numbers_that_must_be_there_are_asked_for():
    link = described('<link name="a"><visual><geometry><box/></geometry></visual></link>').links[0]
    with pytest.raises(UrdfError, match=r'a: <box size="">; 3 finite numbers are needed'):
        numbers(link.visuals[0].geometry, "size", 3, "a")
    with pytest.raises(UrdfError, match="a: mass is not given; a finite number is needed"):
        number(link.inertial, "mass", "a")
    assert number(link.inertial, "mass", "a", 0.0) == 0.0


def test_shapes():
    robot = described(
        '<link name="a">'
        + "".join(
            f"<collision><geometry>{shape}</geometry></collision>"
            for shape in ('<box size="1 1 1"/><mesh/>', '<capsule radius="1"/>', "<cone/>", "")
        )
        + '<collision/><visual><geometry><mesh filename="m"/></geometry></visual></link>'
    )
    box, capsule, cone, nothing, none = (each.geometry for each in robot.links[0].collisions)
    assert isinstance(box, Box)
    assert isinstance(capsule, Capsule)
    assert (capsule.radius, capsule.length) == (1.0, None)
    assert isinstance(cone, UnknownShape)
    assert cone.tag == "cone"
    assert nothing is none is None
    mesh = robot.links[0].visuals[0].geometry
    assert isinstance(mesh, Mesh)
    assert mesh.scale is None


def test_reading_leaves_the_xml_as_it_is():
    root = read_xml(COMPLETE)
    robot_of(root)
    assert robot_of(root).link_map.keys() == robot_of(read_xml(COMPLETE)).link_map.keys()
    assert len(root.findall("link")) == 3


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "robot_description is no XML: no element found"),
        ("<robot><link></robot>", "is no XML: mismatched tag: line 1"),
        ('<robot><xacro:macro name="a"/></robot>', "is no XML: unbound prefix"),
        ("<sdf/>", "has the root element <sdf>; <robot> is needed"),
    ],
)
def test_what_is_no_robot_is_refused(text, said):
    with pytest.raises(UrdfError, match=said):
        read_robot(text)
