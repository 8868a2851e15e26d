"""Model of an exercise in one of its settings: plain data, checked where it is made."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Dict, Iterator, Mapping, Optional, Sequence, Tuple

from telex_control.common.params import (
    Declared,
    choice,
    number,
    parameter,
    require,
    require_choice,
    require_range,
)
from telex_sim.malfunctions.kinds import names_of_kinds
from telex_sim.scene.model import LARGEST, ORIGIN, Start, Vector3, require_name
from telex_sim.scene.model import Source as Emitter

from .conditions import FLOOR, ROBOT, TOOL, Condition, Dose
from .metric_kinds import KINDS, OF_ALL, OVERS

PRACTICE, EXAM = "practice", "exam"
MODES = (PRACTICE, EXAM)
TRACKS, FLIPPERS, ARM, GRIPPER = "tracks", "flippers", "arm", "gripper"
CAMERA, LAMPS = "camera", "lamps"
CONTROLS = (TRACKS, FLIPPERS, ARM, GRIPPER, CAMERA, LAMPS)
"""What an operator can be told the keys of."""
ALL = "all"
"""Stands for every object in what is put back."""
ANY = "any"
"""Stands for every group of links, or every object, in allowed contacts."""
MOST_TEXT = 2000
_LONGEST_NAME = 60


def require_label(value: str, what: str) -> None:
    """Raise a `ConfigError` unless `value` is a short text for people, such as a step's name."""
    require(
        0 < len(value) <= _LONGEST_NAME and value.isprintable() and value == value.strip(),
        f"{what} is {value[:80]!r}; 1 to {_LONGEST_NAME} printable characters are needed",
    )


def _require_text(value: str, what: str) -> None:
    require(
        len(value) <= MOST_TEXT,
        f"{what} has {len(value)} characters; at most {MOST_TEXT} fit",
    )


@dataclass(frozen=True)
class Zone:
    """A box or an upright cylinder, in the world or in the frame of an object.

    Attributes
    ----------
    center : tuple of 3 floats
        m.
    size : tuple of 3 floats, optional
        Full extents of a box (m), turned by `yaw` (rad).
    radius, height : float, optional
        Of a cylinder (m); without a height it has no end.
    of : str
        Object in whose frame the zone is given; empty: the world.
    """

    center: Vector3 = ORIGIN
    size: Optional[Vector3] = None
    yaw: float = 0.0
    radius: Optional[float] = None
    height: Optional[float] = None
    of: str = ""

    def __post_init__(self) -> None:
        require(
            (self.size is None) != (self.radius is None),
            "size and radius are both given, or neither; one of them is needed",
        )
        require(self.height is None or self.radius is not None, "height belongs to radius")
        require(self.yaw == 0.0 or self.size is not None, "yaw belongs to size")
        require_range(self, "yaw", -100.0, 100.0)
        for length in (*(self.size or ()), self.radius, self.height):
            require(
                length is None or 0.0 < length <= LARGEST,
                f"a length is {length}; above 0 and at most {LARGEST:g} m is needed",
            )
        require(
            all(abs(number) <= LARGEST for number in self.center),
            f"center is {list(self.center)}; at most {LARGEST:g} m is needed",
        )

    def contains(self, point: Tuple[float, float, float]) -> bool:
        """Whether a point (m), given in the frame that the zone is given in, is in it."""
        dx, dy, dz = (point[i] - self.center[i] for i in range(3))
        if self.size is None:
            assert self.radius is not None
            tall = self.height is None or abs(dz) <= 0.5 * self.height
            return tall and dx * dx + dy * dy <= self.radius * self.radius
        cosine, sine = math.cos(self.yaw), math.sin(self.yaw)
        x, y = cosine * dx + sine * dy, cosine * dy - sine * dx
        return (
            abs(x) <= 0.5 * self.size[0]
            and abs(y) <= 0.5 * self.size[1]
            and abs(dz) <= 0.5 * self.size[2]
        )


@dataclass(frozen=True)
class Step:
    """A part of the task, done once its condition holds."""

    name: str
    until: Condition


@dataclass(frozen=True)
class Fault:
    """Spoils a repetition: it ends without credit when the condition holds."""

    name: str
    when: Condition


@dataclass(frozen=True)
class Penalty:
    """Adds `seconds` to the time of the repetition whenever its condition begins to hold."""

    name: str
    when: Condition
    seconds: float


@dataclass(frozen=True)
class Question:
    """Something that the operator has to find out.

    Attributes
    ----------
    of : str
        Object on which the answer can be read, drawn anew in every repetition; or empty.
    row, place : int
        Which row of a chart, and which character of it (or which of the pipes), from 1; 0: all.
    choices : tuple of str
        Possible answers; empty: any text.
    answer : str
        The right one where it is not drawn; empty: it comes with each repetition.
    """

    name: str
    ask: str
    of: str = ""
    row: int = 0
    place: int = 0
    choices: Tuple[str, ...] = ()
    answer: str = ""

    def __post_init__(self) -> None:
        require_name(self.name, "name")
        require_range(self, "row", 0, 100)
        require_range(self, "place", 0, 100)
        _require_text(self.ask, "ask")
        require(bool(self.ask.strip()), "ask is ''; a question is needed")
        require(
            len(self.choices) <= 50 and len(set(self.choices)) == len(self.choices),
            f"choices is {list(self.choices)[:8]}; at most 50 different answers are possible",
        )
        require(not (self.of and self.answer), "of and answer are both given; one is needed")
        require(
            not self.answer or not self.choices or self.answer in self.choices,
            f"answer is '{self.answer}'; one of the choices is needed",
        )


@dataclass(frozen=True)
class Vary:
    """What a seed changes: the object's place by up to these lengths (m) and angle (rad)."""

    object: str
    position: Vector3 = ORIGIN
    yaw: float = 0.0

    def __post_init__(self) -> None:
        for span in (*self.position, self.yaw):
            require(
                0.0 <= span <= 100.0,
                f"a span is {span}; 0 to 100 is needed, it holds to both sides",
            )


@dataclass(frozen=True)
class Repetitions(Declared):
    """How often, and for how long."""

    most: int = number(10, "Attempts after which the trial ends; 0: no end.", 0, 1000)
    least: int = number(
        1, "Completed repetitions that a verdict needs.", 1, lambda own: own.most or 1000
    )
    trial_time: float = number(
        0.0,
        "After which the trial ends (s of sim time); what has not ended by then does not count. 0: "
        "no end.",
        0.0,
        1.0e5,
    )
    time: float = number(
        0.0,
        'After which a repetition is a fault ("time", s of sim time); 0: no end.',
        0.0,
        1.0e5,
    )


@dataclass(frozen=True)
class FurtherRobot:
    """A robot beside the first one.

    Attributes
    ----------
    name : str
        By which conditions and metrics know it; live it may be called otherwise.
    x, y : float
        Where its base_link starts (m).
    ground : float
        Height of the ground there (m).
    yaw : float
        Its heading (rad).
    pose : str
        Named pose that it starts in; empty: its own.
    variant : str
        Of the robot; empty: that of the first one.
    """

    name: str
    x: float
    y: float
    ground: float = 0.0
    yaw: float = 0.0
    pose: str = ""
    variant: str = ""

    def __post_init__(self) -> None:
        require_name(self.name, "name")
        require(
            self.name not in (ROBOT, TOOL, FLOOR),
            f"name is '{self.name}', which stands for something else; another one is needed",
        )
        Start(**self.start())  # refuses what it cannot be

    def start(self) -> Dict[str, Any]:
        """Return where it starts, as an entry of a scene's ``robots``."""
        start = {"x": self.x, "y": self.y, "ground": self.ground, "yaw": self.yaw}
        return {**start, **({"pose": self.pose} if self.pose else {})}


@dataclass(frozen=True)
class PutBack:
    """What is put back between repetitions: the robot, and objects by name (``[all]``: all)."""

    robot: bool = True
    objects: Tuple[str, ...] = (ALL,)


@dataclass(frozen=True)
class Contacts:
    """Pairs (group of links, object) that may touch; ``any`` stands for each."""

    allowed: Tuple[Tuple[str, str], ...] = (("tracks", "floor"),)

    def __post_init__(self) -> None:
        require(
            len(self.allowed) <= 200,
            f"allowed has {len(self.allowed)} pairs; at most 200 are possible",
        )

    def allows(self, group: str, thing: str) -> bool:
        """Whether a group of links may touch a thing."""
        return any(
            links in (group, ANY) and touched in (thing, ANY) for links, touched in self.allowed
        )


@dataclass(frozen=True)
class Metric:
    """Something that is measured, and what it has to be.

    Attributes
    ----------
    name : str
        Key in the file and in the sheet.
    kind : str
        One of `metric_kinds.KINDS`; by default the name.
    bound : float, optional
        Pass value, key ``pass``; None: it is only shown.
    expert : tuple of 2 floats, optional
        Mean and standard deviation of the expert.
    object : str
        Of a kind that looks at contacts or at what was held: this object alone.
    height : float
        Of ``drops``: from which a fall counts (m).
    length : float, optional
        Of a path ratio: median length of the expert's path (m).
    over : str
        How several repetitions make one figure: median, mean or worst; empty: as the kind has it.
    robot : str
        Further robot that it is of; empty: the first one.
    """

    name: str
    kind: str
    bound: Optional[float] = None
    expert: Optional[Tuple[float, float]] = None
    object: str = ""
    height: float = 0.05
    length: Optional[float] = None
    over: str = ""
    robot: str = ""

    def __post_init__(self) -> None:
        require_choice(self, "kind", KINDS)
        known = KINDS[self.kind]
        require(
            not self.robot or not (known.of_trial or self.kind in OF_ALL),
            f"robot does not belong to {self.kind}",
        )
        require(not self.object or known.of_object, f"object does not belong to {self.kind}")
        require(
            (self.length is not None) == known.needs_length,
            f"length {'is missing; the expert' if known.needs_length else 'does not belong to '}"
            + ("'s median path (m) is needed" if known.needs_length else self.kind),
        )
        require_range(self, "length", above=0.0)
        require_range(self, "height", 0.005, 100.0)
        require(
            self.over in ("", *OVERS) and (not self.over or not known.of_trial),
            f"over is '{self.over}'; {', '.join(OVERS)} are possible, for what is measured in a"
            " repetition",
        )
        if self.expert is not None:
            require(
                self.expert[1] >= 0.0,
                f"expert is {list(self.expert)}; mean and a standard deviation of 0 or more are"
                " needed",
            )

    @property
    def text(self) -> str:
        """What it measures, for people."""
        return KINDS[self.kind].text + "".join(
            f", {name}" for name in (self.object, self.robot) if name
        )


@dataclass(frozen=True)
class Expert(Declared):
    """Where the experts' figures come from."""

    by: str = choice(
        "script",
        ("script", "people"),
        "``script``: scripted operators, figures are provisional; ``people``.",
    )
    sees: str = parameter("", "What a scripted one knows that a person cannot see.")
    repetitions: int = number(0, "That the figures rest on.", 0, 100_000)

    def check(self) -> None:
        """Check what concerns single ones in a way of its own; see `Declared.check`."""
        _require_text(self.sees, "sees")


@dataclass(frozen=True)
class Hint:
    """A text that practice shows: `on` the name of a step, fault or penalty, or an event's."""

    on: str
    text: str

    def __post_init__(self) -> None:
        require_label(self.on, "on")
        _require_text(self.text, "text")


@dataclass(frozen=True)
class Seeds:
    """Seed by mode; None: drawn when the trial begins."""

    practice: Optional[int] = 1
    exam: Optional[int] = None

    def of(self, mode: str) -> Optional[int]:
        """Return the fixed seed of a mode, or None where it is drawn."""
        return self.exam if mode == EXAM else self.practice


@dataclass(frozen=True)
class SceneSource:
    """Where the exercise takes place.

    Attributes
    ----------
    base : str or mapping
        Name or path of a scene, or its content.
    folder : Path
        Of the exercise's file: relative paths start from it.
    changes : mapping
        ``floor``, ``lights``, ``start`` as in a scene, and ``objects`` by name, laid over the base.
    """

    base: Any
    folder: Path
    changes: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class RadiatingObject:
    """An object of the scene that is made to radiate; `activity` in Bq."""

    object: str
    nuclide: str
    activity: float

    def __post_init__(self) -> None:
        Emitter(self.nuclide, self.activity)  # refuses what it cannot be


@dataclass(frozen=True)
class Radiation:
    """Radiation that the exercise adds to its scene, and what may be received of it.

    Attributes
    ----------
    limits : dict of str to float
        Dose of a repetition from which it is spoilt, by component (Gy).
    history : dict of str to float
        Dose received before, by component (Gy).
    """

    sources: Tuple[RadiatingObject, ...] = ()
    limits: Dict[str, float] = field(default_factory=dict)
    history: Dict[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        objects = [source.object for source in self.sources]
        for i, name in enumerate(objects):
            require(
                name not in objects[:i],
                f"sources[{i}]/object is '{name}'; it has a source already",
            )
        for component in (*self.limits, *self.history):
            require_name(component, "name of a component")
        for component, limit in self.limits.items():
            require(limit > 0.0, f"limits/dose/{component} is {limit}; above 0 (Gy) is needed")
        for component, dose in self.history.items():
            require(dose >= 0.0, f"history/{component} is {dose}; 0 or more (Gy) is needed")

    def faults(self, others: Sequence[str] = ()) -> Tuple[Fault, ...]:
        """The limits as faults; they hold for the first robot and each of the others, by name."""
        return tuple(
            Fault(f"dose of {name.replace('_', ' ')}", _beyond(Dose(name, limit), others))
            for name, limit in self.limits.items()
        )


def _beyond(dose: Dose, others: Sequence[str]) -> Condition:
    each = tuple(Condition("dose", dose, robot=robot) for robot in ("", *others))
    return Condition("any", parts=each) if others else each[0]


@dataclass(frozen=True)
class Survey:
    """Points that are to be passed, at an even speed.

    Attributes
    ----------
    points : tuple of str
        Zones, each of which is to be met once.
    speed : float
        Of the robot over the floor, from the first point to the last (m/s).
    what : str
        What is to be led through them: the tool or the robot.
    """

    points: Tuple[str, ...]
    speed: float
    what: str = TOOL

    def __post_init__(self) -> None:
        require(
            len(set(self.points)) == len(self.points) >= 2,
            f"points is {list(self.points)[:8]}; two different zones or more are needed",
        )
        require_range(self, "speed", maximum=5.0, above=0.0)
        require_choice(self, "what", (TOOL, ROBOT))


@dataclass(frozen=True)
class Failure:
    """Something of the robot that fails.

    Attributes
    ----------
    what, kind : str
        As of telex_msgs/Malfunction.
    value : float
        Its severity in the kind's unit; 0: the default.
    announced : bool
        Whether the operator is told.
    robot : str
        Further robot that it is of; empty: the first one.
    """

    what: str
    kind: str
    value: float = 0.0
    announced: bool = False
    robot: str = ""

    def __post_init__(self) -> None:
        require_name(self.what, "what")
        require_choice(self, "kind", names_of_kinds())


@dataclass(frozen=True)
class Malfunction:
    """A failure that begins once a condition holds, once in a repetition."""

    when: Condition
    failure: Failure


LINK_FIELDS = (
    "delay",
    "jitter",
    "loss",
    "burst_length",
    "burst_interval",
    "bandwidth",
    "outage_every",
    "outage_for",
)
"""Figures of the line between robot and operator; docs/instructor/line.md says what they mean."""


@dataclass(frozen=True)
class LineLink:
    """The line between robot and operator in a trial.

    Attributes
    ----------
    profile : str
        Name of a profile that the bridge knows.
    fields : dict of str to float
        What differs from it.
    """

    profile: str = "perfect"
    fields: Dict[str, float] = field(default_factory=dict)

    @property
    def described(self) -> str:
        """The line in a few words."""
        changes = ", ".join(f"{key} {value:g}" for key, value in sorted(self.fields.items()))
        return f"{self.profile} ({changes})" if changes else self.profile


@dataclass(frozen=True)
class Exercise:
    """An exercise in one of its settings; docs/instructor/exercises.md describes the keys.

    Attributes
    ----------
    path : Path
        Of its file.
    sha256 : str
        Of its file's text.
    setting : str
        Which of the `settings` this is.
    begin : Condition
        With which the clock of a repetition starts.
    controls : tuple of str
        Those of `CONTROLS` that it needs; empty: what its steps show.
    link : LineLink, optional
        The line to the operator; None: as the instructor has set it.
    robots : tuple of FurtherRobot
        Those that it needs beside the first one.
    """

    path: Path
    sha256: str
    name: str
    title: str
    description: str
    variant: str
    modes: Tuple[str, ...]
    settings: Tuple[str, ...]
    setting: str
    scene: SceneSource
    seeds: Seeds
    vary: Tuple[Vary, ...]
    zones: Dict[str, Zone]
    begin: Condition
    steps: Tuple[Step, ...]
    any_order: bool
    repetitions: Repetitions
    put_back: PutBack
    faults: Tuple[Fault, ...]
    penalties: Tuple[Penalty, ...]
    contacts: Contacts
    questions: Tuple[Question, ...]
    metrics: Tuple[Metric, ...]
    expert: Expert
    hints: Tuple[Hint, ...]
    controls: Tuple[str, ...]
    malfunctions: Tuple[Malfunction, ...]
    radiation: Radiation
    survey: Optional[Survey]
    link: Optional[LineLink]
    robots: Tuple[FurtherRobot, ...] = ()

    def conditions(self) -> Iterator[Tuple[str, Condition]]:
        """Yield every condition with the key that it stands under."""
        yield "begin", self.begin
        for i, step in enumerate(self.steps):
            yield f"steps[{i}] ({step.name})/until", step.until
        for i, fault in enumerate(self.faults):
            yield f"faults[{i}] ({fault.name})/when", fault.when
        for i, penalty in enumerate(self.penalties):
            yield f"penalties[{i}] ({penalty.name})/when", penalty.when
        for i, malfunction in enumerate(self.malfunctions):
            yield f"malfunctions[{i}]/when", malfunction.when
