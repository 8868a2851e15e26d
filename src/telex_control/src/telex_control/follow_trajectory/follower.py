"""Leads the joints through a motion, and records what they do."""

from __future__ import annotations

import math
from typing import Callable, Mapping, Protocol

import numpy as np

from . import FollowTrajectoryError
from .analysis import PathRecording
from .reference import PlannedPath

APPROACH = 0.5
"""Share of the velocity limits at which the start of a path is approached."""
REST = 1.0
"""Time (s) for which the joints rest before a path begins: integral terms settle."""
TAIL = 0.5
"""Time (s) that is recorded after the end of a path."""
AWAY = {"default": 0.02, "prismatic": 0.005}
"""A joint further than this (rad, m) from the start of the path is held by something."""

_PEAK = 1.875
"""Peak over mean velocity of the polynomial of fifth order from rest to rest."""


class PathRig(Protocol):
    """A robot whose arm joints have position controllers."""

    def reference(self, joint: str) -> float:
        """What the joint's controller holds (rad, m)."""

    def position(self, joint: str) -> float:
        """Measured position (rad, m)."""

    def lag(self) -> float:
        """Time by which the controllers let a moving reference wait (s)."""

    def stream(
        self, references: Callable[[float], Mapping[str, float]], end: float
    ) -> PathRecording:
        """Send references until a time, and record the joint positions meanwhile.

        Parameters
        ----------
        references : callable
            Position by joint (rad, m) at a time (s); the first time is 0.
        end : float
            s.
        """

    def wait(self, seconds: float) -> None:
        """Let sim time pass."""


def approach(rig: PathRig, motion: PlannedPath, positions: np.ndarray) -> None:
    """Lead the arm's joints to `positions` together, without a jump of velocity.

    Raises
    ------
    FollowTrajectoryError
        A joint did not get there.
    """
    names = motion.chain.joint_names
    start = np.array([rig.reference(name) for name in names])
    way = positions - start
    times = _PEAK * np.abs(way) / (APPROACH * motion.chain.velocity_limits)
    duration = max(float(times.max()), 0.1)

    def reference(time: float) -> Mapping[str, float]:
        share = min(time / duration, 1.0)
        progress = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
        return dict(zip(names, (start + way * progress).tolist()))

    rig.stream(reference, duration)
    rig.wait(REST)
    for name, joint, wanted in zip(names, motion.chain.joints, positions):
        error = abs(rig.position(name) - wanted)
        if not error <= AWAY.get(joint.kind, AWAY["default"]):
            raise FollowTrajectoryError(
                f"{name} is {error:.3f} from {wanted:.3f}, where the path begins; something holds "
                "it (the emergency stop, an obstacle, another program)"
            )


def follow(rig: PathRig, motion: PlannedPath) -> PathRecording:
    """Follow a motion from its start, where the arm already is.

    The controllers smooth what they are sent, which delays it by a known time; the references run
    ahead of the path by as much.
    """
    names, lead = motion.chain.joint_names, rig.lag()
    end = motion.profile.duration + TAIL
    if not math.isfinite(lead):
        raise FollowTrajectoryError(f"the controllers' lag is {lead} s; it must be finite")

    def reference(time: float) -> Mapping[str, float]:
        return dict(zip(names, motion.reference(time + lead).tolist()))

    return rig.stream(reference, end)
