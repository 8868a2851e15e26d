"""The page of variants of Telex: what they lack is not on it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from console_page import opened
from waiting import wait_until
from web_harness import Ros
from web_robot import Robot, describe

from telex_experiments.rigs.chromium import lacking

DESCRIPTION = Path(__file__).resolve().parents[3] / "telex_description"

pytestmark = [
    pytest.mark.browser,
    pytest.mark.slow,
    pytest.mark.skipif(
        bool(lacking()),
        reason=lacking() or "there is a browser",
    ),
]


def become(ros, variant):
    """Let the parameters be those of a variant."""
    script = str(DESCRIPTION / "scripts" / "robot_description")
    made = subprocess.run(
        [sys.executable, script, variant], capture_output=True, text=True, check=True
    )
    ros.master.setParam("/telex/robot_description", made.stdout)
    for kind in ("cameras", "lamps"):
        declared = yaml.safe_load((DESCRIPTION / "config" / f"{kind}.yaml").read_text())[kind]
        ros.master.setParam(f"/telex/cameras/{kind}", declared)


@pytest.fixture(scope="module")
def page():
    with Ros() as ros:
        describe(ros)
        become(ros, "six_axis")
        robot = Robot(ros)
        robot.publish_states()
        robot.publish_node_status()
        _, url = ros.serve("video_server")
        ros.serve("rosbridge")
        with opened(url) as page:
            page.ros = ros
            yield page


def rows(page, where):
    script = (
        f"return [...document.querySelectorAll('#{where} .row')].filter((row) => row.offsetParent)"
        ".map((row) => row.firstChild.textContent)"
    )
    return page.script(script)


def test_an_arm_of_six_axes_has_no_row_and_no_key_for_a_telescope(page):
    page.mode("JOINT")
    assert "telescope" not in rows(page, "arm-rows")
    assert len(rows(page, "arm-rows")) == 6
    assert page.views() == ["turret", "gripper"]
    page.press("/")
    assert "telescope" not in page.text("keys")
    page.press("/")


def test_a_page_takes_on_a_probe_that_is_started_in_the_place_of_a_gripper(page):
    page.script("window.old = true")
    become(page.ros, "inspection")
    page.load()
    wait_until(lambda: not page.script("return window.old === true"))
    page.mode("JOINT")
    assert len(rows(page, "arm-rows")) == 7
    assert not page.element("#gripper-card").is_displayed()
    assert not page.element("#grip").is_displayed()
    page.press("/")
    assert "gripper clos" not in page.text("keys")
    page.press("/")
    page.press(",")  # no key of anything
    assert page.views() == ["turret", "gripper"]
    page.press("F2")
    assert page.views() == ["gripper", "turret"]
    assert [each for each in page.errors() if "favicon" not in each] == []
