"""Exercises of reading and searching: the expert is told what stands there, and where it is."""

from __future__ import annotations

import math
from typing import AbstractSet, Dict, List, Sequence

from telex_sim.scene.library.terrain.maze import Cell, Passage, perfect_maze

from .. import driving
from ..driving import Point
from ..handling import Hand
from .brief import Brief

_LINE = 1.5  # m
_LOOK = 0.6
"""At each row (s)."""
_IN_MAZE = 0.5  # m/s
_WALL = 0.05  # m

_BY_RADIO = 0.4
"""Speed on a line that fades (m/s)."""
_GAP = 1.3
"""Middle of a gap, from the corridor's (m)."""
_BEFORE_GAP, _BEHIND_GAP = 1.4, 2.6
"""From where a gap is driven through straight on, and where its chart is read (m)."""
_LAST_LOOK = (3.3, 0.95)
"""How far before the last chart it is read, and how far aside: in line with the last gap (m)."""

_BESIDE_LINE, _AHEAD = 0.6, 0.8  # m, of the robot from the flanges, and of its tool before it
_SMELLING = 0.2
"""Speed at which the sensor follows the gas (m/s)."""


def acuity(hand: Hand, brief: Brief) -> None:
    """Drive to the line, and read the rows from above."""
    station = hand.station
    driving.run_to(station, (_LINE, 0.0), 0.5, heading=0.0)
    station.stop()
    station.wait(1.0)
    for question in brief.answers:
        station.wait(_LOOK)
        station.port.answer(question, brief.answers[question])


def maze(hand: Hand, brief: Brief) -> None:
    """Drive from chart to chart, by the nearest next, read each from its cell, and go out."""
    station = hand.station
    entry = brief.entries["maze"]
    columns, rows = int(entry["columns"]), int(entry["rows"])
    pitch = float(entry["corridor"]) + _WALL
    passages = perfect_maze(columns, rows, int(entry["seed"]))
    left = float(entry["position"][0]) - 0.5 * (columns - 1) * pitch
    right = float(entry["position"][1]) - 0.5 * (rows - 1) * pitch

    def middle(cell: Cell) -> Point:
        return (left + cell[0] * pitch, right + cell[1] * pitch)

    def cell_before(chart: str) -> Cell:
        # Its back is at the wall: half a cell before it is the middle of the cell it looks into.
        x, y = brief.entries[chart]["position"][:2]
        yaw = float(brief.entries[chart]["yaw"])
        x, y = x - 0.5 * pitch * math.cos(yaw), y - 0.5 * pitch * math.sin(yaw)
        return (round((x - left) / pitch), round((y - right) / pitch))

    station.hold_preset("folded")
    station.wait(1.5)
    here: Cell = (0, 0)
    driving.follow(station, [middle(here)], _IN_MAZE)
    unread: Dict[str, Cell] = {chart: cell_before(chart) for chart in brief.answers}
    while unread:
        ways = {chart: _way(passages, here, cell) for chart, cell in unread.items()}
        chart = min(ways, key=lambda name: len(ways[name]))
        driving.follow(station, _corners([middle(cell) for cell in ways[chart]]), _IN_MAZE)
        here = unread.pop(chart)
        station.wait(_LOOK)
        station.port.answer(chart, brief.answers[chart])
    out = middle((columns, rows - 1))
    way = [middle(cell) for cell in _way(passages, here, (columns - 1, rows - 1))]
    driving.follow(station, _corners([*way, out]), _IN_MAZE)


def radio_range(hand: Hand, brief: Brief) -> None:
    """From chart to chart through the gaps, the last from the line of its gap, and back."""
    station = hand.station
    station.hold_preset("folded")
    legs: List[List[Point]] = []
    for number in (1, 2, 3):
        x, y = brief.entries[f"wall_{number}"]["position"][:2]
        aside = -math.copysign(_GAP, y)
        legs.append([(x - _BEFORE_GAP, aside), (x + _BEHIND_GAP, aside)])
    (x, aside), before = legs[-1][-1], brief.entries["chart_4"]["position"][0] - _LAST_LOOK[0]
    legs.append([(x + 1.8, 0.0), (before, math.copysign(_LAST_LOOK[1], aside))])
    for leg, (question, answer) in zip(legs, brief.answers.items()):
        driving.follow(station, leg, _BY_RADIO)
        station.wait(_LOOK)
        station.port.answer(question, answer)
    way = [point for leg in legs for point in leg]
    driving.follow(station, [*reversed(way[:-1]), (0.0, 0.0)], _BY_RADIO)


def leak_search(hand: Hand, brief: Brief) -> None:
    """Drive along the line of flanges with the sensor beside it, and tell the one that leaks."""
    station = hand.station
    station.hold_preset("folded")
    entry = brief.entries["line"]
    x, y = entry["position"][:2]
    half = 0.5 * int(entry["flanges"]) * float(entry["spacing"])
    aside = y - _BESIDE_LINE
    driving.run_to(station, (x - half - 1.0, aside), _SMELLING, heading=0.0)
    driving.run_to(station, (x + half - _AHEAD, aside), _SMELLING, heading=0.0)
    station.stop()
    station.wait(_LOOK)
    station.port.answer("leak", brief.answers["leak"])


def _way(passages: AbstractSet[Passage], start: Cell, goal: Cell) -> List[Cell]:
    """Cells of the only way from one to another, both with it."""
    ways = [[start]]
    for way in ways:
        if way[-1] == goal:
            return way
        ways += [
            [*way, cell]
            for passage in sorted(map(sorted, passages))
            for cell in passage
            if way[-1] in passage and cell not in way
        ]
    raise ValueError(f"no way leads from {start} to {goal}")


def _corners(points: Sequence[Point]) -> List[Point]:
    """Where a way turns, and its end; not its beginning."""
    kept = []
    for index, point in enumerate(points[1:], 1):
        after = points[index + 1] if index + 1 < len(points) else None
        before = points[index - 1]
        if after is None or not (
            math.isclose(before[0], after[0]) or math.isclose(before[1], after[1])
        ):
            kept.append(point)
    return kept
