"""Radiation and malfunctions of a robot's cameras and lamps in a recording, by time."""

from __future__ import annotations

import math
from typing import Any, Dict, Optional, Sequence

from telex_msgs.msg import CameraRadiation, Malfunctions

from telex_sim.malfunctions import battery, kinds

from ..judging.entries import BadEntryError, Entry, decode
from .series import Intervals, Steps


class Equipment:
    """Doses and malfunctions as they were recorded.

    Entries are kept, not what they say: doses come five times a second.
    """

    def __init__(self) -> None:
        self._doses, self._broken = Steps(), Steps()
        self._frozen: Dict[str, Intervals] = {}

    def take_doses(self, entry: Entry, time: float) -> None:
        """Take a telex_msgs/ComponentDoses that holds from a time (s) on.

        Raises
        ------
        BadEntryError
        """
        message = decode(entry, "telex_msgs/ComponentDoses")
        columns = (message.names, message.dose_rate, message.dose, message.failed)
        if len({len(column) for column in columns}) > 1:
            raise BadEntryError(
                f"it has {len(message.dose_rate)} rates, {len(message.dose)} doses and "
                f"{len(message.failed)} failures of {len(message.names)} components"
            )
        for number in (*message.dose_rate, *message.dose):
            if not 0.0 <= number < math.inf:
                raise BadEntryError(f"a dose or rate is {number}; 0 or more is needed")
        self._doses.append(time, entry)

    def take_malfunctions(self, entry: Entry, time: float) -> None:
        """Take a telex_msgs/Malfunctions that holds from a time (s) on.

        Raises
        ------
        BadEntryError
        """
        message = decode(entry, "telex_msgs/Malfunctions")
        seen = [each for each in message.active if each.group in (kinds.CAMERA, kinds.LAMP)]
        for each in seen:
            if not math.isfinite(each.value):
                raise BadEntryError(f"the value of {each.what} {each.kind} is {each.value}")
        frozen = {each.what for each in seen if _is_frozen(each)}
        for camera in frozen | set(self._frozen):
            self._frozen.setdefault(camera, Intervals()).set(time, camera in frozen)
        kept = [each for each in seen if not _is_frozen(each)]
        self._broken.append(time, Malfunctions(active=kept, unpowered=message.unpowered))

    def close(self, end: float, begin: float, duration: float) -> None:
        """Take no more: the last sample came at `end`, and time counts from `begin` on (s)."""
        for steps in (self._doses, self._broken):
            steps.shift(begin)
        for spans in self._frozen.values():
            spans.close(end)
            spans.shift(begin, duration)

    def frozen_since(self, camera: str, time: float) -> Optional[float]:
        """Time (s) at which a camera froze that is frozen at a time (s); None: it is not."""
        spans = self._frozen.get(camera)
        return None if spans is None else spans.since(time)

    def silent(self, camera: str, time: float) -> str:
        """Say why a camera sent no pictures at a time (s); empty: it did."""
        if battery.CAMERAS in self.malfunctions(time).unpowered:
            return "the empty battery feeds no camera"
        radiation = self._radiation(time)
        if camera in radiation.names and radiation.failed[radiation.names.index(camera)]:
            return "it has died of its dose"
        return ""

    def malfunctions(self, time: float) -> Malfunctions:
        """What was broken of cameras and lamps at a time (s).

        Without what makes a camera freeze: its pictures are those of another time.
        """
        found: Optional[Malfunctions] = self._broken.at(time)
        return Malfunctions() if found is None else found

    def radiation(self, cameras: Sequence[str], time: float) -> CameraRadiation:
        """What some cameras had received at a time (s); nothing where nobody told of it."""
        told = self._radiation(time)
        kept = [index for index, name in enumerate(told.names) if name in cameras]
        return CameraRadiation(
            names=[told.names[index] for index in kept],
            dose_rate=[told.dose_rate[index] for index in kept],
            dose=[told.dose[index] for index in kept],
            failed=[told.failed[index] for index in kept],
        )

    def _radiation(self, time: float) -> CameraRadiation:
        entry: Optional[Entry] = self._doses.at(time)
        if entry is None:
            return CameraRadiation()
        return decode(entry, "telex_msgs/ComponentDoses")


def _is_frozen(active: Any) -> bool:
    return bool(active.group == kinds.CAMERA and active.kind == kinds.FROZEN.name)
