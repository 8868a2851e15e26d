"""Command streams: the watchdog that stops them, and the latch that the emergency stop sets.

A client repeats its command while a key is held. Silence is a command to stop, whatever caused it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Collection, Dict, Generic, Optional, Set, TypeVar

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

    Several clients may send; each is known by the name of its node. What is latched is the stream
    of each of them: only its own pause or its own stop lets it in again, so that nobody can release
    a key that another operator still holds.

    Parameters
    ----------
    timeout
        A command older than this (s), on either clock, is a command to stop.
    """

    def __init__(self, timeout: float) -> None:
        self._timeout = timeout
        self._command: Optional[Command] = None
        self._caller = ""
        self._received: Optional[Clocks] = None
        self.obeyed = ""
        """Who sent the last command that was obeyed."""
        self._validity = timeout
        self._heard: Dict[str, float] = {}  # client to the wall time of its last command
        self._ignored: Set[str] = set()
        self._inhibited = False

    def receive(
        self, command: Command, now: Clocks, caller: str = "", validity: Optional[float] = None
    ) -> bool:
        """Take a command that asks for motion.

        Parameters
        ----------
        caller
            Who sent it.
        validity
            Time (s) that the command holds when it is not repeated; never longer than the timeout.

        Returns
        -------
        bool
            Whether the command is obeyed.
        """
        self._forget_paused(now.wall)
        self._heard[caller] = now.wall
        if self._inhibited:
            self._ignored.add(caller)
        if caller in self._ignored:
            return False
        self._command = command
        self._caller = caller
        self._received = now
        self.obeyed = caller
        self._validity = self._timeout if validity is None else min(validity, self._timeout)
        return True

    def end(self, caller: str = "") -> None:
        """Take a command to stop from anybody; it also ends the wait for the pause of `caller`."""
        self._command = None
        self._heard.pop(caller, None)
        self._ignored.discard(caller)

    def discard(self) -> None:
        """Forget the command; the stream may go on with its next message."""
        self._command = None

    def keep(self, callers: Collection[str]) -> None:
        """End the command unless its client is one of `callers`: the others are gone."""
        if self._command is not None and self._caller not in callers:
            self.end(self._caller)

    def latch(self) -> None:
        """Forget the command, ignore each running stream until it has paused or sent a stop."""
        self._command = None
        self._ignored.update(self._heard)

    def ignore(self, caller: str) -> None:
        """Ignore the running stream of `caller` until it has paused or sent a stop."""
        if caller in self._heard:
            self._ignored.add(caller)

    def inhibit(self, inhibited: bool) -> None:
        """Ignore all commands while inhibited, and then the streams that ran meanwhile."""
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
        return any(wall - self._heard[caller] < self._timeout for caller in self._ignored)

    def _forget_paused(self, wall: float) -> None:
        for caller in [c for c, heard in self._heard.items() if wall - heard >= self._timeout]:
            del self._heard[caller]
            self._ignored.discard(caller)


class StartingTime:
    """The time after its start in which a node learns who is already sending commands.

    It counts from the first joint state: the node listens to commands before it listens to those,
    so by then it is connected to whoever sends any. A stream repeats its command well within the
    timeout; it is heard within this time, which is twice as long, and then needs a new press.

    Parameters
    ----------
    timeout
        Age (s) at which a command that is not repeated ends.
    """

    def __init__(self, timeout: float) -> None:
        self._length = 2.0 * timeout
        self._began: Optional[float] = None
        self.lasts = True

    def ends(self, wall: float) -> bool:
        """Take a joint state that came at `wall` (monotonic, s); tell whether it is over now."""
        if self._began is None:
            self._began = wall
        if not self.lasts or wall - self._began < self._length:
            return False
        self.lasts = False
        return True


@dataclass(frozen=True)
class TimeStep:
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

    def advance(self, stamp: float) -> Optional[TimeStep]:
        """Return the step to a new stamp (s); None for the first stamp and for a repeated one."""
        last, self._last = self._last, stamp
        if last is None or stamp == last:
            return None
        dt = stamp - last
        jumped = dt < 0.0 or dt > self._longest
        return TimeStep(0.0 if jumped else dt, jumped)
