"""Exposure of a camera: by hand, or by the brightness of its last pictures."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Optional

import numpy as np

from telex_control.common.params import Declared, number, parameter, require

_MAX_EV = 16.0

# Of the finished picture, every so many rows and columns are metered.
_METERED = 8

# Light that an automatic exposure aims at, in the mean: shown as 0.53 of white.
_AIM = -math.log2(1.0 - 0.53**2)

# The darkest that is told apart from black (of white).
_DARKEST = 1.0 / 255.0

# Light for each of the values that a picture is made of, by the curve that they are shown with:
# value = sqrt(1 - 2^-light). White is as bright as the last value below it.
_LIGHT = -np.log2(1.0 - np.square(np.minimum(np.arange(256), 254) / 255.0))


@dataclass(frozen=True)
class ExposureConfig(Declared):
    """How a camera exposes. One EV more is twice the light.

    Raises
    ------
    telex_control.common.params.ConfigError
    """

    auto: bool = parameter(False, "Whether it follows the light.")
    ev: float = number(
        0.0,
        "By hand: the exposure, 0 for a bright day. Automatic: how much brighter the "
        "picture shall be than a medium one.",
        -_MAX_EV,
        _MAX_EV,
    )
    min_ev: float = number(-2.0, "Least that an automatic exposure chooses.", -_MAX_EV, _MAX_EV)
    max_ev: float = number(2.0, "Most that it chooses.", -_MAX_EV, _MAX_EV)
    time_constant: float = number(
        0.4, "In which it makes up for 63 % of a change (s of sim time).", 0.0, 60.0
    )

    def check(self) -> None:
        """Check what concerns several of them; see `Declared.check`."""
        require(
            self.min_ev <= self.max_ev,
            f"min_ev is {self.min_ev}; it must not be above max_ev, which is {self.max_ev}",
        )


class ExposureControl:
    """Exposes one camera, picture after picture."""

    def __init__(self) -> None:
        self._ev = 0.0
        self._wanted_ev = 0.0
        self._stamp: Optional[int] = None

    def expose(self, config: ExposureConfig, stamp: int) -> float:
        """Choose the exposure of the next picture.

        Parameters
        ----------
        stamp
            Sim time of the picture (ns); may jump back when the simulation restarts.

        Returns
        -------
        float
            EV.
        """
        if not config.auto:
            self._ev = self._wanted_ev = config.ev
        elif self._stamp is not None:
            passed = max(0.0, (stamp - self._stamp) * 1e-9)
            share = 1.0
            if config.time_constant > 0.0:
                share = -math.expm1(-passed / config.time_constant)
            wanted = min(max(self._wanted_ev + config.ev, config.min_ev), config.max_ev)
            self._ev += share * (wanted - self._ev)
        self._stamp = stamp
        return self._ev

    def meter(self, picture: np.ndarray) -> None:
        """Look at the picture that was taken with the exposure chosen last.

        Parameters
        ----------
        picture
            RGBA, shape (height, width, 4), uint8, without noise.
        """
        # Green carries most of the brightness.
        top, left = (min(_METERED // 2, side - 1) for side in picture.shape[:2])
        sample = picture[top::_METERED, left::_METERED, 1]
        light = max(float(_LIGHT[sample].mean()), _DARKEST**2)
        self._wanted_ev = self._ev + math.log2(_AIM / light)


def exposure_factor(ev: float) -> float:
    """By what light is multiplied."""
    return 2.0**ev
