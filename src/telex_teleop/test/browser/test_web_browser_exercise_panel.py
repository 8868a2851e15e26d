"""The instructor's panel of exercises, and the strip on his page, in headless Chromium."""

from __future__ import annotations

import json

import pytest
from console_page import OTHER
from instructor_page import answer, outside, page, robot, ros, simulator
from selenium.webdriver.support.ui import Select
from waiting import wait_until

# the fixtures of the other tests of this page, started anew for this file
__all__ = ["page", "robot", "ros", "simulator"]

pytestmark = [pytest.mark.ros, pytest.mark.browser]

STATE = {
    "trial": "t1",
    "exercise": "slalom",
    "title": "Slalom",
    "setting": "dusk",
    "mode": "exam",
    "operator": "ann",
    "valid": True,
    "repetition": 1,
    "repetitions": 3,
    "steps": ["out", "back"],
    "steps_done": [False, False],
}
SLALOM = {"name": "slalom", "title": "Slalom", "settings": ["day", "dusk"]}
VALVE = {"name": "valve", "title": "Valve", "settings": ["standard"]}
BROKEN = {"name": "broken", "problem": "no YAML"}
DONE = {"success": True}


class Training:
    """Plays the training node."""

    def __init__(self, simulator):
        self.probe = simulator.probe
        modes = {"modes": ["practice", "exam"]}
        listed = [{**SLALOM, **modes}, {**VALVE, **modes}, BROKEN]
        self.serve("list", "telex_msgs/ListExercises", exercises=listed)
        for name in ("start", "again", "abort"):
            self.serve(name, "std_srvs/Trigger", **DONE)
        self.serve("note", "telex_msgs/NoteTrial", **DONE)
        self.reset()

    def reset(self):
        self.serve("open", "telex_msgs/OpenExercise", trial="t1", **DONE)
        self.tell("idle")
        self.probe.forget_requests()

    def serve(self, name, kind, **response):
        self.probe.do("serve", service=f"/telex/training/{name}", type=kind, response=response)

    def tell(self, phase, **changes):
        state = {**STATE, **changes} if phase != "idle" else {}
        message = {"phase": phase, **state}
        self.probe.publish("/telex/training/state", "telex_msgs/TrainingState", message, latch=True)

    def asked(self, name):
        return self.probe.requests_of(f"/telex/training/{name}")


@pytest.fixture(scope="module")
def training(ros, simulator, tmp_path_factory):
    folder = tmp_path_factory.mktemp("pages")
    (folder / "api").mkdir()
    (folder / "api" / "sheets").write_text(json.dumps([{"operator": "bob"}]))
    ros.master.setParam("/telex/video_server/mounts/training", {"folder": str(folder)})
    return Training(simulator)


@pytest.fixture(autouse=True)
def clean(training, simulator, page):
    training.reset()
    simulator.reset()
    page.load()
    wait_until(lambda: page.text("exercise-note") == "none is open")
    wait_until(lambda: page.element("#exercise-open").is_enabled())


def options(page, element):
    return page.script(
        f"return [...document.getElementById('{element}').options].map(({{value}}) => value)"
    )


def test_an_exercise_is_opened_for_a_trainee_and_started_and_aborted(ros, training, page):
    assert options(page, "exercise-name") == ["slalom", "valve"]
    url = f"{ros.param('/telex/rosbridge/url')}?name=Ann"
    assert page.driver.execute_async_script(OTHER, url)
    wait_until(lambda: "Ann" in page.text("roster"))
    page.element("#exercise-open").click()
    assert "type a name" in page.text("exercise-note")
    assert training.asked("open") == []
    page.element("#exercise-operator").send_keys("ann")
    assert options(page, "exercise-names") == ["Ann", "bob"]
    Select(page.element("#exercise-setting")).select_by_value("dusk")
    Select(page.element("#exercise-mode")).select_by_value("exam")
    page.element("#exercise-open").click()
    wait_until(
        lambda: training.asked("open")
        == [{"exercise": "slalom", "setting": "dusk", "mode": "exam", "operator": "ann"}]
    )
    assert not page.element("#exercise-start").is_enabled()
    training.tell("ready")
    wait_until(lambda: page.text("exercise-note") == "ann · Slalom, dusk · exam · ready")
    assert page.text("training-title") == "Slalom · dusk · EXAM"
    page.element("#exercise-start").click()
    wait_until(lambda: training.asked("start"))
    training.tell("running", elapsed=65.2)
    wait_until(lambda: page.text("training-clock") == "01:05")
    assert page.text("training-step") == "1/2 out"
    assert not page.element("#exercise-open").is_enabled()
    page.element("#exercise-abort").click()
    assert answer(page, "no").startswith("Abort the trial of ann?")
    assert training.asked("abort") == []
    page.element("#exercise-abort").click()
    answer(page, "yes")
    wait_until(lambda: len(training.asked("abort")) == 1)
    page.script("other.close()")
    assert page.errors() == []


def test_settings_are_those_of_the_exercise_that_is_chosen(page):
    assert options(page, "exercise-setting") == ["day", "dusk"]
    Select(page.element("#exercise-name")).select_by_value("valve")
    assert options(page, "exercise-setting") == ["standard"]
    assert not page.element("#exercise-setting").is_enabled()


def test_what_is_refused_says_why(training, page):
    why = "a trial of Slalom is running (bob); training/abort ends it"
    training.serve("open", "telex_msgs/OpenExercise", success=False, message=why)
    page.element("#exercise-operator").send_keys("ann")
    page.element("#exercise-open").click()
    wait_until(lambda: why in page.text("log"))
    assert page.text("exercise-note") == "none is open"


def test_a_trial_is_noted_while_it_goes_on_and_marked_once_it_has_ended(training, page):
    assert not page.element("#exercise-remarks").is_displayed()
    training.tell("running")
    wait_until(lambda: page.element("#exercise-remarks").is_displayed())
    assert not page.element("#exercise-passed").is_enabled()
    remark = page.element("#exercise-remark")
    remark.send_keys("looks back too late\n")
    note = {"trial": "t1", "kind": "note", "value": "looks back too late", "reason": "instructor"}
    wait_until(lambda: training.asked("note") == [note])
    wait_until(lambda: remark.get_property("value") == "")
    training.tell("ended", verdict="passed")
    wait_until(lambda: page.text("exercise-note") == "ann · Slalom, dusk · exam · passed")
    page.element("#exercise-failed").click()
    assert page.text("exercise-note") == "a mark needs a reason"
    remark.send_keys("careless")
    page.element("#exercise-failed").click()
    mark = {"trial": "t1", "kind": "mark", "value": "failed", "reason": "careless"}
    wait_until(lambda: training.asked("note")[1:] == [mark])
    wait_until(lambda: page.text("exercise-note").endswith("· passed"))


@pytest.mark.parametrize("size", [(1280, 720), (1920, 1080)])
def test_nothing_is_cut_off_while_a_trial_runs(training, page, size):
    page.resize(*size)
    asked = {"name": "ring", "ask": "Where is the ring open?", "choices": ["up", "down"]}
    training.tell("running", questions=[asked])
    wait_until(lambda: "ring open" in page.text("training-questions"))
    assert outside(page) == []
    page.resize(1280, 720)
