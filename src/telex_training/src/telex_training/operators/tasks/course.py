"""Figure 10: a maze, obstacles, stairs and a step of 50 cm, driven one after the other."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Callable, Dict, List, Tuple

from telex_sim.scene.library.terrain.maze import Cell, Maze, perfect_maze

from .. import by_presets, driving
from ..port import NotManagedError
from ..robot_size import AXLE_HEIGHT
from ..station import Keys, Station
from ..terrain import hurdle
from ..terrain.hurdle import Hurdle
from ..terrain.stairs import Stairs
from ..terrain.step import Step
from .task import View

WORLD = "paper_course.yaml"
MAZE = Maze(columns=4, rows=3, corridor=1.1, thickness=0.05, height=0.8, seed=15)
MAZE_AT = (2.3, -1.15)
RAMP_END, RAMP_HEIGHT = 9.75, 0.4
BARRIER = Hurdle(height=0.3, length=0.6, edge=11.35)
STAIRS = Stairs(rise=0.17, run=0.28, steps=6, landing=1.4, foot=13.75)
STEP = Step(height=0.5, edge=20.05)

_MAZE_SPEED, _SPEED = 0.45, 0.5  # m/s
_RUN_UP = 1.15  # m, of base_link before an obstacle
_STANDING = 0.03  # m, that base_link may be lower than on level ground

_BESIDE: View = ("follow", -1.2, 0.30, 3.0, (0.2, 0.0, 0.15))
_ABOVE: View = ("fixed", -1.9, 0.85, 6.9, (1.8, -1.35, 0.1))


def way_through(maze: Maze, at: Tuple[float, float]) -> List[driving.Point]:
    """Return the corners of the way through a maze, from before it to behind it.

    Parameters
    ----------
    at : tuple of 2 floats
        Its middle (m); it is not turned.
    """
    passages = perfect_maze(maze.columns, maze.rows, maze.seed)
    goal = (maze.columns - 1, maze.rows - 1)
    came_from: Dict[Cell, Cell] = {(0, 0): (0, 0)}
    ahead = [(0, 0)]
    while ahead:
        cell = ahead.pop(0)
        for passage in passages:
            if cell in passage:
                other = next(each for each in passage if each != cell)
                if other not in came_from:
                    came_from[other] = cell
                    ahead.append(other)
    cells = [goal]
    while cells[-1] != (0, 0):
        cells.append(came_from[cells[-1]])
    cells.reverse()
    middles = [
        (
            at[0] + (column - 0.5 * (maze.columns - 1)) * maze.pitch,
            at[1] + (row - 0.5 * (maze.rows - 1)) * maze.pitch,
        )
        for column, row in cells
    ]
    points = [*middles, (middles[-1][0] + maze.pitch, middles[-1][1])]
    # Straight on needs no corner.
    return [
        point
        for before, point, after in zip([(at[0] - 9.0, middles[0][1]), *points], points, points[1:])
        if (point[0] - before[0]) * (after[1] - point[1])
        != (point[1] - before[1]) * (after[0] - point[0])
    ] + [points[-1]]


@dataclass(frozen=True)
class Section:
    """A part of the course.

    Attributes
    ----------
    drive : callable
        Drives it; raises `NotManagedError`.
    view : View
        Where the instructor's camera looks from.
    pictures : int
        In its filmstrip.
    """

    name: str
    title: str
    drive: Callable[[Station], None]
    view: View
    pictures: int = 6


def _maze(station: Station) -> None:
    keys = Keys(station)
    # As short as it gets, or it could not turn between the walls.
    keys.hold("folded")
    keys.wait(3.0)
    driving.follow(station, way_through(MAZE, MAZE_AT), _MAZE_SPEED)
    keys.hold("drive")
    driving.turn_to(station, 0.0)


def _obstacles(station: Station) -> None:
    keys = Keys(station)
    keys.hold("drive")
    station.keep_lane(_SPEED)
    top = 0.0

    def look() -> None:
        nonlocal top
        top = max(top, station.pose.z)

    station.until(lambda: station.pose.x > RAMP_END + 0.5, 25.0, "over the ramp", look)
    if top < RAMP_HEIGHT + AXLE_HEIGHT - _STANDING:
        raise NotManagedError(f"the ramp was not climbed, but {top:.2f} m; {station.where()}")
    keys.hold("")
    hurdle.cross(station, BARRIER)
    _on_floor(station)


def _stairs(station: Station) -> None:
    _run_up(station, STAIRS.foot)
    keys = Keys(station)
    by_presets.climb_stairs(keys, STAIRS)
    by_presets.descend_stairs(keys, STAIRS)
    _on_floor(station)


def _step(station: Station) -> None:
    _run_up(station, STEP.edge)
    by_presets.climb_step(Keys(station), STEP)


def _run_up(station: Station, foot: float) -> None:
    """Drive up to an obstacle, if it is still far."""
    station.hold_preset("drive")
    station.keep_lane(_SPEED)
    station.until(lambda: station.pose.x > foot - _RUN_UP, 20.0, "the run-up")


def _on_floor(station: Station) -> None:
    if abs(station.pose.z - AXLE_HEIGHT) > _STANDING:
        raise NotManagedError(f"does not stand on the floor; {station.where()}")


SECTIONS = (
    Section("maze", "Through the maze", _maze, _ABOVE, 8),
    Section("obstacles", "Over a ramp and a barrier of 30 cm", _obstacles, _BESIDE, 8),
    Section("stairs", "Stairs of 17 x 28 cm, up and down", _stairs, _BESIDE, 8),
    Section("step", "Up a step of 50 cm", _step, _BESIDE, 8),
)
