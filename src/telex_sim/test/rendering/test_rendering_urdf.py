import math
import re

import pytest

from telex_control.urdf.elements import UrdfError
from telex_sim.robot.urdf.visuals import DEFAULT_COLOR, urdf_visuals
from telex_sim.scene.visual_scene import VisualShape

ROBOT = """<?xml version="1.0" encoding="utf-8"?>
<robot name="r">
  <material name="orange"><color rgba="1 0.5 0 1"/></material>
  <link name="base">
    <visual>
      <origin xyz="1 2 3" rpy="0 0 1.5707963267948966"/>
      <geometry><box size="1 2 3"/></geometry>
      <material name="orange"/>
    </visual>
    <visual>
      <geometry><cylinder radius="0.1" length="0.5"/></geometry>
      <material name="blue"><color rgba="0 0 1 0.5"/></material>
    </visual>
  </link>
  <link name="empty"/>
  <link name="arm">
    <visual>
      <origin xyz="0 0 1"/>
      <geometry><sphere radius="0.2"/></geometry>
      <material name="blue"/>
    </visual>
    <visual>
      <geometry><mesh filename="package://robot/a.obj" scale="1 -1 2"/></geometry>
      <material name="poster"><texture filename="package://robot/a.png"/></material>
    </visual>
    <visual><geometry><mesh filename="package://robot/b.stl"/></geometry></visual>
    <visual>
      <geometry><box size="1 1 1"/></geometry>
      <material name="unheard of"/>
    </visual>
    <collision><geometry><box size="9 9 9"/></geometry></collision>
  </link>
  <joint name="j" type="fixed"><parent link="base"/><child link="arm"/></joint>
  <joint name="k" type="fixed"><parent link="base"/><child link="empty"/></joint>
</robot>
"""


@pytest.fixture(scope="module")
def visuals():
    return urdf_visuals(ROBOT)


def test_all_visuals_in_order(visuals):
    assert [visual.link for visual in visuals] == ["base"] * 2 + ["arm"] * 4
    assert [visual.shape for visual in visuals] == [
        VisualShape.BOX,
        VisualShape.CYLINDER,
        VisualShape.SPHERE,
        VisualShape.MESH,
        VisualShape.MESH,
        VisualShape.BOX,
    ]


def test_sizes_as_in_the_scene_messages(visuals):
    box, cylinder, sphere, mesh, plain_mesh, _ = visuals
    assert box.size == (1.0, 2.0, 3.0)
    assert (cylinder.size[0], cylinder.size[2]) == (0.1, 0.5)
    assert sphere.size[0] == 0.2
    assert mesh.size == (1.0, -1.0, 2.0)
    assert plain_mesh.size == (1.0, 1.0, 1.0)
    assert plain_mesh.mesh == "package://robot/b.stl"


def test_poses(visuals):
    assert visuals[0].position == (1.0, 2.0, 3.0)
    assert visuals[0].orientation == pytest.approx((0, 0, math.sqrt(0.5), math.sqrt(0.5)))
    assert visuals[1].position == (0.0, 0.0, 0.0)
    assert visuals[1].orientation == (0.0, 0.0, 0.0, 1.0)
    assert visuals[2].position == (0.0, 0.0, 1.0)


def test_materials_by_value_and_by_name(visuals):
    orange, blue, named_blue, poster, none, unknown = visuals
    assert orange.color == (1.0, 0.5, 0.0, 1.0)
    assert blue.color == named_blue.color == (0.0, 0.0, 1.0, 0.5)
    assert poster.color == (1.0, 1.0, 1.0, 1.0)
    assert poster.texture == "package://robot/a.png"
    assert none.color == unknown.color == DEFAULT_COLOR
    assert none.texture == ""


@pytest.mark.parametrize(
    "text", ["", "<robot", "<robot name='r'><link name='a'><visual/></link></robot>"]
)
def test_what_is_no_urdf(text):
    with pytest.raises(UrdfError, match="robot_description"):
        urdf_visuals(text)


@pytest.mark.parametrize("value", ["1e39", "255", "1.001", "-0.1"])
@pytest.mark.parametrize("given", ["1 0.5 0 1", "0 0 1 0.5"], ids=["of the robot", "of a visual"])
def test_a_color_beyond_0_to_1_is_refused_by_its_link(given, value):
    _, others = given.split(" ", 1)
    text = ROBOT.replace(f'rgba="{given}"', f'rgba="{value} {others}"')
    said = f"link 'base': visual: <color rgba> has the value {float(value):g}; 0 to 1 is needed"
    with pytest.raises(UrdfError, match=re.escape(said)):
        urdf_visuals(text)
