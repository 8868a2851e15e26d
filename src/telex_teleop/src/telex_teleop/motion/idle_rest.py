"""Lets the threads that read joint states rest while nothing is to be moved."""

from __future__ import annotations

import threading
from typing import Optional

LONGEST_REST = 0.05
"""Time (s) between two joint states that an idle node reads."""


class IdleRest:
    """Holds up idle threads, and lets them go as soon as there is something to do.

    A thread of rospy that is held up in its callback leaves messages in its socket, and takes the
    newest of them afterwards: what costs processor time is to wake up for each.
    """

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._commands = 0
        self._idle_since: Optional[int] = None
        self._last: Optional[float] = None
        self._last_wall = 0.0
        self._longest = LONGEST_REST

    @property
    def commands(self) -> int:
        """Number of commands that have come."""
        return self._commands

    def wake(self) -> None:
        """A command has come."""
        with self._changed:
            self._commands += 1
            self._changed.notify_all()

    def settle(self, idle: bool, commands: int, stamp: float, wall: float) -> None:
        """Rest if a joint state has left nothing to do.

        Parameters
        ----------
        idle
            Whether nothing is to be moved.
        commands
            Their number before that was found out: a later one ends the rest before it begins.
        stamp, wall
            Of the joint state: sim time and monotonic time of arrival (s). Where sim time goes
            faster than the wall's, the rest is so much shorter.
        """
        last, elapsed = self._last, wall - self._last_wall
        self._last, self._last_wall = stamp, wall
        self._idle_since = commands if idle else None
        if idle and last is not None and elapsed > 0.0:
            self._longest = LONGEST_REST / max(1.0, (stamp - last) / elapsed)
            self._rest(commands, self._longest)

    def follow(self) -> None:
        """Rest in another thread, as long, while the one of the joint states is idle."""
        commands = self._idle_since
        if commands is not None:
            self._rest(commands, self._longest)

    def _rest(self, commands: int, seconds: float) -> None:
        with self._changed:
            self._changed.wait_for(lambda: self._commands != commands, seconds)
