"""Reproducing the paper: what experiments are, how they are run, and what the report says."""

from __future__ import annotations

import base64
import csv
import io
import math
import os
import re
import signal
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path

import pytest
from waiting import wait_until

from telex_experiments.paper import __main__ as program
from telex_experiments.paper import registry, schedule
from telex_experiments.paper.experiment import (
    Experiment,
    Figure,
    ReportPicture,
    ReportTable,
    Result,
    missing,
)
from telex_experiments.paper.one import carry_out
from telex_experiments.paper.page import ReportRun, number, page
from telex_experiments.paper.recorder import Throttle, rates
from telex_experiments.paper.schedule import ExperimentOutcome, Schedule, planned
from telex_experiments.paper.session import PaperSession
from telex_experiments.rigs.private_master import PrivateMaster, end_tree

pytestmark = [pytest.mark.waiting, pytest.mark.slow]

ROOT = Path(__file__).resolve().parents[1]

RUN = ReportRun("2026-01-01 12:00", "a processor", "commit abc", False, 1, 90.0)
VOID = {"meta", "link", "img", "br"}
PIXEL = base64.b64decode(
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAQAAAC1HAwCAAAAC0lEQVR42mNkYAAAAAYAAjCB0C8AAAAASUVORK5CYII="
)
DRAWING = "<svg xmlns='http://www.w3.org/2000/svg'><script>alert(1)</script></svg>"


def experiment(name="one", **changes):
    given = {
        "paper": "figure 1",
        "title": "A result",
        "claim": "It works.",
        "method": "It is tried.",
        "bar": "1 mm",
        "run": lambda session: Result(),
        "seconds": 10.0,
        "quick_seconds": 2.0,
        **changes,
    }
    return Experiment(name, **given)


def good():
    return Result(figures=[Figure("error", 0.5, "mm", at_most=1.0)])


def bad():
    return Result(figures=[Figure("error", 1.5, "mm", at_most=1.0), Figure("length", 2.0, "m")])


class Page(HTMLParser):
    """What a browser would make of a page, and what it would fetch."""

    def __init__(self, text):
        super().__init__()
        self.open, self.broken, self.fetched, self.links, self.ids = [], [], [], [], []
        self.words, self.missed, self.scripts = [], 0, 0
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attributes):
        given = dict(attributes)
        if tag not in VOID:
            self.open.append(tag)
        if "src" in given:
            self.fetched.append(given["src"])
        if tag == "link":
            self.fetched.append(given["href"])
        if tag == "a":
            self.links.append(given["href"])
        if "id" in given:
            self.ids.append(given["id"])
        self.missed += "missed" in given.get("class", "").split()
        self.scripts += tag == "script"

    def handle_endtag(self, tag):
        if not self.open or self.open.pop() != tag:
            self.broken.append(tag)

    def handle_data(self, data):
        self.words.append(data)

    @property
    def text(self):
        return " ".join(" ".join(self.words).split())


def report(tmp_path, *outcomes):
    return page(RUN, outcomes, tmp_path)


# ---- the page


def full(tmp_path):
    """Return an outcome with everything that one can have."""
    folder = tmp_path / "one"
    folder.mkdir()
    (folder / "photo.jpg").write_bytes(b"\xff\xd8\xff")
    (folder / "pixel.png").write_bytes(PIXEL)
    (folder / "plot.svg").write_text(DRAWING)
    (folder / "plot.png").write_bytes(PIXEL)
    result = Result(
        figures=[Figure("error", 0.5, "mm", at_most=1.0), Figure("runs", 9, "", at_least=9)],
        pictures=[
            ReportPicture("Photo.", "photo.jpg", "of it"),
            ReportPicture("Pixel.", "pixel.png"),
            ReportPicture("Plot.", "plot.svg"),
        ],
        tables=[
            ReportTable("Runs", "runs.csv", ("run", "error mm"), [[1, 0.25], [2, None]], "All.")
        ],
        bags=["run 1.bag"],
        notes=["A note."],
    )
    return ExperimentOutcome(experiment(), result, 12.0)


def test_the_page_is_whole_and_needs_nothing_beside_it(tmp_path):
    text = report(tmp_path, full(tmp_path))
    found = Page(text)
    assert not found.broken
    assert not found.open
    assert found.scripts == 0
    assert len(found.fetched) == 4  # the icon, and three pictures
    assert all(address.startswith("data:") for address in found.fetched)
    assert not any(re.match(r"[a-z]+:|//", link) for link in found.links)
    assert not re.search(r"@import|url\(", text)
    assert base64.b64encode(PIXEL).decode() in text


def test_the_page_links_every_file_of_an_experiment(tmp_path):
    found = Page(report(tmp_path, full(tmp_path)))
    for file in ("runs.csv", "run%201.bag", "photo.jpg", "plot.svg", "plot.png"):
        assert f"one/{file}" in found.links, file
    assert "#one" in found.links
    assert "one" in found.ids


def test_a_met_bar_stands_beside_claim_and_figure(tmp_path):
    found = Page(report(tmp_path, full(tmp_path)))
    for words in ("It works.", "It is tried.", "1 mm", "0.5 mm", "A note.", "All.", "\u2264 1"):
        assert words in found.text
    assert "1 of 1 results reproduced" in found.text
    assert found.missed == 0


def test_a_missed_bar_is_red_and_named_in_the_summary(tmp_path):
    outcomes = [
        ExperimentOutcome(experiment("one"), good(), 1.0),
        ExperimentOutcome(experiment("two"), bad(), 1.0),
    ]
    text = report(tmp_path, *outcomes)
    found = Page(text)
    assert "1 of 2 results reproduced" in found.text
    # heading, badge of the summary, badge of the section, row of the figure and its badge
    assert found.missed == 5
    summary = text[: text.index("id='one'")]
    assert "error 1.5 mm" in summary
    assert "length" not in summary


def test_what_broke_off_is_missed_and_says_why(tmp_path):
    found = Page(report(tmp_path, ExperimentOutcome(experiment(), missing("no <camera>"), 1.0)))
    assert found.text.count("no <camera>") == 2
    assert found.missed == 3


def test_text_cannot_break_the_page(tmp_path):
    evil = "<script>alert('1')</script> & \"more\""
    given = experiment(title=evil, claim=evil, method=evil, bar=evil, paper=evil)
    result = Result(
        figures=[Figure(evil, 2.0, evil, at_most=1.0)],
        pictures=[ReportPicture(evil, "x.svg", evil)],
        tables=[ReportTable(evil, "a'b.csv", (evil,), [[evil]], evil)],
        notes=[evil],
        error=evil,
    )
    (tmp_path / "one").mkdir()
    (tmp_path / "one" / "x.svg").write_text(DRAWING)
    found = Page(report(tmp_path, ExperimentOutcome(given, result, 1.0)))
    assert found.scripts == 0
    assert not found.broken
    assert found.text.count("<script>alert('1')</script>") >= 10
    assert "one/a%27b.csv" in found.links


def test_a_picture_that_is_missing_is_said(tmp_path):
    result = good()
    result.pictures.append(ReportPicture("Gone.", "gone.png"))
    assert (
        "gone.png is missing"
        in Page(report(tmp_path, ExperimentOutcome(experiment(), result, 1.0))).text
    )


def test_a_long_table_is_folded_and_a_missed_figure_is_not(tmp_path):
    long = ReportTable("Long", "long.csv", ("n",), [[n] for n in range(100)])
    result = Result(figures=[Figure(f"f{n}", 2.0, "", at_most=1.0) for n in range(40)])
    result.tables.append(long)
    text = report(tmp_path, ExperimentOutcome(experiment(), result, 1.0))
    assert text.count("<details open>") == 1
    assert text.count("<details>") == 1


def test_numbers_stand_below_their_heads_and_words_do_not(tmp_path):
    table = ReportTable("T", "t.csv", ("mass kg", "fits"), [[1.5, True], [None, False]])
    result = Result(tables=[table])
    text = report(tmp_path, ExperimentOutcome(experiment(), result, 1.0))
    assert "<th class=number>mass kg</th>" in text
    assert "<td class=number>1.5</td><td>yes</td>" in text
    assert "<th>fits</th>" in text


def test_a_wide_picture_has_the_width_of_the_page(tmp_path):
    outcome = full(tmp_path)
    outcome.result.pictures.append(ReportPicture("Wide.", "pixel.png", wide=True))
    text = report(tmp_path, outcome)
    assert text.count("<figure class=wide>") == 1
    assert text.count("<figure>") == 3


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (None, "\u2013"),
        (True, "yes"),
        (7, "7"),
        (1234.5678, "1235"),
        (-0.00012345, "\u22120.0001234"),
        (math.inf, "none"),
        (math.nan, "none"),
        ("a", "a"),
    ],
)
def test_numbers_are_written_for_people(value, text):
    assert number(value) == text


# ---- results


def test_a_result_without_a_bar_proves_nothing():
    assert not Result().ok
    assert not Result(figures=[Figure("length", 1.0, "m")]).ok
    assert good().ok
    assert not bad().ok
    assert not missing("why", good()).ok


def test_no_number_meets_no_bar():
    assert not Result(figures=[Figure("error", math.nan, "", at_most=1.0)]).ok
    assert not Result(figures=[Figure("runs", math.nan, "", at_least=1.0)]).ok


def test_a_result_survives_its_way_between_processes():
    result = Result(
        figures=[Figure("error", math.inf, "mm", at_most=1.0), Figure("n", 3, "")],
        pictures=[ReportPicture("P.", "p.svg", "c")],
        tables=[ReportTable("T", "t.csv", ("a", "b"), [[1.5, None], ["x", True]])],
        bags=["b.bag"],
        notes=["n"],
        error="e",
    )
    again = Result.from_json(result.as_json())
    assert again.figures == result.figures
    assert again.pictures == result.pictures
    assert again.tables[0].as_csv() == result.tables[0].as_csv()
    assert (again.bags, again.notes, again.error) == (result.bags, result.notes, result.error)


def test_a_table_keeps_all_digits_in_its_csv():
    table = ReportTable("T", "t.csv", ("a, b", "c"), [[0.1234567890123, 'say "x"'], [None, 2]])
    rows = list(csv.reader(io.StringIO(table.as_csv())))
    assert rows == [["a, b", "c"], ["0.1234567890123", 'say "x"'], ["", "2"]]


def test_what_does_not_fit_is_refused():
    with pytest.raises(ValueError, match="does not fit its head"):
        ReportTable("T", "t.csv", ("a", "b"), [[1]])
    with pytest.raises(ValueError, match="none of"):
        ReportPicture("P.", "film.gif")
    with pytest.raises(ValueError, match="lower case"):
        experiment("Fig 9")
    with pytest.raises(ValueError, match="seconds"):
        experiment(seconds=math.nan)


# ---- which experiments there are


def test_every_result_of_the_paper_has_an_experiment():
    found = registry.experiments()
    papers = " ".join(each.paper for each in found)
    for reference in ("Figure 3", "section 3.2", "Figure 6", "Figure 7", "Figure 8", "Figure 11"):
        assert reference.lower() in papers.lower(), reference


def test_experiments_are_chosen_by_name_or_group():
    names = [each.name for each in registry.experiments()]
    assert [each.name for each in registry.select([])] == names
    assert [each.name for each in registry.select(["fig8", "fig3"])] == [
        "fig3_kinematics",
        "fig8_trajectories",
        "fig8_live",
    ]
    with pytest.raises(registry.UnknownExperimentError, match="no experiment 'fig99'; there are"):
        registry.select(["fig99"])


def test_the_whole_run_fits_its_time():
    """25 minutes on two cores, with a reserve."""
    found = registry.experiments()
    assert planned(found, quick=False) <= 23.5 * 60.0
    assert planned(found, quick=True) <= 12.0 * 60.0


# ---- running them

FAKE = """
import os, subprocess, sys, time
from telex_experiments.paper import registry
from telex_experiments.paper.experiment import Experiment, Figure, Result, ReportTable

def experiment(name, run, **more):
    words = dict.fromkeys(("paper", "title", "claim", "method", "bar"), name)
    return Experiment(name, run=run, **{"seconds": 1.0, "quick_seconds": 1.0, **words, **more})

def well(session):
    print("a library speaks")
    session.say(f"seed {session.seed}, quick {session.quick}")
    table = ReportTable("T", "t.csv", ("a",), [[1]])
    return Result(figures=[Figure("x", 1.0, "", at_most=2.0)], tables=[table])

def computing(session):
    return Result(figures=[Figure("niceness", os.nice(0), "", at_least=10)])

def badly(session):
    return Result(figures=[Figure("x", 3.0, "", at_most=2.0)])

def broken(session):
    raise ValueError("it broke")

def dead(session):
    print("last words", file=sys.stderr, flush=True)
    os._exit(7)

def endless(session):
    child = subprocess.Popen(["sleep", "600"], start_new_session=True)
    (session.folder / "child").write_text(str(child.pid))
    session.say("sleeping")
    time.sleep(600)

def ticking(session):
    times = []
    while not (session.folder.parent / "alone" / "span").exists() or len(times) < 100:
        times.append(time.monotonic())
        time.sleep(0.02)
    (session.folder / "times").write_text(" ".join(map(repr, times)))
    return Result(figures=[Figure("x", 1.0, "", at_most=2.0)])

def alone(session):
    began = time.monotonic()
    time.sleep(1.5)
    (session.folder / "span").write_text(f"{began!r} {time.monotonic()!r}")
    return Result(figures=[Figure("x", 1.0, "", at_most=2.0)])

EXPERIMENTS = (
    *(experiment(run.__name__, run) for run in (well, badly, broken, dead, endless)),
    experiment("computing", computing, in_wall_time=False),
    experiment("ticking", ticking, in_wall_time=False),
    experiment("alone", alone, alone=True),
)
"""

NO_ROS = """
import contextlib
from telex_experiments.paper import session
session.PaperSession.__enter__ = lambda self: self
session.PaperSession.__exit__ = lambda self, *exception: None
"""


@pytest.fixture
def fakes(tmp_path, monkeypatch):
    """Experiments that need no simulator, also in the processes that are started."""
    modules = tmp_path / "modules"
    modules.mkdir()
    (modules / "fakes.py").write_text(FAKE + NO_ROS)
    # Python imports this by itself at its start.
    (modules / "sitecustomize.py").write_text(
        "import sys\n"
        "def register():\n"
        "    from telex_experiments.paper import registry\n"
        "    registry.MODULES = ('fakes',)\n"
        "class Finder:\n"
        "    def find_spec(self, name, path=None, target=None):\n"
        "        if name == 'telex_experiments.paper.one':\n"
        "            sys.meta_path.remove(self)\n"
        "            register()\n"
        "sys.meta_path.insert(0, Finder())\n"
    )
    paths = [modules, os.environ.get("PYTHONPATH", "")]
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(map(str, paths)))
    monkeypatch.syspath_prepend(str(modules))
    monkeypatch.setattr(registry, "MODULES", ("fakes",))
    return tmp_path / "results"


def test_a_run_ends_with_a_report_and_a_status(fakes, capsys):
    options = program.parse(["--only", "well", "--out", str(fakes), "--seed", "5", "--quick"])
    assert program.reproduce(options) == 0
    said = capsys.readouterr().out
    assert "well: seed 5, quick True" in said
    assert "a library speaks" not in said
    assert (fakes / "well" / "t.csv").read_text() == "a\n1\n"
    assert "1 of 1 results reproduced" in (fakes / "report.html").read_text()


def test_a_missed_bar_gives_a_status_and_the_others_go_on(fakes, capsys):
    options = program.parse(["--only", "well", "badly", "broken", "dead", "--out", str(fakes)])
    assert program.reproduce(options) == program.MISSED
    said = capsys.readouterr().out
    assert "missed: badly, broken, dead" in said
    assert "ValueError: it broke" in said
    found = Page((fakes / "report.html").read_text())
    assert "1 of 4 results reproduced" in found.text
    assert "ended with status 7: last words" in found.text


def test_what_only_computes_leaves_the_processors_to_the_simulators(fakes):
    (outcome,) = Schedule(fakes, False, 1, lambda line: None).run(registry.select(["computing"]))
    assert outcome.result.ok, outcome.result


def test_what_computes_stands_still_while_one_has_to_be_alone(fakes):
    chosen = registry.select(["ticking", "alone"])
    outcomes = Schedule(fakes, False, 1, lambda line: None).run(chosen)
    assert all(outcome.result.ok for outcome in outcomes), outcomes
    times = [float(word) for word in (fakes / "ticking" / "times").read_text().split()]
    began, ended = (float(word) for word in (fakes / "alone" / "span").read_text().split())
    assert not [time for time in times if began < time < ended]
    assert times[-1] > ended


def test_one_that_takes_too_long_is_ended_with_all_that_it_started(fakes, monkeypatch):
    monkeypatch.setattr(schedule, "PATIENCE", 0.0)
    monkeypatch.setattr(schedule, "GRACE", 4.0)
    file = fakes / "endless" / "child"

    class Endless(subprocess.Popen):
        """Its time runs out once its child is there."""

        def wait(self, timeout=None):
            if timeout == schedule.GRACE:
                wait_until(lambda: file.exists() and file.read_text(), "the child", 300.0)
                timeout = 0.0
            return super().wait(timeout)

    monkeypatch.setattr(schedule.subprocess, "Popen", Endless)
    (outcome,) = Schedule(fakes, False, 1, lambda line: None).run(registry.select(["endless"]))
    assert "ended after 4 s" in outcome.result.error
    assert not outcome.result.ok
    child = int(file.read_text())
    wait_until(lambda: not runs(child), "the child to end", 5.0)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_run_leaves_no_process_behind(fakes, number):
    command = (
        "import sys; from telex_experiments.paper import registry; registry.MODULES = ('fakes',)\n"
    )
    command += "from telex_experiments.paper.__main__ import main; sys.argv[0] = 'x'; main()"
    process = subprocess.Popen(
        [sys.executable, "-c", command, "--only", "endless", "--out", str(fakes)],
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    for line in process.stdout:
        if "sleeping" in line:
            break
    child = int((fakes / "endless" / "child").read_text())
    assert runs(child)
    process.send_signal(number)
    said = process.stdout.read()
    assert process.wait(30.0) == program.INTERRUPTED
    assert "Ending what was started" in said
    wait_until(lambda: not runs(child), "the child to end", 5.0)
    assert not (fakes / "report.html").exists()


def runs(pid):
    """Tell whether a process runs."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except (FileNotFoundError, ProcessLookupError):
        return False


def test_what_an_experiment_raises_is_its_error():
    class Workplace:
        def __enter__(self):
            return self

        def __exit__(self, *exception):
            pass

    def breaks(session):
        raise RuntimeError("no camera")

    result = carry_out(experiment(run=breaks), Workplace())
    assert result.error == "RuntimeError: no camera"


def test_what_computes_runs_beside_what_drives():
    both = [experiment("a"), experiment("b"), experiment("c", in_wall_time=False, seconds=15.0)]
    assert planned(both, quick=False) == 20.0
    assert planned(both, quick=True) == 4.0
    assert planned([experiment("a"), experiment("b", repeatable=True)], True, 10) == 22.0


@pytest.mark.parametrize("arguments", [["--seed", "-1"], ["--only"], ["--fast"], ["--repeat", "0"]])
def test_a_wrong_command_line_ends_the_program(arguments, capsys):
    with pytest.raises(SystemExit) as ended:
        program.parse(arguments)
    assert ended.value.code == program.MISUSED
    assert "reproduce_paper.sh" in capsys.readouterr().err


# ---- recording


def test_a_stream_is_thinned_out_and_begins_anew_when_the_clock_is_set_back():
    throttle = Throttle(5.0)
    kept = [time for time in range(0, 1000, 40) if throttle.keeps(time / 1e3)]
    assert kept == [0, 200, 400, 600, 800]
    assert throttle.keeps(0.1)
    assert throttle.keeps(0.11, "another sender")
    assert not throttle.keeps(0.12)
    everything = Throttle(None)
    assert all(everything.keeps(0.001 * step) for step in range(10))


def test_a_recording_holds_commands_states_frames_and_the_asked_cameras():
    found = rates("/telex", ["more"], ["front"], 2.0)
    for topic in (
        "/tf_static",
        "/telex/joint_states",
        "/telex/track_teleop/cmd_vel",
        "/telex/more",
    ):
        assert topic in found
    assert found["/telex/cameras/front/image_raw/compressed"] == 2.0
    assert not any("rear" in topic for topic in found)


def test_cameras_are_drawn_as_often_as_they_are_recorded(tmp_path, monkeypatch):
    session = PaperSession("one", tmp_path, False, 1, print)
    drawn = {}
    monkeypatch.setattr(
        session, "configure_camera", lambda name, **settings: drawn.update({name: settings})
    )
    session.record("run", ("front",), rate=1.0)
    session.record("console", ("rear",), watched=True)
    assert drawn == {"front": {"rate": 1.0, "priority": 0}}


LATE_CLOCK = """
import time
import rospy
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Bool

rospy.init_node("robot", disable_signals=True)
clock = rospy.Publisher("/clock", Clock, queue_size=10)
stop = rospy.Publisher("/telex/e_stop", Bool, queue_size=10)
while clock.get_num_connections() < 2:  # its own, and the recorder's
    time.sleep(0.01)
heard = 0
for step in range(10000):
    heard += stop.get_num_connections()
    if heard == 100:
        print("heard", flush=True)
    stop.publish(step % 2 == 0)
    if step > 100:
        clock.publish(rospy.Time(100, 10_000_000 * (step % 100)))
    time.sleep(0.01)
"""


@pytest.mark.ros
def test_a_bag_begins_with_the_sim_time(tmp_path):
    import rosbag

    with PrivateMaster() as master:
        environment = master.environment()
        subprocess.run(["rosparam", "set", "/use_sim_time", "true"], env=environment, check=True)
        path = tmp_path / "run.bag"
        recorder = [sys.executable, "-m", "telex_experiments.paper.recorder", str(path), "/telex"]
        started = []
        try:
            for command in ([sys.executable, "-c", LATE_CLOCK], recorder):
                started.append(
                    subprocess.Popen(
                        command, env=environment, stdout=subprocess.PIPE, start_new_session=True
                    )
                )
            assert started[-1].stdout.readline().strip() == b"recording"
            assert started[0].stdout.readline().strip() == b"heard"
        finally:
            for process in reversed(started):
                end_tree(process)
                process.stdout.close()
    with rosbag.Bag(str(path)) as bag:
        times = [stamp.to_sec() for _, _, stamp in bag.read_messages("/telex/e_stop")]
    assert len(times) > 10
    assert 100.0 <= min(times) <= max(times) < 101.0
