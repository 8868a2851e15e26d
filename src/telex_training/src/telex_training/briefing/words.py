"""Conditions of exercises in words, for people who are to fulfil or avoid them."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, Callable, Dict, List, Mapping, NamedTuple, Optional, Sequence, Tuple, Union

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


# By whether it is pushed, by several, and whether it is so.
_CONTACTS: Dict[Tuple[bool, bool, bool], str] = {
    (False, False, True): "{who} touches {what}",
    (False, False, False): "{who} does not touch {what}",
    (False, True, True): "{who} touch {what}",
    (False, True, False): "{who} do not touch {what}",
    (True, False, True): "{who} pushes {what}",
    (True, False, False): "{who} does not push {what}",
    (True, True, True): "{who} push {what}",
    (True, True, False): "{who} do not push {what}",
}

Value = Union[str, float, "Said"]


class Said(NamedTuple):
    """A sentence in parts, which pages say in other languages.

    Attributes
    ----------
    english : str
        With values in braces. What follows a bar, here and in values that are texts, is not said:
        it tells apart what other languages say in other words, such as ``|object`` what they
        decline.
    values : mapping
        By the names in braces.
    """

    english: str
    values: Mapping[str, Any]

    def __str__(self) -> str:
        texts = {name: _plain(value) for name, value in self.values.items()}
        return _plain(self.english).format(**texts)

    def as_json(self) -> Dict[str, Any]:
        """Return the parts as plain data."""
        values = {
            name: value.as_json() if isinstance(value, Said) else value
            for name, value in self.values.items()
        }
        return {"english": self.english, "values": values}


def _plain(value: Value) -> str:
    if isinstance(value, str):
        return value.split("|")[0]
    return str(value) if isinstance(value, Said) else f"{value:g}"


def say(english: str, **values: Value) -> Said:
    """Make a sentence of its values."""
    return Said(english, values)


def condition_words(condition: Condition) -> Said:
    """Say when a condition holds: a clause, such as "the robot is in 'turn' for 0.5 s"."""
    return _clause(condition, True)


def thing_words(name: str, form: str = "") -> Value:
    """Name an object, a group of links or a part of one: "the left board", "cone 1".

    Parameters
    ----------
    name : str
    form : str
        For languages that decline: empty where it is what does something, ``object`` where
        something is done to it, ``of`` where it has a part.
    """
    of, _, body = name.partition("/")
    if body:
        return say("{part} of {whole}", part=thing_words(body), whole=thing_words(of, "of"))
    words = name.replace("_", " ")
    named = words if words[-1:].isdigit() else f"the {words}"
    return f"{named}|{form}" if form else named


def _clause(condition: Condition, holds: bool) -> Said:
    if condition.kind == "not":
        made = _clause(condition.parts[0], not holds)
    elif condition.parts:
        # What is not the case of all is not the case of one at least, and the other way round.
        made = _joined(condition.parts, (condition.kind == "all") == holds, holds)
    else:
        made = _CLAUSES[condition.kind](condition.of, holds)
        if condition.robot:
            made = say("{clause} (robot '{robot}')", clause=made, robot=condition.robot)
    if condition.seconds:
        made = say("{clause} for {seconds} s", clause=made, seconds=condition.seconds)
    return made


def _joined(parts: Sequence[Condition], together: bool, holds: bool) -> Said:
    word = "and" if together else "or"
    merged = _merged(parts, word, holds)
    if merged is not None:
        return merged
    clauses: List[Value] = []
    for part in parts:
        clause = _clause(part, holds)
        mixed = len(part.parts) > 1 and ((part.kind == "all") == holds) != together
        clauses.append(say("({clause})", clause=clause) if mixed else clause)
    return listed(clauses, word)


def listed(words: Sequence[Value], last: str) -> Said:
    """Join words as a sentence does: "a, b or c"."""
    if len(words) < 2:
        return say("{what}", what=words[0])
    if len(words) == 2:
        both = "{first} and {last}" if last == "and" else "{first} or {last}"
        return say(both, first=words[0], last=words[1])
    return say("{first}, {rest}", first=words[0], rest=listed(words[1:], last))


def _merged(parts: Sequence[Condition], word: str, holds: bool) -> Optional[Said]:
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
    what = listed([thing_words(thing, "object") for thing in things], word if holds else "or")
    many = groups == ["tracks"] or (len(groups) > 1 and word == "and")
    return _contact(first.of, who, many, what, holds)


def _subject(name: str) -> Value:
    return {ROBOT: "the robot", TOOL: "the tool"}.get(name) or thing_words(name)


def _group(group: str) -> Value:
    return thing_words(group) if group else "the robot"


def _zone(name: str) -> str:
    return f"{name.replace('_', ' ')}|zone"


def _inside(of: Inside, holds: bool) -> Said:
    words = "{what} is in '{zone}'" if holds else "{what} is outside '{zone}'"
    return say(words, what=_subject(of.what), zone=_zone(of.zone))


def _joint(of: JointWithin, holds: bool) -> Said:
    least, most = (
        None if bound is None else _position(of.joint, bound) for bound in (of.above, of.below)
    )
    if least is not None and most is not None:
        where = say("beyond {least} and below {most}", least=least, most=most)
    elif least is not None:
        where = say("beyond {position}", position=least)
    else:
        assert most is not None
        where = say("below {position}", position=most)
    owner = "the robot|of" if of.object == ROBOT else thing_words(of.object, "of")
    part = f"the {of.joint.replace('_', ' ')}"
    joint = say("{part} of {whole}", part=part, whole=owner)
    words = "{joint} stands {where}" if holds else "{joint} does not stand {where}"
    return say(words, joint=joint, where=where)


def _position(joint: str, value: float) -> Said:
    """Words for where a joint stands: hinges and slides of the scene library say which they are."""
    if joint.endswith("hinge"):
        return _degrees(value)
    words = "{length} m" if joint.endswith("slide") else "{length} (rad or m)"
    return say(words, length=value)


def _degrees(angle: float) -> Said:
    degrees = math.degrees(angle)
    return say(
        "{angle}°", angle=float(f"{degrees:.0f}" if abs(degrees) >= 10.0 else f"{degrees:.2g}")
    )


def _latch(of: Latch, holds: bool) -> Said:
    words = "{what} is latched" if of.held == holds else "{what} is unlatched"
    return say(words, what=thing_words(of.object))


def _held(of: Held, holds: bool) -> Said:
    if of.object:
        words = "the gripper holds {what}" if holds else "the gripper does not hold {what}"
        made = say(words, what=thing_words(of.object, "object"))
    else:
        words = "the gripper holds something"
        made = say(words if holds else "the gripper does not hold anything")
    if of.above is None:
        return made
    return say("{clause} with more than {force} N", clause=made, force=of.above)


def _dropped(of: Dropped, holds: bool) -> Said:
    falls = "{what} falls from the gripper by more than {height} cm"
    not_so = "{what} does not fall from the gripper by more than {height} cm"
    made = say(falls if holds else not_so, what=thing_words(of.object), height=100.0 * of.height)
    if not of.outside:
        return made
    zones = listed([say("'{zone}'|zone", zone=_zone(zone)) for zone in of.outside], "and")
    return say("{clause} outside {zones}", clause=made, zones=zones)


def _contact(of: Any, who: Value, many: bool, what: Value, holds: bool) -> Said:
    made = say(_CONTACTS[isinstance(of, Force), many, holds], who=who, what=what)
    if isinstance(of, Force):
        return say("{clause} with more than {force} N", clause=made, force=of.above)
    return say("{clause} in '{zone}'", clause=made, zone=_zone(of.zone)) if of.zone else made


def _touches(of: Any, holds: bool) -> Said:
    what = thing_words(of.object, "object")
    return _contact(of, _group(of.group), of.group == "tracks", what, holds)


def _tilted(of: Tilted, holds: bool) -> Said:
    words = "{what} leans by more than {angle}" if holds else "{what} leans by no more than {angle}"
    return say(words, what=_subject(of.what), angle=_degrees(of.angle))


def _moved(of: Moved, holds: bool) -> Said:
    far = "{what} is more than {distance} cm from where it was"
    near = "{what} is no more than {distance} cm from where it was"
    return say(far if holds else near, what=_subject(of.what), distance=100.0 * of.distance)


def _answered(of: Answered, holds: bool) -> Said:
    words = "the question '{question}' is answered"
    not_so = "the question '{question}' is not answered"
    made = say(words if holds else not_so, question=of.question.replace("_", " "))
    if of.right is None:
        return made
    return say("{clause} rightly" if of.right else "{clause} wrongly", clause=made)


def _dose(of: Dose, holds: bool) -> Said:
    what = _subject(of.what)
    if of.what not in (ROBOT, *ELECTRONICS):
        what = say("{what} camera", what=thing_words(of.what, "of"))
    if of.what in ELECTRONICS:
        words = "{what} have received more than {dose} Gy"
        not_so = "{what} have received no more than {dose} Gy"
    else:
        words = "{what} has received more than {dose} Gy"
        not_so = "{what} has received no more than {dose} Gy"
    return say(words if holds else not_so, what=what, dose=of.above)


def _elapsed(of: Elapsed, holds: bool) -> Said:
    words = "{seconds} s have passed" if holds else "{seconds} s have not passed"
    return say(words, seconds=of.seconds)


def _event(of: Event, holds: bool) -> Said:
    made = say(_EVENTS[of.name])
    if of.count > 1:
        made = say("{clause} ({count} times)", clause=made, count=of.count)
    return made if holds else say("it is not so that {clause}", clause=made)


_CLAUSES: Dict[str, Callable[[Any, bool], Said]] = {
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
