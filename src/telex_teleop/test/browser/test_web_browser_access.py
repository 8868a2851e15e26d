"""The console's layouts on every screen: what is shown where, how large, and to whom."""

from __future__ import annotations

import contextlib

import axe
import pytest
from console_page import page, robot, ros
from waiting import wait_until
from web_robot import ESTOP

# the fixtures of the console's other tests, started anew for this file
__all__ = ["page", "robot", "ros"]

pytestmark = [pytest.mark.ros, pytest.mark.browser]

SIZES = [(1920, 1080), (1366, 768), (1280, 720), (1024, 768), (820, 1180)]
MODES = ["DRIVE", "JOINT", "CARTESIAN", "CAMERA"]
FIRST = {"DRIVE": ["front", "mast"], "JOINT": ["turret", "gripper"], "CAMERA": ["turret", "front"]}

# Whatever breaks the rules of the page's look, as it is now.
FAULTS = """
    const shown = (element) => element.checkVisibility() && element.getClientRects().length > 0;
    const name = (element) => element.id || element.outerHTML.slice(0, 90);
    const faults = [];
    for (const element of document.querySelectorAll("body *")) {
      if (!shown(element)) continue;
      const said = [...element.childNodes].some((n) => n.nodeType === 3 && n.data.trim() !== "");
      const size = parseFloat(getComputedStyle(element).fontSize);
      if (said && size < 13) faults.push(`${size} px: ${name(element)}`);
    }
    const panel = document.querySelector(".panel");
    for (const button of document.querySelectorAll("button, select, input, main a")) {
      if (!shown(button)) continue;
      const {left, top, right, bottom, width, height} = button.getBoundingClientRect();
      if (width < 44 || height < 44) faults.push(`${width} x ${height}: ${name(button)}`);
      const scrolls = panel.contains(button) && panel.scrollHeight > panel.clientHeight;
      const isOut = left < 0 || right > innerWidth || !scrolls && (top < 0 || bottom > innerHeight);
      if (isOut) faults.push(`outside: ${name(button)}`);
      if (button.scrollWidth > button.clientWidth + 2) faults.push(`cut: ${button.innerText}`);
    }
    for (const word of document.querySelectorAll(".row > span:first-child")) {
      if (!shown(word) || word.scrollWidth <= word.clientWidth) continue;
      faults.push(`cut: ${word.textContent}`);
    }
    for (const canvas of document.querySelectorAll("#picture, .thumbnail canvas:not(.aids)")) {
      if (!shown(canvas)) continue;
      const {left, top, width, height} = canvas.getBoundingClientRect();
      for (let v = 0.36; v < 1; v += 0.09) {
        for (let u = 0.02; u < 1; u += 0.12) {
          const over = [...document.querySelectorAll("#view *, .second *, .thumbnail *")]
            .filter((each) => each !== canvas && !each.contains(canvas) && shown(each)
              && !each.matches(".over, .aids"));
          const [x, y] = [left + u * width, top + v * height];
          const hit = over.find((each) => {
            const box = each.getBoundingClientRect();
            const clip = each.closest(".over")?.getBoundingClientRect() ?? box;
            return x > box.left && x < box.right && y > box.top
              && y < Math.min(box.bottom, clip.bottom);
          });
          if (hit) faults.push(`over the picture: ${name(hit)}`);
        }
      }
    }
    for (const part of document.querySelectorAll(".stage, .instruments, .log, .second")) {
      const room = part.parentElement.checkVisibility() && part.parentElement;
      if (!room || getComputedStyle(room).display === "contents" || !shown(part)) continue;
      const less = part.getBoundingClientRect().bottom - room.getBoundingClientRect().bottom;
      if (less > 1) faults.push(`${less} px cut off below: ${part.className}`);
    }
    const stop = document.getElementById("estop").getBoundingClientRect();
    const chips = document.querySelector(".chips").getBoundingClientRect();
    if (stop.left < chips.right) faults.push(`E-STOP not at the right: ${stop.left} px`);
    const {clientWidth: wide, clientHeight: high} = document.getElementById("view");
    const isPair = document.body.dataset.second === "true" && innerWidth > 900;
    if (isPair && wide > 1.06 * 4 / 3 * high) faults.push(`bars beside it: ${wide} x ${high}`);
    const view = document.getElementById("picture").getBoundingClientRect();
    if (view.width * view.height < 0.09 * innerWidth * innerHeight) faults.push("small first view");
    return [...new Set(faults)];
"""

# English sentences that are on the page, of which its language says something else.
LEFT = """
    const [language] = arguments;
    return import(`/js/language/${language}.js`).then((module) => {
      const table = module[language.toUpperCase()];
      const said = new Set(Object.values(table));
      const nodes = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
      const left = new Set();
      while (nodes.nextNode()) {
        if (nodes.currentNode.parentElement.closest("#log, kbd, script")) continue;
        const words = nodes.currentNode.data.trim().replace(/\\s+/g, " ");
        if (!Object.hasOwn(table, words) || said.has(words)) continue;
        if (table[words] !== words) left.add(words);
      }
      return [...left];
    });
"""


@pytest.fixture(scope="module")
def told(robot, page):
    robot.publish_node_status()
    page.element("#tour-skip").click()


@pytest.fixture(autouse=True)
def clean(told, robot, page):
    page.resize(1280, 720)
    for kept in ("layouts/telex", "language"):
        page.script(f"localStorage.removeItem('telex.{kept}')")
    page.load()
    page.wait_until_all_is_shown()
    robot.forget()


def show(page, mode, robot):
    robot.publish_node_status(arm_mode=mode if mode in ("JOINT", "CARTESIAN") else "JOINT")
    if mode != "CARTESIAN":
        page.mode(mode)
    else:
        page.element('[data-layout="ARM"]').click()
    wait_until(lambda: page.is_in(mode))


@pytest.mark.parametrize("size", SIZES)
def test_one_of_several_robots_says_which_it_is(page, size):
    page.resize(*size)
    page.script(
        "const brand = document.getElementById('brand');"
        "brand.dataset.several = 'true'; brand.textContent = 'telex_six_axis';"
    )
    assert page.element("#brand").is_displayed()
    assert page.script(FAULTS) == []


@pytest.mark.parametrize("size", SIZES)
def test_every_layout_is_whole_on_every_screen(robot, page, size):
    faults = {}
    for mode in MODES:
        show(page, mode, robot)
        page.resize(*size)
        faults[mode] = page.script(FAULTS)
    robot.publish_sim(e_stop=True)
    wait_until(lambda: page.element("#estop-band").is_displayed())
    faults["e-stop"] = page.script(FAULTS)
    assert page.element("#estop").is_displayed()
    robot.publish_sim()
    wait_until(lambda: not page.element("#estop-band").is_displayed())
    page.element("#help").click()
    page.element("#tour-start").click()
    faults["tour"] = page.script(FAULTS)
    page.element("#tour-skip").click()
    page.element('[data-command="second"]').click()
    faults["one view"] = page.script(FAULTS)
    page.element("#aids-open").click()
    faults["aids"] = page.script(FAULTS)
    assert {state: found for state, found in faults.items() if found} == {}


def test_each_layout_has_its_own_views_and_keeps_what_was_chosen(page):
    for mode, views in FIRST.items():
        page.mode(mode) if mode != "DRIVE" else None
        assert page.views() == views
    page.press("F2")
    assert page.views() == ["front", "turret"]
    page.press("`")
    assert page.is_in("DRIVE")
    assert page.views() == FIRST["DRIVE"]
    page.press("F4")
    assert page.views() == ["front"]
    page.press("F8")  # which shows it again
    page.press("F8")
    page.press("F9")
    first, second = page.views()
    assert (first, second) != ("front", "mast")
    assert not page.element("#thumbnails").is_displayed()
    page.load()
    assert page.is_in("DRIVE")
    assert page.views() == [first, second]
    assert not page.element("#thumbnails").is_displayed()
    page.press("Enter")
    assert page.views() == ["front", "turret"]
    assert page.element("#thumbnails").is_displayed()


def test_views_that_are_not_shown_are_not_asked_for(ros, page):
    def watched():
        return [
            camera
            for camera in ("front", "mast", "rear", "gripper")
            if ros.subscribers(f"/telex/cameras/{camera}/image_raw/compressed")
        ]

    wait_until(lambda: watched() == ["front", "mast", "rear", "gripper"], timeout=20.0)
    page.press("F9")
    wait_until(lambda: watched() == ["front", "mast"], timeout=20.0)
    page.press("F4")
    wait_until(lambda: watched() == ["front"], timeout=20.0)
    page.press("F4")
    wait_until(lambda: watched() == ["front", "mast"], timeout=20.0)
    page.resize(1024, 768)  # where there is no room for the small ones
    page.press("F9")
    assert watched() == ["front", "mast"]


def test_buttons_are_walked_by_keys(robot, page):
    def focused():
        return page.script("return document.activeElement.id || document.activeElement.tagName")

    page.press("Tab")  # the mode
    assert focused() == "BODY"
    page.press("F6")
    assert focused() == "slower"
    page.press("Tab")
    assert focused() == "faster"
    outline = page.script("return getComputedStyle(document.activeElement).outlineStyle")
    assert outline == "solid"
    page.press("Enter")
    wait_until(lambda: robot.heard("/telex/arm_teleop/speed_scale"))
    page.press("Escape")
    assert robot.wait_for(ESTOP) == [{"data": True}]
    page.press("F6")
    assert focused() == "BODY"


@pytest.mark.skipif(axe.lacking() != "", reason=axe.lacking())
def test_axe_finds_nothing_in_any_state(robot, page):
    found = {}
    for mode in MODES:
        show(page, mode, robot)
        found[mode] = axe.findings(page.script)
    for state, button in (("keys", "help"), ("exercises", "exercises-open")):
        page.element(f"#{button}").click()
        found[state] = axe.findings(page.script)
        page.element(f"#{state}-close").click()
    show(page, "DRIVE", robot)
    page.element("#aids-open").click()
    found["aids"] = axe.findings(page.script)
    page.element("#aids-open").click()
    robot.publish_sim(e_stop=True)
    robot.publish_camera("front")
    wait_until(lambda: page.element("#no-picture").is_displayed())
    found["e-stop, no picture"] = axe.findings(page.script)
    robot.publish_sim()
    robot.publish_camera("front", rate=15)
    wait_until(lambda: not page.element("#estop-band").is_displayed())
    page.element("#help").click()
    page.element("#tour-start").click()
    found["tour"] = axe.findings(page.script)
    page.element("#tour-skip").click()
    assert {state: each for state, each in found.items() if each} == {}


def speak(page, language):
    """Change the language by its key until it is there."""
    for _ in range(3):
        if page.script("return document.documentElement.lang") == language:
            return
        page.press("F10")
    raise AssertionError(f"the page does not speak {language}")


@pytest.mark.parametrize("language", ["de", "fr"])
def test_all_is_said_in_a_language_and_fits(robot, page, language):
    speak(page, language)
    faults = {}
    for mode in MODES:
        show(page, mode, robot)
        for size in SIZES[1:]:
            page.resize(*size)
            faults[mode, size] = page.script(FAULTS)
    page.element("#help").click()
    faults["keys"] = page.script(LEFT, language)
    page.element("#keys-close").click()
    assert {state: found for state, found in faults.items() if found} == {}
    assert page.text("link-text").startswith({"de": "verbunden", "fr": "connecté"}[language])


@pytest.mark.skipif(axe.lacking() != "", reason=axe.lacking())
def test_another_language_changes_words_and_nothing_else(robot, page):
    tracks = "/telex/track_teleop/cmd_vel"
    before = 0

    @contextlib.contextmanager
    def hold_and_speak():
        nonlocal before
        with page.hold("w"):
            speak(page, "fr")
            before = len(robot.heard(tracks))
            yield

    def begin():
        speak(page, "en")
        robot.forget()

    def goes_on():
        told = robot.heard(tracks)
        return len(told) > before + 20 and told[-1]["linear"]["x"] == 1.2

    with page.held_until(goes_on, hold_and_speak, begin):
        pass
    assert page.element("#estop").text.startswith("ARRÊT D\N{RIGHT SINGLE QUOTATION MARK}URGENCE")
    wait_until(lambda: "," in page.text("sim-speed"))
    assert axe.findings(page.script) == []
    page.load()  # which keeps it
    assert page.script("return document.documentElement.lang") == "fr"
    page.browser.go(f"{page.url}?lang=de")
    assert page.text("estop").startswith("NOT-HALT")
    wait_until(lambda: page.attribute("link", "data-state") == "up", timeout=15.0)
    speak(page, "en")
    assert "lang" not in page.address()
    assert page.text("estop").startswith("E-STOP")


def test_keys_are_called_as_they_are_printed_on_the_users_keyboard(page):
    def caps():
        return [
            page.element(f'.key-line [data-binding="{name}"]').get_attribute("textContent")
            for name in ("drive:forward", "drive:left", "go_back", "view")
        ]

    page.element("#help").click()
    chosen = "Object.defineProperty(navigator, 'keyboard', {value: undefined});"
    assert caps() == ["W", "A", "Backspace", "8"]
    page.script(chosen + "localStorage.setItem('telex.keyboard', 'fr')")
    page.element("#keys-close").click()
    page.element("#help").click()
    wait_until(lambda: caps() == ["Z", "Q", "⌫", "8"])
    page.script("localStorage.removeItem('telex.keyboard')")
