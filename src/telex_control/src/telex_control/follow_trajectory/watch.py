"""Reasons to end a motion of the arm early: an obstacle ahead, a reset."""

from __future__ import annotations

from typing import Optional

from telex_msgs.msg import Proximity, ProximityPair, SimStatus

STOPPING = 0.2
"""Time (s) of the present approach that is left to stop in: transport, lag of the controllers."""


class MotionWatch:
    """Looks at the reports of the simulator while the arm is led.

    Parameters
    ----------
    clearance : float, optional
        Distance (m) that the arm keeps from what it must not touch; None: whatever is near.

    Attributes
    ----------
    reason : str, optional
        Why the motion has to end, the first time that it had to; None: it may go on.
    """

    def __init__(self, clearance: Optional[float]) -> None:
        self._clearance = clearance
        self._resets: Optional[int] = None
        self.reason: Optional[str] = None

    def on_proximity(self, message: Proximity) -> None:
        """Take what is near. Fingers may touch; motion away is free."""
        if self._clearance is None or self.reason is not None:
            return
        for pair in message.pairs:
            if pair.contact != ProximityPair.GUARDED or not pair.closing_speed > 0.0:
                continue
            if pair.distance < self._clearance + STOPPING * pair.closing_speed:
                self.reason = (
                    f"stopped: {pair.link} is {1000.0 * pair.distance:.0f} mm from {pair.other} "
                    f"and nears it by {1000.0 * pair.closing_speed:.0f} mm/s; another centre or "
                    "another posture to begin from is needed"
                )
                return

    def on_status(self, message: SimStatus) -> None:
        """Take the state of the simulator."""
        if self._resets is not None and message.resets != self._resets and self.reason is None:
            self.reason = "stopped: the simulation was reset on the way, or stood; start again"
        self._resets = message.resets
