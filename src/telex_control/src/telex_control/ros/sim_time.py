"""Conversion of sim time."""

from __future__ import annotations

import genpy


def stamp(seconds: float) -> genpy.Time:
    """Return `seconds` as a message stamp, rounded to the nanosecond.

    rospy's own conversion truncates, so that 0.006 s would become 5999999 ns and differ from the
    clock's stamp of the same instant.
    """
    return genpy.Time(0, round(seconds * 1e9))
