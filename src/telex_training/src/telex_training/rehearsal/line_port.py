"""A rehearsed robot at the far end of a line: it hears late or never, and is seen late."""

from __future__ import annotations

import collections
import functools
import math
from random import Random
from typing import Any, Callable, Deque, Tuple

import numpy as np

from telex_sim.engine.radio import signal_at
from telex_sim.offline.robot import OfflineRobot
from telex_teleop.web.line.line import Line
from telex_teleop.web.line.line_queue import LineQueue
from telex_teleop.web.line.profiles import LineSetting, Profiles

from ..exercises.model import Exercise
from ..operators.port import (
    Command,
    Drive,
    FlipperPreset,
    Jog,
    NamedPose,
    NotManagedError,
    Observation,
    ToolTwist,
)
from .teleop import Due, OfflineTeleop

_SIZE = 250
"""Bytes of a command as the console sends it."""
PATIENCE = 60.0
"""For how long (s) an operator waits for a line on which nothing passes."""
_LOOK = 0.25
"""Between two looks whether something passes again (s)."""
_ROUNDING = 1e-6

_profiles = functools.lru_cache(maxsize=None)(Profiles.read)


def line_setting(exercise: Exercise, profile: str = "") -> LineSetting:
    """Find the line of a rehearsal.

    Parameters
    ----------
    profile : str
        Name of one in telex_teleop/config/link_profiles.yaml; empty: what the exercise asks for.

    Raises
    ------
    ConfigError
        There is no such profile.
    """
    profiles = _profiles()
    if profile or exercise.link is None:
        return profiles.choose(profile)
    return profiles.combine(exercise.link.profile, exercise.link.fields)


class LineTeleop(OfflineTeleop):
    """A robot behind a line.

    Commands pass it first in, first out; those that move may be lost. A call (mode, e-stop, an
    answer) waits for its way there and back. What is seen is as old as the delay, to a sample of
    the truth, and stands during an outage. Where the line goes by the radio signal, that is
    computed as often as a simulator tells it.

    Parameters
    ----------
    advance, on_answer : callable
        As of `OfflineTeleop`.
    hear : callable
        Told of each command as it arrives.
    random : Random
        Of losses and jitter.
    patience : float
        For how long (s) an operator looks at what stands; then he gives up.
    """

    def __init__(
        self,
        robot: OfflineRobot,
        advance: Callable[[float], None],
        on_answer: Callable[[str, str], None],
        hear: Callable[[Command], None],
        setting: LineSetting,
        random: Random,
        patience: float = PATIENCE,
    ) -> None:
        self._hear, self._patience = hear, patience
        self._line, self._setting = Line(random), setting
        self._since = self._seen_at = robot.simulation.time
        self._looked = -math.inf
        self._line.configure(setting.fields, self._since)
        self._queue: LineQueue[Command] = LineQueue(self._line)
        self._seen: Deque[Tuple[Observation, Any]] = collections.deque()
        self._beside: Callable[[], Any] = lambda: None
        self._due = Due(robot.simulation.config.publish.truth_rate)
        super().__init__(robot, advance, on_answer)

    def observe(self) -> Observation:
        """See `Port.observe`."""
        return self.look()[0]

    def look(self) -> Tuple[Observation, Any]:
        """Return what is seen, and what else was kept of the same moment, see `keep_beside`.

        Raises
        ------
        NotManagedError
            Nothing has come for longer than the operator has patience.
        """
        if self._line.is_perfect:
            return self._sight()
        now = self._robot.simulation.time
        if self._line.in_outage(now) and now - self._seen_at > self._patience:
            raise NotManagedError(f"nothing has come by the line for {self._patience:g} s")
        self._keep()
        return self._seen[0]

    def keep_beside(self, make: Callable[[], Any]) -> None:
        """Have something else, such as where everything is, seen as late as the robot."""
        self._beside = make
        self._seen = collections.deque((seen, make()) for seen, _ in self._seen)

    def _sight(self) -> Tuple[Observation, Any]:
        return super().observe(), self._beside()

    def _keep(self) -> None:
        """Keep what there is to see, and forget what no look will show any more."""
        now, seen = self._robot.simulation.time, self._seen
        if seen and seen[-1][0].time == now:
            seen.pop()
        seen.append(self._sight())
        shown = now - self._line.fields.delay + _ROUNDING
        if self._line.in_outage(now):
            while len(seen) > 2 and seen[2][0].time <= shown:
                del seen[1]
        else:
            self._seen_at = now
            while len(seen) > 1 and seen[1][0].time <= shown:
                seen.popleft()

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
        if self._line.is_perfect:
            return
        asked = now = self._robot.simulation.time
        # Where all is lost, only another place of the robot, which may still move, or the end of
        # the trial changes that.
        while math.isinf(self._line.reopens(now)):
            if now - asked > PATIENCE:
                raise NotManagedError(f"nothing has passed the line for {PATIENCE:g} s")
            self.advance(_LOOK)
            now = self._robot.simulation.time
        wait = self._line.reopens(now) - now + self._line.draw_delay()
        self.advance(wait + self._line.draw_retransmissions())

    def _follow(self, now: float) -> None:
        """Have the line as the radio signal is."""
        simulation = self._robot.simulation
        robot = self._robot.robot
        rate = robot.config.radio.rate
        if self._setting.by_signal is None or not rate or now < self._looked + 1.0 / rate:
            return
        self._looked = now
        quality = signal_at(simulation, robot).quality
        self._line.configure(self._setting.at(quality), self._since)

    def _on_joint_state(self, stamp: float) -> None:
        self._follow(stamp)
        command = self._queue.take(stamp)
        while command is not None:
            self._arrive(command)
            command = self._queue.take(stamp)
        super()._on_joint_state(stamp)
        if self._line.is_perfect:
            self._seen.clear()
        elif self._due.due(stamp):
            self._keep()

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
