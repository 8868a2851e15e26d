"""Runs experiments, each in a process of its own, and tells how it goes."""

from __future__ import annotations

import contextlib
import os
import queue
import signal
import subprocess
import sys
import threading
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Callable, Dict, Iterator, List, Optional, Sequence, Set, TextIO

from telex_control.common.child_processes import DIES_WITH_US
from telex_experiments.rigs.private_master import end_tree

from .experiment import Experiment, Result, missing
from .one import RESULT

PATIENCE = 4.0
"""An experiment is ended after this many times what it is expected to take, and `GRACE`."""
GRACE = 300.0  # s, for a machine that has other things to do
STOP_TIMEOUT = 20.0
"""Time (s) that an experiment gets to end what it has started."""
Say = Callable[[str], None]


@dataclass(frozen=True)
class ExperimentOutcome:
    """A result, and how long it took.

    Attributes
    ----------
    seconds : float
        Of wall time.
    """

    experiment: Experiment
    result: Result
    seconds: float


def planned(experiments: Sequence[Experiment], quick: bool, repeat: int = 1) -> float:
    """Wall time (s) that experiments are expected to take: the longer one of the two lanes."""
    lanes = {True: 0.0, False: 0.0}
    for experiment in experiments:
        lanes[experiment.in_wall_time] += experiment.expected(quick, repeat)
    return max(lanes.values())


class Schedule:
    """Two lanes: what drives a simulator, one after the other, and beside it what computes only.

    Parameters
    ----------
    folder : Path
        Of the results; each experiment gets a folder in it.
    say : callable
        Takes a line of progress.
    repeat : int
        Runs of experiments that are `repeatable`.
    """

    def __init__(self, folder: Path, quick: bool, seed: int, say: Say, repeat: int = 1) -> None:
        self._folder = folder
        self._quick = quick
        self._seed = seed
        self._say = say
        self._repeat = repeat
        self._stopped = threading.Event()
        self._running: Dict[str, subprocess.Popen] = {}
        # What only computes, while it runs; and whether it has to stand still.
        self._computing: Set[subprocess.Popen] = set()
        self._held = False
        self._lock = threading.Lock()

    def run(self, experiments: Sequence[Experiment]) -> List[ExperimentOutcome]:
        """Run experiments; their outcomes come in the given order.

        Interrupted, it ends what runs, and everything that was started by it.
        """
        outcomes: Dict[str, ExperimentOutcome] = {}
        ended: queue.Queue = queue.Queue()

        def lane(members: Sequence[Experiment]) -> None:
            try:
                for experiment in members:
                    if self._stopped.is_set():
                        break
                    outcomes[experiment.name] = self._run_one(experiment)
            except BaseException as error:
                ended.put(error)
            else:
                ended.put(None)

        threads = [
            threading.Thread(
                target=lane, args=([e for e in experiments if e.in_wall_time == kind],)
            )
            for kind in (True, False)
        ]
        for thread in threads:
            thread.start()
        try:
            for _ in threads:
                # Without a timeout, a signal would have to wait for the lanes.
                error: Optional[BaseException] = _take(ended)
                if error is not None:
                    raise error
        finally:
            self._stop()
            for thread in threads:
                thread.join()
        return [outcomes[experiment.name] for experiment in experiments]

    def _stop(self) -> None:
        self._stopped.set()
        with self._lock:
            running = list(self._running.values())
        for process in running:
            end_tree(process, STOP_TIMEOUT)

    def _run_one(self, experiment: Experiment) -> ExperimentOutcome:
        folder = self._folder / experiment.name
        folder.mkdir(parents=True, exist_ok=True)
        expected = experiment.expected(self._quick, self._repeat)
        self._say(f"{experiment.name}: {experiment.title} (about {_minutes(expected)})")
        began = time.monotonic()
        with self._quiet() if experiment.alone else contextlib.nullcontext():
            result = self._carry_out(experiment, folder, PATIENCE * expected + GRACE)
        for table in result.tables:
            (folder / table.file).write_text(table.as_csv(), encoding="utf-8")
        seconds = time.monotonic() - began
        verdict = "ok" if result.ok else f"MISSED {_why(result)}"
        self._say(f"{experiment.name}: {verdict} ({_minutes(seconds)})")
        return ExperimentOutcome(experiment, result, seconds)

    def _carry_out(self, experiment: Experiment, folder: Path, timeout: float) -> Result:
        command = [
            *DIES_WITH_US,
            sys.executable,
            "-m",
            "telex_experiments.paper.one",
            experiment.name,
            str(folder),
        ]
        command += [str(self._seed), "--repeat", str(self._repeat)]
        command += ["--quick"] if self._quick else []
        with open(folder / "log.txt", "w") as log, self._lock:
            if self._stopped.is_set():
                return missing("interrupted")
            process = subprocess.Popen(
                command,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=log,
                text=True,
                start_new_session=True,
            )
            self._running[experiment.name] = process
            if not experiment.in_wall_time:
                self._computing.add(process)
                if self._held:
                    os.killpg(process.pid, signal.SIGSTOP)
        if process.stdout is None:
            raise RuntimeError("no pipe from the experiment")
        teller = threading.Thread(target=self._tell, args=(experiment.name, process.stdout))
        teller.start()
        late = False
        try:
            process.wait(timeout)
        except subprocess.TimeoutExpired:
            late = True
        finally:
            # In any case: nothing that it has started may stay.
            if not self._stopped.is_set():
                end_tree(process, STOP_TIMEOUT)
            teller.join()
            with self._lock:
                del self._running[experiment.name]
                self._computing.discard(process)
        if late:
            return missing(
                f"ended after {_minutes(timeout)}: it should have taken a quarter of that, or less"
            )
        file = folder / RESULT
        if not file.exists():
            end = "".join((folder / "log.txt").read_text(errors="replace").splitlines(True)[-5:])
            return missing(f"its process ended with status {process.returncode}: {end.strip()}")
        return Result.from_json(file.read_text(encoding="utf-8"))

    @contextlib.contextmanager
    def _quiet(self) -> Iterator[None]:
        """Let what only computes stand still meanwhile."""
        self._hold(True)
        try:
            yield
        finally:
            self._hold(False)

    def _hold(self, held: bool) -> None:
        with self._lock:
            self._held = held
            for process in self._computing:
                with contextlib.suppress(ProcessLookupError):
                    os.killpg(process.pid, signal.SIGSTOP if held else signal.SIGCONT)

    def _tell(self, name: str, lines: TextIO) -> None:
        with contextlib.suppress(ValueError):
            for line in lines:
                self._say(f"{name}: {line.rstrip()}")


def _take(ended: queue.Queue) -> Optional[BaseException]:
    while True:
        with contextlib.suppress(queue.Empty):
            item: Optional[BaseException] = ended.get(timeout=0.5)
            return item


def _why(result: Result) -> str:
    if result.error:
        return f"({result.error.splitlines()[0]})"
    if not result.missed:
        return "(it has no bar)"
    return "(" + ", ".join(f"{f.name}: {f.value:.4g} {f.unit}" for f in result.missed[:3]) + ")"


def _minutes(seconds: float) -> str:
    whole = round(seconds)
    return f"{whole // 60} min {whole % 60:02d} s" if whole >= 60 else f"{whole} s"
