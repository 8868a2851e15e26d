"""Sounds of the console in headless Chromium: while a motor runs or an alarm is on, not else."""

from __future__ import annotations

import math

import pytest
from console_page import page, robot, ros
from waiting import wait_until

# the fixtures of the console's other tests, started anew for this file
__all__ = ["page", "robot", "ros"]

pytestmark = [pytest.mark.ros, pytest.mark.browser]

SILENT, HEARD = 1e-4, 5e-3

# Whatever the page sends to the loudspeaker goes to an ear as well.
EAR = """
    const connect = AudioNode.prototype.connect;
    AudioNode.prototype.connect = function (to, ...rest) {
      if (to instanceof AudioDestinationNode) {
        window.ear = new AnalyserNode(to.context, { fftSize: 4096 });
        connect.call(this, window.ear);
      }
      return connect.call(this, to, ...rest);
    };
    window.loudness = () => {
      if (window.ear === undefined || window.ear.context.state !== "running") return 0;
      const samples = new Float32Array(window.ear.fftSize);
      window.ear.getFloatTimeDomainData(samples);
      return Math.sqrt(samples.reduce((sum, each) => sum + each * each, 0) / samples.length);
    };
"""


@pytest.fixture(scope="module")
def ear(page, robot):
    robot.publish_node_status()
    page.browser.call("Page.addScriptToEvaluateOnNewDocument", source=EAR)
    page.load()
    page.wait_until_all_is_shown()
    return lambda: page.script("return loudness()")


@pytest.fixture(autouse=True)
def rest(robot):
    yield
    robot.publish_velocity("elbow_joint", 0.0)
    robot.publish_sim()


def test_it_begins_with_a_gesture_and_tells_what_moves(page, robot, ear):
    robot.publish_velocity("elbow_joint", 0.4)
    wait_until(lambda: "Starts with your first key press" in page.text("sound-note"))
    assert ear() == 0.0
    page.element("#sound-louder").click()
    wait_until(lambda: ear() > HEARD)
    assert "Training aid" in page.text("sound-note")
    robot.publish_velocity("elbow_joint", 0.0)
    wait_until(lambda: ear() < SILENT)
    robot.publish_velocity("elbow_joint", 0.4)
    wait_until(lambda: ear() > HEARD)
    robot.publish_velocity("elbow_joint", math.nan)
    wait_until(lambda: ear() < SILENT)


def test_a_key_switches_it_off_and_that_is_kept(page, robot, ear):
    robot.publish_velocity("elbow_joint", 0.4)
    page.element("#sound-quieter").click()
    wait_until(lambda: ear() > HEARD)
    volume = page.text("sound-volume")
    page.press("Numpad9")
    wait_until(lambda: ear() < SILENT)
    page.load()
    assert page.attribute("sound", "aria-checked") == "false"
    assert page.text("sound-volume") == volume
    page.press("Numpad9")
    wait_until(lambda: ear() > HEARD)
    assert page.attribute("sound", "aria-checked") == "true"


def test_an_alarm_is_heard_until_it_is_acknowledged(page, robot, ear):
    page.wait_until_all_is_shown()
    wait_until(lambda: not page.element("#quiet").is_enabled() and ear() < SILENT)
    robot.publish_sim(e_stop=True)
    wait_until(lambda: ear() > HEARD)
    page.press("F1")
    wait_until(lambda: not page.element("#quiet").is_enabled() and ear() < SILENT)
    assert page.errors() == []
