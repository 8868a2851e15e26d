"""Command streams: the watchdog that stops them, and the latch that the emergency stop sets.

A client repeats its command while a key is held. Silence is a command to stop, whatever caused it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic, Optional, TypeVar

__all__ = ["Clocks", "CommandStream", "SimTicks", "Tick"]

Command = TypeVar("Command")


@dataclass(frozen=True)
class Clocks:
    """One instant on the two clocks that a stream is judged by.

    Attributes
    ----------
    wall
        Monotonic time of this machine (s): goes on while the simulation is paused.
    sim
        Stamp of the newest joint state (s): goes on faster than wall time in a fast simulation.
    """

    wall: float
    sim: float


class CommandStream(Generic[Command]):
    """The newest command of one stream, while it is valid.

    Parameters
    ----------
    timeout
        A command older than this (s), on either clock, is a command to stop.
    """

    def __init__(self, timeout: float) -> None:
        self._timeout = timeout
        self._command: Optional[Command] = None
        self._received: Optional[Clocks] = None
        self._validity = timeout
        self._heard: Optional[float] = None
        self._inhibited = False
        self._latched = False

    @property
    def latched(self) -> bool:
        """Whether a running stream is ignored until it pauses."""
        return self._latched

    def receive(self, command: Command, now: Clocks, validity: Optional[float] = None) -> bool:
        """Take a command that asks for motion.

        Parameters
        ----------
        command
            What is wanted.
        now
            Time of arrival.
        validity
            Time (s) that the command holds when it is not repeated; never longer than the timeout.

        Returns
        -------
        bool
            Whether the command is obeyed.
        """
        paused = self._heard is None or now.wall - self._heard >= self._timeout
        self._heard = now.wall
        if self._inhibited or (self._latched and not paused):
            return False
        self._latched = False
        self._command = command
        self._received = now
        self._validity = self._timeout if validity is None else min(validity, self._timeout)
        return True

    def end(self) -> None:
        """Take a command to stop; it also ends the wait for a pause."""
        self._command = None
        self._heard = None
        self._latched = self._inhibited

    def discard(self) -> None:
        """Forget the command; the stream may go on with its next message."""
        self._command = None

    def latch(self) -> None:
        """Forget the command and ignore the stream until it has paused or sent a stop."""
        self._command = None
        self._latched = True

    def inhibit(self, inhibited: bool) -> None:
        """Ignore all commands while inhibited, and then the stream that ran meanwhile."""
        self._inhibited = inhibited
        if inhibited:
            self.latch()

    def command(self, now: Clocks) -> Optional[Command]:
        """Return the command that holds now, None when there is none or it has become stale."""
        if self._command is None or self._received is None:
            return None
        age = max(now.wall - self._received.wall, now.sim - self._received.sim)
        if age > self._validity:
            self._command = None
        return self._command

    def waiting(self, wall: float) -> bool:
        """Tell whether a stream is running now that the latch makes us ignore."""
        return self._latched and self._heard is not None and wall - self._heard < self._timeout


@dataclass(frozen=True)
class Tick:
    """One step of sim time: its length (s), or a jump over which nothing can be continued."""

    dt: float
    jumped: bool


class SimTicks:
    """Steps of sim time between joint states.

    Parameters
    ----------
    longest
        A longer step (s), or one backwards, is a jump: the simulation was reset or the robot was
        out of sight.
    """

    def __init__(self, longest: float) -> None:
        self._longest = longest
        self._last: Optional[float] = None

    @property
    def now(self) -> Optional[float]:
        """Stamp of the newest joint state (s), None before the first."""
        return self._last

    def advance(self, stamp: float) -> Optional[Tick]:
        """Return the step to a new stamp (s); None for the first stamp and for a repeated one."""
        last, self._last = self._last, stamp
        if last is None or stamp == last:
            return None
        dt = stamp - last
        jumped = dt < 0.0 or dt > self._longest
        return Tick(0.0 if jumped else dt, jumped)
