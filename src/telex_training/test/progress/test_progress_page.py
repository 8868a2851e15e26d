"""The page of progress, as the video server asks for it: everybody sees their own."""

import json
import urllib.error
import urllib.parse
import urllib.request

import pytest
from recorded_trials import record

from telex_training.ros.library import Library
from telex_training.ros.pages.class_pages import ClassPages
from telex_training.ros.pages.training_pages import TrainingPages

pytestmark = pytest.mark.waiting


@pytest.fixture(scope="module")
def ask(tmp_path_factory):
    folder = tmp_path_factory.mktemp("recordings")
    record(folder, "ann", exercise="slalom", setting="cones_3", times=[(30.0, True)] * 7)
    record(folder, "Bäb, the 2nd")
    (folder / "bad.mcap").write_text("nonsense")
    pages = TrainingPages(Library(folder), folder, 0, print, ClassPages(dict, str, print))
    pages.start()

    def ask(query="", name="", role="operator"):
        headers = {"X-Telex-Role": role, "X-Telex-Name": urllib.parse.quote(name)}
        address = f"{pages._address}/progress/{query}"
        try:
            with urllib.request.urlopen(urllib.request.Request(address, headers=headers)) as reply:
                return reply.status, reply.read().decode(), reply.headers
        except urllib.error.HTTPError as error:
            return error.code, error.read().decode(), error.headers

    yield ask
    pages.close()


def test_operators_see_their_own(ask):
    status, text, headers = ask(name="ann")
    assert status == 200
    assert "<h1>ann</h1>" in text
    assert "slalom, day: 2 passed in a row" in text
    assert "the 2nd" not in text
    assert headers["Cache-Control"] == "no-store"
    assert "default-src 'none'" in headers["Content-Security-Policy"]


def test_names_of_any_letters_are_found(ask):
    status, text, _ = ask(name="Bäb, the 2nd")
    assert status == 200
    assert "1 trial from 2026-03-01" in text


@pytest.mark.parametrize("name", ["Bäb, the 2nd", "", "nobody"])
def test_operators_do_not_see_others(ask, name):
    status, text, _ = ask("?person=ann", name=name)
    assert status == 404
    assert "2026-03-01" not in text
    status, text, _ = ask("?person=nobody", name=name)
    assert status == (200 if name == "nobody" else 404)


def test_without_a_name_there_is_nothing_to_see(ask):
    assert ask()[:2] == (404, "Progress is shown by name: ?name=YOUR-NAME\n")


def test_instructors_see_the_class_and_everybody_in_it(ask):
    status, text, _ = ask(role="instructor", name="ann")
    assert status == 200
    assert "2 people, 2 trials" in text
    status, text, _ = ask("?person=ann", role="instructor")
    assert "<h1>ann</h1>" in text


def test_instructors_are_told_where_everybody_stands(ask):
    status, text, _ = ask("api/standing", role="instructor")
    assert status == 200
    begun = {course["name"]: course for course in json.loads(text)}
    # Nobody has begun the others.
    assert begun.keys() == {"telex_basic"}
    course = begun["telex_basic"]
    assert course["people"].keys() == {"ann"}
    assert dict(zip(course["modules"], course["people"]["ann"]))["slalom"] == "open"
