"""Speeds of the belts of a tracked robot, led by a yaw rate that is measured.

Belts slip sideways when they turn a robot, and along: it turns by a quarter or a half of what
wheels at the same places would do, depending on the ground, on the load and on how much of the
belts lies on it. A factor makes up for the usual case, and a PI loop for the rest.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Optional, Tuple

from ..common.params import Declared, number, parameter
from ..common.stateful import Stateful
from ..hardware.joint_limits import clamp

_TURNING = 0.05
"""Yaw rate (rad/s) below which the robot counts as driving straight."""
_STEERING = 0.1
"""Yaw rate (rad/s) for which the belts may always make up while the robot drives along, to keep
its course."""
_ANSWERS = 0.1
"""Least share of the wanted yaw rate that a robot reaches unless it is blocked."""
_ANSWERS_AT_LEAST = 0.004
"""The same, as a yaw rate (rad/s): more than a gyroscope's filtered noise."""
_LISTENS = 0.2
"""Time constant (s) of the yaw rate in which an answer is looked for: tracks that slip on a slope
shake the robot by as much to either side."""
_SILENCE = 0.1
"""How long (s) a robot that has answered may stand still before it counts as blocked: one that is
pulled the other way comes through standstill."""
_FADES = 0.3
"""Time constant (s) of an integral that itself turns a robot which is to drive straight; what is
left within the tolerance would stay for good."""
_REMEMBERS = 2.0
"""Time constant (s) with which the integral's part for a faster turn is forgotten."""
_FOLLOWS = 0.25
"""Share of the belts' speed difference by which they may lag behind and still follow."""
_FOLLOWS_AT_LEAST = 0.05
"""The same, as a speed (m/s)."""


@dataclass(frozen=True)
class YawRateLoopConfig(Declared):
    """Gains and limits of the loop."""

    proportional_gain: float = number(
        2.0, "Of the yaw rate's error: yaw rate that the belts are to make up for, per rad/s.", 0.0
    )
    integral_gain: float = number(20.0, "Of the error's integral (1/s).", 0.0)
    filter_time: float = number(
        0.02, "Time constant of the filter on the measured yaw rate (s); 0 for none.", 0.0
    )
    response_time: float = number(
        0.05,
        "Time constant with which the robot follows at best (s): the integral expects no more.",
        0.0,
    )
    straight_tolerance: float = number(
        0.01,
        "Yaw rate that is left alone while the robot drives straight (rad/s). Equal "
        "belts keep it straight by themselves; a loop that takes what is left of the "
        "gyroscope's bias for a turn lets the belts of both sides fight each other with"
        " all they have.",
        0.0,
    )
    max_factor: float = number(
        10.0,
        "How much more than wheels the belts may turn at most, so that a blocked robot "
        "does not spin them ever faster.",
        1.0,
    )
    hold_heading: bool = parameter(
        False, "Whether the robot keeps the heading that it had when it began to drive straight."
    )
    heading_gain: float = number(2.0, "Of the heading's error (1/s).", 0.0)
    max_heading_rate: float = number(
        0.2, "Yaw rate at which a lost heading is taken up again, at most (rad/s).", 0.0
    )


class YawRateLoop(Stateful):
    """Turns a commanded twist into speeds of the left and the right belts.

    A robot that is told to stand gets standing belts, whatever is measured. Where the belts would
    have to run faster than they can, the robot drives slower rather than turn less.

    The integral is of use for one way of driving. It shrinks with the commanded yaw rate, or the
    robot would turn on after a turn; what this took away comes back with a faster turn, or an
    unsteady hand would wear it down, but no more than that, since what makes up for a pull in a
    slow turn would be far too much in a fast one. It ends when the robot stands. It does not grow
    while growth would be in vain: the belts run as fast as they may, do not follow (a brake, a
    stalled motor), or the robot does not answer them (it is blocked).

    Parameters
    ----------
    max_speed : float
        Of a belt (m/s).

    Attributes
    ----------
    integral : float
        Yaw rate that the belts make up for (rad/s).
    """

    SAVED = (
        "_angular",
        "_difference",
        "_expected",
        "_fastest",
        "_heard",
        "_rate",
        "_saturated",
        "_since_answer",
        "_taken",
        "_turned",
        "integral",
    )

    def __init__(self, config: YawRateLoopConfig, max_speed: float) -> None:
        self._config = config
        self._max_speed = max_speed
        self.reset()

    def reset(self) -> None:
        """Forget the past."""
        self.integral = 0.0
        self._rate: Optional[float] = None
        self._expected = 0.0
        self._angular = 0.0
        # What slower turns took from the integral, and the one (rad/s) that it belonged to.
        self._taken = self._fastest = 0.0
        self._heard = 0.0
        self._since_answer = math.inf
        self._difference = 0.0
        self._saturated = False
        self._turned: Optional[float] = None

    def update(
        self,
        linear: float,
        angular: float,
        yaw_rate: Optional[float],
        belt_difference: float,
        gauge: Tuple[float, float],
        period: float,
    ) -> Tuple[float, float]:
        """Return the speeds of the left and the right belts (m/s) for the next cycle.

        Parameters
        ----------
        linear, angular : float
            Commanded (m/s, rad/s).
        yaw_rate : float or None
            Measured about the robot's own vertical axis (rad/s); None when it is not known.
        belt_difference : float
            Half of what the right belts run faster than the left, measured (m/s).
        gauge : tuple of 2 floats
            Distance of the belts, and the one that wheels of the same effect would have (m).
        period : float
            Of a cycle (s).
        """
        distance, effective = gauge
        if linear == 0.0 and angular == 0.0:
            self.reset()
            return 0.0, 0.0
        factor = effective / distance
        turn = factor * angular
        if yaw_rate is None:
            self.integral = 0.0
            self._rate = self._turned = None
        else:
            wanted = angular + self._heading_correction(linear, angular, yaw_rate, period)
            self._scale_integral(angular, period)
            self._filter(wanted, yaw_rate, period)
            self._listen(wanted, period)
            straight = angular == 0.0 and abs(wanted) < _TURNING
            may_grow = (
                not self._saturated
                and self._follows(belt_difference)
                and (straight or self._since_answer <= _SILENCE)
            )
            at_least = 0.0 if linear == 0.0 else _STEERING
            turn = self._led(wanted, factor, may_grow, at_least, period)
        self._angular = angular
        return self._within_limits(linear, 0.5 * turn * distance)

    def _heading_correction(
        self, linear: float, angular: float, yaw_rate: float, period: float
    ) -> float:
        """Yaw rate that leads back to the heading at which the robot began to drive straight."""
        config = self._config
        if not config.hold_heading or angular != 0.0 or linear == 0.0:
            self._turned = None
            return 0.0
        if self._turned is None:
            # The end of a turn is not yet the heading to keep.
            if abs(yaw_rate) > _TURNING:
                return 0.0
            self._turned = 0.0
        self._turned += yaw_rate * period
        limit = config.max_heading_rate
        return clamp(-config.heading_gain * self._turned, -limit, limit)

    def _scale_integral(self, angular: float, period: float) -> None:
        """Let the integral go down and up with the commanded yaw rate."""
        last, now = abs(self._angular), abs(angular)
        given = 0.0
        if angular * self._angular < 0.0:
            self.integral = self._taken = 0.0
        elif now < last:
            given = self.integral * (now / last - 1.0)
        elif now > last and self._fastest > last:
            given = self._taken * min(1.0, (now - last) / (self._fastest - last))
        self.integral += given
        kept = _REMEMBERS / (period + _REMEMBERS)
        self._taken = (self._taken - given) * kept
        self._fastest = now + max(0.0, self._fastest - now) * kept

    def _filter(self, wanted: float, yaw_rate: float, period: float) -> None:
        """Go on with the measured yaw rate, and with the one that can be expected of it."""
        config = self._config
        if self._rate is None:
            self._rate = self._expected = yaw_rate
        self._rate += (yaw_rate - self._rate) * period / (period + config.filter_time)
        self._expected += (wanted - self._expected) * period / (period + config.response_time)

    def _led(
        self, wanted: float, factor: float, may_grow: bool, at_least: float, period: float
    ) -> float:
        """Turn of the belts, as a yaw rate of wheels (rad/s), by feed-forward and PI.

        Its limit counts from a wanted yaw rate of `at_least` (rad/s).
        """
        assert self._rate is not None
        config = self._config
        # Not the drives' lag, which would be taken for slip and lead to an overshoot.
        lasting, error = self._expected - self._rate, wanted - self._rate
        if wanted == 0.0:
            tolerance = config.straight_tolerance
            lasting -= clamp(lasting, -tolerance, tolerance)
            error -= clamp(error, -tolerance, tolerance)
            if self.integral * self._rate > 0.0:
                self.integral *= _FADES / (period + _FADES)
        if may_grow or self.integral * lasting < 0.0:
            self.integral += config.integral_gain * lasting * period
        turn = factor * wanted + config.proportional_gain * error + self.integral
        limit = config.max_factor * max(abs(wanted), at_least)
        self._saturated = abs(turn) > limit
        return clamp(turn, -limit, limit)

    def _follows(self, belt_difference: float) -> bool:
        """Whether the belts run as they were told to."""
        lag = abs(self._difference - belt_difference)
        return lag <= _FOLLOWS_AT_LEAST + _FOLLOWS * abs(self._difference)

    def _listen(self, wanted: float, period: float) -> None:
        """Note whether the robot turns; against the command too: then it is pulled, not blocked."""
        assert self._rate is not None
        self._heard += (self._rate - self._heard) * period / (period + _LISTENS)
        answers = abs(self._heard) >= max(_ANSWERS * abs(wanted), _ANSWERS_AT_LEAST)
        self._since_answer = 0.0 if answers else self._since_answer + period

    def _within_limits(self, linear: float, difference: float) -> Tuple[float, float]:
        """Speeds of the belts for half their difference; the turn has precedence."""
        limit = self._max_speed
        self._saturated = self._saturated or abs(difference) > limit
        self._difference = difference = clamp(difference, -limit, limit)
        rest = limit - abs(difference)
        linear = clamp(linear, -rest, rest)
        return linear - difference, linear + difference
