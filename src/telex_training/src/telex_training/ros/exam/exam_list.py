"""Has the bridge hold an exam's list, and lets go of it."""

from __future__ import annotations

import threading
from functools import partial
from typing import Callable, List, Sequence

import rospy
from std_msgs.msg import String

WITHIN = 3.0
"""Wall time for the bridge to say that the list holds (s)."""
_TOKEN = "instructor_token_file"


class ExamListError(RuntimeError):
    """No exam can begin; the message says what to do."""


class ExamList:
    """The list that holds at the bridge for all but instructors while an exam runs.

    ``training/exam`` says for which trial it is wanted, ``bridge/exam`` for which it holds. Both
    are latched, and no client of the bridge can publish them. A node that comes anew wants none.
    Where there are several robots, the list holds at the bridge of each.

    Parameters
    ----------
    bridge : str
        The bridge's name.
    lifted : callable
        Told when a list that is wanted holds no more: an instructor has ended it.
    within : float
        See `WITHIN`.
    others : sequence of str
        Namespaces of further robots.
    """

    def __init__(
        self,
        bridge: str,
        lifted: Callable[[], None],
        within: float = WITHIN,
        others: Sequence[str] = (),
    ) -> None:
        self._bridge = bridge
        self._lifted = lifted
        self._within = within
        self._lock = threading.Condition()
        self._wanted = ""
        self._confirmed = False
        prefixes = ("", *(f"{each}/" for each in others))
        self._held = dict.fromkeys(prefixes, "")
        self._publishers = [
            rospy.Publisher(f"{each}training/exam", String, queue_size=10, latch=True)
            for each in prefixes
        ]
        self._publish("")
        self._heard = [
            rospy.Subscriber(
                f"{each}bridge/exam", String, partial(self._hear, each), tcp_nodelay=True
            )
            for each in prefixes
        ]

    def _publish(self, trial: str) -> None:
        for publisher in self._publishers:
            publisher.publish(String(trial))

    @property
    def trial(self) -> str:
        """Trial for which the list is wanted; empty: none."""
        return self._wanted

    def take(self, trial: str) -> None:
        """Have the list hold for a trial, and return once it does.

        Raises
        ------
        ExamListError
            There is no instructor's token, or the bridge does not answer.
        """
        # Without a token everybody could say that he is an instructor.
        if not all(rospy.get_param(f"{each}{self._bridge}/{_TOKEN}", "") for each in self._held):
            raise ExamListError(
                "an exam needs an instructor's token, and none is set: start the station with "
                f"{_TOKEN}:=FILE, such as run.sh {_TOKEN}:=~/teacher.token, and connect as "
                "instructor with what is in it"
            )
        with self._lock:
            self._wanted, self._confirmed = trial, False
            self._publish(trial)
            self._confirmed = self._lock.wait_for(lambda: not self._open(), self._within)
            missing = self._open()
        if not self._confirmed:
            self.release(trial)
            names = ", ".join(rospy.resolve_name(f"{each}{self._bridge}") for each in missing)
            raise ExamListError(
                f"the bridge has not closed what an exam closes within {self._within:g} s; is it "
                f"running ({names})?"
            )

    def holds(self, trial: str) -> bool:
        """Whether the list of a trial holds, and nobody has ended it since it was taken."""
        with self._lock:
            return self._confirmed and self._wanted == trial

    def _open(self) -> List[str]:
        """Return the robots at whose bridges the list that is wanted does not hold."""
        return [each for each, held in self._held.items() if held != self._wanted]

    def release(self, trial: str) -> None:
        """Let the list of a trial end, unless it is another one's by now."""
        with self._lock:
            if self._wanted != trial:
                return
            self._wanted, self._confirmed = "", False
            self._publish("")

    def _hear(self, robot: str, message: String) -> None:
        with self._lock:
            self._held[robot] = message.data
            self._lock.notify_all()
            lifted = self._confirmed and bool(self._open())
            if lifted:
                self._confirmed = False
        if lifted:
            self._lifted()
