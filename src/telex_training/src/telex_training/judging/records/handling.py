"""Handling in a repetition: drops of what was held, and its slip in the gripper."""

from __future__ import annotations

import math
from typing import Any, Dict, FrozenSet, Iterable, List, Optional, Set, Tuple

import numpy as np

from telex_control.common.geometry.matrices import rotation_matrix

from ...exercises.model import Exercise
from ..conditions import Context

USUAL_HEIGHT = 0.05
"""A fall by more is a drop (m)."""
_SLIPS = 0.003
"""m/s in the gripper, from which what is held counts as slipping."""
_WATCHED = 3.0
"""Time after its release for which an object can fall (s)."""


def goal_zones(exercise: Exercise) -> Dict[str, FrozenSet[str]]:
    """Zones into which the steps want each object; there, it may fall."""
    found: Dict[str, Set[str]] = {}
    for step in exercise.steps:
        for part in step.until.wanted():
            if part.kind == "inside":
                found.setdefault(part.of.what, set()).add(part.of.zone)
    return {what: frozenset(zones) for what, zones in found.items()}


class HandlingRecord:
    """What happened to held objects since the repetition began.

    Parameters
    ----------
    goals : dict of str to frozenset of str
        See `goal_zones`.
    heights : iterable of float
        From which falls are to be counted (m).
    """

    def __init__(self, goals: Dict[str, FrozenSet[str]], heights: Iterable[float]) -> None:
        self._goals = goals
        self._heights = sorted({USUAL_HEIGHT, *heights})
        self._held = ""
        self._in_tool: Any = None
        self._slip: Dict[str, float] = {}
        self._falling: Dict[str, Tuple[float, float, List[float]]] = {}
        self._drops: Dict[Tuple[str, float], int] = {}

    def sample(self, context: Context, span: float) -> List[str]:
        """Take a sample; `span` is the time since the one before (s).

        Returns
        -------
        list of str
            Objects that have just fallen by more than `USUAL_HEIGHT`.
        """
        world, held = context.world, context.world.carried
        if held != self._held:
            place = world.position(self._held) if self._held else None
            if place is not None:
                self._falling[self._held] = (context.time, place[2], list(self._heights))
            self._held, self._in_tool = held, None
            self._falling.pop(held, None)
        if held:
            self._slide(context, held, span)
        return self._fallen(context) if self._falling else []

    def _slide(self, context: Context, held: str, span: float) -> None:
        place, matrix = context.world.position(held), context.world.tool_in_base
        sample = context.world.sample
        if place is None or matrix is None or context.world.tool is None or sample is None:
            return
        turn = rotation_matrix(sample.base[1]) @ matrix[:3, :3]
        now = turn.T @ (np.asarray(place) - np.asarray(context.world.tool))
        if self._in_tool is not None and span > 0.0:
            way = float(np.sqrt(((now - self._in_tool) ** 2).sum()))
            if way > _SLIPS * span:
                self._slip[held] = self._slip.get(held, 0.0) + way
        self._in_tool = now

    def _fallen(self, context: Context) -> List[str]:
        dropped = []
        for name, (since, height, heights) in list(self._falling.items()):
            place = context.world.position(name)
            if place is None or context.time - since > _WATCHED:
                del self._falling[name]
                continue
            while heights and height - place[2] > heights[0]:
                limit = heights.pop(0)
                if any(context.contains(zone, place) for zone in self._goals.get(name, ())):
                    continue
                self._drops[(name, limit)] = self._drops.get((name, limit), 0) + 1
                if limit == USUAL_HEIGHT:
                    dropped.append(name)
        return dropped

    def figure(self, kind: str, thing: str = "", height: float = USUAL_HEIGHT) -> Optional[float]:
        """Return drops or slip (m), of one thing or of all."""
        if kind == "slip":
            return math.fsum(way for name, way in self._slip.items() if _is_of(name, thing))
        return float(
            sum(
                count
                for (name, limit), count in self._drops.items()
                if _is_of(name, thing) and limit == height
            )
        )


def _is_of(name: str, thing: str) -> bool:
    """Whether something is a thing, or a piece of it; empty: of any."""
    return thing in ("", name, name.partition("/")[0])
