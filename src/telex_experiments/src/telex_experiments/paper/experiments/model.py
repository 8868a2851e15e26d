"""Section 3.2: what the robot consists of, in the running system."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, Dict, List, Optional, Tuple

import rospy
import yaml
from controller_manager_msgs.srv import ListControllers
from sensor_msgs.msg import CameraInfo, JointState

from telex_control.kinematics import UrdfTree
from telex_control.urdf.joints import joints, parse_urdf
from telex_control.urdf.model import Robot
from telex_control.urdf.transmission_parser import driven_joints

from ..experiment import Cell, Experiment, Figure, ReportTable, Result
from ..session import PaperSession

EXPECTED = Path(__file__).resolve().parents[1] / "model.yaml"
GROUPS = ("arm", "flippers", "gripper", "belts", "camera_head")
FRAME_MASS = 1e-5
"""A link lighter than this is a frame (kg): PyBullet would take it for one of 1 kg without."""
TOLERANCE = 1e-3  # rad, m, kg, of figures that are written with so many digits
VIEW_TOLERANCE = 0.5
"""Of an angle of view (deg): CameraInfo tells a focal length of a lens with distortion."""


class _Check:
    """Counts what is not as expected."""

    def __init__(self) -> None:
        self.wrong: List[str] = []

    def same(self, name: str, found: Any, expected: Any, tolerance: float = TOLERANCE) -> bool:
        """Compare, and note a difference."""
        if isinstance(expected, (int, float)) and isinstance(found, (int, float)):
            good = math.isclose(found, expected, abs_tol=tolerance)
        else:
            good = found == expected
        if not good:
            self.wrong.append(f"{name} is {found}, not {expected}")
        return good


def joint_rows(
    robot: Robot, expected: Dict[str, Any], moved: List[str], check: _Check
) -> List[List[Cell]]:
    """Compare the joints, their limits and transmissions; returns a table's rows."""
    found = joints(robot)
    driven = {joint.joint for joint in driven_joints(robot)}
    rows: List[List[Cell]] = []
    wanted = {name: (group, row) for group in GROUPS for name, row in expected[group].items()}
    check.same("the set of movable joints", sorted(found), sorted(wanted))
    for name, (group, (kind, lower, upper, velocity, effort)) in wanted.items():
        joint = found.get(name)
        if joint is None:
            continue
        limits: Tuple[Optional[float], Optional[float]] = (
            (None, None) if math.isinf(joint.lower) else (joint.lower, joint.upper)
        )
        good = [
            check.same(f"{name}: kind", joint.kind, kind),
            check.same(f"{name}: lower limit", limits[0], lower),
            check.same(f"{name}: upper limit", limits[1], upper),
            check.same(f"{name}: velocity", joint.velocity, float(velocity)),
            check.same(f"{name}: effort", joint.effort, float(effort)),
            check.same(f"{name}: has a transmission", name in driven, True),
            check.same(f"{name}: is in joint_states", name in moved, True),
        ]
        rows.append(
            [
                group,
                name,
                joint.kind,
                *limits,
                joint.velocity,
                joint.effort,
                name in driven,
                all(good),
            ]
        )
    return rows


def mass_rows(
    robot: Robot, expected: Dict[str, Any], check: _Check
) -> Tuple[List[List[Cell]], float]:
    """Compare the masses; returns a table's rows, and the sum (kg)."""
    inertials = UrdfTree(robot).inertials
    masses = {name: each.mass for name, each in inertials.items() if each is not None}
    heavy = {name: mass for name, mass in masses.items() if mass > FRAME_MASS}
    wanted: Dict[str, float] = expected["masses"]
    check.same("the set of links with a mass", sorted(heavy), sorted(wanted))
    without = sorted(name for name, each in inertials.items() if each is None)
    check.same("links without an inertial", without, [])
    rows: List[List[Cell]] = []
    for name, mass in wanted.items():
        if name in heavy:
            good = check.same(f"{name}: mass", heavy[name], mass)
            inertial = inertials[name]
            moments = inertial.inertia[:3] if inertial is not None else (None, None, None)
            rows.append([name, heavy[name], *moments, good])
    total = sum(masses.values())
    check.same("the whole mass", total, expected["total_mass"], 0.01)
    return rows, total


def camera_rows(session: PaperSession, expected: Dict[str, Any], check: _Check) -> List[List[Cell]]:
    """Compare what the running cameras say of themselves; returns a table's rows."""
    rows: List[List[Cell]] = []
    for name, (width, height, view) in expected["cameras"].items():
        info = session.wait_for(f"cameras/{name}/camera_info", CameraInfo)
        angle = math.degrees(view_angle(info))
        good = [
            check.same(f"camera {name}: width", info.width, width),
            check.same(f"camera {name}: height", info.height, height),
            check.same(f"camera {name}: angle of view", angle, view, VIEW_TOLERANCE),
            check.same(f"camera {name}: frame", info.header.frame_id, frame_of(name)),
        ]
        rows.append([name, info.width, info.height, angle, info.header.frame_id, all(good)])
    return rows


def frame_of(camera: str) -> str:
    """Return the optical frame of a camera."""
    return f"{camera}_camera_optical_frame"


def view_angle(info: CameraInfo) -> float:
    """Return the full angle of view across a picture (rad), with the lens's distortion."""
    reach = 0.5 * info.width / info.K[0]
    k1, k2, _, _, k3 = info.D
    # The radius without distortion that the lens puts at the edge: found by Newton's method.
    radius = reach
    for _ in range(50):
        square = radius * radius
        shown = radius * (1.0 + square * (k1 + square * (k2 + square * k3)))
        slope = 1.0 + square * (3.0 * k1 + square * (5.0 * k2 + square * 7.0 * k3))
        radius -= (shown - reach) / slope
    return 2.0 * math.atan(radius)


def run(session: PaperSession) -> Result:
    """Compare the running system's description, joint states and cameras with what is expected."""
    expected = yaml.safe_load(EXPECTED.read_text(encoding="utf-8"))
    check = _Check()
    with session.simulator(pose="ready"):
        robot = parse_urdf(rospy.get_param(f"{session.namespace}/robot_description"))
        moved = list(session.wait_for("joint_states", JointState).name)
        table = joint_rows(robot, expected, moved, check)
        masses, total = mass_rows(robot, expected, check)
        session.say("asking the cameras what they are")
        cameras = camera_rows(session, expected, check)
        service = rospy.ServiceProxy(
            f"{session.namespace}/controller_manager/list_controllers", ListControllers
        )
        running = [each for each in service().controller if each.state == "running"]
    figures = [
        Figure("facts that are not as expected", len(check.wrong), "", at_most=0),
        Figure("movable joints", len(table), "", at_least=23),
        Figure("cameras that answer", len(cameras), "", at_least=6),
        Figure("mass", total, "kg"),
        Figure("controllers that run", len(running), ""),
    ]
    lowest, highest = "lower rad, m", "upper rad, m"
    return Result(
        figures=figures,
        tables=[
            ReportTable(
                "Joints",
                "joints.csv",
                (
                    *("group", "joint", "kind", lowest, highest),
                    *("velocity rad/s, m/s", "effort Nm, N", "transmission", "as expected"),
                ),
                table,
                "The arm has six revolute joints and one prismatic, the base four flippers, the "
                "gripper six joints, as in the paper; belts and camera head are driven joints too.",
            ),
            ReportTable(
                "Masses and moments of inertia",
                "masses.csv",
                ("link", "mass kg", "Ixx kg m2", "Iyy kg m2", "Izz kg m2", "as expected"),
                masses,
            ),
            ReportTable(
                "Cameras",
                "cameras.csv",
                ("camera", "width px", "height px", "angle of view deg", "frame", "as expected"),
                cameras,
                "By the CameraInfo that each running camera sends with its pictures.",
            ),
        ],
        notes=check.wrong[:20],
    )


EXPERIMENTS = (
    Experiment(
        name="model_facts",
        paper="Section 3.2",
        title="The physical model",
        claim="The URDF has six revolute and one prismatic joint for the arm, four revolute ones "
        "for the flippers, with limits of position, effort and velocity, transmissions to their "
        "actuators, collision and inertial properties, and the robot's cameras (six, section 1). "
        "The gripper has six revolute joints (section 4.2).",
        method="The running system is asked: its robot description, joint states, controllers and "
        "each camera's CameraInfo; compared with the documented figures.",
        bar="complete: all joints with limits and transmissions, all masses, six cameras",
        run=run,
        seconds=45.0,
        quick_seconds=45.0,
    ),
)
