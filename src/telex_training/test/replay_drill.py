"""A recording of a small trial: a block drives two metres and touches a wall."""

from __future__ import annotations

import json

from telex_msgs.msg import ActiveMalfunction, ComponentDoses, Malfunctions
from training_truth import SCENE, Trial, exercise, serialized

from telex_training.recording.trial_file import SHEET, attachments, sheet_attachment
from telex_training.recording.trial_file import Trial as About
from telex_training.recording.writer import Attachment, RecordingWriter

SIZE = {"width": 320, "height": 240, "horizontal_fov": 1.2}
CAMERAS = {
    "cameras": {
        "front": {"frame": "front_camera_optical_frame", "noise": 2.0, **SIZE},
        "turret": {"frame": "turret_camera_optical_frame", "zoom_max": 6.0, **SIZE},
        "roof": {"frame": "no_link", **SIZE},
    },
    "lamps": {"front_left": {"frame": "front_left_lamp_link", "level": 0.5}},
}
TEXT = """
name: drill
title: A drill
description: For tests.
begin: {not: {inside: {what: robot, zone: start}}}
steps: [{name: drive, until: {inside: {what: robot, zone: there}}}]
zones:
  start: {center: [0.0, 0.0, 0.2], size: [0.4, 1.0, 1.0]}
  there: {center: [1.5, 0.0, 0.2], size: [1.0, 1.0, 1.0]}
repetitions: {most: 1}
"""
URDF = """
<robot name="block">
  <link name="base_link"/><link name="turret"/><link name="front_camera_optical_frame"/>
  <joint name="turret_joint" type="revolute">
    <parent link="base_link"/><child link="turret"/><origin xyz="0 0 0.5" rpy="0 0 0"/>
    <axis xyz="0 0 1"/><limit lower="-3" upper="3" velocity="1" effort="1"/>
  </joint>
  <joint name="camera_joint" type="fixed">
    <parent link="turret"/><child link="front_camera_optical_frame"/><origin xyz="1 0 0"/>
  </joint>
</robot>
"""
BOX = '<link name="turret"><visual><geometry><box size="1 1 1"/></geometry></visual></link>'


def record(path, made, changes=(), ending=None):
    """Write a drill's entries with its attachments."""
    about = About("t1", "/exercises/drill.yaml", "standard", "practice", "ann", "test", 7)
    scene = SCENE.replace("\n", "\n  ")
    text = f"{TEXT}\nscene:{scene}"
    digests = {"package://a/b.obj": "1234"}
    with_all = attachments(about, text, SCENE, URDF, CAMERAS, digests)
    with_all.update(changes)
    writer = RecordingWriter(path, with_all)
    for entry in made:
        writer.put(entry, 0)
    writer.close(ending or {})
    return path


def drill():
    """A trial in which the robot drives two metres, and touches the wall at the end."""
    trial = Trial(exercise(TEXT), scene=SCENE).begin()
    trial.drive(2.0)
    trial.contacts = [("base", "wall", 250.0), ("tracks", "floor", 900.0)]
    trial.sample(5)
    return trial


def failing(trial):
    """Have the drill's camera fail for a second in each of several ways, two seconds apart.

    Dark, frozen, dead of its dose, and without power, in which the lamp is dead as well.
    """
    for broken, failed in (
        ({"active": [active("front", "camera", "dark", 1.0)]}, False),
        ({"active": [active("front", "camera", "frozen")]}, False),
        ({}, True),
        (
            {
                "active": [active("front_left", "lamp", "dead")],
                "unpowered": ["drives", "lamps", "cameras"],
            },
            False,
        ),
    ):
        for now, dead in ((broken, failed), ({}, False)):
            message = Malfunctions(**now)
            trial.feed("sim/malfunctions", "telex_msgs/Malfunctions", serialized(message))
            rate, dose = (2.0, 90.0) if dead else (0.0, 0.0)
            told = ComponentDoses(
                names=["robot", "front"],
                dose_rate=[1.0, rate],
                dose=[1.0, dose],
                failed=[False, dead],
            )
            trial.feed("sim/doses", "telex_msgs/ComponentDoses", serialized(told))
            trial.seconds(1.0)
    return trial


def active(what, group, kind, value=0.0):
    """Something that fails."""
    return ActiveMalfunction(what=what, group=group, kind=kind, value=value)


def faster():
    """The drill done at twice the speed, after a longer wait."""
    trial = Trial(exercise(TEXT), scene=SCENE).begin()
    trial.seconds(1.0)
    trial.drive(2.0, 1.0)
    return trial


def record_faster(path):
    """Write the faster run, of a robot that can be seen, with its sheet."""
    trial = faster()
    urdf = URDF.replace('<link name="turret"/>', BOX)
    changes = {"robot.urdf": Attachment("text/xml", urdf.encode())}
    sheet = json.loads(trial.judge.text())
    sheet["trial"] = path.stem
    return record(path, trial.entries, changes, {SHEET: sheet_attachment(json.dumps(sheet))})
