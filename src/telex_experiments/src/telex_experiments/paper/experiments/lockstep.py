"""Figure 8 in lockstep: the paths are led within the loop, so that no clock has a part in it."""

from __future__ import annotations

import contextlib
import hashlib
import io
import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, Iterator, List, Sequence, Set

from sensor_msgs.msg import JointState

from telex_control.common.child_processes import KILLED_WITH_US
from telex_control.follow_trajectory.analysis import TrackingFigures
from telex_control.follow_trajectory.command_line import lead, parse
from telex_control.kinematics import Chain
from telex_sim.offline.arm import OfflineArm
from telex_sim.offline.simulation import OfflineSimulation, robot_description

from ..experiment import Cell, Experiment, Figure, ReportTable, Result
from ..session import PaperSession
from .trajectory import AXES, LARGEST, POSE, QUICK, RMS, TOOL_PATHS, ToolPath, error_cells, pictures

SETTLING = 3.0
"""Sim time (s) after the reset in which the tracks settle, and so do integral terms."""
SHOWN_DIGITS = 16
"""Of a hash, in the table."""


@dataclass(frozen=True)
class Led:
    """A path that was followed.

    Attributes
    ----------
    digest : str
        SHA-256 of all joint states from the reset to the end, as messages.
    """

    figures: TrackingFigures
    digest: str


def follow(way: ToolPath, folder: Path) -> Led:
    """Reset a robot, have its tool follow a path, and write the report of it into a folder.

    References go to the topics of the controllers, as those of any client, by the number of the
    step; each is read back from its controller before the step is made.

    Raises
    ------
    FollowTrajectoryError, KinematicsError
    """
    options = parse([*way.arguments, "--out", str(folder)])
    urdf = robot_description()
    chain = Chain.from_urdf(urdf, options.base, options.tip)
    offline = OfflineSimulation(urdf, start__pose=POSE)
    digest = hashlib.sha256()

    def add(message: Any) -> None:
        buffer = io.BytesIO()
        message.serialize(buffer)
        digest.update(buffer.getvalue())

    with contextlib.closing(offline.simulation):
        offline.simulation.reset()
        offline.node.subscribe("/joint_states", JointState, add)
        arm = OfflineArm(offline.simulation, offline.node, chain.joint_names, options.rate)
        arm.wait(SETTLING)
        return Led(lead(options, chain, arm).figures, digest.hexdigest())


@contextlib.contextmanager
def hogs() -> Iterator[None]:
    """Keep every processor busy meanwhile, at the priority of this process."""
    command = [*KILLED_WITH_US, sys.executable, "-c", "while True: pass"]
    with contextlib.ExitStack() as stack:
        for _ in range(os.cpu_count() or 1):
            process = subprocess.Popen(command)
            stack.callback(process.wait)
            stack.callback(process.kill)
        yield


def run(session: PaperSession) -> Result:
    """Follow the paths, as often as asked for; every second time beside hogs."""
    ways: Sequence[ToolPath] = QUICK if session.quick else TOOL_PATHS
    rows: List[List[Cell]] = []
    found: Dict[str, List[Led]] = {way.title: [] for way in ways}
    for number in range(1, session.repeat + 1):
        beside = number % 2 == 0
        with hogs() if beside else contextlib.nullcontext():
            for way in ways:
                session.say(f"{way.title}, run {number} of {session.repeat}")
                led = follow(way, session.folder)
                found[way.title].append(led)
                shown = led.digest[:SHOWN_DIGITS]
                rows.append([way.title, number, beside, *error_cells(led.figures), shown])
    head = ["path", "run", "processors hogged", "rms mm", "largest mm"]
    head += [f"{kind} {axis} mm" for kind in ("rms", "largest") for axis in AXES]
    return Result(
        figures=bars(found),
        pictures=pictures(ways),
        tables=[
            ReportTable(
                "Errors",
                "errors.csv",
                [*head, "joint states"],
                rows,
                "Of the measured joint states, against where the tool is to be at that time; the "
                "ways themselves are in the CSV of each path. Joint states: the begin of the "
                "SHA-256 of all their messages from the reset on. On one machine it is the same in "
                "every run, whatever else has the processors; reproduce_paper.sh --only "
                "fig8_trajectories --repeat 10 shows it.",
            )
        ],
        notes=[
            "The base stands on its tracks, not fixed. What is left are mostly the moments when a "
            "joint turns back, and dry friction changes its sign. What an ordinary client reaches "
            "over ROS is in fig8_live.",
            *(f"{way.title}: the ways are in {session.name}/{way.name}.csv." for way in ways),
        ],
    )


def bars(found: Dict[str, List[Led]]) -> List[Figure]:
    """Return the bars for all runs of each path, by its title: the worst run counts."""
    figures: List[Figure] = []
    for title, runs in found.items():
        rms = 1e3 * max(led.figures.rms for led in runs)
        most = 1e3 * max(led.figures.largest for led in runs)
        figures += [
            Figure(f"{title}: rms error", rms, "mm", at_most=RMS),
            Figure(f"{title}: largest error", most, "mm", at_most=LARGEST),
        ]
        if len(runs) > 1:
            different: Set[str] = {led.digest for led in runs}
            name = f"{title}: different joint states in {len(runs)} runs"
            figures.append(Figure(name, len(different), "", at_most=1))
    return figures


EXPERIMENTS = (
    Experiment(
        name="fig8_trajectories",
        paper="Figure 8, section 5",
        title="The tool follows 2D and 3D trajectories",
        claim="The arm was programmed to follow trajectories in 2D and 3D with the base at rest, "
        "by coordinates fed to the operational-space control. It tracked a spiral with very "
        "little error; minor deviations were put down to coupling and nonlinearities that the "
        "PIDs cannot compensate.",
        method="The shipped robot with the shipped controllers, in one process. From a reset, the "
        "core of follow_trajectory leads the tool along a circle, a square and the spiral (radius "
        "0.15 m, height 0.3 m, three turns) at 0.05 m/s. Its references, 100 a second of sim time, "
        "go to the controllers' topics by the number of the step, and are read back before it.",
        bar="error \u2264 1 mm rms and \u2264 3 mm at most, in every run; the same joint states",
        run=run,
        seconds=150.0,
        quick_seconds=60.0,
        in_wall_time=False,
        repeatable=True,
        groups=("fig8",),
    ),
)
