"""Distribution of the tests among pytest-xdist's workers (``-n 3 --dist loadgroup``).

What needs a ROS master, a browser or wall time and works the machine hard runs one after the other
in one worker; what needs them and mostly waits, in a second one. The other workers meanwhile run
what depends on no clock, at low priority: that may wait, and the rest may not. Without ``-n``, all
tests run one after the other.

Marks say which is which; each file has its own. What the CPU time of a file says otherwise is told
at the end of a run.
"""

from __future__ import annotations

import os
import re
import time
from collections import defaultdict
from functools import lru_cache
from pathlib import Path
from typing import DefaultDict, Iterator, List, Optional, Set

import pytest
from hypothesis import HealthCheck, settings

pytest_plugins = ["own_ros"]

# How long an example takes says nothing on a machine that has other things to do.
settings.register_profile("telex", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("telex")

ROOT = Path(__file__).resolve().parent
NEEDS_THE_MACHINE = ("ros", "browser", "real_time")
"""Markers of tests that others may not hold up."""
HEAVY, LIGHT = "real_time", "waiting"
"""Lanes of such tests: one after the other in each."""
SLOW = 3.0
"""CPU time (s) from which on a file is to be marked slow, which ``test.sh --fast`` leaves out."""
NOT_SLOW = 1.5
"""CPU time (s) up to which a file is not to be marked so."""
LONGEST_CHECK = 900.0
"""For which checks beside the tests are waited for once all tests have ended (s)."""
PATIENCE = 15
"""Niceness of a worker from its first test that can wait."""


def in_a_worker() -> bool:
    """Whether this is one of the processes among which the tests are distributed."""
    return "PYTEST_XDIST_WORKER" in os.environ


def needs_the_machine(item: pytest.Item) -> bool:
    """Whether a test has to go on in wall time."""
    return any(item.get_closest_marker(name) for name in NEEDS_THE_MACHINE)


def group_of(item: pytest.Item) -> str:
    """Return a name that tests share which one worker runs one after the other."""
    if needs_the_machine(item):
        return LIGHT if item.get_closest_marker("waiting") else HEAVY
    # Files are not torn apart: their tests share costly fixtures.
    return item.nodeid.split("::", 1)[0]


def pytest_configure(config: pytest.Config) -> None:
    """Let xdist hand out the groups in our order."""
    if hasattr(config.option, "loadscopereorder"):  # of xdist 3.8, which needs Python 3.9
        config.option.loadscopereorder = False
    config.pluginmanager.register(CpuTimes())
    beside = os.environ.get("TELEX_CHECKS_BESIDE")
    if beside and not in_a_worker():
        config.pluginmanager.register(ChecksBeside(Path(beside)))


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> Optional[bool]:
    """Leave out, without importing it, a file whose own marks ``-m "not (...)"`` leaves out."""
    left_out = re.fullmatch(r"not \(([\w ]+)\)", config.option.markexpr)
    if left_out is None or collection_path.suffix != ".py" or not collection_path.is_file():
        return None
    own = re.search(r"^pytestmark = (\[\n.*?^\]|.*?$)", collection_path.read_text(), re.M | re.S)
    marks = re.findall(r"pytest\.mark\.(\w+)", own.group(1)) if own else []
    return True if set(marks) & set(left_out.group(1).split(" or ")) else None


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: List[pytest.Item]) -> None:
    """Begin with the tests that need the machine; keep those together that share a worker."""
    groups = {item: group_of(item) for item in items}
    for item, group in groups.items():
        item.add_marker(pytest.mark.xdist_group(group))
    # A worker that has once stepped back cannot come forward again for these.
    first = {HEAVY: 0, LIGHT: 1}
    items.sort(key=lambda item: first.get(groups[item], 2))


@lru_cache(maxsize=None)
def step_back() -> None:
    """Lower the priority of this process, once: it cannot be raised again.

    It gets a session of its own: the nodes of a launch have theirs, and Linux shares the processors
    among sessions first.
    """
    from telex_control.common.scheduling import add_niceness as lower

    os.setsid()
    lower(PATIENCE)


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    """Step back before the first test that can wait."""
    if in_a_worker() and not needs_the_machine(item):
        step_back()


class CpuTimes:
    """CPU time of each file, children that have ended included."""

    def __init__(self) -> None:
        self.of_file: DefaultDict[str, float] = defaultdict(float)
        self.marked: Set[str] = set()
        self._before = cpu_time()

    def pytest_collection_finish(self) -> None:
        """Begin to count: what importing takes is nobody's alone."""
        self._before = cpu_time()

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(self, item: pytest.Item) -> Iterator[None]:
        """Note in each report what its phase took; another worker's process may print it."""
        report = yield
        now = cpu_time()
        report.cpu_time, self._before = now - self._before, now
        report.marked_slow = item.get_closest_marker("slow") is not None
        report.in_wall_time = needs_the_machine(item)
        return report

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Add up; and name tests without the group that xdist appends, to be run again by it."""
        if in_a_worker():
            return
        file = report.nodeid.split("::", 1)[0]
        name, _, group = report.nodeid.rpartition("@")
        if group in (HEAVY, LIGHT, file):
            report.nodeid = name
        if not getattr(report, "in_wall_time", True):
            self.of_file[file] += report.cpu_time
            if report.marked_slow:
                self.marked.add(file)

    def pytest_terminal_summary(
        self, terminalreporter: pytest.TerminalReporter, exitstatus: int
    ) -> None:
        """Name the files whose mark says what is not so."""
        config = terminalreporter.config
        less = config.option.keyword or any("::" in each for each in config.args)
        if less or exitstatus != pytest.ExitCode.OK:
            return  # these were not whole files
        for file, seconds in sorted(self.of_file.items(), key=lambda each: -each[1]):
            if seconds > SLOW and file not in self.marked:
                terminalreporter.line(f"{file} took {seconds:.1f} s of CPU time: mark it slow")
            elif seconds < NOT_SLOW and file in self.marked:
                terminalreporter.line(f"{file} took {seconds:.1f} s of CPU time: it is not slow")
        if config.option.durations:
            terminalreporter.section(f"slowest {config.option.durations} files in CPU time")
            slowest = sorted(self.of_file.items(), key=lambda each: -each[1])
            for file, seconds in slowest[: config.option.durations]:
                terminalreporter.line(f"{seconds:6.2f} s {file}")
            terminalreporter.line(f"{sum(self.of_file.values()):6.2f} s in all files")


class ChecksBeside:
    """Tells how the checks went that ``test.sh`` runs beside the tests.

    Of each there is ``NAME.title``, ``NAME.out`` with what it says and, once it has ended,
    ``NAME.end`` with its exit status and how long it took (s).
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    @pytest.hookimpl(trylast=True)
    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        """Wait for each; print what it says where something is wrong."""
        latest = time.monotonic() + LONGEST_CHECK
        for title in sorted(self._folder.glob("*.title")):
            end, name = title.with_suffix(".end"), title.read_text().strip()
            while not end.exists() and time.monotonic() < latest:
                time.sleep(0.2)
            status, took = end.read_text().split() if end.exists() else ("has not ended", "?")
            if status == "0":
                terminalreporter.line(f"{name}: ok ({took} s)")
                continue
            terminalreporter.section(f"{name}: FAILED, {status} ({took} s)", red=True)
            terminalreporter.line(title.with_suffix(".out").read_text())


def cpu_time() -> float:
    """Return the CPU time (s) of this process and of its children that have ended."""
    return sum(os.times()[:4])
