"""A robot that does at once what its tracks are told."""

from __future__ import annotations

import math
from typing import Dict, List, Optional

import numpy as np

from telex_training.operators.port import (
    CameraView,
    Command,
    Drive,
    Notice,
    Observation,
    Placement,
    TeleopPort,
)
from telex_training.operators.station import FLIPPERS


class FlatFloor(TeleopPort):
    """Drives without inertia; flippers and arm stay."""

    def __init__(self) -> None:
        super().__init__()
        self.urdf = ""
        self.x = self.y = self.yaw = self.time = 0.0
        self.deaf = False
        self.speeds: List[Drive] = []
        self.sent: List[Command] = []
        self.notices: Dict[str, Notice] = {}
        self._told = Drive()

    def observe(self) -> Observation:
        orientation = (0.0, 0.0, math.sin(0.5 * self.yaw), math.cos(0.5 * self.yaw))
        return Observation(
            time=self.time,
            base=Placement((self.x, self.y, 0.11), orientation),
            positions=dict.fromkeys(FLIPPERS, 0.1),
            notices=dict(self.notices),
        )

    def advance(self, seconds: float) -> None:
        self.time += seconds
        if not self.deaf:
            self.speeds.append(self._told)
            self.yaw += seconds * self._told.angular
            self.x += seconds * self._told.linear * math.cos(self.yaw)
            self.y += seconds * self._told.linear * math.sin(self.yaw)

    def send(self, command: Command) -> None:
        self.sent.append(command)
        if isinstance(command, Drive):
            self._told = command

    def set_mode(self, name: str) -> None:
        raise AssertionError(f"mode {name} was set")

    def e_stop(self, active: bool) -> None:
        raise AssertionError("the emergency stop was touched")

    def zoom(self, camera: str, factor: float) -> None:
        raise AssertionError(f"camera {camera} was zoomed")

    def camera(self, name: str) -> CameraView:
        raise AssertionError(f"camera {name} was opened")

    def object_pose(self, name: str) -> Optional[np.ndarray]:
        return None

    def answer(self, question: str, answer: str) -> None:
        raise AssertionError(f"question {question} was answered")
