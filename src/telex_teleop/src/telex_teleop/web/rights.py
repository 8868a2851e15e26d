"""The lists of rights of `config/bridge_rights.yaml`."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass, field, replace
from typing import Tuple

import rospkg

from telex_control.common.params import require

from ..files import read_file

_PATTERN = re.compile(r"!?[A-Za-z0-9_/*]+")
_NAME = re.compile(r"[A-Za-z0-9_/]+")


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


@dataclass(frozen=True)
class Rights:
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

    operator: UseLists = field(default_factory=UseLists)
    instructor: UseLists = field(default_factory=UseLists)
    commands: UseLists = field(default_factory=UseLists)
    without_control: UseLists = field(default_factory=UseLists)

    @classmethod
    def read(cls, path: str = "") -> Rights:
        """Read a file; an empty path stands for the shipped one.

        Raises
        ------
        telex_control.common.params.ConfigError
            It cannot be read or is wrong.
        """
        shipped = os.path.join(
            rospkg.RosPack().get_path("telex_teleop"), "config", "bridge_rights.yaml"
        )
        return read_file(cls, path or shipped)

    def hiding(self, cameras: object) -> Rights:
        """Return these rights without some cameras for operators, of whatever robot.

        Parameters
        ----------
        cameras
            Their names, as the video server's parameter holds them; what is no name hides nothing.
        """
        listed = cameras if isinstance(cameras, (list, tuple)) else ()
        names = [name for name in listed if isinstance(name, str) and _NAME.fullmatch(name)]
        topics = tuple(f"!/*cameras/{name}/*" for name in names)
        settings = tuple(f"!/*cameras/{name}{end}" for name in names for end in ("", "/*"))
        operator = replace(
            self.operator,
            publish=self.operator.publish + topics,
            subscribe=self.operator.subscribe + topics,
            get=self.operator.get + settings,
        )
        return replace(self, operator=operator)
