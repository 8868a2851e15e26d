"""Reads sim time less often than it is published, where nothing hangs on its last digits.

A message of 100 Hz costs a node of rospy more than 1 % of a processor, whatever is done with it:
what costs is to wake up for each. So the thread that reads `/clock` rests after each message, and
then takes the newest of those that have come meanwhile.
"""

from __future__ import annotations

import collections
import time
from typing import Any, Deque, Optional, Tuple

import rospy.impl.simtime
from rospy.rostime import _set_rostime

COARSE_PERIOD = 0.05
"""Wall time (s) between two readings."""


def read_clock_seldom() -> None:
    """Let the node that begins in this process next have a clock with steps of `COARSE_PERIOD`."""
    rospy.impl.simtime._set_rostime_clock_wrapper = _take


def last_reading() -> Optional[Tuple[float, float]]:
    """Return the last sim time read (s), and when that was on this machine's monotonic clock (s).

    None before the first one, and in a node whose clock is not coarse.
    """
    return _readings[-1] if _readings else None


_readings: Deque[Tuple[float, float]] = collections.deque(maxlen=1)


def _take(message: Any) -> None:
    _readings.append((message.clock.to_sec(), time.monotonic()))
    _set_rostime(message.clock)
    time.sleep(COARSE_PERIOD)
