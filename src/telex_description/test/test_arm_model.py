"""Turret, arm and gripper: shapes, masses, the gripper's geometry and force, variants."""

from __future__ import annotations

import math
import subprocess
from typing import Dict, List

import numpy as np
import pytest
from assembly import Assembly
from shipped_robot import PACKAGE, expanded
from telex_cad import tools
from telex_cad.figures import Figures
from telex_cad.link_model import LinkModel
from telex_cad.upper import arm, gripper, turret
from urdf_parser_py.urdf import URDF, Box, Collision, Cylinder

from telex_control.common.geometry.matrices import rotation_from_rpy

pytestmark = pytest.mark.slow

SIDES = ("left", "right")
PARTS = {"base": 1, "middle": 1, "tip": -2}
MASSES = {
    "turret_link": 5.1,
    "turret_camera_pan_link": 0.15,
    "turret_camera_tilt_link": 0.25,
    "upper_arm_link": 4.5,
    "telescope_link": 2.2,
    "elbow_link": 1.8,
    "forearm_link": 1.6,
    "wrist_link": 1.0,
    "gripper_link": 0.8,
    **{
        f"{side}_finger_{part}_link": mass
        for side in SIDES
        for part, mass in (("base", 0.08), ("middle", 0.12), ("tip", 0.10))
    },
}
# Closing force at the pads (N), and what the drives together may reach at most
FORCE, MOST_FORCE = 250.0, 300.0
OPENINGS = np.linspace(0.0, 0.555, 19)
PROTRUSION = 0.015
# Hoses and cables may stand out further from the collision shapes.
TURRET_PROTRUSION = 0.020


@pytest.fixture(scope="module")
def models(figures: Figures) -> Dict[str, LinkModel]:
    links = [*turret.links(figures), *arm.links(figures), *gripper.links(figures)]
    return {link.name: link for link in links}


@pytest.fixture(scope="module")
def assembly(robot: URDF, models: Dict[str, LinkModel]) -> Assembly:
    return Assembly(robot, models)


def fingers(opening: float) -> Dict[str, float]:
    """Return the finger joints for one coupled angle (rad)."""
    return {
        f"{side}_finger_{part}_joint": ratio * opening
        for side in SIDES
        for part, ratio in PARTS.items()
    }


# ---- solids


def test_masses_are_those_of_the_budget(robot: URDF, models: Dict[str, LinkModel]) -> None:
    assert {name: model.mass for name, model in models.items()} == MASSES
    for name, mass in MASSES.items():
        assert robot.link_map[name].inertial.mass == pytest.approx(mass), name


def test_arm_has_at_most_20_000_triangles(models: Dict[str, LinkModel]) -> None:
    triangles = {
        name: sum(solid.num_tri() for solid in model.merged().values())
        for name, model in models.items()
    }
    assert sum(triangles.values()) <= 20_000, triangles


@pytest.mark.parametrize(
    "positions",
    [
        {},
        {"telescope_joint": 0.15},
        {"telescope_joint": 0.30},
        {"shoulder_joint": math.radians(60), "elbow_joint": math.radians(170)},
        {"shoulder_joint": math.radians(-170), "elbow_joint": math.radians(-170)},
        {"wrist_pitch_joint": math.radians(130), "turret_camera_tilt_joint": math.radians(60)},
        {"wrist_pitch_joint": math.radians(-130), "turret_camera_tilt_joint": math.radians(-45)},
        {"forearm_roll_joint": 1.0, "gripper_roll_joint": 0.7, "turret_camera_pan_joint": 1.2},
        *(fingers(opening) for opening in (-0.05, 0.14, 0.28, 0.42, 0.56)),
    ],
)
def test_no_joint_drives_a_link_into_its_neighbour(
    assembly: Assembly, positions: Dict[str, float]
) -> None:
    # Less than a tenth of a drop: what rounding leaves where surfaces slide on each other.
    assert assembly.adjacent_overlaps(positions, above=5e-9) == []


def test_slide_stays_in_the_tube_over_the_whole_stroke(
    robot: URDF, models: Dict[str, LinkModel]
) -> None:
    stroke = robot.joint_map["telescope_joint"].limit.upper
    mouth = robot.joint_map["telescope_joint"].origin.xyz[0]
    slide = models["telescope_link"].merged()["metal"].bounding_box()
    assert mouth + slide[0] > 0.046
    assert slide[0] + stroke < -0.040


# ---- collision shapes


def distance_to(collision: Collision, points: np.ndarray) -> np.ndarray:
    """Return how far points (N x 3, link frame) lie outside a box or cylinder (m)."""
    origin = collision.origin
    if origin is not None:
        points = (points - (origin.xyz or [0, 0, 0])) @ rotation_from_rpy(origin.rpy or (0, 0, 0))
    shape = collision.geometry
    if isinstance(shape, Box):
        beyond = np.abs(points) - np.array(shape.size) / 2
    else:
        assert isinstance(shape, Cylinder)
        radial = np.hypot(points[:, 0], points[:, 1]) - shape.radius
        beyond = np.column_stack([radial, np.abs(points[:, 2]) - shape.length / 2])
    return np.linalg.norm(np.maximum(beyond, 0.0), axis=1)


def greatest_protrusion(collisions: List[Collision], model: LinkModel) -> float:
    """Return how far the solids of a link stand out of its collision shapes at most (m)."""
    solids = model.merged().values()
    points = np.vstack([np.asarray(solid.to_mesh().vert_properties)[:, :3] for solid in solids])
    return np.min([distance_to(collision, points) for collision in collisions], axis=0).max()


@pytest.mark.parametrize("name", sorted(MASSES))
def test_what_is_seen_hardly_stands_out_of_the_collision_shapes(
    robot: URDF, models: Dict[str, LinkModel], name: str
) -> None:
    collisions = robot.link_map[name].collisions
    assert 1 <= len(collisions) <= 8
    allowed = TURRET_PROTRUSION if name == "turret_link" else PROTRUSION
    assert greatest_protrusion(collisions, models[name]) <= allowed


@pytest.mark.parametrize("side", SIDES)
def test_pads_and_their_collision_boxes_have_the_same_face(
    robot: URDF, models: Dict[str, LinkModel], side: str
) -> None:
    name = f"{side}_finger_tip_link"
    (collision,) = robot.link_map[name].collisions
    sign = 1 if side == "left" else -1
    face = collision.origin.xyz[1] - sign * collision.geometry.size[1] / 2
    rubber = models[name].merged()["rubber"].bounding_box()
    seen = rubber[1] if side == "left" else rubber[4]
    assert seen == pytest.approx(face, abs=1e-5)


# ---- gripper


def pad_faces(robot: URDF, assembly: Assembly, opening: float) -> List[np.ndarray]:
    """Return the 4x4 poses, in the palm's frame, of the middles of both pads' faces."""
    frames = assembly.frames(fingers(opening))
    palm = np.linalg.inv(frames["gripper_link"])
    poses = []
    for side, sign in (("left", 1), ("right", -1)):
        (collision,) = robot.link_map[f"{side}_finger_tip_link"].collisions
        centre = np.eye(4)
        centre[:3, 3] = collision.origin.xyz
        centre[1, 3] -= sign * collision.geometry.size[1] / 2
        poses.append(palm @ frames[f"{side}_finger_tip_link"] @ centre)
    return poses


def opening_by_formula(figures: Figures, angle: float) -> float:
    """Return the distance of the pads (m): a link's end moves by L (sin lean - sin(lean - q))."""
    finger = figures.finger
    lean = finger["lean"]
    base = finger["base"] * (math.sin(lean) - math.sin(lean - angle))
    middle = finger["middle"] * (math.sin(lean) - math.sin(lean - 2 * angle))
    return 2 * (base + middle)


@pytest.mark.parametrize("opening", OPENINGS)
def test_pads_open_parallel_by_the_formula(
    robot: URDF, assembly: Assembly, figures: Figures, opening: float
) -> None:
    left, right = pad_faces(robot, assembly, opening)
    assert left[:3, :3] == pytest.approx(np.eye(3), abs=1e-6)
    assert right[:3, :3] == pytest.approx(np.eye(3), abs=1e-6)
    assert left[1, 3] - right[1, 3] == pytest.approx(opening_by_formula(figures, opening), abs=1e-6)
    placed = assembly.placed(fingers(opening))
    seen = placed["left_finger_tip_link"].min_gap(placed["right_finger_tip_link"], 0.3)
    assert seen == pytest.approx(opening_by_formula(figures, opening), abs=1e-3)


def test_gripper_opens_from_0_to_20_cm(robot: URDF, figures: Figures) -> None:
    joint = robot.joint_map["left_finger_base_joint"]
    assert opening_by_formula(figures, 0.0) == 0.0
    assert opening_by_formula(figures, joint.safety_controller.soft_upper_limit) >= 0.200


def test_pads_stay_at_the_tool(robot: URDF, assembly: Assembly) -> None:
    frames = assembly.frames({})
    tool = np.linalg.inv(frames["gripper_link"]) @ frames["tool_link"]
    for opening in OPENINGS:
        for pad in pad_faces(robot, assembly, opening):
            assert pad[0, 3] == pytest.approx(tool[0, 3], abs=0.010)
            assert pad[2, 3] == pytest.approx(0.0, abs=1e-9)


def lever_arms(robot: URDF, assembly: Assembly, side: str, opening: float) -> Dict[str, float]:
    """Return dy/dq of the pad's centre for each joint of a finger (m): the column of J for y.

    By central differences of the forward kinematics, one joint at a time. J^T F gives the efforts.
    """
    index, step = SIDES.index(side), 1e-6
    arms = {}
    for part in PARTS:
        joint = f"{side}_finger_{part}_joint"
        centre = pad_faces(robot, assembly, opening)[index][:3, 3]
        # The point is fixed to the pad, which turns with the joint.
        frames = assembly.frames(fingers(opening))
        tip = np.linalg.inv(frames["gripper_link"]) @ frames[f"{side}_finger_tip_link"]
        in_tip = np.linalg.inv(tip) @ [*centre, 1.0]
        moved = []
        for sign in (1, -1):
            positions = fingers(opening)
            positions[joint] += sign * step
            frames = assembly.frames(positions)
            pose = np.linalg.inv(frames["gripper_link"]) @ frames[f"{side}_finger_tip_link"]
            moved.append((pose @ in_tip)[1])
        arms[joint] = (moved[0] - moved[1]) / (2 * step)
    return arms


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("opening", OPENINGS)
def test_efforts_press_with_250_n_and_no_more_than_300(
    robot: URDF, assembly: Assembly, side: str, opening: float
) -> None:
    arms = lever_arms(robot, assembly, side, opening)
    for joint, arm_length in arms.items():
        needed = abs(arm_length) * FORCE
        assert needed <= robot.joint_map[joint].limit.effort, joint
    reached = min(robot.joint_map[j].limit.effort / abs(length) for j, length in arms.items())
    assert FORCE <= reached <= MOST_FORCE


# ---- cameras, lamps


@pytest.mark.parametrize(
    ("camera", "link"),
    [("gripper", "gripper_link"), ("arm", "elbow_link"), ("turret", "turret_camera_tilt_link")],
)
def test_camera_sits_at_its_lens_and_looks_past_its_own_link(
    assembly: Assembly, camera: str, link: str
) -> None:
    frames = assembly.frames({})
    pose = np.linalg.inv(frames[link]) @ frames[f"{camera}_camera_link"]
    solid = assembly.solids[link]
    eye, forward = pose[:3, 3], pose[:3, 0]
    # The glass ends just behind the frame ...
    assert solid.ray_cast(tuple(eye), tuple(eye - 0.010 * forward))
    # ... and no ray of a 70 x 50 degree view meets the link beyond the near plane.
    for across in np.linspace(-0.7, 0.7, 9):
        for up in np.linspace(-0.46, 0.46, 7):
            ray = pose[:3, :3] @ [1.0, across, up]
            start, end = eye + 0.020 * ray, eye + 0.5 * ray
            assert not solid.ray_cast(tuple(start), tuple(end)), (across, up)


@pytest.mark.parametrize(
    ("lamp", "link"),
    [
        ("turret_camera_lamp_link", "turret_camera_tilt_link"),
        ("gripper_lamp_link", "gripper_link"),
    ],
)
def test_lamp_frame_lies_on_its_light(
    robot: URDF, assembly: Assembly, models: Dict[str, LinkModel], lamp: str, link: str
) -> None:
    assert robot.parent_map[lamp][1] == link
    frames = assembly.frames({})
    pose = np.linalg.inv(frames[link]) @ frames[lamp]
    light = models[link].merged()["lamp"]
    eye, beam = pose[:3, 3], pose[:3, 0]
    assert light.ray_cast(tuple(eye + 0.002 * beam), tuple(eye - 0.004 * beam))
    assert not assembly.solids[link].ray_cast(tuple(eye + 0.002 * beam), tuple(eye + 0.3 * beam))


# ---- variants


def test_without_telescope_the_slide_is_fixed() -> None:
    robot = expanded("telescope:=false")
    joint = robot.joint_map["telescope_joint"]
    assert joint.type == "fixed"
    assert joint.origin.xyz == expanded().joint_map["telescope_joint"].origin.xyz
    assert not any(t.joints[0].name == "telescope_joint" for t in robot.transmissions)


@pytest.mark.parametrize(
    ("tool", "link"),
    [("gripper", "gripper_link"), ("probe", "probe_link"), ("none", "flange_link")],
)
def test_each_tool_ends_in_the_tool_frame(figures: Figures, tool: str, link: str) -> None:
    robot = expanded(f"tool:={tool}")
    assert robot.joint_map["gripper_roll_joint"].child == link
    assert robot.parent_map["tool_link"][1] == link
    assert ("left_finger_tip_joint" in robot.joint_map) == (tool == "gripper")
    assert robot.link_map["gripper_camera_link"]
    assert robot.link_map["gripper_lamp_link"]
    models = {m.name: m for m in [*gripper.links(figures), *tools.links(figures)]}
    assert greatest_protrusion(robot.link_map[link].collisions, models[link]) <= PROTRUSION
    if tool != "gripper":
        front = max(solid.bounding_box()[3] for solid in models[link].merged().values())
        frames = Assembly(robot, {link: models[link]}).frames({})
        reach = (np.linalg.inv(frames[link]) @ frames["tool_link"])[0, 3]
        assert front == pytest.approx(reach, abs=0.001)


def test_unknown_tool_is_refused() -> None:
    model = PACKAGE / "urdf" / "telex.urdf.xacro"
    result = subprocess.run(
        ["xacro", str(model), "tool:=spoon"], capture_output=True, text=True, check=False
    )
    assert result.returncode != 0
    assert "spoon" in result.stderr
    assert "gripper" in result.stderr
