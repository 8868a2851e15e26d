"""Doses of the robot's components, as the simulator tells them, and since a repetition began."""

from __future__ import annotations

import math
from typing import Dict, Mapping, Optional

from .entries import BadEntryError, Entry, decode

TYPE = "telex_msgs/ComponentDoses"


def read_doses(entry: Entry) -> Dict[str, float]:
    """Decode what each component has received (Gy).

    Raises
    ------
    BadEntryError
        It cannot be decoded, has more or fewer doses than names, or one that is no dose.
    """
    message = decode(entry, TYPE)
    if len(message.names) != len(message.dose):
        raise BadEntryError(f"it has {len(message.dose)} doses of {len(message.names)} components")
    for dose in message.dose:
        if not 0.0 <= dose < math.inf:
            raise BadEntryError(f"a dose is {dose} Gy; 0 or more is needed")
    return dict(zip(message.names, message.dose))


class DoseRecord:
    """What has been received since a repetition began."""

    def __init__(self) -> None:
        self._now: Dict[str, float] = {}
        self._before: Dict[str, float] = {}

    def begin(self) -> None:
        """Count from now on."""
        self._before = dict(self._now)

    def take(self, doses: Mapping[str, float]) -> None:
        """Take what components have received by now (Gy); one that is new counts from here on."""
        self._now = dict(doses)
        for component, dose in doses.items():
            self._before.setdefault(component, dose)

    def received(self, component: str) -> Optional[float]:
        """Dose of a component since the begin (Gy); None: nobody tells."""
        if component not in self._now:
            return None
        return self._now[component] - self._before[component]
