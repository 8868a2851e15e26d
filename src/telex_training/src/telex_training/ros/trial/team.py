"""What a further robot's operator may do: what is open is his where his robot is in its team."""

from __future__ import annotations

from typing import Any, List, Mapping, Optional

from ...exercises.model import Exercise
from ...judging.trial_record import ENDED
from ..session import Session, SessionError


def settings_of(offer: Mapping[str, Any], place: int) -> List[str]:
    """Return the settings of an exercise, as `TrainingNode` offers it, that a robot can open.

    Parameters
    ----------
    place : int
        Of the robot on the station, from 0.
    """
    return [name for name in offer.get("settings", []) if offer["further"][name] >= place]


def require_in_team(session: Session, robot: str) -> None:
    """Refuse what is asked for at a robot that has no part in what is open.

    Parameters
    ----------
    robot : str
        Namespace of a further one.

    Raises
    ------
    SessionError
    """
    if robot not in session.others.values():
        raise SessionError(_not_his(session.exercise))


def require_opening(session: Optional[Session], exercise: Exercise, robot: str, place: int) -> None:
    """Refuse to open an exercise at a robot that has no part in it, or none in what is open.

    Parameters
    ----------
    session : Session, optional
        That is open.
    robot : str
        Namespace of a further one.
    place : int
        See `settings_of`.

    Raises
    ------
    SessionError
    """
    if len(exercise.robots) < place:
        raise SessionError(_not_his(exercise))
    if session is None or session.phase == ENDED or robot in session.others.values():
        return
    name = session.operator or "no name"
    raise SessionError(
        f"{session.exercise.title} is open at the first robot for {name}; until it has ended, "
        "another one can be opened there alone"
    )


def _not_his(exercise: Exercise) -> str:
    if not exercise.robots:
        return f"{exercise.title} is an exercise for one robot, the first one's"
    count = 1 + len(exercise.robots)
    return f"{exercise.title} is an exercise for the station's first {count} robots"
