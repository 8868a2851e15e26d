"""Errors of the tool on its path."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import List, Optional, Sequence, Tuple

import numpy as np

from . import FollowTrajectoryError
from .reference import PlannedPath

AXES = ("x", "y", "z")


@dataclass(frozen=True)
class PathRecording:
    """What the joints did.

    Attributes
    ----------
    times : ndarray, shape (n,)
        Since the start of the path, rising (s).
    positions : ndarray, shape (n, joints)
        Measured (rad, m), in the order of the chain.
    overdue : ndarray, shape (m,)
        By how long the next reference was overdue, whenever a controller told what it holds (s);
        empty where nobody asked.
    """

    times: np.ndarray
    positions: np.ndarray
    overdue: np.ndarray = field(default_factory=lambda: np.empty(0))


def overdue(
    due: Sequence[float], sent: Sequence[float], looks: Sequence[Tuple[float, float]]
) -> List[float]:
    """Tell how long a controller had been waiting for a reference, each time that it told its own.

    Parameters
    ----------
    due : sequence of float
        When references were wanted, rising (s): a controller uses one from the cycle after.
    sent : sequence of float
        The references (rad, m).
    looks : sequence of tuple
        Time, rising, and what the controller then held (s; rad, m).

    Returns
    -------
    list of float
        Since when the reference after the one that it held was due, or 0 (s). A look at a joint
        that rests tells nothing and has no entry.
    """
    found: List[float] = []
    held, newest = -1, -1
    for time, value in looks:
        while newest + 1 < len(due) and due[newest + 1] < time:
            newest += 1
        at = next((i for i in range(newest, max(held, 0) - 1, -1) if sent[i] == value), None)
        if at is None:
            continue
        held = at
        moves = held < newest or (held > 0 and sent[held] != sent[held - 1])
        if moves:
            found.append(time - due[held + 1] if held < newest else 0.0)
    return found


@dataclass(frozen=True)
class TrackingResult:
    """Desired and measured way of the tool, in the base link's frame.

    Attributes
    ----------
    name : str
        Of the path.
    times : ndarray, shape (n,)
        s.
    desired, measured : ndarray, shape (n, 3)
        Places at these times (m).
    overdue : ndarray, shape (m,)
        See `PathRecording`.
    """

    name: str
    times: np.ndarray
    desired: np.ndarray
    measured: np.ndarray
    overdue: np.ndarray = field(default_factory=lambda: np.empty(0))

    @property
    def error(self) -> np.ndarray:
        """Measured minus desired place, shape (n, 3) (m)."""
        return self.measured - self.desired

    @property
    def figures(self) -> TrackingFigures:
        """Figures of the errors."""
        error = self.error
        distance = np.linalg.norm(error, axis=1)
        return TrackingFigures(
            rms=float(np.sqrt(np.mean(distance**2))),
            largest=float(distance.max()),
            rms_by_axis=_three(np.sqrt(np.mean(error**2, axis=0))),
            largest_by_axis=_three(np.abs(error).max(axis=0)),
            delay=self._delay(),
            length=float(np.linalg.norm(np.diff(self.desired, axis=0), axis=1).sum()),
            duration=float(self.times[-1] - self.times[0]),
            overdue=_three(np.percentile(self.overdue, (50, 99, 100)))
            if len(self.overdue)
            else None,
        )

    def _delay(self) -> float:
        """Time by which the tool is behind, as fits best: the error's share along the speed."""
        speed = np.gradient(self.desired, self.times, axis=0)
        return float(-np.sum(self.error * speed) / max(np.sum(speed**2), 1e-12))


@dataclass(frozen=True)
class TrackingFigures:
    """Figures of a followed path.

    Attributes
    ----------
    rms, largest : float
        Distance of the tool from where it is to be at the same time (m).
    rms_by_axis, largest_by_axis : tuple of 3 floats
        The same by axis (m).
    delay : float
        By which it is behind, in the mean (s).
    length : float
        Of the path (m).
    duration : float
        s.
    overdue : tuple of 3 floats, optional
        By how long the next reference was overdue at the controllers: in the median, the 99th
        percentile and at most (s).
    """

    rms: float
    largest: float
    rms_by_axis: Tuple[float, float, float]
    largest_by_axis: Tuple[float, float, float]
    delay: float
    length: float
    duration: float
    overdue: Optional[Tuple[float, float, float]] = None


def _three(values: np.ndarray) -> Tuple[float, float, float]:
    x, y, z = (float(value) for value in values)
    return (x, y, z)


def analyse(name: str, motion: PlannedPath, recording: PathRecording) -> TrackingResult:
    """Find where the tool was, by forward kinematics of the measured joint positions.

    Raises
    ------
    FollowTrajectoryError
        There is too little to look at, or it does not reach to the end of the path.
    """
    last = float(recording.times[-1]) if len(recording.times) else 0.0
    inside = (recording.times >= 0.0) & (recording.times <= motion.profile.duration)
    times = recording.times[inside]
    if len(times) < 10 or last < motion.profile.duration:
        raise FollowTrajectoryError(
            f"{len(times)} joint states in the {motion.profile.duration:.1f} s of the path, the "
            f"last at {last:.1f} s; more are needed"
        )
    measured = np.array([motion.chain.forward(q)[:3, 3] for q in recording.positions[inside]])
    return TrackingResult(name, times, motion.tool(times), measured, recording.overdue)
