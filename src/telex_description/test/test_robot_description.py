"""The robot model: complete names, plausible bodies, limits, transmissions, poses and cameras."""

from __future__ import annotations

import math
import subprocess
import sys
from itertools import combinations
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
SOFT_LIMITED = ARM_JOINTS + FINGER_JOINTS + FLIPPER_JOINTS
POSITIONED = SOFT_LIMITED + CAMERA_JOINTS
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
    "front_left_flipper_joint": (-2.0, 2.0, 0.6, 300),
    "left_finger_tip_joint": (-1.12, 0.10, 2.0, 12),
}
# Named poses: tool in base_link (m), its angle below the horizon (rad) or None.
TOOL = {
    "stow": ((0.06, 0.0, 0.689), None),
    "drive": ((0.06, 0.0, 0.689), None),
    "ready": ((0.80, 0.0, 0.30), math.radians(25)),
    "look_front": ((0.62, 0.0, 0.95), 0.0),
    "floor_pick": ((0.775, 0.0, -0.05), math.radians(70)),
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
        self.body = self.bullet.loadURDF(str(urdf_file), flags=pybullet.URDF_USE_SELF_COLLISION)
        indices = range(self.bullet.getNumJoints(self.body))
        infos = [self.bullet.getJointInfo(self.body, index) for index in indices]
        self.joints = {info[1].decode(): info[0] for info in infos}
        self.links = {info[12].decode(): info[0] for info in infos}
        self.parents = {info[0]: info[16] for info in infos}
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

    def overlaps(self) -> List[Tuple[str, str, float]]:
        """Return pairs of links, not parent and child, that overlap by more than 0.1 mm."""
        names = {-1: "base_link", **{index: name for name, index in self.links.items()}}
        shaped = [i for i in names if self.bullet.getCollisionShapeData(self.body, i)]
        found = []
        for first, second in combinations(shaped, 2):
            if self.parents.get(first) == second or self.parents.get(second) == first:
                continue
            points = self.bullet.getClosestPoints(self.body, self.body, 0.0, first, second)
            depth = min((point[8] for point in points), default=0.0)
            if depth < -1e-4:
                found.append((names[first], names[second], depth))
        return found


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
def test_joint_has_limits_and_no_explicit_damping(robot: URDF, name: str) -> None:
    joint = joint_named(robot, name)
    assert joint.limit.effort > 0
    assert joint.limit.velocity > 0
    assert joint.dynamics.damping == 0
    if name in TRACK_JOINTS:
        assert joint.type == "continuous"
    else:
        assert joint.limit.lower < joint.limit.upper


@pytest.mark.parametrize("name", sorted(DRIVES))
def test_drive_figures(robot: URDF, name: str) -> None:
    limit = joint_named(robot, name).limit
    assert (limit.lower, limit.upper, limit.velocity, limit.effort) == pytest.approx(DRIVES[name])


@pytest.mark.parametrize("name", SOFT_LIMITED)
def test_soft_limits_lie_within_hard_limits(robot: URDF, name: str) -> None:
    joint = joint_named(robot, name)
    soft = joint.safety_controller
    assert soft.k_position > 0
    assert soft.k_velocity > 0
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
        assert moments[0] + moments[1] >= moments[2] * (1 - 1e-9), link.name


def test_mass_is_75_kg(robot: URDF) -> None:
    assert sum(link.inertial.mass for link in robot.links) == pytest.approx(75.0, rel=0.05)


def test_pybullet_finds_the_same_mass(robot: URDF, loaded: LoadedRobot) -> None:
    assert loaded.mass() == pytest.approx(sum(link.inertial.mass for link in robot.links), abs=1e-6)


def test_pybullet_keeps_every_inertia(loaded: LoadedRobot) -> None:
    # PyBullet sets an impossible inertia to zero and goes on.
    for name, index in loaded.links.items():
        assert min(loaded.bullet.getDynamicsInfo(loaded.body, index)[2]) > 0, name


@pytest.mark.parametrize("corner", CORNERS)
def test_flipper_at_zero_lies_flat_on_the_floor(robot: URDF, corner: str) -> None:
    (collision,) = robot.link_map[f"{corner}_flipper_link"].collisions
    file = Path(collision.geometry.filename.replace(MESH_ADDRESS, str(PACKAGE)))
    lines = [line.split() for line in file.read_text().splitlines()]
    vertices = np.array([line[1:] for line in lines if line[0] == "v"], dtype=float)
    vertices += joint_named(robot, f"{corner}_flipper_joint").origin.xyz
    lowest = vertices[:, 2].min()
    assert lowest == pytest.approx(-0.110, abs=1e-5)
    touching = vertices[vertices[:, 2] < lowest + 1e-5]
    assert np.ptp(touching[:, 0]) == pytest.approx(math.sqrt(0.44**2 - 0.04**2), abs=1e-4)
    assert np.abs(vertices[:, 1]).max() == pytest.approx(0.200, abs=1e-5)


def test_hull_script_writes_what_is_in_the_repository(tmp_path: Path) -> None:
    script = PACKAGE / "scripts" / "make_flipper_hull"
    subprocess.run([sys.executable, str(script), "--output", str(tmp_path)], check=True)
    for end in ("front", "rear"):
        name = f"flipper_{end}.obj"
        assert (tmp_path / name).read_bytes() == (PACKAGE / "meshes" / name).read_bytes()


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
        assert set(camera) == {
            "frame",
            "width",
            "height",
            "horizontal_fov",
            "near",
            "far",
            "rate",
            "jpeg_quality",
        }
        assert camera["frame"] == f"{name}_camera_optical_frame"
        assert camera["frame"] in robot.link_map
        assert 0 < camera["horizontal_fov"] < math.pi
        assert 0 < camera["near"] < camera["far"]
        assert camera["rate"] > 0
        assert 1 <= camera["jpeg_quality"] <= 100


# ---- poses


def test_poses_name_every_positioned_joint() -> None:
    poses = read_yaml("poses.yaml")["poses"]
    assert set(poses) == set(TOOL)
    for name, pose in poses.items():
        assert sorted(pose) == sorted(POSITIONED), name


def test_poses_lie_within_the_soft_limits(robot: URDF) -> None:
    for pose_name, pose in read_yaml("poses.yaml")["poses"].items():
        for name, position in pose.items():
            joint = joint_named(robot, name)
            lower, upper = joint.limit.lower, joint.limit.upper
            if joint.safety_controller is not None:
                lower = joint.safety_controller.soft_lower_limit
                upper = joint.safety_controller.soft_upper_limit
            assert lower <= position <= upper, f"{pose_name}: {name}"


def test_fingers_stay_parallel_in_the_poses() -> None:
    for pose in read_yaml("poses.yaml")["poses"].values():
        for side in SIDES:
            base, middle, tip = (
                pose[f"{side}_finger_{part}_joint"] for part in ("base", "middle", "tip")
            )
            assert (middle, tip) == pytest.approx((base, -2 * base))


@pytest.mark.parametrize("name", sorted(TOOL))
def test_tool_is_where_the_pose_says(loaded: LoadedRobot, name: str) -> None:
    expected_position, expected_pitch = TOOL[name]
    loaded.move(read_yaml("poses.yaml")["poses"][name])
    position, rotation = loaded.frame("tool_link")
    assert position == pytest.approx(expected_position, abs=0.01)
    if expected_pitch is not None:
        assert -math.asin(rotation[2, 0]) == pytest.approx(expected_pitch, abs=0.01)


@pytest.mark.parametrize("name", sorted(TOOL))
def test_no_link_reaches_into_another_in_the_poses(loaded: LoadedRobot, name: str) -> None:
    loaded.move(read_yaml("poses.yaml")["poses"][name])
    assert loaded.overlaps() == []


@pytest.mark.parametrize("opening", [-0.04, 0.0, 0.3, 0.55])
def test_pads_open_parallel_and_symmetric(loaded: LoadedRobot, opening: float) -> None:
    for side in SIDES:
        loaded.move({f"{side}_finger_base_joint": opening})
        loaded.move({f"{side}_finger_middle_joint": opening})
        loaded.move({f"{side}_finger_tip_joint": -2 * opening})
    tool_position, tool = loaded.frame("tool_link")
    left_position, left = loaded.frame("left_finger_tip_link")
    right_position, right = loaded.frame("right_finger_tip_link")
    assert left == pytest.approx(tool, abs=1e-6)
    assert right == pytest.approx(tool, abs=1e-6)
    left_offset = tool.T @ (left_position - tool_position)
    right_offset = tool.T @ (right_position - tool_position)
    assert left_offset == pytest.approx(right_offset * [1, -1, 1], abs=1e-6)
    # Closed, both links of a finger lean in by 25 degrees; the middle one turns with the base.
    first = math.radians(25) - opening
    second = math.radians(25) - 2 * opening
    pivot = 0.065 - 0.045 * math.sin(first) - 0.075 * math.sin(second)
    assert left_offset[1] == pytest.approx(pivot, abs=1e-6)
