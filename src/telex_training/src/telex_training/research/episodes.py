"""Repetitions of a recording as episodes: what was seen, commanded and credited, frame by frame."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Dict, Iterator, List, Mapping, Optional, Tuple

import numpy as np

from ..judging.activity import COMMANDS, STATUSES, asks_for_motion
from ..judging.entries import BadEntryError, Entry, decode
from ..judging.judge import Judge
from ..judging.trial_record import RUNNING
from ..recording.reader import Recording
from ..recording.trial_file import judge_of
from ..recording.writer import RecordingError
from ..replay.replay import Replay
from ..replay.timeline import Moment
from .command_vector import DRIVE_PART, CommandVector, node_of
from .reward import Reward

_HOLDS = 0.28
"""How long a command counts that is not repeated (s): the joint nodes' watchdog."""
_JOG = "control_msgs/JointJog"
_TWIST = "geometry_msgs/Twist"


@dataclass(frozen=True, eq=False)
class Episode:
    """One repetition.

    Attributes
    ----------
    task : str
        What was to be done, in words.
    moments : list of Moment
        One for each frame.
    states : ndarray, shape (frames, numbers), float32
        As `state_names` has them.
    actions : ndarray, shape (frames, numbers), float32
        What was commanded from each frame on until the next one, as `CommandVector` has it.
    rewards : ndarray, shape (frames,), float32
        For that time.
    success : bool
        Whether the repetition was completed.
    """

    task: str
    moments: List[Moment]
    states: np.ndarray
    actions: np.ndarray
    rewards: np.ndarray
    success: bool


class Given:
    """What the operator commands, as the teleoperation nodes would take it."""

    def __init__(self) -> None:
        self._speed: Dict[str, float] = {}
        self._held: Dict[str, Tuple[float, Mapping[str, float]]] = {}

    def take(self, entry: Entry, time: float) -> None:
        """Hear an entry of a recording at a time (s)."""
        node, channel = entry.channel.partition("/")[0], entry.channel
        try:
            if channel in STATUSES:
                self._speed[node] = float(decode(entry, STATUSES[channel]).speed_scale)
            elif channel in COMMANDS:
                self._held[node] = (time, _rates(entry) if asks_for_motion(entry) else {"": 0.0})
        except BadEntryError:
            return

    def at(self, time: float, vector: CommandVector) -> np.ndarray:
        """Return the rates that are held at a time (s); nan: only the robot's motion tells."""
        values = np.zeros(len(vector.rates))
        for i, rate in enumerate(vector.rates):
            node = node_of(rate.part)
            since, rates = self._held.get(node, (-np.inf, {}))
            if time - since <= _HOLDS:
                key = rate.name if rate.part == DRIVE_PART else rate.key
                value = np.nan if not rates else rates.get(key, 0.0)
                limited = np.clip(value, -rate.most, rate.most)
                values[i] = self._speed.get(node, 1.0) * limited
        return values


def _rates(entry: Entry) -> Dict[str, float]:
    """Return what a command asks for by name; empty: by other means than rates."""
    kind = COMMANDS[entry.channel]
    message = decode(entry, kind)
    if kind == _TWIST:
        return {"drive.linear": message.linear.x, "drive.angular": message.angular.z}
    if kind == _JOG and len(message.velocities) == len(message.joint_names):
        return dict(zip(message.joint_names, message.velocities))
    return {}


class _Frames:
    """A repetition that is under way."""

    def __init__(self, begin: float, judge: Judge) -> None:
        self.begin = begin
        self.reward = Reward(judge.exercise, judge.state(), {})
        self.actions: List[np.ndarray] = []
        self.rewards: List[float] = []

    def due(self, period: float) -> float:
        """When the present frame ends (s)."""
        return self.begin + (len(self.actions) + 1) * period

    def close(self, action: np.ndarray, judge: Judge) -> None:
        """End the present frame."""
        self.actions.append(action)
        self.rewards.append(math.fsum(self.reward.terms(judge.state()).values()))


def episodes(
    recording: Recording, replay: Replay, vector: CommandVector, rate: float
) -> Iterator[Episode]:
    """Yield the repetitions of a recording that have ended, but those from bookmarks.

    Parameters
    ----------
    replay : Replay
        Of the same.
    vector : CommandVector
        Of its robot.
    rate : float
        Frames per second of sim time.

    Raises
    ------
    RecordingError
        The recording does not say of what it is, or lacks a joint.
    """
    judge, given, period = judge_of(recording), Given(), 1.0 / rate
    frames: Optional[_Frames] = None
    for entry, time in zip(recording.entries, replay.timeline.entry_times.tolist()):
        while frames is not None and time >= frames.due(period):
            frames.close(given.at(frames.due(period), vector), judge)
        judge.feed(entry)
        given.take(entry, time)
        if frames is None:
            if judge.phase == RUNNING and not judge.state()["from_bookmark"]:
                frames = _Frames(time, judge)
        elif judge.phase != RUNNING:
            frames.close(given.at(time, vector), judge)
            if frames.reward.ended:
                yield _episode(replay, vector, frames, period)
            frames = None


def _episode(replay: Replay, vector: CommandVector, frames: _Frames, period: float) -> Episode:
    timeline, exercise = replay.timeline, replay.exercise
    count = len(frames.actions)
    moments = [timeline.moment(frames.begin + i * period) for i in range(count + 1)]
    states = np.array([_state(replay, vector, moment) for moment in moments])
    # States are those of the truth's samples, which may be nearer or further apart than frames.
    apart = np.diff([moment.time for moment in moments])
    measured = np.diff(states, axis=0) / np.where(apart > 0.0, apart, period)[:, np.newaxis]
    columns = {joint: 7 + i for i, joint in enumerate(vector.joints)}
    actions = np.array(frames.actions)
    for i, rate in enumerate(vector.rates):
        unknown = np.isnan(actions[:, i])
        found = measured[:, [columns[joint] for joint in rate.measured_by]]
        rates = found.mean(axis=1) if rate.measured_by else np.zeros(count)
        actions[unknown, i] = np.clip(rates, -rate.most, rate.most)[unknown]
    title = exercise.title or exercise.name
    return Episode(
        f"{title}: {exercise.description}" if exercise.description else title,
        moments[:-1],
        states[:-1].astype(np.float32),
        actions.astype(np.float32),
        np.array(frames.rewards, dtype=np.float32),
        frames.reward.succeeded,
    )


def _state(replay: Replay, vector: CommandVector, moment: Moment) -> List[float]:
    """Return what is seen of the robot at a moment, as `state_names` has it."""
    names, row = moment.part.names.joints, moment.part.joints[moment.row]
    for joint in vector.joints:
        if joint not in names:
            raise RecordingError(f"{replay.path}: its truth has no joint '{joint}'")
    joints = [row[names[joint]] for joint in vector.joints]
    return [*moment.part.base[moment.row].tolist(), *joints]
