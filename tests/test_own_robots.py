"""The console of robots that are not Telex, started as docs/engineer/own_robot.md says."""

from __future__ import annotations

import re
import time
from contextlib import contextmanager
from pathlib import Path

import pytest
import rosgraph
from waiting import wait_until

from telex_experiments.rigs.bringup import Bringup
from telex_experiments.rigs.chromium import Chromium, lacking
from telex_experiments.rigs.private_master import PrivateMaster

EXAMPLES = Path(__file__).resolve().parents[1] / "docs" / "examples"
OWN_ROBOT = ("telex_teleop", "own_robot.launch")
ROVER = {
    "controllers": "controllers",
    "config": "simulation",
    "base": "base",
    "cameras": "cameras",
}
BENCH_ARM = {
    "controllers": "controllers",
    "config": "simulation",
    "arm": "arm",
    "gripper": "gripper",
    "cameras": "cameras",
}

pytestmark = [
    pytest.mark.browser,
    pytest.mark.slow,
    pytest.mark.skipif(bool(lacking()), reason=lacking() or "there is a browser"),
]

SHOWN = "[...document.querySelectorAll('{}')].filter((each) => each.offsetParent)"


class Operator:
    """Sees the page of a robot, and presses its keys."""

    def __init__(self, browser):
        self.browser = browser

    def evaluate(self, script):
        return self.browser.evaluate(script)

    def texts(self, selector):
        """What the elements of a selector say that are shown."""
        shown = SHOWN.format(selector)
        return self.evaluate(f"{shown}.map(({{textContent}}) => textContent.trim())")

    def number(self, selector):
        """The first number in a text; a dash where there is none."""
        text = self.evaluate(f"document.querySelector('{selector}').textContent")
        found = re.search(r"[-+]?\d+(\.\d+)?", text)
        return None if found is None else float(found.group())

    def views(self):
        """Cameras of the large views, once both are live."""
        live = (
            "document.getElementById('view').dataset.state === 'live' && "
            "[...document.querySelectorAll('#second .thumbnail')].every(({dataset}) => "
            "dataset.state === 'live')"
        )
        self.browser.wait_for("live pictures", live, 30.0)
        return [*self.texts("#camera-name"), *self.texts("#second .thumbnail b")]

    def hold(self, code, until, what):
        """Hold a key until something is so; a page that stood still has let it go meanwhile."""
        pressed = 0.0

        def comes():
            nonlocal pressed
            if time.monotonic() - pressed > 2.0:
                self.tap(code)
                self.browser.press(code)
                pressed = time.monotonic()
            return until()

        try:
            wait_until(comes, what, 20.0)
        finally:
            self.browser.release(code)

    def tap(self, code):
        """Press and release a key; the page has done what it does by then."""
        self.browser.press(code)
        self.browser.handled(self.browser.key("keyUp", code))

    def keys(self):
        """What the list of keys has."""
        self.tap("Slash")
        titles = self.texts("#key-groups .key-line span")
        self.tap("Slash")
        return titles

    def is_quiet(self):
        """Tell that the page has complained of nothing, in the console or in its messages."""
        alarms = self.evaluate(
            "[...document.querySelectorAll('#log [data-level=alarm]')].map((e) => e.textContent)"
        )
        return [*self.browser.complaints, *(each for each in alarms if "e-stop" not in each)] == []


@contextmanager
def operated(name, folder, files, *arguments):
    """Start a robot of docs/examples, and open its page."""
    paths = [f"{each}:={EXAMPLES / name / file}.yaml" for each, file in files.items()]
    model = f"model:={EXAMPLES / name / name}.urdf"
    with PrivateMaster() as master:
        launch = Bringup(
            [f"ns:={name}", model, *paths, *arguments],
            master.environment(),
            folder / f"{name}.txt",
            launch=OWN_ROBOT,
        )
        try:
            server = rosgraph.Master("/test", master.uri)

            def url():
                try:
                    return server.getParam(f"/{name}/video_server/url")
                except rosgraph.MasterError:
                    return None

            address = launch.wait_for("video server", url)
            with Chromium(address, size=(1366, 768), exact=True, listens=True) as browser:
                ready = "document.getElementById('link').dataset.state === 'up'"
                browser.wait_for("the connection", ready, 30.0)
                told = "/[0-9]/.test(document.getElementById('speed').textContent)"
                browser.wait_for("the nodes' status", told, 30.0)
                yield Operator(browser)
        except BaseException:
            print(launch.output_tail(60))
            raise
        finally:
            launch.end(timeout=0.0)


def e_stop_holds(operator, code, moves):
    """Stop everything, press a key in vain, and release."""
    operator.tap("Escape")
    operator.browser.wait_for("the e-stop", "document.body.classList.contains('estopped')")
    operator.browser.press(code)
    time.sleep(0.5)
    assert not moves()
    operator.browser.release(code)
    operator.browser.click("#release")
    operator.browser.wait_for("its release", "!document.body.classList.contains('estopped')")


def test_a_base_on_wheels_with_two_cameras(tmp_path):
    with operated("rover", tmp_path, ROVER) as operator:
        assert operator.views() == ["bow", "stern"]
        assert operator.texts("#brand, .panel h2") == ["ROVER", "Drive"]
        assert operator.texts("#layouts") == []
        assert operator.texts("#exercises-open") == []
        assert operator.texts("#tour-count") == ["1 of 1"]
        assert operator.texts(".values dt") == [
            "speed",
            "commanded",
            "heading",
            "moves",
            "moved by",
        ]

        def speed():
            return abs(operator.number("#speed-hud") or 0.0)

        operator.hold("KeyW", lambda: speed() > 0.15, "driving ahead")
        wait_until(lambda: speed() < 0.02, "standing")
        before = operator.number("#heading")
        operator.hold("KeyD", lambda: operator.number("#heading") != before, "turning")
        wait_until(lambda: speed() < 0.02, "standing")
        e_stop_holds(operator, "KeyW", lambda: speed() > 0.02)
        operator.tap("F2")
        assert operator.views() == ["stern", "bow"]
        keys = " ".join(operator.keys())
        assert "drive ahead" in keys
        for absent in (
            *("flipper", "gripper", "arm", "tool", "lamp", "JOINT", "CAMERA", "small"),
            "bookmark",
        ):
            assert not re.search(rf"\b{absent}", keys), absent
        assert operator.is_quiet()


def test_an_arm_on_a_fixed_base(tmp_path):
    with operated("bench_arm", tmp_path, BENCH_ARM, "fixed_base:=true") as operator:
        assert operator.views() == ["post", "hand"]
        assert operator.texts("#layouts") == []
        assert operator.texts("#flipper-card, .tracks, #attitude, #hold-tool, #lamps") == []
        assert operator.texts(".values dt") == ["gripper", "moves", "moved by"]
        assert operator.texts("#arm-rows .row > span:first-child") == [
            *("waist", "upper", "lower", "wrist turn", "wrist bend", "hand turn")
        ]

        def angle(joint="waist_joint"):
            return operator.number(f'[data-joint="{joint}"]')

        wait_until(lambda: angle() is not None, "joint states")
        operator.hold("KeyJ", lambda: angle() > 3.0, "the waist turning")
        operator.hold("KeyX", lambda: angle("upper_joint") > 0.0, "the pose reach")
        operator.hold("Period", lambda: angle("hand") > 10.0, "the hand opening")
        rest = angle()
        e_stop_holds(operator, "KeyJ", lambda: angle() > rest + 0.5)
        operator.browser.click('[data-mode="CARTESIAN"]')
        operator.browser.wait_for("CARTESIAN", "document.body.dataset.keysMode === 'CARTESIAN'")
        height = operator.number("#tool_z-value")
        operator.hold(
            "KeyK", lambda: operator.number("#tool_z-value") < height - 5, "the tool lowered"
        )
        assert operator.texts("#tool-options [data-frame]") == ["tool_tip", "pedestal", "world"]
        keys = " ".join(operator.keys())
        for absent in (
            "flipper",
            "drive",
            "lamp",
            "telescope",
            "turret",
            "camera left",
            "hold",
            "plan",
        ):
            assert not re.search(rf"\b{absent}", keys), absent
        assert operator.is_quiet()
