"""What other people's xacro and launch files take for granted."""

from __future__ import annotations

import math
import os
import subprocess

import pytest
import yaml

from telex_control.urdf.joints import UrdfError, joints, parse_urdf
from telex_sim.robot.model import robot_model

ARM = """<?xml version="1.0"?>
<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:arg name="folder" default="."/>
  <xacro:property name="folder" value="$(arg folder)"/>
  <xacro:property name="limits" value="${xacro.load_yaml(folder + '/limits.yaml')}"/>
  <xacro:property name="sizes" value="${load_yaml(folder + '/limits.yaml')['sizes']}"/>
  <link name="base"><visual><geometry>
    <mesh filename="$(find telex_description)/meshes/hull.obj"/></geometry></visual></link>
  <xacro:macro name="joint" params="name parent:=base *limit">
    <link name="${name}_link"/>
    <joint name="${name}" type="revolute">
      <parent link="${parent}"/><child link="${name}_link"/>
      <origin xyz="0 0 ${sizes['height']}"/>
      <xacro:insert_block name="limit"/>
    </joint>
  </xacro:macro>
  <xacro:joint name="elbow">
    <limit lower="${limits['lower']}" upper="${limits.upper}" velocity="1" effort="1"/>
  </xacro:joint>
</robot>
"""
LIMITS = "lower: !degrees -90\nupper: !radians 1.5\nsizes: {height: 0.25}\n"


@pytest.fixture
def arm(tmp_path):
    (tmp_path / "limits.yaml").write_text(LIMITS)
    path = tmp_path / "arm.xacro"
    path.write_text(ARM)
    return path


def check(text):
    robot = parse_urdf(text)
    elbow = joints(robot)["elbow"]
    assert (elbow.lower, elbow.upper) == (pytest.approx(-math.pi / 2.0), 1.5)
    assert robot.joints[0].origin.xyz == [0.0, 0.0, 0.25]
    mesh = next(visual.geometry for link in robot.links for visual in link.visuals)
    assert mesh.filename.endswith("/telex_description/meshes/hull.obj")


def test_limits_from_yaml_with_units_and_files_of_packages(arm):
    check(robot_model(arm, [f"folder={arm.parent}"]))


def test_a_package_that_is_not_there_is_named(arm):
    arm.write_text(ARM.replace("find telex_description", "find nowhere_description"))
    said = r"xacro: ROS_PACKAGE_PATH has no package 'nowhere_description'\n"
    with pytest.raises(UrdfError, match=said):
        robot_model(arm, [f"folder={arm.parent}"])


def test_a_launch_file_finds_xacro_as_a_package(arm):
    launch = arm.parent / "arm.launch"
    launch.write_text(
        '<launch><param name="robot_description" '
        f"command=\"$(find xacro)/xacro --inorder '{arm}' folder:={arm.parent}\"/></launch>"
    )
    done = subprocess.run(
        ["roslaunch", "--dump-params", str(launch)],
        env={**os.environ, "ROS_LOG_DIR": str(arm.parent)},
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    check(yaml.safe_load(done.stdout)["/robot_description"])


@pytest.mark.parametrize(
    ("options", "cameras"),
    [
        ("", {"front", "rear", "mast"}),
        ("cameras=front rear payload_size=0.2 0.2 0.1", {"front", "rear"}),
        ("cameras=front,tool=probe", {"front"}),
    ],
)
def test_options_of_a_variant_may_have_words_with_spaces_between(arm, options, cameras):
    done = subprocess.run(
        [
            *("roslaunch", "--dump-params", "telex_description", "description.launch"),
            f"options:={options}",
        ],
        env={**os.environ, "ROS_LOG_DIR": str(arm.parent)},
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    model = yaml.safe_load(done.stdout)["/robot_description"]
    assert {name for name in ("front", "rear", "mast") if f"{name}_camera_link" in model} == cameras


def test_a_package_of_the_system_comes_first(arm):
    system = arm.parent / "share" / "xacro"
    system.mkdir(parents=True)
    (system / "package.xml").write_text("<package><name>xacro</name></package>")
    path = f"{system.parent}:{os.environ['ROS_PACKAGE_PATH']}"
    found = subprocess.check_output(
        ["rospack", "find", "xacro"], env={**os.environ, "ROS_PACKAGE_PATH": path}, text=True
    )
    assert found.strip() == str(system)
