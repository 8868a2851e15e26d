"""Damaged recordings: whatever a file has, reading, scoring and exporting end with a clear word."""

from __future__ import annotations

import contextlib
import io
import json
import math
import struct
import tempfile
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from training_truth import SCENE, Trial

from telex_training.command_lines import export, score
from telex_training.exercises.exercise_file import parse_exercise
from telex_training.recording.reader import read_recording, repair
from telex_training.recording.trial_file import EXERCISE, ROBOT, TRIAL, attachments
from telex_training.recording.trial_file import SCENE as SCENE_TEXT
from telex_training.recording.trial_file import Trial as About
from telex_training.recording.writer import Attachment, RecordingError, RecordingWriter

DRILL = """
title: Drill
zones: {start: {center: [0, 0, 0], size: [1, 2, 1]}}
begin: {not: {inside: {what: robot, zone: start}}}
steps: [{name: there, until: {moved: {what: robot, distance: 1}}}]
metrics: {time: {pass: 30}, contacts: {pass: 1}, tool_path: {}, sparc: {}}
scene:""" + SCENE.replace("\n", "\n  ")
URDF = "<robot name='r'><link name='base_link'/></robot>"
ABSURD = [math.nan, math.inf, -math.inf, 3e38, -3e38, 1e-44, 0.0]
pytestmark = pytest.mark.slow
quick = settings(
    max_examples=25, deadline=None, suppress_health_check=list(HealthCheck), derandomize=True
)


def recorded():
    """Entries and attachments of a short trial."""
    trial = Trial(parse_exercise(DRILL, Path("/exercises/drill.yaml")).first).begin()
    trial.drive(1.2, speed=1.0)
    about = About("t1", "/exercises/drill.yaml", "standard", "practice", "ann", "test", 7)
    return trial.entries, attachments(about, DRILL, SCENE, URDF, {}, {})


ENTRIES, ATTACHED = recorded()


def write(path, entries, attached=None, ending=None):
    path.unlink(missing_ok=True)
    writer = RecordingWriter(path, ATTACHED if attached is None else attached)
    for entry in entries:
        writer.put(entry, 1_700_000_000_000_000_000)
    writer.close(ending or {})
    return path


def run(main, *arguments):
    """Exit status and error output of a command; whatever it raises fails the test."""
    said = io.StringIO()
    with contextlib.redirect_stderr(said), contextlib.redirect_stdout(io.StringIO()):
        status = main([str(argument) for argument in arguments])
    return status, said.getvalue()


def survives(path):
    """Score and export a recording in every form; each failure names the file in one line."""
    for main, *options in (
        (score.main,),
        (score.main, "--json"),
        (score.main, "--csv"),
        (export.main, "--bag"),
        (export.main, "--csv"),
    ):
        output = path.with_suffix(".out")
        output.unlink(missing_ok=True)
        ending = ["-o", output] if main is export.main else []
        status, said = run(main, *options, *ending, path)
        assert status in (0, 1)
        assert (status == 0) == (said == ""), said
        if status:
            assert str(path.parent) in said
            assert said.count("\n") == 1
            # What was not exported to its end is not left behind as if it had been.
            assert not output.exists()


@pytest.fixture
def path(tmp_path):
    return tmp_path / "a.mcap"


def test_the_trial_that_is_damaged_is_a_whole_one(path):
    write(path, ENTRIES)
    assert run(score.main, path) == (0, "")
    survives(path)


@quick
@given(
    st.floats(0.0, 1.0),
    st.lists(st.tuples(st.floats(0.0, 1.0, exclude_max=True), st.integers(0, 255)), max_size=6),
)
def test_files_that_are_cut_off_or_have_other_bytes(keep, flips):
    with tempfile.TemporaryDirectory() as folder:
        path = write(Path(folder, "a.mcap"), ENTRIES)
        content = bytearray(path.read_bytes())
        for share, value in flips:
            content[int(share * len(content))] = value
        path.write_bytes(content[: round(keep * len(content))])
        survives(path)
        wrong = ""
        try:
            before = read_recording(path)
            assert repair(path).entries == before.entries
        except RecordingError as error:
            wrong = str(error)
        assert wrong == "" or folder in wrong


@st.composite
def disorders(draw):
    """Entries of the trial in another order, less or more of them, or other things in them."""
    made = list(ENTRIES)
    for _ in range(draw(st.integers(1, 4))):
        at = draw(st.integers(0, len(made) - 1))
        entry = made[at]
        change = draw(
            st.sampled_from("remove repeat move channel kind time number data truth".split())
        )
        if change == "remove" and len(made) > 2:
            made = made[:at] + made[at + draw(st.integers(1, 30)) :] or [entry]
        elif change == "repeat":
            made.insert(draw(st.integers(0, len(made))), entry)
        elif change == "move":
            made.insert(draw(st.integers(0, len(made) - 1)), made.pop(at))
        elif change == "channel":
            gone = entry.channel
            made = [each for each in made if each.channel != gone] or [entry]
        elif change == "kind":
            kinds = ["std_msgs/String", "telex_msgs/Nothing", "", "x", "geometry_msgs/Twist"]
            made[at] = entry._replace(kind=draw(st.sampled_from(kinds)))
        elif change == "time":
            times = st.sampled_from([0.0, 1e-9, 4.4e9, 1.8e10]) | st.floats(0.0, 1e9)
            made[at] = entry._replace(time=draw(times))
        elif change == "number":
            made[at] = entry._replace(number=draw(st.integers(0, 2**32 - 1)))
        elif change == "data":
            made[at] = entry._replace(data=draw(st.binary(max_size=120)))
        elif change == "truth":
            samples = [i for i, each in enumerate(made) if each.channel == "sim/truth"]
            for i in samples[:: draw(st.integers(1, 40))]:
                made[i] = made[i]._replace(data=absurd(draw, made[i].data))
    return made


def absurd(draw, data):
    """A truth sample in which some numbers are not: of float or double, anywhere in its bytes."""
    changed = bytearray(data)
    for _ in range(draw(st.integers(1, 3))):
        form = draw(st.sampled_from(["<f", "<d", "<I"]))
        size = struct.calcsize(form)
        at = draw(st.integers(0, max(0, len(changed) - size)))
        value = 2**32 - 1 if form == "<I" else draw(st.sampled_from(ABSURD))
        if len(changed) >= size:
            struct.pack_into(form, changed, at, value)
    return bytes(changed)


@quick
@given(disorders())
def test_entries_that_are_disordered_missing_or_absurd(entries):
    with tempfile.TemporaryDirectory() as folder:
        survives(write(Path(folder, "a.mcap"), entries))


TEXTS = st.sampled_from(
    [
        b"",
        b"\xff\xfe",
        b"null",
        b"[]",
        b"{",
        b"[" * 3000,
        b"<robot",
        b"<a/>",
        b"a: &b [*b]",
        b"objects: 3",
        b"{x: .nan}",
        json.dumps({"trial": "t", "setting": "none"}).encode(),
    ]
)


@quick
@given(
    st.dictionaries(
        st.sampled_from([EXERCISE, SCENE_TEXT, ROBOT, TRIAL]),
        st.none() | TEXTS | st.binary(max_size=60),
        min_size=1,
        max_size=2,
    )
)
def test_attachments_that_are_missing_or_other_things(changes):
    attached = dict(ATTACHED)
    for name, content in changes.items():
        del attached[name]
        if content is not None:
            attached[name] = Attachment("text/plain", content)
    with tempfile.TemporaryDirectory() as folder:
        survives(write(Path(folder, "a.mcap"), ENTRIES[:40], attached))


@pytest.mark.parametrize("seconds", [0.0, 4.4e9, 1.8e10])
def test_times_that_a_bag_cannot_have(path, seconds):
    write(path, [entry._replace(time=seconds) for entry in ENTRIES[:5]])
    survives(path)


@pytest.mark.parametrize("name", [EXERCISE, SCENE_TEXT, ROBOT, TRIAL])
@pytest.mark.parametrize(
    "content", [b"<robot", b"[" * 3000, b"\xff\xfe", b"[]"], ids=["xml", "deep", "bytes", "list"]
)
def test_attachments_that_cannot_be_used(path, name, content):
    write(path, ENTRIES[:10], {**ATTACHED, name: Attachment("text/plain", content)})
    survives(path)
    # A sheet needs all of them.
    status, said = run(score.main, path)
    assert status == 1
    assert said.startswith(f"score: {path}: ")


def test_a_sheet_that_is_another_thing_does_not_end_the_score(path):
    write(path, ENTRIES, ending={"sheet.json": Attachment("application/json", b"\xff[")})
    assert run(score.main, path) == (0, "")
