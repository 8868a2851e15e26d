"""The pages' tables of other languages have all that the pages say, and nothing else."""

from __future__ import annotations

import ast
import json
import re
from html.parser import HTMLParser
from pathlib import Path

import pytest
import yaml

from telex_sim.scene.library import object_types
from telex_sim.scene.type_texts import summary
from telex_teleop.actions.vocabulary import Vocabulary
from telex_training.briefing import words
from telex_training.briefing.texts import exercise_texts
from telex_training.exercises.exercise_file import load_exercise
from telex_training.judging.records import aids

SRC = Path(__file__).resolve().parents[1] / "src"
CONSOLE = SRC / "telex_teleop/console"
LANGUAGE = CONSOLE / "js/language"
PAGES = (CONSOLE, SRC / "telex_training/pages")
LANGUAGES = sorted(path.stem for path in LANGUAGE.glob("??.js"))
STRING = r'"(?:[^"\\]|\\.)*"'
ATTRIBUTES = ("title", "aria-label", "placeholder", "alt", "label")

# Names of the product and of a language's code, and what `language/page.js` leaves alone.
AS_THEY_ARE = {"TELEX", "EN"}
UNTRANSLATED = ("script", "style")

# Modules whose sentences people read on the pages, and to what they give them.
SPEAKERS = (
    "telex_training/src/telex_training/judging/judge.py",
    "telex_training/src/telex_training/ros/apparatus.py",
    "telex_training/src/telex_training/ros/exam/exam_list.py",
    "telex_training/src/telex_training/ros/session.py",
    "telex_training/src/telex_training/ros/texts.py",
    "telex_training/src/telex_training/ros/training_node.py",
    "telex_training/src/telex_training/ros/trial/bookmarks.py",
    "telex_training/src/telex_training/ros/trial/team.py",
    "telex_sim/src/telex_sim/ros/arranging.py",
    "telex_sim/src/telex_sim/ros/simulator_node.py",
    "telex_teleop/src/telex_teleop/arm/arm_teleop.py",
    "telex_teleop/src/telex_teleop/arm/tool_slowdown.py",
    "telex_teleop/src/telex_teleop/motion/teleop_core.py",
    "telex_teleop/src/telex_teleop/web/bridge/clients/control.py",
    "telex_teleop/src/telex_teleop/web/bridge/topics/commands.py",
)
TOLD_BY = (
    "ApparatusError",
    "CommandOverdueError",
    "CommandRefusedError",
    "CommandUncertainError",
    "ControlError",
    "ExamListError",
    "ModeError",
    "SessionError",
    "_invalidate",
    "_refuse",
)

# Types of objects that the instructor's page does not offer.
MADE_OF_PARAMETERS = ("custom", "mesh")


class Markup(HTMLParser):
    """Gathers the sentences of a page."""

    def __init__(self):
        super().__init__()
        self.found = []
        self._inside = []

    def handle_starttag(self, tag, attrs):
        if tag in UNTRANSLATED or "data-binding" in dict(attrs):
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


def said_by_conditions():
    """Return the sentences that briefs make of conditions."""
    tree = ast.parse(Path(words.__file__).read_text())
    skipped = {
        id(part)
        for node in ast.walk(tree)
        if isinstance(node, ast.JoinedStr)
        for part in node.values
    }
    skipped |= {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    texts = [
        node.value
        for node in ast.walk(tree)
        if isinstance(node, ast.Constant)
        and isinstance(node.value, str)
        and id(node) not in skipped
    ]
    return {text for text in texts if " " in text or "{" in text}


def said_by_files():
    """Return what shipped exercises, courses and scenes say, and which of them says it."""
    found = {}
    for path in sorted((SRC / "telex_training/exercises").glob("*.yaml")):
        for exercise in load_exercise(path).settings.values():
            found.update((each, f"exercise {path.stem}") for each in exercise_texts(exercise))
    for path in sorted((SRC / "telex_training/curricula").glob("*.yaml")):
        course = yaml.safe_load(path.read_text())
        names = [course["title"], *(module["name"] for module in course["modules"])]
        found.update((each, f"curriculum {path.stem}") for each in names)
    for path in sorted((SRC / "telex_sim/scenes").glob("*.yaml")):
        scene = yaml.safe_load(path.read_text())
        found.update((each, f"scene {path.stem}") for each in (scene["name"], scene["description"]))
    found.update((each, "aid of a sheet") for each in aids.WORDS.values())
    presets = yaml.safe_load((SRC / "telex_teleop/config/flipper_presets.yaml").read_text())
    found.update((each["description"], f"preset {each['name']}") for each in presets["presets"])
    for name, kind in object_types().items():
        group = kind.__module__.split(".")[-2]
        if name not in MADE_OF_PARAMETERS:
            label = f"{name.replace('_', ' ')}|type"
            found.update(
                (each, f"type {name}") for each in (label, f"{group}|group", summary(kind))
            )
    # Marks that stand on objects, such as S1, are the same in every language.
    return {
        each: whose
        for each, whose in found.items()
        if re.search(r"[a-z]", re.sub(r"\{\w+\}", "", each.split("|")[0]))
    }


def said_by_module(path):
    """Yield the sentences that a module tells, with {} for values."""

    def form(node):
        if isinstance(node, ast.JoinedStr):
            parts = (part.value if isinstance(part, ast.Constant) else "{}" for part in node.values)
            return "".join(parts)
        return node.value if isinstance(getattr(node, "value", None), str) else ""

    def names(nodes):
        return {getattr(node, "attr", getattr(node, "id", "")) for node in nodes}

    for node in ast.walk(ast.parse((SRC / path).read_text())):
        if isinstance(node, ast.Call):
            told = list(node.args) if names([node.func]) & set(TOLD_BY) else []
            told += [word.value for word in node.keywords if word.arg == "message"]
        elif isinstance(node, ast.Assign) and names(node.targets) & {"message", "_message"}:
            told = [node.value]
        else:
            continue
        yield from (form(each) for each in told)


def table(language):
    """Return a table of translations, whose files are JSON but for their frames and comments."""
    files = (f"{language}.js", f"exercises_{language}.js")
    source = "".join((LANGUAGE / file).read_text() for file in files)
    lines = re.findall(rf"^  ({STRING}): ({STRING}),$", source, re.M)
    pairs = [(json.loads(key), json.loads(value)) for key, value in lines]
    assert len(lines) == sum(line.startswith('  "') for line in source.splitlines())
    assert len(dict(pairs)) == len(pairs), "a sentence is there twice"
    return dict(pairs)


@pytest.fixture(scope="module")
def files():
    return said_by_files()


@pytest.fixture(scope="module")
def said(files):
    everything = said_by_code() | said_by_markup() | said_by_actions() | said_by_conditions()
    everything |= set(files)
    return {each for each in everything if re.search(r"[^\W\d_]", re.sub(r"\{\w+\}", "", each))}


@pytest.mark.parametrize("language", LANGUAGES)
def test_a_language_has_all_that_is_said_and_nothing_else(language, said, files):
    there = set(table(language))
    lacking = sorted(f"{whose}: {each!r}" for each, whose in files.items() if each not in there)
    assert not lacking, f"language/exercises_{language}.js lacks:\n" + "\n".join(lacking)
    assert sorted(said - there) == [], f"language/{language}.js lacks them"
    assert sorted(there - said) == [], f"nobody says them: take them out of language/{language}.js"


@pytest.mark.parametrize("path", SPEAKERS)
def test_what_a_node_tells_people_is_in_the_tables(path):
    known = {re.sub(r"\{\w+\}", "{}", each) for each in table(LANGUAGES[0])}

    def is_known(form):
        plain = re.search(r"[a-z]{3}", form) is None or re.fullmatch(r"[\w.]+", form)
        parts = re.split("; |: ", form, maxsplit=1)
        return plain or form in known or (len(parts) > 1 and all(map(is_known, parts)))

    lacking = [form for form in said_by_module(path) if not is_known(form)]
    assert not lacking, "language/words.js and the tables lack:\n" + "\n".join(lacking)


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
