"""A recording opened to be looked at again."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, Dict, List, Mapping, NamedTuple, Optional, Tuple

import numpy as np
from telex_msgs.msg import CameraRadiation, Malfunctions

from telex_control.common.params import ConfigError, read_config
from telex_control.urdf.elements import UrdfError
from telex_sim.cameras.cameras_config import CamerasConfig
from telex_sim.malfunctions import battery
from telex_sim.scene.model import Scene

from ..exercises.exercise_file import ExerciseError
from ..exercises.seeds import scene_of
from ..judging.moments import MomentNote, moment_notes
from ..recording.reader import Recording, read_recording
from ..recording.trial_file import (
    CAMERAS,
    MESHES,
    ROBOT,
    SCENE,
    SHEET,
    attached_text,
    judged,
    trial_of,
    urdf_of,
)
from ..recording.writer import RecordingError
from .cameras import camera_names, lamp_levels, replay_config
from .scenery import ALL_LIGHT, RobotBeside, Scenery
from .series import envelope
from .timeline import Moment, Timeline

BINS = 800
"""Places across a strip, at most."""
_MOST_NAMED = 5
_MARKS = {
    "begin": "begin",
    "step": "step",
    "fault": "fault",
    "penalty": "fault",
    "contact": "contact",
    "drop": "fault",
    "tipped": "fault",
    "repetition": "repetition",
    "practised": "repetition",
    "bookmark": "other",
    "back": "other",
    "e_stop": "stop",
    "stuck": "stop",
    "malfunction": "malfunction",
    "mended": "malfunction",
    "reaction": "malfunction",
    "invalid": "invalid",
    "note": "note",
    "mark": "note",
    "answer": "other",
    "camera": "other",
    "mode": "other",
    "end": "end",
}
"""Kinds of marks on the timeline, by the judge's events."""
_LONGEST = 1e9
"""Time (s) beyond which a number is none."""


class SilentCameraError(Exception):
    """A camera sent no pictures; the message says which, and why."""


class MetricCondition(NamedTuple):
    """What cameras and lamps have come to."""

    radiation: CameraRadiation
    malfunctions: Malfunctions


class Replay:
    """A trial's recording: what was where at any time, and what happened when.

    Parameters
    ----------
    cameras : mapping
        Parameters of the cameras' node that stand in where the recording has none.

    Attributes
    ----------
    exercise : Exercise
        In the trial's setting.
    urdf : str
        Of the robot.
    cameras : mapping
        Parameters of the cameras' node when the trial began.
    notes : list of MomentNote
        Written by whoever watched it.
    closed : bool
        Whether the recording is complete; notes are added to such a one alone.
    problems : list of str
        What is not as it was, and is drawn all the same.

    Raises
    ------
    RecordingError
        Nothing of it can be drawn; the message says why.
    """

    def __init__(self, recording: Recording, cameras: Mapping[str, Any]) -> None:
        self.path = recording.path
        self.trial, self.exercise = trial_of(recording)
        self.problems: List[str] = []
        self.notes = moment_notes(recording.entries)
        self.closed = recording.whole
        if not self.closed:
            self.problems.append("The recording was cut off; what is left of it is shown.")
        self.cameras = self._cameras(recording, cameras)
        self._meshes = _struct(recording, MESHES)
        robots = [robot.name for robot in self.exercise.robots]
        self.timeline = Timeline(recording, robots=robots)
        if self.timeline.bad:
            self.problems.append(f"{self.timeline.bad} entries make no sense and are left out.")
        try:
            self.urdf = attached_text(recording, ROBOT)
            beside = [
                RobotBeside(
                    attached_text(recording, urdf_of(name)), Timeline(recording, name, robots)
                )
                for name in robots
            ]
            self.scenery = Scenery(self.urdf, self._scene(recording), beside)
        except UrdfError as error:
            raise RecordingError(f"{recording.path}: {ROBOT}: {error}") from error
        came = {name for part in self.timeline.parts for name in self.scenery.unknown(part)}
        if came:
            self.problems.append(
                f"{_listed(sorted(came))}: not in the scene as it was loaded, and not shown."
            )
        self._sheet = self._sheet_of(recording)
        self._begin = int(self.timeline.stamps[0]) / 1e9

    @classmethod
    def open(cls, path: Path, cameras: Mapping[str, Any]) -> Replay:
        """Open a file; see the class.

        Raises
        ------
        RecordingError
        """
        recording = read_recording(path)
        try:
            return cls(recording, cameras)
        except RecordingError:
            raise
        except Exception as error:  # content that is malformed raises whatever it leads to
            raise RecordingError(
                f"{path}: it cannot be shown: {type(error).__name__}: {error}"
            ) from error

    def _cameras(self, recording: Recording, others: Mapping[str, Any]) -> Mapping[str, Any]:
        found = _struct(recording, CAMERAS)
        if not found.get("cameras"):
            self.problems.append(
                "The recording says nothing about the cameras; those of this machine are shown."
            )
            return others
        try:
            read_config(CamerasConfig, replay_config(found, "robot", 0), CAMERAS)
        except ConfigError as error:
            self.problems.append(
                f"The recording's cameras cannot be shown, this machine's are: {error}"
            )
            return others
        return found

    def _scene(self, recording: Recording) -> Optional[Scene]:
        try:
            return scene_of(self.exercise, attached_text(recording, SCENE))
        except (ExerciseError, RecordingError) as error:
            self.problems.append(f"The scene cannot be read, the robot is shown alone: {error}")
            return None

    def _sheet_of(self, recording: Recording) -> Dict[str, Any]:
        """The sheet that it ends with, or the one that its entries make."""
        sheet = _struct(recording, SHEET)
        return sheet if _can_be_shown(sheet) else judged(recording).sheet()

    def compare(self, software: str, meshes: Mapping[str, str]) -> List[str]:
        """What of this machine is not what the trial was recorded with.

        Parameters
        ----------
        software : str
            As in `Trial`.
        meshes : mapping of str to str
            SHA-256 of the meshes that are here, by their addresses.
        """
        found = []
        if self.trial.software != software:
            found.append(
                f"Recorded with software {self.trial.software or 'unknown'}, drawn with {software}."
            )
        changed = sorted(
            name for name, digest in self._meshes.items() if meshes.get(name) != digest
        )
        if changed:
            found.append(f"Meshes have changed since: {_listed(changed)}.")
        return found

    @property
    def camera_names(self) -> List[str]:
        """Cameras that the robot had."""
        return camera_names(self.cameras, self.scenery.links)

    def switches(self, moment: Moment) -> Dict[str, float]:
        """Lamps' levels and zooms at a moment, by the topics that set them."""
        held = lamp_levels(self.cameras)
        for topic, steps in self.timeline.switches.items():
            value = steps.at(moment.time)
            if value is not None:
                held[topic] = value
            elif topic.endswith("/zoom"):
                held[topic] = 1.0
        return held

    def light(self, moment: Moment) -> Tuple[float, float]:
        """Shares of the scene's daylight and of its lamps' light at a moment."""
        return self.timeline.light.at(moment.time) or ALL_LIGHT

    def sent_by(self, camera: str, moment: Moment) -> Moment:
        """Moment of the picture that a camera sent at a moment: an earlier one while it is frozen.

        Raises
        ------
        SilentCameraError
            It sent none.
        """
        equipment = self.timeline.equipment
        why = equipment.silent(camera, moment.time)
        if why:
            raise SilentCameraError(f"{camera} sends nothing: {why}")
        since = equipment.frozen_since(camera, moment.time)
        return moment if since is None else self.timeline.moment(since)

    def condition(self, moment: Moment) -> MetricCondition:
        """What cameras and lamps have come to at a moment, for what draws it."""
        equipment, cameras = self.timeline.equipment, self.camera_names
        malfunctions = equipment.malfunctions(moment.time)
        radiation = equipment.radiation(cameras, moment.time)
        if battery.CAMERAS not in malfunctions.unpowered:
            return MetricCondition(radiation, malfunctions)
        # The views from outside, and the clear ones, need none of the robot's power.
        nothing = [0.0] * len(cameras)
        return MetricCondition(
            CameraRadiation(
                names=cameras, dose_rate=nothing, dose=nothing, failed=[True] * len(cameras)
            ),
            Malfunctions(
                active=malfunctions.active,
                unpowered=[each for each in malfunctions.unpowered if each != battery.CAMERAS],
            ),
        )

    def seen_at(self, time: float) -> float:
        """Time (s) of what the operator saw at a time: earlier by the age of his picture."""
        age = self.timeline.age.at(time)
        return max(0.0, time - (age or 0.0))

    # --- for pages -------------------------------------------------------------------------------

    def about(self) -> Dict[str, Any]:
        """Everything but pictures: plain data for a page."""
        timeline, trial, sheet = self.timeline, self.trial, self._sheet
        return {
            "trial": trial.trial,
            "operator": trial.operator,
            "mode": trial.mode,
            "setting": trial.setting,
            "software": trial.software,
            "title": self.exercise.title or self.exercise.name,
            "verdict": sheet.get("verdict", ""),
            "valid": bool(sheet.get("valid", True)),
            "began": round(self._begin, 4),
            "duration": round(timeline.duration, 4),
            "samples": len(timeline.times),
            "period": round(float(np.median(np.diff(timeline.times))), 4)
            if len(timeline.times) > 1
            else 0.02,
            "cameras": self.camera_names,
            "marks": self.marks(),
            "stretches": self.stretches(),
            "keys": {name: spans.rounded() for name, spans in sorted(timeline.keys.items())},
            "strips": self.strips(),
            "problems": list(self.problems),
        }

    def marks(self) -> List[Dict[str, Any]]:
        """What happened: time (s), kind, event, name and details, in the order of time."""
        made = []
        for event in self._sheet["events"]:
            kind = _MARKS.get(event.get("event", ""))
            time = self._replayed(event.get("time"))
            if kind is None or time is None:
                continue
            detail = event.get("detail")
            # A note may be of an earlier moment; other events say in words where they are.
            at: Any = detail.get("at") if isinstance(detail, dict) else None
            made.append(
                {
                    "time": float(at) if _is_time(at) else time,
                    "kind": kind,
                    "event": event["event"],
                    "name": event.get("name", ""),
                    "detail": detail,
                }
            )
        made += [
            {"time": round(time, 3), "kind": "stop", "event": "released", "name": why, "detail": {}}
            for time, why in self.timeline.released
        ]
        made += [self._note(note) for note in self.notes]
        return sorted(made, key=lambda mark: mark["time"])

    def _note(self, note: MomentNote) -> Dict[str, Any]:
        author = note.by or ("instructor" if note.instructor else "no name")
        return {
            "time": round(min(note.at, self.timeline.duration), 3),
            "kind": "note",
            "event": "moment",
            "name": author,
            "detail": {"text": note.text, "instructor": note.instructor},
        }

    def stretches(self) -> List[Dict[str, Any]]:
        """Spans of time: slow, stopped by the emergency stop, paused."""
        slow = self._sheet.get("real_time_factor", {}).get("slow", [])
        spans = [(self._replayed(first), self._replayed(last)) for first, last in slow]
        made = [
            {"kind": "slow", "begin": first, "end": last}
            for first, last in spans
            if first is not None and last is not None
        ]
        for kind, found in (("stopped", self.timeline.stopped), ("paused", self.timeline.paused)):
            made += [{"kind": kind, "begin": a, "end": b} for a, b in found.rounded()]
        return made

    def strips(self) -> List[Dict[str, Any]]:
        """Figures over time, each as least and largest of up to `BINS` spans."""
        timeline = self.timeline
        age = timeline.age
        made = []
        for name, unit, times, values in (
            ("speed", "m/s", timeline.times, timeline.speed),
            ("force", "N", timeline.times, timeline.force),
            ("margin", "", timeline.times, timeline.margin),
            ("picture age", "s", np.array(age.times), np.array(age.values)),
        ):
            inside = (times >= 0.0) & (times <= timeline.duration) if len(times) else slice(None)
            bins = min(BINS, max(1, len(times) // 2))
            found = envelope(times[inside], values[inside], timeline.duration, bins)
            made.append({"name": name, "unit": unit, **found})
        return made

    def _replayed(self, time: Any) -> Optional[float]:
        """Time of the replay (s) of a sim time that the sheet has."""
        if not _is_time(time):
            return None
        stamps = self.timeline.stamps
        if (np.diff(stamps) >= 0).all():
            return round(min(max(time - self._begin, 0.0), self.timeline.duration), 3)
        # The simulator began anew: the first sample of that time.
        nearest = int(np.argmin(np.abs(stamps / 1e9 - time)))
        return round(float(self.timeline.times[nearest]), 3)


def _is_time(value: Any) -> bool:
    """Whether plain data is a time (s); of NaN and what JSON calls Infinity, nothing is."""
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    return number and abs(value) < _LONGEST


def _can_be_shown(sheet: Mapping[str, Any]) -> bool:
    """Whether a sheet has events and slow spans as the judge writes them."""
    events = sheet.get("events")
    real_time = sheet.get("real_time_factor", {})
    slow = real_time.get("slow", []) if isinstance(real_time, dict) else None
    return (
        isinstance(events, list)
        and all(isinstance(each, dict) and isinstance(each.get("event"), str) for each in events)
        and isinstance(slow, list)
        and all(isinstance(each, list) and len(each) == 2 for each in slow)
    )


def _struct(recording: Recording, name: str) -> Dict[str, Any]:
    """An attachment of JSON; empty where it is missing."""
    if name not in recording.attachments:
        return {}
    try:
        made = json.loads(attached_text(recording, name))
    except ValueError as error:
        raise RecordingError(f"{recording.path}: '{name}' is no JSON: {error}") from error
    if not isinstance(made, dict):
        raise RecordingError(f"{recording.path}: '{name}' is no struct of JSON")
    return made


def _listed(names: List[str]) -> str:
    more = f" and {len(names) - _MOST_NAMED} more" if len(names) > _MOST_NAMED else ""
    return ", ".join(names[:_MOST_NAMED]) + more
