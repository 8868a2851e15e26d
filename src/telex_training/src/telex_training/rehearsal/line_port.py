"""A rehearsed robot at the far end of a line: it hears late or never, and is seen late."""

from __future__ import annotations

import collections
from random import Random
from typing import Callable, Deque

import numpy as np

from telex_control.common.params import ConfigError
from telex_sim.offline.robot import OfflineRobot
from telex_teleop.web.line.line import Line
from telex_teleop.web.line.messages import LineQueue
from telex_teleop.web.line.profiles import LineSetting, Profiles

from ..exercises.model import Exercise
from ..operators.port import (
    Command,
    Drive,
    FlipperPreset,
    Jog,
    NamedPose,
    Observation,
    ToolTwist,
)
from .teleop import OfflineTeleop

_SIZE = 250
"""Bytes of a command as the console sends it."""


def line_setting(exercise: Exercise, profile: str = "") -> LineSetting:
    """Find the line of a rehearsal.

    Parameters
    ----------
    exercise : Exercise
    profile : str
        Name of one in telex_teleop/config/link_profiles.yaml; empty: what the exercise asks for.

    Raises
    ------
    ConfigError
        There is no such profile, or it depends on the radio signal, which is not computed here.
    """
    profiles = Profiles.read()
    if profile:
        setting = profiles.choose(profile)
    elif exercise.link is not None:
        setting = profiles.combine(exercise.link.profile, exercise.link.fields)
    else:
        setting = profiles.choose("")
    if setting.by_signal is not None:
        raise ConfigError(f"line is '{setting.name}'; one that does not go by the signal is needed")
    return setting


class LineTeleop(OfflineTeleop):
    """A robot behind a line.

    Commands pass it first in, first out; those that move may be lost. A call (mode, e-stop, an
    answer) waits for its way there and back. What is seen is as old as the delay, and stands
    during an outage.

    Parameters
    ----------
    robot : OfflineRobot
    advance, on_answer : callable
        As of `OfflineTeleop`.
    hear : callable
        Told of each command as it arrives.
    setting : LineSetting
    random : Random
        Of losses and jitter.
    """

    def __init__(
        self,
        robot: OfflineRobot,
        advance: Callable[[float], None],
        on_answer: Callable[[str, str], None],
        hear: Callable[[Command], None],
        setting: LineSetting,
        random: Random,
    ) -> None:
        self._hear = hear
        self._line = Line(random)
        self._line.configure(setting.fields, robot.simulation.time)
        self._queue: LineQueue[Command] = LineQueue(self._line)
        self._seen: Deque[Observation] = collections.deque()
        super().__init__(robot, advance, on_answer)

    def observe(self) -> Observation:
        """See `Port.observe`."""
        newest = super().observe()
        if self._line.is_perfect:
            return newest
        self._seen.append(newest)
        now = newest.time
        if not self._line.in_outage(now):
            shown = now - self._line.fields.delay
            while len(self._seen) > 1 and self._seen[1].time <= shown:
                self._seen.popleft()
        return self._seen[0]

    def send(self, command: Command) -> None:
        """See `Port.send`."""
        if self._queue.passes:
            self._arrive(command)
            return
        now = self._robot.simulation.time
        if _moves(command):
            self._queue.send_or_lose(command, _SIZE, now)
        else:
            self._queue.send(command, _SIZE, now)

    def set_mode(self, name: str) -> None:
        """See `TeleopPort.set_mode`."""
        self._cross()
        super().set_mode(name)
        self._cross()

    def e_stop(self, active: bool) -> None:
        """See `TeleopPort.e_stop`."""
        self._cross()
        super().e_stop(active)
        self._cross()

    def answer(self, question: str, answer: str) -> None:
        """See `TeleopPort.answer`."""
        self._cross()
        super().answer(question, answer)

    def _cross(self) -> None:
        if not self._line.is_perfect:
            now = self._robot.simulation.time
            wait = self._line.reopens(now) - now + self._line.draw_delay()
            self.advance(wait + self._line.draw_retransmissions())

    def _on_joint_state(self, stamp: float) -> None:
        command = self._queue.take(stamp)
        while command is not None:
            self._arrive(command)
            command = self._queue.take(stamp)
        super()._on_joint_state(stamp)

    def _arrive(self, command: Command) -> None:
        self._hear(command)
        super().send(command)


def _moves(command: Command) -> bool:
    """Tell whether a command asks for motion: a stop must arrive."""
    if isinstance(command, Drive):
        return bool(command.linear or command.angular)
    if isinstance(command, Jog):
        return any(command.rates.values())
    if isinstance(command, ToolTwist):
        return bool(np.any([*command.linear, *command.angular]))
    if isinstance(command, (FlipperPreset, NamedPose)):
        return bool(command.name)
    return True
