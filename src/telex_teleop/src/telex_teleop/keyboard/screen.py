"""The keyboard's screen as text: keys, what they move, where that is, whether it obeys."""

from __future__ import annotations

import math
import textwrap
from dataclasses import dataclass, field
from enum import Enum
from typing import FrozenSet, List, Mapping, Optional, Sequence, Tuple, Type, TypeVar

from telex_teleop.actions.grammar import (
    NODES,
    TOOL_AXES,
    Action,
    Command,
    Drive,
    Jog,
    Lamps,
    Preset,
    Side,
    Tool,
    ToPose,
    Zoom,
)
from telex_teleop.keyboard.map import KeyMap
from telex_teleop.tracks.track_drive import STANDSTILL, Velocity

COLUMN = 39  # characters of one of the two columns
KEYS = 10  # of them for the keys
VALUE = 11  # and for the value
LABEL = COLUMN - 2 - KEYS - 1 - 1 - VALUE
NAMED_BY = KEYS + 1 + LABEL
TITLES = {"tracks": "TRACKS", "flipper": "FLIPPERS", "gripper": "GRIPPER", "arm": "ARM"}
# what goes by the names of its YAML file
Named = TypeVar("Named", Preset, ToPose)
NAMED = {Preset: "FLIPPER PRESETS", ToPose: "ARM POSES"}
LEFT, RIGHT = ("tracks", "flipper", "gripper"), ("arm",)
SIDES = (Side("left"), Side("right"))
ZOOMS = (Zoom(1), Zoom(-1))
DRIVES = (
    ("drive", Drive(1, 0), Drive(-1, 0)),
    ("turn", Drive(0, 1), Drive(0, -1)),
)


class Style(Enum):
    """How a line looks."""

    NORMAL = "normal"
    TITLE = "title"
    GOOD = "good"
    WARNING = "warning"
    ALARM = "alarm"


@dataclass(frozen=True)
class ScreenLine:
    """One line of the screen."""

    text: str
    style: Style = Style.NORMAL


@dataclass(frozen=True)
class NodeView:
    """A teleoperation node as its last status shows it; `age` (s) is that of the status."""

    age: float
    active: bool
    message: str


@dataclass(frozen=True)
class JointView:
    """A joint as the last status shows it: position (rad or m), and whether something holds it."""

    position: float
    limited: bool


@dataclass(frozen=True)
class ToolView:
    """The tool as the last status shows it.

    Attributes
    ----------
    frame
        Along whose axes it moves.
    position
        In the base's frame (m).
    turned
        Roll, pitch and yaw there (rad).
    """

    frame: str
    position: Tuple[float, float, float]
    turned: Tuple[float, float, float]


@dataclass(frozen=True)
class ScreenState:
    """Everything that the screen shows.

    Attributes
    ----------
    exact_keys
        Whether the terminal reports releases.
    mode
        Mode of the arm, None before its first status.
    speed_scale
        The operator's speed, None before the first status.
    e_stop
        Whether the emergency stop is known to be active.
    nodes
        ``tracks``, ``arm``, ``gripper``, ``flipper`` to what they say; those not heard of are
        absent.
    joints
        By name.
    drive
        What goes to the tracks now.
    tool
        The tool, None before the arm's first status.
    arm_notice
        What there is to know of the arm's motion and of its grip.
    """

    robot: str
    exact_keys: bool = False
    mode: Optional[str] = None
    speed_scale: Optional[float] = None
    e_stop: bool = False
    nodes: Mapping[str, NodeView] = field(default_factory=dict)
    joints: Mapping[str, JointView] = field(default_factory=dict)
    drive: Velocity = STANDSTILL
    held: FrozenSet[Action] = frozenset()
    notice: str = ""
    tool: Optional[ToolView] = None
    arm_notice: str = ""
    zoom: float = 1.0
    lit: Tuple[str, ...] = ()


def render(
    keys: KeyMap,
    lengths: Sequence[str],
    state: ScreenState,
    columns: int,
    lines: int,
    show_help: bool = False,
) -> List[ScreenLine]:
    """Return the screen, cut to the size of the terminal.

    Parameters
    ----------
    lengths
        Joints whose position is shown in mm instead of degrees.
    columns, lines
        Size of the terminal.
    show_help
        Whether the explanation takes the place of the table.
    """
    head = [_head(state), _obedience(keys, state), ScreenLine(state.arm_notice, Style.WARNING)]
    foot = [ScreenLine(""), *_commands(keys, columns), ScreenLine(state.notice, Style.WARNING)]
    body = _help(keys, state, columns) if show_help else _table(keys, lengths, state, columns)
    # What says whether the robot obeys, and how to stop it, stays on the smallest screen.
    body = body[: max(lines - len(head) - len(foot), 0)]
    picture = [*head, *body, *foot][:lines]
    return [ScreenLine(line.text[:columns], line.style) for line in picture]


def _head(state: ScreenState) -> ScreenLine:
    speed = "-" if state.speed_scale is None else f"{100.0 * state.speed_scale:.0f} %"
    mode = state.mode or "-"
    if mode == "CARTESIAN" and state.tool is not None:
        mode = f"{mode} ({state.tool.frame})"
    return ScreenLine(
        f"TELEX KEYBOARD   robot {state.robot}   mode {mode}   speed {speed}",
        Style.TITLE,
    )


def _obedience(keys: KeyMap, state: ScreenState) -> ScreenLine:
    if state.e_stop:
        release = _names(keys, Command.RELEASE_E_STOP) or "another console"
        return ScreenLine(f"E-STOP IS ACTIVE, nothing obeys. Release: {release}", Style.ALARM)
    silent = [node for node in ("tracks", *NODES) if _is_silent(state, node)]
    if len(silent) == 1 + len(NODES):
        return ScreenLine("NO ANSWER from the robot's teleoperation nodes", Style.ALARM)
    if silent:
        return ScreenLine(f"NO ANSWER from: {', '.join(silent)}", Style.WARNING)
    for node in sorted(state.nodes, key=lambda name: not state.nodes[name].active):
        if state.nodes[node].message:
            return ScreenLine(f"NOT OBEYED ({node}): {state.nodes[node].message}", Style.WARNING)
    active = [node for node, view in state.nodes.items() if view.active]
    if active:
        return ScreenLine(f"OBEYED by {', '.join(active)}", Style.GOOD)
    return ScreenLine("READY")


def _is_silent(state: ScreenState, node: str) -> bool:
    view = state.nodes.get(node)
    return view is None or view.age > 1.0


def _table(
    keys: KeyMap, lengths: Sequence[str], state: ScreenState, columns: int
) -> List[ScreenLine]:
    left = [text for node in LEFT for text in _section(node, keys, lengths, state)]
    left += _named(keys, Preset, state)
    right = [text for node in RIGHT for text in _section(node, keys, lengths, state)]
    if any(keys.keys_of(zoom) for zoom in ZOOMS):
        right.append(_row(keys, ZOOMS, "zoom", f"x{state.zoom:.1f}", state))
    right += _named(keys, ToPose, state)
    right += _lamps(keys, state)
    if columns < 2 * COLUMN + 1:
        return [ScreenLine(text) for text in (*right, *left)]
    height = max(len(left), len(right))
    left += [""] * (height - len(left))
    right += [""] * (height - len(right))
    return [ScreenLine(f"{a:<{COLUMN}} {b}".rstrip()) for a, b in zip(left, right)]


def _section(node: str, keys: KeyMap, lengths: Sequence[str], state: ScreenState) -> List[str]:
    if node == "tracks":
        values = (f"{state.drive.linear:+.2f} m/s", f"{state.drive.angular:+.2f} rad/s")
        rows = [
            _row(keys, (plus, minus), label, value, state)
            for (label, plus, minus), value in zip(DRIVES, values)
            if keys.keys_of(plus) or keys.keys_of(minus)
        ]
    else:
        rows = [
            _row(
                keys,
                (Jog(node, joints, 1), Jog(node, joints, -1)),
                joint_label(joints, TITLES[node]),
                _position(joints, lengths, state),
                state,
            )
            for joints in _axes(node, keys)
        ]
        if node == "arm":
            rows = [*_tool_rows(keys, state), *rows]
    return [TITLES[node] + _sides(node, keys, state), *rows] if rows else []


def _sides(node: str, keys: KeyMap, state: ScreenState) -> str:
    """Return what the title of the flippers says about their sides."""
    parts = [
        f"{'>' if side in state.held else ''}{'/'.join(keys.keys_of(side))} {side.name}"
        for side in SIDES
        if node == "flipper" and keys.keys_of(side)
    ]
    return f"  (only {', '.join(parts)})" if parts else ""


def _named(keys: KeyMap, kind: Type[Named], state: ScreenState) -> List[str]:
    """Return all actions of a kind that goes by names, as many on a line as fit."""
    actions = [action for action in keys.actions.values() if isinstance(action, kind)]
    parts: List[str] = [
        f"{'>' if action in state.held else ' '} {'/'.join(keys.keys_of(action))} {action.name}"
        for action in dict.fromkeys(actions)
    ]
    return [NAMED[kind], *_fill(parts, COLUMN, " ")] if parts else []


def _lamps(keys: KeyMap, state: ScreenState) -> List[str]:
    """Return all switches of lamps; a star marks those of which one is lit."""
    switches = [action for action in keys.actions.values() if isinstance(action, Lamps)]
    parts = [
        f"{'*' if set(lamps.names) & set(state.lit) else ' '} {'/'.join(keys.keys_of(lamps))} "
        f"{joint_label(lamps.names, '')}"
        for lamps in dict.fromkeys(switches)
    ]
    return ["LAMPS", *_fill(parts, COLUMN, " ")] if parts else []


def _tool_rows(keys: KeyMap, state: ScreenState) -> List[str]:
    rows: List[str] = []
    for axis, name in enumerate(TOOL_AXES):
        pair = (Tool(axis, 1), Tool(axis, -1))
        if keys.keys_of(pair[0]) or keys.keys_of(pair[1]):
            rows.append(_row(keys, pair, f"tool {name}", _tool_value(axis, state.tool), state))
    return rows


def _tool_value(axis: int, tool: Optional[ToolView]) -> str:
    if tool is None:
        return ""
    if axis < 3:
        return f"{1000.0 * tool.position[axis]:+.0f} mm"
    return f"{math.degrees(tool.turned[axis - 3]):+.1f} deg"


def _axes(node: str, keys: KeyMap) -> List[Tuple[str, ...]]:
    jogs = [action for action in keys.actions.values() if isinstance(action, Jog)]
    return list(dict.fromkeys(jog.joints for jog in jogs if jog.node == node))


def _row(
    keys: KeyMap, actions: Tuple[Action, ...], label: str, value: str, state: ScreenState
) -> str:
    marker = ">" if state.held.intersection(actions) else " "
    # in the order of the file, which is that of the keyboard: the upper key comes first
    bound = list(keys.actions.values())
    ordered = sorted(actions, key=lambda a: bound.index(a) if a in bound else len(bound))
    names = " ".join("/".join(keys.keys_of(action)) or "-" for action in ordered)
    said = f"{names:<{KEYS}} {label}"
    return f"{marker} {said:<{NAMED_BY}.{NAMED_BY}} {value:>{VALUE}.{VALUE}}"


def joint_label(joints: Sequence[str], title: str) -> str:
    """Return what the operator calls one joint, or several that move together, under a title."""
    words = [joint.split("_") for joint in joints]
    common = [word for word in words[0] if all(word in others for others in words[1:])]
    said = [word for word in common if word != "joint" and word.upper() not in title]
    while len(" ".join(said)) > LABEL:
        said = said[1:]
    return " ".join(said) or ("all" if len(joints) > 1 else joints[0])


def _position(joints: Tuple[str, ...], lengths: Sequence[str], state: ScreenState) -> str:
    views = [state.joints.get(joint) for joint in joints]
    if len(views) != 1 or views[0] is None:
        limited = any(view is not None and view.limited for view in views)
        return "limit" if limited else ""
    view = views[0]
    if joints[0] in lengths:
        value = f"{1000.0 * view.position:+.0f} mm"
    else:
        value = f"{math.degrees(view.position):+.1f} deg"
    return f"!{value}" if view.limited else value


def _commands(keys: KeyMap, columns: int) -> List[ScreenLine]:
    commands = [
        action
        for action in keys.actions.values()
        if isinstance(action, Command) and action not in IN_HELP
    ]
    parts = [f"{_names(keys, each)}: {keys.label(each)}" for each in dict.fromkeys(commands)]
    return [ScreenLine(text) for text in _fill(parts, columns, "  ")]


def _fill(parts: Sequence[str], columns: int, space: str) -> List[str]:
    """Return the parts on as few lines as they need, none of them broken."""
    lines: List[str] = []
    for part in parts:
        if lines and len(lines[-1]) + len(space) + len(part) <= columns:
            lines[-1] += space + part
        else:
            lines.append(part)
    return lines


def _names(keys: KeyMap, command: Command) -> str:
    return " ".join(keys.keys_of(command))


# What is seldom used has no place on a screen of 24 lines.
IN_HELP = (Command.BOOKMARK, Command.GO_BACK)
EXACT_KEYS = """\
This terminal reports when a key goes up: a motion lasts exactly as long as its key is held, and
several keys work at once."""
TYPED_KEYS = """\
This terminal does not report when a key goes up: a short press is a nudge; a held key pauses after
it until your keyboard begins to repeat, then moves until just after you let go; of several held
keys only the last one counts. Terminals with the kitty protocol (kitty, foot, WezTerm) are
exact."""
HELP = """\
Hold a key to move, let it go to stop; all motion is on ramps. The first key of a pair moves
ahead, up, in or to the left, or closes. '!' marks a joint that a limit or something in its way
holds back. In mode CARTESIAN the arm's keys move its tool along the frame's axes. A pose moves
the whole arm, a preset all flippers; a flipper key ends a preset until a new press. A held side key
leaves the flippers of that side. Lamps go on and off by a press ('*' is lit). The guard keeps
the arm off what is near.{bookmarks}

{holding}

The speed is a factor on all motions, and stays when you quit. {stop} stops everything at once and
lets all held keys go. The e-stop also brakes the tracks; after it, press anew what you want to
move. When this window loses the keyboard, or this program ends, everything stops."""


def _bookmarks(keys: KeyMap) -> str:
    mark, back = (_names(keys, each) for each in IN_HELP)
    return f" {mark} sets a bookmark, {back} goes back." if mark and back else ""


def _help(keys: KeyMap, state: ScreenState, columns: int) -> List[ScreenLine]:
    text = HELP.format(
        holding=EXACT_KEYS if state.exact_keys else TYPED_KEYS,
        stop=_names(keys, Command.STOP),
        bookmarks=_bookmarks(keys),
    )
    lines: List[ScreenLine] = []
    for paragraph in text.split("\n\n"):
        if lines:
            lines.append(ScreenLine(""))
        lines.extend(ScreenLine(text) for text in textwrap.wrap(paragraph, max(columns - 1, 20)))
    return lines
