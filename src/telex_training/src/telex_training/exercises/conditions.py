"""Conditions of exercises as plain data; `telex_training.judging.conditions` evaluates them.

In a file a condition is a struct with one kind, and optionally the time for which it has to hold,
and which robot it looks at where there are several::

    {inside: {what: robot, zone: start}, for: 0.5}
    {all: [{held: {object: cube}}, {not: {touches: {object: table}}}]}
    {held: {object: beam}, robot: second}
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Dict, Iterator, Mapping, Optional, Tuple, Type

from telex_control.common.params import (
    ConfigError,
    Declared,
    choice,
    number,
    read_struct,
    read_value,
    require,
    required,
)

ROBOT, TOOL = "robot", "tool"
FLOOR = "floor"
ELECTRONICS = ("arm_electronics", "drive_electronics")
"""Components that receive doses, beside the robot and its cameras."""
MOST_PARTS = 200
"""Kinds that one condition may be composed of."""
_LONGEST = 3600.0

EVENTS = (
    "answer",
    "camera",
    "command",
    "contact",
    "drop",
    "e_stop",
    "mode",
    "penalty",
    "step",
    "stuck",
    "tipped",
)
"""What the condition ``event`` can name."""


@dataclass(frozen=True)
class Inside:
    """The origin of the robot's root link, the tool's frame, an object or a body is in a zone."""

    what: str
    zone: str


@dataclass(frozen=True)
class JointWithin:
    """A hinge or slide of an object (or a joint of the robot) stands within bounds (rad, m)."""

    object: str
    joint: str
    above: Optional[float] = None
    below: Optional[float] = None

    def __post_init__(self) -> None:
        require(
            self.above is not None or self.below is not None,
            "neither above nor below is given; one is needed",
        )
        require(
            self.above is None or self.below is None or self.above < self.below,
            f"above is {self.above} and below is {self.below}; above must be less",
        )


@dataclass(frozen=True)
class Latch:
    """A latch holds its piece, or with ``held: false`` does not."""

    object: str
    joint: str
    held: bool = True


@dataclass(frozen=True)
class Held(Declared):
    """The gripper holds an object, with more than `above` (N) where that is given."""

    object: str = ""
    above: Optional[float] = number(None, "", 0.0, 1.0e5)


@dataclass(frozen=True)
class Dropped(Declared):
    """An object was held, is not any more, and fell by more than `height` (m) outside of zones."""

    object: str
    height: float = number(0.05, "", 0.005, 100.0)
    outside: Tuple[str, ...] = ()


@dataclass(frozen=True)
class Touches:
    """A group of the robot's links (empty: any) is in contact with an object.

    With a zone, only where the mean point of the contact is in it.
    """

    object: str
    group: str = ""
    zone: str = ""


@dataclass(frozen=True)
class Force(Declared):
    """The largest 20 ms mean of the normal force on an object is more than `above` (N)."""

    object: str
    above: float = number(required, "", 0.0, 1.0e6)
    group: str = ""


@dataclass(frozen=True)
class Tilted(Declared):
    """The z axis of the robot or an object leans by more than `angle` (rad) from the vertical."""

    what: str
    angle: float = number(required, "", 0.0, 3.2)


@dataclass(frozen=True)
class Moved(Declared):
    """Something is further than `distance` (m) from where the repetition found it."""

    what: str
    distance: float = number(required, "", 0.0, 1.0e4)


@dataclass(frozen=True)
class Answered:
    """A question was answered, with ``right: true`` rightly, with ``right: false`` wrongly."""

    question: str
    right: Optional[bool] = None


@dataclass(frozen=True)
class Dose(Declared):
    """A component has received more than `above` (Gy) in this repetition."""

    what: str
    above: float = number(required, "", 0.0)


@dataclass(frozen=True)
class Elapsed(Declared):
    """The repetition has lasted for `seconds`."""

    seconds: float = number(required, "", 0.0, 1.0e6)


@dataclass(frozen=True)
class Event(Declared):
    """An event has happened `count` times in this repetition."""

    name: str = choice(required, EVENTS)
    count: int = number(1, "", 1, 10_000)


ATOMS: Dict[str, Type[Any]] = {
    "inside": Inside,
    "joint": JointWithin,
    "latch": Latch,
    "held": Held,
    "dropped": Dropped,
    "touches": Touches,
    "force": Force,
    "tilted": Tilted,
    "moved": Moved,
    "answered": Answered,
    "dose": Dose,
    "elapsed": Elapsed,
    "event": Event,
}
"""Kinds of conditions that look at one thing, and what each is given."""
COMPOSED = ("all", "any", "not")
KINDS = (*ATOMS, *COMPOSED)
_OF_ALL = ("latch", "answered", "elapsed", "event")
"""Kinds that do not look at one of several robots."""


@dataclass(frozen=True)
class Condition:
    """A condition.

    Attributes
    ----------
    kind : str
        One of `KINDS`.
    of : dataclass, optional
        What a kind of `ATOMS` is given.
    parts : tuple of Condition
        Of a kind of `COMPOSED`.
    seconds : float
        For which it has to hold without a break before it counts (s of sim time); key ``for``.
    robot : str
        Further robot that it looks at; empty: the first one.
    """

    kind: str
    of: Any = None
    parts: Tuple[Condition, ...] = ()
    seconds: float = 0.0
    robot: str = ""

    def walk(self) -> Iterator[Condition]:
        """Yield this condition and all that it is composed of."""
        yield self
        for part in self.parts:
            yield from part.walk()

    def wanted(self, wanted: bool = True) -> Iterator[Condition]:
        """Yield those of all that it is composed of which have to hold for it to hold."""
        if wanted and not self.parts:
            yield self
        for part in self.parts:
            yield from part.wanted(wanted != (self.kind == "not"))

    def zones(self) -> Tuple[str, ...]:
        """Names of the zones that it looks at by itself."""
        if self.kind == "inside":
            return (self.of.zone,)
        if self.kind == "touches":
            return (self.of.zone,) if self.of.zone else ()
        return tuple(self.of.outside) if self.kind == "dropped" else ()


def read_condition(content: Any, name: str) -> Condition:
    """Read a condition.

    Parameters
    ----------
    content
        As in a file.
    name : str
        For messages.

    Raises
    ------
    ConfigError
    """
    made = _read(content, name)
    count = sum(1 for _ in made.walk())
    require(count <= MOST_PARTS, f"{name} has {count} parts; at most {MOST_PARTS} are possible")
    return made


def _read(content: Any, name: str, of: str = "") -> Condition:
    """Read a condition that stands within one of a robot (`of`), if it has none of its own."""
    if not isinstance(content, Mapping):
        raise ConfigError(f"{name} is {str(content)[:60]!r}; a struct with a condition is needed")
    seconds = 0.0
    if "for" in content:
        seconds = read_value(float, content["for"], f"{name}/for")
        require(
            0.0 <= seconds <= _LONGEST,
            f"{name}/for is {seconds}; 0 to {_LONGEST:g} s is possible",
        )
    kinds = [str(key) for key in content if key not in ("for", "robot")]
    for kind in kinds:
        require(
            kind in KINDS, f"{name}/{kind} is unknown; known are {', '.join(KINDS)}, for, robot"
        )
    require(
        len(kinds) == 1,
        f"{name} has {' and '.join(kinds) or 'no condition'}; one condition is needed"
        " (all and any join several)",
    )
    (kind,) = kinds
    given, inside = content[kind], f"{name}/{kind}"
    robot = read_value(str, content.get("robot", of), f"{name}/robot")
    require(
        kind not in _OF_ALL or "robot" not in content, f"{name}/robot does not belong to {kind}"
    )
    if kind == "not":
        return Condition(kind, parts=(_read(given, inside, robot),), seconds=seconds)
    if kind in COMPOSED:
        require(
            isinstance(given, list) and bool(given),
            f"{inside} is {str(given)[:60]!r}; a list of conditions is needed",
        )
        parts = tuple(_read(part, f"{inside}[{i}]", robot) for i, part in enumerate(given))
        return Condition(kind, parts=parts, seconds=seconds)
    if kind == "elapsed":
        given = {"seconds": read_value(float, given, inside)}
    own = "" if kind in _OF_ALL else robot
    return Condition(kind, read_struct(ATOMS[kind], given, inside), seconds=seconds, robot=own)
