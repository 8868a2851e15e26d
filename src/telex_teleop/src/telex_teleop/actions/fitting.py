"""Fitting of the vocabulary to a robot: what it lacks is left out, what it has besides gets keys.

The keys of what is left out go to what the file does not name: those of the arm's first missing
joint to the robot's first joint of another name, and so on. What finds no key has its button.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Dict, Iterable, List, Sequence, Tuple, Type

from telex_control.urdf.joints import short_name
from telex_teleop.actions.abilities import Abilities, MovedJoint
from telex_teleop.actions.grammar import (
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
from telex_teleop.actions.vocabulary import Layout, NamedAction, Vocabulary

Slot = Tuple[str, ...]
"""Joints that the actions of a pair of keys move together."""

_JOINT = ("JOINT",)
_CAMERA = ("CAMERA",)


def fit(vocabulary: Vocabulary, robot: Abilities, adds: bool = True) -> Dict[str, Any]:
    """Return what ``/actions.json`` has for a robot.

    Parameters
    ----------
    adds
        Whether what the file does not name is added; a file that was written for the robot says
        itself what there shall be.
    """
    actions = list(vocabulary.actions)
    if adds:
        actions = _with_the_rest(actions, robot)
    actions = [_trimmed(each, robot) for each in actions if _can(each, robot)]
    modes = _modes(actions, robot)
    kept = [
        replace(each, modes=tuple(mode for mode in each.modes if mode in modes))
        for each in actions
        if set(each.modes) & set(modes) and _leads(each, modes)
    ]
    there = {each.does for each in kept}
    layouts = {
        name: Layout(
            tuple(mode for mode in layout.modes if mode in modes),
            _cameras(layout.first, robot),
            _cameras(layout.second, robot),
            tuple(aid for aid in layout.aids if aid in there),
        )
        for name, layout in vocabulary.layouts.items()
        if set(layout.modes) & set(modes)
    }
    lengths = tuple(dict.fromkeys((*vocabulary.lengths, *robot.lengths)))
    # What they say of the arm is nothing to a robot without one.
    notes = {mode: vocabulary.modes[mode] if robot.arm else "" for mode in modes}
    return vocabulary.as_json(kept, notes, layouts, lengths)


def _can(each: NamedAction, robot: Abilities) -> bool:
    """Tell whether a robot can do what an action asks for."""
    action = each.action
    if isinstance(action, Jog):
        there = {
            "arm": [joint.name for joint in (*robot.arm, *robot.head)],
            "flipper": [joint.name for joint in robot.flippers],
            "gripper": [joint.name for joint in robot.fingers],
        }[action.node]
        if action.node == "gripper" and robot.gripper is not None:
            there.append(robot.gripper.name)
        return bool(set(action.joints) & set(there))
    if isinstance(action, Side):
        return all(
            any(joint.name in names for joint in robot.flippers) for names in robot.sides().values()
        )
    if isinstance(action, Lamps):
        return bool(set(action.names) & set(robot.lamps))
    conditions = {
        Drive: robot.drives,
        Tool: robot.tool,
        Zoom: robot.zooms,
        Preset: isinstance(action, Preset) and action.name in robot.presets,
        ToPose: isinstance(action, ToPose) and action.name in robot.poses,
    }
    moves = robot.drives or any((robot.arm, robot.head, robot.fingers, robot.flippers))
    commands = {
        Command.FRAME: robot.tool,
        Command.HOLD_TOOL: robot.tool and robot.drives,
        Command.GUARD: robot.guard,
        Command.SLOWER: moves,
        Command.FASTER: moves,
        Command.GUIDE_LINES: robot.drives,
        Command.AIM_LINE: robot.tool,
        Command.FINGER_GAP: robot.gripper is not None,
        Command.CONTACT_MARKS: robot.gripper is not None,
        Command.HORIZON: robot.attitude,
        Command.COMPASS: robot.drives,
        Command.PLAN: robot.drives,
        Command.ZOOM_FACTOR: robot.zooms,
        Command.AIDS: robot.drives or robot.tool or robot.zooms or robot.gripper is not None,
    }
    if isinstance(action, Command):
        return commands.get(action, True)
    return conditions[type(action)]


def _trimmed(each: NamedAction, robot: Abilities) -> NamedAction:
    """Return an action without those of its lamps and flippers that the robot lacks."""
    action = each.action
    if isinstance(action, Lamps):
        there = [name for name in action.names if name in robot.lamps]
        return replace(each, does=f"lamps {' '.join(there)}")
    if isinstance(action, Jog) and action.node == "flipper":
        names = {joint.name for joint in robot.flippers}
        return replace(
            each, does=_jog(action.node, (j for j in action.joints if j in names), action.sign)
        )
    return each


def _modes(actions: Iterable[NamedAction], robot: Abilities) -> Tuple[str, ...]:
    """Return the modes in which there is something to do; one at least."""
    jogs = [each for each in actions if isinstance(each.action, Jog)]
    has = {
        "DRIVE": robot.drives or bool(robot.flippers),
        "JOINT": bool(robot.arm or robot.fingers),
        "CARTESIAN": robot.tool,
        "CAMERA": robot.zooms or any(each.modes == _CAMERA for each in jogs),
    }
    return tuple(mode for mode, there in has.items() if there) or _CAMERA


def _leads(each: NamedAction, modes: Sequence[str]) -> bool:
    """Tell whether an action that leads to a mode leads to another one than the present one."""
    leads_to = {
        Command.MODE: {"JOINT", "CARTESIAN"},
        Command.DRIVE_MODE: {"DRIVE"},
        Command.CAMERA_MODE: {"CAMERA"},
    }
    if not isinstance(each.action, Command) or each.action not in leads_to:
        return True
    return len(modes) > 1 and bool(leads_to[each.action] & set(modes))


def _cameras(wanted: Iterable[str], robot: Abilities) -> Tuple[str, ...]:
    """Return the names of the cameras that have the wanted roles, or names."""
    found: List[str] = []
    for role in wanted:
        found += [name for name, declared in robot.cameras.items() if role in (declared, name)]
    return tuple(dict.fromkeys(found))


# ---- what the file does not name


def _with_the_rest(actions: List[NamedAction], robot: Abilities) -> List[NamedAction]:
    """Let what the robot has besides have the actions of what it lacks, or further ones."""
    head = sorted(robot.head, key=lambda joint: -abs(joint.axis[2]))
    actions = _give_joints(actions, "arm", _JOINT, [(j.name,) for j in robot.arm], robot.arm)
    actions = _give_joints(actions, "arm", _CAMERA, [(j.name,) for j in head], head)
    actions = _give_joints(actions, "flipper", (), _ends(robot.flippers), robot.flippers)
    if robot.gripper is not None:
        actions = _give_joints(actions, "gripper", (), [(robot.gripper.name,)], ())
    actions = _give_names(actions, Preset, robot.presets, "preset {}", "flipper preset {}")
    actions = _give_names(actions, ToPose, robot.poses, "pose {}", "arm to {}")
    return _give_names(actions, Lamps, robot.lamps, "lamps {}", "{} lamp")


def _ends(flippers: Sequence[MovedJoint]) -> List[Slot]:
    """Return the flippers of the front, and those of the rear."""
    front = tuple(joint.name for joint in flippers if joint.place[0] >= 0.0)
    rear = tuple(joint.name for joint in flippers if joint.place[0] < 0.0)
    return [end for end in (front, rear) if end]


def _give_joints(
    actions: List[NamedAction],
    node: str,
    modes: Tuple[str, ...],
    wanted: Sequence[Slot],
    joints: Sequence[MovedJoint],
) -> List[NamedAction]:
    """Let joints that no action names have the actions of joints that the robot lacks.

    Parameters
    ----------
    actions
        All.
    node
        That moves the joints.
    modes
        Of the actions whose keys they get; empty: whatever they are.
    wanted
        What each pair of actions shall move.
    joints
        All of the robot's that the node moves.
    """
    jogs = [
        (each, each.action)
        for each in actions
        if isinstance(each.action, Jog) and each.action.node == node
    ]
    named = {name for _, jog in jogs for name in jog.joints}
    there = {name for slot in wanted for name in slot}
    new = [slot for slot in wanted if not set(slot) & named]
    free = list(
        dict.fromkeys(
            jog.joints
            for each, jog in jogs
            if each.key and (not modes or each.modes == modes) and not set(jog.joints) & there
        )
    )
    given = dict(zip(free, new))
    by_name = {joint.name: joint for joint in joints}
    counts: Dict[Slot, int] = {}

    def renamed(each: NamedAction) -> NamedAction:
        action = each.action
        if not isinstance(action, Jog) or action.node != node or action.joints not in given:
            return each
        slot = given[action.joints]
        joint = by_name.get(slot[0])
        if node != "arm" or joint is None:
            return replace(each, does=_jog(node, slot, action.sign))
        if modes == _CAMERA:
            return replace(each, does=_jog(node, slot, action.sign * _orientation(joint)))
        if each.modes != modes:
            return each
        place = counts[slot] = counts.get(slot, -1) + 1
        return _worded(each, joint, place % 2)

    made = [renamed(each) for each in actions]
    if node == "arm":
        group = next((each.group for each, _ in jogs if each.modes == modes), "Arm")
        for slot in new[len(free) :]:
            joint = by_name[slot[0]]
            blank = NamedAction(does="stop", name="", group=group, modes=modes)
            made += [
                replace(_worded(blank, joint, place), name=f"{joint.name}:{place}")
                for place in (0, 1)
            ]
    return made


def _worded(each: NamedAction, joint: MovedJoint, place: int) -> NamedAction:
    """Return the first or the second action of a joint: ahead of its row the one up, in or left."""
    words, first = _WORDS[_direction(joint)]
    sign = first * _orientation(joint) * (1, -1)[place]
    row = short_name(joint.name).replace("_", " ")
    return replace(
        each,
        does=_jog("arm", (joint.name,), sign),
        title=f"{row} {words[place]}",
        label=words[place],
        row=row,
    )


_WORDS = {
    "length": (("in", "out"), -1),
    "roll": (("left", "right"), -1),
    "pitch": (("up", "down"), -1),
    "yaw": (("left", "right"), 1),
}
"""What the actions of a joint are called, and the sign of the first one for an axis that points
ahead, to the left or up."""


def _direction(joint: MovedJoint) -> str:
    if joint.kind == "prismatic":
        return "length"
    return ("roll", "pitch", "yaw")[_longest(joint)]


def _orientation(joint: MovedJoint) -> int:
    if joint.kind == "prismatic":
        return 1
    return 1 if joint.axis[_longest(joint)] >= 0.0 else -1


def _longest(joint: MovedJoint) -> int:
    return max(range(3), key=lambda index: abs(joint.axis[index]))


def _jog(node: str, joints: Iterable[str], sign: int) -> str:
    return f"{node} {' '.join(joints)} {'+' if sign > 0 else '-'}"


def _give_names(
    actions: List[NamedAction],
    kind: Type[Any],
    names: Sequence[str],
    does: str,
    title: str,
) -> List[NamedAction]:
    """Let presets, poses or lamps that no action names have the actions of those that are missing.

    Parameters
    ----------
    actions
        All.
    kind
        Class of the actions.
    names
        Of what the robot has.
    does, title
        Text of an action, and what the list of keys calls it, with {} for the name.
    """

    def named_by(each: NamedAction) -> Tuple[str, ...]:
        action = each.action
        return action.names if isinstance(action, Lamps) else (getattr(action, "name", ""),)

    of_kind = [each for each in actions if isinstance(each.action, kind)]
    named = {name for each in of_kind for name in named_by(each)}
    new = [name for name in names if name not in named]
    free = [each.name for each in of_kind if not set(named_by(each)) & set(names)]
    given = dict(zip(free, new))

    def worded(each: NamedAction, name: str) -> NamedAction:
        words = name.replace("_", " ")
        return replace(each, does=does.format(name), title=title.format(words), label=words)

    made = [worded(each, given[each.name]) if each.name in given else each for each in actions]
    for name in new[len(free) :]:
        like = of_kind[0] if of_kind else None
        blank = NamedAction(
            does="stop",
            name=does.format(name).replace(" ", ":"),
            group="" if like is None else like.group,
            modes=actions[0].modes if like is None else like.modes,
        )
        made.append(worded(blank, name))
    return made
