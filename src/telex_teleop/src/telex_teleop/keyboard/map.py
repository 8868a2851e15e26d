"""The operator's keys: which key does what, read from YAML.

An action is a short text: ``tracks forward``, ``arm turret_joint +``, ``flipper JOINT JOINT -``,
``preset NAME`` (of the flippers), ``tool x +``, ``pose NAME`` (of the arm), or one of the commands
``stop``, ``e-stop``, ``release e-stop``, ``faster``, ``slower``, ``mode``, ``frame``,
``hold tool``, ``help``, ``quit``.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
from functools import cached_property
from typing import Dict, List, Mapping, Optional, Tuple, Union

from telex_control.params import ConfigError, require, require_names, require_range

__all__ = [
    "TOOL_AXES",
    "Action",
    "Command",
    "Drive",
    "Jog",
    "KeyMap",
    "KeyboardSettings",
    "Preset",
    "ToPose",
    "Tool",
]


@dataclass(frozen=True)
class Jog:
    """Move joints of one node while the key is held; `sign` is 1 or -1."""

    node: str
    joints: Tuple[str, ...]
    sign: int


@dataclass(frozen=True)
class Drive:
    """Drive while the key is held: signs of forward speed and of yaw rate to the left."""

    linear: int
    angular: int


@dataclass(frozen=True)
class Preset:
    """Move the flippers to a preset while the key is held."""

    name: str


@dataclass(frozen=True)
class Tool:
    """Move the tool along or about an axis while the key is held; `sign` is 1 or -1.

    `axis` is an index of `TOOL_AXES`.
    """

    axis: int
    sign: int


@dataclass(frozen=True)
class ToPose:
    """Move the arm to a named pose while the key is held."""

    name: str


class Command(Enum):
    """Done once when its key goes down."""

    STOP = "stop"
    E_STOP = "e-stop"
    RELEASE_E_STOP = "release e-stop"
    FASTER = "faster"
    SLOWER = "slower"
    MODE = "mode"
    FRAME = "frame"
    HOLD_TOOL = "hold tool"
    HELP = "help"
    QUIT = "quit"


Action = Union[Jog, Drive, Preset, Tool, ToPose, Command]

NODES = ("arm", "gripper", "flipper")
DIRECTIONS = {
    "forward": Drive(1, 0),
    "back": Drive(-1, 0),
    "left": Drive(0, 1),
    "right": Drive(0, -1),
}
SIGNS = {"+": 1, "-": -1}
# in the order of a twist: along x, y, z, then about them
TOOL_AXES = ("x", "y", "z", "roll", "pitch", "yaw")
NOTHING = "nothing"
GRAMMAR = (
    "'tracks DIRECTION' with "
    + ", ".join(DIRECTIONS)
    + "; 'NODE JOINT ... +' or '-' with node "
    + ", ".join(NODES)
    + "; 'preset NAME'; 'tool AXIS +' or '-' with "
    + ", ".join(TOOL_AXES)
    + "; 'pose NAME'; or one of "
    + ", ".join(command.value for command in Command)
)


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
    if len(words) == 2 and words[0] == "tracks" and words[1] in DIRECTIONS:
        return DIRECTIONS[words[1]]
    if len(words) == 2 and words[0] == "preset":
        return Preset(words[1])
    if len(words) == 2 and words[0] == "pose":
        return ToPose(words[1])
    if len(words) == 3 and words[0] == "tool" and words[1] in TOOL_AXES and words[2] in SIGNS:
        return Tool(TOOL_AXES.index(words[1]), SIGNS[words[2]])
    if len(words) >= 3 and words[0] in NODES and words[-1] in SIGNS:
        joints = tuple(words[1:-1])
        if len(set(joints)) == len(joints):
            return Jog(words[0], joints, SIGNS[words[-1]])
    raise ValueError(text)


class KeyMap:
    """Keys and their actions.

    Parameters
    ----------
    actions
        Name of a key, as `decoding.KeyEvent` has it, to its action.
    """

    def __init__(self, actions: Dict[str, Action]) -> None:
        self.actions = actions

    def action(self, name: str) -> Optional[Action]:
        """Return what a key does, None when nothing."""
        found = self.actions.get(name)
        if found is None and len(name) == 1:
            # caps lock must not make the robot deaf
            found = self.actions.get(name.lower())
        return found

    def keys_of(self, action: Action) -> List[str]:
        """Return the keys of an action."""
        return [name for name, other in self.actions.items() if other == action]

    @classmethod
    def from_texts(cls, texts: Mapping[str, str], name: str = "keys") -> KeyMap:
        """Read a map of key to the text of its action.

        Parameters
        ----------
        texts
            Key to text; ``nothing`` leaves the key without action.
        name
            Of the map, for messages.

        Raises
        ------
        telex_control.params.ConfigError
            When an action is unknown, or no key stops, quits or sets off the emergency stop.
        """
        actions: Dict[str, Action] = {}
        for key, text in texts.items():
            if text.strip() == NOTHING:
                continue
            try:
                actions[key] = parse_action(text)
            except ValueError:
                raise ConfigError(f"{name}/{key} is {text!r}; it must be {GRAMMAR}") from None
        for needed in (Command.STOP, Command.E_STOP, Command.QUIT):
            require(needed in actions.values(), f"{name}: no key has the action {needed.value!r}")
        return cls(actions)


@dataclass(frozen=True)
class KeyboardSettings:
    """Parameters of keyboard_teleop.

    Attributes
    ----------
    keys
        Name of a key to the text of its action.
    cartesian_keys
        Those that do something else while the arm is in CARTESIAN mode.
    tap_time, key_timeout
        See `held.HeldKeys` (s).
    send_rate
        Commands per second while a key is held.
    redraw_rate
        Pictures of the screen per second.
    longest_gap
        When the program was held up for longer (s), all keys count as released.
    jog_rate
        Commanded rate (rad/s, m/s); the teleoperation nodes clamp it to what a joint can do.
    linear, angular
        Commanded velocity of the tracks (m/s, rad/s), clamped likewise.
    tool_linear, tool_angular
        The same of the tool.
    speed_step
        Factor of one step of the speed scale.
    lengths
        Joints whose position is a length and shown in mm; the others are angles, shown in degrees.

    Raises
    ------
    telex_control.params.ConfigError
        When one is out of range, or an action is unknown.
    """

    keys: Dict[str, str]
    cartesian_keys: Dict[str, str] = field(default_factory=dict)
    tap_time: float = 0.15
    key_timeout: float = 0.2
    send_rate: float = 50.0
    redraw_rate: float = 10.0
    longest_gap: float = 0.2
    jog_rate: float = 100.0
    linear: float = 1.2
    angular: float = 1.0
    tool_linear: float = 10.0
    tool_angular: float = 10.0
    speed_step: float = 1.25
    lengths: Tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for name, minimum, maximum in (
            ("tap_time", 0.02, 1.0),
            ("key_timeout", 0.02, 1.0),
            ("send_rate", 10.0, 200.0),
            ("redraw_rate", 1.0, 30.0),
            ("longest_gap", 0.05, 1.0),
            ("speed_step", 1.01, 4.0),
        ):
            require_range(self, name, minimum, maximum)
        for name in ("jog_rate", "linear", "angular", "tool_linear", "tool_angular"):
            require_range(self, name, above=0.0)
        if self.lengths:
            require_names(self, "lengths")
        _ = self.key_map, self.cartesian_map

    @cached_property
    def key_map(self) -> KeyMap:
        """The keys and their actions."""
        return KeyMap.from_texts(self.keys)

    @cached_property
    def cartesian_map(self) -> KeyMap:
        """The same while the arm is in CARTESIAN mode."""
        return KeyMap.from_texts({**self.keys, **self.cartesian_keys}, "cartesian_keys")
