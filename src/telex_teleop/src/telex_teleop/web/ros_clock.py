"""Sim time of a node, finer than it is published."""

from __future__ import annotations

import time

import rospy

from telex_control.ros.rospy_fixes.coarse_clock import last_reading

from .line.sim_clock import SimClock


class RosClock:
    """ROS time (s) as it goes on between two messages of `/clock`; for one thread."""

    def __init__(self) -> None:
        self._clock = SimClock()

    def __call__(self) -> float:
        """Return the time now (s)."""
        now = time.monotonic()
        reading, read = last_reading() or (rospy.get_time(), now)
        return self._clock.at(reading, read, now)
