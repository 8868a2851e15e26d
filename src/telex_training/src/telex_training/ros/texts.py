"""Texts of the instructor to the trainee: shown until he acknowledges them, and recorded."""

from __future__ import annotations

import threading
from functools import partial
from typing import Any, Callable, Collection, Dict, Sequence

import rospy
from telex_msgs.msg import TrainingText
from telex_msgs.srv import ReadText, ReadTextResponse, TellTrainee, TellTraineeResponse

LONGEST = 200
"""Of a text, in characters: one line that is read at a glance."""
_LONGEST_NAME = 40

ForTeam = Callable[[Any, Callable[[Any], Any], str, str], Callable[[Any], Any]]
"""Makes of a service's class, what answers it, its name and a further robot's namespace what
answers there: it refuses where that robot has no part in what is open.
"""


class TraineeTexts:
    """The newest text, on ``training/text``, latched; ``training/tell`` and ``training/read``.

    Parameters
    ----------
    note : callable
        Told an input of the judge, for the recording of the trial that is under way, if one is.
    reader : callable
        Returns the name of the trainee at a robot, by its namespace; that of the first is empty.
    others : sequence of str
        Namespaces of further robots, where both services and the topic are as well.
    team : callable
        Returns the namespaces of the robots of what is open: others are shown no text.
    for_team : callable
        See `ForTeam`.
    """

    def __init__(
        self,
        note: Callable[[Dict[str, Any]], None],
        reader: Callable[[str], str],
        others: Sequence[str] = (),
        team: Callable[[], Collection[str]] = tuple,
        for_team: ForTeam = lambda kind, answer, name, robot: answer,
    ) -> None:
        self._note, self._reader, self._team = note, reader, team
        self._lock = threading.Lock()
        self._text = TrainingText()
        self._publisher = rospy.Publisher("training/text", TrainingText, queue_size=4, latch=True)
        self._others = {
            robot: rospy.Publisher(f"{robot}/training/text", TrainingText, queue_size=4, latch=True)
            for robot in others
        }
        self._services = [
            rospy.Service("training/tell", TellTrainee, self._on_tell),
            rospy.Service("training/read", ReadText, partial(self._on_read, "")),
        ]
        for robot in others:
            for name, kind, answer in (
                ("training/tell", TellTrainee, self._on_tell),
                ("training/read", ReadText, partial(self._on_read, robot)),
            ):
                answer_team = for_team(kind, answer, name, robot)
                self._services.append(rospy.Service(f"{robot}/{name}", kind, answer_team))

    def clear(self) -> None:
        """Show no text any more: what comes is for another trainee."""
        with self._lock:
            if self._text.text:
                self._publish(TrainingText(number=self._text.number + 1, read=True))

    def _on_tell(self, request: Any) -> TellTraineeResponse:
        text, by = request.text.strip(), request.by.strip()[:_LONGEST_NAME] or "instructor"
        if len(text) > LONGEST or not text.isprintable():
            return TellTraineeResponse(
                success=False,
                message=f"text has {len(text)} characters; one line of at most {LONGEST} that can "
                "be printed is possible",
            )
        with self._lock:
            number = self._text.number + 1
            self._publish(TrainingText(number=number, text=text, by=by, read=not text))
        said = f"said to the trainee: {text}" if text else "took the text to the trainee back"
        self._note({"input": "note", "text": said, "by": by})
        return TellTraineeResponse(success=True, message="", number=number)

    def _on_read(self, robot: str, request: Any) -> ReadTextResponse:
        with self._lock:
            now = self._text
            if request.number != now.number or not now.text:
                return ReadTextResponse(
                    success=False,
                    message=f"number is {request.number}; the text that is shown has {now.number}",
                )
            if now.read:
                return ReadTextResponse(success=True, message="it was acknowledged before")
            self._publish(TrainingText(number=now.number, text=now.text, by=now.by, read=True))
        said = f"has read: {now.text}"
        self._note({"input": "note", "text": said, "by": self._reader(robot) or "trainee"})
        return ReadTextResponse(success=True, message="")

    def _publish(self, text: TrainingText) -> None:
        text.header.stamp = rospy.get_rostime()
        self._text = text
        self._publisher.publish(text)
        nothing = TrainingText(header=text.header, number=text.number, read=True)
        team = self._team()
        for robot, publisher in self._others.items():
            publisher.publish(text if robot in team else nothing)
