"""The operator's keys: which key does what, read from YAML."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Dict, List, Mapping, Optional, Tuple

from telex_control.common.params import (
    ConfigError,
    Declared,
    number,
    parameter,
    read_config,
    require,
    require_names,
    required,
)
from telex_teleop.actions.grammar import GRAMMAR, PAGE_ONLY, Action, Command, Lamps, parse_action
from telex_teleop.actions.vocabulary import Vocabulary
from telex_teleop.motion.speed import MAX_ZOOM, STEP, STEP_RANGE, ZOOM_RATE

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
            # caps lock must not disable the keys
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
class KeyboardSettings(Declared):
    """Parameters of keyboard_teleop.

    Raises
    ------
    telex_control.common.params.ConfigError
        When one is out of range, or an action is unknown.
    """

    keys: Dict[str, str] = parameter(required, "Name of a key to the text of its action.")
    cartesian_keys: Dict[str, str] = parameter(
        dict, "Those that do something else while the arm is in CARTESIAN mode."
    )
    tap_time: float = number(0.15, "See `held.HeldKeys` (s).", 0.02, 1.0)
    key_timeout: float = number(0.2, "See `held.HeldKeys` (s).", 0.02, 1.0)
    send_rate: float = number(50.0, "Commands per second while a key is held.", 10.0, 200.0)
    redraw_rate: float = number(10.0, "Pictures of the screen per second.", 1.0, 30.0)
    longest_gap: float = number(
        0.2, "When the program was held up for longer (s), all keys count as released.", 0.05, 1.0
    )
    jog_rate: float = number(
        100.0,
        "Commanded rate (rad/s, m/s); the teleoperation nodes clamp it to what a joint can do.",
        above=0.0,
    )
    linear: float = number(
        1.2, "Commanded velocity of the tracks (m/s), clamped likewise.", above=0.0
    )
    angular: float = number(
        1.0, "Commanded velocity of the tracks (rad/s), clamped likewise.", above=0.0
    )
    tool_linear: float = number(10.0, "The same of the tool.", above=0.0)
    tool_angular: float = number(10.0, "The same of the tool.", above=0.0)
    speed_step: float = number(
        STEP, "One step of the speed scale, as a share of the full speed.", *STEP_RANGE
    )
    zoom_rate: float = number(
        ZOOM_RATE, "How fast the camera zooms (1/s, of the factor's logarithm).", above=0.0
    )
    max_zoom: float = number(MAX_ZOOM, "Largest zoom factor.", 1.0, 100.0)
    lengths: Tuple[str, ...] = parameter(
        (),
        "Joints whose position is a length and shown in mm; the others are angles, "
        "shown in degrees.",
    )
    labels: Dict[str, str] = parameter(
        dict, "Text of a command to what the screen calls it, where that is another word."
    )

    def check(self) -> None:
        """Check what concerns several of them; see `Declared.check`."""
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
