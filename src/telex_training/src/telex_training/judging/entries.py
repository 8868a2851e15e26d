"""Entries of the ordered inbox, and what their serialised messages say."""

from __future__ import annotations

import json
import math
from functools import lru_cache
from typing import Any, Dict, NamedTuple, Type

import genpy

from telex_control.common.geometry.quaternions import Pose

from ..plain_data import require_text

INPUTS = "training/inputs"
"""Channel of the training's own inputs: JSON in std_msgs/String."""
TRUTH, NAMES, STATUS = "sim/truth", "sim/truth_names", "sim/status"
CLIENTS, TELEMETRY, LINK = "bridge/clients", "console/telemetry", "link/state"
MALFUNCTIONS, E_STOP, DOSES = "sim/malfunctions", "e_stop", "sim/doses"
LIGHT = "sim/light"
"""Shares of the scene's light; for the replay."""
ACTIONS = "bridge/actions"
"""What instructors have done to the scene, with their names."""
ODOMETRY, ODOMETRY_PERIOD = "track_controller/odom", 0.2
"""Recorded where the exercise has a survey; and sim time from one to the next that is (s)."""
_LONGEST_JSON = 100_000


class Entry(NamedTuple):
    """What arrived in the inbox.

    Attributes
    ----------
    number : int
        One more with every entry.
    time : float
        Sim time of its arrival (s).
    channel : str
        Name of the topic in the robot's namespace.
    kind : str
        Type of the message.
    data : bytes
        As it is serialised.
    """

    number: int
    time: float
    channel: str
    kind: str
    data: bytes


class BadEntryError(ValueError):
    """An entry cannot be used; the message says why."""


@lru_cache(maxsize=None)
def _message_class(kind: str) -> Type[Any]:
    found = genpy.message.get_message_class(kind)
    if found is None:
        raise BadEntryError(f"type '{kind}' is unknown")
    return found


def decode(entry: Entry, *kinds: str) -> Any:
    """Make the message of an entry.

    Parameters
    ----------
    *kinds : str
        Types that its channel may have.

    Raises
    ------
    BadEntryError
    """
    if entry.kind not in kinds:
        raise BadEntryError(f"its type is '{entry.kind}'; {' or '.join(kinds)} is needed")
    message = _message_class(entry.kind)()
    try:
        message.deserialize(entry.data)
    except Exception as error:  # genpy raises what the bytes lead it to
        raise BadEntryError(f"it is no {entry.kind}: {type(error).__name__}") from None
    return message


def doses_of(entry: Entry) -> Dict[str, float]:
    """Return what each component has received (Gy), of a telex_msgs/ComponentDoses.

    Raises
    ------
    BadEntryError
        It has more or fewer doses than names, or one that is no dose.
    """
    message = decode(entry, "telex_msgs/ComponentDoses")
    if len(message.names) != len(message.dose):
        raise BadEntryError(f"it has {len(message.dose)} doses of {len(message.names)} components")
    for dose in message.dose:
        if not 0.0 <= dose < math.inf:
            raise BadEntryError(f"a dose is {dose} Gy; 0 or more is needed")
    return dict(zip(message.names, message.dose))


def odometry_of(entry: Entry) -> Pose:
    """Return the pose of a nav_msgs/Odometry.

    Raises
    ------
    BadEntryError
        It has a number that is not finite.
    """
    pose = decode(entry, "nav_msgs/Odometry").pose.pose
    place, turn = pose.position, pose.orientation
    made = (place.x, place.y, place.z), (turn.x, turn.y, turn.z, turn.w)
    if not all(map(math.isfinite, (*made[0], *made[1]))):
        raise BadEntryError(f"its pose is {made}; finite numbers are needed")
    return made


def text_of(entry: Entry) -> str:
    """Return the text of a std_msgs/String.

    Raises
    ------
    BadEntryError
    """
    return str(decode(entry, "std_msgs/String").data)


def json_of(entry: Entry) -> Dict[str, Any]:
    """Return the struct that a std_msgs/String has as JSON.

    Raises
    ------
    BadEntryError
        It is no JSON, no struct, too long, or has a number that is not finite or a text that is
        none.
    """
    text = text_of(entry)
    if len(text) > _LONGEST_JSON:
        raise BadEntryError(f"it has {len(text)} characters; at most {_LONGEST_JSON} are read")
    try:
        made = json.loads(text, parse_constant=_refuse)
        require_text(made)
    except (ValueError, RecursionError) as error:
        raise BadEntryError(f"it is no JSON: {str(error)[:80]}") from None
    if not isinstance(made, dict):
        raise BadEntryError(f"it is {text[:40]!r}; a struct is needed")
    return made


def _refuse(word: str) -> None:
    raise ValueError(f"{word} is not finite")


def text_field(content: Dict[str, Any], key: str, default: str = "") -> str:
    """Return a text of a struct.

    Raises
    ------
    BadEntryError
    """
    value = content.get(key, default)
    if not isinstance(value, str) or len(value) > 2000:
        raise BadEntryError(f"{key} is {str(value)[:40]!r}; a text is needed")
    return value


def number_field(content: Dict[str, Any], key: str) -> float:
    """Return a finite number of a struct.

    Raises
    ------
    BadEntryError
    """
    value = content.get(key)
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise BadEntryError(f"{key} is {str(value)[:40]!r}; a number is needed")
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise BadEntryError(f"{key} is {str(value)[:40]!r}; it must be finite")
    return number
