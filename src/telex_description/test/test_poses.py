"""The named poses: within limits, where they should be, clear of all else; and so are the moves."""

from __future__ import annotations

import math
from typing import Dict, List

import numpy as np
import pytest
import yaml
from assembly import Assembly, Gap, models_by_link
from shipped_robot import PACKAGE
from telex_cad.figures import Figures
from urdf_parser_py.urdf import URDF

pytestmark = pytest.mark.slow

FLOOR = -0.110
SIDES = ("left", "right")
FLIPPERS = [f"{end}_{side}_flipper_joint" for end in ("front", "rear") for side in SIDES]
TIPS = {"left_finger_tip_link", "right_finger_tip_link"}
# Least distance between links that do not carry each other (m)
CLEARANCE = 0.003
# The same between the shoulder and the flippers
TURRET_CLEARANCE = 0.010
# Tool in base_link (m), and how far it points below the horizon (rad) where that matters
TOOL = {
    "stow": ((0.044, 0.0, 0.682), None),
    "drive": ((0.044, 0.0, 0.682), None),
    "ready": ((0.80, 0.0, 0.30), math.radians(25)),
    "look_front": ((0.62, 0.0, 0.95), 0.0),
    "floor_pick": ((0.775, 0.0, -0.05), math.radians(70)),
}
MOVES = [
    ("stow", "drive"),
    ("drive", "ready"),
    ("ready", "look_front"),
    ("ready", "floor_pick"),
]
POSES: Dict[str, Dict[str, float]] = yaml.safe_load(
    (PACKAGE / "config" / "poses.yaml").read_text(encoding="utf-8")
)["poses"]


@pytest.fixture(scope="module")
def assembly(robot: URDF, figures: Figures) -> Assembly:
    return Assembly(robot, models_by_link(figures))


def with_turret(pose: str, degrees: float) -> Dict[str, float]:
    return {**POSES[pose], "turret_joint": math.radians(degrees)}


def too_near(assembly: Assembly, positions: Dict[str, float], below: float) -> List[Gap]:
    """Return what is nearer than `below`, without the closed pads on each other."""

    def wanted(first: str, second: str) -> bool:
        # A drive wheel turns within the side plates of its flipper, round the hull's axle stub.
        in_wheel = "_track_link" in first + second and "base_link" in (first, second)
        return not (assembly.adjacent(first, second) or in_wheel or {first, second} == TIPS)

    return assembly.gaps(positions, below, wanted)


def too_near_to_the_vehicle(
    assembly: Assembly, positions: Dict[str, float], below: float
) -> List[Gap]:
    """Return what of turret and arm is nearer to hull or flippers than `below`."""

    def of_the_vehicle(link: str) -> bool:
        return link == "base_link" or "flipper" in link

    def wanted(first: str, second: str) -> bool:
        if "_track_link" in first + second or assembly.adjacent(first, second):
            return False
        return of_the_vehicle(first) != of_the_vehicle(second)

    return assembly.gaps(positions, below, wanted)


# ---- limits and places


def test_poses_name_every_positioned_joint(robot: URDF) -> None:
    positioned = {j.name for j in robot.joints if j.type in ("revolute", "prismatic")}
    assert set(POSES) == set(TOOL)
    for name, pose in POSES.items():
        assert set(pose) == positioned, name


def test_poses_keep_three_degrees_from_the_limits(robot: URDF) -> None:
    for pose_name, pose in POSES.items():
        for name, position in pose.items():
            joint = robot.joint_map[name]
            # Telescope and fingers rest on their stops when they are in, and closed.
            margin = 0.0 if name == "telescope_joint" or "finger" in name else math.radians(3)
            soft = joint.safety_controller
            assert soft.soft_lower_limit <= position <= soft.soft_upper_limit, (pose_name, name)
            assert joint.limit.lower + margin <= position <= joint.limit.upper - margin, (
                pose_name,
                name,
            )


def test_fingers_stay_parallel_in_the_poses() -> None:
    for pose in POSES.values():
        for side in SIDES:
            base, middle, tip = (
                pose[f"{side}_finger_{part}_joint"] for part in ("base", "middle", "tip")
            )
            assert (middle, tip) == pytest.approx((base, -2 * base))


@pytest.mark.parametrize("name", sorted(TOOL))
def test_tool_is_where_the_pose_says(assembly: Assembly, name: str) -> None:
    position, pitch = TOOL[name]
    frame = assembly.frames(POSES[name])["tool_link"]
    assert frame[:3, 3] == pytest.approx(position, abs=0.002)
    if pitch is not None:
        assert -math.asin(frame[2, 0]) == pytest.approx(pitch, abs=0.002)


# ---- clearance


@pytest.mark.parametrize("name", sorted(POSES))
def test_links_clear_each_other(assembly: Assembly, name: str) -> None:
    assert too_near(assembly, POSES[name], CLEARANCE) == []


@pytest.mark.parametrize(("start", "end"), MOVES)
def test_straight_moves_between_poses_are_clear(assembly: Assembly, start: str, end: str) -> None:
    for part in np.linspace(0.0, 1.0, 11):
        between = {
            name: (1 - part) * position + part * POSES[end][name]
            for name, position in POSES[start].items()
        }
        assert too_near(assembly, between, CLEARANCE) == [], part
        assert assembly.bounds(between)[0][2] > FLOOR - 0.001, part


@pytest.mark.parametrize("name", sorted(POSES))
def test_arm_keeps_off_the_floor(assembly: Assembly, name: str) -> None:
    placed = assembly.placed(POSES[name])
    arm = [link for link in placed if not ("flipper" in link or "track" in link)]
    lowest = min(placed[link].bounding_box()[2] for link in arm)
    assert lowest > FLOOR + 0.008


def test_floor_pick_opens_and_closes_without_touching_the_floor(assembly: Assembly) -> None:
    for opening in np.linspace(0.0, 0.55, 8):
        pose = dict(POSES["floor_pick"])
        for side in SIDES:
            for part, ratio in (("base", 1), ("middle", 1), ("tip", -2)):
                pose[f"{side}_finger_{part}_joint"] = ratio * opening
        placed = assembly.placed(pose)
        lowest = min(s.bounding_box()[2] for link, s in placed.items() if "finger" in link)
        assert 0.005 < lowest - FLOOR < 0.040, opening


# ---- turret


def test_shoulder_keeps_10_mm_from_upright_flippers(assembly: Assembly) -> None:
    gaps = too_near_to_the_vehicle(assembly, POSES["stow"], TURRET_CLEARANCE)
    assert [gap for gap in gaps if "flipper" in str(gap)] == []


@pytest.mark.parametrize(
    ("name", "lower", "upper"),
    [("drive", -200, -40), ("drive", 0, 200), ("ready", -170, 150), ("look_front", -200, 200)],
)
def test_turret_turns_freely(assembly: Assembly, name: str, lower: float, upper: float) -> None:
    for degrees in np.linspace(lower, upper, round((upper - lower) / 10) + 1):
        gaps = too_near_to_the_vehicle(assembly, with_turret(name, degrees), TURRET_CLEARANCE)
        assert [gap for gap in gaps if gap.distance < CLEARANCE] == [], degrees
        # The turret itself keeps the wider distance from the flippers.
        assert [gap for gap in gaps if "turret_link" in gap and "flipper" in str(gap)] == []


def test_stowed_turret_is_shut_in_until_the_flippers_are_lowered(assembly: Assembly) -> None:
    assert too_near_to_the_vehicle(assembly, with_turret("stow", 30), 0.0005) != []
    for degrees in (10, 30, 90, 150):
        lowered = {**with_turret("stow", degrees), **dict.fromkeys(FLIPPERS, 0.8)}
        assert too_near_to_the_vehicle(assembly, lowered, CLEARANCE) == [], degrees


# ---- envelope


def test_folded_robot_is_short_and_narrow(assembly: Assembly) -> None:
    lower, upper = assembly.bounds(POSES["stow"])
    length, width, height = upper - lower
    assert 0.70 < length < 0.82
    assert width == pytest.approx(0.400, abs=0.002)
    assert height < 0.86


def test_stretched_flippers_make_it_1_58_m_long(assembly: Assembly) -> None:
    lower, upper = assembly.bounds({**POSES["stow"], **dict.fromkeys(FLIPPERS, 0.0)})
    assert upper[0] - lower[0] == pytest.approx(1.58, abs=0.01)
    assert lower[2] == pytest.approx(FLOOR, abs=0.001)
