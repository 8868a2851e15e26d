"""What axe-core finds about pages of the training that need no simulator."""

from __future__ import annotations

import contextlib
import functools
import http.server
import threading
from pathlib import Path

import axe
import pytest
from recorded_trials import record

from telex_experiments.classroom.class_server import ClassServer
from telex_experiments.classroom.stand_in_station import StandInStation, beside
from telex_experiments.rigs.chromium import Chromium, lacking
from telex_training.progress.curriculum_file import curricula, load_curriculum
from telex_training.progress.reports.class_report import class_report
from telex_training.progress.reports.person_report import person_report
from telex_training.progress.trial_facts import read_trial

PAGES = Path(__file__).resolve().parents[1] / "src/telex_training/pages"

pytestmark = [
    pytest.mark.browser,
    pytest.mark.skipif(bool(lacking() or axe.lacking()), reason=lacking() or axe.lacking()),
]

STATE = {
    "phase": "running",
    "title": "Slalom",
    "setting": "day",
    "mode": "practice",
    "operator": "ann",
    "holder": "ann",
    "repetition": 1,
    "repetitions": 3,
    "results": ["touched a cone"],
    "elapsed": 12.0,
    "steps": ["out", "back"],
    "steps_done": [True, False],
    "faults": ["touched a cone"],
    "help": 42.0,
}


class _Quiet(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *_arguments):
        pass


@contextlib.contextmanager
def served(folder):
    """Address of the files of a folder."""
    handler = functools.partial(_Quiet, directory=str(folder))
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()


@pytest.fixture(scope="module")
def look():
    with Chromium("about:blank", size=(1280, 840)) as browser:

        def look(address, shown):
            browser.call("Page.navigate", url=address)
            browser.wait_for("the page", shown)
            return axe.findings(lambda script: browser.evaluate(f"(() => {{ {script} }})()"))

        yield look


def test_the_class(look):
    stations = [StandInStation([STATE]), StandInStation([{"phase": "idle"}])]
    with beside(stations):
        addresses = {f"station {number}": each.address for number, each in enumerate(stations)}
        with ClassServer(addresses) as server:
            there = "document.querySelectorAll('.station[data-phase=here]').length === 2"
            assert look(server.url, there) == []


def test_the_replay(look):
    with served(PAGES) as address:
        note = "document.getElementById('note').textContent !== ''"
        assert look(f"{address}/replay/replay.html?trial=t1", note) == []


def test_progress_of_a_person_and_of_all(look, tmp_path):
    times = [(30.0, True)] * 7
    path = record(tmp_path, "ann", exercise="slalom", setting="cones_3", times=times)
    trials, courses = [read_trial(path)], [load_curriculum(each) for each in curricula().values()]
    (tmp_path / "person.html").write_text(person_report("ann", trials, courses, 1.8e9))
    (tmp_path / "class.html").write_text(class_report({"ann": trials}, courses, 1.8e9))
    with served(tmp_path) as address:
        for name in ("person", "class"):
            assert look(f"{address}/{name}.html", "document.querySelector('h1') !== null") == []
