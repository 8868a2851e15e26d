"""Core of the track teleoperation: an operator's velocity in, a velocity within limits out.

Free of ROS, not thread-safe: whoever owns it serialises the calls.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Collection, Mapping, Optional, Tuple

from telex_control.common.params import number, parameter, word
from telex_control.common.plausible import LARGEST_SPEED
from telex_teleop.motion.joint_jog import require_number
from telex_teleop.motion.speed import SpeedScale
from telex_teleop.motion.stream import Clocks, CommandStream
from telex_teleop.motion.teleop_core import NEEDS_NEW_PRESS, TeleopCore
from telex_teleop.motion.teleop_settings import TeleopSettings

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
class TrackSettings(TeleopSettings):
    """Parameters of the track teleoperation node, beside those of every node."""

    command_timeout: float = 0.25
    max_linear: float = number(1.2, "Bound at speed scale 1 (m/s).", above=0.0)
    max_angular: float = number(1.0, "Bound at speed scale 1 (rad/s).", above=0.0)
    publish_rate: float = number(
        50.0, "Commands to the track controller per second of sim time.", 10.0, 100.0
    )
    stop_time: float = number(0.2, "Time (s) for which the final stop is repeated.", 0.0, 2.0)
    controller: str = word(
        "track_controller",
        "That drives the base: takes ``<controller>/cmd_vel`` and tells ``<controller>/odom``.",
    )
    pulse_joint: str = parameter(
        "front_left_track_joint",
        "One of the belts: joint states without it are not the base's and say nothing of its time.",
    )


@dataclass(frozen=True)
class TrackState:
    """What a display shows: whose command is obeyed, what is sent now, and why is none obeyed."""

    commanders: Tuple[str, ...]
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
        require_number(name, value, LARGEST_SPEED)
    used = ("linear.x", "angular.z")
    ignored = tuple(name for name, value in components.items() if value != 0.0 and name not in used)
    return Velocity(components["linear.x"], components["angular.z"]), ignored


class TrackDrive(TeleopCore):
    """Drives the base while a command stream is alive, and ends with a stop.

    Parameters
    ----------
    speed
        The operator's speed, shared with whoever sets it.
    """

    def __init__(self, settings: TrackSettings, speed: SpeedScale) -> None:
        super().__init__(settings.command_timeout, settings.longest_step, speed)
        self.settings = settings
        self._stream: CommandStream[Velocity] = CommandStream(settings.command_timeout)
        self._sent = STANDSTILL
        self._sent_at: Optional[float] = None
        self._stopping_until: Optional[float] = None
        self._inhibit()

    @property
    def idle(self) -> bool:
        """Whether nothing drives, and the stop at the end of a drive has been repeated enough."""
        return self._sent == STANDSTILL and self._stopping_until is None

    def receive(self, velocity: Velocity, wall: float, caller: str = "") -> None:
        """Take a command of `caller` that arrived at `wall` (monotonic time, s)."""
        if self._ticks.now is None:
            return
        if velocity == STANDSTILL:
            self._stream.end(caller)
        else:
            self._stream.receive(velocity, self._arrival(wall), caller)

    def keep(self, callers: Collection[str]) -> None:
        """Stop what was driving unless its client is one of `callers`: the others are gone."""
        self._stream.keep(callers)

    def restart(self, stamp: float) -> None:
        """Forget the drive, because the robot was put somewhere else; the belts are stopped."""
        del stamp
        self._restart()

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
        if self._starting.ends(wall):
            self._inhibit()
        slept = self._paused(wall)
        tick = self._ticks.advance(stamp)
        self._last_wall = wall
        if tick is None:
            return None
        # A simulation that stood still goes on with a robot at full speed.
        if tick.jumped or slept:
            self._restart()
        command = self._stream.command(Clocks(wall, stamp))
        if command is not None:
            self._stopping_until = None
            return self._send(self._limited(command), stamp) if self._due(stamp) else None
        return self._finish(stamp)

    def state(self, wall: float) -> TrackState:
        """Return what a display shows at `wall` (monotonic time, s)."""
        message = self._inhibition(wall)
        if self._ticks.now is None:
            return TrackState((), STANDSTILL, message)
        alive = self._stream.command(Clocks(wall, self._ticks.now)) is not None
        if not message and self._stream.waiting(wall):
            message = NEEDS_NEW_PRESS
        commanders = (self._stream.obeyed,) if alive and not message else ()
        return TrackState(commanders, self._sent, message)

    def _inhibit(self) -> None:
        self._stream.inhibit(self._inhibited)

    def _restart(self) -> None:
        """Forget everything, but stop what was driving."""
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
