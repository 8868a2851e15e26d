"""Dead-man drills: what fails while a key is held and the robot drives, and what happens then."""

from __future__ import annotations

import contextlib
import math
import os
import random
import signal
import statistics
import time
from typing import Callable, Dict, Iterator, List, NamedTuple, Optional

from telex_experiments.console.rig import REPEAT_PERIOD, SPEED, TRACKS, ConsoleRig, settle
from telex_experiments.rigs.chromium import Chromium
from telex_experiments.rigs.network_namespace import NetworkNamespace
from telex_experiments.rigs.report import Figure, MeasurementError, wait_until

STOP_WITHIN = 0.35
"""Time (s) within which the belts have to be commanded to zero."""

WATCHED = 1.0
"""Time (s) for which nothing may move after the cut has ended, the key still being held."""

CUT = (0.5, 1.5)
"""Range of the length of a cut (s); long enough for old commands to pile up on the way."""

LONG_CUT = 4.5
"""Length (s) of every fifth cut of the network: the page gives the connection up meanwhile."""

CONNECTED = "document.getElementById('link').dataset.state === 'up'"
"""Expression on the console."""

TRIES = 5
"""Attempts at a drill, of which one has to find the robot driving."""

RESET_EVERY = 4
"""Drills after which the robot is put back to where it started."""


class DrillOutcome(NamedTuple):
    """What one drill has shown.

    Attributes
    ----------
    stopped
        Time (s) from the failure to the last change of the command for the belts, to zero; None
        if that did not come.
    stood
        Time (s) from the failure until the belts stood.
    way
        How far the robot came meanwhile (m).
    moved
        Whether anything moved after that before a new press.
    obeyed
        Whether a new press moved the robot.
    """

    stopped: Optional[float]
    stood: Optional[float]
    way: float
    moved: bool
    obeyed: bool


class DrillOperator:
    """Somebody at a console who drives; the browser may be lost under his hands.

    Parameters
    ----------
    network
        Through which the console reaches it; None for this machine's own.
    """

    def __init__(self, rig: ConsoleRig, network: Optional[NetworkNamespace] = None) -> None:
        self.rig = rig
        self.network = network
        self.browser = self._new_browser()
        self.tab = self.browser.open_tab()
        self.code = "KeyW"

    def _new_browser(self) -> Chromium:
        if self.network is None:
            return Chromium(self.rig.page())
        return Chromium(self.rig.page(self.network.address), self.network.before)

    def replace_browser(self) -> None:
        """Open the console anew, after the browser has been lost."""
        self.browser.close()
        self.browser = self._new_browser()
        settle(self.browser)
        self.tab = self.browser.open_tab()

    def close(self) -> None:
        """End the browser."""
        self.browser.close()

    def hold_until(self, what: str, condition: Callable[[], bool], timeout: float = 10.0) -> None:
        """Keep the key down, which the keyboard repeats, until something is so."""
        end = time.monotonic() + timeout
        while not condition():
            if time.monotonic() > end:
                raise MeasurementError(f"not within {timeout:g} s: {what}")
            self.browser.repeat(self.code)
            time.sleep(REPEAT_PERIOD)

    def hold_for(self, seconds: float) -> None:
        """Keep the key down for a while."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.browser.repeat(self.code)
            time.sleep(REPEAT_PERIOD)

    def speed_wanted(self) -> float:
        """Speed (m/s) that the present key means."""
        return SPEED if self.code == "KeyW" else -SPEED

    def drives(self) -> bool:
        """Whether the robot is at full speed."""
        wanted = self.speed_wanted()
        return abs(self.rig.wire.belt_speed - wanted) < 0.03 * SPEED

    def drive(self) -> None:
        """Press the key, and hold it until the robot is at full speed.

        A page that lets go, as it does when it stands still, gets another press.
        """
        for _ in range(5):
            self.browser.press(self.code)
            with contextlib.suppress(MeasurementError):
                self.hold_until("the robot to drive at full speed", self.drives, 3.0)
                return
            self.browser.release(self.code)
            time.sleep(0.4)
        log = self.browser.evaluate("[...document.querySelectorAll('#log li')].map((e) => e.title)")
        raise MeasurementError(f"the robot does not drive; the console says: {log}")

    def try_anew(self) -> bool:
        """Let the key go, press it once more, and tell whether the robot is told to move."""
        self.browser.release(self.code)
        time.sleep(0.35)
        since = time.monotonic()
        self.browser.press(self.code)
        end = since + 1.5
        while time.monotonic() < end:
            if any(each.value != 0.0 for each in self.rig.wire.heard(TRACKS, since)):
                self.browser.release(self.code)
                return True
            time.sleep(0.01)
        self.browser.release(self.code)
        return False

    def rest(self) -> None:
        """Wait until the robot stands."""
        wire = self.rig.wire
        wait_until(
            "the robot to stand",
            lambda: wire.last(TRACKS) == 0.0 and abs(wire.belt_speed) < 0.01,
            10.0,
        )


Drill = Callable[[DrillOperator], Iterator[None]]
"""Gets ready, goes on to break something, and then to mend it."""


def kill_browser(operator: DrillOperator) -> Iterator[None]:
    """All processes of the browser are killed."""
    browser = operator.browser
    pids = list(browser.processes())
    yield
    browser.signal(signal.SIGKILL, pids)
    yield
    operator.replace_browser()


def hide_tab(operator: DrillOperator) -> Iterator[None]:
    """Another tab is brought to the front."""
    yield
    operator.browser.show(operator.tab)
    yield
    operator.browser.show()
    time.sleep(0.2)


def freeze_page(operator: DrillOperator) -> Iterator[None]:
    """The browser freezes the page, as one that nobody has looked at for long, and thaws it."""
    browser = operator.browser
    yield
    browser.tell("Page.setWebLifecycleState", browser.session, state="frozen")
    yield
    browser.call("Page.setWebLifecycleState", state="active")
    # It counts as hidden until it is brought to the front.
    browser.show(operator.tab)
    time.sleep(0.1)
    browser.show()
    browser.wait_for("the console's connection", CONNECTED)


def stop_browser(operator: DrillOperator) -> Iterator[None]:
    """All processes of the browser stand still, as in a machine that hangs, and go on."""
    yield from _stop_and_wake(operator.browser, list(operator.browser.processes()))


def stop_page(operator: DrillOperator) -> Iterator[None]:
    """The page's process stands still, the browser does not."""
    processes = operator.browser.processes()
    pages = [pid for pid, kind in processes.items() if kind == "renderer"]
    yield from _stop_and_wake(operator.browser, pages)


def stop_main_process(operator: DrillOperator) -> Iterator[None]:
    """The browser's main process stands still, through which the keyboard is heard."""
    yield from _stop_and_wake(operator.browser, [operator.browser.pid])


def _stop_and_wake(browser: Chromium, pids: List[int]) -> Iterator[None]:
    yield
    browser.signal(signal.SIGSTOP, pids)
    yield
    browser.signal(signal.SIGCONT, pids)


def cut_network(operator: DrillOperator) -> Iterator[None]:
    """The cable is pulled out, and put in again."""
    network = operator.network
    if network is None:
        raise MeasurementError("the console does not stand in a network of its own")
    yield
    network.cut()
    yield
    network.mend()
    operator.browser.wait_for("the console's connection", CONNECTED)


def kill_bridge(operator: DrillOperator) -> Iterator[None]:
    """The bridge is killed; roslaunch starts it again."""
    bridge = operator.rig.bridge_pid
    yield
    os.kill(bridge, signal.SIGKILL)
    yield
    operator.rig.wait_for_another_bridge(bridge)
    operator.browser.wait_for("the console's connection", CONNECTED)


DRILLS: Dict[str, Drill] = {
    "browser killed": kill_browser,
    "tab hidden": hide_tab,
    "page frozen": freeze_page,
    "browser stopped and woken": stop_browser,
    "page's process stopped and woken": stop_page,
    "browser's main process stopped and woken": stop_main_process,
    "bridge killed": kill_bridge,
}
NETWORK_DRILL = "network cut"


def drill(operator: DrillOperator, break_it: Drill, cut: float) -> Optional[DrillOutcome]:
    """Drive at full speed, let something fail, and see; None if the robot did not drive then."""
    wire = operator.rig.wire
    operator.rest()
    wire.forget()
    story = break_it(operator)
    operator.drive()
    next(story)
    if wire.last(TRACKS) == 0.0:
        # The page has let go by itself just now, so there is nothing to stop.
        operator.browser.release(operator.code)
        return None
    broken, place = time.monotonic(), wire.place
    next(story)
    stood = None
    while time.monotonic() < broken + max(cut, STOP_WITHIN + 0.8):
        if stood is None and abs(wire.belt_speed) < 0.01:
            stood = time.monotonic() - broken
        time.sleep(0.005)
    way = math.dist(place, wire.place)
    with contextlib.suppress(StopIteration):
        next(story)
    # The operator has never let the key go.
    operator.hold_for(WATCHED)
    commands = wire.heard(TRACKS, broken)
    stopped = stop_of(commands, broken)
    moved = any(
        each.value != 0.0 and stopped is not None and each.at > broken + stopped
        for each in commands
    )
    moved = moved or abs(wire.belt_speed) > 0.02
    return DrillOutcome(stopped, stood, way, moved, operator.try_anew())


def stop_of(commands: List, broken: float) -> Optional[float]:
    """Time from a failure to the first zero among the commands that came after it."""
    for each in commands:
        if each.value == 0.0:
            return float(each.at - broken)
    return None


def repeat(operator: DrillOperator, name: str, break_it: Drill, times: int) -> List[Figure]:
    """Do a drill some times, forwards and backwards in turn, and count."""
    dice = random.Random(name)
    outcomes: List[DrillOutcome] = []
    for number in range(times):
        if number % RESET_EVERY == 0:
            operator.rest()
            operator.rig.reset()
        operator.code = ("KeyW", "KeyS")[number % 2]
        long_cut = break_it is cut_network and number % 5 == 4
        length = LONG_CUT if long_cut else dice.uniform(*CUT)
        tries = (drill(operator, break_it, length) for _ in range(TRIES))
        outcome = next((each for each in tries if each is not None), None)
        if outcome is None:
            raise MeasurementError(f"{name}: the page lets go by itself, again and again")
        outcomes.append(outcome)
        print(f"  {name} {number + 1} of {times}: {told(outcomes[-1])}", flush=True)
    return figures_of(name, outcomes)


def told(outcome: DrillOutcome) -> str:
    """What came of a drill, in words."""
    if outcome.stopped is None:
        return "NOT STOPPED"
    words = [f"stop after {outcome.stopped * 1e3:.0f} ms"]
    if outcome.stood is not None:
        words.append(f"at rest after {outcome.stood * 1e3:.0f} ms and {outcome.way:.2f} m")
    if outcome.moved:
        words.append("MOVED WITHOUT A NEW PRESS")
    if not outcome.obeyed:
        words.append("does not obey a new press")
    return ", ".join(words)


def figures_of(name: str, outcomes: List[DrillOutcome]) -> List[Figure]:
    """What is reported of a drill."""
    stops = sorted(each.stopped for each in outcomes if each.stopped is not None)
    in_time = sum(each <= STOP_WITHIN for each in stops)
    stood = [each.stood for each in outcomes if each.stood is not None]
    count = len(outcomes)
    figures = [
        Figure(f"{name}: belts commanded to zero within 0.35 s", in_time, f"of {count}", count),
        Figure(
            f"{name}: moved before a new press",
            sum(each.moved for each in outcomes),
            f"of {count}",
            at_most=0,
        ),
        Figure(
            f"{name}: obeys a new press",
            sum(each.obeyed for each in outcomes),
            f"of {count}",
            at_least=count,
        ),
    ]
    if stops:
        figures += [
            Figure(f"{name}: time to zero, median", statistics.median(stops) * 1e3, "ms"),
            Figure(f"{name}: time to zero, longest", stops[-1] * 1e3, "ms"),
        ]
    if stood:
        figures += [
            Figure(f"{name}: at rest after, longest", max(stood) * 1e3, "ms"),
            Figure(f"{name}: way, longest", max(each.way for each in outcomes), "m"),
        ]
    return figures


def drills(rig: ConsoleRig, times: int, names: Optional[List[str]] = None) -> List[Figure]:
    """Do all drills, each some times."""
    figures: List[Figure] = []
    chosen = [*DRILLS, NETWORK_DRILL] if names is None else names
    on_this_machine = [name for name in chosen if name in DRILLS]
    if on_this_machine:
        with contextlib.closing(DrillOperator(rig)) as operator:
            settle(operator.browser)
            for name in on_this_machine:
                figures += repeat(operator, name, DRILLS[name], times)
    if NETWORK_DRILL in chosen:
        figures += network_drills(rig, times)
    return figures


def network_drills(rig: ConsoleRig, times: int) -> List[Figure]:
    """Cut the network between console and robot."""
    if not NetworkNamespace.available():
        print(f"  {NETWORK_DRILL}: not done; only root can make a network namespace", flush=True)
        return [Figure(f"{NETWORK_DRILL}: drills done", 0, at_least=times)]
    with contextlib.ExitStack() as stack:
        network = stack.enter_context(NetworkNamespace())
        operator = stack.enter_context(contextlib.closing(DrillOperator(rig, network)))
        settle(operator.browser)
        return repeat(operator, NETWORK_DRILL, cut_network, times)
