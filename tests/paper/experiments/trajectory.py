"""Figure 8: the tool follows paths in 2D and 3D."""

from __future__ import annotations

import contextlib
import json
from dataclasses import dataclass
from typing import List, Sequence, Tuple

import rospy
from telex_msgs.msg import SimStatus

from ..experiment import Cell, Experiment, Figure, Picture, Result, Table
from ..recorder import ARM_COMMANDS
from ..session import Session
from ..tool import rosrun

RMS, LARGEST = 1.0, 3.0
"""Errors with an empty gripper (mm)."""
PICTURES = 1.0
"""A second, as few as tell what the robot did: the tool needs the processor."""
AXES = ("x", "y", "z")


@dataclass(frozen=True)
class Way:
    """A path for the tool.

    Attributes
    ----------
    name : str
        Of the tool's figures.
    title : str
    arguments : tuple of str
        Of ``follow_trajectory``.
    """

    name: str
    title: str
    arguments: Tuple[str, ...]


WAYS = (
    Way("circle", "Circle, level (2D)", ("--circle",)),
    Way("square", "Square, upright (2D)", ("--square", "--plane", "xz", "--radius", "0.1")),
    Way("spiral", "Spiral (3D)", ("--spiral",)),
)
QUICK = (
    Way("circle", "Half a circle, level (2D)", ("--circle", "--turns", "0.5")),
    Way("spiral", "One turn of the spiral (3D)", ("--spiral", "--turns", "1", "--height", "0.1")),
)


class LateCycles:
    """Hears how many control cycles the simulator begins late; close it when done."""

    def __init__(self, session: Session) -> None:
        self._counts: List[int] = []
        self._subscriber = rospy.Subscriber(
            f"{session.namespace}/sim/status",
            SimStatus,
            lambda message: self._counts.append(message.late_cycles),
        )

    def begin(self) -> None:
        """Forget what was heard."""
        self._counts = self._counts[-1:]

    @property
    def most(self) -> int:
        """Of those since the begin, the most between two messages: in a second."""
        counts = self._counts
        return max((later - sooner for sooner, later in zip(counts, counts[1:])), default=0)

    def close(self) -> None:
        """Listen no more."""
        self._subscriber.unregister()


def follow(session: Session, way: Way, late: LateCycles) -> Tuple[List[Figure], List[Cell]]:
    """Have the tool follow a path; returns the bars, and a row of the table."""
    session.say(way.title)
    late.begin()
    with session.record(way.name, ("front",), ARM_COMMANDS, PICTURES):
        rosrun(
            *("telex_control", "follow_trajectory", *way.arguments),
            *("--out", str(session.folder)),
            say=session.say,
        )
    (found,) = json.loads((session.folder / f"{way.name}.json").read_text(encoding="utf-8"))
    rms, most = 1e3 * found["rms"], 1e3 * found["largest"]
    figures = [
        Figure(f"{way.title}: rms error", rms, "mm", at_most=RMS),
        Figure(f"{way.title}: largest error", most, "mm", at_most=LARGEST),
    ]
    row: List[Cell] = [way.title, found["length"], found["duration"], rms, most]
    row += [1e3 * value for value in (*found["rms_by_axis"], *found["largest_by_axis"])]
    return figures, [*row, late.most]


def run(session: Session) -> Result:
    """Follow the paths on the running system, by the tool that ships with it."""
    ways: Sequence[Way] = QUICK if session.quick else WAYS
    figures: List[Figure] = []
    rows: List[List[Cell]] = []
    # Not faster than real time: a reference that a busy machine delays would be late by more.
    with session.simulator(console=False, pose="look_front"):
        session.configure_camera("front", rate=PICTURES)
        with contextlib.closing(LateCycles(session)) as late:
            for way in ways:
                found, row = follow(session, way, late)
                figures += found
                rows.append(row)
    head = ["path", "length m", "time s", "rms mm", "largest mm"]
    head += [f"{kind} {axis} mm" for kind in ("rms", "largest") for axis in AXES]
    head.append("late cycles in a second")
    return Result(
        figures=figures,
        pictures=[
            Picture(
                f"{way.title}.",
                f"{way.name}.svg",
                "The desired path and the one followed; below, the error in x, y and z over time.",
            )
            for way in ways
        ],
        tables=[
            Table(
                "Errors",
                "errors.csv",
                head,
                rows,
                "Of the measured joint states, against where the tool is to be at that time; the "
                "ways themselves are in the CSV of each path. Late cycles: the most control cycles "
                "that the simulator began late in one second; many tell of a machine held up.",
            )
        ],
        bags=[f"{way.name}.bag" for way in ways],
        notes=[
            "References go out at 100 Hz over ROS, and the base stands on its tracks, not fixed. "
            "At 50 mm/s a reference that is 20 ms late is an error of 1 mm: spikes in the plots "
            "are those of a machine that has other things to do. "
            "What is left are mostly the moments when a joint turns back, and dry friction "
            "changes its sign.",
            *(f"{way.title}: the ways are in {session.name}/{way.name}.csv." for way in ways),
        ],
    )


EXPERIMENTS = (
    Experiment(
        name="fig8_trajectories",
        paper="Figure 8, section 5",
        title="The tool follows 2D and 3D trajectories",
        claim="The arm was programmed to follow trajectories in 2D and 3D with the base at rest, "
        "by coordinates fed to the operational-space control. It tracked a spiral with very "
        "little error; minor deviations were put down to coupling and nonlinearities that the "
        "PIDs cannot compensate.",
        method="rosrun telex_control follow_trajectory leads the tool along a circle, a square and "
        "the spiral (radius 0.15 m, height 0.3 m, three turns) at 0.05 m/s.",
        bar="error \u2264 1 mm rms and \u2264 3 mm at most",
        run=run,
        seconds=215.0,
        quick_seconds=60.0,
        # A reference that comes 0.1 s late is an error of 5 mm.
        alone=True,
        groups=("fig8",),
    ),
)
