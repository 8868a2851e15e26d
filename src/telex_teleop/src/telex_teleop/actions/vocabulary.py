"""Vocabulary of actions, with keys and titles: the file ``config/actions.yaml``.

The console's page gets it as JSON, the terminal takes its keys from it.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from functools import cached_property
from typing import Any, Dict, Iterable, Mapping, Optional, Tuple

from telex_control.common.params import ConfigError, require, require_text
from telex_teleop.actions.grammar import (
    AIDS,
    GRAMMAR,
    PAGE_ONLY,
    TERMINAL_ONLY,
    Action,
    Command,
    Tool,
    as_json,
    parse_action,
)
from telex_teleop.actions.keys import is_function_key, page_key
from telex_teleop.files import FromFile
from telex_teleop.motion.speed import MAX_ZOOM, STEP, ZOOM_RATE

MODES = ("DRIVE", "JOINT", "CARTESIAN", "CAMERA")
"""Modes of the console's keys; a terminal has those of the arm, JOINT and CARTESIAN."""


@dataclass(frozen=True)
class Entry:
    """What the file says of an action.

    Attributes
    ----------
    does
        Text of the action, see `grammar`.
    key
        Its key in page and terminal, as typed on a US keyboard or by name; a function key is the
        page's alone; empty: none in the page.
    title
        What the list of keys calls it; empty: its name.
    label
        Word on its button; empty: the part of the name after the colon.
    row
        What stands before its buttons; empty: the part of the name before the colon.
    page
        Further keys of the page (KeyboardEvent.code).
    terminal
        Further keys of the terminal.
    """

    does: str
    key: str = ""
    title: str = ""
    label: str = ""
    row: str = ""
    page: Tuple[str, ...] = ()
    terminal: Tuple[str, ...] = ()

    def __post_init__(self) -> None:
        try:
            parse_action(self.does)
        except ValueError:
            raise ConfigError(
                f"does is {self.does!r}; it must be {GRAMMAR}, "
                + ", ".join(command.value for command in PAGE_ONLY)
            ) from None
        try:
            _ = self.key and page_key(self.key)
        except ValueError:
            raise ConfigError(
                f"key is {self.key!r}; it must be a small letter, a digit, a sign of a US keyboard "
                "without shift, or a name such as pageup; what only a terminal has goes to terminal"
            ) from None

    @property
    def action(self) -> Action:
        """What is done."""
        return parse_action(self.does)


@dataclass(frozen=True)
class Group:
    """Actions that stand together in the list of keys.

    Attributes
    ----------
    title
        Of the group.
    actions
        Name to action; a name without a colon has one part only.
    modes
        Those in which the actions have their keys; empty: all.
    """

    title: str
    actions: Dict[str, Entry]
    modes: Tuple[str, ...] = ()

    def __post_init__(self) -> None:
        require_text(self, "title")
        for mode in self.modes:
            require(mode in MODES, f"modes has {mode!r}; known are {', '.join(MODES)}")
        for name, entry in self.actions.items():
            require(
                not isinstance(entry.action, Tool) or self.modes == ("CARTESIAN",),
                f"actions/{name} moves the tool, and modes is {list(self.modes)}; it must be "
                "[CARTESIAN]",
            )


@dataclass(frozen=True)
class NamedAction(Entry):
    """An entry with its name and what its group says of it; nothing that it left out is empty."""

    name: str = ""
    group: str = ""
    modes: Tuple[str, ...] = ()

    @property
    def typed(self) -> Tuple[str, ...]:
        """Its keys in a terminal."""
        if self.action in PAGE_ONLY:
            return ()
        shared = self.key and not is_function_key(self.key)
        return (*((self.key,) if shared else ()), *self.terminal)

    @property
    def codes(self) -> Tuple[str, ...]:
        """Its keys in the page (KeyboardEvent.code)."""
        return (*((page_key(self.key)[0],) if self.key else ()), *self.page)


@dataclass(frozen=True)
class Layout:
    """How the console's page is arranged for a task.

    Attributes
    ----------
    modes
        Those of the keys in which the page has this layout.
    first, second
        Roles or names of the cameras of its two large views: of each list, the first that the robot
        has.
    aids
        Those that are on at first, by the texts of `grammar.AIDS`.
    """

    modes: Tuple[str, ...]
    first: Tuple[str, ...] = ()
    second: Tuple[str, ...] = ()
    aids: Tuple[str, ...] = ()

    def __post_init__(self) -> None:
        known = [each.value for each in AIDS]
        for aid in self.aids:
            require(aid in known, f"aids has {aid!r}; known are {', '.join(known)}")


LAYOUTS = {
    "DRIVE": Layout(("DRIVE",)),
    "ARM": Layout(("JOINT", "CARTESIAN")),
    "LOOK": Layout(("CAMERA",)),
}
"""Layouts of a page whose file names none."""


@dataclass(frozen=True)
class Vocabulary(FromFile):
    """Everything that an operator can do.

    Attributes
    ----------
    modes
        Each of `MODES` to what its keys are about.
    groups
        In the order of the list of keys.
    layouts
        Of the page, by name; the first one is there at first. Each mode belongs to one of them.
    lengths
        Joints whose position is shown in mm; the others' are shown in degrees.

    Raises
    ------
    telex_control.common.params.ConfigError
        When an action is unknown, a key has two meanings in a mode, or none stops the robot.
    """

    SHIPPED = "actions.yaml"

    modes: Dict[str, str]
    groups: Tuple[Group, ...]
    layouts: Dict[str, Layout] = field(default_factory=lambda: dict(LAYOUTS))
    lengths: Tuple[str, ...] = ()

    def __post_init__(self) -> None:
        require(
            set(self.modes) == set(MODES),
            f"modes are {', '.join(self.modes)}; they must be {', '.join(MODES)}",
        )
        placed = sorted(mode for layout in self.layouts.values() for mode in layout.modes)
        require(
            placed == sorted(MODES),
            f"layouts have the modes {', '.join(placed) or 'none'}; "
            f"each of {', '.join(MODES)} must belong to one of them",
        )
        names = [name for group in self.groups for name in group.actions]
        for name in names:
            require(names.count(name) == 1, f"groups: two actions are called {name!r}")
        for needed in (Command.E_STOP, Command.STOP):
            require(
                any(each.action is needed and each.key for each in self.actions),
                f"groups: no action with a key does {needed.value!r}",
            )
        for mode in MODES:
            there = [each for each in self.actions if mode in each.modes]
            _require_one_meaning([(key, each.name) for each in there for key in each.codes], mode)
            _require_one_meaning([(key, each.name) for each in there for key in each.typed], mode)

    @cached_property
    def actions(self) -> Tuple[NamedAction, ...]:
        """All actions, in the order of the file."""
        return tuple(
            _named(name, entry, group)
            for group in self.groups
            for name, entry in group.actions.items()
        )

    def terminal_settings(self) -> Dict[str, Any]:
        """Return what the file of keyboard_teleop says where it has no keys of its own."""
        joint, cartesian = (
            {key: each.does for each in self.actions if mode in each.modes for key in each.typed}
            for mode in ("JOINT", "CARTESIAN")
        )
        return {
            "keys": joint,
            # what is not said again there would still mean a joint
            "cartesian_keys": {k: cartesian.get(k, "nothing") for k in (*cartesian, *joint)},
            "labels": {
                each.action.value: each.label
                for each in self.actions
                if isinstance(each.action, Command)
            },
            "lengths": list(self.lengths),
        }

    def as_json(
        self,
        actions: Optional[Iterable[NamedAction]] = None,
        modes: Optional[Mapping[str, str]] = None,
        layouts: Optional[Mapping[str, Layout]] = None,
        lengths: Optional[Iterable[str]] = None,
    ) -> Dict[str, Any]:
        """Return what ``/actions.json`` has; docs/engineer/external_gui.md describes it.

        Parameters
        ----------
        actions, modes, layouts, lengths
            In place of the file's.
        """
        told = self.actions if actions is None else actions
        shown = [each for each in told if each.action not in TERMINAL_ONLY]
        notes = self.modes if modes is None else modes
        arranged = self.layouts if layouts is None else layouts
        return {
            "speed_step": STEP,
            "zoom_rate": ZOOM_RATE,
            "max_zoom": MAX_ZOOM,
            "lengths": list(self.lengths if lengths is None else lengths),
            "modes": [{"name": name, "note": notes[name]} for name in MODES if name in notes],
            "layouts": [{"name": name, **asdict(each)} for name, each in arranged.items()],
            "actions": [_as_json(each) for each in shown],
        }


def _require_one_meaning(keys: Iterable[Tuple[str, str]], mode: str) -> None:
    owners: Dict[str, str] = {}
    for key, name in keys:
        other = owners.setdefault(key, name)
        require(other == name, f"groups: {key} is the key of {other} and of {name} in {mode}")


def _named(name: str, entry: Entry, group: Group) -> NamedAction:
    words = name.replace("_", " ")
    before, _, after = words.partition(":")
    said = {
        **vars(entry),
        "title": entry.title or words.replace(":", " "),
        "label": entry.label or after or before,
        "row": entry.row or before,
    }
    return NamedAction(**said, name=name, group=group.title, modes=group.modes or MODES)


def _as_json(each: NamedAction) -> Dict[str, Any]:
    code, cap = page_key(each.key) if each.key else (None, None)
    return {
        "name": each.name,
        "does": as_json(each.action),
        "title": each.title,
        "label": each.label,
        "row": each.row,
        "group": each.group,
        "modes": list(each.modes),
        "code": code,
        "cap": cap,
        "more_codes": list(each.page),
        "button": bool(each.key) or not each.terminal,
    }
