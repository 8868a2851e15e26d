"""Cost and effect of radiation: the field among shields, and its noise in pictures."""

from __future__ import annotations

import math
import time
from typing import Callable, List

import numpy as np

from telex_sim.cameras.optics.noise import RadiationConfig, SensorNoise
from telex_sim.radiation.field import Field, PointSource, Shield, ShieldForm

from ..rigs.report import Figure

_WIDTH, _HEIGHT = 640, 480
_NOISE = 1.5
"""Of the electronics (grey levels), as the cameras for driving have it."""


def radiation_figures(rounds: int) -> List[Figure]:
    """CPU time of the field and of the noise; ratio of signal and noise after 80 Gy.

    Parameters
    ----------
    rounds : int
        The more, the less chance there is in the times: each is the median of 50 times as many.
    """
    figures = [
        Figure(
            f"field of 24 rays, {count} shields: CPU",
            _field_time(count, 50 * rounds),
            "ms",
            at_most=2.0,
        )
        for count in (50, 500)
    ]
    figures += [
        Figure(
            f"noise at {rate:g} Gy/h after 80 Gy, 640x480: CPU",
            _noise_time(rate, 50 * rounds),
            "ms",
            at_most=0.5,
        )
        for rate in (10.0, 180.0)
    ]
    gray, dark = _relative_snr(120), _relative_snr(40)
    return [
        *figures,
        Figure("signal to noise at 10 Gy/h after 80 Gy, grey 120", gray, "dB", -7.0, -3.0),
        Figure("the same, grey 40 beside grey 120", dark - gray, "dB", at_most=-5.0),
    ]


def _median(measure: Callable[[int], None], rounds: int) -> float:
    """Median of the thread's CPU time (ms)."""
    spent = []
    for number in range(rounds):
        began = time.thread_time()
        measure(number)
        spent.append(1000.0 * (time.thread_time() - began))
    return float(np.median(spent))


def _field_time(count: int, rounds: int) -> float:
    random = np.random.default_rng(1)
    shields = [
        Shield(ShieldForm.BOX, tuple(random.uniform(0.05, 0.5, 3)), "concrete", number)
        for number in range(count)
    ]
    field = Field([PointSource("Co-60", 1e12)] * 3, shields)
    field.positions[:] = random.uniform(-5.0, 5.0, (3, 3))
    field.centers[:] = random.uniform(-5.0, 5.0, (count, 3))
    points = random.uniform(-5.0, 5.0, (8, 3))
    return _median(lambda _: np.sum(field.rates(points)), rounds)


def _noise_time(rate: float, rounds: int) -> float:
    noise, config = SensorNoise(_WIDTH, _HEIGHT, 7), RadiationConfig(dose_rate=rate, dose=80.0)
    picture = np.full((_HEIGHT, _WIDTH, 4), 120, np.uint8)

    def take(stamp: int) -> None:
        noise.age(picture, config)
        noise.irradiate(picture, config, stamp)

    return _median(take, rounds)


def _relative_snr(grey: int) -> float:
    """Ratio to that of the same camera elsewhere (dB), mean of 100 pictures."""
    config, spread = RadiationConfig(dose_rate=10.0, dose=80.0), []
    for exposed in (RadiationConfig(), config):
        noise, found = SensorNoise(_WIDTH, _HEIGHT, 7), []
        for stamp in range(100):
            picture = np.full((_HEIGHT, _WIDTH, 4), grey, np.uint8)
            noise.age(picture, exposed)
            noise.add(picture, _NOISE, stamp)
            noise.irradiate(picture, exposed, stamp)
            found.append(float(picture[..., :3].std()))
        spread.append(float(np.mean(found)))
    return 20.0 * math.log10((1.0 - config.dose * config.loss) * spread[0] / spread[1])
