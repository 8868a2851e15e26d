"""From a key in the browser to the robot: how long it takes."""

from __future__ import annotations

import random
import statistics
import time
from typing import Dict, List, NamedTuple, Optional, Tuple

from telex_experiments.console.rig import (
    DRIVE,
    JOG,
    LIVE,
    TRACKS,
    TURRET,
    ConsoleRig,
    Heard,
    have_large,
)
from telex_experiments.rigs.chromium import Chromium
from telex_experiments.rigs.report import Figure, MeasurementError

HELD = 0.12
"""Time (s) for which a key is held."""

PAUSE = (0.45, 0.55)
"""Range of the pause (s) after a key is let go; even ones would keep step with the loops' ticks."""

CHANGED = 1e-9
"""Change of a controller's command from which on it is another one."""

WITHIN = 0.4
"""Longest time (s) after a press at which something can still be its effect."""


class EffectPath(NamedTuple):
    """Which topics a key's effect passes: to the teleoperation node, and to the controller."""

    teleop: str
    controller: str


EFFECT_PATHS: Dict[str, EffectPath] = {
    "KeyW": EffectPath(DRIVE, TRACKS),
    "KeyS": EffectPath(DRIVE, TRACKS),
    "KeyJ": EffectPath(JOG, TURRET),
    "KeyL": EffectPath(JOG, TURRET),
}


def listen_to_keys(browser: Chromium) -> None:
    """Let the page note when a key was pressed, by the clock of its events."""
    browser.evaluate(
        """
        if (window.benchmarkPresses === undefined) {
          addEventListener("keydown", ({ repeat, timeStamp }) => {
            if (!repeat) benchmarkPresses.push(timeStamp);
          }, { capture: true });
        }
        window.benchmarkPresses = [];
        """
    )


class Presses:
    """Presses keys on the console, and finds out what came of each.

    Parameters
    ----------
    browser
        The console, listening to keys.
    """

    def __init__(self, rig: ConsoleRig, browser: Chromium) -> None:
        self._wire = rig.wire
        self._browser = browser
        self._codes: List[str] = []
        self._dice = random.Random(8)
        self.missed = 0
        self.uncertainty = 0.0
        """Largest error (s) by which the page's clock may have been mistaken."""

    def do(self, code: str, held: float = HELD) -> None:
        """Press a key, let it go, and pause."""
        self._browser.press(code)
        time.sleep(held)
        self._browser.release(code)
        time.sleep(self._dice.uniform(*PAUSE))
        self._codes.append(code)

    def take(self) -> Tuple[List[float], List[float]]:
        """Return the times (s) from each press to the teleop callback and to the controller."""
        offset, uncertainty = self._browser.clock()
        self.uncertainty = max(self.uncertainty, uncertainty)
        stamps = self._browser.evaluate("benchmarkPresses.splice(0)")
        codes, self._codes = self._codes, []
        if len(stamps) != len(codes):
            raise MeasurementError(f"of {len(codes)} presses the page has heard {len(stamps)}")
        callbacks, commands = [], []
        for code, stamp in zip(codes, stamps):
            pressed = stamp / 1e3 + offset
            callback = self._first_motion(EFFECT_PATHS[code].teleop, pressed)
            command = self._first_change(EFFECT_PATHS[code].controller, pressed)
            if callback is None or command is None:
                self.missed += 1
                continue
            callbacks.append(callback - pressed)
            commands.append(command - pressed)
        self._wire.forget()
        return callbacks, commands

    def _first_motion(self, topic: str, pressed: float) -> Optional[float]:
        for each in self._after(topic, pressed):
            if each.value != 0.0:
                return each.at
        return None

    def _first_change(self, topic: str, pressed: float) -> Optional[float]:
        before = [each.value for each in self._wire.heard(topic) if each.at < pressed]
        rest = before[-1] if before else 0.0
        for each in self._after(topic, pressed):
            if abs(each.value - rest) > CHANGED:
                return each.at
        return None

    def _after(self, topic: str, pressed: float) -> List[Heard]:
        return [each for each in self._wire.heard(topic, pressed) if each.at < pressed + WITHIN]


def latency(rig: ConsoleRig, presses: int) -> List[Figure]:
    """Press keys while six views are live."""
    with rig.browser() as browser:
        have_large(browser, "front", "ARM")
        listen_to_keys(browser)
        time.sleep(2.0)
        rig.wire.forget()
        operator = Presses(rig, browser)
        times: Dict[str, Tuple[List[float], List[float]]] = {}
        for first, second in (("KeyW", "KeyS"), ("KeyJ", "KeyL")):
            for _ in range((presses + 3) // 4):
                operator.do(first)
                operator.do(second)
            times[first] = operator.take()
            print(f"  {first[3:]} and {second[3:]}: {len(times[first][0])} presses", flush=True)
        browser.wait_for("six views that are still live", LIVE, 10.0)
    return figures_of(times, operator)


def figures_of(
    times: Dict[str, Tuple[List[float], List[float]]], operator: Presses
) -> List[Figure]:
    """What is reported."""
    callbacks = sorted(each for callback, _ in times.values() for each in callback)
    commands = sorted(each for _, command in times.values() for each in command)
    if not callbacks:
        raise MeasurementError("no press has reached the robot")
    figures = [
        Figure("key: presses", len(callbacks) + operator.missed),
        Figure("key: presses without effect", operator.missed, at_most=0),
        *_spread("key down to teleop callback", callbacks, 5.0, 15.0),
        *_spread("key down to controller command", commands, 25.0, 45.0),
    ]
    for code, name in (("KeyW", "tracks"), ("KeyJ", "turret")):
        command = sorted(times[code][1])
        if command:
            median = statistics.median(command) * 1e3
            figures.append(Figure(f"key down to controller command, {name}: median", median, "ms"))
    uncertainty = operator.uncertainty * 1e3
    return [*figures, Figure("page's clock: uncertain by", uncertainty, "ms", at_most=1.0)]


def _spread(name: str, values: List[float], median: float, most: float) -> List[Figure]:
    return [
        Figure(f"{name}: median", statistics.median(values) * 1e3, "ms", at_most=median),
        Figure(f"{name}: 95 %", values[len(values) * 95 // 100] * 1e3, "ms", at_most=most),
        Figure(f"{name}: longest", values[-1] * 1e3, "ms"),
    ]
