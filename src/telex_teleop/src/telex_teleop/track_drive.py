"""Core of the track teleoperation: a driver's velocity in, a velocity within limits out.

Free of ROS, not thread-safe: whoever owns it serialises the calls.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Mapping, Optional, Tuple

from telex_teleop.joint_jog import InvalidCommand
from telex_teleop.settings import Section
from telex_teleop.speed import SpeedScale
from telex_teleop.stream import Clocks, CommandStream, SimTicks

__all__ = ["TrackDrive", "TrackSettings", "TrackState", "Velocity", "parse_twist"]

# A joint state may come this much before its turn (s) and still be the one that a message is due
# with.
SCHEDULE_TOLERANCE = 1e-3


@dataclass(frozen=True)
class Velocity:
    """Velocity of the base: forward (m/s), yaw rate to the left (rad/s)."""

    linear: float
    angular: float


STANDSTILL = Velocity(0.0, 0.0)


@dataclass(frozen=True)
class TrackSettings:
    """Parameters of the track teleoperation node.

    Attributes
    ----------
    max_linear, max_angular
        Bounds at speed scale 1 (m/s, rad/s).
    command_timeout
        Age (s) at which a command that is not repeated ends.
    longest_step
        Joint states further apart than this (s of sim time) start everything anew.
    publish_rate
        Commands to the track controller per second of sim time.
    stop_time
        Time (s) for which the final stop is repeated.
    status_rate
        Status messages per second of wall time.
    """

    max_linear: float
    max_angular: float
    command_timeout: float
    longest_step: float
    publish_rate: float
    stop_time: float
    status_rate: float

    @classmethod
    def from_settings(cls, settings: Section) -> TrackSettings:
        """Read the parameters; the caller finishes the section."""
        return cls(
            max_linear=settings.number("max_linear", 1.2, positive=True),
            max_angular=settings.number("max_angular", 1.0, positive=True),
            command_timeout=settings.number("command_timeout", 0.28, positive=True, maximum=0.3),
            longest_step=settings.number("longest_step", 0.5, positive=True),
            publish_rate=settings.number("publish_rate", 50.0, minimum=10.0, maximum=100.0),
            stop_time=settings.number("stop_time", 0.2, minimum=0.0, maximum=2.0),
            status_rate=settings.number("status_rate", 10.0, positive=True, maximum=100.0),
        )


@dataclass(frozen=True)
class TrackState:
    """What a display shows: is a command obeyed, what is sent now, and why is none obeyed."""

    active: bool
    command: Velocity
    message: str


def parse_twist(components: Mapping[str, float]) -> Tuple[Velocity, Tuple[str, ...]]:
    """Check a Twist.

    Parameters
    ----------
    components
        The six components under the names ``linear.x`` to ``angular.z``.

    Returns
    -------
    tuple
        The velocity, and the names of the components that tracks cannot follow and that are not
        zero.

    Raises
    ------
    InvalidCommand
        When a component is no finite number.
    """
    for name, value in components.items():
        if not math.isfinite(value):
            raise InvalidCommand(f"{name} is {value!r}; must be a finite number")
    used = ("linear.x", "angular.z")
    ignored = tuple(name for name, value in components.items() if value != 0.0 and name not in used)
    return Velocity(components["linear.x"], components["angular.z"]), ignored


class TrackDrive:
    """Drives the base while a command stream is alive, and ends with a stop.

    Parameters
    ----------
    settings
        Bounds and times.
    speed
        The operator's speed, shared with whoever sets it.
    """

    def __init__(self, settings: TrackSettings, speed: SpeedScale) -> None:
        self.settings = settings
        self.speed = speed
        self._stream: CommandStream[Velocity] = CommandStream(settings.command_timeout)
        self._ticks = SimTicks(settings.longest_step)
        self._last_wall: Optional[float] = None
        self._e_stop = False
        self._sent = STANDSTILL
        self._sent_at: Optional[float] = None
        self._stopping_until: Optional[float] = None

    def receive(self, velocity: Velocity, wall: float) -> None:
        """Take a command that arrived at `wall` (monotonic time, s)."""
        if self._ticks.now is None:
            return
        if velocity == STANDSTILL:
            self._stream.end()
        else:
            self._stream.receive(velocity, Clocks(wall, self._ticks.now))

    def set_e_stop(self, active: bool) -> None:
        """Begin or end an emergency stop."""
        if active != self._e_stop:
            self._e_stop = active
            self._stream.inhibit(active)

    def update(self, stamp: float, wall: float) -> Optional[Velocity]:
        """Advance to a new joint state.

        Parameters
        ----------
        stamp
            Its stamp (s of sim time).
        wall
            Monotonic time (s) of its arrival.

        Returns
        -------
        Velocity or None
            What to send to the track controller, None for nothing.
        """
        tick = self._ticks.advance(stamp)
        self._last_wall = wall
        if tick is None:
            return None
        if tick.jumped:
            self._restart()
        command = self._stream.command(Clocks(wall, stamp))
        if command is not None:
            self._stopping_until = None
            return self._send(self._limited(command), stamp) if self._due(stamp) else None
        return self._finish(stamp)

    def state(self, wall: float) -> TrackState:
        """Return what a display shows at `wall` (monotonic time, s)."""
        if self._ticks.now is None or self._last_wall is None:
            return TrackState(False, STANDSTILL, "no joint_states yet: is the simulator running?")
        alive = self._stream.command(Clocks(wall, self._ticks.now)) is not None
        if self._e_stop:
            message = "the e-stop is active"
        elif wall - self._last_wall > 2.0 * self.settings.command_timeout:
            message = "no joint_states: the simulation is paused or has ended"
        elif self._stream.waiting(wall):
            message = "a command from before the stop goes on: release the key and press it again"
        else:
            message = ""
        return TrackState(alive and not message, self._sent, message)

    def _restart(self) -> None:
        """Forget everything after a jump of the sim time, but stop what was driving."""
        self._stream.latch()
        self._sent_at = None
        self._stopping_until = None

    def _finish(self, stamp: float) -> Optional[Velocity]:
        """Return the stop that ends a drive, repeated for a while, then nothing."""
        if self._sent != STANDSTILL:
            self._stopping_until = stamp + self.settings.stop_time
            return self._send(STANDSTILL, stamp)
        if self._stopping_until is None or not self._due(stamp):
            return None
        if stamp > self._stopping_until:
            self._stopping_until = None
            return None
        return self._send(STANDSTILL, stamp)

    def _limited(self, command: Velocity) -> Velocity:
        limits, scale = self.settings, self.speed.value
        linear = max(-limits.max_linear, min(limits.max_linear, command.linear))
        angular = max(-limits.max_angular, min(limits.max_angular, command.angular))
        return Velocity(linear * scale, angular * scale)

    def _due(self, stamp: float) -> bool:
        period = 1.0 / self.settings.publish_rate
        return self._sent_at is None or stamp - self._sent_at >= period - SCHEDULE_TOLERANCE

    def _send(self, velocity: Velocity, stamp: float) -> Velocity:
        self._sent = velocity
        self._sent_at = stamp
        return velocity
