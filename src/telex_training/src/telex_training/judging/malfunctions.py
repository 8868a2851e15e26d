"""Record of what failed in a trial, and of how soon the operator did something else."""

from __future__ import annotations

import math
from typing import Any, Dict, List, NamedTuple, Optional, Tuple

from telex_sim.malfunctions.kinds import text_of

from .activity import COMMANDS
from .entries import BadEntryError, Entry, decode
from .entries import text_of as said

_HOLDS = 0.3
"""A command counts for so long (s): the watchdogs' 0.28 s and a sample."""
_ALIKE = 0.2
"""Share of a command by which it may differ and still be the same: no hand holds a stick still."""
_MOST = 200
Axis = Tuple[str, str]
"""Channel, and what of its messages."""


class FailureEpisode:
    """Something that failed, until it worked again.

    Attributes
    ----------
    stamp : genpy.Time
        By which the simulator tells it from others of its kind.
    since : float
        Sim time (s).
    ended : float, optional
        Sim time (s); None: it has not.
    commanded, stopped : float, optional
        Sim time (s) of the first other command and of the first emergency stop; None: there was
        none before it ended.
    """

    def __init__(self, active: Any, heard: float, held: Dict[Axis, float]) -> None:
        self.what, self.group = str(active.what), str(active.group)
        self.kind, self.value = str(active.kind), float(active.value)
        self.announced = bool(active.announced)
        self.stamp = active.since
        self.since = min(active.since.to_sec(), heard)
        self.ended: Optional[float] = None
        self.commanded: Optional[float] = None
        self.stopped: Optional[float] = None
        # What was commanded when it began.
        self._held = held

    @property
    def name(self) -> str:
        """Part and kind."""
        return f"{self.what} {self.kind}"

    def differs(self, axis: Axis, value: float) -> bool:
        """Whether a command is another than that which was given when it began."""
        before = self._held.get(axis, 0.0)
        return abs(value - before) > _ALIKE * max(abs(value), abs(before))

    @property
    def held(self) -> Tuple[Axis, ...]:
        """Axes that were commanded to move when it began."""
        return tuple(self._held)

    def sheet(self) -> Dict[str, Any]:
        """What the score sheet says of it."""
        return {
            "time": self.since,
            "what": self.what,
            "kind": self.kind,
            "value": self.value,
            "announced": self.announced,
            "ended": self.ended,
            "command": None if self.commanded is None else self.commanded - self.since,
            "e_stop": None if self.stopped is None else self.stopped - self.since,
        }


class EpisodeEvent(NamedTuple):
    """What happened to an episode: its event, and details."""

    event: str
    episode: FailureEpisode
    detail: Dict[str, Any]


class MalfunctionRecord:
    """Hears of malfunctions, commands and stops, and relates them."""

    def __init__(self) -> None:
        self.episodes: List[FailureEpisode] = []
        self._open: List[FailureEpisode] = []
        self._commands: Dict[Axis, Tuple[float, float]] = {}
        self._stopped = False

    def hear(self, entry: Entry) -> List[EpisodeEvent]:
        """Hear a telex_msgs/Malfunctions.

        Raises
        ------
        BadEntryError
        """
        message, time = decode(entry, "telex_msgs/Malfunctions"), entry.time
        events = []
        active = {(str(each.what), str(each.kind), each.since): each for each in message.active}
        known = {(each.what, each.kind): each for each in self._open}
        for (what, kind, since), each in active.items():
            if not math.isfinite(each.value):
                raise BadEntryError(f"the value of {what} {kind} is {each.value}")
            before = known.get((what, kind))
            if before is not None and before.stamp == since:
                continue
            if before is not None:
                events.append(self._end(before, time))
            if len(self.episodes) < _MOST:
                made = FailureEpisode(each, time, self._held(time))
                self.episodes.append(made)
                self._open.append(made)
                detail = {"value": made.value, "announced": made.announced}
                events.append(EpisodeEvent("malfunction", made, detail))
        there = {(what, kind) for what, kind, _ in active}
        gone = [each for each in self._open if (each.what, each.kind) not in there]
        return [*(self._end(each, time) for each in gone), *events]

    def _end(self, episode: FailureEpisode, time: float) -> EpisodeEvent:
        episode.ended = time
        self._open.remove(episode)
        return EpisodeEvent("mended", episode, {})

    def _held(self, time: float) -> Dict[Axis, float]:
        return {
            axis: value
            for axis, (value, given) in self._commands.items()
            if value and time - given <= _HOLDS
        }

    def command(self, entry: Entry) -> List[EpisodeEvent]:
        """Hear a command; returns the episodes to which it is the first reaction.

        Raises
        ------
        BadEntryError
        """
        given = {(entry.channel, name): value for name, value in _axes(entry).items()}
        for axis, value in given.items():
            self._commands[axis] = (value, entry.time)
        events = []
        for each in self._open:
            other = any(each.differs(axis, value) for axis, value in given.items())
            if other and each.commanded is None:
                events.append(self._commanded(each, entry.time))
        return events

    def sample(self, time: float) -> List[EpisodeEvent]:
        """Let time pass (s): a stream that has fallen silent is a key that was released."""
        events = []
        for each in self._open:
            if each.commanded is not None:
                continue
            ends = [self._commands[axis][1] for axis in each.held]
            if ends and time - min(ends) > _HOLDS:
                events.append(self._commanded(each, max(min(ends), each.since)))
        return events

    def _commanded(self, episode: FailureEpisode, time: float) -> EpisodeEvent:
        episode.commanded = time
        return EpisodeEvent("reaction", episode, {"by": "command", "seconds": time - episode.since})

    def e_stop(self, entry: Entry) -> List[EpisodeEvent]:
        """Hear an emergency stop, set or released.

        Raises
        ------
        BadEntryError
        """
        was, self._stopped = self._stopped, bool(decode(entry, "std_msgs/Bool").data)
        events = []
        for each in self._open:
            if self._stopped and not was and each.stopped is None:
                each.stopped = entry.time
                seconds = entry.time - each.since
                events.append(EpisodeEvent("reaction", each, {"by": "e_stop", "seconds": seconds}))
        return events

    def announced(self) -> List[str]:
        """Say in words what fails now and was announced."""
        return [
            f"{each.what}: {text_of(each.group, each.kind)}"
            for each in self._open
            if each.announced
        ]


def _axes(entry: Entry) -> Dict[str, float]:
    """What a command asks for, by names; of texts, the text."""
    kind = COMMANDS[entry.channel]
    if kind == "std_msgs/String":
        return {said(entry): 1.0}
    message = decode(entry, kind)
    if kind == "control_msgs/JointJog":
        moved = message.velocities or message.displacements
        return _finite(dict(zip(message.joint_names, moved)))
    if kind == "telex_msgs/FlipperPresetHold":
        return {str(message.preset): 1.0 if message.preset else 0.0}
    if kind == "geometry_msgs/PoseStamped":
        return _finite(_numbers("position", message.pose.position))
    twist = message.twist if kind == "geometry_msgs/TwistStamped" else message
    return _finite({**_numbers("linear", twist.linear), **_numbers("angular", twist.angular)})


def _numbers(name: str, vector: Any) -> Dict[str, float]:
    return {f"{name}.x": vector.x, f"{name}.y": vector.y, f"{name}.z": vector.z}


def _finite(axes: Dict[str, float]) -> Dict[str, float]:
    return {name: value for name, value in axes.items() if math.isfinite(value)}
