"""Texts of the instructor to the trainee: shown until he acknowledges them, and recorded."""

from __future__ import annotations

import threading
from typing import Any, Callable, Dict

import rospy
from telex_msgs.msg import TrainingText
from telex_msgs.srv import ReadText, ReadTextResponse, TellTrainee, TellTraineeResponse

LONGEST = 200
"""Of a text, in characters: one line that is read at a glance."""
_LONGEST_NAME = 40


class TraineeTexts:
    """The newest text, on ``training/text``, latched; ``training/tell`` and ``training/read``.

    Parameters
    ----------
    note : callable
        Told an input of the judge, for the recording of the trial that is under way, if one is.
    reader : callable
        Returns the name of the trainee.
    """

    def __init__(self, note: Callable[[Dict[str, Any]], None], reader: Callable[[], str]) -> None:
        self._note, self._reader = note, reader
        self._lock = threading.Lock()
        self._text = TrainingText()
        self._publisher = rospy.Publisher("training/text", TrainingText, queue_size=4, latch=True)
        self._services = [
            rospy.Service("training/tell", TellTrainee, self._on_tell),
            rospy.Service("training/read", ReadText, self._on_read),
        ]

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

    def _on_read(self, request: Any) -> ReadTextResponse:
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
        self._note({"input": "note", "text": said, "by": self._reader() or "trainee"})
        return ReadTextResponse(success=True, message="")

    def _publish(self, text: TrainingText) -> None:
        text.header.stamp = rospy.get_rostime()
        self._text = text
        self._publisher.publish(text)
