"""When operator, browser, bridge or network fail while a key is held: the tracks stop, and stay so.

From the key in a real browser to the command for the track controller, with the real bridge and
the real track node between.
"""

from __future__ import annotations

import contextlib
import os
import signal
import time

import pytest
from console_page import page, robot, ros
from waiting import wait_until
from web_robot import ARM_JOINTS, DRIVE, POSITIONS

# the fixtures of the console's other tests, started anew for this file
__all__ = ["page", "robot", "ros"]

pytestmark = [pytest.mark.ros, pytest.mark.browser, pytest.mark.waiting]

TRACKS = "/telex/track_controller/cmd_vel"
PULSE = "front_left_track_joint"


class Tracks:
    """The commands that reach the track controller."""

    def __init__(self, ros, robot):
        self.probe = robot.probe
        self.probe.subscribe(TRACKS, "geometry_msgs/Twist")
        names = [*ARM_JOINTS, PULSE]
        states = {"name": names, "position": [*POSITIONS[: len(ARM_JOINTS)], 0.0]}
        self.probe.publish("/telex/joint_states", "sensor_msgs/JointState", states, rate=100)
        ros.start_node("track_teleop", "__name:=track_teleop")

    def speeds(self):
        return [command["linear"]["x"] for command in self.probe.messages(TRACKS)]

    def run(self):
        return self.speeds()[-1:] == [1.2]

    def stand(self):
        return self.speeds()[-1:] == [0.0]

    def stay(self, period=0.4):
        """Tell whether they are told to stand for a while (s), or told nothing."""
        told = len(self.speeds())
        time.sleep(period)
        return self.stand() and set(self.speeds()[told:]) <= {0.0}


def drive_first(page, tracks):
    """Drive by presses, of which one counts once the page knows the speed and the node the page."""
    wait_until(lambda: drives(page, tracks), timeout=20.0, period=0.3)


@pytest.fixture(scope="module")
def tracks(ros, robot, page):
    tracks = Tracks(ros, robot)
    drive_first(page, tracks)
    return tracks


def driving(page, tracks):
    """Hold the key that drives ahead: the tracks run before the caller's block begins."""
    return page.held_until(
        tracks.run, lambda: page.hold("w"), anew=lambda: wait_until(lambda: not tracks.run())
    )


def drive(page, tracks):
    """Drive by a new press, and let go."""
    with driving(page, tracks):
        pass
    wait_until(tracks.stand)


def drives(page, tracks):
    with page.hold("w"), contextlib.suppress(AssertionError):
        wait_until(tracks.run, timeout=0.5)
    with contextlib.suppress(AssertionError):
        wait_until(tracks.stand, timeout=0.5)
        return 1.2 in tracks.speeds()
    return False


@pytest.fixture(autouse=True)
def clean(tracks):
    tracks.probe.heard[TRACKS].clear()


@contextlib.contextmanager
def stopped(pids):
    """Let processes stand still."""
    for pid in pids:
        os.kill(pid, signal.SIGSTOP)
    try:
        yield
    finally:
        for pid in pids:
            os.kill(pid, signal.SIGCONT)


def say_again(page):
    """A keyboard repeats a key that is held."""
    event = "new KeyboardEvent('keydown', {code: 'KeyW', repeat: true})"
    page.script(f"window.dispatchEvent({event})")


def test_a_page_that_was_stopped_moves_nothing_until_a_new_press(page, tracks):
    with driving(page, tracks):
        # A press of now, which reaches the page when it is awake again.
        page.script("window.late = new KeyboardEvent('keydown', {code: 'KeyW'})")
        with stopped(page.browser.renderers()):
            wait_until(tracks.stand)
            time.sleep(0.4)
        page.script("window.dispatchEvent(late)")
        say_again(page)
        assert tracks.stay()
    drive(page, tracks)


def test_a_browser_that_no_longer_hears_the_keyboard_stops(page, tracks):
    """The page runs on while the main process hangs, and would never learn that a key is let go."""
    main = page.browser.pid
    with driving(page, tracks):
        with stopped([main]):
            wait_until(tracks.stand)
            assert tracks.stay()
        say_again(page)
        assert tracks.stay()
    assert "released: the browser does not answer" in page.element("#log").text
    drive(page, tracks)


def test_a_key_let_go_after_a_standstill_does_not_bring_back_the_other(robot, page, tracks):
    def turns():
        return tracks.run() and robot.heard(DRIVE)[-1]["angular"]["z"] == 1.0

    with page.held_until(turns, lambda: page.hold("w", "a"), anew=robot.forget):
        robot.probe.heard[DRIVE].clear()
        page.script("""
            const end = performance.now() + 600;
            while (performance.now() < end);
            window.dispatchEvent(new KeyboardEvent("keyup", {code: "KeyA"}));
        """)
        wait_until(lambda: robot.heard(DRIVE)[-1]["linear"]["x"] == 0.0)
        assert tracks.stay()
        told = {(each["linear"]["x"], each["angular"]["z"]) for each in robot.heard(DRIVE)}
        assert told <= {(1.2, 1.0), (0.0, 0.0)}


def test_commands_that_were_held_up_on_their_way_are_dropped(robot, page, tracks):
    page.script("""
        const send = WebSocket.prototype.send;
        WebSocket.prototype.send = function (text) {
          if (JSON.parse(text).op === "publish") setTimeout(() => send.call(this, text), 300);
          else send.call(this, text);
        };
    """)

    def is_refused():
        # Pressed anew: of a press while it stands still, the page sends and says nothing.
        with page.hold("w"), contextlib.suppress(AssertionError):
            return wait_until(lambda: "s late" in page.element("#log").text, timeout=2.0)

    try:
        robot.probe.heard[DRIVE].clear()
        wait_until(is_refused, timeout=20.0)
        assert "released:" in page.element("#log").text
        wait_until(lambda: robot.heard(DRIVE))
        assert {command["linear"]["x"] for command in robot.heard(DRIVE)} == {0.0}
        assert set(tracks.speeds()) <= {0.0}  # the end of what an earlier test drove
    finally:
        page.load()
    drive_first(page, tracks)


def test_a_bridge_that_is_killed_stops_and_needs_a_new_press_when_it_is_back(ros, page, tracks):
    with driving(page, tracks):
        ros.stop(ros.bridge, signal.SIGKILL)
        wait_until(tracks.stand)
        wait_until(lambda: page.attribute("link", "data-state") != "up")
        ros.bridge = ros.start_node("rosbridge", "_port:=0", "__name:=rosbridge")
        wait_until(lambda: page.attribute("link", "data-state") == "up", timeout=30.0)
        say_again(page)
        assert tracks.stay()
    drive(page, tracks)


def test_a_browser_that_is_killed_stops(page, tracks):
    with driving(page, tracks):
        try:
            page.browser.kill()
            wait_until(tracks.stand)
            assert tracks.stay()
        finally:
            page.start_again()
    drive_first(page, tracks)
