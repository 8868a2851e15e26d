"""The console in headless Chromium, before a robot that is played: what its tests share."""

from __future__ import annotations

import contextlib
import json
from urllib.parse import urlsplit

import pytest
from waiting import wait_until
from web_harness import Ros
from web_robot import Robot, describe

from telex_experiments.rigs.chromium import Chromium, code_of, lacking

NOTHING = "\N{EN DASH}"
"""Stands in place of a figure that is not known."""

OTHER = """
const [url] = arguments;
window.other = new WebSocket(url);
other.ask = (name) => new Promise((resolve) => {
  other.onmessage = ({data}) => {
    const answer = JSON.parse(data);
    if (answer.op === "service_response") resolve(answer.values.success);
  };
  other.send(JSON.stringify({op: "call_service", service: `/telex/bridge/${name}`}));
});
return new Promise((done) => { other.onopen = () => done(true); });
"""
"""Opens, in a page, a connection of somebody else, who can ask for control."""

DEAD_NETWORK = """
const send = WebSocket.prototype.send;
let socket, isDead = true;
WebSocket.prototype.send = function (text) {
  socket = this;
  if (!isDead) send.call(this, text);
};
window.revive = () => {
  isDead = false;
  socket.close();
};
"""
"""Lets a page's bridge hear nothing more of it, until its revive() ends that connection."""

LET_GO = """
window.letGo = 0;
addEventListener("DOMContentLoaded", async () => {
  const log = document.getElementById("log");
  if (log === null) return;
  const said = /released: |losgelassen: |relâché : |press it again/;
  new MutationObserver((changes) => {
    const lines = changes.flatMap(({addedNodes}) => [...addedNodes]);
    window.letGo += lines.filter(({title}) => said.test(title)).length;
  }).observe(log, {childList: true});
  const {isStale, stoodStill} = await import("/js/deadman.js");
  for (const kind of ["keydown", "pointerdown"]) {
    addEventListener(kind, (event) => {
      if (isStale(event) || stoodStill()) window.letGo += 1;
    }, {capture: true});
  }
});
"""
"""Counts, in every page, what has to be pressed anew.

That is whatever the page says that it has let go, or a node that it does not obey; the log's own
count leaves out what is said again within a second. And it is what was pressed while the page stood
still, of which the page says nothing.
"""

SHIFT = 8
"""Of the keys that are down while a mouse is used."""

SHOWN = "element.checkVisibility({visibilityProperty: true, opacityProperty: true})"
TEXT = f"{SHOWN} ? element.innerText.replaceAll('\\u00a0', ' ').trim() : ''"
IS_DISPLAYED = f"{SHOWN} && element.getBoundingClientRect().width > 0"
MIDDLE = """(() => {
  element.scrollIntoView({block: "nearest", inline: "nearest", behavior: "instant"});
  const {left, top, width, height} = element.getBoundingClientRect();
  const [x, y] = [left + width / 2, top + height / 2];
  const hit = document.elementFromPoint(x, y);
  return [x, y, element.contains(hit) ? "" : `under ${hit?.outerHTML.slice(0, 100)}`];
})()"""
"""Where the middle of an element is (px), and what hides it."""
SET = """[element.value = arguments[0], ...["input", "change"]
  .map((kind) => element.dispatchEvent(new Event(kind, {bubbles: true})))]"""


class Element:
    """The first element of a selector on a page, looked for whenever it is asked for something.

    LookupError says that there is none.
    """

    def __init__(self, page, selector):
        self._page = page
        self._selector = selector

    def ask(self, expression, *arguments):
        """Return the value of an expression in which it is `element`."""
        found = self._page.script(
            f"const element = document.querySelector({json.dumps(self._selector)});"
            f"return element && {{value: {expression}}};",
            *arguments,
        )
        if found is None:
            raise LookupError(f"the page has no {self._selector}")
        return found.get("value")

    @property
    def text(self):
        """What can be read."""
        return self.ask(TEXT)

    def is_displayed(self):
        return self.ask(IS_DISPLAYED)

    def is_enabled(self):
        return self.ask("!element.matches(':disabled')")

    def get_attribute(self, name):
        """Return an attribute, or the property of that name; empty where there is neither."""
        return self.ask("element.getAttribute(arguments[0]) ?? element[arguments[0]] ?? ''", name)

    def get_property(self, name):
        return self.ask("element[arguments[0]]", name)

    def click(self):
        """Click with the mouse: on its middle, which nothing may hide once the page is laid out."""
        x = y = hidden = None

        def uncovered():
            nonlocal x, y, hidden
            x, y, hidden = self.ask(MIDDLE)
            return not hidden

        wait_until(uncovered, lambda: f"to see {self._selector}, which is {hidden}", 5.0)
        self._page.mouse("mouseMoved", x, y, buttons=0)
        self._page.mouse("mousePressed", x, y)
        self._page.mouse("mouseReleased", x, y, buttons=0)

    @contextlib.contextmanager
    def held(self, modifiers=0):
        """Hold it with the mouse; gives a function that moves the mouse by so many pixels."""
        x, y, _ = self.ask(MIDDLE)

        def move(right, down):
            nonlocal x, y
            x, y = x + right, y + down
            self._page.mouse("mouseMoved", x, y, modifiers=modifiers)

        self._page.mouse("mouseMoved", x, y, buttons=0, modifiers=modifiers)
        self._page.mouse("mousePressed", x, y, modifiers=modifiers)
        try:
            yield move
        finally:
            self._page.mouse("mouseReleased", x, y, buttons=0, modifiers=modifiers)

    def drag(self, right, down, modifiers=0):
        """Drag with the mouse by so many pixels, from its middle."""
        with self.held(modifiers) as move:
            move(right, down)

    def wheel(self, down):
        """Turn the mouse's wheel over it, by so many pixels."""
        x, y, _ = self.ask(MIDDLE)
        self._page.mouse("mouseWheel", x, y, buttons=0, deltaX=0, deltaY=down)

    def type(self, text):
        """Type into it; a line ends with Enter."""
        *lines, rest = text.split("\n")
        for line in lines:
            self._insert(line)
            self.press("Enter")
        self._insert(rest)

    def _insert(self, text):
        self.ask("element.focus()")
        if text:
            self._page.browser.call("Input.insertText", text=text)

    def press(self, *keys):
        """Press keys, one after the other, while it has the focus."""
        self.ask("element.focus()")
        for key in keys:
            self._page.press(key)

    def set(self, value):
        """Choose a value; an empty one clears a field."""
        self.ask(SET, value)


class Page:
    """The console in a browser.

    Keys are named by their sign on a US keyboard, or by their position: "w", ";", "F2", "PageUp".
    """

    def __init__(self, url):
        self.url = url
        self._start()

    def _start(self):
        self.browser = Chromium("about:blank", listens=True)
        self.browser.call("Page.enable")  # for scripts that run before the page's own
        self.browser.call("Page.addScriptToEvaluateOnNewDocument", source=LET_GO)

    def start_again(self):
        """Take another browser for one that was killed."""
        self.browser.close()
        self._start()
        self.resize(1280, 720)
        self.load()

    def resize(self, width, height):
        self.browser.resize((width, height))
        # What is pressed or touched is looked for in the last frame that was drawn.
        self.script(
            "return new Promise((done) =>"
            " requestAnimationFrame(() => requestAnimationFrame(() => done())));"
        )

    def load(self, steady=True):
        """Load it anew, until it is connected and, for keys that are to be held, runs evenly."""
        self.browser.go(self.url)
        wait_until(lambda: self.attribute("link", "data-state") == "up", timeout=15.0)
        if not steady:
            return
        # On a busy machine a page that is being built stands still now and then, which lets go.
        self.script("""
            return new Promise((done) => {
              const begun = performance.now();
              let last = begun, since = begun;
              const timer = setInterval(() => {
                const now = performance.now();
                if (now - last > 100) since = now;
                last = now;
                if (now - since > 500 || now - begun > 15000) { clearInterval(timer); done(); }
              }, 20);
            });
        """)

    def address(self):
        return self.script("return location.href")

    def script(self, text, *arguments):
        """Run statements with `arguments` on the page; returns what they return."""
        return self.browser.evaluate(f"(function () {{\n{text}\n}})(...{json.dumps(arguments)})")

    def element(self, selector):
        return Element(self, selector)

    def texts(self, selector):
        """Return what can be read of all elements of a selector."""
        return self.script(
            f"return [...document.querySelectorAll(arguments[0])].map((element) => {TEXT});",
            selector,
        )

    def text(self, element_id):
        return self.element(f"#{element_id}").text

    def attribute(self, element_id, name):
        return self.element(f"#{element_id}").get_attribute(name)

    def mouse(self, kind, x, y, buttons=1, **more):
        """Use the mouse, whose left button is then held (1) or not (0), at a place (px)."""
        clicks = kind in ("mousePressed", "mouseReleased")
        event = {"type": kind, "x": x, "y": y, "buttons": buttons, "clickCount": int(clicks)}
        button = "left" if buttons or clicks else "none"
        self.browser.call("Input.dispatchMouseEvent", button=button, **event, **more)

    def down(self, *keys):
        for key in keys:
            self.browser.handled(self.browser.key("keyDown", code_of(key)))

    def up(self, *keys):
        for key in keys:
            self.browser.handled(self.browser.key("keyUp", code_of(key)))

    @contextlib.contextmanager
    def hold(self, *keys):
        self.down(*keys)
        try:
            yield
        finally:
            self.up(*keys)

    def press(self, key):
        with self.hold(key):
            pass

    def hold_until(self, condition, *keys, anew=lambda: None):
        """Hold keys until something is seen, as `held_until` does, and let them go."""
        with self.held_until(condition, lambda: self.hold(*keys), anew):
            pass

    @contextlib.contextmanager
    def held_until(self, condition, hold, anew=lambda: None):
        """Hold something until something is seen, and on until the caller's block ends.

        It is pressed anew only where the page lets go, as it does on a busy machine: a press that
        has no effect fails.

        Parameters
        ----------
        condition
            What is to be seen while all is held: once the page has let go, it counts no more.
        hold
            Makes what holds it (a context manager).
        anew
            Called between the page's letting go and the next press: to forget what came before.
        """
        with contextlib.ExitStack() as held:

            def press():
                before = self._count_let_go()
                held.enter_context(hold())
                return before

            before = press()

            def seen():
                nonlocal before
                is_seen = False
                with contextlib.suppress(LookupError):
                    is_seen = condition()
                # After the condition: what has let go until then may be what it saw.
                if self._count_let_go() == before:
                    return is_seen
                held.close()
                anew()
                before = press()
                return False

            wait_until(seen, lambda: f"what keys are held for; the log: {self.log()}", 20.0)
            yield

    def _count_let_go(self):
        return self.script("return window.letGo")

    def log(self):
        """Return the lines of the log, newest first, and how often each was said."""
        return self.script(
            "return [...document.querySelectorAll('#log li')]"
            ".map(({title, dataset}) => [title, Number(dataset.count)]);"
        )

    def mode(self, mode):
        """Let keys be about something, by the buttons; the arm has to follow by itself."""
        layout = {"DRIVE": "DRIVE", "CAMERA": "LOOK"}.get(mode, "ARM")
        self.element(f'[data-layout="{layout}"]').click()
        wait_until(lambda: self.is_in(mode))

    def is_in(self, mode):
        """Tell whether keys are about something."""
        return self.script("return document.body.dataset.keysMode") == mode

    def views(self):
        """Return the cameras of the two large views; of one where the other is not shown."""
        return self.script(
            "return [document.getElementById('camera-name').textContent,"
            " ...[...document.querySelectorAll('#second .thumbnail')]"
            ".filter((each) => each.offsetParent).map(({dataset}) => dataset.camera)]"
        )

    def thumbnail(self, camera):
        return self.element(f'.thumbnail[data-camera="{camera}"]')

    def thumbnails(self):
        """Return the cameras of all views but the first, and their states."""
        return self.script(
            "return [...document.querySelectorAll('.thumbnail')]"
            ".map(({dataset}) => [dataset.camera, dataset.state])"
        )

    def wait_until_all_is_shown(self):
        """Wait for what the robot says and shows when no test has changed it.

        A page that was left, and keeps its connection for a while, may have control until then.
        """
        script = """
            const text = (id) => document.getElementById(id).textContent;
            const state = (id) => document.getElementById(id).dataset.state;
            return [
              text("speed"), text("sim-state"), state("control") !== "watching", state("view"),
              ...[...document.querySelectorAll(".thumbnail")].map(({dataset}) => dataset.state),
            ];
        """
        shown = ["40 %", "running", True, *["live"] * 6]
        wait_until(lambda: self.script(script) == shown, timeout=20.0)

    def all_live(self):
        return all(state == "live" for _, state in self.thumbnails())

    def pixel(self, selector, x, y):
        """Return the colour of a canvas at a part of its width and height."""
        return self.script(
            f"const canvas = document.querySelector('{selector}');"
            "const dot = new OffscreenCanvas(1, 1).getContext('2d');"
            f"dot.drawImage(canvas, {x} * canvas.width, {y} * canvas.height, 1, 1, 0, 0, 1, 1);"
            "return [...dot.getImageData(0, 0, 1, 1).data].slice(0, 3)"
        )

    def errors(self):
        """Return what the browser complained of since the last call."""
        found = list(self.browser.complaints)
        del self.browser.complaints[: len(found)]
        return found

    def hosts(self):
        """Return the hosts that the browser asked when the page was loaded first."""
        parts = map(urlsplit, self.browser.addresses)
        return {each.hostname for each in parts if each.scheme not in ("data", "blob", "chrome")}


@contextlib.contextmanager
def opened(url):
    """Open a page in a browser of its own."""
    page = Page(url)
    try:
        page.resize(1280, 720)
        # Not for longer: each message of a WebSocket is told as well.
        page.browser.call("Network.enable")
        page.load()
        page.browser.call("Network.disable")
        yield page
    finally:
        page.browser.close()


@pytest.fixture(scope="module")
def ros():
    if lacking():
        pytest.skip(lacking())
    with Ros() as ros:
        yield ros


@pytest.fixture(scope="module")
def robot(ros):
    robot = Robot(ros)
    robot.publish_states()
    return robot


@pytest.fixture(scope="module")
def page(ros, robot):
    describe(ros)
    ros.master.setParam("/telex/cameras/cameras/turret/zoom_max", 2.0)
    _, url = ros.serve("video_server")
    ros.bridge, _ = ros.serve("rosbridge")
    with opened(url) as page:
        yield page
