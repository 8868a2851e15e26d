"""The console in headless Chromium, before a robot that is played: what its tests share."""

from __future__ import annotations

import contextlib
import json
from urllib.parse import urlsplit

import headless_chromium
import pytest
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from waiting import wait_until
from web_harness import Ros
from web_robot import Robot, describe

NOTHING = "\N{EN DASH}"
"""Stands in place of a figure that is not known."""

OTHER = """
const [url, done] = arguments;
window.other = new WebSocket(url);
other.ask = (name) => new Promise((resolve) => {
  other.onmessage = ({data}) => {
    const answer = JSON.parse(data);
    if (answer.op === "service_response") resolve(answer.values.success);
  };
  other.send(JSON.stringify({op: "call_service", service: `/telex/bridge/${name}`}));
});
other.onopen = () => done(true);
"""
"""Opens, in a page, a connection of somebody else, who can ask for control."""


class Page:
    """The console in a browser."""

    def __init__(self, url, profile):
        self.url = url
        self._profile = str(profile)
        self._start()

    def _start(self):
        logs = {"browser": "ALL", "performance": "ALL"}
        self.driver = headless_chromium.start(self._profile, logs=logs)

    def start_again(self):
        """Take another browser for one that was killed."""
        self.driver.quit()
        self._start()
        self.resize(1280, 720)
        self.load()

    def resize(self, width, height):
        metrics = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
        # What is pressed or touched is looked for in the last frame that was drawn.
        self.driver.execute_async_script(
            "const done = arguments[0];"
            "requestAnimationFrame(() => requestAnimationFrame(() => done()));"
        )

    def load(self):
        self.driver.get(self.url)
        wait_until(lambda: self.attribute("link", "data-state") == "up", timeout=15.0)
        # On a busy machine a page that is being built stands still now and then, which lets go.
        self.driver.set_script_timeout(60.0)
        self.driver.execute_async_script("""
            const done = arguments[0];
            const begun = performance.now();
            let last = begun, since = begun;
            const timer = setInterval(() => {
              const now = performance.now();
              if (now - last > 100) since = now;
              last = now;
              if (now - since > 500 || now - begun > 15000) { clearInterval(timer); done(); }
            }, 20);
        """)

    def script(self, text):
        return self.driver.execute_script(text)

    def element(self, selector):
        return self.driver.find_element(By.CSS_SELECTOR, selector)

    def text(self, element_id):
        return self.element(f"#{element_id}").text

    def attribute(self, element_id, name):
        return self.element(f"#{element_id}").get_attribute(name)

    def down(self, *keys):
        actions = ActionChains(self.driver)
        for key in keys:
            actions.key_down(key)
        actions.perform()

    def up(self, *keys):
        actions = ActionChains(self.driver)
        for key in keys:
            actions.key_up(key)
        actions.perform()

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
        return [entry["message"] for entry in self.driver.get_log("browser")]

    def hosts(self):
        """Return the hosts that the browser has sent requests to."""
        hosts = set()
        for entry in self.driver.get_log("performance"):
            event = json.loads(entry["message"])["message"]
            address = {
                "Network.requestWillBeSent": lambda p: p["request"]["url"],
                "Network.webSocketCreated": lambda p: p["url"],
            }.get(event["method"])
            if address is not None:
                parts = urlsplit(address(event["params"]))
                if parts.scheme not in ("data", "blob", "chrome"):
                    hosts.add(parts.hostname)
        return hosts


@pytest.fixture(scope="module")
def ros():
    if headless_chromium.lacking():
        pytest.skip(headless_chromium.lacking())
    with Ros() as ros:
        yield ros


@pytest.fixture(scope="module")
def robot(ros):
    robot = Robot(ros)
    robot.publish_states()
    return robot


@pytest.fixture(scope="module")
def page(ros, robot, tmp_path_factory):
    describe(ros)
    ros.master.setParam("/telex/cameras/cameras/turret/zoom_max", 2.0)
    _, url = ros.serve("video_server")
    ros.bridge, _ = ros.serve("rosbridge")
    page = Page(url, tmp_path_factory.mktemp("profile"))
    try:
        page.resize(1280, 720)
        page.load()
        yield page
    finally:
        page.driver.quit()
