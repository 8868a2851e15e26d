"""Mazes, generated from a seed."""

from __future__ import annotations

import random
from dataclasses import dataclass
from pathlib import Path
from typing import FrozenSet, List, Set, Tuple

from ...model import SceneObject
from .. import materials as look
from ..building.walls import FINISHES
from ..object_type import ObjectType
from ..parameters import choice, number
from ..shapes import Parts, box, standing, steel_post

Cell = Tuple[int, int]
Passage = FrozenSet[Cell]


def perfect_maze(columns: int, rows: int, seed: int) -> Set[Passage]:
    """Open passages between cells so that exactly one way leads from any cell to any other.

    A walk goes on at random to a cell that was not visited yet, and back where there is none
    (depth-first search), until every cell was visited.

    Returns
    -------
    set of frozenset
        Each the two neighbouring cells, (column, row), between which there is no wall.
    """
    # random() alone is promised to stay the same from one Python to the next.
    numbers = random.Random(seed)
    passages: Set[Passage] = set()
    way: List[Cell] = [(0, 0)]
    visited = {(0, 0)}
    while way:
        column, row = way[-1]
        around = ((column + 1, row), (column, row + 1), (column - 1, row), (column, row - 1))
        free = [
            cell
            for cell in around
            if 0 <= cell[0] < columns and 0 <= cell[1] < rows and cell not in visited
        ]
        if not free:
            way.pop()
            continue
        cell = free[int(numbers.random() * len(free))]
        passages.add(frozenset((way[-1], cell)))
        visited.add(cell)
        way.append(cell)
    return passages


@dataclass(frozen=True)
class Maze(ObjectType):
    """Maze with one way through, from the middle of a cell at -x to one at +x.

    The entrance lies at the cell with the lowest x and y, the exit at that with the highest.
    """

    columns: int = number(4, "Cells along x and along y.", 1, 30)
    rows: int = number(4, "Cells along x and along y.", 1, 30)
    corridor: float = number(1.2, "Clear width (m).", 0.5, 5.0)
    height: float = number(1.2, "Of the walls (m).", 0.1, 4.0)
    thickness: float = number(0.05, "Of the walls (m).", 0.01, 0.5)
    seed: int = number(1, "The same seed gives the same maze.", 0, 2**31 - 1)
    finish: str = choice("wood", FINISHES)

    @property
    def pitch(self) -> float:
        """From the middle of a cell to that of the next (m)."""
        return self.corridor + self.thickness

    def walls(self) -> List[Tuple[Cell, Cell]]:
        """Straight walls between corners of cells, each as long as possible; corners from 0."""
        passages = perfect_maze(self.columns, self.rows, self.seed)

        def closed(one: Cell, other: Cell) -> bool:
            return frozenset((one, other)) not in passages

        walls: List[Tuple[Cell, Cell]] = []
        for line in range(self.rows + 1):
            along = [closed((column, line - 1), (column, line)) for column in range(self.columns)]
            walls += [((start, line), (end, line)) for start, end in _runs(along)]
        last = (self.columns, self.rows - 1)
        for line in range(self.columns + 1):
            along = [
                closed((line - 1, row), (line, row)) and (line, row) not in ((0, 0), last)
                for row in range(self.rows)
            ]
            walls += [((line, start), (line, end)) for start, end in _runs(along)]
        return walls

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        surface = FINISHES[self.finish]
        parts: List = []
        corners: Set[Cell] = set()
        for (x0, y0), (x1, y1) in self.walls():
            length = ((x1 - x0) + (y1 - y0)) * self.pitch - self.thickness
            middle = self._corner(0.5 * (x0 + x1), 0.5 * (y0 + y1))
            along_x = y0 == y1
            size = (length, self.thickness) if along_x else (self.thickness, length)
            parts.append(box((*size, self.height), (*middle, 0.5 * self.height), surface))
            rim = (size[0], size[1] + 0.01) if along_x else (size[0] + 0.01, size[1])
            parts.append(
                box((*rim, 0.03), (*middle, self.height - 0.005), look.DARK_STEEL, solid=False)
            )
            corners |= {(x, y) for x in range(x0, x1 + 1) for y in range(y0, y1 + 1)}
        parts.extend(self._posts(corners))
        return standing("maze", tuple(parts))

    def _posts(self, corners: Set[Cell]) -> Parts:
        return tuple(
            steel_post(
                self.height + 0.03,
                self.thickness + 0.012,
                (*self._corner(*corner), 0.0),
                look.GRAY_PAINT,
            )
            for corner in sorted(corners)
        )

    def _corner(self, column: float, row: float) -> Tuple[float, float]:
        return (
            (column - 0.5 * self.columns) * self.pitch,
            (row - 0.5 * self.rows) * self.pitch,
        )


def _runs(flags: List[bool]) -> List[Tuple[int, int]]:
    """Start and end (exclusive) of each unbroken run of true."""
    runs: List[Tuple[int, int]] = []
    for index, flag in enumerate(flags):
        if flag and runs and runs[-1][1] == index:
            runs[-1] = (runs[-1][0], index + 1)
        elif flag:
            runs.append((index, index + 1))
    return runs


TYPES = {"maze": Maze}
