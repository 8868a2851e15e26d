"""Texts of the instructor to the trainee, without a master."""

from __future__ import annotations

from types import SimpleNamespace
from unittest import mock

import genpy
import pytest

from telex_training.ros import texts as module
from telex_training.ros.texts import LONGEST, TraineeTexts


@pytest.fixture
def desk():
    """The services by their names, what was published, and what was noted of the trial."""
    published, noted, services = [], [], {}
    rospy = mock.Mock()
    rospy.Service = lambda name, _, answer: services.__setitem__(name, answer)
    at_second, team = [], ["", "/telex_b"]

    def publisher(topic, _, **__):
        shown = {"training/text": published, "/telex_b/training/text": at_second}[topic]
        return SimpleNamespace(publish=shown.append)

    def for_team(_, answer, name, robot):
        return lambda request: answer(request) if robot in team else f"{name}: not {robot}'s"

    def call(robot, name, **request):
        service = f"{robot}/training/{name}" if robot else f"training/{name}"
        return services[service](SimpleNamespace(**request))

    rospy.Publisher = publisher
    rospy.get_rostime.return_value = genpy.Time(7)
    with mock.patch.object(module, "rospy", rospy):
        names = {"": "Ann", "/telex_b": "Cid"}
        texts = TraineeTexts(noted.append, names.__getitem__, ["/telex_b"], lambda: team, for_team)
        yield SimpleNamespace(
            tell=lambda text, by="Bob", robot="": call(robot, "tell", text=text, by=by),
            read=lambda number, robot="": call(robot, "read", number=number),
            clear=texts.clear,
            published=published,
            at_second=at_second,
            noted=noted,
            team=team,
        )


def test_a_text_is_shown_until_it_is_read_and_both_are_noted(desk):
    answer = desk.tell("  <b>Stop</b>  ")
    assert (answer.success, answer.number) == (True, 1)
    shown = desk.published[-1]
    assert (shown.text, shown.by, shown.read) == ("<b>Stop</b>", "Bob", False)
    assert desk.read(1).success
    assert desk.published[-1].read
    assert desk.read(1).success, "a second press does no harm"
    assert len(desk.published) == 2
    assert desk.noted == [
        {"input": "note", "text": "said to the trainee: <b>Stop</b>", "by": "Bob"},
        {"input": "note", "text": "has read: <b>Stop</b>", "by": "Ann"},
    ]


def test_a_team_is_shown_one_text_and_whoever_reads_it_is_noted(desk):
    assert desk.tell("Slower", robot="/telex_b").success
    assert [each[-1].text for each in (desk.published, desk.at_second)] == ["Slower"] * 2
    assert desk.read(1, "/telex_b").success
    assert desk.published[-1].read
    assert desk.at_second[-1].read
    assert desk.noted[-1] == {"input": "note", "text": "has read: Slower", "by": "Cid"}


def test_a_robot_that_is_not_in_the_team_is_shown_no_text(desk):
    desk.tell("Slower")
    desk.team.remove("/telex_b")
    desk.clear()
    desk.tell("Ann, stop")
    shown = desk.at_second[-1]
    assert (shown.number, shown.text, shown.read) == (3, "", True)
    assert desk.tell("Stop", robot="/telex_b") == "training/tell: not /telex_b's"
    assert desk.read(3, "/telex_b") == "training/read: not /telex_b's"
    assert not desk.published[-1].read


def test_a_text_that_is_taken_back_needs_no_acknowledgement(desk):
    desk.tell("Stop")
    desk.tell("", by=" ")
    shown = desk.published[-1]
    assert (shown.number, shown.text, shown.by, shown.read) == (2, "", "instructor", True)
    for number in (1, 2):
        refused = desk.read(number)
        assert (refused.success, refused.message) == (
            False,
            f"number is {number}; the text that is shown has 2",
        )


def test_the_next_trainee_is_shown_nothing_of_the_one_before(desk):
    desk.clear()
    assert desk.published == [], "where nothing was said"
    desk.tell("Ann, stop")
    noted = list(desk.noted)
    desk.clear()
    desk.clear()
    assert len(desk.published) == 2
    shown = desk.published[-1]
    assert (shown.number, shown.text, shown.by, shown.read) == (2, "", "", True)
    assert desk.noted == noted, "it is no act of anybody in a trial"
    assert not desk.read(1).success
    assert desk.tell("Bob, go").number == 3
    assert not desk.published[-1].read


@pytest.mark.parametrize("text", ["x" * (LONGEST + 1), "two\nlines", "turned \u202e round", "\x00"])
def test_what_is_no_line_is_refused(desk, text):
    refused = desk.tell(text)
    assert not refused.success
    assert f"one line of at most {LONGEST}" in refused.message
    assert desk.published == desk.noted == []


def test_nothing_can_be_read_before_anything_was_said(desk):
    assert not desk.read(0).success
