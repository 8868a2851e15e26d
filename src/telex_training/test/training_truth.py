"""Builders of synthetic trials: truth samples, commands and inputs as the inbox numbers them."""

from __future__ import annotations

import io
import json
from pathlib import Path
from typing import Any, Dict, List, Optional, Sequence, Tuple

import genpy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from std_msgs.msg import String
from telex_msgs.msg import (
    ComponentDoses,
    InstructorAction,
    LinkState,
    SceneLight,
    SimStatus,
    TruthContact,
    TruthNames,
    TruthSample,
)

from telex_training.exercises.exercise_file import parse_exercise
from telex_training.judging.entries import Entry
from telex_training.judging.judge import Judge
from telex_training.judging.trial_record import JudgeEvent

PERIOD = 0.02
STEPS = 10
JOINTS = (
    "turret_joint",
    "shoulder_joint",
    "telescope_joint",
    "elbow_joint",
    "forearm_roll_joint",
    "wrist_pitch_joint",
    "gripper_roll_joint",
)
GROUPS = ("base", "tracks", "arm", "gripper")
OBJECTS = ("cube", "wall", "door", "plug")
BODIES = ("cube/cube", "door/leaf", "plug/plug")
MECHANISMS = ("door/hinge",)
LATCHES = ("plug/latch",)
LEVEL = (0.0, 0.0, 0.0, 1.0)
FLOOR = -1

SCENE = """
objects:
  - {type: cube, name: cube, position: [2.0, 0.0, 0.0]}
  - {type: wall, name: wall, position: [4.0, 0.0, 0.0], yaw: 1.5708, length: 2.0}
  - {type: door, name: door, position: [0.0, 4.0, 0.0]}
  - {type: connector, name: plug, position: [0.0, -4.0, 0.0]}
"""


def serialized(message: Any) -> bytes:
    buffer = io.BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


def exercise(text: str, setting: str = "") -> Any:
    """An exercise of this text, whose scene is `SCENE` unless it gives one."""
    if "scene:" not in text:
        text += "\nscene:" + SCENE.replace("\n", "\n  ")
    return parse_exercise(text, Path("/exercises/drill.yaml")).setting(setting)


class Trial:
    """Feeds a judge, and keeps the entries.

    `robot` (position, quaternion), `bodies`, `joints`, `held`, ... are what the next sample says.
    """

    def __init__(self, of: Any, urdf: str = "", scene: str = "", start: float = 10.0) -> None:
        self.judge = Judge(of, scene, urdf)
        self.entries: List[Entry] = []
        self.events: List[JudgeEvent] = []
        self.time, self.wall = start, 1.0e9
        self.sequence = self.steps = 0
        self.resets = 0
        self.revision = 1
        self.robot: Tuple[Sequence[float], Sequence[float]] = ((0.0, 0.0, 0.112), LEVEL)
        self.speed = 0.0
        self.bodies: Dict[str, Tuple[Sequence[float], Sequence[float]]] = {
            "cube/cube": ((2.0, 0.0, 0.0), LEVEL),
            "door/leaf": ((0.0, 4.0, 0.0), LEVEL),
            "plug/plug": ((0.0, -4.0, 0.0), LEVEL),
        }
        self.joints = [0.0] * len(JOINTS)
        self.hinge = 0.0
        self.latched = True
        self.held: Optional[str] = None
        self.grip = 0.0
        self.margin = 1.0
        self.contacts: List[Tuple[str, str, float]] = []
        self.impulse = 0.0
        self.pace = 1.0

    def feed(self, channel: str, kind: str, data: bytes) -> List[JudgeEvent]:
        entry = Entry(len(self.entries) + 1, self.time, channel, kind, data)
        self.entries.append(entry)
        found = self.judge.feed(entry)
        self.events += found
        return found

    def names(self) -> None:
        message = TruthNames()
        message.revision = self.revision
        message.robot = "telex"
        message.joints, message.groups = list(JOINTS), list(GROUPS)
        message.objects, message.bodies = list(OBJECTS), list(BODIES)
        message.mechanisms, message.latches = list(MECHANISMS), list(LATCHES)
        self.feed("sim/truth_names", "telex_msgs/TruthNames", serialized(message))

    def message(self) -> TruthSample:
        """The next sample, 20 ms after the one before."""
        self.time = round(self.time + PERIOD, 6)
        self.wall += PERIOD / self.pace
        self.sequence += 1
        self.steps += STEPS
        message = TruthSample()
        message.header.stamp = genpy.Time.from_sec(self.time)
        message.header.frame_id = "world"
        message.sequence, message.steps = self.sequence, self.steps
        message.revision, message.resets = self.revision, self.resets
        message.wall_time = self.wall
        message.base = [*self.robot[0], *self.robot[1]]
        message.twist = [self.speed, 0.0, 0.0, 0.0, 0.0, 0.0]
        message.joints = list(self.joints)
        message.mechanisms = [self.hinge]
        message.latched = [self.latched]
        message.whole = True
        message.moved = list(range(len(BODIES)))
        message.poses = [x for body in BODIES for part in self.bodies[body] for x in part]
        message.margin = self.margin
        message.held = -1 if self.held is None else OBJECTS.index(self.held)
        message.grip = self.grip
        for group, thing, force in self.contacts:
            index = FLOOR if thing == "floor" else OBJECTS.index(thing)
            message.contacts.append(
                TruthContact(
                    GROUPS.index(group), index, force, self.impulse, STEPS, [1.0, 0.0, 0.5]
                )
            )
        return message

    def sample(self, count: int = 1) -> List[JudgeEvent]:
        """Feed samples that all say the same; returns the events of all."""
        found: List[JudgeEvent] = []
        for _ in range(count):
            found += self.feed("sim/truth", "telex_msgs/TruthSample", serialized(self.message()))
        return found

    def seconds(self, seconds: float) -> List[JudgeEvent]:
        return self.sample(round(seconds / PERIOD))

    def at(self, x: float, y: float = 0.0, z: float = 0.112) -> List[JudgeEvent]:
        """Put the robot there, and feed one sample."""
        self.robot = ((x, y, z), self.robot[1])
        return self.sample()

    def drive(self, x: float, speed: float = 0.5) -> List[JudgeEvent]:
        """Move the robot along x at a speed (m/s), commanded all the way."""
        found: List[JudgeEvent] = []
        (now, y, z), turn = self.robot
        count = max(1, round(abs(x - now) / (speed * PERIOD)))
        self.speed = speed if x > now else -speed
        for i in range(count):
            found += self.command(self.speed)
            self.robot = ((now + (x - now) * (i + 1) / count, y, z), turn)
            found += self.sample()
        self.speed = 0.0
        return found

    def command(self, speed: float) -> List[JudgeEvent]:
        message = Twist()
        message.linear.x = speed
        return self.feed("track_teleop/cmd_vel", "geometry_msgs/Twist", serialized(message))

    def status(self, **fields: Any) -> List[JudgeEvent]:
        message = SimStatus()
        for name, value in fields.items():
            setattr(message, name, value)
        return self.feed("sim/status", "telex_msgs/SimStatus", serialized(message))

    def link(self, profile: str, since: float, **fields: Any) -> List[JudgeEvent]:
        """Tell what the line is; fields of its message."""
        told = {"perfect": profile == "perfect", **fields}
        message = LinkState(profile=profile, since=genpy.Time.from_sec(since), **told)
        return self.feed("link/state", "telex_msgs/LinkState", serialized(message))

    def light(self, daylight: float, lamps: float) -> List[JudgeEvent]:
        """Tell what light an instructor has set."""
        message = SceneLight(daylight=daylight, lamps=lamps)
        return self.feed("sim/light", "telex_msgs/SceneLight", serialized(message))

    def action(self, by: str, service: str, request: str) -> List[JudgeEvent]:
        """Tell what an instructor has done."""
        message = InstructorAction(by=by, service=service, request=request)
        return self.feed("bridge/actions", "telex_msgs/InstructorAction", serialized(message))

    def doses(self, **received: float) -> List[JudgeEvent]:
        """Tell what components have received (Gy)."""
        message = ComponentDoses(names=list(received), dose=list(received.values()))
        return self.feed("sim/doses", "telex_msgs/ComponentDoses", serialized(message))

    def odometry(self, x: float, y: float, turn: Sequence[float] = LEVEL) -> List[JudgeEvent]:
        """Tell where the robot is by its own odometry."""
        message = Odometry()
        place = message.pose.pose
        place.position.x, place.position.y = x, y
        q = place.orientation
        q.x, q.y, q.z, q.w = turn
        return self.feed("track_controller/odom", "nav_msgs/Odometry", serialized(message))

    def input(self, kind: str, **fields: Any) -> List[JudgeEvent]:
        text = json.dumps({"input": kind, **fields})
        return self.feed("training/inputs", "std_msgs/String", serialized(String(data=text)))

    def begin(self, mode: str = "practice") -> Trial:
        """From nothing to a repetition that waits for its begin."""
        self.names()
        self.sample()
        self.input("open", trial="t1", operator="ann", mode=mode, seed=7, software="test")
        self.input("start")
        self.input("ready")
        self.sample()
        return self

    def again(self) -> None:
        self.input("again")
        self.input("ready")
        self.sample()

    def kinds(self) -> List[str]:
        return [event.event for event in self.events]
