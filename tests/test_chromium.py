"""The browser that benchmarks, suites and reports drive."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any, Dict, Iterator, List

import cv2
import numpy as np
import pytest

from telex_experiments.rigs.chromium import BrowserError, Chromium, code_of, lacking

pytestmark = [
    pytest.mark.browser,
    pytest.mark.skipif(bool(lacking()), reason=lacking() or "there is a browser"),
]

PAGE = """<!doctype html><head>
<meta http-equiv="Content-Security-Policy" content="script-src 'self' 'unsafe-inline'">
</head><body style="margin: 0; background: rgb(0, 0, 255); height: 2000px">
<button onclick="window.clicked = true; console.error('pressed', 3)">press</button>
<script>
  window.keys = [];
  for (const kind of ["keydown", "keyup"])
    addEventListener(kind, (event) => keys.push([kind, event.code, event.key]));
</script>
"""


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Chromium]:
    page = tmp_path_factory.mktemp("page") / "page.html"
    page.write_text(PAGE)
    script = "window.before = location.protocol;"
    with Chromium(
        page.as_uri(), size=(400, 300), script=script, exact=True, listens=True
    ) as browser:
        browser.wait_for("the page", "window.keys !== undefined")
        yield browser


def test_a_picture_has_the_size_that_was_asked_for(browser: Chromium) -> None:
    picture = cv2.imdecode(np.frombuffer(browser.screenshot(), np.uint8), cv2.IMREAD_COLOR)
    assert picture.shape == (300, 400, 3)
    # No scroll bar at the right, although the page is longer.
    assert picture[250, 399].tolist() == [255, 0, 0]


def test_a_script_runs_before_the_page(browser: Chromium) -> None:
    assert browser.evaluate("window.before") == "file:"


def test_keys_come_by_their_position_and_their_sign(browser: Chromium) -> None:
    browser.evaluate("keys.length = 0")
    for code in ("KeyW", "Escape", "Home"):
        browser.press(code)
        browser.release(code)
    wanted = [["KeyW", "w"], ["Escape", "Escape"], ["Home", "Home"]]
    assert browser.wait_for("all keys", "keys.length === 6 && keys") == [
        [kind, *key] for key in wanted for kind in ("keydown", "keyup")
    ]


def test_a_click_and_what_the_page_complains_of(browser: Chromium) -> None:
    browser.click("button")
    assert browser.evaluate("window.clicked") is True
    browser.evaluate("setTimeout(() => { throw new Error('spilt') })")
    end = time.monotonic() + 10.0
    while len(browser.complaints) < 2 and time.monotonic() < end:
        time.sleep(0.05)
    pressed, spilt = browser.complaints
    assert pressed == "pressed 3"
    assert "Error: spilt" in spilt
    with pytest.raises(BrowserError, match="null"):
        browser.click("#nothing")


def test_enter_presses_a_button_and_a_promise_is_waited_for(browser: Chromium) -> None:
    browser.evaluate("window.clicked = false; document.querySelector('button').focus()")
    browser.handled(browser.key("keyDown", code_of("Enter")))
    assert browser.evaluate("window.clicked") is True
    browser.release("Enter")
    slow = "new Promise((resolve) => setTimeout(() => resolve(7), 20))"
    assert browser.evaluate(slow) == 7
    assert [code_of(key) for key in ("w", "`", "PageUp")] == ["KeyW", "Backquote", "PageUp"]


def test_another_page_is_loaded(browser: Chromium, tmp_path: Path) -> None:
    other = tmp_path / "other.html"
    other.write_text("<title>other</title>")
    browser.call("Network.enable")
    browser.go(other.as_uri())
    assert browser.evaluate("document.title") == "other"
    assert other.as_uri() in browser.addresses
    with pytest.raises(BrowserError, match="nothing: .*NOT_FOUND"):
        browser.go("file:///nothing")


def test_what_a_page_that_loads_itself_anew_pushed_aside_is_asked_for_again(
    browser: Chromium, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    other = tmp_path / "other.html"
    other.write_text("<title>again</title>")
    # What Chromium answers where a page goes its own way in the very moment (one time in 119).
    asked: List[str] = []
    ask = browser.call

    def call(method: str, **parameters: Any) -> Dict[str, Any]:
        asked.append(method)
        aside = asked == ["Page.navigate"]
        return {"errorText": "net::ERR_ABORTED"} if aside else ask(method, **parameters)

    monkeypatch.setattr(browser, "call", call)
    browser.go(other.as_uri())
    assert asked == ["Page.navigate", "Page.navigate"]
    assert browser.evaluate("document.title") == "again"


def test_a_browser_has_processes_of_its_own(browser: Chromium) -> None:
    kinds = browser.processes()
    assert set(browser.renderers()) < set(kinds)
    assert kinds[browser.pid] == "browser"
    assert browser.cpu() > 0.0


def test_there_may_be_no_browser(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(BrowserError, match="apt-get install chromium"):
        Chromium("about:blank")
