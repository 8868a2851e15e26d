"""The keys and controls in documents are those of the vocabulary and of the gamepad's map."""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest

from telex_teleop.actions.grammar import PAGE_ONLY, Preset, ToPose
from telex_teleop.actions.keys import page_key
from telex_teleop.actions.vocabulary import MODES, Vocabulary
from telex_teleop.files import shipped_file
from telex_teleop.joy.maps import JoyMap, StickBinding

ROOT = Path(__file__).resolve().parents[4]
WAYS = ("up", "right", "down", "left")

# Sentences of documents, with the names of actions in place of their keys.
SENTENCES = {
    "README.md": (
        "Hold **{drive:forward}**: the robot drives. **{drive:back}** back, **{drive:left}** and "
        "**{drive:right}** turn.",
        "**{slower}** and **{faster}** change that.",
        "Hold **{front:up}**: the front flippers rise (**{front:down}** lowers them). "
        "**{rear:up}** and **{rear:down}** are the rear flippers; with **{side:left}** or "
        "**{side:right}** held only the left or right one moves. **{preset:0}** … **{preset:6}** "
        "move all four to a preset while held: {presets} (",
        "Hold **{turret:left}** or **{turret:right}**: the turret turns. "
        "**{shoulder:up}**/**{shoulder:down}** shoulder, **{telescope:in}**/**{telescope:out}** "
        "telescope, **{elbow:up}**/**{elbow:down}** elbow, "
        "**{forearm_roll:left}**/**{forearm_roll:right}** forearm, "
        "**{wrist_pitch:up}**/**{wrist_pitch:down}** wrist, "
        "**{gripper_roll:left}**/**{gripper_roll:right}** gripper roll.",
        "**{mode}** again changes to moving the *tool*: **{tool_x:back}**/**{tool_x:ahead}** back "
        "and ahead, **{tool_y:left}**/**{tool_y:right}** left and right, "
        "**{tool_z:up}**/**{tool_z:down}** up and down, "
        "**{tool_pitch:up}**/**{tool_pitch:down}** pitch, "
        "**{tool_yaw:left}**/**{tool_yaw:right}** yaw, "
        "**{tool_roll:left}**/**{tool_roll:right}** roll. **{frame}** chooses along whose axes",
        "**{hold}** keeps the tool in its place while you drive. Hold **{poses}** for the poses "
        "{pose_labels}.",
        "**{gripper:close}** and **{gripper:open}** close and open the gripper. **{stop}** stops "
        "all. **{view}**, or a click on a small picture, makes the next camera large; the arrows, "
        "**{look:near}** and **{look:far}** turn and zoom the turret's camera, **{lamps:front}**, "
        "**{lamps:rear}**, **{lamps:turret}** and **{lamps:gripper}** switch lamps. **{keys}** "
        "lists all keys.",
        "**{estop}** or E-STOP brakes the tracks",
    ),
    "docs/operator/console.md": (
        "<kbd>{view}</kbd> for the next",
        "<kbd>{slower}</kbd> and <kbd>{faster}</kbd> change the speed",
        "| DRIVE | <kbd>{drive_mode}</kbd> |",
        "| ARM | <kbd>{mode}</kbd> |",
        "| LOOK | <kbd>{camera_mode}</kbd> |",
        "<kbd>{second_camera}</kbd> |",
        "<kbd>{swap}</kbd> |",
        "<kbd>{second}</kbd> |",
        "<kbd>{small}</kbd> |",
        "<kbd>{walk}</kbd> begins to walk the buttons",
        "<kbd>{language}</kbd>, or the button with",
        "<kbd>{aids}</kbd>, or *aids* above the first view",
        "| guide lines | <kbd>{aid:guides}</kbd> |",
        "| aim line | <kbd>{aid:aim}</kbd> |",
        "| finger gap | <kbd>{aid:gap}</kbd> |",
        "| contact marks | <kbd>{aid:contact}</kbd> |",
        "| horizon | <kbd>{aid:horizon}</kbd> |",
        "| compass | <kbd>{aid:compass}</kbd> |",
        "| zoom factor | <kbd>{aid:zoom}</kbd> |",
        "| plan | <kbd>{aid:plan}</kbd> |",
        "acknowledges it by <kbd>{read}</kbd>",
        "<kbd>{sound}</kbd> or the button *sound*",
        "<kbd>{quiet}</kbd> or *quiet*",
        "<kbd>{frame}</kbd> the next frame, <kbd>{hold}</kbd> the tool keeps its place",
        "<kbd>{keys}</kbd> lists all keys.",
        "<kbd>{estop}</kbd> is the e-stop, always.",
    ),
    "docs/operator/input.md": ("({mode} changes it)",),
}


@pytest.fixture(scope="module")
def vocabulary():
    return Vocabulary.read()


@pytest.mark.parametrize(
    ("name", "sentence"), [(name, said) for name, them in SENTENCES.items() for said in them]
)
def test_sentences_name_the_keys_that_there_are(vocabulary, name, sentence):
    caps = {each.name: page_key(each.key)[1] for each in vocabulary.actions if each.key}
    poses = [each for each in vocabulary.actions if isinstance(each.action, ToPose)]
    presets = [each for each in vocabulary.actions if isinstance(each.action, Preset)]
    caps["poses"] = " ".join(caps[each.name] for each in poses)
    caps["pose_labels"] = ", ".join(each.label for each in poses)
    caps["presets"] = ", ".join(each.label for each in presets)
    wanted = re.sub(r"\{([^}]+)\}", lambda found: caps[found[1]], sentence)
    assert wanted in " ".join((ROOT / name).read_text().split())


def test_the_table_of_keys_is_that_of_the_vocabulary(vocabulary):
    rows = {}
    for each in vocabulary.actions:
        rows.setdefault((each.group, each.name.split(":")[0]), []).append(each)
    lines = []
    for row in rows.values():
        caps = " ".join(f"`` {cap} ``" if cap == "`" else f"`{cap}`" for cap in caps_of(row))
        more = " ".join(f"`{key}`" for each in row for key in each.terminal)
        page = " (in the page)" if row[0].action in PAGE_ONLY else ""
        modes = "all" if row[0].modes == MODES else ", ".join(row[0].modes)
        lines.append((caps, more, in_short(row) + page, modes))
    require_table(("keys", "further ones of a terminal", "", "modes"), lines)


# Of each line of the gamepad's table: what it is called, controls in their order (of a stick, its
# negative and its positive end), whether with the shift button.
CONTROLS = (
    ("left stick up, down", ("left_stick_y",), False),
    ("left stick left, right", ("left_stick_x",), False),
    ("right stick up, down", ("right_stick_y",), False),
    ("right stick left, right", ("right_stick_x",), False),
    ("d-pad up, down", ("dpad_up", "dpad_down"), False),
    ("d-pad left, right", ("dpad_left", "dpad_right"), False),
    ("X, B", ("west", "east"), False),
    ("**RB** held: d-pad up, right, down, left", tuple(f"dpad_{w}" for w in WAYS), True),
    ("**RB** held: B, Y, X", ("east", "north", "west"), True),
    ("A, Y", ("south", "north"), False),
    ("LT, RT", ("left_trigger", "right_trigger"), False),
    ("left stick pressed", ("left_stick",), False),
    ("right stick pressed", ("right_stick",), False),
    ("**RB** held: right stick pressed", ("right_stick",), True),
    ("LB + Back", ("back",), False),
)


def test_the_table_of_the_gamepad_is_that_of_its_map(vocabulary):
    joy_map = JoyMap.read(shipped_file("joy/twin_stick.yaml"))
    named = {each.action: each for each in reversed(vocabulary.actions)}
    lines = []
    for label, controls, shifted in CONTROLS:
        cells = []
        for mode in joy_map.modes:
            plain, bound = (joy_map.bindings(mode, held) for held in (False, shifted))
            actions = []
            for control in controls:
                binding = bound.get(control)
                if isinstance(binding, StickBinding):
                    actions += [binding.negative, binding.positive]
                elif binding is not None and not (shifted and binding == plain.get(control)):
                    actions.append(binding.action)
            cells.append(in_short([named[action] for action in actions]))
        lines.append((label, *(("in every mode: " + cells[0],) if len(set(cells)) == 1 else cells)))
    lines = [(*line, *[""] * (len(joy_map.modes) + 1 - len(line))) for line in lines]
    require_table(("control", *(mode.name for mode in joy_map.modes)), lines)


def caps_of(row):
    return [page_key(each.key)[1] for each in row if each.key]


def in_short(row):
    """Return the titles of actions, without the words that the title before has said."""
    said, last = [], []
    for each in row:
        preset = isinstance(each.action, Preset)
        words = f"flippers to {each.label}".split() if preset else each.title.split()
        common = len(os.path.commonprefix([words, last]))
        if 0 < common < len(words):
            said.append(" ".join(words[common:]))
        else:
            last = words
            said.append(" ".join(words))
    return ", ".join(said)


def require_table(head, lines):
    rows = [head, *lines]
    # a bar would end the cell
    assert not any("|" in cell for row in rows for cell in row)
    first, *rest = (re.sub(" +", " ", f"| {' | '.join(row)} |") for row in rows)
    table = "\n".join([first, "|---" * len(head) + "|", *rest])
    text = (ROOT / "docs/operator/input.md").read_text()
    assert table in text, f"docs/operator/input.md must have this table:\n\n{table}\n"
