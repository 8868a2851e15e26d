"""A node with a coarse clock has sim time, and rests between two readings of it."""

from __future__ import annotations

import rospy
import rospy.impl.simtime
from rosgraph_msgs.msg import Clock

from telex_control.ros.rospy_fixes import coarse_clock


def test_the_reader_of_the_clock_rests_after_each_message(monkeypatch):
    monkeypatch.setattr(
        rospy.impl.simtime,
        "_set_rostime_clock_wrapper",
        rospy.impl.simtime._set_rostime_clock_wrapper,
    )
    steps = []
    monkeypatch.setattr(coarse_clock, "_set_rostime", lambda now: steps.append(now.to_sec()))
    monkeypatch.setattr(coarse_clock.time, "sleep", lambda seconds: steps.append(f"{seconds} s"))
    coarse_clock.read_clock_seldom()
    rospy.impl.simtime._set_rostime_clock_wrapper(Clock(rospy.Time(7)))
    assert steps == [7.0, "0.05 s"]
