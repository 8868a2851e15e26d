"""State of the emergency stop, from two sources that may disagree."""

from __future__ import annotations


class EStopState:
    """The emergency stop as a listener sees it.

    ``e_stop`` may have several publishers, each with a latched value of its own, and somebody who
    joins late gets these in any order: a release among them may be older than the stop. The robot's
    status is one latched publisher that tells what holds. Where it exists it decides; a stop is
    obeyed at once all the same.
    """

    def __init__(self) -> None:
        self.active = False
        self._told_by_robot = False

    def take_request(self, active: bool) -> None:
        """Take a message of ``e_stop``."""
        if active or not self._told_by_robot:
            self.active = active

    def take_status(self, active: bool) -> None:
        """Take what the robot's status says."""
        self._told_by_robot = True
        self.active = active
