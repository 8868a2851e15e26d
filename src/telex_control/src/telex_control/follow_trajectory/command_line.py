"""Leads the tool along a path through the operational-space scheme, and shows how well it follows.

Works on a simulator that runs, with the robot at rest. The arm is moved: to the start of the path,
along it, and back; it stops before what it would run into. Errors are of the measured joint states.
Writes a figure (PNG, SVG: the way in space, errors over time), tables (Markdown, JSON) and the ways
(CSV). Lengths in m, in the base link's frame.
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import Optional, Sequence

import numpy as np
import rospy

from ..command_lines import program
from ..kinematics import Chain, IKSolver, KinematicsError
from ..step_response.ros_session import find_namespace
from ..step_response.runner import StepError
from ..urdf.joints import UrdfError
from . import FollowTrajectoryError, report, table
from .analysis import TrackingResult, analyse
from .follower import PathRig, approach, follow
from .paths import PLANES, SHAPES, Shape, from_csv
from .paths import Path as ToolPath
from .reference import PlannedPath, plan
from .ros_rig import TrajectoryRig
from .speed_profile import SpeedProfile
from .watch import MotionWatch

PERIOD = 0.002
"""Time between the references that are worked out (s); sent are as many as `--rate` says."""
CENTRE = (0.85, 0.0, 0.5)
"""Where the arm has room for a spiral of 0.15 m radius and 0.3 m height (m)."""
HEIGHTS = {"spiral": 0.3}
TURNS = {"spiral": 3.0}


def _number(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"{text} is not finite")
    return value


def _positive(text: str) -> float:
    value = _number(text)
    if not value > 0.0:
        raise argparse.ArgumentTypeError(f"{text} is not above 0")
    return value


def parse(arguments: Sequence[str]) -> argparse.Namespace:
    """Read the command line; it ends the program when that is wrong."""
    parser = argparse.ArgumentParser(prog="follow_trajectory", description=__doc__)
    kinds = parser.add_mutually_exclusive_group(required=True)
    for name in SHAPES:
        kinds.add_argument(f"--{name}", dest="shape", action="store_const", const=name)
    kinds.add_argument("--csv", type=Path, metavar="FILE", help="points of a path: x, y, z a line")
    parser.add_argument(
        "--radius", type=_positive, default=0.15, help="half the size of the path (0.15)"
    )
    parser.add_argument(
        "--height",
        type=_number,
        help="by which the path rises out of its plane: 3D (spiral 0.3, others 0)",
    )
    parser.add_argument(
        "--turns", type=_positive, help="how often it goes round (spiral 3, else 1)"
    )
    parser.add_argument("--plane", choices=list(PLANES), default="xy", help="of the path (xy)")
    place = parser.add_mutually_exclusive_group()
    place.add_argument(
        "--centre",
        nargs=3,
        type=_number,
        metavar=("X", "Y", "Z"),
        help=f"of the path ({' '.join(map(str, CENTRE))}); added to points of a file",
    )
    place.add_argument("--here", action="store_true", help="begin the path where the tool is")
    parser.add_argument("--speed", type=_positive, default=0.05, help="along the path, m/s (0.05)")
    parser.add_argument(
        "--acceleration", type=_positive, default=0.1, help="along the path, m/s2 (0.1)"
    )
    parser.add_argument(
        "--rate", type=_positive, default=100.0, help="of the references, Hz of sim time (100)"
    )
    guard = parser.add_mutually_exclusive_group()
    guard.add_argument(
        "--clearance",
        type=_positive,
        default=0.005,
        metavar="M",
        help="the arm stops at this distance from what it must not touch (0.005)",
    )
    guard.add_argument(
        "--unguarded",
        dest="clearance",
        action="store_const",
        const=None,
        help="go on, whatever the arm runs into",
    )
    parser.add_argument("--base", default="base_link", metavar="LINK", help="(base_link)")
    parser.add_argument("--tip", default="tool_link", metavar="LINK", help="(tool_link)")
    parser.add_argument(
        "--out",
        type=Path,
        default=Path("results") / "follow_trajectory",
        metavar="DIR",
        help="folder for figures and tables (results/follow_trajectory)",
    )
    parser.add_argument("--namespace", metavar="NS", help="of the robot, where there are several")
    return parser.parse_args(list(arguments))


def tool_path(options: argparse.Namespace, tool: np.ndarray) -> ToolPath:
    """Make the path that the command line asks for.

    Parameters
    ----------
    tool : ndarray, shape (3,)
        Where the tool is (m).

    Raises
    ------
    FollowTrajectoryError
    """
    if options.csv is not None:
        path = from_csv(options.csv, options.centre)
    else:
        name = options.shape
        height = HEIGHTS.get(name, 0.0) if options.height is None else options.height
        turns = options.turns or TURNS.get(name, 1.0)
        centre = tuple(options.centre or CENTRE)
        path = SHAPES[name](Shape(options.radius, height, turns, options.plane, centre))
    return path.moved(tool - path.points[0]) if options.here else path


def measure(options: argparse.Namespace) -> TrackingResult:
    """Carry it out on the running simulator; see `lead`.

    Raises
    ------
    FollowTrajectoryError, StepError, KinematicsError
    """
    given: Optional[str] = options.namespace
    namespace = find_namespace() if given is None else given.rstrip("/")
    try:
        urdf = rospy.get_param(f"{namespace}/robot_description")
    except KeyError as error:
        raise FollowTrajectoryError(
            f"parameter {namespace}/robot_description is missing"
        ) from error
    chain = Chain.from_urdf(urdf, options.base, options.tip)
    watch = MotionWatch(options.clearance)
    return lead(options, chain, TrajectoryRig(namespace, chain.joint_names, options.rate, watch))


def lead(options: argparse.Namespace, chain: Chain, rig: PathRig) -> TrackingResult:
    """Plan, lead the arm along the path and back, and write what it did.

    Parameters
    ----------
    options : Namespace
        See `parse`.
    chain : Chain
        Of the arm.

    Raises
    ------
    FollowTrajectoryError, StepError, KinematicsError
    """
    home = [rig.reference(name) for name in chain.joint_names]
    tool = chain.forward(home)
    path = tool_path(options, tool[:3, 3])
    profile = SpeedProfile(path.length, path.stops, options.speed, options.acceleration)
    print(f"path of {path.length:.2f} m, {profile.duration:.1f} s; working it out ...", flush=True)
    motion: PlannedPath = plan(IKSolver(chain), path, profile, tool[:3, :3], home, PERIOD)
    print("moving to its start ...", flush=True)
    approach(rig, motion, motion.start)
    print("following it ...", flush=True)
    recording = follow(rig, motion)
    result = analyse(options.shape or options.csv.stem, motion, recording)
    print("\n" + table.text([result]))
    if result.figures.overdue is not None:
        shown = " / ".join(f"{1000.0 * late:.0f}" for late in result.figures.overdue)
        print(f"\nreferences overdue at the controllers (median / 99 % / most): {shown} ms")
    for file in report.write(options.out, result):
        print(file)
    print("moving back ...", flush=True)
    approach(rig, motion, np.array(home))
    return result


def main() -> None:
    """Run the program."""
    options = parse(program.arguments())

    def work() -> None:
        program.begin_measurement("follow_trajectory")
        measure(options)

    errors = (KinematicsError, StepError, FollowTrajectoryError, UrdfError)
    program.run_measurement("follow_trajectory", work, *errors)
