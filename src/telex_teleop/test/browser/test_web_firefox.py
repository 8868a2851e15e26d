"""The console in headless Firefox: that it shows, drives, stops and stays within the window."""

from __future__ import annotations

import pytest
from console_page import LET_GO
from firefox import Firefox, firefox
from waiting import wait_until
from web_harness import Ros
from web_robot import ARM, DRIVE, ESTOP, THUMBNAILS, Robot, describe

pytestmark = [pytest.mark.ros, pytest.mark.browser]

LIVE = "[...document.querySelectorAll('.thumbnail[data-state=live]')].map((e) => e.dataset.camera)"
# Gives the colour of the large view (red, green, blue, opacity) at a place, in parts of its size.
# Only once pictures have been flowing for a while: before the first one is presented it is black,
# and the page stands still for 10 s (see `Firefox`), lets go of its keys and loses the bridge.
LARGE_VIEW_AT = """(x, y) => {
  const view = document.querySelector("#view canvas");
  const box = view.getBoundingClientRect();
  const over = document.elementFromPoint(box.x + x * box.width, box.y + y * box.height);
  if (over.closest("#view") === null) {
    throw new Error("the large view is covered");
  }
  const copy = document.createElement("canvas");
  [copy.width, copy.height] = [view.width, view.height];
  const context = copy.getContext("2d");
  context.drawImage(view, 0, 0);
  return [...context.getImageData(x * view.width, y * view.height, 1, 1).data];
}"""


@pytest.fixture(scope="module")
def ros():
    if firefox() is None:
        pytest.skip("Firefox is not installed (apt-get install firefox-esr)")
    with Ros() as ros:
        yield ros


@pytest.fixture(scope="module")
def robot(ros):
    robot = Robot(ros)
    robot.publish_states()
    robot.publish_node_status()
    return robot


@pytest.fixture(scope="module")
def page(ros, robot, tmp_path_factory):
    describe(ros)
    _, url = ros.serve("video_server")
    ros.serve("rosbridge")
    page = Firefox(tmp_path_factory.mktemp("profile"))
    try:
        page.command("script.addPreloadScript", functionDeclaration=f"() => {{{LET_GO}}}")
        page.resize(1280, 720)
        page.get(url)
        wait_until(lambda: state(page, "link") == "up", timeout=30.0)
        wait_until(lambda: state(page, "view") == "live", timeout=30.0)
        page.click("#tour-skip")
        yield page
    finally:
        page.quit()


def state(page, element, of="state"):
    return page.evaluate(f"document.getElementById('{element}').dataset.{of}")


def test_six_views_are_live_and_the_page_fits_the_window(robot, page):
    wait_until(lambda: sorted(page.evaluate(LIVE)) == THUMBNAILS, timeout=30.0)
    size = "[document.documentElement.scrollWidth, document.documentElement.scrollHeight]"
    assert page.evaluate(size) == [1280, 720]
    wait_until(
        lambda: state(page, "view", "picture") == "good", timeout=30.0
    )  # by its rate over 2 s

    # The box that the fake camera shows, in the large view, with nothing over it.
    def is_orange():
        red, green, blue, _ = page.evaluate(f"({LARGE_VIEW_AT})(0.72, 0.5)")
        return red > 150 > green > blue

    wait_until(is_orange, timeout=30.0)
    wait_until(lambda: state(page, "link") == "up", timeout=30.0)


def commands(robot, page, key, topic, count):
    """Return what comes while a key is held, once it is so much, and let the key go.

    It is pressed anew only where the page lets go, as it does on a busy machine.
    """
    let_go = None

    def heard():
        nonlocal let_go
        messages = robot.heard(topic)
        # After the messages: what has let go until then may have ended them.
        if page.evaluate("letGo") == let_go:
            return len(messages) >= count and messages
        page.keys("keyUp", key)
        robot.forget()
        let_go = page.evaluate("letGo")
        page.keys("keyDown", key)
        return None

    try:
        return wait_until(heard, f"{count} commands on {topic}", 20.0)
    finally:
        page.keys("keyUp", key)


def test_a_key_drives_until_it_is_let_go(robot, page):
    messages = commands(robot, page, "w", DRIVE, 20)
    assert messages[-1]["linear"]["x"] == pytest.approx(1.2)
    wait_until(lambda: robot.heard(DRIVE)[-1]["linear"]["x"] == 0.0)
    wait_until(lambda: robot.is_quiet(DRIVE))
    assert robot.heard(DRIVE)[-1]["linear"]["x"] == 0.0


def test_modes_and_joints_follow_their_keys(robot, page):
    page.keys("keyDown", "\ue004")  # Tab
    page.keys("keyUp", "\ue004")
    messages = commands(robot, page, "j", ARM, 5)
    assert messages[-1]["joint_names"] == ["turret_joint"]
    wait_until(lambda: robot.is_quiet(ARM))


def test_escape_is_the_emergency_stop_and_nothing_was_complained_of(robot, page):
    page.keys("keyDown", "\ue00c")  # Escape
    page.keys("keyUp", "\ue00c")
    assert robot.wait_for(ESTOP)[-1]["data"] is True
    assert page.complaints == []
