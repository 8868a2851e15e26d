"""Gamepads: where in a sensor_msgs/Joy each control of the standard layout is.

The controls are those of the W3C Gamepad specification's standard layout, by names that tell the
place, whatever is printed there: ``south`` is A on an Xbox pad, a cross on a PlayStation's.
Sticks go from -1 (left, up) to 1 (right, down), buttons and triggers from 0 to 1.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from typing import Dict, Iterable, Optional, Sequence, Tuple

from telex_control.common.params import ConfigError, Declared, number, require
from telex_teleop.files import FromFile

STICKS = ("left_stick_x", "left_stick_y", "right_stick_x", "right_stick_y")
"""In the order of the W3C layout's axes."""

BUTTONS = (
    "south",
    "east",
    "west",
    "north",
    "left_bumper",
    "right_bumper",
    "left_trigger",
    "right_trigger",
    "back",
    "start",
    "left_stick",
    "right_stick",
    "dpad_up",
    "dpad_down",
    "dpad_left",
    "dpad_right",
    "guide",
)
"""In the order of the W3C layout's buttons."""

CONTROLS = (*STICKS, *BUTTONS)
HIGHEST_INDEX = 255


class InvalidJoy(ValueError):  # noqa: N818  it names a message, as InvalidCommand does
    """A Joy message that must not move anything; the text names the field."""


@dataclass(frozen=True)
class ControlSource(Declared):
    """Where a control is in the message."""

    axis: Optional[int] = number(
        None, "Index into the message's axes, for what is no button.", 0, HIGHEST_INDEX
    )
    button: Optional[int] = number(
        None, "Index into the message's buttons, for one.", 0, HIGHEST_INDEX
    )
    rest: float = number(0.0, "Value of the axis that stands for 0.", -1.0, 1.0)
    full: float = number(1.0, "Value of the axis that stands for 1.", -1.0, 1.0)

    def check(self) -> None:
        """Check what concerns several of them; see `Declared.check`."""
        require(
            (self.axis is None) != (self.button is None),
            f"axis is {self.axis}, button is {self.button}; one of them must be given",
        )
        require(
            abs(self.full - self.rest) >= 0.5,
            f"rest is {self.rest:g}, full is {self.full:g}; they must be at least 0.5 apart",
        )

    def read(self, axes: Sequence[float], buttons: Sequence[int]) -> float:
        """Return the control's value, not yet kept within its range."""
        if self.button is not None:
            return float(buttons[self.button] != 0)
        assert self.axis is not None
        return (axes[self.axis] - self.rest) / (self.full - self.rest)


@dataclass(frozen=True)
class Pad:
    """A kind of gamepad.

    Attributes
    ----------
    description
        For people.
    controls
        Name of a control to where it is; a pad need not have all.
    match
        Regular expression that is found in the names of such devices, whatever the case; empty:
        not recognized by name.
    """

    description: str
    controls: Dict[str, ControlSource] = field(default_factory=dict)
    match: str = ""

    def __post_init__(self) -> None:
        require(bool(self.controls), "controls is empty; name the controls of the pad")
        for name in self.controls:
            require(
                name in CONTROLS, f"controls/{name} is unknown; known are {', '.join(CONTROLS)}"
            )
        try:
            re.compile(self.match)
        except re.error as error:
            raise ConfigError(
                f"match is {self.match!r}; a regular expression is needed: {error}"
            ) from None

    @property
    def axes(self) -> int:
        """Number of axes that a message must have at least."""
        return 1 + max((s.axis for s in self.controls.values() if s.axis is not None), default=-1)

    @property
    def buttons(self) -> int:
        """Number of buttons that a message must have at least."""
        return 1 + max(
            (s.button for s in self.controls.values() if s.button is not None), default=-1
        )

    def read(self, axes: Sequence[float], buttons: Sequence[int]) -> Dict[str, float]:
        """Return the value of each control.

        Raises
        ------
        InvalidJoy
            When the message is too short for this pad, or has a number that is not finite.
        """
        for name, values, needed in (("axes", axes, self.axes), ("buttons", buttons, self.buttons)):
            if len(values) < needed:
                raise InvalidJoy(
                    f"{name} has {len(values)} values; this pad ({self.description}) has at least "
                    f"{needed}: choose the right one with ~pad"
                )
        for index, value in enumerate(axes):
            if not math.isfinite(value):
                raise InvalidJoy(f"axes[{index}] is {value!r}; it must be a number from -1 to 1")
        return {
            name: max(-1.0 if name in STICKS else 0.0, min(1.0, source.read(axes, buttons)))
            for name, source in self.controls.items()
        }

    def recognizes(self, device: str) -> bool:
        """Tell whether a device of that name is such a pad."""
        return bool(self.match) and re.search(self.match, device, re.IGNORECASE) is not None


@dataclass(frozen=True)
class Pads(FromFile):
    """All known kinds of gamepads, by name; the first one that recognizes a device counts."""

    SHIPPED = "joy/pads.yaml"

    pads: Dict[str, Pad]

    def __post_init__(self) -> None:
        require(bool(self.pads), "pads is empty; describe at least one pad")

    def called(self, name: str) -> Pad:
        """Return the pad of that name.

        Raises
        ------
        telex_control.common.params.ConfigError
            When there is none.
        """
        require(
            name in self.pads,
            f"pad is {name!r}; known are {_listed(self.pads)} (or auto, with the node joy)",
        )
        return self.pads[name]

    def recognized(self, device: str) -> Tuple[str, Pad]:
        """Return the pad that a device of that name is, and the pad's name.

        Raises
        ------
        telex_control.common.params.ConfigError
            When no pad recognizes it.
        """
        for name, pad in self.pads.items():
            if pad.recognizes(device):
                return name, pad
        raise ConfigError(
            f"the device {device!r} is no known pad; choose one with ~pad: {_listed(self.pads)}"
        )


def _listed(names: Iterable[str]) -> str:
    return ", ".join(names)
