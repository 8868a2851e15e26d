"""That what stops the robot can be pressed whatever the header says, on every screen."""

from __future__ import annotations

import pytest
from console_page import Page, robot, ros
from waiting import wait_until
from web_robot import ESTOP, describe

# the fixtures of the console's other tests, started anew for this file
__all__ = ["robot", "ros"]

pytestmark = [pytest.mark.ros, pytest.mark.browser]

# the least, beside where the layout changes, and what screens have
WIDTHS = [768, 901, 1024, 1151, 1280, 1366, 1600, 1920]
HEIGHT = {768: 1024, 1024: 768, 1280: 720, 1366: 768, 1920: 1080}
LONG_NAME = "Bartholomew Featherstonehaugh-Smythe IV."  # as long as a name may be
EVERY_NODE = "MISSING simulator, cameras, arm_teleop, gripper_teleop, flipper_teleop, track_teleop"
DEVICES = "MOVED BY the robot's gamepad, a terminal, the program somebody_wrote_last_year"
TAKEN = {"control": True, "control-text": f"WATCHING · {LONG_NAME}", "control-button": "take"}

# In each group one of several: texts by the id of their element; None hides it, True shows it.
# The question is the page's own, and open all the time.
STATES = [
    [{"release": None}, {"release": True}],
    [{"health": None}, {"health": "MISSING cameras"}, {"health": EVERY_NODE}],
    [{"others": None}, {"others": "MOVED BY a terminal"}, {"others": DEVICES}],
    [{"control": None}, {"control": True, "control-text": "you control"}, TAKEN],
    [
        {"link-text": "connected 3 ms", "sim-state": "running", "sim-speed": "1.00"},
        {"link-text": "silent 123.4 s", "sim-state": "NO STATUS", "sim-speed": "-"},
    ],
    [{"speed": "5 %", "clock": "00:00"}, {"speed": "35-100 %", "clock": "600:00"}],
    [{"scene-name": "hall"}, {"scene-name": "the_tunnel_that_somebody_made_for_his_own_lesson"}],
    [{"control-holder": "free"}, {"control-holder": LONG_NAME}],
    [{"keys": None}, {"keys": True}],
    [{"ask": None}, {"ask": True}],
]

COMBINATIONS = {"": 2 * 3 * 3 * 3 * 2 * 2 * 2, "/instructor": 2 * 2 * 2 * 2 * 2}

TOOLS = """
    const has = (id) => document.getElementById(id) !== null;
    const groups = arguments[0].filter((group) => Object.keys(group.at(-1)).every(has));
    const show = (texts) => {
      for (const [id, text] of Object.entries(texts)) {
        const element = document.getElementById(id);
        element.hidden = text === null;
        if (typeof text === "string") element.textContent = text;
      }
    };
    const buttons = [...document.querySelectorAll("body > header button")];
    const missed = () => buttons.filter((button) => {
      if (button.offsetParent === null) return false;
      const {left, right, top, bottom} = button.getBoundingClientRect();
      if (left < 0 || top < 0 || right > innerWidth || bottom > innerHeight) return true;
      return !button.contains(document.elementFromPoint((left + right) / 2, (top + bottom) / 2));
    }).map(({id}) => id);
"""

# Goes through all combinations of what the page has of these; returns how many they are, and the
# first ones in which a button of the header is outside the window or under something else.
TRY_ALL = """
    let count = 0;
    const wrong = [];
    const go = (rest, shown) => {
      for (const texts of rest[0] ?? []) {
        show(texts);
        go(rest.slice(1), [...shown, texts]);
      }
      if (rest.length > 0) return;
      count += 1;
      const ids = missed();
      if (ids.length > 0 && wrong.length < 3) wrong.push({ids, width: innerWidth, shown});
    };
    go(groups, []);
    show(Object.assign({}, ...groups.map(([first]) => first)));
    return [count, wrong];
"""

# Shows the last of each, whatever the page says itself from then on; returns what it shows.
SHOW_WORST = """
    const worst = Object.assign({}, ...groups.map((group) => group.at(-1)));
    const observer = new MutationObserver(() => {
      show(worst);
      observer.takeRecords();
    });
    show(worst);
    const every = {subtree: true, childList: true, characterData: true, attributes: true};
    observer.observe(document.body, every);
    return Object.keys(worst);
"""


@pytest.fixture(scope="module")
def server(ros, robot):
    robot.publish_node_status()
    describe(ros)
    ros.serve("rosbridge")
    return ros.serve("video_server")[1]


@pytest.fixture(scope="module")
def browser(server):
    page = Page(server)
    try:
        yield page
    finally:
        page.browser.close()


@pytest.fixture(scope="module", params=list(COMBINATIONS))
def path(request):
    return request.param


@pytest.fixture(scope="module")
def page(path, server, browser):
    browser.url = f"{server}{path}"
    browser.load()
    if path == "/instructor":
        browser.element("#reset").click()
        wait_until(lambda: browser.element("#ask").is_displayed())
    return browser


@pytest.mark.parametrize("width", WIDTHS)
def test_the_e_stop_is_in_reach_in_every_state(page, path, width):
    page.resize(width, HEIGHT.get(width, 800))
    assert page.element("#estop").is_displayed()
    count, wrong = page.script(TOOLS + TRY_ALL, STATES)
    assert wrong == []
    assert count == COMBINATIONS[path]


def test_the_e_stop_can_be_pressed_in_the_worst_state(robot, page):
    """Once by a click, and not by its place alone."""
    page.resize(768, 1024)
    # Where trying all states took long, the bridge has given the page up meanwhile.
    wait_until(lambda: page.attribute("link", "data-state") == "up", timeout=30.0)
    shown = page.script(TOOLS + SHOW_WORST, STATES)
    assert all(page.element(f"#{element_id}").is_displayed() for element_id in shown)
    page.element("#estop").click()
    assert robot.wait_for(ESTOP) == [{"data": True}]
    robot.forget()
