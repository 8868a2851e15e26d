"""Common core of the teleoperation nodes: when nothing is obeyed, and why.

Free of ROS, not thread-safe: whoever owns a core serialises the calls.
"""

from __future__ import annotations

import abc
from typing import Optional

from telex_teleop.motion.idle_rest import LONGEST_REST
from telex_teleop.motion.speed import SpeedScale
from telex_teleop.motion.stream import Clocks, SimTicks, StartingTime

NEEDS_NEW_PRESS = "a command from before the stop goes on: release the key and press it again"


class TeleopCore(abc.ABC):
    """Obeys nothing before the first joint state, after its start, in an emergency stop or a pause.

    It begins so because a stream of commands may be running that was meant for its predecessor.

    Parameters
    ----------
    command_timeout
        Age (s) at which a command that is not repeated ends.
    longest_step
        Joint states further apart than this (s of sim time), or running backwards, start everything
        anew.
    speed
        The operator's speed, shared with whoever sets it.
    """

    def __init__(self, command_timeout: float, longest_step: float, speed: SpeedScale) -> None:
        self.speed = speed
        self._command_timeout = command_timeout
        self._ticks = SimTicks(longest_step)
        self._last_wall: Optional[float] = None
        self._starting = StartingTime(command_timeout)
        self._e_stop = False

    def set_e_stop(self, active: bool) -> None:
        """Begin or end an emergency stop."""
        if active != self._e_stop:
            self._e_stop = active
            self._inhibit()

    @abc.abstractmethod
    def restart(self, stamp: float) -> None:
        """Forget all motion: the robot was put somewhere else at `stamp` (s of sim time)."""

    @property
    @abc.abstractmethod
    def idle(self) -> bool:
        """Whether the last joint state left nothing to move, so that others may be left out."""

    def _arrival(self, wall: float) -> Clocks:
        """Return the time of a command that arrives at `wall` (monotonic, s), after a joint state.

        An idle node looks seldom at these: the newest one may be older than the simulation is.
        """
        assert self._ticks.now is not None
        ahead = wall - self._last_wall if self.idle and self._last_wall is not None else 0.0
        return Clocks(wall, self._ticks.now + max(0.0, min(LONGEST_REST, ahead)))

    @abc.abstractmethod
    def _inhibit(self) -> None:
        """Tell the streams of commands whether they are `_inhibited` now."""

    @property
    def _inhibited(self) -> bool:
        return self._e_stop or self._starting.lasts

    def _inhibition(self, wall: float) -> str:
        """Return why no command at all is obeyed at `wall` (monotonic, s); empty when some are."""
        if self._ticks.now is None or self._last_wall is None:
            return "no joint_states yet: is the simulator running?"
        if self._e_stop:
            return "the e-stop is active"
        if self._paused(wall):
            return "no joint_states: the simulation is paused or has ended"
        return "just started" if self._starting.lasts else ""

    def _paused(self, wall: float) -> bool:
        """Tell whether no joint state has come for a while before `wall` (monotonic, s)."""
        return self._last_wall is not None and wall - self._last_wall > 2.0 * self._command_timeout
