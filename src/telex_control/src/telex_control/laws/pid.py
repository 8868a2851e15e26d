"""PID with the semantics of ROS's control_toolbox, without its derivative kick."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Mapping, Optional

from ..common.params import ConfigError, read_value
from ..common.stateful import Stateful

_KEYS = {"p", "i", "d", "i_clamp", "i_clamp_min", "i_clamp_max", "antiwindup", "publish_state"}


@dataclass(frozen=True)
class PidGains:
    """Gains of a `Pid`.

    Attributes
    ----------
    p, i, d : float
        Proportional, integral and derivative gain.
    i_max, i_min : float
        Bounds of the integral term (unit of the output).
    antiwindup : bool
        Bound the integral itself, so that it leaves its bound as soon as the error turns.
    """

    p: float
    i: float = 0.0
    d: float = 0.0
    i_max: float = 0.0
    i_min: float = 0.0
    antiwindup: bool = False

    @classmethod
    def from_params(cls, params: Mapping[str, Any], name: str) -> PidGains:
        """Read gains from a ``pid`` parameter struct.

        Parameters
        ----------
        params : mapping
            Keys p (required), i, d, i_clamp, i_clamp_min, i_clamp_max, antiwindup.
        name : str
            Full name of the parameter, for messages.

        Raises
        ------
        ConfigError
            A key is missing or unknown, or a value is no finite number; the message names it.
        """
        if not isinstance(params, Mapping):
            raise ConfigError(f"parameter {name} is {params!r}; a struct with p, i, d is needed")
        unknown = sorted(set(params) - _KEYS)
        if unknown:
            raise ConfigError(
                f"parameter {name}/{unknown[0]} is unknown; known are {', '.join(sorted(_KEYS))}"
            )
        if "p" not in params:
            raise ConfigError(f"parameter {name}/p is missing; it is the proportional gain")

        def number(key: str, default: float) -> float:
            return read_value(float, params.get(key, default), f"parameter {name}/{key}")

        for key in ("antiwindup", "publish_state"):
            read_value(bool, params.get(key, False), f"parameter {name}/{key}")
        clamp = abs(number("i_clamp", 0.0))
        gains = cls(
            p=number("p", 0.0),
            i=number("i", 0.0),
            d=number("d", 0.0),
            i_max=number("i_clamp_max", clamp),
            i_min=number("i_clamp_min", -clamp),
            antiwindup=params.get("antiwindup", False),
        )
        if gains.i_min > gains.i_max:
            raise ConfigError(
                f"parameter {name}: i_clamp_min {gains.i_min} is above i_clamp_max {gains.i_max}"
            )
        return gains


class Pid(Stateful):
    """One PID loop.

    The output is ``p e + clamp(i integral(e)) + d de/dt``. Unlike control_toolbox, the first
    sample after `reset` has no derivative from differences: there is no earlier error to
    differ from, and a kick of ``d e / period`` would follow every start.

    Attributes
    ----------
    gains : PidGains
        May be replaced at any time, also from another thread.
    error, error_dot, integral, i_term, output, period : float
        Of the last sample that was usable.
    """

    __slots__ = (
        "_last_error",
        "error",
        "error_dot",
        "gains",
        "i_term",
        "integral",
        "output",
        "period",
    )
    SAVED = ("_last_error", "error", "error_dot", "i_term", "integral", "output", "period")

    def __init__(self, gains: PidGains) -> None:
        self.gains = gains
        self.reset()

    def reset(self) -> None:
        """Forget the past."""
        self.integral = 0.0
        self._last_error: Optional[float] = None
        self.error = 0.0
        self.error_dot = 0.0
        self.i_term = 0.0
        self.output = 0.0
        self.period = 0.0

    def update(self, error: float, period: float, error_dot: Optional[float] = None) -> float:
        """Advance by one sample and return the output.

        Parameters
        ----------
        error : float
            Set point minus measured value.
        period : float
            Time since the last call (s); at 0 or below the output is 0.
        error_dot : float, optional
            Derivative of the error; taken from differences when not given.

        Returns
        -------
        float
            The output; 0 for input that is not finite, which leaves the state as it was.
        """
        if period <= 0.0 or not math.isfinite(error):
            return 0.0
        if error_dot is None:
            last = self._last_error
            error_dot = 0.0 if last is None else (error - last) / period
        if not math.isfinite(error_dot):
            return 0.0
        self._last_error = error
        gains = self.gains
        integral = self.integral + period * error
        if gains.antiwindup and gains.i != 0.0:
            low, high = gains.i_min / gains.i, gains.i_max / gains.i
            if low > high:
                low, high = high, low
            integral = low if integral < low else (high if integral > high else integral)
        self.integral = integral
        i_term = gains.i * integral
        low, high = gains.i_min, gains.i_max
        self.i_term = i_term = low if i_term < low else (high if i_term > high else i_term)
        self.error = error
        self.error_dot = error_dot
        self.period = period
        self.output = gains.p * error + i_term + gains.d * error_dot
        return self.output
