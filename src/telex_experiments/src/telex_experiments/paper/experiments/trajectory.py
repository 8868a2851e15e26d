"""Figure 8 on the running system: an ordinary client leads the tool along paths in 2D and 3D."""

from __future__ import annotations

import contextlib
import json
import math
from dataclasses import dataclass
from typing import List, Sequence, Tuple

import rospy
from telex_msgs.msg import SimStatus

from telex_control.follow_trajectory.analysis import TrackingFigures

from ..experiment import Cell, Experiment, Figure, ReportPicture, ReportTable, Result
from ..recorder import ARM_COMMANDS
from ..session import PaperSession
from ..tool import rosrun

RMS, LARGEST = 1.0, 3.0
"""Errors with an empty gripper (mm)."""
OVERDUE = ("median", "99th percentile", "most")
PICTURES = 1.0
"""A second, as few as tell what the robot did: the tool needs the processor."""
AXES = ("x", "y", "z")
POSE = "look_front"


@dataclass(frozen=True)
class ToolPath:
    """A path for the tool.

    Attributes
    ----------
    name : str
        Of the tool's figures.
    arguments : tuple of str
        Of ``follow_trajectory``.
    """

    name: str
    title: str
    arguments: Tuple[str, ...]


TOOL_PATHS = (
    ToolPath("circle", "Circle, level (2D)", ("--circle",)),
    ToolPath("square", "Square, upright (2D)", ("--square", "--plane", "xz", "--radius", "0.1")),
    ToolPath("spiral", "Spiral (3D)", ("--spiral",)),
)
QUICK = (
    ToolPath("circle", "Half a circle, level (2D)", ("--circle", "--turns", "0.5")),
    ToolPath(
        "spiral", "One turn of the spiral (3D)", ("--spiral", "--turns", "1", "--height", "0.1")
    ),
)


class LateCycles:
    """Hears how many control cycles the simulator begins late; close it when done."""

    def __init__(self, session: PaperSession) -> None:
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


def follow(
    session: PaperSession, way: ToolPath, late: LateCycles
) -> Tuple[List[Figure], List[Cell]]:
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
    del found["path"]
    reached = TrackingFigures(**found)
    figures = [
        Figure(f"{way.title}: rms error", 1e3 * reached.rms, "mm"),
        Figure(f"{way.title}: largest error", 1e3 * reached.largest, "mm", at_most=LARGEST),
    ]
    overdue = [1e3 * time for time in reached.overdue or [math.nan] * len(OVERDUE)]
    figures += [
        Figure(f"{way.title}: references overdue, {name}", time, "ms")
        for name, time in zip(OVERDUE, overdue)
    ]
    row: List[Cell] = [way.title, reached.length, reached.duration, *error_cells(reached)]
    return figures, [*row, *overdue, late.most]


def error_cells(figures: TrackingFigures) -> List[Cell]:
    """Return rms and largest error, then both by axis (mm)."""
    by_axis = (*figures.rms_by_axis, *figures.largest_by_axis)
    return [1e3 * value for value in (figures.rms, figures.largest, *by_axis)]


def pictures(ways: Sequence[ToolPath]) -> List[ReportPicture]:
    """Return the drawings that ``follow_trajectory`` makes of paths."""
    caption = "The desired path and the one followed; below, the error in x, y and z over time."
    return [ReportPicture(f"{way.title}.", f"{way.name}.svg", caption) for way in ways]


def run(session: PaperSession) -> Result:
    """Follow the paths on the running system, by the tool that ships with it."""
    ways: Sequence[ToolPath] = QUICK if session.quick else TOOL_PATHS
    figures: List[Figure] = []
    rows: List[List[Cell]] = []
    # Not faster than real time: a reference that a busy machine delays would be late by more.
    with session.simulator(console=False, pose=POSE), contextlib.closing(
        LateCycles(session)
    ) as late:
        for way in ways:
            found, row = follow(session, way, late)
            figures += found
            rows.append(row)
    head = ["path", "length m", "time s", "rms mm", "largest mm"]
    head += [f"{kind} {axis} mm" for kind in ("rms", "largest") for axis in AXES]
    head += [f"overdue, {name} ms" for name in OVERDUE]
    head.append("late cycles in a second")
    return Result(
        figures=figures,
        pictures=pictures(ways),
        tables=[
            ReportTable(
                "Errors",
                "errors.csv",
                head,
                rows,
                "Of the measured joint states, against where the tool is to be at that time; the "
                "ways themselves are in the CSV of each path. Overdue: for how long the reference "
                "after the one that a controller held was due already, seen 50 times a second of "
                "sim time for each joint that moves. Late cycles: the most control cycles "
                "that the simulator began late in one second; many tell of a machine held up.",
            )
        ],
        bags=[f"{way.name}.bag" for way in ways],
        notes=[
            "References go out at 100 Hz over ROS. At 50 mm/s one that is 20 ms late is an error "
            "of 1 mm: spikes in the plots are those of a machine that has other things to do. "
            "Without them, the error is that of fig8_trajectories.",
            *(f"{way.title}: the ways are in {session.name}/{way.name}.csv." for way in ways),
        ],
    )


EXPERIMENTS = (
    Experiment(
        name="fig8_live",
        paper="Figure 8, section 5",
        title="The same trajectories, led by a client of the running system",
        claim="The coordinates were fed to the operational-space control over ROS.",
        method="rosrun telex_control follow_trajectory, an ordinary process, leads the tool along "
        "the paths of fig8_trajectories: it answers every joint state with a reference for each "
        "joint. How late these come is seen from what the controllers say that they hold.",
        bar="error \u2264 3 mm at most",
        run=run,
        seconds=215.0,
        quick_seconds=60.0,
        # A reference that comes 0.1 s late is an error of 5 mm.
        alone=True,
        groups=("fig8",),
    ),
)
