"""Rights of clients: topics, services and parameters, and which of them command the robot."""

from __future__ import annotations

import re
from typing import Callable, Dict, Iterable, List, Pattern, Tuple

from ...rights import Rights, UseLists
from ..protocol.operations import OperationError


class NamePatterns:
    """A list of patterns of ROS names; of those that fit a name the last one decides.

    `*` stands for any text, slashes included; a pattern that begins with `!` takes away what others
    give. A pattern without a slash at its beginning is meant inside the namespace.

    Parameters
    ----------
    patterns
        The list.
    namespace
        Global name with a slash at its end.
    """

    def __init__(self, patterns: Iterable[str], namespace: str) -> None:
        self._rules: List[Tuple[Pattern[str], bool]] = []
        for pattern in patterns:
            taken = pattern.startswith("!")
            name = pattern[1:] if taken else pattern
            full = name if name.startswith("/") else namespace + name
            expression = ".*".join(re.escape(part) for part in full.split("*"))
            self._rules.append((re.compile(expression, re.DOTALL), not taken))

    def match(self, name: str) -> bool:
        """Tell whether the list holds a global name."""
        for pattern, given in reversed(self._rules):
            if pattern.fullmatch(name):
                return given
        return False


_Uses = Dict[str, NamePatterns]


def _uses(lists: UseLists, namespace: str) -> _Uses:
    return {use: NamePatterns(patterns, namespace) for use, patterns in vars(lists).items()}


class Access:
    """The lists of rights, applied to the names that one kind of client uses.

    A use is `publish`, `subscribe`, `call`, `serve`, `set` or `get`, as the lists are called.

    Parameters
    ----------
    rights
        The lists.
    resolve
        Gives a name its global form.
    e_stop_topic
        Topic of the emergency stop.
    instructor
        Whether it is for instructors.
    plain
        Whether every client may use what an instructor may.
    """

    def __init__(
        self,
        rights: Rights,
        resolve: Callable[[str], str],
        e_stop_topic: str,
        *,
        instructor: bool,
        plain: bool = False,
    ) -> None:
        self._namespace = resolve("x")[: -len("x")]
        self._instructor = instructor
        self._instructors = _uses(rights.instructor, self._namespace)
        all_of_it = instructor or plain
        self._own = self._instructors if all_of_it else _uses(rights.operator, self._namespace)
        self._commands = _uses(rights.commands, self._namespace)
        without_control = rights.without_control if instructor else UseLists()
        self._without_control = _uses(without_control, self._namespace)
        self.e_stop_topic = resolve(e_stop_topic)

    def allows(self, use: str, name: str) -> bool:
        """Tell whether the client may use a name in this way."""
        if use == "publish" and name == self.e_stop_topic:
            return True  # whatever the lists say: an emergency stop is everybody's
        return self._own[use].match(name) and not self._would_replace_all(use, name)

    def _would_replace_all(self, use: str, name: str) -> bool:
        """Tell whether this would set or delete all that stands in the robot's namespace."""
        return use == "set" and self._namespace.startswith(name.rstrip("/") + "/")

    def check(self, use: str, name: str) -> None:
        """Raise OperationError unless the client may use a name in this way."""
        if self.allows(use, name):
            return
        if self._would_replace_all(use, name):
            raise OperationError(f"{name} holds all parameters of the robot; name a single one")
        if self._instructors[use].match(name):
            raise OperationError(
                f"{name[:200]} is open to instructors only, who connect with ?role=instructor in "
                f"the bridge's address ('{use}' in the file that its parameter ~rights names)"
            )
        raise OperationError(
            f"{name[:200]} is not open to clients ('{use}' in the file that the bridge's parameter "
            "~rights names)"
        )

    def is_command(self, use: str, name: str) -> bool:
        """Tell whether this commands the robot."""
        return self._commands[use].match(name)

    def needs_control(self, use: str, name: str) -> bool:
        """Tell whether the client may do this only while it holds control."""
        return self.is_command(use, name) and not self._without_control[use].match(name)
