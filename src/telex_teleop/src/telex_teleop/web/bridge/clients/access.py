"""Rights of clients: topics, services and parameters, and which of them command the robot."""

from __future__ import annotations

from typing import Callable, Dict, Optional

from ...exam.exam_list import BRIDGE_TOPIC, TRAINING_TOPIC, Exam
from ...rights import NamePatterns, Rights, UseLists
from ..protocol.operations import OperationError
from .other_robots import OtherRobots

_Uses = Dict[str, NamePatterns]

TELEMETRY_TOPIC = "console/telemetry"
"""On which a page tells what its operator sees, time and again while it believes that it has
control: no command, though only he who has control is heard."""


def _uses(lists: UseLists, namespace: str) -> _Uses:
    return {use: NamePatterns(patterns, namespace) for use, patterns in vars(lists).items()}


class Access:
    """The lists of rights, applied to the names that one kind of client uses.

    A use is `publish`, `subscribe`, `call`, `serve`, `set` or `get`, as the lists are called.

    Parameters
    ----------
    resolve
        Gives a name its global form.
    e_stop_topic
        Topic of the emergency stop.
    instructor
        Whether it is for instructors.
    plain
        Whether every client may use what an instructor may.
    exam
        The exam whose list holds for them while it runs; None for those with the instructor's
        token.
    others
        What is another robot's; None: what looks so by its name.
    """

    def __init__(
        self,
        rights: Rights,
        resolve: Callable[[str], str],
        e_stop_topic: str,
        *,
        instructor: bool,
        plain: bool = False,
        exam: Optional[Exam] = None,
        others: Optional[OtherRobots] = None,
    ) -> None:
        self._namespace = resolve("x")[: -len("x")]
        self._instructors = _uses(rights.instructor, self._namespace)
        self._hears_all = instructor or plain
        operators = _uses(rights.operator, self._namespace)
        self._own = self._instructors if self._hears_all else operators
        self._commands = _uses(rights.commands, self._namespace)
        without_control = rights.without_control if instructor else UseLists()
        self._without_control = _uses(without_control, self._namespace)
        self.e_stop_topic = resolve(e_stop_topic)
        self.telemetry_topic = resolve(TELEMETRY_TOPIC)
        self._others = others or OtherRobots(self._namespace)
        self._exam = exam
        self._told_of_exams = (resolve(TRAINING_TOPIC), resolve(BRIDGE_TOPIC))

    def allows(self, use: str, name: str) -> bool:
        """Tell whether the client may use a name in this way."""
        if use == "publish" and name == self.e_stop_topic:
            return True  # whatever the lists say: an emergency stop is everybody's
        if use in ("publish", "serve") and name in self._told_of_exams:
            return False  # whatever the lists say: nobody may lift an exam's list in this way
        if self._is_closed(use, name):
            return False  # whatever the lists say: its own bridge knows who has control of it
        if self._exam is not None and not self._exam.allows(use, name):
            return False
        return self._own[use].match(name) and not self._would_replace_all(use, name)

    def _is_closed(self, use: str, name: str) -> bool:
        """Tell whether this is of another robot, whose bridge has its line and its exam, too."""
        hears = use == "get" or (use == "subscribe" and self._hears_all)
        return not hears and self._others.owns(use, name)

    def _would_replace_all(self, use: str, name: str) -> bool:
        """Tell whether this would set or delete all that stands in the robot's namespace."""
        return use == "set" and self._namespace.startswith(name.rstrip("/") + "/")

    def check(self, use: str, name: str) -> None:
        """Raise OperationError unless the client may use a name in this way."""
        if not self.allows(use, name):
            raise OperationError(self.refusal(use, name))

    def refusal(self, use: str, name: str) -> str:
        """Say why the client may not use a name in this way."""
        if self._is_closed(use, name):
            return self._others.refusal(name)
        if self._exam is not None and not self._exam.allows(use, name):
            return self._exam.refusal(use, name)
        if self._would_replace_all(use, name):
            return f"{name} holds all parameters of the robot; name a single one"
        if self._instructors[use].match(name):
            return (
                f"{name[:200]} is open to instructors only, who connect with ?role=instructor in "
                f"the bridge's address ('{use}' in the file that its parameter ~rights names)"
            )
        return (
            f"{name[:200]} is not open to clients ('{use}' in the file that the bridge's parameter "
            "~rights names)"
        )

    def check_question(self, name: str) -> None:
        """Raise OperationError unless the client may ask rosapi this now.

        What is asked of rosapi is open to all, but for an exam's list.
        """
        if self._exam is not None and not self._exam.allows("call", name):
            raise OperationError(self._exam.refusal("call", name))

    def is_command(self, use: str, name: str) -> bool:
        """Tell whether this commands the robot."""
        return name != self.telemetry_topic and self._commands[use].match(name)

    def needs_control(self, use: str, name: str) -> bool:
        """Tell whether the client may do this only while it holds control."""
        return self.is_command(use, name) and not self._without_control[use].match(name)
