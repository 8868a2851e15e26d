"""Checked answers of stations, which may be of another version, or no stations at all."""

from __future__ import annotations

import json
from dataclasses import dataclass, fields
from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple

from telex_control.common.params import ConfigError, read_struct, read_value, require

from ..progress.standing import LOCKED, OPEN, PROFICIENT, SPENT, WORKING

MOST_STATE, MOST_STANDING, MOST_PICTURE = 65_536, 2_000_000, 4_000_000
"""Bytes of the longest answer that is read."""
_BY_RANK = (LOCKED, OPEN, WORKING, SPENT, PROFICIENT)
"""Of a module; what somebody has reached on one station counts for all."""


class BadAnswerError(ValueError):
    """An answer makes no sense; the message says what of it."""


@dataclass(frozen=True)
class StationState:
    """A station's trial as it stands; see telex_msgs/TrainingState.

    Attributes
    ----------
    help : float or None
        For how long the trainee has asked for help (s); None: he does not.
    holder : str
        Name of who has control; empty: nobody, or no name.
    view : str
        Camera of the trainee's large picture; empty: unknown.
    """

    phase: str
    trial: str = ""
    exercise: str = ""
    title: str = ""
    setting: str = ""
    mode: str = ""
    operator: str = ""
    valid: bool = True
    repetition: int = 0
    repetitions: int = 0
    results: Tuple[str, ...] = ()
    elapsed: float = 0.0
    penalty: float = 0.0
    trial_elapsed: float = 0.0
    trial_limit: float = 0.0
    steps: Tuple[str, ...] = ()
    steps_done: Tuple[bool, ...] = ()
    faults: Tuple[str, ...] = ()
    hint: str = ""
    message: str = ""
    verdict: str = ""
    help: Optional[float] = None
    holder: str = ""
    view: str = ""


_FIELDS = {each.name for each in fields(StationState)}


def json_of(data: bytes) -> Any:
    """Decode JSON.

    Raises
    ------
    BadAnswerError
    """
    try:
        return json.loads(data)
    except (ValueError, RecursionError) as error:
        raise BadAnswerError(f"what came is no JSON: {str(error)[:100]}") from error


def state_of(content: Any) -> StationState:
    """Read a station's state; keys that are not known here are left out.

    Raises
    ------
    BadAnswerError
    """
    try:
        require(isinstance(content, Mapping), "a JSON object is needed")
        known = {key: value for key, value in content.items() if key in _FIELDS}
        return read_struct(StationState, known)
    except ConfigError as error:
        raise BadAnswerError(f"what came is no state of a station: {error}") from error


@dataclass(frozen=True)
class Course:
    """Where people stand in a curriculum.

    Attributes
    ----------
    people : dict of str to tuple of str
        State of each module, by name; see `telex_training.progress.standing`.
    """

    name: str
    title: str
    modules: Tuple[str, ...]
    people: Dict[str, Tuple[str, ...]]

    def __post_init__(self) -> None:
        for name, states in self.people.items():
            require(
                len(states) == len(self.modules) and set(states) <= set(_BY_RANK),
                f"people/{name[:40]} has {len(states)} states; one of {', '.join(_BY_RANK)} for "
                f"each of {len(self.modules)} modules is needed",
            )


def courses_of(content: Any) -> List[Course]:
    """Read a station's standings.

    Raises
    ------
    BadAnswerError
    """
    try:
        return list(read_value(Tuple[Course, ...], content, "standing"))
    except ConfigError as error:
        raise BadAnswerError(f"what came are no standings: {error}") from error


def merged(answers: Sequence[Sequence[Course]]) -> List[Course]:
    """Join the standings of several stations: of each module, the best that somebody has reached.

    A curriculum of one name with other modules, of another version, stands by itself.
    """
    joined: Dict[Tuple[str, Tuple[str, ...]], Course] = {}
    for course in (each for answer in answers for each in answer):
        key = (course.name, course.modules)
        known = joined.get(key)
        people = dict(known.people) if known is not None else {}
        for name, states in course.people.items():
            before = people.get(name, states)
            people[name] = tuple(max(pair, key=_BY_RANK.index) for pair in zip(before, states))
        ordered = dict(sorted(people.items()))
        joined[key] = Course(course.name, course.title, course.modules, ordered)
    return list(joined.values())
