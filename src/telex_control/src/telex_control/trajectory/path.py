"""The motion ahead of one joint: pieces in order of time, which can be replaced."""

from __future__ import annotations

import bisect
import math
from typing import List, NamedTuple, Optional, Sequence, Union

from .spline import Sample, SplineSegment, State


class Track(NamedTuple):
    """States of one joint and when they are to be reached (s, from the track's start)."""

    times: Sequence[float]
    states: Sequence[State]


class _PlacedTrack:
    """A track from one of its states on, with its place in time and among the turns of the joint.

    Its segments are made one after the other as they are needed: a track may have thousands, and
    is taken over within one control cycle.
    """

    __slots__ = ("_cursor", "_first", "_origin", "_segment", "_track", "_turns", "end_time")

    def __init__(self, track: Track, first: int, origin: float, turns: float) -> None:
        self._track = track
        self._first = first
        self._origin = origin
        self._turns = turns
        self._cursor = first
        self._segment: Optional[SplineSegment] = None
        self.end_time = origin + track.times[-1]

    def shifted(self, by: float) -> _PlacedTrack:
        return _PlacedTrack(self._track, self._first, self._origin + by, self._turns)

    @property
    def start_time(self) -> float:
        return self._origin + self._track.times[self._first]

    def sample(self, time: float) -> Sample:
        times, cursor = self._track.times, self._cursor
        time -= self._origin
        if time < times[cursor]:
            cursor = self._first
            # Rounding alone may bring its first instant before its start.
            time = max(time, times[cursor])
        while cursor + 2 < len(times) and times[cursor + 1] <= time:
            cursor += 1
        if cursor != self._cursor or self._segment is None:
            self._cursor, self._segment = cursor, self._make(cursor)
        return self._turned(self._segment.sample(time))

    def sample_at(self, time: float) -> Sample:
        times = self._track.times
        time = max(time - self._origin, times[self._first])
        index = bisect.bisect_right(times, time) - 1
        return self._turned(self._make(min(index, len(times) - 2)).sample(time))

    def _make(self, index: int) -> SplineSegment:
        times, states = self._track
        return SplineSegment(times[index], states[index], times[index + 1], states[index + 1])

    def _turned(self, sample: Sample) -> Sample:
        return (sample[0] + self._turns, sample[1], sample[2]) if self._turns else sample


_Piece = Union[SplineSegment, _PlacedTrack]


class JointPath:
    """Pieces of one joint's motion; each holds until the next one starts.

    A path is not changed: `replaced` makes another. One thread may call `sample`, any `sample_at`.
    """

    __slots__ = ("_cursor", "_pieces", "_starts")

    def __init__(self, pieces: Sequence[_Piece]) -> None:
        self._pieces: List[_Piece] = list(pieces)
        self._starts = [piece.start_time for piece in self._pieces]
        self._cursor = 0

    @classmethod
    def hold(cls, time: float, position: float) -> JointPath:
        """Return the path that stays at `position` from `time` on."""
        state = State(position, 0.0, 0.0)
        return cls([SplineSegment(time, state, time, state)])

    @classmethod
    def stop(
        cls,
        time: float,
        duration: float,
        position: float,
        velocity: float,
        lower: float = -math.inf,
        upper: float = math.inf,
    ) -> JointPath:
        """Return the path that comes to rest within `duration` (s), evenly slowing down.

        Parameters
        ----------
        position, velocity : float
            At `time`.
        lower, upper : float
            Bounds of where it comes to rest.
        """
        rest = min(max(position + 0.5 * velocity * duration, lower), upper)
        start, end = State(position, velocity), State(rest, 0.0)
        return cls([SplineSegment(time, start, time + duration, end)])

    @property
    def start_time(self) -> float:
        """Before this (s) nothing is known of it."""
        return self._starts[0]

    @property
    def end_time(self) -> float:
        """When its last state is reached (s)."""
        return self._pieces[-1].end_time

    def shifted(self, by: float) -> JointPath:
        """Return the same path, later by so much (s)."""
        return JointPath([piece.shifted(by) for piece in self._pieces])

    def sample(self, time: float) -> Sample:
        """Return position, velocity and acceleration at `time` (s), which mostly grows."""
        starts, cursor = self._starts, self._cursor
        if time < starts[cursor]:
            cursor = 0
        while cursor + 1 < len(starts) and starts[cursor + 1] <= time:
            cursor += 1
        self._cursor = cursor
        return self._pieces[cursor].sample(time)

    def sample_at(self, time: float) -> Sample:
        """Return the same as `sample`, for any time and from any thread."""
        piece = self._pieces[max(bisect.bisect_right(self._starts, time) - 1, 0)]
        return piece.sample_at(time) if isinstance(piece, _PlacedTrack) else piece.sample(time)

    def replaced(
        self, time: float, track: Track, first: int, origin: float, wraps: bool
    ) -> JointPath:
        """Return this path up to `time` (s), and from there through a track.

        Parameters
        ----------
        first : int
            The state of the track that is reached first, not before `time`.
        origin : float
            Time of the track's start (s).
        wraps : bool
            Whether positions that differ by whole turns are the same: the track is moved by as many
            turns as bring its first state nearest to this path.
        """
        start = State(*self.sample_at(time))
        target = track.states[first]
        turns = 0.0
        if wraps:
            way = target.position - start.position
            turns = math.remainder(way, 2.0 * math.pi) - way
            target = target._replace(position=target.position + turns)
        # What lies before the cursor is over.
        pieces = self._pieces[self._cursor : bisect.bisect_left(self._starts, time)]
        pieces.append(SplineSegment(time, start, origin + track.times[first], target))
        if first + 1 < len(track.times):
            pieces.append(_PlacedTrack(track, first, origin, turns))
        return JointPath(pieces)
