"""Another run of the same exercise beside a trial: where its robot was at the same step."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Dict, Iterable, List, Optional, Tuple

import numpy as np

from telex_control.common.geometry.quaternions import Pose
from telex_sim.robot.urdf.visuals import UrdfVisual

from .replay import Replay
from .scenery import OtherRobotScenery

NAME = "replay_ghost"
"""Name of its robot in the scene."""
_COLOR = (0.45, 0.75, 1.0, 0.35)
_AWAY = -1000.0
"""Height (m) at which nothing sees it."""


class GhostError(ValueError):
    """A run cannot be drawn beside a trial; the message says why."""


@dataclass(frozen=True)
class Span:
    """A repetition by times of a replay (s).

    Attributes
    ----------
    earliest : float
        End of the one before; 0 of the first.
    begin : float
        When its clock started.
    steps : tuple of (str, float)
        Names and ends of the steps that were done, in the order of time.
    end : float
        Of the repetition, or of what was recorded of it.
    """

    earliest: float
    begin: float
    steps: Tuple[Tuple[str, float], ...]
    end: float
    completed: bool


def spans(marks: Iterable[Dict[str, Any]], duration: float) -> List[Span]:
    """Repetitions that began, by the marks of a replay; see `Replay.marks`."""
    found: List[Span] = []
    earliest = 0.0
    begin: Optional[float] = None
    steps: List[Tuple[str, float]] = []

    def close(end: float, completed: bool) -> None:
        if begin is not None:
            found.append(Span(earliest, begin, tuple(steps), end, completed))

    for mark in marks:
        event, time = mark["event"], mark["time"]
        if event == "begin":
            begin, steps = time, []
        elif event == "step" and begin is not None:
            steps.append((mark["name"], time))
        elif event == "repetition":
            close(time, mark["name"] == "passed")
            earliest, begin = time, None
    close(duration, False)
    return found


def anchors(span: Span, other: Span) -> Tuple[List[float], List[float]]:
    """Times of two repetitions that belong together: begin, ends of steps that both did, end."""
    mine, others = [span.begin], [other.begin]
    done = dict(reversed(other.steps))
    pairs = [(time, done[name]) for name, time in span.steps if name in done]
    if span.completed and other.completed:
        pairs.append((span.end, other.end))
    for time, there in pairs:
        if time > mine[-1] and there > others[-1]:
            mine.append(time)
            others.append(there)
    return mine, others


class Ghost:
    """The robot of another run, as it was when it was as far as the trial is.

    Of the other run the fastest completed repetition is shown, beside each of the trial's. Begins
    and ends of steps coincide; between them its time runs evenly, and after the last one that both
    did as fast as the trial's.

    Attributes
    ----------
    robot : OtherRobotScenery
        In one colour through which the trial is seen.

    Raises
    ------
    GhostError
        It is no run of the same exercise and setting, or none of its repetitions was completed.
    """

    def __init__(self, trial: Replay, other: Replay) -> None:
        for what, mine, others in (
            ("exercise", trial.exercise.name, other.exercise.name),
            ("setting", trial.exercise.setting, other.exercise.setting),
        ):
            if mine != others:
                raise GhostError(f"the {what} of the ghost is '{others}'; '{mine}' is needed")
        self._other = other
        self._spans = spans(trial.marks(), trial.timeline.duration)
        done = [each for each in spans(other.marks(), other.timeline.duration) if each.completed]
        if not done:
            raise GhostError(f"none of the repetitions of {other.trial.trial} was completed")
        self._span = min(done, key=lambda each: each.end - each.begin)
        scenery = other.scenery
        visuals = [_translucent(each) for each in scenery.visuals]
        self.robot = OtherRobotScenery(NAME, scenery.links, visuals)

    def time(self, time: float) -> float:
        """Time of the other run (s) that belongs to one of the trial."""
        span, other = self._at(time), self._span
        if span is None:
            return other.begin
        mine, others = anchors(span, other)
        if time < mine[0]:
            return max(other.earliest, others[0] - (mine[0] - time))
        if time > mine[-1]:
            return min(other.end, others[-1] + (time - mine[-1]))
        return float(np.interp(time, mine, others))

    def ahead(self, time: float) -> float:
        """By how much the other run was earlier at what the trial does at a time (s)."""
        span = self._at(time)
        if span is None or time < span.begin:
            return 0.0
        return (time - span.begin) - (self.time(time) - self._span.begin)

    def _at(self, time: float) -> Optional[Span]:
        """Repetition of the trial at a time, which counts from the end of the one before."""
        begun = [each for each in self._spans if each.earliest <= time]
        return begun[-1] if begun else None

    def poses(self, time: float) -> List[Pose]:
        """Poses of its links at a time of the trial (s), in their order."""
        scenery = self._other.scenery
        return scenery.link_poses(self._other.timeline.moment(self.time(time)))

    def away(self) -> List[Pose]:
        """Poses at which nobody sees it."""
        return [((0.0, 0.0, _AWAY), (0.0, 0.0, 0.0, 1.0))] * len(self.robot.links)


def _translucent(visual: UrdfVisual) -> UrdfVisual:
    return replace(visual, color=_COLOR, texture="", drive="", mesh_materials=False)
