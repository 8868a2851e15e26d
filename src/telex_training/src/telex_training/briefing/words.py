"""Conditions of exercises in words, for people who are to fulfil or avoid them."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, Callable, Dict, List, Optional, Sequence

from ..exercises.conditions import (
    ELECTRONICS,
    ROBOT,
    TOOL,
    Answered,
    Condition,
    Dose,
    Dropped,
    Elapsed,
    Event,
    Force,
    Held,
    Inside,
    JointWithin,
    Latch,
    Moved,
    Tilted,
)

_EVENTS: Dict[str, str] = {
    "answer": "an answer is given",
    "camera": "the main view is changed",
    "command": "a command is given",
    "contact": "there is a contact that is not allowed",
    "drop": "something is dropped",
    "e_stop": "the e-stop is pressed",
    "mode": "the arm's mode is changed",
    "penalty": "there is a penalty",
    "step": "a step is done",
    "stuck": "the robot is stuck",
    "tipped": "the robot has tipped over",
}


def condition_words(condition: Condition) -> str:
    """Say when a condition holds: a clause, such as "the robot is in 'turn' for 0.5 s"."""
    return _clause(condition, True)


def thing_words(name: str) -> str:
    """Name an object, a group of links or a part of one: "the left board", "cone 1"."""
    of, _, body = name.partition("/")
    if body:
        return f"{thing_words(body)} of {thing_words(of)}"
    words = name.replace("_", " ")
    return words if words[-1:].isdigit() else f"the {words}"


def _clause(condition: Condition, holds: bool) -> str:
    held_for = f" for {condition.seconds:g} s" if condition.seconds else ""
    if condition.kind == "not":
        return _clause(condition.parts[0], not holds) + held_for
    if condition.parts:
        # What is not the case of all is not the case of one at least, and the other way round.
        together = (condition.kind == "all") == holds
        return _joined(condition.parts, together, holds) + held_for
    of_robot = f" (robot '{condition.robot}')" if condition.robot else ""
    return _CLAUSES[condition.kind](condition.of, holds) + of_robot + held_for


def _joined(parts: Sequence[Condition], together: bool, holds: bool) -> str:
    word = "and" if together else "or"
    merged = _merged(parts, word, holds)
    if merged is not None:
        return merged
    clauses = []
    for part in parts:
        clause = _clause(part, holds)
        mixed = len(part.parts) > 1 and ((part.kind == "all") == holds) != together
        clauses.append(f"({clause})" if mixed else clause)
    return listed(clauses, word)


def listed(words: Sequence[str], last: str) -> str:
    """Join words as a sentence does: "a, b or c"."""
    if len(words) < 2:
        return "".join(words)
    return f"{', '.join(words[:-1])} {last} {words[-1]}"


def _merged(parts: Sequence[Condition], word: str, holds: bool) -> Optional[str]:
    """Say what several touches, or forces, differ in but once; None: they differ in more."""
    first = parts[0]
    if first.kind not in ("touches", "force") or len(parts) < 2:
        return None
    if any(part.robot for part in parts):
        return None
    if word == "or" and not holds:
        return None  # "does not touch a or b" would say that it touches neither
    if not all(
        part.kind == first.kind
        and part.seconds == 0.0
        and replace(part.of, object="", group="") == replace(first.of, object="", group="")
        for part in parts
    ):
        return None
    things = list(dict.fromkeys(part.of.object for part in parts))
    groups = list(dict.fromkeys(part.of.group for part in parts))
    if len(things) * len(groups) != len(parts) or min(len(things), len(groups)) > 1:
        return None
    who = listed([_group(group) for group in groups], word)
    what = listed([thing_words(thing) for thing in things], word if holds else "or")
    many = groups == ["tracks"] or (len(groups) > 1 and word == "and")
    return _contact(first.of, who, many, what, holds)


def _subject(name: str) -> str:
    return {ROBOT: "the robot", TOOL: "the tool"}.get(name) or thing_words(name)


def _group(group: str) -> str:
    return thing_words(group) if group else "the robot"


def _verb(holds: bool, yes: str, bare: str) -> str:
    return yes if holds else f"does not {bare}"


def _is(holds: bool) -> str:
    return "is" if holds else "is not"


def _inside(of: Inside, holds: bool) -> str:
    return f"{_subject(of.what)} is {'in' if holds else 'outside'} '{of.zone.replace('_', ' ')}'"


def _joint(of: JointWithin, holds: bool) -> str:
    bounds: List[str] = []
    if of.above is not None:
        bounds.append(f"beyond {_position(of.joint, of.above)}")
    if of.below is not None:
        bounds.append(f"below {_position(of.joint, of.below)}")
    where = " and ".join(bounds)
    owner = "the robot" if of.object == ROBOT else thing_words(of.object)
    joint = of.joint.replace("_", " ")
    return f"the {joint} of {owner} {_verb(holds, 'stands', 'stand')} {where}"


def _position(joint: str, value: float) -> str:
    """Words for where a joint stands: hinges and slides of the scene library say which they are."""
    if joint.endswith("hinge"):
        return _degrees(value)
    return f"{value:g} m" if joint.endswith("slide") else f"{value:g} (rad or m)"


def _degrees(angle: float) -> str:
    degrees = math.degrees(angle)
    return f"{degrees:.0f}°" if abs(degrees) >= 10.0 else f"{degrees:.2g}°"


def _latch(of: Latch, holds: bool) -> str:
    return f"{thing_words(of.object)} is {'latched' if of.held == holds else 'unlatched'}"


def _held(of: Held, holds: bool) -> str:
    what = thing_words(of.object) if of.object else ("something" if holds else "anything")
    force = "" if of.above is None else f" with more than {of.above:g} N"
    return f"the gripper {_verb(holds, 'holds', 'hold')} {what}{force}"


def _dropped(of: Dropped, holds: bool) -> str:
    zones = listed([f"'{zone.replace('_', ' ')}'" for zone in of.outside], "and")
    where = f" outside {zones}" if zones else ""
    fall = f"from the gripper by more than {100.0 * of.height:g} cm{where}"
    return f"{thing_words(of.object)} {_verb(holds, 'falls', 'fall')} {fall}"


def _contact(of: Any, who: str, many: bool, what: str, holds: bool) -> str:
    negated = "do not" if many else "does not"
    if isinstance(of, Force):
        verb = ("push" if many else "pushes") if holds else f"{negated} push"
        return f"{who} {verb} {what} with more than {of.above:g} N"
    verb = ("touch" if many else "touches") if holds else f"{negated} touch"
    where = f" in '{of.zone.replace('_', ' ')}'" if of.zone else ""
    return f"{who} {verb} {what}{where}"


def _touches(of: Any, holds: bool) -> str:
    return _contact(of, _group(of.group), of.group == "tracks", thing_words(of.object), holds)


def _tilted(of: Tilted, holds: bool) -> str:
    more = "more" if holds else "no more"
    return f"{_subject(of.what)} leans by {more} than {_degrees(of.angle)}"


def _moved(of: Moved, holds: bool) -> str:
    far = "more" if holds else "no more"
    return f"{_subject(of.what)} is {far} than {100.0 * of.distance:g} cm from where it was"


def _answered(of: Answered, holds: bool) -> str:
    way = {None: "", True: " rightly", False: " wrongly"}[of.right]
    return f"the question '{of.question}' {_is(holds)} answered{way}"


def _dose(of: Dose, holds: bool) -> str:
    of_camera = "" if of.what in (ROBOT, *ELECTRONICS) else " camera"
    have = "have" if of.what in ELECTRONICS else "has"
    more = f"{have} received {'' if holds else 'no '}more than {of.above:g} Gy"
    return f"{_subject(of.what)}{of_camera} {more}"


def _elapsed(of: Elapsed, holds: bool) -> str:
    return f"{of.seconds:g} s have {'' if holds else 'not '}passed"


def _event(of: Event, holds: bool) -> str:
    times = f" ({of.count} times)" if of.count > 1 else ""
    return _EVENTS[of.name] + times if holds else f"it is not so that {_EVENTS[of.name]}{times}"


_CLAUSES: Dict[str, Callable[[Any, bool], str]] = {
    "inside": _inside,
    "joint": _joint,
    "latch": _latch,
    "held": _held,
    "dropped": _dropped,
    "touches": _touches,
    "force": _touches,
    "tilted": _tilted,
    "moved": _moved,
    "answered": _answered,
    "dose": _dose,
    "elapsed": _elapsed,
    "event": _event,
}
