"""A port to the robot through the console's page: commands are keys that are pressed and counted.

What it sees is what a person before the page knows: the joints, the odometry, the grip as the page
shows it, what the nodes say. Where things stood when he began he has been told.
"""

from __future__ import annotations

import json
import math
import urllib.request
from collections import Counter
from typing import Any, Dict, List, Mapping, Optional, Set, Tuple

import numpy as np
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Range
from telex_msgs.msg import CartesianTeleopStatus, JointTeleopStatus, TrackTeleopStatus

from telex_control.common.geometry.matrices import (
    homogeneous,
    inverse,
    pose_matrix,
    quaternion_tuple,
    rotation_from_rpy,
    rotation_vector,
)
from telex_control.kinematics import Chain
from telex_experiments.rigs.chromium import Chromium
from telex_training.operators.port import (
    CameraView,
    Command,
    Drive,
    FlipperPreset,
    Grip,
    Jog,
    NamedPose,
    NotManagedError,
    Observation,
    Placement,
    TeleopPort,
    ToolPose,
)
from telex_training.operators.robot_size import AXLE_HEIGHT
from telex_training.ros.live_robot import LiveRobot

Object = Mapping[str, Any]
"""Of a scene's file."""

LOOK = """
JSON.stringify({
  held: [...document.querySelectorAll("[data-action].held")].map(({ dataset }) => dataset.action),
  shown: [...document.querySelectorAll("[data-action]")].map(({ dataset }) => dataset.action),
  grip: document.getElementById("grip").textContent,
  stuck: document.getElementById("speed-hud").dataset.stuck === "true",
  mode: document.body.dataset.keysMode ?? "",
  frame: document.querySelector("[data-frame][aria-checked=true]")?.textContent ?? "",
})
"""

_LATE = 0.12
"""From the press of a key, or its release, to what comes of it (s)."""
_SEEN = 0.25
"""How long one looks at what has come of a release before the key is tapped again (s)."""
_LOST = 0.4
"""How long a key is down before one sees that the page has let go of it (s)."""
_CORRECTED, _OFF = 0.04, 0.15
"""Turning (rad/s), by how far one is off the way: ends a correction, and begins one."""
_HELD = 0.5
"""Of what a key gives: who wants less taps it."""
_TAP_WAY, _TAP_TURN = 0.02, 0.03
"""Way (m) and angle (rad) of a tap, at least."""
_NEAR, _TURNED = 0.0025, 0.010
"""Of the tool (m, rad): no key is pressed for less."""
_FINGERS = 3
"""Keys of the tool that are down together, at most."""
_AXES = ("x", "y", "z", "roll", "pitch", "yaw")


class _Taps:
    """Holds one of two keys, or taps it where less is wanted than it gives.

    Parameters
    ----------
    least : float
        What a tap gives, at least.
    """

    def __init__(self, least: float) -> None:
        self._least = least
        self._owed = 0.0
        self._sign = 0

    def sign(self, wanted: float, given: float, period: float) -> int:
        """Which of both keys is down now: 1, -1, or 0 for none."""
        if wanted == 0.0 or given <= 0.0:
            self._owed, self._sign = 0.0, 0
        elif abs(wanted) >= _HELD * given:
            self._owed, self._sign = 0.0, int(math.copysign(1, wanted))
        else:
            self._owed += (wanted - self._sign * given) * period
            if self._sign == 0 and abs(self._owed) >= self._least:
                self._sign = int(math.copysign(1, self._owed))
            elif self._sign * self._owed <= 0.0:
                self._sign = 0
        return self._sign


class ByKeys(TeleopPort):
    """The robot through a page of the console; close it when done.

    Parameters
    ----------
    browser : Chromium
        With the console, live.
    page : str
        Its address.
    start : tuple of 3 floats
        Where the robot began: x, y (m), heading (rad).
    things : mapping of str to mapping
        Entries of the scene's file, by their names.

    Attributes
    ----------
    pressed : collections.Counter
        Names of the actions whose keys were pressed, and how often.
    again : int
        Keys that were pressed again, because the page had let go of them: on a busy machine it
        stands still now and then.
    range : float
        To what the tool points at, as the robot's range finder has it (m).
    """

    def __init__(
        self,
        browser: Chromium,
        page: str,
        start: Tuple[float, float, float],
        things: Mapping[str, Object],
    ) -> None:
        super().__init__()
        self.pressed: Counter[str] = Counter()
        self.again = 0
        self.range = math.inf
        self._browser = browser
        self._things = things
        self.robot = robot = LiveRobot("/telex")
        self.urdf = robot.urdf
        self._tool = Chain.from_urdf(self.urdf, "base_link", "tool_link")
        with urllib.request.urlopen(f"{page.partition('?')[0]}actions.json", timeout=10) as reply:
            self._actions: List[Dict[str, Any]] = json.load(reply)["actions"]
        self._codes = {each["name"]: each["code"] for each in self._actions if each["code"]}
        x, y, yaw = start
        self._start = homogeneous(rotation_from_rpy((0.0, 0.0, yaw)), (x, y, 0.0))
        self._odometry: Optional[np.ndarray] = None
        self._origin: Optional[np.ndarray] = None
        self._statuses: Dict[str, Any] = {}
        robot.node.subscribe("track_controller/odom", Odometry, self._on_odometry)
        for name, kind in (
            ("track_teleop/status", TrackTeleopStatus),
            ("gripper_teleop/status", JointTeleopStatus),
            ("arm_teleop/cartesian_status", CartesianTeleopStatus),
        ):
            robot.node.subscribe(name, kind, self._hearer(name))
        robot.node.subscribe("range_finder", Range, self._on_range)
        self._wanted: List[Command] = []
        self._down: Dict[str, float] = {}
        self._released: Dict[str, float] = {}
        self._lost: Set[str] = set()
        self._way, self._turn = _Taps(_TAP_WAY), _Taps(_TAP_TURN)
        self._corrects = 0
        self._look: Dict[str, Any] = {}
        self._speed = float(
            browser.evaluate("parseFloat(document.getElementById('speed').textContent)")
        )
        self._speed /= 100.0
        while self._odometry is None or len(self._statuses) < 3:
            robot.advance(0.1)
        self._look_at_page()

    # --- what is seen ----------------------------------------------------------------------------

    def _on_odometry(self, message: Any) -> None:
        at, turned = message.pose.pose.position, message.pose.pose.orientation
        pose = pose_matrix((at.x, at.y, at.z), (turned.x, turned.y, turned.z, turned.w))
        if self._origin is None:
            # It began where he was told that the robot stands.
            yaw = math.atan2(pose[1, 0], pose[0, 0])
            level = homogeneous(
                rotation_from_rpy((0.0, 0.0, yaw)), (at.x, at.y, at.z - AXLE_HEIGHT)
            )
            self._origin = self._start @ inverse(level)
        self._odometry = self._origin @ pose

    def _on_range(self, message: Any) -> None:
        self.range = float(message.range)

    def set_back(self, way: np.ndarray) -> None:
        """Take the robot to be this way (m, in the world) behind where the odometry has it."""
        assert self._origin is not None
        moved = self._origin.copy()
        moved[:3, 3] -= way
        self._origin = moved

    def _hearer(self, name: str) -> Any:
        def hear(message: Any) -> None:
            self._statuses[name] = message

        return hear

    def _look_at_page(self) -> None:
        self._look = json.loads(self._browser.evaluate(LOOK))

    def observe(self) -> Observation:
        """See `Port.observe`; the base is where the odometry has it."""
        seen, pose = self.robot.observe(), self._odometry
        base = None
        if pose is not None:
            x, y, z = (float(each) for each in pose[:3, 3])
            base = Placement((x, y, z), quaternion_tuple(pose))
        _, found, rest = str(self._look.get("grip", "")).partition("force ")
        force = float(rest.split()[0]) if found else 0.0
        return Observation(
            seen.time, base, seen.positions, seen.velocities, Grip("", force), seen.notices
        )

    def object_pose(self, name: str) -> Optional[np.ndarray]:
        """Where a thing stood when he began; see `TeleopPort.object_pose`."""
        entry = self._things.get(name)
        if entry is None:
            return None
        turn = rotation_from_rpy((0.0, 0.0, float(entry.get("yaw", 0.0))))
        return homogeneous(turn, entry["position"])

    @property
    def stuck(self) -> bool:
        """Whether the page says so of the robot."""
        return bool(self._look["stuck"])

    # --- keys ------------------------------------------------------------------------------------

    def _find(self, **does: Any) -> str:
        for action in self._actions:
            if action["code"] and all(
                action["does"].get(key) == each for key, each in does.items()
            ):
                return str(action["name"])
        raise NotManagedError(f"the page has no key that does {does}")

    def _press(self, name: str) -> None:
        self._browser.press(self._codes[name])
        self._down[name] = self.robot.observe().time
        if name in self._lost:
            self._lost.discard(name)
            self.again += 1
        else:
            self.pressed[name] += 1

    def _release(self, name: str) -> None:
        self._browser.release(self._codes[name])
        self._down.pop(name, None)
        self._released[name] = self.robot.observe().time

    def _hold(self, names: Set[str]) -> None:
        for name in set(self._down) - names:
            self._release(name)
        self._look_at_page()
        now = self.robot.observe().time
        for name, since in list(self._down.items()):
            # The page lets go of a key by itself, as after a moment without an answer.
            is_shown = name in self._look["shown"] and name not in self._look["held"]
            if now - since > _LOST and is_shown:
                self._release(name)
                self._released.pop(name)
                self._lost.add(name)
        self._lost &= names
        for name in sorted(names - set(self._down)):
            self._press(name)

    def _tap(self, name: str) -> None:
        self._press(name)
        self.robot.advance(0.08)
        self._release(name)

    def send(self, command: Command) -> None:
        """See `Port.send`: its keys are down while it is sent at each look."""
        self._wanted.append(command)

    def advance(self, seconds: float) -> None:
        """See `Port.advance`."""
        wanted, self._wanted = self._wanted, []
        names: Set[str] = set()
        for command in wanted:
            names |= self._names(command, seconds)
        self._hold(names)
        self.robot.advance(seconds)

    def _names(self, command: Command, period: float) -> Set[str]:
        if isinstance(command, Drive):
            return self._drive(command, period)
        if isinstance(command, FlipperPreset):
            return {self._find(kind="preset", name=command.name)} if command.name else set()
        if isinstance(command, NamedPose):
            return {self._find(kind="pose", name=command.name)} if command.name else set()
        if isinstance(command, Jog):
            node = command.node[: -len("_teleop")]
            return {
                self._find(kind="jog", node=node, joints=[joint], sign=int(math.copysign(1, rate)))
                for joint, rate in command.rates.items()
                if rate
            }
        if isinstance(command, ToolPose):
            return self._lead(command)
        raise TypeError(f"no keys for {command!r}")

    def _drive(self, command: Drive, period: float) -> Set[str]:
        limits = self._statuses["track_teleop/status"]
        way = self._way.sign(command.linear, self._speed * limits.max_linear, period)
        wanted = command.angular
        if command.linear:
            # On the way one corrects what one sees, until it is right again.
            if abs(wanted) < _CORRECTED or wanted * self._corrects < 0.0:
                self._corrects = 0
            if abs(wanted) > _OFF:
                self._corrects = int(math.copysign(1, wanted))
            turn = self._corrects
        else:
            self._corrects = 0
            turn = self._turn.sign(wanted, self._speed * limits.max_angular, period)
        names = set()
        if way:
            names.add(self._find(kind="drive", linear=way, angular=0))
        if turn:
            names.add(self._find(kind="drive", linear=0, angular=turn))
        return names

    def _lead(self, command: ToolPose) -> Set[str]:
        """Keys that lead the tool towards a pose, along and about the axes of the page's frame."""
        seen = self.robot.observe()
        tool = self._tool.forward([seen.positions[name] for name in self._tool.joint_names])
        target = command.target
        if command.frame == "world":
            if self._odometry is None:
                return set()
            target = inverse(self._odometry) @ target
        turn = tool[:3, :3] if self._look["frame"] == "tool" else np.eye(3)
        way = turn.T @ (target[:3, 3] - tool[:3, 3])
        angle = turn.T @ rotation_vector(target[:3, :3] @ tool[:3, :3].T)
        limits = self._statuses["arm_teleop/cartesian_status"]
        rates = [self._speed * limits.max_linear] * 3 + [self._speed * limits.max_angular] * 3
        wanted = []
        for axis, off, rate, near in zip(
            _AXES, (*way, *angle), rates, (_NEAR,) * 3 + (_TURNED,) * 3
        ):
            sign = int(math.copysign(1, off))
            name = self._find(kind="tool", axis=axis, sign=sign)
            if name in self._down:
                if abs(off) > rate * _LATE:
                    wanted.append((-math.inf, name))
            elif abs(off) > near and seen.time - self._released.get(name, -1.0) > _SEEN:
                wanted.append((-abs(off) / rate, name))
        return {name for _, name in sorted(wanted)[:_FINGERS]}

    # --- the rest of the port --------------------------------------------------------------------

    def set_mode(self, name: str) -> None:
        """See `TeleopPort.set_mode`: by the key that changes it."""
        mode = self._find(kind="command", name="mode")
        for _ in range(4):
            self._look_at_page()
            if self._look["mode"] == name:
                return
            self._tap(mode)
            self.robot.advance(0.6)
        raise NotManagedError(f"the page does not come to {name} mode")

    def e_stop(self, active: bool) -> None:
        """See `TeleopPort.e_stop`."""
        raise NotManagedError("nobody stops")

    def zoom(self, camera: str, factor: float) -> None:
        """See `TeleopPort.zoom`."""
        raise NotManagedError("nobody zooms")

    def camera(self, name: str) -> CameraView:
        """See `TeleopPort.camera`."""
        raise NotManagedError("the pictures are on the page")

    def answer(self, question: str, answer: str) -> None:
        """See `TeleopPort.answer`."""
        raise NotManagedError("nobody asks")

    def close(self) -> None:
        """Let go of all keys, and hear no more."""
        for name in list(self._down):
            self._release(name)
        self.robot.close()
