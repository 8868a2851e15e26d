"""Motion of base and tool in a repetition: paths, reversals, smoothness, stops, balance."""

from __future__ import annotations

import math
from typing import Any, List, Optional, Tuple

from telex_control.common.geometry.quaternions import Pose, Vector3, rotate

from ...exercises.model import Survey
from ..conditions import Context, lean
from ..truth import World
from .smoothness import mean_sparc

_STANDS = 1e-3
"""m/s, below which what is left of motion is the physics' and no path."""
_REVERSES = 0.05
_DRIVES, _TURNS, _REACHES = 0.02, 0.05, 0.005
"""m/s, rad/s, m/s from which base and tool move."""
_SHORT_MOVE = 2.0
_SHORTEST_WAIT, _LONGEST_WAIT = 0.5, 3.0
CAUTION = 0.5
"""Tip-over margin below which the displays warn."""
TIPPED_ANGLE, _TIPPED_TIME = 1.2, 0.5


class _Path:
    def __init__(self) -> None:
        self.length = 0.0
        self.known = False
        self._last: Optional[Vector3] = None

    def add(self, place: Optional[Vector3], span: float) -> float:
        """Add a place; returns the speed (m/s)."""
        last, self._last = self._last, place
        if place is None:
            return 0.0
        self.known = True
        if last is None or span <= 0.0:
            return 0.0
        way = math.dist(last, place)
        if way > _STANDS * span:
            self.length += way
        return way / span


class MotionRecord:
    """How base and tool moved since the repetition began."""

    def __init__(self) -> None:
        self._base, self._tool, self._reach = _Path(), _Path(), _Path()
        self._speeds: List[float] = []
        self._heading = 0
        self._reversals = 0
        self._moving = False
        self._changed: Optional[float] = None
        self._last_move: Optional[float] = None
        self._moves = self._waits = 0

    def sample(self, world: World, time: float, span: float) -> None:
        """Take a sample; `span` is the time since the one before (s)."""
        sample = world.sample
        assert sample is not None
        self._base.add(sample.base[0], span)
        self._tool.add(world.tool, span)
        reach = 0.0
        if world.tool_in_base is not None:
            x, y, z = world.tool_in_base[:3, 3].tolist()
            reach = self._reach.add((x, y, z), span)
            self._speeds.append(reach)
        ahead = rotate(sample.base[1], (1.0, 0.0, 0.0))
        speed = sum(a * v for a, v in zip(ahead, sample.twist[:3]))
        if abs(speed) > _REVERSES:
            heading = 1 if speed > 0.0 else -1
            self._reversals += self._heading == -heading
            self._heading = heading
        turn = math.sqrt(sum(w * w for w in sample.twist[3:]))
        self._stop_or_go(time, abs(speed) > _DRIVES or turn > _TURNS or reach > _REACHES)

    def _stop_or_go(self, time: float, moving: bool) -> None:
        """Count moves of less than 2 s with a stop of 0.5 to 3 s behind them."""
        if self._changed is None:
            self._changed, self._moving = time, moving
            return
        if moving == self._moving:
            return
        lasted, self._changed, self._moving = time - self._changed, time, moving
        if not moving:
            self._moves += 1
            self._last_move = lasted
        elif self._last_move is not None:
            waited = _SHORTEST_WAIT <= lasted <= _LONGEST_WAIT
            self._waits += waited and self._last_move < _SHORT_MOVE

    def figure(self, kind: str, length: Optional[float] = None) -> Optional[float]:
        """Return a figure; `length` is that of the expert's path (m), for a ratio."""
        if kind.startswith(("base_path", "tool_path")):
            path = self._base if kind.startswith("base") else self._tool
            if not path.known:
                return None
            return path.length / length if length else path.length
        if kind == "reversals":
            return float(self._reversals)
        if kind == "sparc":
            return mean_sparc(self._speeds) if self._speeds else None
        return self._waits / self._moves if self._moves else 0.0


class BalanceRecord:
    """How near the robot was to tipping over since the repetition began."""

    def __init__(self) -> None:
        self._margin: Optional[float] = None
        self._caution = 0.0
        self._tips = 0
        self._leaning: Optional[float] = None
        self._tipped = False

    def sample(self, world: World, time: float, span: float) -> bool:
        """Take a sample; tells whether the robot has just tipped over."""
        sample = world.sample
        assert sample is not None
        margin = sample.margin
        self._margin = margin if self._margin is None else min(self._margin, margin)
        if margin < CAUTION:
            self._caution += span
        if lean(sample.base[1]) <= TIPPED_ANGLE:
            self._leaning, self._tipped = None, False
            return False
        if self._leaning is None:
            self._leaning = time
        if self._tipped or time - self._leaning < _TIPPED_TIME:
            return False
        self._tipped = True
        self._tips += 1
        return True

    def figure(self, kind: str) -> Optional[float]:
        """Return one of the figures margin, caution and tips."""
        figures: Any = {"margin": self._margin, "caution": self._caution, "tips": self._tips}
        value = figures[kind]
        return None if value is None else float(value)


class SurveyRecord:
    """Points of a survey that were passed, and how evenly; None: the exercise has none."""

    def __init__(self, survey: Optional[Survey]) -> None:
        self._survey = survey
        self._missed = set() if survey is None else set(survey.points)
        self._lasted = self._error = 0.0
        self._laid: Optional[Tuple[complex, complex, complex]] = None
        self._map_error: Optional[float] = None

    def hear_odometry(self, world: World, pose: Pose) -> None:
        """Take where the robot is by its own odometry, and compare that with where it is.

        A map by that odometry is laid over the truth where the repetition begins.
        """
        survey, sample = self._survey, world.sample
        if survey is None or sample is None or not self._missed:
            return
        told, heading = _flat(pose)
        place, true_heading = _flat(sample.base)
        if self._laid is None:
            self._laid = place, told, true_heading / heading
        if len(self._missed) < len(survey.points):
            begin, told_begin, turn = self._laid
            error = abs(begin + (told - told_begin) * turn - place)
            self._map_error = max(error, self._map_error or 0.0)

    def sample(self, context: Context, span: float) -> None:
        """Take a sample; `span` is the time since the one before (s)."""
        survey, sample = self._survey, context.world.sample
        if survey is None or sample is None or not self._missed:
            return
        if len(self._missed) < len(survey.points):
            speed = math.hypot(sample.twist[0], sample.twist[1])
            self._lasted += span
            self._error += abs(speed - survey.speed) * span
        self._missed -= {name for name in self._missed if context.within(survey.what, name)}

    def figure(self, kind: str) -> Optional[float]:
        """Return a figure."""
        if self._survey is None:
            return None
        if kind == "missed_points":
            return float(len(self._missed))
        if kind == "map_error":
            return self._map_error
        return self._error / self._lasted if self._lasted else None


def _flat(pose: Pose) -> Tuple[complex, complex]:
    """Place and heading over the floor of a pose: x + iy (m), and what turns x to its heading."""
    (x, y, _), orientation = pose
    ahead = complex(*rotate(orientation, (1.0, 0.0, 0.0))[:2])
    return complex(x, y), ahead / abs(ahead) if ahead else 1.0 + 0.0j
