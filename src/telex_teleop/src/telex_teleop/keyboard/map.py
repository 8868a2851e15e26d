"""The operator's keys: which key does what, read from YAML."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Dict, List, Mapping, Optional, Tuple

from telex_control.common.params import (
    ConfigError,
    read_config,
    require,
    require_names,
    require_range,
)
from telex_teleop.actions.grammar import GRAMMAR, PAGE_ONLY, Action, Command, Lamps, parse_action
from telex_teleop.actions.vocabulary import Vocabulary
from telex_teleop.motion.speed import MAX_ZOOM, STEP, STEP_RANGE, ZOOM_RATE

__all__ = ["KeyMap", "KeyboardSettings"]

NOTHING = "nothing"


class KeyMap:
    """Keys and their actions.

    Parameters
    ----------
    actions
        Name of a key, as `decoding.KeyEvent` has it, to its action.
    labels
        Text of a command to what the screen calls it, where that is another word.
    """

    def __init__(
        self, actions: Dict[str, Action], labels: Optional[Mapping[str, str]] = None
    ) -> None:
        self.actions = actions
        self._labels = labels or {}

    def label(self, command: Command) -> str:
        """Return what the screen calls a command."""
        return self._labels.get(command.value, command.value)

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
    def from_texts(
        cls,
        texts: Mapping[str, str],
        name: str = "keys",
        labels: Optional[Mapping[str, str]] = None,
    ) -> KeyMap:
        """Read a map of key to the text of its action.

        Parameters
        ----------
        texts
            Key to text; ``nothing`` leaves the key without action.
        name
            Of the map, for messages.
        labels
            See `KeyMap`.

        Raises
        ------
        telex_control.common.params.ConfigError
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
            require(
                actions[key] not in PAGE_ONLY,
                f"{name}/{key} is {text!r}, which only the console's page has",
            )
        for needed in (Command.STOP, Command.E_STOP, Command.QUIT):
            require(needed in actions.values(), f"{name}: no key has the action {needed.value!r}")
        return cls(actions, labels)


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
        One step of the speed scale, as a share of the full speed.
    zoom_rate
        How fast the camera zooms (1/s, of the factor's logarithm).
    max_zoom
        Largest zoom factor.
    lengths
        Joints whose position is a length and shown in mm; the others are angles, shown in degrees.
    labels
        Text of a command to what the screen calls it, where that is another word.

    Raises
    ------
    telex_control.common.params.ConfigError
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
    speed_step: float = STEP
    zoom_rate: float = ZOOM_RATE
    max_zoom: float = MAX_ZOOM
    lengths: Tuple[str, ...] = ()
    labels: Dict[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name, minimum, maximum in (
            ("tap_time", 0.02, 1.0),
            ("key_timeout", 0.02, 1.0),
            ("send_rate", 10.0, 200.0),
            ("redraw_rate", 1.0, 30.0),
            ("longest_gap", 0.05, 1.0),
            ("speed_step", *STEP_RANGE),
            ("max_zoom", 1.0, 100.0),
        ):
            require_range(self, name, minimum, maximum)
        for name in ("jog_rate", "linear", "angular", "tool_linear", "tool_angular", "zoom_rate"):
            require_range(self, name, above=0.0)
        if self.lengths:
            require_names(self, "lengths")
        _ = self.key_map, self.cartesian_map

    @classmethod
    def read(cls, content: Any, vocabulary: Vocabulary, name: str) -> KeyboardSettings:
        """Read what a file says; the keys are those of the vocabulary where it has none.

        Parameters
        ----------
        content
            Of the file.
        vocabulary
            What can be done, and by which keys.
        name
            Of the file, for messages.

        Raises
        ------
        telex_control.common.params.ConfigError
            When it is wrong.
        """
        if isinstance(content, Mapping):
            shipped = vocabulary.terminal_settings()
            if "keys" in content:
                # one's own keys in JOINT mode would be hidden by the shipped ones of the other
                del shipped["cartesian_keys"]
            content = {**shipped, **content}
        return read_config(cls, content, name)

    @cached_property
    def key_map(self) -> KeyMap:
        """The keys and their actions."""
        return KeyMap.from_texts(self.keys, labels=self.labels)

    @cached_property
    def lamps(self) -> Tuple[str, ...]:
        """Names of all lamps that a key switches."""
        actions = (*self.key_map.actions.values(), *self.cartesian_map.actions.values())
        names = (name for action in actions if isinstance(action, Lamps) for name in action.names)
        return tuple(dict.fromkeys(names))

    @cached_property
    def cartesian_map(self) -> KeyMap:
        """The same while the arm is in CARTESIAN mode."""
        # named twice for the order: of a pair, the first key of this mode is shown first
        texts = {**self.cartesian_keys, **self.keys, **self.cartesian_keys}
        return KeyMap.from_texts(texts, "cartesian_keys", self.labels)
