"""The judge's record of a robot beside the first one."""

from __future__ import annotations

from typing import List, Optional, Tuple

from telex_sim.scene.model import Scene

from ..activity import COMMANDS, STATUSES, ActivityRecord
from ..entries import (
    ACTIONS,
    CLIENTS,
    DOSES,
    E_STOP,
    LINK,
    MALFUNCTIONS,
    NAMES,
    STATUS,
    TELEMETRY,
    TRUTH,
    Entry,
    decode,
    doses_of,
)
from ..malfunctions import MalfunctionRecord
from ..truth import Names, Sample, World
from ..validity import Continuity, LinkRecord
from .aids import LASER_LINK, LASERS

CHANNELS = (
    NAMES,
    TRUTH,
    STATUS,
    DOSES,
    MALFUNCTIONS,
    E_STOP,
    CLIENTS,
    ACTIONS,
    TELEMETRY,
    LINK,
    *LASERS,
    *COMMANDS,
    *STATUSES,
)
"""What of a further robot is looked at; in a recording its name stands before each."""
LATE = 1.0
"""Sim time after which a robot of which no truth comes is missing (s)."""


def channel_of(robot: str, channel: str) -> str:
    """Name of a robot's channel in a recording; the first one's stands as it is."""
    return f"{robot}/{channel}" if robot else channel


class OtherRobot:
    """A further robot of a trial.

    Parameters
    ----------
    name : str
        As the exercise calls it.
    scene : Scene, optional
    urdf : str
        See `World`.

    Attributes
    ----------
    world : World
        As its own truth tells it.
    """

    def __init__(self, name: str, scene: Optional[Scene], urdf: str) -> None:
        self.name = name
        self.world = World(scene, urdf)
        self.activity = ActivityRecord()
        self.continuity = Continuity()
        self.link = LinkRecord()
        self.malfunctions = MalfunctionRecord()
        self._has_lasers = f'"{LASER_LINK}"' in urdf

    def hear(self, entry: Entry) -> List[str]:
        """Hear an entry of its own: not truth, line, failures, nor an instructor's act.

        Returns
        -------
        list of str
            Events.

        Raises
        ------
        BadEntryError
        """
        channel, activity = entry.channel, self.activity
        if channel == NAMES:
            self.world.name(Names(decode(entry, "telex_msgs/TruthNames")))
            return []
        if channel == STATUS:
            return activity.sim_status(decode(entry, "telex_msgs/SimStatus"))
        if channel == DOSES:
            self.world.doses.take(doses_of(entry))
            return []
        if channel == CLIENTS:
            activity.clients(entry)
            return []
        if channel in LASERS:
            if self._has_lasers:
                activity.aids.switch_lasers(decode(entry, "std_msgs/Float64").data)
            return []
        if channel in COMMANDS:
            event = activity.command(entry)
        elif channel in STATUSES:
            event = activity.teleop_status(entry)
        else:
            event = activity.telemetry(entry)
        return [event] if event else []

    def take(self, sample: Sample) -> Optional[Tuple[float, int]]:
        """Take a sample; returns time (s) and steps since the one before, or None: not named yet.

        Raises
        ------
        BadEntryError
        """
        world, before = self.world, self.world.sample
        if not world.knows(sample):
            return None
        world.take(sample)
        if before is None:
            return 0.0, 0
        return max(0.0, sample.time - before.time), max(0, sample.steps - before.steps)

    def is_there(self, time: float, resets: int) -> bool:
        """Whether its truth is of now (s), and of a world that was put back so often."""
        sample = self.world.sample
        return sample is not None and sample.resets >= resets and time - sample.time <= LATE
