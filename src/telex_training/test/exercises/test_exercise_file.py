"""Exercise files: what they say, and that every mistake is named with what would be right."""

from __future__ import annotations

import contextlib
from pathlib import Path

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from telex_training.briefing.texts import unsaid
from telex_training.exercises.catalog import exercises, find_exercise
from telex_training.exercises.exercise_file import ExerciseError, load_exercise, parse_exercise
from telex_training.exercises.model import Failure, LineLink

pytestmark = pytest.mark.slow

PATH = Path("/exercises/drill.yaml")
LEAST = """
scene: floor
steps:
  - {name: go, until: {inside: {what: robot, zone: goal}, for: 0.5}}
zones:
  goal: {center: [3, 0, 0], radius: 0.5}
"""


def read(text):
    return parse_exercise(text, PATH)


def refusal(text):
    with pytest.raises(ExerciseError) as caught:
        read(text)
    message = str(caught.value)
    assert message.startswith("/exercises/drill.yaml: ")
    assert "\n" not in message
    return message[len("/exercises/drill.yaml: ") :]


def test_what_is_left_out_has_a_default():
    made = read(LEAST).first
    assert made.name == "drill"
    assert made.title == "drill"
    assert made.variant == "standard"
    assert made.modes == ("practice", "exam")
    assert made.settings == ("standard",)
    assert made.seeds.of("practice") == 1
    assert made.seeds.of("exam") is None
    assert made.begin.of.name == "command"
    assert made.repetitions.most == 10
    assert made.put_back.robot
    assert made.put_back.objects == ("all",)
    assert made.contacts.allows("tracks", "floor")
    assert not made.contacts.allows("base", "floor")
    assert made.steps[0].until.seconds == 0.5


def test_the_whole_format_is_read():
    made = read(
        LEAST
        + """
title: Drill
description: Drive there.
variant: inspection
mode: exam
seed: {practice: 3, exam: 12}
vary: [{object: robot, position: [0.1, 0.2, 0], yaw: 0.3}]
begin: {not: {inside: {what: robot, zone: goal}}}
any_order: true
repetitions: {most: 5, least: 2, trial_time: 600, time: 60}
put_back: {robot: false, objects: []}
faults: [{name: tipped, when: {tilted: {what: robot, angle: 1.0}, for: 0.5}}]
penalties: [{name: wall, when: {touches: {object: wall}}, seconds: 5}]
contacts: {allowed: [[any, floor], [gripper, any]]}
questions: [{name: ring, ask: Where is it open?, choices: [up, down], answer: up}]
metrics:
  time: {expert: [95, 14], pass: 130}
  wall_force: {kind: peak_force, object: wall, pass: 90, over: mean}
expert: {by: people, repetitions: 10}
hints: [{on: wall, text: Slower.}]
link: 300
malfunctions: [{when: {elapsed: 5}, what: arm, kind: frozen, announced: true}]
sources: [{object: capsule, nuclide: Co-60, activity: 3.7e13}]
limits: {dose: {robot: 2}}
history: {arm: 40}
"""
    ).first
    assert made.modes == ("exam",)
    assert made.seeds.of("exam") == 12
    assert made.vary[0].position == (0.1, 0.2, 0.0)
    assert made.any_order
    assert made.faults[0].when.of.angle == 1.0
    assert made.contacts.allows("gripper", "cube")
    assert made.questions[0].choices == ("up", "down")
    assert made.metrics[0].bound == 130.0
    assert made.metrics[1].kind == "peak_force"
    assert made.hints[0].on == "wall"
    assert made.link == LineLink(fields={"delay": 0.3})
    assert made.malfunctions[0].failure == Failure("arm", "frozen", announced=True)
    assert made.malfunctions[0].when.of.seconds == 5.0
    assert made.radiation.sources[0].activity == 3.7e13
    assert made.radiation.history == {"arm": 40.0}
    assert [fault.name for fault in made.faults] == ["tipped", "dose of robot"]
    assert made.faults[1].when.of.above == 2.0


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[1, 2]", "a struct with the key 'steps' is needed"),
        ("scene: floor", "steps is missing"),
        (LEAST + "malfunctions: [{what: arm, kind: dark}]", "malfunctions[0]/when is missing"),
        (
            LEAST + "malfunctions: [{when: {elapsed: 1}, what: arm, kind: dim}]",
            "malfunctions[0]: kind is 'dim'; weak, stuck, ",
        ),
        (
            LEAST + "malfunctions: [{when: {elapsed: 1}, what: arm, kind: dark, value: .nan}]",
            "malfunctions[0]/value is nan",
        ),
        (
            LEAST + "malfunctions: [{when: {elapsed: 1}, camera: arm, kind: dark}]",
            "malfunctions[0]/camera is unknown; known are announced, kind, robot, value, what",
        ),
        (LEAST + "goals: {}", "goals is unknown; known are"),
        (LEAST + "zone: {}", "zone is unknown; known are zones"),
        (LEAST.replace("scene: floor", ""), "scene is missing"),
        (LEAST.replace("scene: floor", "scene: 3"), "scene is '3'"),
        (LEAST.replace("radius: 0.5", ""), "zones/goal: size and radius are both given, or"),
        (LEAST.replace("radius: 0.5", "radius: -1"), "zones/goal: a length is -1.0"),
        (LEAST.replace("radius: 0.5", "radius: .nan"), "zones/goal/radius is nan; it must be"),
        (LEAST.replace("radius: 0.5", "radius: .inf"), "zones/goal/radius is inf; it must be"),
        (LEAST.replace("radius: 0.5", "round: 1"), "zones/goal/round is unknown; known are"),
        (LEAST.replace("zone: goal", "zone: gaol"), "inside: zone is 'gaol'; there are: goal"),
        (LEAST.replace("zone: goal", "zone: ''"), "inside: zone is ''; there are: goal"),
        (
            LEAST + "faults: [{name: a, when: {not: {touches: {object: floor, zone: gaol}}}}]",
            "faults[0] (a)/when/touches: zone is 'gaol'; there are: goal",
        ),
        (
            LEAST
            + "penalties: [{name: a, when: {dropped: {object: a, outside: [b]}}, seconds: 1}]",
            "penalties[0] (a)/when/dropped: zone is 'b'; there are: goal",
        ),
        (
            LEAST + "survey: {points: [goal, b], speed: 0.1}",
            "survey/points: zone is 'b'; there are: goal",
        ),
        (LEAST.replace("for: 0.5", "for: -1"), "steps[0] (go)/until/for is -1.0"),
        (LEAST.replace("inside:", "within:"), "steps[0] (go)/until/within is unknown; known are"),
        (LEAST.replace("what: robot, ", ""), "steps[0] (go)/until/inside/what is missing"),
        (LEAST.replace("for: 0.5", "held: {}"), "has inside and held; one condition is needed"),
        (LEAST.replace("until: {inside", "till: {inside"), "steps[0] (go)/till is unknown"),
        (LEAST.replace("name: go", "name: 3"), "steps[0]/name is 3; a string is needed"),
        (LEAST + "begin: {all: []}", "begin/all is '[]'; a list of conditions is needed"),
        (LEAST + "begin: {elapsed: soon}", "begin/elapsed is 'soon'; a number is needed"),
        (LEAST + "begin: {event: {name: rain}}", "begin/event: name is 'rain'; answer,"),
        (LEAST + "begin: {joint: {object: a, joint: b}}", "neither above nor below is given"),
        (
            LEAST + "sources: [{object: a, nuclide: U-235, activity: 1}]",
            "sources[0]: nuclide is 'U-235'; Co-60, Cs-137, Ir-192",
        ),
        (
            LEAST + "sources: [{object: a, nuclide: Co-60, activity: .nan}]",
            "sources[0]/activity is nan",
        ),
        (
            LEAST + "sources: [" + ",".join(2 * ["{object: a, nuclide: Co-60, activity: 1}"]) + "]",
            "sources[1]/object is 'a'; it has a source already",
        ),
        (LEAST + "limits: {force: 1}", "limits/force is unknown; known is dose"),
        (LEAST + "limits: {dose: {robot: 0}}", "limits/dose/robot is 0.0; above 0 (Gy)"),
        (LEAST + "history: {arm: -1}", "history/arm is -1.0; 0 or more (Gy)"),
        (LEAST + "mode: [test]", "mode is ['test']; practice and exam"),
        (LEAST + "seed: {exam: -1}", "seed/exam is '-1'; a whole number from 0, or drawn"),
        (LEAST + "seed: {practice: drawn}", "seed/practice is drawn; practice has a fixed one"),
        (LEAST + "seed: {test: 1}", "seed/test is unknown"),
        (LEAST + "metrics: {speed: {pass: 1}}", "metrics/speed/kind is 'speed'; time, penalties"),
        (LEAST + "metrics: {time: {pass: x}}", "metrics/time/pass is 'x'; a number is needed"),
        (LEAST + "metrics: {time: {bound: 1}}", "metrics/time/bound is unknown; known are expert"),
        (LEAST + "metrics: {time: {over: sum}}", "metrics/time: over is 'sum'; median, mean"),
        (LEAST + "metrics: {base_path_ratio: {}}", "length is missing"),
        (LEAST + "metrics: {time: {length: 3}}", "length does not belong to time"),
        (LEAST + "metrics: {time: {object: a}}", "object does not belong to time"),
        (LEAST + "penalties: [{name: a, when: {elapsed: 1}}]", "penalties[0] (a)/seconds is miss"),
        (LEAST + "faults: [{name: a, when: {elapsed: 1}, seconds: 2}]", "seconds is unknown"),
        (LEAST + "repetitions: {most: 3, least: 4}", "least is 4; it must be at least 1 and at"),
        (LEAST + "settings: []", "settings: a list of structs is needed"),
        (LEAST + "settings: [{lights: {}}]", "settings[0]/name is None; a string is needed"),
        (LEAST + "settings: [{name: a}, {name: a}]", "settings[1]/name is 'a'; another one has"),
        (LEAST + "settings: [{name: a, steps: []}]", "settings[0] (a): steps is []"),
        (LEAST + "settings: [{name: a, seps: []}]", "settings[0] (a): seps is unknown; known"),
        (LEAST + "objects: {cube: {type: crate}}", "name and type cannot be changed"),
        (LEAST + "vary: [{object: a, position: [-1, 0, 0]}]", "vary[0]: a span is -1.0; 0 to"),
        (LEAST + "a: &x 1\nb: *x", "anchors and aliases"),
        (LEAST + "title: one\ntitle: two", "'title' stands twice"),
        (LEAST + "limits: {dose: {robot: -1}}", "limits/dose/robot is -1.0"),
        (
            LEAST + "sources: [{object: a, nuclide: Co-60, activity: 0}]",
            "activity is 0.0; it must be",
        ),
        (LEAST + "questions: [{name: a, ask: ''}]", "ask is ''"),
        (LEAST + "title: " + "x" * 100, "title is"),
        (LEAST + "texts: {german: {go: los}}", "texts/german: a language's code of two letters"),
        (LEAST + "texts: {de: [los]}", "texts/de: a struct of texts by English ones"),
        (LEAST + "texts: {de: {go: 3}}", "texts/de/go is 3; a string is needed"),
        (LEAST + "texts: {de: {go: ' '}}", "texts/de/go has 0 characters; 1 to 2000 fit"),
        (LEAST + "settings: [{name: a, texts: {}}]", "settings[0] (a): texts: a setting has none"),
        ("x" * 300_000, "it has 300000 bytes; at most 200000 are read"),
    ],
)
def test_a_mistake_is_named(text, said):
    assert said in refusal(text)


def test_what_it_says_in_other_languages_is_found_by_what_it_says():
    file = read(
        LEAST
        + """
title: Drive to  the goal
texts:
  de: {go: los, Drive to the goal: "Zum Ziel", "goal|zone": Ziel, go there: dorthin}
  fr: {the robot: robot}
"""
    )
    assert file.texts["de"]["Drive to the goal"] == "Zum Ziel"
    assert [str(each) for each in unsaid(file)] == [
        "texts/de: 'go there' is nothing that the exercise says"
    ]
    assert read(LEAST).texts == {}


def test_a_mistake_in_what_settings_share_is_not_laid_to_them():
    wrong = LEAST.replace("for: 0.5", "for: -1") + "settings: [{name: a}]"
    assert refusal(wrong).startswith("steps[0] (go)/until/for is -1.0")


def test_settings_override_by_key():
    made = read(
        LEAST
        + """
metrics: {time: {pass: 100, expert: [50, 5]}, contacts: {pass: 1}}
begin: {not: {inside: {what: robot, zone: goal}}}
settings:
  - {name: easy}
  - name: hard
    metrics: {time: {pass: 60}, contacts: null}
    lights: {sun: {intensity: 0}}
    begin: {elapsed: 1}
    zones: {goal: {center: [5, 0, 0]}}
    steps: [{name: there, until: {elapsed: 9}}]
"""
    )
    easy, hard = made.setting("easy"), made.setting("hard")
    assert made.first is easy
    assert [metric.name for metric in easy.metrics] == ["time", "contacts"]
    (time,) = hard.metrics
    assert (time.bound, time.expert) == (60.0, (50.0, 5.0))
    assert hard.zones["goal"].center == (5.0, 0.0, 0.0)
    assert hard.zones["goal"].radius == 0.5
    assert hard.begin.kind == "elapsed"
    assert [step.name for step in hard.steps] == ["there"]
    assert hard.scene.changes == {"lights": {"sun": {"intensity": 0}}}
    assert easy.scene.changes == {}
    assert easy.sha256 == hard.sha256
    with pytest.raises(ExerciseError, match="setting is 'x'; there are: easy, hard"):
        made.setting("x")


def test_a_file_that_is_not_there_or_too_long_is_named(tmp_path):
    with pytest.raises(ExerciseError, match="No such file"):
        load_exercise(tmp_path / "none.yaml")
    long = tmp_path / "long.yaml"
    long.write_bytes(b"#" * 300_000)
    with pytest.raises(ExerciseError, match="at most 200000 are read"):
        load_exercise(long)


def test_the_catalogue_finds_shipped_and_own_exercises(tmp_path, monkeypatch):
    assert {"slalom", "hurdle", "cube_to_bin"} <= set(exercises())
    (tmp_path / "drill.yaml").write_text(LEAST)
    monkeypatch.setenv("TELEX_EXERCISE_PATH", str(tmp_path))
    assert find_exercise("drill") == tmp_path / "drill.yaml"
    with pytest.raises(ExerciseError, match="there is no exercise 'slalon'; there are: slalom"):
        find_exercise("slalon")


@pytest.mark.parametrize("name", sorted(exercises()))
def test_shipped_exercises_are_named_as_their_files(name):
    assert load_exercise(exercises()[name]).first.name == name


VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=3)
    | st.dictionaries(
        st.sampled_from(
            ["name", "until", "when", "inside", "what", "zone", "all", "not", "for", "size", "held"]
        ),
        inner,
        max_size=3,
    ),
    max_leaves=8,
)
KEYS = st.sampled_from(
    """scene steps zones begin faults penalties metrics settings hints questions vary seed mode
    repetitions contacts link malfunctions sources limits history objects put_back expert
    name""".split()
)


@pytest.mark.parametrize(
    ("text", "link", "described"),
    [
        ("", None, ""),
        ("link: perfect\n", LineLink(), "perfect"),
        ('link: "500"\n', LineLink("500"), "500"),
        ("link: 250\n", LineLink(fields={"delay": 0.25}), "perfect (delay 0.25)"),
        (
            "link: {profile: lossy, delay: 0.4}\n",
            LineLink("lossy", {"delay": 0.4}),
            "lossy (delay 0.4)",
        ),
    ],
)
def test_the_line_is_a_profile_a_delay_or_figures(text, link, described):
    made = read(LEAST + text).first.link
    assert made == link
    assert made is None or made.described == described


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("link: -5", "a delay (ms) of 0 or more"),
        ("link: .nan", "it must be finite"),
        ("link: true", "a number is needed"),
        ("link: [300]", "a number is needed"),
        ("link: {speed: 1}", "link/speed is unknown; known are profile, delay"),
        ("link: {delay: -1}", "link/delay is -1"),
        ("link: {profile: 300}", "link/profile is 300"),
    ],
)
def test_a_line_that_cannot_be_is_refused(text, said):
    with pytest.raises(ExerciseError) as error:
        read(LEAST + text + "\n")
    assert said in str(error.value)


@given(st.dictionaries(KEYS, VALUES, max_size=4))
def test_no_content_makes_the_reader_fail_otherwise(changes):
    content = {**yaml.safe_load(LEAST), **changes}
    with contextlib.suppress(ExerciseError):
        read(yaml.safe_dump(content))


@given(st.text(max_size=200))
def test_no_text_makes_the_reader_fail_otherwise(text):
    with pytest.raises(ExerciseError):
        read(text)
