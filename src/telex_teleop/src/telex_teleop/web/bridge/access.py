"""Which topics, services and parameters clients may use, and which of them command the robot."""

from __future__ import annotations

import re
from typing import Callable, Iterable, List, Pattern

from ..config import RosbridgeConfig
from .operations import OperationError


class NamePatterns:
    """A list of patterns of ROS names.

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
        self._given: List[Pattern[str]] = []
        self._taken: List[Pattern[str]] = []
        for pattern in patterns:
            taken = pattern.startswith("!")
            name = pattern[1:] if taken else pattern
            full = name if name.startswith("/") else namespace + name
            expression = ".*".join(re.escape(part) for part in full.split("*"))
            (self._taken if taken else self._given).append(re.compile(expression, re.DOTALL))

    def match(self, name: str) -> bool:
        """Tell whether the list holds a global name."""
        if any(pattern.fullmatch(name) for pattern in self._taken):
            return False
        return any(pattern.fullmatch(name) for pattern in self._given)


class _Uses:
    """One of the three lists: names by what is done with them."""

    def __init__(self, lists: object, namespace: str) -> None:
        self._patterns = {
            use: NamePatterns(patterns, namespace) for use, patterns in vars(lists).items()
        }

    def hold(self, use: str, name: str) -> bool:
        patterns = self._patterns.get(use)
        return patterns is not None and patterns.match(name)


class Access:
    """The lists of the configuration, applied to names.

    A use is `publish`, `subscribe`, `call`, `serve` or `set`, as the lists are called.

    Parameters
    ----------
    config
        The bridge's parameters.
    resolve
        Gives a name its global form.
    """

    def __init__(self, config: RosbridgeConfig, resolve: Callable[[str], str]) -> None:
        namespace = resolve("x")[: -len("x")]
        self._allowed = _Uses(config.allowed, namespace)
        self._commands = _Uses(config.commands, namespace)
        self._instructors = _Uses(config.instructor, namespace)
        self.e_stop_topic = resolve(config.e_stop_topic)

    def check(self, use: str, name: str) -> None:
        """Raise OperationError unless clients may use a name in this way."""
        if not self._allowed.hold(use, name):
            raise OperationError(
                f"{name[:200]} is not open to clients; the bridge's parameter ~allowed/{use} "
                "lists what is"
            )

    def is_command(self, use: str, name: str) -> bool:
        """Tell whether only the client that holds control may do this."""
        return self._commands.hold(use, name)

    def is_instructors(self, use: str, name: str) -> bool:
        """Tell whether an instructor may do this without holding control."""
        return self._instructors.hold(use, name)
