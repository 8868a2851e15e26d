"""The way that joints have before them, followed inside speed and acceleration limits.

The way is a polyline of postures, which the joints never leave: where a limit binds they are late
on it. They are never so fast that they could not come to rest on what is known of it. The end of
the way may therefore be moved on, or left where it is, at any time.

All kernels stand in one file, as in `kernels`.
"""

from __future__ import annotations

import math
from typing import Tuple

import numpy as np

from .compiled import compiled

_ROUNDING = 1e-9
"""Share of an acceleration limit that is left to rounding."""
_SAME = 1e-9
"""Distance of a posture (rad, m), or of a place, from another that is taken for none."""
_FINEST = 0.07
"""Share of what a tick could go, of two segments at most, to which its end is found."""
_TINY = 1e-15
"""rad, m; above 0 even where limits are so small that their products are not."""
_TICKS = 10000
"""Beyond which braking counts as endless."""


@compiled
def _scan(
    path: np.ndarray,
    first: int,
    share: float,
    here: np.ndarray,
    step: np.ndarray,
    reach: np.ndarray,
    change: np.ndarray,
) -> Tuple[float, float]:
    """Least and largest place on the path where a tick from `here` may end; -1 where none is.

    A place is the number of a segment plus a share of it. The joints have moved by `step` in the
    tick before; what lies before the place first + share is left out.
    """
    least, most = -1.0, -1.0
    for s in range(first, len(path) - 1):
        low, high = share if s == first else 0.0, 1.0
        for j in range(path.shape[1]):
            way = path[s + 1, j] - path[s, j]
            off = path[s, j] - here[j]
            lower = max(step[j] - change[j], -reach[j]) - off
            upper = min(step[j] + change[j], reach[j]) - off
            if way > 0.0:
                low, high = max(low, lower / way), min(high, upper / way)
            elif way < 0.0:
                low, high = max(low, upper / way), min(high, lower / way)
            elif lower > 0.0 or upper < 0.0:
                high = -1.0
            if low > high:
                break
        if low <= high:
            if least < 0.0:
                least = s + low
            most = s + high
            if high < 1.0:
                break
        elif least >= 0.0:
            break
    return least, most


@compiled
def _put(path: np.ndarray, place: float, out: np.ndarray) -> Tuple[int, float]:
    """Fill in the posture at a place; return its segment and share."""
    s = min(int(place), len(path) - 2)
    share = place - s
    for j in range(out.size):
        if share < 1.0:
            out[j] = path[s, j] + share * (path[s + 1, j] - path[s, j])
        else:
            out[j] = path[s + 1, j]
    return s, share


@compiled
def _braked(
    path: np.ndarray,
    begin: np.ndarray,
    place: float,
    fraction: float,
    reach: np.ndarray,
    change: np.ndarray,
    stop: np.ndarray,
) -> float:
    """Brake on the path from a place to which the joints moved from `begin` within a tick.

    Later ticks have a `fraction` of its length; `reach` and `change` are theirs. Returns the place
    where the joints come to rest, which `stop` gets; -1 where they cannot.
    """
    n = begin.size
    here, step = begin.copy(), np.empty(n)
    for _ in range(_TICKS):
        s, share = _put(path, place, stop)
        at_rest = True
        for j in range(n):
            step[j] = fraction * (stop[j] - here[j])
            here[j] = stop[j]
            at_rest = at_rest and abs(step[j]) <= change[j]
        if at_rest:
            return place
        least, _most = _scan(path, s, share, here, step, reach, change)
        # A place not beyond the present one would be a rest, which was not possible.
        if least <= place:
            return -1.0
        place, fraction = least, 1.0
    return -1.0


@compiled
def _advance(
    path: np.ndarray,
    step: np.ndarray,
    reach: np.ndarray,
    change: np.ndarray,
    fraction: float,
    moved: np.ndarray,
    stop: np.ndarray,
) -> Tuple[float, float]:
    """Fill in where the joints are a tick later, and where they could come to rest after that.

    `step` is that of the tick before, then that of this one; `fraction` is how long, against this
    one, the ticks are in which they could brake. Returns both places on the path.
    """
    n = step.size
    begin = path[0].copy()
    allowed, slower, braking = change.copy(), np.empty(n), np.empty(n)
    least, most = _scan(path, 0, 0.0, begin, step, reach, allowed)
    while least < 0.0:
        # After a tick of another length: rather too hard a braking than off the path.
        for j in range(n):
            allowed[j] = 1.25 * allowed[j] + _TINY
        least, most = _scan(path, 0, 0.0, begin, step, reach, allowed)
    for j in range(n):
        slower[j] = fraction * reach[j]
        braking[j] = (1.0 - _ROUNDING) * fraction * fraction * change[j]
    place = most
    end = _braked(path, begin, place, fraction, slower, braking, stop)
    if end < 0.0:
        below, above = least, most
        width = max(_FINEST * min(most - least, 2.0), _SAME)
        while above - below > width:
            place = 0.5 * (below + above)
            end = _braked(path, begin, place, fraction, slower, braking, stop)
            if end < 0.0:
                above = place
            else:
                below = place
        place = below
        end = _braked(path, begin, place, fraction, slower, braking, stop)
        if end < 0.0:
            end = len(path) - 1.0
            _put(path, end, stop)
    _put(path, place, moved)
    for j in range(n):
        step[j] = moved[j] - begin[j]
    return place, end


class PosturePath:
    """The way of `count` joints.

    Attributes
    ----------
    step : ndarray, shape (n,)
        What they moved by in the tick before (rad, m).
    """

    def __init__(self, count: int) -> None:
        self._points = np.empty((64, count))
        self._first = self._last = self._firm = 0
        self.step = np.zeros(count)
        self._moved, self._stop = np.empty(count), np.empty(count)
        self._stop_row = 0
        self.begin(self.step)

    def begin(self, q: np.ndarray) -> None:
        """Rest at a posture, with no way to go."""
        self._first = self._last = self._firm = self._stop_row = 0
        self._points[0] = self._stop[:] = q
        self.step[:] = 0.0

    def warm_up(self) -> None:
        """Compile, or load from the cache, what will be needed."""
        n = self.step.size
        path, limits = np.zeros((2, n)), np.ones(n)
        _advance(path, np.zeros(n), limits, limits, 1.0, np.empty(n), np.empty(n))

    def stands_at(self, q: np.ndarray) -> bool:
        """Whether the joints are at a posture."""
        largest: float = max(abs(q - self._points[self._first]).tolist())
        return largest <= _SAME

    @property
    def position(self) -> np.ndarray:
        """Where the joints are, shape (n,)."""
        return self._points[self._first].copy()

    @property
    def end(self) -> np.ndarray:
        """Where the way ends, shape (n,)."""
        return self._points[self._last].copy()

    @property
    def count(self) -> int:
        """How many postures are still to be passed."""
        return self._last - self._first

    def append(self, q: np.ndarray, *, firm: bool) -> None:
        """Lengthen the way by a posture; one that is firm is not cut off by `shorten`."""
        if self._last + 1 == len(self._points):
            rows = self._points[self._first : self._last + 1].copy()
            if 2 * len(rows) > len(self._points):
                self._points = np.empty((2 * len(self._points), q.size))
            self._points[: len(rows)] = rows
            self._firm -= self._first
            self._stop_row -= self._first
            self._first, self._last = 0, len(rows) - 1
        self._last += 1
        self._points[self._last] = q
        if firm:
            self._firm = self._last

    def shorten(self, *, entirely: bool = False) -> None:
        """Cut off what comes after the last firm posture and is not needed to come to rest.

        Parameters
        ----------
        entirely : bool
            Firm postures too.
        """
        if self._firm <= self._stop_row or entirely:
            # The posture of rest lies between this row and the next.
            self._last = min(self._last, self._stop_row)
            self._firm = min(self._firm, self._last)
            self.append(self._stop, firm=False)
        else:
            self._last = min(self._last, self._firm)

    def advance(self, reach: np.ndarray, change: np.ndarray, fraction: float) -> None:
        """Go on by one tick.

        Parameters
        ----------
        reach : ndarray, shape (n,)
            How far each joint may move in it (rad, m), above 0.
        change : ndarray, shape (n,)
            By how much this may differ from the tick before.
        fraction : float
            How long later ticks have to be counted on to be, against this one.
        """
        if self._first == self._last:
            self.step[:] = 0.0
            return
        path = self._points[self._first : self._last + 1]
        place, end = _advance(path, self.step, reach, change, fraction, self._moved, self._stop)
        self._stop_row = self._first + math.floor(end)
        self._first += math.floor(place)
        self._points[self._first] = self._moved
