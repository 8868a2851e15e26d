"""From a key in the browser to the picture that shows the motion."""

from __future__ import annotations

import bisect
import statistics
import time
from typing import Any, Callable, List, Mapping, Optional, Sequence

import rospy
from sensor_msgs.msg import CameraInfo, JointState

from telex_experiments.console.keys import Presses, listen_to_keys
from telex_experiments.console.rig import JOG, ConsoleRig, Heard, have_large
from telex_experiments.rigs.report import Figure, MeasurementError

JOINT, CAMERA = "turret_joint", "front"
MOVING = 0.05
"""Part of the commanded velocity from which on the joint moves."""

WITHIN = 1.0
"""Longest time (s) after a press at which something can still be its effect."""

TIED = 0.002
"""Error (s) that is allowed for when a picture is recognised by its time."""


class Stamps:
    """The stamps (s, sim time) of joint states and pictures, and the joint's velocity (rad/s)."""

    def __init__(self) -> None:
        self.velocities: List[Heard] = []
        self.pictures: List[float] = []
        self.ahead = float("inf")
        """Wall time less sim time (s), by the message that came quickest."""
        self._subscribers = [
            _subscriber("joint_states", JointState, self._on_joint_states),
            # Sent just before its picture, with the same stamp.
            _subscriber(f"cameras/{CAMERA}/camera_info", CameraInfo, self._on_camera_info),
        ]

    def _on_joint_states(self, message: JointState) -> None:
        stamp = message.header.stamp.to_sec()
        self.ahead = min(self.ahead, time.time() - stamp)
        if JOINT in message.name:
            self.velocities.append(Heard(stamp, message.velocity[message.name.index(JOINT)]))

    def _on_camera_info(self, message: CameraInfo) -> None:
        self.pictures.append(message.header.stamp.to_sec())

    def forget(self) -> None:
        """Begin anew: over a long time the clocks go apart."""
        del self.velocities[:], self.pictures[:]
        self.ahead = float("inf")

    def close(self) -> None:
        """Hear no more."""
        for subscriber in self._subscribers:
            subscriber.unregister()


def _subscriber(topic: str, kind: type, receive: Callable[[Any], None]) -> rospy.Subscriber:
    return rospy.Subscriber(f"/telex/{topic}", kind, receive, queue_size=100, tcp_nodelay=True)


def first_picture(
    pressed: float, speed: float, stamps: Stamps, painted: Sequence[Mapping[str, float]]
) -> Optional[float]:
    """Return when (s, wall) the motion that a key has begun was painted first.

    Parameters
    ----------
    pressed
        When the key was pressed (s, wall).
    speed
        What it commands (rad/s).
    painted
        Pictures: wall time of the scene, known to the 10 ms between two clock messages, and of
        the end of painting (s).

    Returns
    -------
    time
        None where nothing moved within WITHIN, or no picture showed it.
    """
    since = pressed - stamps.ahead
    moved = [
        each.at
        for each in stamps.velocities
        if since < each.at < since + WITHIN and abs(each.value) >= MOVING * speed
    ]
    pictures = sorted(stamps.pictures)
    if not (moved and pictures) or moved[0] > pictures[-1]:
        return None
    # A picture's own time is late by up to one clock message, never early.
    stamp = pictures[bisect.bisect_left(pictures, moved[0])]
    ends = [
        each["painted"]
        for each in painted
        if each["captured"] >= stamp + stamps.ahead - TIED and each["painted"] > pressed
    ]
    return min(ends, default=None)


def key_to_picture(rig: ConsoleRig, presses: int) -> List[Figure]:
    """Turn the turret to and fro by its keys, the front camera large."""
    times: List[float] = []
    missed = 0
    with rig.browser() as browser:
        have_large(browser, "front", "ARM")
        stamps = Stamps()
        listen_to_keys(browser)
        operator = Presses(rig, browser)
        time.sleep(2.0)
        for number in range(presses):
            code = "JL"[number % 2]
            stamps.forget()
            rig.wire.forget()
            browser.evaluate_in_worker("takeTally()")
            operator.do(f"Key{code}")
            pressed, painted = _of_page(browser)
            speed = max((abs(each.value) for each in rig.wire.heard(JOG)), default=0.0)
            end = first_picture(pressed, speed, stamps, painted) if speed else None
            if end is None:
                missed += 1
            else:
                times.append(end - pressed)
        stamps.close()
    if not times:
        raise MeasurementError("no press was seen in a picture")
    times.sort()
    name = "key down to painted motion"
    return [
        Figure(f"{name}: presses", presses),
        Figure(f"{name}: presses without effect", missed, at_most=0),
        Figure(f"{name}: median", statistics.median(times) * 1e3, "ms", at_most=150.0),
        Figure(f"{name}: 95 %", times[len(times) * 95 // 100] * 1e3, "ms"),
        Figure(f"{name}: longest", times[-1] * 1e3, "ms"),
    ]


def _of_page(browser: Any) -> Any:
    """Return when the last key was pressed, and what was painted, by wall time (s)."""
    tally = browser.evaluate_in_worker("takeTally()")
    pressed = browser.evaluate("performance.timeOrigin + benchmarkPresses.splice(0).pop()")
    painted = [
        {key: (tally["origin"] + each[key]) / 1e3 for key in ("captured", "painted")}
        for each in tally["cameras"].get(CAMERA, {"last": []})["last"]
        if each["captured"] is not None
    ]
    return pressed / 1e3, painted
