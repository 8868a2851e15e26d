"""The URDF of the standard robot: complete names, plausible bodies, limits, cameras, lamps."""

from __future__ import annotations

import math
import subprocess
from pathlib import Path
from typing import Dict, Iterator, List, Tuple
from xml.etree import ElementTree

import numpy as np
import pybullet
import pytest
import yaml
from pybullet_utils.bullet_client import BulletClient
from urdf_parser_py.urdf import URDF, Joint

PACKAGE = Path(__file__).resolve().parents[1]
MODEL = PACKAGE / "urdf" / "telex.urdf.xacro"
MESH_ADDRESS = "package://telex_description"

CAMERAS = ("gripper", "arm", "turret", "front", "rear", "mast")
EQUIPMENT = ("range_finder", "left_laser", "right_laser", "microphone", "left_pad", "right_pad")
LAMPS = ("front_left", "front_right", "rear_left", "rear_right", "turret_camera", "gripper")
SIDES = ("left", "right")
CORNERS = [f"{end}_{side}" for end in ("front", "rear") for side in SIDES]
ARM_JOINTS = [
    f"{name}_joint"
    for name in (
        "turret",
        "shoulder",
        "telescope",
        "elbow",
        "forearm_roll",
        "wrist_pitch",
        "gripper_roll",
    )
]
FINGER_JOINTS = [
    f"{side}_finger_{part}_joint" for side in SIDES for part in ("base", "middle", "tip")
]
FLIPPER_JOINTS = [f"{corner}_flipper_joint" for corner in CORNERS]
TRACK_JOINTS = [f"{corner}_track_joint" for corner in CORNERS]
CAMERA_JOINTS = ["turret_camera_pan_joint", "turret_camera_tilt_joint"]
POSITIONED = ARM_JOINTS + FINGER_JOINTS + FLIPPER_JOINTS + CAMERA_JOINTS
MOVABLE = POSITIONED + TRACK_JOINTS
LINKS = (
    [
        "base_link",
        "turret_link",
        "upper_arm_link",
        "telescope_link",
        "elbow_link",
        "forearm_link",
        "wrist_link",
        "gripper_link",
        "tool_link",
        "imu_link",
        "turret_camera_pan_link",
        "turret_camera_tilt_link",
    ]
    + [joint.replace("_joint", "_link") for joint in FINGER_JOINTS + FLIPPER_JOINTS + TRACK_JOINTS]
    + [f"{camera}_camera_link" for camera in CAMERAS]
    + [f"{camera}_camera_optical_frame" for camera in CAMERAS]
    + [f"{lamp}_lamp_link" for lamp in LAMPS]
    + [f"{each}_link" for each in EQUIPMENT]
)
# Drives: lower, upper (rad, m), velocity (rad/s, m/s), effort (N m, N).
DRIVES = {
    "turret_joint": (-math.radians(200), math.radians(200), 0.628, 120),
    "shoulder_joint": (-math.radians(170), math.radians(60), 0.314, 350),
    "telescope_joint": (0.0, 0.30, 0.05, 600),
    "elbow_joint": (-math.radians(170), math.radians(170), 0.628, 180),
    "forearm_roll_joint": (-math.radians(200), math.radians(200), 1.257, 60),
    "wrist_pitch_joint": (-math.radians(130), math.radians(130), 1.361, 80),
    "gripper_roll_joint": (-2 * math.pi, 2 * math.pi, 1.292, 40),
    "front_left_flipper_joint": (-1.9, 2.0, 1.0, 300),
    "left_finger_tip_joint": (-1.12, 0.10, 2.0, 12),
}


def read_yaml(name: str) -> Dict:
    return yaml.safe_load((PACKAGE / "config" / name).read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def urdf_text() -> str:
    return subprocess.run(
        ["xacro", str(MODEL)], check=True, stdout=subprocess.PIPE, text=True
    ).stdout


@pytest.fixture(scope="module")
def robot(urdf_text: str) -> URDF:
    return URDF.from_xml_string(urdf_text.encode())


class LoadedRobot:
    """The robot in a PyBullet world of its own, base_link at the origin."""

    def __init__(self, urdf_file: Path) -> None:
        self.bullet = BulletClient(pybullet.DIRECT)
        flags = pybullet.URDF_USE_SELF_COLLISION | pybullet.URDF_USE_INERTIA_FROM_FILE
        self.body = self.bullet.loadURDF(str(urdf_file), flags=flags)
        indices = range(self.bullet.getNumJoints(self.body))
        infos = [self.bullet.getJointInfo(self.body, index) for index in indices]
        self.joints = {info[1].decode(): info[0] for info in infos}
        self.links = {info[12].decode(): info[0] for info in infos}
        # PyBullet places the centre of mass; the link frame is wanted.
        dynamics = self.bullet.getDynamicsInfo(self.body, -1)
        base = self.bullet.getBasePositionAndOrientation(self.body)
        centre_to_frame = self.bullet.invertTransform(dynamics[3], dynamics[4])
        self.world_to_base = self.bullet.invertTransform(
            *self.bullet.multiplyTransforms(*base, *centre_to_frame)
        )

    def mass(self) -> float:
        links = [-1, *self.links.values()]
        return sum(self.bullet.getDynamicsInfo(self.body, link)[0] for link in links)

    def move(self, positions: Dict[str, float]) -> None:
        for name, position in positions.items():
            self.bullet.resetJointState(self.body, self.joints[name], position)

    def frame(self, link: str) -> Tuple[np.ndarray, np.ndarray]:
        """Return a link's position and rotation matrix in base_link."""
        state = self.bullet.getLinkState(self.body, self.links[link], computeForwardKinematics=True)
        position, quaternion = self.bullet.multiplyTransforms(
            *self.world_to_base, state[4], state[5]
        )
        rotation = np.reshape(self.bullet.getMatrixFromQuaternion(quaternion), (3, 3))
        return np.array(position), rotation


@pytest.fixture(scope="module")
def loaded(urdf_text: str, tmp_path_factory: pytest.TempPathFactory) -> Iterator[LoadedRobot]:
    file = tmp_path_factory.mktemp("urdf") / "telex.urdf"
    file.write_text(urdf_text.replace(MESH_ADDRESS, str(PACKAGE)), encoding="utf-8")
    robot = LoadedRobot(file)
    yield robot
    robot.bullet.disconnect()


def movable_joints(robot: URDF) -> List[Joint]:
    return [joint for joint in robot.joints if joint.type != "fixed"]


def joint_named(robot: URDF, name: str) -> Joint:
    return robot.joint_map[name]


def rotation_of(rpy: List[float]) -> np.ndarray:
    """Return the rotation matrix of URDF's fixed-axis roll, pitch, yaw."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy), np.sin(rpy)
    about_x = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    about_y = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    about_z = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    return about_z @ about_y @ about_x


# ---- names and syntax


def test_check_urdf_accepts_it(urdf_text: str, tmp_path: Path) -> None:
    file = tmp_path / "telex.urdf"
    file.write_text(urdf_text, encoding="utf-8")
    result = subprocess.run(["check_urdf", str(file)], capture_output=True, check=False)
    assert result.returncode == 0, result.stderr.decode()
    assert result.stderr == b""
    assert b"root Link: base_link" in result.stdout


def test_links_are_exactly_those_of_the_contract(robot: URDF) -> None:
    assert sorted(link.name for link in robot.links) == sorted(LINKS)


def test_movable_joints_are_exactly_those_of_the_contract(robot: URDF) -> None:
    assert sorted(joint.name for joint in movable_joints(robot)) == sorted(MOVABLE)


def test_every_mesh_exists(urdf_text: str) -> None:
    addresses = {mesh.attrib["filename"] for mesh in ElementTree.fromstring(urdf_text).iter("mesh")}
    assert addresses
    for address in addresses:
        assert address.startswith(MESH_ADDRESS)
        assert Path(address.replace(MESH_ADDRESS, str(PACKAGE))).is_file()


def test_every_material_is_defined(robot: URDF) -> None:
    defined = {material.name for material in robot.materials}
    used = {visual.material.name for link in robot.links for visual in link.visuals}
    assert used <= defined


def test_other_figures_make_another_robot(tmp_path: Path) -> None:
    figures = (PACKAGE / "config" / "robot.xacro").read_text(encoding="utf-8")
    variant = tmp_path / "robot.xacro"
    variant.write_text(
        figures.replace('"wrist_pitch_x" value="0.360"', '"wrist_pitch_x" value="0.5"')
    )
    text = subprocess.check_output(["xacro", str(MODEL), f"robot:={variant}"], text=True)
    longer = URDF.from_xml_string(text.encode())
    assert joint_named(longer, "wrist_pitch_joint").origin.xyz[0] == pytest.approx(0.5)


# ---- joints


@pytest.mark.parametrize("name", MOVABLE)
def test_joint_has_limits_friction_and_damping(robot: URDF, name: str) -> None:
    joint = joint_named(robot, name)
    assert joint.limit.effort > 0
    assert joint.limit.velocity > 0
    assert joint.dynamics.friction > 0
    assert joint.dynamics.damping > 0
    # what friction takes leaves most of the drive's effort
    lost = joint.dynamics.friction + joint.dynamics.damping * joint.limit.velocity
    assert lost < 0.15 * joint.limit.effort
    assert joint.safety_controller.k_position > 0
    assert joint.safety_controller.k_velocity > 0
    if name in TRACK_JOINTS:
        assert joint.type == "continuous"
    else:
        assert joint.limit.lower < joint.limit.upper


@pytest.mark.parametrize("name", sorted(DRIVES))
def test_drive_figures(robot: URDF, name: str) -> None:
    limit = joint_named(robot, name).limit
    assert (limit.lower, limit.upper, limit.velocity, limit.effort) == pytest.approx(DRIVES[name])


@pytest.mark.parametrize("name", POSITIONED)
def test_soft_limits_lie_within_hard_limits(robot: URDF, name: str) -> None:
    joint = joint_named(robot, name)
    soft = joint.safety_controller
    assert joint.limit.lower <= soft.soft_lower_limit < soft.soft_upper_limit <= joint.limit.upper


def test_each_movable_joint_has_one_transmission_of_its_kind(urdf_text: str) -> None:
    interfaces: Dict[str, List[str]] = {}
    for transmission in ElementTree.fromstring(urdf_text).findall("transmission"):
        assert transmission.findtext("type") == "transmission_interface/SimpleTransmission"
        assert float(transmission.findtext("actuator/mechanicalReduction") or 0) != 0
        for joint in transmission.findall("joint"):
            kinds = [element.text or "" for element in joint.findall("hardwareInterface")]
            interfaces.setdefault(joint.attrib["name"], []).extend(kinds)
    expected = {name: ["hardware_interface/EffortJointInterface"] for name in POSITIONED}
    expected.update({name: ["hardware_interface/VelocityJointInterface"] for name in TRACK_JOINTS})
    assert interfaces == expected


@pytest.mark.parametrize("corner", CORNERS)
def test_positive_flipper_angle_raises_the_tip(loaded: LoadedRobot, corner: str) -> None:
    loaded.move({joint: 0.0 for joint in FLIPPER_JOINTS})
    outwards = 1.0 if corner.startswith("front") else -1.0
    loaded.move({f"{corner}_flipper_joint": math.pi / 2})
    _, rotation = loaded.frame(f"{corner}_flipper_link")
    tip = rotation @ np.array([outwards, 0.0, 0.0])
    assert tip == pytest.approx([0.0, 0.0, 1.0], abs=1e-6)


@pytest.mark.parametrize("name", TRACK_JOINTS)
def test_belts_turn_about_y_at_the_flipper_pivot(robot: URDF, name: str) -> None:
    joint = joint_named(robot, name)
    assert joint.parent == name.replace("track_joint", "flipper_link")
    assert joint.axis == [0, 1, 0]
    assert joint.origin.xyz == [0, 0, 0]


# ---- bodies


def test_inertias_are_those_of_real_bodies(robot: URDF) -> None:
    for link in robot.links:
        inertial = link.inertial
        assert inertial is not None, f"{link.name} has none: PyBullet would make it 1 kg"
        assert inertial.mass > 0
        moments = np.linalg.eigvalsh(np.array(inertial.inertia.to_matrix()))
        assert moments[0] > 0, link.name
        assert moments[0] + moments[1] >= moments[2] * (1 - 1e-6), link.name
        # No part of a link is further from its centre than the robot is long.
        assert moments[2] < inertial.mass * 0.5**2 + 1e-8, link.name


def test_mass_is_75_kg(robot: URDF) -> None:
    assert sum(link.inertial.mass for link in robot.links) == pytest.approx(75.0, rel=0.05)


def test_pybullet_finds_the_same_mass(robot: URDF, loaded: LoadedRobot) -> None:
    assert loaded.mass() == pytest.approx(sum(link.inertial.mass for link in robot.links), abs=1e-6)


def test_pybullet_has_the_mass_of_every_link(robot: URDF, loaded: LoadedRobot) -> None:
    for name, index in {"base_link": -1, **loaded.links}.items():
        mass = loaded.bullet.getDynamicsInfo(loaded.body, index)[0]
        assert mass == pytest.approx(robot.link_map[name].inertial.mass, rel=1e-6), name


def test_pybullet_has_the_principal_moments_of_every_link(robot: URDF, loaded: LoadedRobot) -> None:
    # PyBullet sets an impossible inertia to zero and goes on.
    for name, index in {"base_link": -1, **loaded.links}.items():
        tensor = np.array(robot.link_map[name].inertial.inertia.to_matrix())
        found = sorted(loaded.bullet.getDynamicsInfo(loaded.body, index)[2])
        assert found == pytest.approx(np.linalg.eigvalsh(tensor), rel=1e-3), name


@pytest.mark.parametrize("corner", CORNERS)
def test_flipper_at_zero_lies_flat_on_the_floor(robot: URDF, corner: str) -> None:
    lines = [
        line.split()
        for collision in robot.link_map[f"{corner}_flipper_link"].collisions
        for line in Path(collision.geometry.filename.replace(MESH_ADDRESS, str(PACKAGE)))
        .read_text()
        .splitlines()
    ]
    vertices = np.array([line[1:] for line in lines if line[0] == "v"], dtype=float)
    vertices += joint_named(robot, f"{corner}_flipper_joint").origin.xyz
    lowest = vertices[:, 2].min()
    assert lowest == pytest.approx(-0.110, abs=1e-5)
    touching = vertices[vertices[:, 2] < lowest + 1e-5]
    assert np.ptp(touching[:, 0]) == pytest.approx(math.sqrt(0.44**2 - 0.04**2), abs=1e-4)
    assert np.abs(vertices[:, 1]).max() == pytest.approx(0.200, abs=1e-5)


# ---- cameras and frames


@pytest.mark.parametrize("camera", CAMERAS)
def test_optical_frame_looks_along_x_of_the_camera(robot: URDF, camera: str) -> None:
    joint = joint_named(robot, f"{camera}_camera_optical_frame_fixed_joint")
    assert joint.parent == f"{camera}_camera_link"
    rotation = rotation_of(joint.origin.rpy)
    right, down, forward = rotation.T
    assert forward == pytest.approx([1, 0, 0], abs=1e-9)
    assert right == pytest.approx([0, -1, 0], abs=1e-9)
    assert down == pytest.approx([0, 0, -1], abs=1e-9)


def test_cameras_look_where_their_names_say(loaded: LoadedRobot) -> None:
    loaded.move({name: 0.0 for name in POSITIONED})
    _, front = loaded.frame("front_camera_optical_frame")
    _, rear = loaded.frame("rear_camera_optical_frame")
    assert front[:, 2] == pytest.approx([math.cos(0.2094), 0, -math.sin(0.2094)], abs=1e-3)
    assert rear[:, 2] == pytest.approx([-math.cos(0.2094), 0, -math.sin(0.2094)], abs=1e-3)
    loaded.move({"turret_camera_pan_joint": math.pi / 2, "turret_camera_tilt_joint": 0.5})
    _, turret = loaded.frame("turret_camera_optical_frame")
    assert turret[:, 2] == pytest.approx([0, math.cos(0.5), -math.sin(0.5)], abs=1e-6)


def test_camera_table_is_complete_and_sound(robot: URDF) -> None:
    table = read_yaml("cameras.yaml")["cameras"]
    assert sorted(table) == sorted(CAMERAS)
    for name, camera in table.items():
        assert set(camera) - {"zoom_max"} == {
            "frame",
            "role",
            "width",
            "height",
            "horizontal_fov",
            "near",
            "far",
            "distortion",
            "vignetting",
            "detail",
            "rate",
            "jpeg_quality",
            "exposure",
            "noise",
        }
        assert ("zoom_max" in camera) is (name == "turret")
        assert camera["frame"] == f"{name}_camera_optical_frame"
        assert camera["frame"] in robot.link_map
        assert 0 < camera["horizontal_fov"] < math.pi
        assert 0 < camera["near"] < camera["far"]
        assert camera["rate"] > 0
        assert 1 <= camera["jpeg_quality"] <= 100
    assert table["turret"]["zoom_max"] > 1


@pytest.mark.parametrize("end", [1, -1])
def test_hull_lamps_shine_along_x_of_their_frames(loaded: LoadedRobot, end: int) -> None:
    name = "front" if end > 0 else "rear"
    for side, y in (("left", 1), ("right", -1)):
        position, rotation = loaded.frame(f"{name}_{side}_lamp_link")
        assert np.sign(position[:2]).tolist() == [end, y]
        beam = rotation[:, 0]
        assert beam[0] * end > 0.98
        assert beam[1] == pytest.approx(0, abs=1e-6)
        assert beam[2] < 0


def test_lamp_table_is_complete_and_sound(robot: URDF) -> None:
    lamps = read_yaml("lamps.yaml")["lamps"]
    table = {name: lamp for name, lamp in lamps.items() if not lamp.get("beam")}
    assert sorted(table) == sorted(LAMPS)
    for name, lamp in table.items():
        assert set(lamp) == {"frame", "angle", "intensity", "reach", "color", "level"}
        assert lamp["frame"] == f"{name}_lamp_link"
        assert lamp["frame"] in robot.link_map
        assert 0 < lamp["angle"] < math.pi
        assert lamp["intensity"] > 0
        assert lamp["reach"] > 0
        assert len(lamp["color"]) == 3
        assert all(0 <= value <= 1 for value in lamp["color"])
        assert lamp["level"] == 0, "the robot starts with its lamps off"
    lasers = {name: lamps[name] for name in sorted(set(lamps) - set(table))}
    assert {name: lamp["frame"] for name, lamp in lasers.items()} == {
        "laser_left": "left_laser_link",
        "laser_right": "right_laser_link",
    }
    assert not any(lamp["level"] for lamp in lasers.values())
