"""Variants: what scripts/robot_description prints, and what it refuses."""

from __future__ import annotations

import math
import runpy
import subprocess
from pathlib import Path
from typing import Dict, List, Set

import numpy as np
import pytest
import yaml
from urdf_parser_py.urdf import URDF

pytestmark = pytest.mark.slow

PACKAGE = Path(__file__).resolve().parents[1]
SCRIPT = PACKAGE / "scripts" / "robot_description"
MODEL = PACKAGE / "urdf" / "telex.urdf.xacro"
NAMES = list(yaml.safe_load((PACKAGE / "config" / "variants.yaml").read_text())["variants"])
FINGERS = {
    f"{side}_finger_{part}_joint"
    for side in ("left", "right")
    for part in ("base", "middle", "tip")
}
# Joints that a variant lacks of those that move in the standard robot
LACKING: Dict[str, Set[str]] = {
    "six_axis": {"telescope_joint"},
    "inspection": FINGERS,
    "carrier": FINGERS,
}


def describe(*words: str) -> subprocess.CompletedProcess:
    return subprocess.run([str(SCRIPT), *words], capture_output=True, text=True, check=False)


def described(*words: str) -> str:
    result = describe(*words)
    assert result.returncode == 0, result.stderr
    assert result.stderr == ""
    return result.stdout


def robot_of(*words: str) -> URDF:
    return URDF.from_xml_string(described(*words).encode())


def movable(robot: URDF) -> Set[str]:
    return {joint.name for joint in robot.joints if joint.type != "fixed"}


def without_comments(text: str) -> List[str]:
    return [line for line in text.splitlines() if line.strip() and "<!--" not in line]


@pytest.fixture(scope="module")
def standard() -> URDF:
    return robot_of()


# ---- what there is


def test_standard_robot_is_what_plain_xacro_gives() -> None:
    plain = subprocess.check_output(["xacro", str(MODEL)], text=True)
    assert without_comments(described("standard")) == without_comments(plain)
    assert without_comments(described()) == without_comments(plain)


@pytest.mark.parametrize("name", NAMES)
def test_every_variant_is_valid_and_has_its_joints(
    standard: URDF, name: str, tmp_path: Path, capfd: pytest.CaptureFixture
) -> None:
    file = tmp_path / "robot.urdf"
    file.write_text(described(name))
    checked = subprocess.run(["check_urdf", str(file)], capture_output=True, text=True, check=False)
    assert checked.returncode == 0
    assert checked.stderr == ""
    assert "root Link: base_link" in checked.stdout
    capfd.readouterr()
    robot = URDF.from_xml_string(file.read_bytes())
    assert capfd.readouterr().err == ""
    assert movable(robot) == movable(standard) - LACKING.get(name, set())
    transmitted = {transmission.joints[0].name for transmission in robot.transmissions}
    assert transmitted == movable(robot)
    for link in robot.links:
        moments = np.linalg.eigvalsh(np.array(link.inertial.inertia.to_matrix()))
        assert moments[0] > 0
        assert moments[0] + moments[1] >= moments[2] * (1 - 1e-6), link.name


def test_stroke_is_the_upper_limit_of_the_telescope() -> None:
    joint = robot_of("stroke:=0.2").joint_map["telescope_joint"]
    assert (joint.limit.upper, joint.safety_controller.soft_upper_limit) == (0.2, 0.2)
    plain = subprocess.check_output(["xacro", str(MODEL), "stroke:=0.2"])
    assert URDF.from_xml_string(plain).joint_map["telescope_joint"].limit.upper == 0.2


def test_fixed_telescope_is_in(standard: URDF) -> None:
    joint = robot_of("six_axis").joint_map["telescope_joint"]
    assert joint.type == "fixed"
    assert joint.origin.xyz == standard.joint_map["telescope_joint"].origin.xyz


@pytest.mark.parametrize(("length", "millimetres"), [("0.36", 360), ("0.52", 520)])
def test_flippers_have_the_meshes_of_their_length(length: str, millimetres: int) -> None:
    robot = robot_of(f"flipper_length:={length}")
    for end in ("front", "rear"):
        link = robot.link_map[f"{end}_left_flipper_link"]
        name = f"flipper_{end}_{millimetres}_"
        assert all(name in visual.geometry.filename for visual in link.visuals)
        assert name in link.collisions[0].geometry.filename


def test_only_the_named_cameras_are_there() -> None:
    links = set(robot_of("cameras:=mast front").link_map)
    frames = {name for name in links if "optical_frame" in name}
    assert frames == {"mast_camera_optical_frame", "front_camera_optical_frame"}
    assert not [name for name in robot_of("cameras:=none").link_map if "optical_frame" in name]


def test_only_the_declared_equipment_is_there() -> None:
    def frames(*words: str) -> Set[str]:
        links = set(robot_of(*words).link_map)
        ends = ("range_finder", "laser", "proximity", "microphone", "pad")
        return {
            link[: -len("_link")]
            for link in links
            if link.endswith(tuple(f"{e}_link" for e in ends))
        }

    lasers, pads = {"left_laser", "right_laser"}, {"left_pad", "right_pad"}
    assert frames() == {"range_finder", "microphone"} | lasers | pads
    assert frames("six_axis") == {"microphone"} | pads
    assert frames("inspection") == {"range_finder", "microphone"} | lasers
    assert frames("six_axis", "equipment:=proximity range_finder") == {"range_finder", "proximity"}
    assert not frames("equipment:=none")


def test_the_range_finder_looks_along_the_tools_axis(standard: URDF) -> None:
    for tool in (standard, robot_of("inspection")):
        sensor, flange = (
            tool.joint_map[f"{name}_link_fixed_joint"].origin for name in ("range_finder", "tool")
        )
        assert (sensor.rpy, flange.rpy) == ([0, 0, 0], [0, 0, 0])
        assert sensor.xyz[1:] == flange.xyz[1:] == [0, 0]
        assert sensor.xyz[0] <= flange.xyz[0]


def test_payload_weighs_and_stands_where_it_is_told(standard: URDF) -> None:
    robot = robot_of("payload_mass:=6", "payload_size:=0.1 0.2 0.3", "payload_xyz:=-0.1 0 0.31")
    payload = robot.link_map["payload_link"]
    assert payload.inertial.mass == 6
    assert payload.inertial.inertia.ixx == pytest.approx(6 / 12 * (0.2**2 + 0.3**2))
    assert payload.collisions[0].geometry.size == pytest.approx([0.1, 0.2, 0.3])
    joint = robot.joint_map["payload_link_fixed_joint"]
    assert (joint.type, joint.parent, joint.origin.xyz) == ("fixed", "base_link", [-0.1, 0, 0.31])
    assert "payload_link" not in standard.link_map


def test_root_without_mass_is_the_same_robot_otherwise(standard: URDF) -> None:
    robot = robot_of("--without-root-inertial")
    assert robot.link_map["base_link"].inertial is None
    assert sorted(robot.link_map) == sorted(standard.link_map)
    assert sorted(robot.joint_map) == sorted(standard.joint_map)
    assert all(robot.link_map[name].inertial for name in robot.link_map if name != "base_link")


def test_a_file_makes_a_variant_and_arguments_override_it(tmp_path: Path) -> None:
    file = tmp_path / "mine.yaml"
    file.write_text("tool: probe\nstroke: 0.1\ncameras: [front, mast]\n")
    robot = robot_of(str(file), "stroke:=0.25", "cameras:=")
    assert "probe_link" in robot.link_map
    assert robot.joint_map["telescope_joint"].limit.upper == 0.25
    assert "front_camera_link" in robot.link_map
    assert "rear_camera_link" not in robot.link_map


@pytest.mark.parametrize(
    "words",
    [
        ["stroke=0.2", "tool=probe", "cameras=[front,mast]"],
        ["stroke=0.2,tool=probe,cameras=[front,mast]"],
        ["stroke=0.2,", "tool:=probe", ",", "cameras=front mast"],
        ["stroke=0.2 tool=probe, cameras:=front mast"],
    ],
)
def test_arguments_for_a_roslaunch_command_line_say_the_same(words: List[str]) -> None:
    same = described(
        "six_axis", "telescope:=true", "stroke:=0.2", "tool:=probe", "cameras:=[front, mast]"
    )
    assert described("six_axis", "telescope=true", *words) == same


def test_a_path_may_hold_an_equals_sign(tmp_path: Path) -> None:
    folder = tmp_path / "a=b"
    folder.mkdir()
    (folder / "mine.yaml").write_text("tool: probe\n")
    assert described(str(folder / "mine.yaml")) == described("tool=probe")


def test_a_file_names_its_figures_from_where_it_stands(tmp_path: Path) -> None:
    (tmp_path / "mine.yaml").write_text("robot: figures.xacro\n")
    (tmp_path / "figures.xacro").write_text((PACKAGE / "config" / "robot.xacro").read_text())
    assert described(str(tmp_path / "mine.yaml")) == described("standard")


def test_other_figures_make_another_robot(tmp_path: Path) -> None:
    text = (PACKAGE / "config" / "robot.xacro").read_text()
    file = tmp_path / "robot.xacro"
    shipped = "telescope=dict(lower=0.0, upper=0.300"
    assert shipped in text
    file.write_text(text.replace(shipped, shipped.replace("0.300", "0.400")))
    robot = robot_of(f"robot:={file}", "stroke:=0.35")
    assert robot.joint_map["telescope_joint"].limit.upper == 0.35


# ---- what is refused


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ("stroke: 0.5", "stroke is 0.5; a number from 0.01 to 0.3 (m) is needed"),
        ("stroke: .nan", "stroke is nan; a number from 0.01 to 0.3 (m) is needed"),
        ("stroke: long", "stroke is 'long'; a number from 0.01 to 0.3 (m) is needed"),
        ("stroke: true", "stroke is True; a number from 0.01 to 0.3 (m) is needed"),
        ("telescope: 1", "telescope is 1; true or false is needed"),
        ("{telescope: false, stroke: 0.2}", "stroke is given, but telescope is false"),
        ("flipper_length: 0.4", "flipper_length is 0.4; there are meshes for 0.36, 0.44, 0.52 (m)"),
        ("flipper_length: .inf", "flipper_length is inf; a number from 0.36 to 0.52"),
        ("tool: hammer", "tool is 'hammer'; one of gripper, probe, none is needed"),
        ("tool: [probe]", "tool is ['probe']; one of gripper, probe, none is needed"),
        ("cameras: front front", "cameras is 'front front'; some of gripper arm turret front"),
        ("cameras: top", "cameras is 'top'; some of gripper arm turret front"),
        ("cameras: 3", "cameras is 3; some of gripper arm turret front"),
        ("payload_mass: -1", "payload_mass is -1; a number from 0 to 40 (kg) is needed"),
        ("payload_size: [1, 1]", "payload_size is [1, 1]; three numbers from 0.01 to 1 (m)"),
        ("payload_size: 0.1 0.1 0", "payload_size is '0.1 0.1 0'; three numbers from 0.01 to 1"),
        ("payload_xyz: [0, .nan, 0]", "payload_xyz is [0, nan, 0]; three numbers from -1 to 1 (m)"),
        ("robot: /no/such/file", "robot is '/no/such/file'; the path of a file of xacro"),
        ("colour: blue", "unknown key 'colour'; there are robot, telescope, stroke,"),
        ("[tool, probe]", "keys with values are needed, e.g. tool: probe"),
        ("tool: [", "no YAML"),
        ("tool: " + "[" * 4000, "no YAML: it is nested too deeply"),
        ("cameras: &a [*a]", "cameras is"),
    ],
)
def test_bad_file_is_refused_with_file_key_and_value(
    tmp_path: Path, keys: str, message: str
) -> None:
    file = tmp_path / "mine.yaml"
    file.write_text(keys)
    script = runpy.run_path(str(SCRIPT))
    with pytest.raises(script["VariantError"]) as refusal:
        script["arguments_of"](str(file), {})
    assert str(file) in str(refusal.value)
    assert message in str(refusal.value)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["seven_axis"], "variants.yaml: no variant 'seven_axis'; there are standard, six_axis"),
        (["/no/such.yaml"], "/no/such.yaml: cannot be read"),
        (["stroke:=1"], "argument: stroke is 1; a number from 0.01 to 0.3 (m) is needed"),
        (["colour:=blue"], "argument: unknown key 'colour'"),
        (["tool=probe,colour=blue"], "argument: unknown key 'colour'"),
        (["stroke=1"], "argument: stroke is 1; a number from 0.01 to 0.3 (m) is needed"),
        (["six_axis", "inspection"], "one variant at a time, not six_axis and inspection"),
    ],
)
def test_bad_arguments_are_refused_without_a_traceback(words: List[str], message: str) -> None:
    result = describe(*words)
    assert result.returncode != 0
    assert message in result.stderr
    assert "Traceback" not in result.stderr
    assert result.stdout == ""


def test_figures_that_are_none_are_refused(tmp_path: Path) -> None:
    file = tmp_path / "robot.xacro"
    file.write_text("this is no XML")
    result = describe(f"robot:={file}")
    assert result.returncode == 1
    assert f"robot is '{file}'; it has no figures of a robot" in result.stderr
    assert "Traceback" not in result.stderr


# ---- flippers


def outline(angle: float, length: float, hub: float, tip: float) -> float:
    """How far inwards (m) a flipper at an angle (rad) reaches from its pivot; positive outwards."""
    middle_line = angle - math.asin((hub - tip) / length)
    return min(-hub, length * math.cos(middle_line) - tip)


@pytest.mark.parametrize("length", ["0.36", "0.44", "0.52"])
def test_front_and_rear_flippers_cannot_meet_within_their_limits(length: str) -> None:
    robot = robot_of(f"flipper_length:={length}")
    reach = []
    for joint in robot.joints:
        if joint.name in ("front_left_flipper_joint", "rear_left_flipper_joint"):
            ends = (joint.limit.lower, joint.limit.upper)
            inwards = min(outline(angle, float(length), 0.110, 0.070) for angle in ends)
            reach.append(abs(joint.origin.xyz[0]) + inwards)
    assert len(reach) == 2
    assert min(reach) > 0.004
