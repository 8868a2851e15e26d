"""The pages' handler: the brief of the trial that is open, and whom it tells what."""

from __future__ import annotations

import json
import urllib.error
import urllib.request
from types import SimpleNamespace

import pytest

from telex_training.exercises.catalog import find_exercise
from telex_training.exercises.exercise_file import load_exercise
from telex_training.ros.library import Library
from telex_training.ros.pages.brief_pages import OpenTrial
from telex_training.ros.pages.class_pages import ClassPages
from telex_training.ros.pages.training_pages import TrainingPages


def sheet(operator, setting, *times):
    return {
        "operator": operator,
        "exercise": {"name": "slalom", "setting": setting},
        "repetitions": [{"completed": True, "seconds": t, "penalty": 5.0} for t in times],
    }


def open_exercise(asked, *given):
    if given[0] == "taken":
        raise RuntimeError("a trial of Slalom is running (bob)")
    asked.append(given)
    return "t7"


@pytest.fixture
def station(tmp_path, monkeypatch):
    library = Library(tmp_path)
    done = [sheet("ann", "day", 80.0, 70.0), sheet("ann", "night", 60.0), sheet("bob", "day", 50.0)]
    monkeypatch.setattr(
        library,
        "sheets",
        lambda operator=None: [each for each in done if operator in (None, each["operator"])],
    )
    state = {"phase": "running", "operator": "ann", "help": 2.5, "questions": ["secret"]}
    asked = []
    pages = TrainingPages(
        library,
        tmp_path,
        0,
        lambda trial, ratings: None,
        ClassPages(lambda: state, lambda *given: open_exercise(asked, *given), asked.append),
    )
    pages.start()
    exercise = load_exercise(find_exercise("slalom")).first
    pages.briefs.opened = lambda: OpenTrial("t1", exercise, "exam", "ann")

    def get(path, name="", role="operator", send=None, kind="application/json"):
        headers = {"X-Telex-Role": role, "X-Telex-Name": name}
        data = None if send is None else json.dumps(send).encode()
        if data is not None:
            headers["Content-Type"] = kind
        address = path if path.startswith("/progress") else f"/training{path}"
        request = urllib.request.Request(f"{pages._address}{address}", data, headers)
        try:
            with urllib.request.urlopen(request, timeout=20.0) as reply:
                return reply.status, reply.read()
        except urllib.error.HTTPError as error:
            return error.code, error.read()

    yield SimpleNamespace(get=get, pages=pages, asked=asked)
    pages.close()


def test_the_brief_is_that_of_the_open_trial(station):
    status, content = station.get("/api/brief/t1", "ann")
    assert status == 200
    brief = json.loads(content)
    assert (brief["exercise"], brief["setting"], brief["mode"]) == ("slalom", "day", "exam")
    assert brief["picture"] == "/training/api/goal/t1.jpg"
    assert station.get("/api/brief/t2", "ann")[0] == 404
    station.pages.briefs.opened = lambda: None
    assert station.get("/api/brief/t1", "ann") == (404, b"This trial is not open.\n")


def test_what_exercises_say_in_other_languages_is_told_to_everybody(station):
    assert json.loads(station.get("/api/texts")[1]) == {}
    station.pages.briefs.texts = lambda: {"de": {"go": "los"}}
    assert json.loads(station.get("/api/texts", "ann")[1]) == {"de": {"go": "los"}}


def test_ones_best_in_this_setting_is_told_to_oneself_and_to_instructors(station):
    def best(*who):
        return json.loads(station.get("/api/brief/t1", *who)[1])["best"]

    assert best("ann") == 75.0
    assert best("", "instructor") == 75.0
    assert best("bob") is None


def test_the_goal_is_a_picture(station):
    status, content = station.get("/api/goal/t1.jpg")
    assert status == 200
    assert content[:3] == b"\xff\xd8\xff"
    assert station.get("/api/goal/t2.jpg")[0] == 404


@pytest.mark.parametrize("name", ["slalom", "..%2F..%2Fslalom", "..%2Fprevious", "none"])
def test_previews_are_those_that_are_shipped(station, name):
    assert station.get(f"/preview/{name}.jpg")[0] == (200 if name == "slalom" else 404)


def test_the_workload_of_a_trial_is_rated_once_and_by_who_did_it(station, monkeypatch):
    ratings, rated = [10, 20, 30, 40, 50, 60], []
    library = station.pages._library
    monkeypatch.setattr(library, "sheet", lambda trial: {"operator": "ann"})
    monkeypatch.setattr(library, "workload", lambda trial: dict(rated).get(trial))
    monkeypatch.setattr(station.pages, "_rate", lambda *given: rated.append(given))
    assert station.get("/api/workload/t1", role="instructor", send=ratings)[0] == 403
    assert station.get("/api/workload/t1", "ann", send=ratings[:5])[0] == 400
    assert station.get("/api/workload/t1", "ann", send=ratings)[0] == 200
    status, content = station.get("/api/workload/t1", "ann", send=[0] * 6)
    assert (status, content) == (409, b"The workload of this trial has been rated already.\n")
    assert station.get("/api/workload/t2", "ann", send=ratings)[0] == 200
    assert rated == [("t1", ratings), ("t2", ratings)]


class TestForAClass:
    def test_instructors_are_told_the_trial_and_nobody_else_is(self, station):
        status, content = station.get("/api/state", role="instructor")
        assert status == 200
        # What the trainee is asked is for the trainee.
        assert json.loads(content) == {"phase": "running", "operator": "ann", "help": 2.5}
        assert station.get("/api/state", "ann")[0] == 403
        assert station.get("/progress/api/standing", "ann")[0] == 403
        assert station.get("/progress/api/standing", role="instructor") == (200, b"[]")

    def test_an_exercise_is_opened_and_started_for_an_instructor(self, station):
        wanted = {"exercise": "slalom", "setting": "day", "mode": "exam", "operator": "eve"}
        send = {**wanted, "start": True}
        status, content = station.get("/api/open", role="instructor", send=send)
        assert (status, json.loads(content)) == (200, {"trial": "t7"})
        assert station.asked == [("slalom", "day", "exam", "eve", True)]
        status, content = station.get("/api/open", role="instructor", send={"exercise": "taken"})
        assert (status, content) == (409, b"a trial of Slalom is running (bob)\n")

    def test_help_is_taken_back(self, station):
        assert station.get("/api/help", role="instructor", send={"help": False})[0] == 200
        assert station.asked == [False]

    @pytest.mark.parametrize(
        ("path", "send", "status"),
        [
            ("/api/open", {"exercise": 3}, 400),
            ("/api/open", {"exercise": "slalom", "start": "yes"}, 400),
            ("/api/open", {"exercise": "slalom", "path": "/etc/passwd"}, 400),
            ("/api/open", [], 400),
            ("/api/open", {"exercise": "\ud800"}, 400),
            ("/api/help", {}, 400),
        ],
    )
    def test_what_makes_no_sense_is_refused(self, station, path, send, status):
        assert station.get(path, role="instructor", send=send)[0] == status
        assert station.get(path, "ann", send=send)[0] == 403
        assert station.get(path, role="instructor", send=send, kind="text/plain")[0] == 415
        assert station.asked == []
