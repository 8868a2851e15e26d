"""The robot model as robot_state_publisher, and with it KDL, take it."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest
import yaml
from waiting import wait_until

from telex_experiments.rigs.private_master import PrivateMaster, end_tree

pytestmark = pytest.mark.waiting

LAUNCH = """
<launch>
  <group ns="one"><include file="$(find telex_description)/launch/description.launch"/></group>
  <group ns="two">
    <include file="$(find telex_description)/launch/description.launch">
      <arg name="variant" value="six_axis"/>
      <arg name="options" value="tool:=probe"/>
    </include>
  </group>
</launch>
"""
NAMESPACES = ("/one", "/two")


def text_of(master: PrivateMaster, *command: str) -> str:
    return subprocess.run(
        command,
        env=master.environment(),
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=30,
        check=False,
    ).stdout


def frames_of_six_cameras(master: PrivateMaster) -> str:
    frames = text_of(master, "timeout", "10", "rostopic", "echo", "-n1", "/tf_static")
    return frames if frames.count("optical_frame") >= 6 else ""


@pytest.mark.ros
def test_description_launch_publishes_frames_without_a_warning(tmp_path: Path) -> None:
    launch, output = tmp_path / "description.launch", tmp_path / "output.txt"
    launch.write_text(LAUNCH)
    with PrivateMaster() as master, output.open("w") as file:
        roslaunch = subprocess.Popen(
            ["roslaunch", "--screen", str(launch)],
            env=master.environment(),
            stdout=file,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        try:
            frames = wait_until(
                lambda: frames_of_six_cameras(master), "the frames of six cameras", 60.0
            )
            descriptions = {
                name: yaml.safe_load(
                    text_of(master, "rosparam", "get", f"{name}/robot_description")
                )
                for name in NAMESPACES
            }
        finally:
            end_tree(roslaunch)
    said = output.read_text()
    assert "child_frame_id" in frames
    assert "imu_link" in frames
    assert "process[one/robot_state_publisher" in said
    assert "process[two/robot_state_publisher" in said
    assert "warn" not in said.lower(), said
    assert "error" not in said.lower(), said
    # What everybody else reads has the mass of the root: PyBullet would take 1 kg instead.
    for description in descriptions.values():
        assert description.count("<inertial>") == description.count("<link ")
    assert "probe_link" not in descriptions["/one"]
    assert "probe_link" in descriptions["/two"]
