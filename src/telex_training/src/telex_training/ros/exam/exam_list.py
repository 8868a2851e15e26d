"""Has the bridge hold an exam's list, and lets go of it."""

from __future__ import annotations

import threading
from typing import Callable

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

    Parameters
    ----------
    bridge : str
        The bridge's name.
    lifted : callable
        Told when a list that is wanted holds no more: an instructor has ended it.
    within : float
        See `WITHIN`.
    """

    def __init__(self, bridge: str, lifted: Callable[[], None], within: float = WITHIN) -> None:
        self._bridge = bridge
        self._lifted = lifted
        self._within = within
        self._lock = threading.Condition()
        self._wanted = self._held = ""
        self._confirmed = False
        self._publisher = rospy.Publisher("training/exam", String, queue_size=10, latch=True)
        self._publisher.publish(String(""))
        self._heard = rospy.Subscriber("bridge/exam", String, self._hear, tcp_nodelay=True)

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
        if not rospy.get_param(f"{self._bridge}/{_TOKEN}", ""):
            raise ExamListError(
                "an exam needs an instructor's token, and none is set: start the station with "
                f"{_TOKEN}:=FILE, such as run.sh {_TOKEN}:=~/teacher.token, and connect as "
                "instructor with what is in it"
            )
        with self._lock:
            self._wanted, self._confirmed = trial, False
            self._publisher.publish(String(trial))
            self._confirmed = self._lock.wait_for(lambda: self._held == trial, self._within)
        if not self._confirmed:
            self.release(trial)
            raise ExamListError(
                f"the bridge has not closed what an exam closes within {self._within:g} s; is it "
                f"running ({rospy.resolve_name(self._bridge)})?"
            )

    def release(self, trial: str) -> None:
        """Let the list of a trial end, unless it is another one's by now."""
        with self._lock:
            if self._wanted != trial:
                return
            self._wanted, self._confirmed = "", False
            self._publisher.publish(String(""))

    def _hear(self, message: String) -> None:
        with self._lock:
            self._held = message.data
            self._lock.notify_all()
            lifted = self._confirmed and self._held != self._wanted
            if lifted:
                self._confirmed = False
        if lifted:
            self._lifted()
