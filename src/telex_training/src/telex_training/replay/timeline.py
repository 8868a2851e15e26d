"""A recording by moments: decoded once and laid out for looking them up.

Time is that of the replay: seconds since the first sample. It never runs back, also where the
simulator began anew in the middle of a recording.
"""

from __future__ import annotations

import math
import re
import struct
from typing import Any, Dict, List, NamedTuple, Sequence, Tuple

import numpy as np

from ..exercises.conditions import FLOOR
from ..judging.activity import COMMANDS, asks_for_motion
from ..judging.entries import (
    DOSES,
    LIGHT,
    MALFUNCTIONS,
    NAMES,
    STATUS,
    TELEMETRY,
    TRUTH,
    BadEntryError,
    Entry,
    decode,
    json_of,
    number_field,
    text_field,
)
from ..judging.truth import Names, Sample, read_sample
from ..recording.reader import Recording
from ..recording.writer import RecordingError
from .equipment import Equipment
from .series import Intervals, Steps

_FLOAT = "std_msgs/Float64"
_TRACKS = "tracks"
_HOLDS = 0.3
"""A command counts for so long (s): the watchdogs' 0.28 s and a sample."""
_LONGEST_AGE = 60.0
"""Age of a picture (s) beyond which nothing is drawn of as long ago."""
_TIMES_END = 2.0**32
"""Of what a ROS time can be (s)."""


class Moment(NamedTuple):
    """A sample of the truth by its place in the recording.

    Attributes
    ----------
    number : int
        Among all samples, from 0.
    part : TimelinePart
        It is one of.
    row : int
        In the part's arrays.
    time : float
        Of the replay (s).
    stamp : int
        Sim time that was recorded (ns).
    """

    number: int
    part: TimelinePart
    row: int
    time: float
    stamp: int


class TimelinePart:
    """Samples whose numbers are of the same names, as columns.

    Attributes
    ----------
    robot : str
        Name of the robot in the scene.
    first : int
        Index of its first sample.
    base : ndarray, shape (n, 7)
        Poses of the root link in the world (m, quaternion x y z w).
    joints : ndarray, shape (n, joints)
        rad, m; in the order of ``names.joints``.
    mechanisms : ndarray, shape (n, mechanisms)
        rad, m.
    """

    def __init__(self, message: Any, first: int) -> None:
        self.robot = str(message.robot)
        self.names = Names(message)
        self.first = first
        self.base = self.joints = self.mechanisms = np.zeros((0, 0))
        self._rows: List[Sample] = []
        self._moves: List[Tuple[List[int], List[Any]]] = [([], []) for _ in self.names.bodies]
        self._bodies: List[Tuple[np.ndarray, np.ndarray]] = []

    def __len__(self) -> int:
        return len(self._rows) if self._rows else len(self.base)

    def take(self, sample: Sample) -> None:
        """Append a sample.

        Raises
        ------
        BadEntryError
            It has more or fewer numbers than there are names.
        """
        names = self.names
        fits = len(sample.joints) == len(names.joints) and len(sample.mechanisms) == len(
            names.mechanisms
        )
        if not fits or any(index >= len(names.bodies) for index, _ in sample.moved):
            raise BadEntryError("the truth sample does not fit its names")
        row = len(self._rows)
        for index, (position, orientation) in sample.moved:
            rows, poses = self._moves[index]
            rows.append(row)
            poses.append((*position, *orientation))
        # What has become columns elsewhere is not kept twice.
        self._rows.append(sample._replace(moved=(), contacts=()))

    def close(self) -> None:
        """Make columns of what was taken."""
        rows = self._rows
        self.base = np.array([(*s.base[0], *s.base[1]) for s in rows], dtype=np.float64)
        self.joints = np.array([s.joints for s in rows], dtype=np.float32)
        self.mechanisms = np.array([s.mechanisms for s in rows], dtype=np.float32)
        self._bodies = [
            (np.array(found), np.array(poses, dtype=np.float64)) for found, poses in self._moves
        ]
        self._rows, self._moves = [], []

    def bodies(self, row: int) -> Dict[str, Tuple[float, ...]]:
        """Poses of the bodies that move by themselves (m, quaternion), by "<object>/<link>"."""
        found: Dict[str, Tuple[float, ...]] = {}
        for name, (rows, poses) in zip(self.names.bodies, self._bodies):
            at = int(np.searchsorted(rows, row, side="right")) - 1
            if at >= 0:
                found[name] = tuple(poses[at].tolist())
        return found


class Timeline:
    """A recording, by time.

    Parameters
    ----------
    robot : str
        Which of its robots it is about, by the exercise's name; empty: the first.
    robots : sequence of str
        Names of further robots in it.

    Attributes
    ----------
    times : ndarray, shape (n,)
        Of the samples (s).
    stamps : ndarray of int, shape (n,)
        Sim times that were recorded (ns).
    speed, force, margin : ndarray, shape (n,)
        Of the root link over the ground (m/s); largest mean over 20 ms of what a group of links and
        a thing did to each other, but tracks on the floor (N); tip-over margin.
    age : Steps
        Age of the main picture that the console told (s).
    view : Steps
        Camera of the main picture.
    switches : dict of str to Steps
        Lamps and zooms by their topics.
    light : Steps
        Shares of the scene's daylight and of its lamps' light.
    equipment : Equipment
        What radiation and malfunctions had done to cameras and lamps.
    keys : dict of str to Intervals
        When each teleoperation node was asked for motion.
    stopped, paused : Intervals
        When the emergency stop was set, and the simulation paused.
    released : list of tuple of float and str
        When, and why, the console let go of the keys.
    entry_times : ndarray, shape (entries,)
        Time of each entry of the recording (s).
    bad : int
        Entries that could not be used.

    Raises
    ------
    RecordingError
        It has no truth with names.
    """

    def __init__(self, recording: Recording, robot: str = "", robots: Sequence[str] = ()) -> None:
        self._robot, self._robots = robot, tuple(robots)
        self.age, self.view, self.light = Steps(), Steps(), Steps()
        self.switches: Dict[str, Steps] = {}
        self.equipment = Equipment()
        self.keys: Dict[str, Intervals] = {}
        self.stopped, self.paused = Intervals(), Intervals()
        self.released: List[Tuple[float, str]] = []
        self.bad = 0
        self._parts: List[TimelinePart] = []
        self._times: List[float] = []
        self._stamps: List[int] = []
        self._figures: List[Tuple[float, float, float]] = []
        self._known: Dict[int, TimelinePart] = {}
        self._offset = 0.0
        self._now = -math.inf
        entry_times = []
        for recorded in recording.entries:
            entry = recorded._replace(channel=self._own(recorded.channel))
            if entry.channel != TRUTH and math.isfinite(entry.time):
                self._now = max(self._now, entry.time + self._offset)
            try:
                self._take(entry)
            except BadEntryError:
                self.bad += 1
            entry_times.append(self._now)
        if not self._times:
            raise RecordingError(f"{recording.path}: it has no truth that could be drawn")
        self._finish(entry_times)

    def _finish(self, entry_times: List[float]) -> None:
        begin = self._times[0]
        self._parts = [part for part in self._parts if len(part)]
        self._firsts = np.array([part.first for part in self._parts])
        for part in self._parts:
            part.close()
        self.times = np.array(self._times) - begin
        self.stamps = np.array(self._stamps, dtype=np.int64)
        self.speed, self.force, self.margin = np.array(self._figures).T
        self.entry_times = np.clip(np.array(entry_times) - begin, 0.0, self.duration)
        for steps in (self.age, self.view, self.light, *self.switches.values()):
            steps.shift(begin)
        for spans in (self.stopped, self.paused, *self.keys.values()):
            spans.close(self._times[-1])
            spans.shift(begin, self.duration)
        self.equipment.close(self._times[-1], begin, self.duration)
        self.released = [(max(0.0, time - begin), why) for time, why in self.released]
        self._times, self._stamps, self._figures = [], [], []

    # --- reading ---------------------------------------------------------------------------------

    def _own(self, channel: str) -> str:
        """Name of a channel without that of the robot; empty: it is of another robot."""
        robot, _, rest = channel.partition("/")
        if robot not in self._robots:
            return "" if self._robot else channel
        return rest if robot == self._robot else ""

    def _take(self, entry: Entry) -> None:
        channel = entry.channel
        if not channel:
            return
        if channel == TRUTH:
            self._take_truth(entry)
        elif channel == NAMES:
            message = decode(entry, "telex_msgs/TruthNames")
            part = TimelinePart(message, len(self._times))
            self._known[int(message.revision)] = part
            self._parts.append(part)
        elif channel == STATUS:
            status = decode(entry, "telex_msgs/SimStatus")
            self.stopped.set(self._now, bool(status.e_stop))
            self.paused.set(self._now, bool(status.paused))
        elif channel == TELEMETRY:
            self._take_telemetry(entry)
        elif channel == LIGHT:
            self._take_light(entry)
        elif channel == DOSES:
            self.equipment.take_doses(entry, self._now)
        elif channel == MALFUNCTIONS:
            self.equipment.take_malfunctions(entry, self._now)
        elif channel in COMMANDS:
            if asks_for_motion(entry):
                node = channel.partition("/")[0]
                self.keys.setdefault(node, Intervals()).extend(self._now, _HOLDS)
        elif entry.kind == _FLOAT:
            (value,) = _float(entry.data)
            self.switches.setdefault(_setting(channel), Steps()).append(self._now, value)

    def _take_truth(self, entry: Entry) -> None:
        sample = read_sample(entry.data)
        part = self._known.get(sample.revision)
        if part is None or part is not self._parts[-1]:
            return  # it was on its way when the names came
        if sample.time >= _TIMES_END:
            raise BadEntryError(f"its time is {sample.time} s; ROS has none from {_TIMES_END:g} s")
        # Before anything is kept of it: of what has no name there is no force.
        x, y = sample.twist[:2]
        figures = math.hypot(x, y), _force(sample, part.names), sample.margin
        part.take(sample)
        # Where the simulator began anew, time goes on from where it was.
        if sample.time + self._offset < self._now - 1.0:
            self._offset = self._now - sample.time
        self._now = max(self._now, sample.time + self._offset)
        self._times.append(self._now)
        self._stamps.append(round(sample.time * 1e9))
        self._figures.append(figures)

    def _take_light(self, entry: Entry) -> None:
        message = decode(entry, "telex_msgs/SceneLight")
        shares = (message.daylight, message.lamps)
        if not all(0.0 <= share <= 1.0 for share in shares):
            raise BadEntryError(f"shares of light are {shares}; 0 to 1 is needed")
        self.light.append(self._now, shares)

    def _take_telemetry(self, entry: Entry) -> None:
        content = json_of(entry)
        view = text_field(content, "view")
        if view:
            self.view.append(self._now, view)
        if "picture_age" in content:
            age = number_field(content, "picture_age")
            if 0.0 <= age <= _LONGEST_AGE:
                self.age.append(self._now, age)
        why = text_field(content, "released")
        if why:
            self.released.append((self._now, why))

    # --- looking up ------------------------------------------------------------------------------

    @property
    def duration(self) -> float:
        """Time of the last sample (s)."""
        return float(self.times[-1])

    def index(self, time: float) -> int:
        """Index of the last sample that is not after a time (s); the first, before it.

        Raises
        ------
        ValueError
            The time is not finite.
        """
        if not math.isfinite(time):
            raise ValueError(f"time is {time}; a finite number is needed")
        # A rounded time of a sample must find it.
        return max(0, int(np.searchsorted(self.times, time + 1e-4, side="right")) - 1)

    def moment(self, time: float) -> Moment:
        """Sample that shows a time (s); see `index`."""
        return self.at(self.index(time))

    def at(self, index: int) -> Moment:
        """Sample of an index, which is taken for the nearest that there is."""
        index = min(max(index, 0), len(self.times) - 1)
        number = int(np.searchsorted(self._firsts, index, side="right")) - 1
        part = self._parts[number]
        time, stamp = float(self.times[index]), int(self.stamps[index])
        return Moment(index, part, index - part.first, time, stamp)

    @property
    def parts(self) -> Tuple[TimelinePart, ...]:
        """All of them, in the order of time."""
        return tuple(self._parts)


def _setting(channel: str) -> str:
    """Topic that sets what is told on a channel; recordings of before have that topic itself."""
    for told, sets in ((r"(cameras/\w+/zoom)_factor", r"\1"), (r"(lamps/\w+/)level", r"\1command")):
        channel = re.sub(f"^{told}$", sets, channel)
    return channel


def _force(sample: Sample, names: Names) -> float:
    largest = 0.0
    for contact in sample.contacts:
        if contact.steps == 0 or contact.group >= len(names.groups):
            continue
        drives = names.groups[contact.group] == _TRACKS and names.thing(contact.object) == FLOOR
        if not drives:
            largest = max(largest, contact.peak)
    return largest


def _float(data: bytes) -> Tuple[float]:
    try:
        (value,) = struct.unpack("<d", data)
    except struct.error:
        raise BadEntryError("it is no std_msgs/Float64") from None
    if not math.isfinite(value):
        raise BadEntryError(f"it is {value}; a finite number is needed")
    return (value,)
