"""The lists of rights of `config/bridge_rights.yaml` and `config/exam_rights.yaml`."""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace
from typing import Iterable, List, Pattern, Tuple, TypeVar

from telex_control.common.params import require

from ..files import FromFile

_PATTERN = re.compile(r"!?[A-Za-z0-9_/*]+")
_NAME = re.compile(r"[A-Za-z0-9_/]+")

Lists = TypeVar("Lists", bound="UseLists")


@dataclass(frozen=True)
class UseLists:
    """Patterns of names, by what is done with them."""

    publish: Tuple[str, ...] = ()
    subscribe: Tuple[str, ...] = ()
    call: Tuple[str, ...] = ()
    serve: Tuple[str, ...] = ()
    set: Tuple[str, ...] = ()
    get: Tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for use, patterns in vars(self).items():
            for pattern in patterns:
                require(
                    _PATTERN.fullmatch(pattern) is not None,
                    f"{use} holds {pattern!r}; a pattern is a ROS name, in which * stands for any "
                    "text, after a ! if it takes away",
                )

    def hiding(self: Lists, cameras: object) -> Lists:
        """Return these lists without some cameras, of whatever robot.

        Parameters
        ----------
        cameras
            Their names, as the video server's parameter holds them; what is no name hides nothing.
        """
        listed = cameras if isinstance(cameras, (list, tuple)) else ()
        names = [name for name in listed if isinstance(name, str) and _NAME.fullmatch(name)]
        topics = tuple(f"!/*cameras/{name}/*" for name in names)
        settings = tuple(f"!/*cameras/{name}{end}" for name in names for end in ("", "/*"))
        return replace(
            self,
            publish=self.publish + topics,
            subscribe=self.subscribe + topics,
            get=self.get + settings,
        )


@dataclass(frozen=True)
class Rights(FromFile):
    """What operators and instructors may use, and what of it commands the robot.

    Attributes
    ----------
    operator, instructor
        What they may use at all.
    commands
        What only the client that holds control may do.
    without_control
        Commands that an instructor may give without holding control.
    """

    SHIPPED = "bridge_rights.yaml"

    operator: UseLists = field(default_factory=UseLists)
    instructor: UseLists = field(default_factory=UseLists)
    commands: UseLists = field(default_factory=UseLists)
    without_control: UseLists = field(default_factory=UseLists)

    def hiding(self, cameras: object) -> Rights:
        """Return these rights without some cameras for operators, of whatever robot.

        Parameters
        ----------
        cameras
            Their names, as the video server's parameter holds them; what is no name hides nothing.
        """
        return replace(self, operator=self.operator.hiding(cameras))


@dataclass(frozen=True)
class ExamRights(UseLists, FromFile):
    """What is left to those without the instructor's token while an exam runs.

    Attributes
    ----------
    pages
        Addresses of the video server that other processes answer.
    """

    SHIPPED = "exam_rights.yaml"

    pages: Tuple[str, ...] = ()


class NamePatterns:
    """A list of patterns of ROS names; of those that fit a name the last one decides.

    `*` stands for any text, slashes included; a pattern that begins with `!` takes away what others
    give. A pattern without a slash at its beginning is meant inside the namespace.

    Parameters
    ----------
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
