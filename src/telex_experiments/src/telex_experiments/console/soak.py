"""Some clients watch and one drives for long, to see whether memory or delays grow."""

from __future__ import annotations

import contextlib
import json
import os
import statistics
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any, Dict, Iterator, List, NamedTuple

import rospy
from std_msgs.msg import Float64

from telex_control.common.child_processes import DIES_WITH_US
from telex_experiments.console.keys import Presses, listen_to_keys
from telex_experiments.console.rig import ConsoleRig
from telex_experiments.rigs.chromium import Chromium
from telex_experiments.rigs.private_master import end_tree
from telex_experiments.rigs.report import PATIENCE, Figure, MeasurementError

WATCHERS = 8
CLOCK_PERIOD = 0.02
"""Time (s) between two messages by which the watchers tell the bridge's delay."""

WARM_UP = 0.2
"""Part of the whole time that does not count: caches and buffers fill."""

LONG_ENOUGH = 300.0
"""Time (s) from which on a growth can be told from what comes and goes."""


class SoakSample(NamedTuple):
    """One second: memory of bridge and video server (MB), of the page's heap, and delays (ms)."""

    at: float
    bridge: float
    video: float
    heap: float
    delays: Dict[str, float]


class Watching:
    """The watchers' process, and the newest delays that it tells."""

    def __init__(self, rig: ConsoleRig) -> None:
        program = str(Path(__file__).with_name("watchers.py"))
        urls = (rig.bridge_url, rig.video_socket_url)
        self._process = subprocess.Popen(
            [*DIES_WITH_US, sys.executable, program, *urls, str(WATCHERS)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )
        self._told: List[Dict[str, List[float]]] = []
        self._lock = threading.Lock()
        threading.Thread(target=self._read, daemon=True).start()
        self._clock = rospy.Publisher("/benchmark/clock", Float64, queue_size=1, tcp_nodelay=True)
        self._ended = threading.Event()
        threading.Thread(target=self._tick, daemon=True).start()

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            with self._lock:
                self._told.append(json.loads(line))

    def _tick(self) -> None:
        while not self._ended.wait(CLOCK_PERIOD):
            self._clock.publish(time.monotonic())

    def delays(self) -> Dict[str, List[float]]:
        """Delays (s) since the last call."""
        if self._process.poll() is not None:
            raise MeasurementError("the watchers have ended")
        with self._lock:
            told, self._told = self._told, []
        return {
            name: [each for part in told for each in part[name]]
            for name in ("message", "answer", "picture")
        }

    def close(self) -> None:
        """End the watchers."""
        self._ended.set()
        end_tree(self._process)


def memory(pid: int) -> float:
    """Resident memory of a process (MB)."""
    with open(f"/proc/{pid}/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6


def growth(times: List[float], values: List[float]) -> float:
    """How much a straight line through some values rises from the first time to the last."""
    if len(times) < 2:
        return 0.0
    middle, mean = statistics.fmean(times), statistics.fmean(values)
    spread = sum((t - middle) ** 2 for t in times)
    slope = sum((t - middle) * (v - mean) for t, v in zip(times, values)) / spread
    return slope * (times[-1] - times[0])


def heap(browser: Chromium) -> float:
    """What the page's scripts hold (MB)."""
    browser.call("Performance.enable")
    metrics = browser.call("Performance.getMetrics")["metrics"]
    return float(next(each["value"] for each in metrics if each["name"] == "JSHeapUsedSize") / 1e6)


def samples(
    rig: ConsoleRig, browser: Chromium, watching: Watching, seconds: float
) -> Iterator[SoakSample]:
    """Drive to and fro for a while, and tell of every second."""
    presses = Presses(rig, browser)
    bridge, video = rig.bridge_pid, rig.video_pid
    begun = time.monotonic()
    collected: Dict[str, List[float]] = {}
    told = begun
    while time.monotonic() < begun + seconds:
        presses.do("KeyW", 0.4)
        presses.do("KeyS", 0.4)
        for name, values in watching.delays().items():
            collected.setdefault(name, []).extend(values)
        callback, command = presses.take()
        collected.setdefault("teleop", []).extend(callback)
        collected.setdefault("command", []).extend(command)
        if all(collected.values()):
            delays = {name: statistics.median(values) * 1e3 for name, values in collected.items()}
            now = time.monotonic()
            yield SoakSample(now - begun, memory(bridge), memory(video), heap(browser), delays)
            collected = {}
            if now - told > 30.0:
                told = now
                print(f"  {now - begun:.0f} of {seconds:.0f} s", flush=True)
        elif time.monotonic() - told > PATIENCE:
            lacking = ", ".join(name for name, values in collected.items() if not values)
            raise MeasurementError(f"the watchers and the operator told nothing of: {lacking}")


def soak(rig: ConsoleRig, seconds: float) -> List[Figure]:
    """Let it run, and report."""
    with rig.browser() as browser, contextlib.closing(Watching(rig)) as watching:
        listen_to_keys(browser)
        time.sleep(2.0)
        watching.delays()
        every = list(samples(rig, browser, watching, seconds))
    return figures_of(every, seconds)


def figures_of(every: List[SoakSample], seconds: float) -> List[Figure]:
    """What is reported; growth is required to be none only where it can be told."""
    counted = [each for each in every if each.at >= WARM_UP * seconds]
    if len(counted) < 2:
        raise MeasurementError(f"{len(counted)} samples came in {seconds:g} s; too few to compare")
    times = [each.at for each in counted]
    long = seconds >= LONG_ENOUGH
    title = f"{WATCHERS} watch, one drives"
    figures = [Figure(f"{title}: duration", seconds, "s")]

    def add(name: str, values: List[float], unit: str, limit: Any) -> None:
        figures.append(Figure(f"{title}: {name}", statistics.median(values), unit))
        at_most = limit if long else None
        grown = growth(times, values)
        figures.append(Figure(f"{title}: {name}, grows by", grown, unit, at_most=at_most))

    add("memory of the bridge", [each.bridge for each in counted], "MB", 2.0)
    add("memory of the video server", [each.video for each in counted], "MB", 2.0)
    add("heap of the page's scripts", [each.heap for each in counted], "MB", None)
    for key, name, limit in (
        ("message", "a message over the bridge", 5.0),
        ("answer", "an answer of the bridge", 5.0),
        ("picture", "age of a picture on arrival", 10.0),
        ("teleop", "key to teleop callback", 5.0),
        ("command", "key to controller command", 5.0),
    ):
        add(f"{name}, median", [each.delays[key] for each in counted], "ms", limit)
    return figures
