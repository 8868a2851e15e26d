"""The page of a class in headless Chromium, with stand-ins for the stations."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from waiting import wait_until

from telex_experiments.classroom.stand_in_station import StandInStation, beside
from telex_experiments.rigs import chromium

pytestmark = [
    pytest.mark.browser,
    pytest.mark.waiting,
    pytest.mark.skipif(bool(chromium.lacking()), reason=chromium.lacking()),
]

COMMAND = Path(__file__).parents[2] / "nodes" / "class"
RUNNING = {
    "phase": "running",
    "title": "Slalom",
    "setting": "day",
    "mode": "exam",
    "operator": "ann",
    "repetition": 2,
    "repetitions": 5,
    "results": ["passed"],
    "elapsed": 42.3,
    "steps": ["out", "back"],
    "steps_done": [True, False],
}
COURSE = {"name": "c", "title": "Basic", "modules": ["slalom"], "people": {"ann": ["working"]}}
PICTURE = Path(__file__).parents[4] / "docs" / "images" / "console_driving.jpg"


@pytest.fixture
def stations():
    picture = PICTURE.read_bytes()
    stations = [
        StandInStation([RUNNING], picture, courses=[COURSE]),
        StandInStation([{**RUNNING, "operator": "<b>bob", "help": 30.0}], picture, "sesame"),
        StandInStation([{"phase": "idle"}]),
    ]
    with beside(stations):
        yield stations


@pytest.fixture
def page(stations, tmp_path):
    token = tmp_path / "token"
    token.write_text("sesame")
    token.chmod(0o600)
    lines = [f"  - {{name: s{i}, address: '{s.address}'}}" for i, s in enumerate(stations)]
    lines[1] = lines[1].replace("}", ", token_file: token}")
    file = tmp_path / "stations.yaml"
    file.write_text("\n".join(["stations:", *lines]))
    own = tmp_path / "own"
    command = [sys.executable, str(COMMAND), str(file), "--port", "0", "--token-file", str(own)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
        try:
            address = server.stdout.readline().split()[-1]
            assert address.endswith(f"?token={own.read_text().strip()}")
            with chromium.Chromium(address, size=(1280, 900)) as browser:
                yield browser
        finally:
            server.terminate()
            assert server.wait(10.0) == 0


def text(page, station, part):
    return page.evaluate(
        f"document.querySelector('[data-station={station}] .{part}')?.textContent ?? ''"
    )


def outcome(page, row):
    return page.evaluate(f"document.querySelectorAll('#order-rows tr')[{row}].cells[3].textContent")


def test_an_instructor_sees_the_class_gives_help_and_opens_an_exercise(stations, page):
    page.wait_for("the page", "document.getElementById('counts') !== null")
    wait_until(lambda: "3 of 3 stations" in page.evaluate("counts.textContent"), "the stations")
    assert text(page, "s0", "about") == "Slalom · day · EXAM"
    assert text(page, "s0", "clock") == "running · repetition 2 of 5 · 00:42 · ✔"
    assert text(page, "s0", "step") == "step 2/2: back"
    # What somebody calls himself is text.
    assert text(page, "s1", "who") == "<b>bob"
    assert text(page, "s2", "clock") == "no exercise is open"
    assert "1 asks for help" in page.evaluate("counts.textContent")
    shown = "document.querySelector('[data-station=s1] img').naturalWidth"
    wait_until(lambda: page.evaluate(shown), "a picture")

    page.click("[data-station=s1] .help button")
    wait_until(lambda: "help" not in page.evaluate("counts.textContent"), "that help was given")
    assert stations[1].sent == [{"help": False}]

    page.click("#progress summary")
    state = "document.querySelector('#courses td')?.title"
    wait_until(lambda: page.evaluate(state) == "working", "the progress")
    assert "Basic" in page.evaluate("courses.textContent")

    page.click("#order-open")
    page.wait_for("the exercises", "document.getElementById('order-exercise').options.length > 3")
    page.click("#order-send")
    page.wait_for("what is wrong", "document.getElementById('order-note').textContent")
    assert page.evaluate("document.getElementById('order-note').textContent") == (
        "choose a station at least"
    )
    page.evaluate(
        "document.getElementById('order-exercise').value = 'gap';"
        "document.getElementById('order-exercise').dispatchEvent(new Event('change'));"
    )
    for row in (0, 2):
        page.click(f"#order-rows tr:nth-child({row + 1}) input[type=checkbox]")
    page.evaluate(
        "document.querySelectorAll('#order-rows tr')[2].cells[2].firstChild.value = 'eve'"
    )
    page.click("#order-send")
    for row in (0, 2):
        wait_until(lambda: "done" in outcome(page, row), "the outcome")  # noqa: B023
    assert outcome(page, 1) == ""
    assert [each.sent[-1]["operator"] for each in (stations[0], stations[2])] == ["ann", "eve"]
    assert stations[0].sent[-1]["exercise"] == "gap"
    page.click("#order-close")

    link = "document.querySelector('[data-station=s1] h2 a')"
    page.evaluate(f"setTimeout(() => {{ location.href = {link}.href; }})")
    wait_until(lambda: page.evaluate("document.title") == "Telex instructor", "the station's page")
    assert page.evaluate("location.search") == "?role=instructor&token=sesame"
