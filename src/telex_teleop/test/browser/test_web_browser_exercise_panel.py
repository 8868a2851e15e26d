"""The instructor's panels of a trial, and the strip on his page, in headless Chromium."""

from __future__ import annotations

import json

import pytest
from console_page import OTHER
from instructor_page import answer, outside, page, robot, ros, simulator
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
        for name in ("start", "again", "call_off"):
            self.serve(name, "std_srvs/Trigger", **DONE)
        self.serve("note", "telex_msgs/NoteTrial", **DONE)
        self.serve("bookmark", "telex_msgs/Bookmark", message="bookmark 'door' is set", **DONE)
        self.serve("back", "telex_msgs/Restore", message="back to it", **DONE)
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
    page.load(steady=False)
    wait_until(lambda: page.text("exercise-note") == "none is open")
    wait_until(lambda: page.element("#exercise-open").is_enabled())


def options(page, element):
    return page.script(
        f"return [...document.getElementById('{element}').options].map(({{value}}) => value)"
    )


def test_an_exercise_is_opened_for_a_trainee_and_started_and_aborted(ros, training, page):
    assert options(page, "exercise-name") == ["slalom", "valve"]
    url = f"{ros.param('/telex/rosbridge/url')}?name=Ann"
    assert page.script(OTHER, url)
    wait_until(lambda: "Ann" in page.text("roster"))
    page.element("#exercise-open").click()
    assert "type a name" in page.text("exercise-note")
    assert training.asked("open") == []
    page.element("#exercise-operator").type("ann")
    assert options(page, "exercise-names") == ["Ann", "bob"]
    page.element("#exercise-setting").set("dusk")
    page.element("#exercise-mode").set("exam")
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
    assert training.asked("call_off") == []
    page.element("#exercise-abort").click()
    answer(page, "yes")
    wait_until(lambda: len(training.asked("call_off")) == 1)
    page.script("other.close()")
    assert page.errors() == []


def test_settings_are_those_of_the_exercise_that_is_chosen(page):
    assert options(page, "exercise-setting") == ["day", "dusk"]
    page.element("#exercise-name").set("valve")
    assert options(page, "exercise-setting") == ["standard"]
    assert not page.element("#exercise-setting").is_enabled()


def test_what_is_refused_says_why(training, page):
    why = "a trial of Slalom is running (bob); it has to be ended first"
    training.serve("open", "telex_msgs/OpenExercise", success=False, message=why)
    page.element("#exercise-operator").type("ann")
    page.element("#exercise-open").click()
    wait_until(lambda: why in page.text("log"))
    assert page.text("exercise-note") == "none is open"


def test_a_trial_is_noted_while_it_goes_on_and_marked_once_it_has_ended(training, page):
    assert not page.element("#exercise-remarks").is_displayed()
    training.tell("running")
    wait_until(lambda: page.element("#exercise-remarks").is_displayed())
    assert not page.element("#exercise-passed").is_enabled()
    remark = page.element("#exercise-remark")
    remark.type("looks back too late\n")
    note = {"trial": "t1", "kind": "note", "value": "looks back too late", "reason": "instructor"}
    wait_until(lambda: training.asked("note") == [note])
    wait_until(lambda: remark.get_property("value") == "")
    training.tell("ended", verdict="passed")
    wait_until(lambda: page.text("exercise-note") == "ann · Slalom, dusk · exam · passed")
    page.element("#exercise-failed").click()
    assert page.text("exercise-note") == "a mark needs a reason"
    remark.type("careless")
    page.element("#exercise-failed").click()
    mark = {"trial": "t1", "kind": "mark", "value": "failed", "reason": "careless"}
    wait_until(lambda: training.asked("note")[1:] == [mark])
    wait_until(lambda: page.text("exercise-note").endswith("· passed"))


PLAYED = """
    window.heard = {};
    window.asked = [];
    window.said = [];
    const bridge = {
      subscribe: ({topic, heard}) => { window.heard[topic] = heard; },
      call: async (service, args) => {
        window.asked.push([service, args]);
        return window.answer;
      },
    };
    window.answer = {success: true, message: ""};
    const topic = (name) => `/telex/${name}`;
    const say = (sentence) => window.said.push(sentence);
    return Promise.all(["robot_client", "instructor/exam_list", "instructor/malfunction_panel"].map(
      (name) => import(`/js/${name}.js`),
    )).then(([client, exam, malfunction]) => {
      const robot = new client.RobotClient(bridge, topic, say, say);
      window.list = new exam.ExamList(robot);
      window.malfunctions = new malfunction.MalfunctionPanel(robot);
      window.list.subscribe();
      window.malfunctions.subscribe();
      return true;
    });
"""
"""Panels on the page with a bridge that is played: these need no exam, and nothing that fails."""

FROZEN = {
    "what": "front",
    "group": "camera",
    "kind": "frozen",
    "text": "the picture stands still",
    "unit": "",
    "default_value": 0,
    "least": 0,
    "most": 0,
}
WEAK = {
    "what": "elbow_joint",
    "group": "joint",
    "kind": "weak",
    "text": "its drive has less force",
    "unit": "share",
    "default_value": 0.5,
    "least": 0.05,
    "most": 0.95,
}


@pytest.fixture
def played(page):
    assert page.script(PLAYED)

    class Played:
        def hear(self, topic, message):
            page.script(f"heard['/telex/{topic}']({json.dumps(message)})")

        def asked(self):
            return page.script("return asked.splice(0)")

        def state(self, **changes):
            state = {**STATE, "phase": "running", **changes}
            page.script(f"malfunctions.show({json.dumps(state)}); list.hear({json.dumps(state)})")

    return Played()


def test_an_exams_list_is_said_and_ended_with_a_question(played, page):
    assert not page.element("#exam-list").is_displayed()
    played.hear("bridge/exam", {"data": "t1"})
    assert page.text("exam-note") == "An exam's list holds, and the exam does not run"
    played.state()
    assert page.text("exam-note") == "Exam: trainees have its list only"
    page.script("document.getElementById('exam-end').click()")
    assert "The trial that runs becomes invalid." in answer(page, "yes")
    # The page's own panel asks the bridge as well, at which no list holds.
    wait_until(lambda: ["/telex/bridge/end_exam", {}] in played.asked())
    played.hear("bridge/exam", {"data": ""})
    assert not page.element("#exam-list").is_displayed()


def test_a_line_is_chosen_by_one_click(page):
    page.element("#tab-faults").click()
    wait_until(lambda: page.text("line-note") == "nothing is impaired")
    for profile, note in (("300", "300 ms"), ("perfect", "nothing is impaired")):
        page.element(f"[data-profile='{profile}']").click()
        wait_until(lambda note=note: page.text("line-note") == note)
        assert page.element("#line-profiles [aria-checked=true]").text == profile
    assert page.errors() == []


def test_a_malfunction_is_injected_now_or_at_the_next_step_and_ended(played, page):
    page.element("#tab-faults").click()
    assert not page.element("#malfunction-panel").is_displayed()
    played.hear("sim/malfunctions", {"active": [], "possible": [FROZEN, WEAK]})
    assert page.text("malfunction-note") == "all works"
    assert not page.element("#malfunction-value").is_displayed()
    page.element("#malfunction-now").click()
    frozen = {"what": "front", "kind": "frozen", "value": 0, "announced": False}
    wait_until(lambda: played.asked() == [["/telex/sim/malfunction", {**frozen, "on": True}]])
    active = {**frozen, "group": "camera"}
    played.hear("sim/malfunctions", {"active": [active], "possible": [FROZEN, WEAK]})
    assert page.text("malfunction-note") == "1 active"
    assert "front: frozen, silent" in page.text("malfunction-active")
    page.element("#malfunction-active button").click()
    wait_until(lambda: played.asked() == [["/telex/sim/malfunction", {**frozen, "on": False}]])
    played.hear("sim/malfunctions", {"active": [], "possible": [FROZEN, WEAK]})
    page.element("#malfunction-what").set("elbow_joint/weak")
    value = page.element("#malfunction-value")
    assert value.get_attribute("placeholder") == "0.5 share"
    value.type("2")
    page.element("#malfunction-now").click()
    assert page.text("malfunction-note") == "the value must be 0.05 to 0.95 share"
    value.set("")
    value.type("0.25")
    page.element("#malfunction-announced").click()
    assert not page.element("#malfunction-next").is_enabled()
    played.state()
    page.element("#malfunction-next").click()
    assert "elbow_joint: weak, at the next step" in page.text("malfunction-active")
    played.state()
    assert played.asked() == []
    played.state(steps_done=[True, False])
    weak = {"what": "elbow_joint", "kind": "weak", "value": 0.25, "announced": True}
    wait_until(lambda: played.asked() == [["/telex/sim/malfunction", {**weak, "on": True}]])
    assert page.text("malfunction-active") == ""


def test_bookmarks_are_those_of_practice_while_one_goes_on_and_else_the_simulators(
    training, simulator, page
):
    names = ["mark 1", "door"]
    simulator.serve("list_bookmarks", "telex_msgs/ListBookmarks", names=names[:1])
    simulator.serve("bookmark", "telex_msgs/Bookmark", names=names, **DONE)
    simulator.serve("restore", "telex_msgs/Restore", **DONE)
    back = page.element("#bookmarks-back")
    assert not back.is_enabled()
    page.element("#bookmarks-name").type("door")
    page.element("#bookmarks-set").click()
    wait_until(lambda: simulator.asked("bookmark") == [{"name": "door", "replaces": ""}])
    wait_until(lambda: options(page, "bookmarks-names") == ["mark 1"])
    assert page.element("#bookmarks-name").get_property("value") == ""
    back.click()
    wait_until(lambda: simulator.asked("restore") == [{"name": "mark 1"}])
    training.tell("running", mode="practice", bookmarks=names)
    wait_until(lambda: options(page, "bookmarks-names") == ["door", "mark 1"])
    back.click()
    wait_until(lambda: training.asked("back") == [{"name": "door"}])
    page.element("#bookmarks-set").click()
    wait_until(lambda: training.asked("bookmark") == [{"name": "", "replaces": ""}])
    # Those of the strip are the trainee's, who is not here.
    assert page.element("#training").is_displayed()
    assert not page.element("#training-bookmarks").is_displayed()
    training.tell("running", mode="exam")
    wait_until(lambda: not page.element("#bookmarks-set").is_enabled())
    assert not back.is_enabled()
    assert len(simulator.asked("restore")) == len(simulator.asked("bookmark")) == 1
    assert page.errors() == []


@pytest.mark.parametrize("size", [(1280, 720), (1920, 1080)])
def test_nothing_is_cut_off_while_a_trial_runs(training, page, played, size):
    page.resize(*size)
    asked = {"name": "ring", "ask": "Where is the ring open?", "choices": ["up", "down"]}
    marks = [f"a name as long as that of a step can be, {number}, repetition 12" for number in "ab"]
    training.tell("running", mode="practice", bookmarks=marks, questions=[asked])
    wait_until(lambda: "ring open" in page.text("training-questions"))
    played.hear("bridge/exam", {"data": "t1"})
    assert outside(page) == []
    page.element("#tab-faults").click()
    wait_until(lambda: page.element("#line-panel").is_displayed())
    active = {**FROZEN, "value": 0, "announced": False}
    played.hear("sim/malfunctions", {"active": [active, active], "possible": [FROZEN, WEAK]})
    assert outside(page) == []
    page.resize(1280, 720)
