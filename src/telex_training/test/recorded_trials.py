"""Builders of recordings of trials: with a made-up sheet, or with one that the judge made."""

from __future__ import annotations

import calendar
import json
import time
from pathlib import Path
from typing import Any, Dict, List, Optional, Sequence, Tuple

from telex_msgs.msg import BridgeClient, BridgeClients, InstructorAction
from training_truth import SCENE, exercise, serialized
from training_truth import Trial as JudgedTrial

from telex_training.judging.entries import Entry
from telex_training.judging.sheet import sheet_text
from telex_training.recording.signature import sealing
from telex_training.recording.station_keys import station_key
from telex_training.recording.trial_file import (
    SHEET,
    Trial,
    attachments,
    input_entry,
    safe_name,
    sheet_attachment,
)
from telex_training.recording.writer import RecordingWriter

STAMP = "2026-03-01_101500"
DRILL = """
name: drill
title: Drill
zones:
  start: {center: [0, 0, 0], size: [1, 2, 1]}
  goal: {center: [3, 0, 0], size: [1, 2, 1]}
begin: {not: {inside: {what: robot, zone: start}}}
steps: [{name: there, until: {inside: {what: robot, zone: goal}}}]
repetitions: {most: 2, least: 1, trial_time: 600, time: 60}
metrics:
  time: {pass: 30, expert: [2, 1]}
"""


def wall_of(stamp: str) -> float:
    """Seconds since the epoch of a trial's date, taken as universal time."""
    return float(calendar.timegm(time.strptime(stamp, "%Y-%m-%d_%H%M%S")))


def sheet(
    trial: str,
    operator: str = "ann",
    times: Sequence[Tuple[float, bool]] = ((20.0, True), (25.0, False)),
    **changes: Any,
) -> Dict[str, Any]:
    """Make up a sheet; `times` are seconds of completed repetitions, and whether they passed.

    A time of 0 is a repetition with a fault. `changes` replace what is on the top level, or of the
    exercise (`exercise`, `setting`, `title`).
    """
    about = {"name": "drill", "title": "Drill", "setting": "standard", "seed": 7, "sha256": ""}
    for key, name in (("exercise", "name"), ("setting", "setting"), ("title", "title")):
        about[name] = changes.pop(key, about[name])
    repetitions = [
        {
            "began": 10.0 * i,
            "seconds": seconds or 5.0,
            "penalty": 0.0,
            "completed": seconds > 0.0,
            "passed": passed,
            "fault": None if seconds else "dropped",
            "metrics": {"time": seconds or 5.0, "contacts": float(not passed), "margin": 0.5},
        }
        for i, (seconds, passed) in enumerate(times)
    ]

    def metric(name: str, unit: str, bound: float, more: bool = False) -> Dict[str, Any]:
        return {
            "name": name,
            "kind": name,
            "unit": unit,
            "text": f"the {name}",
            "more_is_better": more,
            "value": 1.0,
            "pass": bound,
            "expert": [10.0, 1.0] if name == "time" else None,
        }

    return {
        "format": 1,
        "exercise": about,
        "trial": trial,
        "operator": operator,
        "mode": "practice",
        "software": "test",
        "log": {"sha256": f"log of {trial}", "samples": 1, "gaps": 0},
        "valid": True,
        "ended": "complete",
        "trial_seconds": 60.0,
        "repetitions": repetitions,
        "summary": {"completed": sum(seconds > 0.0 for seconds, _ in times)},
        "metrics": [
            metric("time", "s", 30.0),
            metric("contacts", "", 0.0),
            metric("margin", "", 0.4, True),
        ],
        "expert": {"provisional": True},
        "verdict": "passed",
        "marks": [],
        "notes": [],
        "events": [],
        **changes,
    }


def record(
    folder: Path,
    operator: str = "ann",
    stamp: str = STAMP,
    made: Optional[Dict[str, Any]] = None,
    entries: Sequence[Entry] = (),
    closed: bool = True,
    text: str = DRILL,
    signed: bool = False,
    **changes: Any,
) -> Path:
    """Write the recording of a trial whose sheet is made up, unless one is given.

    With `signed` it has a signature of this station, whose key is in ROS_HOME.
    """
    folder.mkdir(exist_ok=True)
    name = f"{stamp}_{safe_name(operator)}_{changes.get('exercise', 'drill')}"
    made = made or sheet(name, operator, **changes)
    path = folder / f"{name}.mcap"
    about = Trial(name, f"/home/{operator}/drill.yaml", "", made["mode"], operator, "test", 7)
    writer = RecordingWriter(path, attachments(about, text, "", "", {}, {}))
    began = round(wall_of(stamp) * 1e9)
    for entry in entries or [input_entry(1, 0, {"input": "open", "operator": operator})]:
        writer.put(entry, began + entry.number)
    ending = {SHEET: sheet_attachment(sheet_text(made))} if closed else {}
    writer.close(ending, sealing(station_key()) if signed else None)
    return path


def judged_trial(
    folder: Path,
    operator: str = "ann",
    others: Sequence[str] = (),
    actions: Sequence[InstructorAction] = (),
) -> Path:
    """Record a trial that the judge has judged: driven there, noted, marked, with others around.

    It is an exam, which instructors' actions make invalid.
    """
    name = f"{STAMP}_{safe_name(operator)}_drill"
    text = DRILL + "scene:" + SCENE.replace("\n", "\n  ") + "\n"
    trial = JudgedTrial(exercise(text))
    trial.names()
    trial.sample()
    clients(trial, [operator, *others])
    trial.input("open", trial=name, operator=operator, mode="exam", setting="standard", seed=7)
    trial.input("start")
    trial.input("ready")
    trial.sample()
    for action in actions:
        trial.feed("bridge/actions", action._type, serialized(action))
    trial.drive(3.0, 1.5)
    trial.input("pause", on=True, by=operator)
    trial.robot = ((0.0, 0.0, 0.112), trial.robot[1])
    trial.again()
    trial.drive(3.0, 1.0)
    trial.input("note", text=f"{operator} was faster than {operator}s brother", by=operator)
    trial.input("moment", at=2.0, text=f"here {operator} turned", by=operator, instructor=False)
    trial.input("mark", verdict="passed", reason=f"well done, {operator}!", by="instructor")
    made = json.loads(trial.judge.text())
    assert made["valid"] == (not actions)
    assert made["verdict"] == "passed" or actions
    return record(folder, operator, made=made, entries=trial.entries, text=text)


def clients(trial: JudgedTrial, names: List[str]) -> None:
    """Tell the judge who is at the bridge."""
    message = BridgeClients(holder="1")
    message.clients = [
        BridgeClient(id=str(i), name=name, role="operator", address="192.0.2.7")
        for i, name in enumerate(names)
    ]
    trial.feed("bridge/clients", "telex_msgs/BridgeClients", serialized(message))
