"""The pages' tables of other languages have all that the pages say, and nothing else."""

from __future__ import annotations

import json
import re
from html.parser import HTMLParser
from pathlib import Path

import pytest

from telex_teleop.actions.vocabulary import Vocabulary

SRC = Path(__file__).resolve().parents[3]
CONSOLE = SRC / "telex_teleop/console"
LANGUAGE = CONSOLE / "js/language"
PAGES = (CONSOLE, SRC / "telex_training/pages")
LANGUAGES = sorted(path.stem for path in LANGUAGE.glob("??.js"))
STRING = r'"(?:[^"\\]|\\.)*"'
ATTRIBUTES = ("title", "aria-label", "placeholder", "alt")

# Names of the product and of a language's code, and what `language/page.js` leaves alone.
AS_THEY_ARE = {"TELEX", "EN"}
UNTRANSLATED = ("script", "style", "kbd")


class Markup(HTMLParser):
    """Gathers the sentences of a page."""

    def __init__(self):
        super().__init__()
        self.found = []
        self._inside = []

    def handle_starttag(self, tag, attrs):
        if tag in UNTRANSLATED:
            self._inside.append(tag)
        self.found += [value for name, value in attrs if name in ATTRIBUTES and value]

    def handle_endtag(self, tag):
        if self._inside and self._inside[-1] == tag:
            self._inside.pop()

    def handle_data(self, data):
        if not self._inside:
            self.found.append(" ".join(data.split()))


def said_by_code():
    """Return what modules pass to text() or term(), and the words that servers say."""
    found = []
    for folder in PAGES:
        for path in folder.rglob("*.js"):
            source = path.read_text()
            found += re.findall(rf"\b(?:text|term)\(\s*({STRING})", source)
    found += re.findall(STRING, (LANGUAGE / "words.js").read_text())
    return {json.loads(each) for each in found}


def said_by_markup():
    """Return the texts and titles of all pages."""
    found = set()
    for folder in PAGES:
        for path in folder.rglob("*.html"):
            page = Markup()
            page.feed(path.read_text())
            found.update(page.found)
    return found - AS_THEY_ARE


def said_by_actions():
    """Return the titles, and where they are shown the labels and rows, of the shipped actions."""
    told = Vocabulary.read().as_json()
    found = {mode[part] for mode in told["modes"] for part in ("name", "note")}
    found |= {layout["name"] for layout in told["layouts"]}
    for action in told["actions"]:
        # A flipper's own motion, which a terminal has a key for, is named where one side is chosen.
        if action["code"] is None and action["does"]["kind"] != "jog":
            continue
        found |= {action["title"]}
        if action["code"] is not None:
            found |= {action["group"]}
        if action["code"] is not None and ":" in action["name"]:
            found |= {action["label"], action["row"]}
    return found


def table(language):
    """Return a table of translations, whose file is JSON but for its frame and its comments."""
    source = (LANGUAGE / f"{language}.js").read_text()
    lines = re.findall(rf"^  ({STRING}): ({STRING}),$", source, re.M)
    pairs = [(json.loads(key), json.loads(value)) for key, value in lines]
    assert len(lines) == sum(line.startswith('  "') for line in source.splitlines())
    assert len(dict(pairs)) == len(pairs), "a sentence is there twice"
    return dict(pairs)


@pytest.fixture(scope="module")
def said():
    everything = said_by_code() | said_by_markup() | said_by_actions()
    return {each for each in everything if re.search(r"[^\W\d_]", re.sub(r"\{\w+\}", "", each))}


@pytest.mark.parametrize("language", LANGUAGES)
def test_a_language_has_all_that_is_said_and_nothing_else(language, said):
    there = set(table(language))
    assert sorted(said - there) == [], f"language/{language}.js lacks them"
    assert sorted(there - said) == [], f"nobody says them: take them out of language/{language}.js"


@pytest.mark.parametrize("language", LANGUAGES)
def test_translations_have_the_values_of_the_english_sentences(language):
    def values(sentence):
        return sorted(re.findall(r"\{\w+\}", sentence))

    wrong = [k for k, said in table(language).items() if values(k) != values(said) or not said]
    assert wrong == []


def test_no_sentence_is_put_together_of_marked_up_pieces():
    """What text() is given must stand there as it is: the tables are made from it."""
    for folder in PAGES:
        for path in folder.rglob("*.js"):
            assert not re.search(r"\b(?:text|term)\(\s*`[^|`]*`", path.read_text()), path.name
