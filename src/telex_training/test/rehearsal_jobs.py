"""Functions that the rehearsal's tests have other processes do."""

from __future__ import annotations

import os
import signal
import threading
from pathlib import Path

from telex_training.operators.experts.brief import Brief
from telex_training.operators.handling import Hand
from telex_training.operators.port import NotManagedError

RELEASED = threading.Event()
"""For which ``wait`` waits, where it is done in the same process."""


class StubbornError(Exception):
    """An error that cannot be read out of a pipe: it is made of two values, and kept as one."""

    def __init__(self, place: str, why: str) -> None:
        super().__init__(f"{place}: {why}")


def work(job: str) -> str:
    """``double TEXT``, ``raise TEXT``, ``stick TEXT``, ``wait``, ``die FILE TIMES``.

    What dies is killed until the file is so long.
    """
    kind, _, rest = job.partition(" ")
    if kind == "double":
        return rest + rest
    if kind == "raise":
        raise ValueError(rest)
    if kind == "wait":
        assert RELEASED.wait(60.0)
        return "late"
    if kind == "stick":
        raise StubbornError("wall", rest)
    name, times = rest.split()
    path = Path(name)
    if len(path.read_text()) < int(times):
        with path.open("a") as file:
            file.write("x")
        os.kill(os.getpid(), signal.SIGKILL)
    return path.read_text()


def gives_up(hand: Hand, brief: Brief) -> None:
    """An operator who drives a little, by the setting's name."""
    hand.station.tick()
    raise NotManagedError(f"setting {brief.setting}: no way through")


def breaks(hand: Hand, brief: Brief) -> None:
    """An operator with a fault in its program."""
    raise ZeroDivisionError("of the operator's own")


NO_FUNCTION = 3
