"""Every reader of the URDF takes it without a word: the standard robot and variants."""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path
from typing import Dict, Iterator

import pybullet
import pytest
import yaml
from pybullet_utils.bullet_client import BulletClient
from urdf_parser_py.urdf import URDF

from telex_control.kinematics import UrdfTree, kdl_tree
from telex_control.urdf.joints import joints, parse_urdf
from telex_control.urdf.transmission_parser import driven_joints
from telex_experiments.rigs.private_master import PrivateMaster, end_tree

pytestmark = pytest.mark.waiting

PACKAGE = Path(__file__).resolve().parents[1]
VARIANTS = ("standard", "six_axis", "carrier")
PATIENCE = 30.0  # s


def describe(variant: str) -> str:
    script = PACKAGE / "scripts" / "robot_description"
    return subprocess.run(
        [sys.executable, str(script), variant], check=True, capture_output=True, text=True
    ).stdout


@pytest.fixture(scope="module")
def descriptions() -> Dict[str, str]:
    return {variant: describe(variant) for variant in VARIANTS}


@pytest.fixture(scope="module")
def master() -> Iterator[PrivateMaster]:
    with PrivateMaster() as master:
        yield master


@pytest.mark.parametrize("variant", VARIANTS)
def test_check_urdf(descriptions: Dict[str, str], variant: str, tmp_path: Path) -> None:
    file = tmp_path / "telex.urdf"
    file.write_text(descriptions[variant], encoding="utf-8")
    result = subprocess.run(["check_urdf", str(file)], capture_output=True, text=True, check=False)
    assert (result.returncode, result.stderr) == (0, "")
    assert "arning" not in result.stdout


@pytest.mark.parametrize("variant", VARIANTS)
def test_urdf_parser(
    descriptions: Dict[str, str], variant: str, capfd: pytest.CaptureFixture
) -> None:
    robot = URDF.from_xml_string(descriptions[variant].encode())
    assert robot.get_root() == "base_link"
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("variant", VARIANTS)
def test_kdl_and_the_control_layer(descriptions: Dict[str, str], variant: str) -> None:
    robot = parse_urdf(descriptions[variant])
    tree = UrdfTree(robot)
    assert kdl_tree(tree).getNrOfJoints() == len(joints(robot))
    assert {each.joint for each in driven_joints(robot)} == set(joints(robot))


@pytest.mark.parametrize("variant", VARIANTS)
def test_pybullet(
    descriptions: Dict[str, str], variant: str, tmp_path: Path, capfd: pytest.CaptureFixture
) -> None:
    file = tmp_path / "telex.urdf"
    text = descriptions[variant].replace("package://telex_description", str(PACKAGE))
    file.write_text(text, encoding="utf-8")
    bullet = BulletClient(pybullet.DIRECT)
    try:
        capfd.readouterr()
        body = bullet.loadURDF(str(file), flags=pybullet.URDF_USE_INERTIA_FROM_FILE)
        assert capfd.readouterr() == ("", "")
        assert bullet.getNumJoints(body) == descriptions[variant].count("<joint name=") - (
            descriptions[variant].count("<transmission ")
        )
    finally:
        bullet.disconnect()


@pytest.mark.ros
@pytest.mark.parametrize("variant", VARIANTS)
def test_robot_state_publisher_and_the_display(
    master: PrivateMaster, variant: str, tmp_path: Path
) -> None:
    output = tmp_path / "output.txt"
    with open(output, "w") as file:
        launch = subprocess.Popen(
            [
                *("roslaunch", "--screen", "telex_description", "display.launch"),
                *(f"variant:={variant}", "rviz:=false"),
            ],
            env=master.environment(),
            stdin=subprocess.DEVNULL,
            stdout=file,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
    try:
        frames = subprocess.run(
            ["rostopic", "echo", "-n", "1", "/tf"],
            env=master.environment(),
            capture_output=True,
            text=True,
            timeout=PATIENCE,
            check=True,
        ).stdout
        # whatever is still to be said
        time.sleep(0.5)
        assert launch.poll() is None
    finally:
        end_tree(launch)
    moved = [
        each["child_frame_id"] for each in yaml.safe_load(frames.split("---")[0])["transforms"]
    ]
    assert "elbow_link" in moved
    assert ("telescope_link" in moved) is (variant != "six_axis")
    said = output.read_text(encoding="utf-8", errors="replace")
    assert "robot_state_publisher" in said
    for word in ("warn", "error", "traceback"):
        assert word not in said.lower(), said


def test_the_rviz_file_shows_what_there_is(descriptions: Dict[str, str]) -> None:
    config = yaml.safe_load((PACKAGE / "rviz" / "telex.rviz").read_text(encoding="utf-8"))
    manager = config["Visualization Manager"]
    links = set(UrdfTree(parse_urdf(descriptions["standard"])).inertials)
    assert manager["Global Options"]["Fixed Frame"] in links
    shown = {display["Name"]: display for display in manager["Displays"]}
    known = {"rviz/Grid", "rviz/RobotModel", "rviz/TF", "rviz/Axes"}
    assert {display["Class"] for display in shown.values()} == known
    for display in shown.values():
        assert display.get("Reference Frame", "base_link") in links
        assert display.get("Robot Description", "robot_description") == "robot_description"
    assert shown["Robot"]["Enabled"]
    assert shown["Floor"]["Offset"]["Z"] == -0.11
