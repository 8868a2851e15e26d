"""Jobs in processes: results, errors, lost processes, a scheduler of many machines."""

from __future__ import annotations

import itertools
import os
import socket
from pathlib import Path
from typing import Any, Dict, List, Optional, Sequence

import pytest
from rehearsal_jobs import RELEASED, work

from telex_training.rehearsal import crew
from telex_training.rehearsal.crew import CrewError, LostError, do_elsewhere, do_here

distributed = pytest.importorskip("distributed")

pytestmark = pytest.mark.slow

SOURCES = "0" * 64


def small_cluster() -> Any:
    """Make a scheduler and a worker in this process."""
    return distributed.LocalCluster(
        n_workers=1,
        threads_per_worker=1,
        processes=False,
        dashboard_address=None,
        protocol="tcp://",
        host="127.0.0.1",
    )


class Told:
    """What was told of the jobs."""

    def __init__(self) -> None:
        self.results: Dict[str, Optional[str]] = {}
        self.errors: Dict[str, Exception] = {}
        self.count = 0

    def __call__(self, job: str, result: Optional[str], error: Optional[Exception]) -> None:
        self.count += 1
        if error is None:
            self.results[job] = result
        else:
            self.errors[job] = error


class TestHere:
    def here(self, jobs: Sequence[str], workers: int = 2) -> Told:
        told = Told()
        do_here(jobs, work, workers, told)
        assert told.count == len(jobs)
        return told

    def test_each_job_is_told_its_result_or_its_error(self) -> None:
        told = self.here(["double a", "raise no such wall", "stick no way", "double b"])
        assert told.results == {"double a": "aa", "double b": "bb"}
        assert isinstance(told.errors["raise no such wall"], ValueError)
        assert str(told.errors["raise no such wall"]) == "no such wall"
        # Whose kind cannot be made again of what pickle keeps: in words.
        assert isinstance(told.errors["stick no way"], crew.WorkError)
        assert str(told.errors["stick no way"]) == "rehearsal_jobs.StubbornError: wall: no way"

    def test_a_lost_process_costs_no_job(self, tmp_path: Path) -> None:
        once = tmp_path / "once"
        once.touch()
        jobs = [f"die {once} 1", *(f"double {n}" for n in range(4))]
        told = self.here(jobs)
        assert not told.errors
        assert told.results[jobs[0]] == "x"
        assert [told.results[f"double {n}"] for n in range(4)] == ["00", "11", "22", "33"]

    def test_a_job_that_loses_every_process_is_given_up(self, tmp_path: Path) -> None:
        always = tmp_path / "always"
        always.touch()
        told = self.here([f"die {always} 99", "double a"])
        assert isinstance(told.errors[f"die {always} 99"], LostError)
        assert always.read_text() == crew.TRIES * "x"
        assert told.results == {"double a": "aa"}

    def test_the_environment_is_as_before(self) -> None:
        before = dict(os.environ)
        self.here(["double a"], 1)
        assert dict(os.environ) == before

    def test_no_jobs_need_no_process(self) -> None:
        assert self.here([]).results == {}


class TestElsewhere:
    @pytest.fixture
    def warnings(self) -> List[str]:
        return []

    def elsewhere(self, warnings: List[str], jobs: Sequence[str]) -> Told:
        told = Told()
        with small_cluster() as cluster:
            do_elsewhere(jobs, work, cluster.scheduler_address, told, warnings.append)
        return told

    def test_workers_do_the_jobs(
        self, warnings: List[str], monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr(crew, "software_digest", lambda: SOURCES)
        told = self.elsewhere(warnings, ["double a", "raise at a wall"])
        assert told.results == {"double a": "aa"}
        assert str(told.errors["raise at a wall"]) == "at a wall"
        assert warnings == []

    def test_a_worker_with_other_sources_that_comes_later_is_refused(
        self, warnings: List[str], monkeypatch: pytest.MonkeyPatch
    ) -> None:
        # Asked twice before the jobs: there, and here.
        digests = itertools.chain([SOURCES] * 2, itertools.repeat("1" * 64))
        monkeypatch.setattr(crew, "software_digest", lambda: next(digests))
        with pytest.raises(CrewError, match="has other sources than this machine"):
            self.elsewhere(warnings, ["double a"])

    def test_a_scheduler_that_is_lost_is_said(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(crew, "software_digest", lambda: SOURCES)
        RELEASED.clear()
        with small_cluster() as cluster:

            def lose(job: str, result: Any, error: Any) -> None:
                # Not the cluster, which waits for the other job; nor is it to close it again.
                cluster.sync(cluster.scheduler.close)
                cluster.shutdown_scheduler = False

            address = cluster.scheduler_address
            lost = f"scheduler {address}: the connection was lost"
            try:
                with pytest.raises(CrewError, match=lost):
                    do_elsewhere(["double a", "wait"], work, address, lose, print)
            finally:
                RELEASED.set()

    @pytest.mark.parametrize("address", ["", "nonsense", "http://a:1", "tcp://a", "tcp://a:99999"])
    def test_what_is_no_address_is_refused(self, warnings: List[str], address: str) -> None:
        with pytest.raises(CrewError, match="tcp://HOST:8786"):
            do_elsewhere(["double a"], work, address, Told(), warnings.append)

    def test_nobody_at_the_address_is_said(self, warnings: List[str]) -> None:
        with socket.socket() as bound:  # which does not listen
            bound.bind(("127.0.0.1", 0))
            address = f"tcp://127.0.0.1:{bound.getsockname()[1]}"
            with pytest.raises(CrewError, match=f"scheduler {address}: .*refused"):
                do_elsewhere(["double a"], work, address, Told(), warnings.append)


def about(**changes: str) -> Dict[str, str]:
    return {
        "sources": SOURCES,
        "wheels": "numpy 1",
        "Python": "3.11.2",
        "processor": "A",
        **changes,
    }


class TestCompare:
    """Whether machines may help each other."""

    def compare(self, found: Dict[str, Any]) -> List[str]:
        warnings: List[str] = []
        crew.compare(found, about(), "tcp://a:1", warnings.append)
        return warnings

    def test_no_workers_are_said_with_the_remedy(self) -> None:
        with pytest.raises(CrewError, match="dask worker tcp://a:1"):
            self.compare({})

    def test_other_sources_are_refused(self) -> None:
        with pytest.raises(CrewError, match="worker w2 has other sources"):
            self.compare({"w1": about(), "w2": about(sources="1" * 64)})

    def test_other_processors_and_wheels_are_warned_of(self) -> None:
        warned = self.compare({"w1": about(processor="B", wheels="numpy 2")})
        assert len(warned) == 2
        assert "numpy 1; numpy 2" in warned[0]
        assert "A; B" in warned[1]
        assert self.compare({"w1": about()}) == []
