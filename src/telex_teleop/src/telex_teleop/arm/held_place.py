"""Keeps the tool's place in the world while the base moves."""

from __future__ import annotations

from typing import Optional

import numpy as np

from telex_control.common.geometry.matrices import inverse
from telex_teleop.arm.tool_settings import ToolSettings
from telex_teleop.motion.rigid_motion import advanced, pose_error, shortened


class HeldPlace:
    """The place, and the twist that keeps the tool there.

    What the base does in a step is made good at once; what could not be, on the tool's own ramp. As
    a twist it is subject to all that bounds the tool's motion: limits, joints' accelerations, and
    what is near.

    Parameters
    ----------
    settings
        Speeds of the way back, and how far the tool may be off before the place is given up.
    """

    def __init__(self, settings: ToolSettings) -> None:
        self._settings = settings
        self._place: Optional[np.ndarray] = None
        self._base: Optional[np.ndarray] = None
        self.active = False

    def hold(self, active: bool) -> None:
        """Begin, at the place where the tool is next time, or end."""
        self.active = active
        self._place = self._base = None

    @property
    def target(self) -> Optional[np.ndarray]:
        """Where the place is in the base's frame (4x4), None while there is none."""
        if self._place is None or self._base is None:
            return None
        return inverse(self._base) @ self._place

    def twist(self, base: Optional[np.ndarray], goal: np.ndarray, dt: float) -> np.ndarray:
        """Return the twist that keeps the tool at its place, along the base's axes, shape (6,).

        Parameters
        ----------
        base : ndarray, shape (4, 4), or None
            Pose of the base in the world, as far as it is known.
        goal : ndarray, shape (4, 4)
            Desired pose of the tool, as the last step has left it.
        dt
            Length of the step (s).
        """
        if not self.active:
            return np.zeros(6)
        before, self._base = self._base, base
        if base is None or before is None or self._place is None:
            return np.zeros(6)
        to_base = inverse(base)
        carried = to_base @ before @ goal
        back = pose_error(to_base @ self._place, carried)
        return pose_error(carried, goal) / dt + self._settings.approach(back, 1.0, dt)

    def keep(
        self, base: Optional[np.ndarray], goal: np.ndarray, reached: np.ndarray, shifted: bool
    ) -> None:
        """Take note of what a step has done.

        Parameters
        ----------
        base, goal
            See `twist`.
        reached : ndarray, shape (4, 4)
            Where the tool is led now.
        shifted
            An operator moves the tool: the place goes with it.
        """
        if not self.active or base is None:
            return
        if shifted or self._place is None:
            self._place = base @ goal
            return
        error = pose_error(inverse(base) @ self._place, reached)
        settings = self._settings
        lead = shortened(error, settings.hold_lead, settings.angular_hold_lead)
        if lead is not error:
            self._place = base @ advanced(reached, lead)
