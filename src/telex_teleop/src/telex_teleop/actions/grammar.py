"""Actions of an operator, as text, as values and as JSON.

An action is a short text. What lasts as long as a key or button is held: ``tracks forward``,
``arm turret_joint +``, ``flipper JOINT JOINT -``, ``side left`` (only the flippers of that side
follow meanwhile), ``preset NAME`` (of the flippers), ``tool x +``, ``pose NAME`` (of the arm),
``zoom +``. What is done once by a press: ``lamps NAME NAME`` (on, or off when one is lit) and the
commands ``stop``, ``e-stop``, ``release e-stop``, ``faster``, ``slower``, ``mode``, ``frame``,
``hold tool``, ``proximity guard``, ``bookmark``, ``go back`` (to one, in practice), ``help``; of a
terminal ``quit``; of the console's page ``drive mode``, ``camera mode``, ``next camera``, ``next
second camera``, ``swap views``, ``second view`` and ``small views`` (shown, or not), ``walk the
buttons``, ``next language``, ``read text``, ``aids`` (their menu), those that switch one of `AIDS`,
``sound`` (on, or off), ``quiet alarms``.

What a stick moves both ways is an axis: ``tracks linear``, ``tracks angular``, ``zoom``, or the
text of an action without its sign. Its positive end is that of the action with ``+``.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from enum import Enum
from typing import Any, Dict, Tuple, Union


@dataclass(frozen=True)
class Jog:
    """Move joints of one node while held; `sign` is 1 or -1."""

    node: str
    joints: Tuple[str, ...]
    sign: int


@dataclass(frozen=True)
class Drive:
    """Drive while held: signs of forward speed and of yaw rate to the left."""

    linear: int
    angular: int


@dataclass(frozen=True)
class Side:
    """Let only the flippers of one side follow while held."""

    name: str


@dataclass(frozen=True)
class Preset:
    """Move the flippers to a preset while held."""

    name: str


@dataclass(frozen=True)
class Tool:
    """Move the tool along or about an axis while held; `sign` is 1 or -1.

    `axis` is an index of `TOOL_AXES`.
    """

    axis: int
    sign: int


@dataclass(frozen=True)
class ToPose:
    """Move the arm to a named pose while held."""

    name: str


@dataclass(frozen=True)
class Zoom:
    """Zoom the pan-tilt-zoom camera in (1) or out (-1) while held."""

    sign: int


@dataclass(frozen=True)
class Lamps:
    """Switch lamps with a press: on, or off when one of them is lit."""

    names: Tuple[str, ...]


class Command(Enum):
    """Done once by a press."""

    STOP = "stop"
    E_STOP = "e-stop"
    RELEASE_E_STOP = "release e-stop"
    FASTER = "faster"
    SLOWER = "slower"
    MODE = "mode"
    FRAME = "frame"
    HOLD_TOOL = "hold tool"
    GUARD = "proximity guard"
    BOOKMARK = "bookmark"
    GO_BACK = "go back"
    HELP = "help"
    QUIT = "quit"
    DRIVE_MODE = "drive mode"
    CAMERA_MODE = "camera mode"
    NEXT_CAMERA = "next camera"
    NEXT_SECOND_CAMERA = "next second camera"
    SWAP_VIEWS = "swap views"
    SECOND_VIEW = "second view"
    SMALL_VIEWS = "small views"
    WALK = "walk the buttons"
    LANGUAGE = "next language"
    READ_TEXT = "read text"
    AIDS = "aids"
    GUIDE_LINES = "guide lines"
    AIM_LINE = "aim line"
    FINGER_GAP = "finger gap"
    CONTACT_MARKS = "contact marks"
    HORIZON = "horizon"
    COMPASS = "compass"
    ZOOM_FACTOR = "zoom factor"
    PLAN = "plan"
    SOUND = "sound"
    QUIET_ALARMS = "quiet alarms"


Action = Union[Jog, Drive, Side, Preset, Tool, ToPose, Zoom, Lamps, Command]

AIDS = (
    Command.GUIDE_LINES,
    Command.AIM_LINE,
    Command.FINGER_GAP,
    Command.CONTACT_MARKS,
    Command.HORIZON,
    Command.COMPASS,
    Command.ZOOM_FACTOR,
    Command.PLAN,
)
"""What the console's page shows besides pictures, or not."""

TERMINAL_ONLY = (Command.QUIT,)
PAGE_ONLY = (
    Command.DRIVE_MODE,
    Command.CAMERA_MODE,
    Command.NEXT_CAMERA,
    Command.NEXT_SECOND_CAMERA,
    Command.SWAP_VIEWS,
    Command.SECOND_VIEW,
    Command.SMALL_VIEWS,
    Command.WALK,
    Command.LANGUAGE,
    Command.READ_TEXT,
    Command.AIDS,
    *AIDS,
    Command.SOUND,
    Command.QUIET_ALARMS,
)
NODES = ("arm", "gripper", "flipper")
DIRECTIONS = {
    "forward": Drive(1, 0),
    "back": Drive(-1, 0),
    "left": Drive(0, 1),
    "right": Drive(0, -1),
}
DRIVE_AXES = {"linear": ("forward", "back"), "angular": ("left", "right")}
SIDES = ("left", "right")
SIGNS = {"+": 1, "-": -1}
# in the order of a twist: along x, y, z, then about them
TOOL_AXES = ("x", "y", "z", "roll", "pitch", "yaw")
GRAMMAR = (
    f"'tracks DIRECTION' with {', '.join(DIRECTIONS)}; "
    f"'NODE JOINT ... +' or '-' with node {', '.join(NODES)}; "
    f"'side left' or 'side right'; 'preset NAME'; "
    f"'tool AXIS +' or '-' with {', '.join(TOOL_AXES)}; "
    "'pose NAME'; 'zoom +' or 'zoom -'; 'lamps NAME ...'; or one of "
    + ", ".join(command.value for command in Command if command not in PAGE_ONLY)
)
AXIS_GRAMMAR = (
    f"'tracks linear' or 'tracks angular'; 'NODE JOINT ...' with node {', '.join(NODES)}; "
    f"'tool AXIS' with {', '.join(TOOL_AXES)}; or 'zoom'"
)


def is_momentary(action: Action) -> bool:
    """Tell whether an action is done once by a press, instead of lasting while held."""
    return isinstance(action, (Command, Lamps))


def parse_action(text: str) -> Action:
    """Return the action that a text names.

    Raises
    ------
    ValueError
        When it names none.
    """
    words = text.split()
    for command in Command:
        if " ".join(words) == command.value:
            return command
    if len(words) >= 2 and words[0] == "lamps" and len(set(words)) == len(words):
        return Lamps(tuple(words[1:]))
    if len(words) == 2:
        kind, name = words
        if kind == "tracks" and name in DIRECTIONS:
            return DIRECTIONS[name]
        if kind == "side" and name in SIDES:
            return Side(name)
        if kind == "preset":
            return Preset(name)
        if kind == "pose":
            return ToPose(name)
        if kind == "zoom" and name in SIGNS:
            return Zoom(SIGNS[name])
    if len(words) == 3 and words[0] == "tool" and words[1] in TOOL_AXES and words[2] in SIGNS:
        return Tool(TOOL_AXES.index(words[1]), SIGNS[words[2]])
    if len(words) >= 3 and words[0] in NODES and words[-1] in SIGNS:
        joints = tuple(words[1:-1])
        if len(set(joints)) == len(joints):
            return Jog(words[0], joints, SIGNS[words[-1]])
    raise ValueError(text)


def parse_axis(text: str) -> Tuple[Action, Action]:
    """Return the actions of an axis: that of its positive end, that of its negative one.

    Raises
    ------
    ValueError
        When the text names no axis.
    """
    words = text.split()
    if len(words) == 2 and words[0] == "tracks" and words[1] in DRIVE_AXES:
        forward, back = DRIVE_AXES[words[1]]
        return DIRECTIONS[forward], DIRECTIONS[back]
    ends = parse_action(f"{text} +"), parse_action(f"{text} -")
    if not all(isinstance(end, (Jog, Tool, Zoom)) for end in ends):
        raise ValueError(text)
    return ends


def as_json(action: Action) -> Dict[str, Any]:
    """Return an action as JSON has it.

    Returns
    -------
    dict
        ``kind`` (``jog``, ``drive``, ``side``, ``preset``, ``tool``, ``pose``, ``zoom``, ``lamps``
        or ``command``) and the fields of the action; a tool's axis by its name in `TOOL_AXES`.
    """
    if isinstance(action, Command):
        return {"kind": "command", "name": action.value}
    values = asdict(action)
    if isinstance(action, Tool):
        values["axis"] = TOOL_AXES[action.axis]
    kind = "pose" if isinstance(action, ToPose) else type(action).__name__.lower()
    return {"kind": kind, **values}
