"""Rates and ages of the pages' pictures while the robot stands, drives, climbs and grips.

The pages themselves count the pictures that they paint and how old they get; nothing is asked of
them, nor of the simulator, while that goes on. A picture is painted when it is on its canvas.
"""

from __future__ import annotations

import contextlib
import math
import statistics
import time
from typing import Any, Dict, Iterable, List, Mapping, NamedTuple, Sequence, Tuple

from telex_experiments.console.rig import REPEAT_PERIOD, ConsoleRig, have_large, settle
from telex_experiments.rigs.chromium import Chromium
from telex_experiments.rigs.private_master import descendants
from telex_experiments.rigs.report import PATIENCE, Figure
from telex_experiments.rigs.thread_times import (
    Share,
    Thread,
    idle_seconds,
    thread_name,
    threads,
    used,
)
from telex_teleop.web.video.websocket.feed import REMEMBERED

WINDOW = 10
"""Length (s) of the windows over which pictures are counted."""

SIZE = (1920, 1080)
OLDEST = 1.0
"""Age (s) that no picture may reach that is shown."""

REAL_TIME = 0.99
FRONT, OTHER, OVERVIEW = "front", "rear", "overview"
OVERVIEW_LIVE = "document.getElementById('view').dataset.state === 'live'"

Keys = Tuple[Tuple[str, ...], float]
"""Keys that are held together, and for how long (s)."""


class Phase(NamedTuple):
    """What is done while pictures are counted.

    Attributes
    ----------
    name
        What it is called.
    keys
        Held one after the other, again and again.
    world
        Scene in which it is done.
    large
        Camera that the operator has in the first view.
    layout
        Of his page.
    """

    name: str
    keys: Tuple[Keys, ...] = ()
    world: str = "training_hall"
    large: str = FRONT
    layout: str = "DRIVE"


PHASES = (
    Phase("standing"),
    Phase("another camera large", large=OTHER),
    Phase(
        "driving",
        ((("KeyW",), 2.5), (("KeyA",), 1.5), (("KeyS",), 2.5), (("KeyD",), 1.5)),
    ),
    Phase(
        "picking",
        (
            (("KeyJ", "KeyI", "Period"), 2.0),
            (("KeyO", "KeyK"), 2.0),
            (("Comma",), 1.5),
            (("KeyL", "KeyI"), 2.0),
            (("KeyU", "KeyK", "Period"), 2.0),
        ),
        layout="ARM",
    ),
    # Up the first steps with the front flippers raised, and down again.
    Phase(
        "climbing",
        (
            (("Digit3",), 2.0),
            (("KeyW", "Digit3"), 7.0),
            (("KeyW", "Digit1"), 4.0),
            (("KeyS", "Digit1"), 4.0),
        ),
        "stairs",
    ),
)


class OpenPages(NamedTuple):
    """Who looks, and how many pictures a second each view gets at least."""

    name: str
    large: float
    small: float
    overview: float


ALONE, BOTH = OpenPages("alone", 20.0, 8.0, 0.0), OpenPages("with instructor", 15.0, 6.0, 8.0)


def views(
    rig: ConsoleRig,
    seconds: float,
    phases: Sequence[Phase] = PHASES,
    everybody: Sequence[OpenPages] = (ALONE, BOTH),
) -> List[Figure]:
    """Measure phases for some time (s) each, for one page and for two."""
    figures: List[Figure] = []
    with contextlib.ExitStack() as stack:
        operator = stack.enter_context(Chromium(rig.page(), size=SIZE))
        settle(operator)
        for _ in range(6):  # 1.0 to about the share of the speed with which run.sh begins
            _hold(operator, ("Minus",), 0.05)
        for pages in everybody:
            browsers = {"operator": operator}
            if pages is BOTH:
                instructor = Chromium(rig.instructor_page, size=SIZE)
                browsers["instructor"] = stack.enter_context(instructor)
                instructor.wait_for("the overview", OVERVIEW_LIVE, PATIENCE)
            for phase in phases:
                print(f"  {phase.name}, {pages.name} ...", flush=True)
                figures += _measure(rig, browsers, pages, phase, seconds)
    return figures


def _measure(
    rig: ConsoleRig,
    browsers: Mapping[str, Chromium],
    pages: OpenPages,
    phase: Phase,
    seconds: float,
) -> List[Figure]:
    operator = browsers["operator"]
    rig.ask("/telex/sim/load_scene", world=phase.world)
    have_large(operator, phase.large, phase.layout)
    settle(operator)
    time.sleep(2.0)
    processes = _processes(rig, browsers)
    for browser in browsers.values():
        browser.evaluate_in_worker("takeTally()")
    clock = rig.clock()
    begun = time.monotonic()
    idle, before = idle_seconds(), threads(processes)
    _do(operator, phase.keys, begun + seconds)
    span = time.monotonic() - begun
    shares = used(before, threads(processes))
    idle = idle_seconds() - idle
    # What is asked after the end counts for none of the above.
    tallies = {
        name: browser.evaluate_in_worker("takeTally()") for name, browser in browsers.items()
    }
    now = rig.clock()
    factor = (now[1] - clock[1]) / (now[0] - clock[0])
    _print_stages(tallies)
    _print_threads(shares, span, idle)
    return _figures(pages, phase, tallies, factor)


def _hold(browser: Chromium, codes: Sequence[str], seconds: float) -> None:
    for code in codes:
        browser.press(code)
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        # A keyboard repeats the last key.
        time.sleep(REPEAT_PERIOD)
        browser.repeat(codes[-1])
    for code in codes:
        browser.release(code)


def _do(browser: Chromium, keys: Sequence[Keys], end: float) -> None:
    while time.monotonic() < end:
        if not keys:
            time.sleep(end - time.monotonic())
        for codes, seconds in keys:
            left = end - time.monotonic()
            if left > 0.0:
                _hold(browser, codes, min(seconds, left))


def _processes(rig: ConsoleRig, browsers: Mapping[str, Chromium]) -> Dict[int, str]:
    named = {pid: "other" for pid in descendants(rig.simulator.pid)}
    named.update({pid: name for name, pid in rig.simulator.processes().items()})
    for who, browser in browsers.items():
        for pid, kind in browser.processes().items():
            named[pid] = f"{who}'s {kind}"
    return named


# What came of it


def rates(seconds: Sequence[int], length: float) -> List[float]:
    """Return pictures per second in every window, from those of each whole second of a time (s)."""
    whole = math.floor(length)
    counts = [*seconds, *[0] * whole][:whole]
    window = min(WINDOW, whole)
    if window == 0:
        return []
    return [sum(counts[n : n + window]) / window for n in range(whole - window + 1)]


def slowest(tally: Mapping[str, Any], cameras: Iterable[str]) -> float:
    """Return the lowest of some cameras' 5th percentiles of the rates of all windows."""
    least = math.inf
    for name in cameras:
        camera = tally["cameras"].get(name, {"seconds": []})
        every = sorted(rates(camera["seconds"], tally["length"]))
        least = min(least, every[len(every) * 5 // 100] if every else 0.0)
    return least


def _figures(
    pages: OpenPages, phase: Phase, tallies: Mapping[str, Any], factor: float
) -> List[Figure]:
    title = f"{pages.name}, {phase.name}"
    operator = tallies["operator"]
    # A camera that has never come counts as well.
    names = {FRONT, "rear", "arm", "gripper", "turret", "mast"}
    small = slowest(operator, names - {phase.large})
    figures = [
        Figure(
            f"{title}: large view", slowest(operator, [phase.large]), "1/s", at_least=pages.large
        )
    ]
    if pages is BOTH:
        instructor = tallies["instructor"]
        small = min(small, slowest(instructor, names))
        overview = slowest(instructor, [OVERVIEW])
        figures.append(Figure(f"{title}: overview", overview, "1/s", at_least=pages.overview))
    oldest = max(
        camera["oldest"] for tally in tallies.values() for camera in tally["cameras"].values()
    )
    return [
        *figures,
        Figure(f"{title}: slowest small view", small, "1/s", at_least=pages.small),
        Figure(f"{title}: oldest picture", oldest * 1e-3, "s", at_most=OLDEST),
        Figure(f"{title}: real-time factor", factor, "", at_least=REAL_TIME),
    ]


def _print_stages(tallies: Mapping[str, Any]) -> None:
    print("    median ms from the pose to      server   sent  received  decoded  painted      age")
    for page, tally in tallies.items():
        for name, camera in sorted(tally["cameras"].items()):
            stages = stages_of(camera["last"], tally["served"].get(name))
            if stages:
                cells = "".join(f"{each:9.1f}" for each in stages)
                print(f"    {page + ', ' + name:28}{cells}", flush=True)


def stages_of(last: Sequence[Mapping[str, Any]], served: Any) -> List[float]:
    """Return how long (ms) pictures took from pose to server, to the sending, to the page, ...

    Parameters
    ----------
    last
        The newest pictures, as the page has noted them.
    served
        What the video server says of them; None: nothing.

    Returns
    -------
    stages
        Medians: until the server had it (drawn, encoded, published), until it was sent, received,
        decoded and painted, each from the one before, and all together. Empty where a part is
        not known.
    """
    # As many as the server speaks of.
    known = [each for each in last[-REMEMBERED:] if each["captured"] is not None]
    if not known or not served:
        return []

    def median(since: str, until: str) -> float:
        return statistics.median(each[until] - each[since] for each in known)

    made = served["made"] * 1e3
    sent = (served["age"] - served["round_trip"]) * 1e3
    return [
        made,
        sent - made,
        median("captured", "received") - sent,
        median("received", "decoded"),
        median("decoded", "painted"),
        median("captured", "painted"),
    ]


def _print_threads(shares: Mapping[Thread, Share], span: float, idle: float) -> None:
    print("    % of a core: running, waiting for a processor", flush=True)
    processes: Dict[Tuple[str, int], List[Tuple[Thread, Share]]] = {}
    for thread, share in shares.items():
        processes.setdefault(thread[:2], []).append((thread, share))
    every = [
        (sum(share.running for _, share in parts), sum(share.waiting for _, share in parts), parts)
        for parts in processes.values()
    ]
    for running, waiting, parts in sorted(every, key=lambda each: -each[0]):
        if running + waiting < 0.01 * span:
            continue
        main = ", ".join(
            f"{thread_name(thread)} {_percent(share, span)}"
            for thread, share in sorted(parts, key=lambda part: -part[1].running)[:4]
            if share.running + share.waiting >= 0.01 * span
        )
        name = parts[0][0][0]
        print(
            f"    {name:28}{100 * running / span:8.1f}{100 * waiting / span:8.1f}  {main}",
            flush=True,
        )
    print(f"    {'idle':28}{100 * idle / span:8.1f}", flush=True)


def _percent(share: Share, span: float) -> str:
    return f"{100 * share.running / span:.1f}/{100 * share.waiting / span:.1f}"
