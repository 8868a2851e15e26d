"""The console in headless Chromium: what it shows, what it sends, and when it lets go."""

from __future__ import annotations

import contextlib
import itertools
import json
import math
import statistics
import time

import numpy as np
import pytest
from console_page import DEAD_NETWORK, NOTHING, OTHER, page, robot, ros
from waiting import wait_until
from web_robot import (
    ARM,
    CONTACT,
    DRIVE,
    ESTOP,
    FLIPPERS,
    GRIPPER,
    NODES,
    ODOM,
    ODOMETRY,
    PRESET_NAMES,
    PRESETS,
    THUMBNAILS,
    camera_picture,
)

# fixtures, started anew for this file
__all__ = ["page", "robot", "ros"]

pytestmark = [pytest.mark.ros, pytest.mark.browser]

CLIENTS = "/telex/bridge/clients"
PICTURE = "/telex/cameras/front/image_raw/compressed"


@pytest.fixture(scope="module")
def told(robot, page):
    """The page has been told what the robot can do, and its tour has been seen."""
    robot.publish_node_status()
    page.element("#tour-skip").click()


@pytest.fixture(autouse=True)
def clean(told, robot, page):
    if page.address().rstrip("/") != page.url.rstrip("/"):
        page.load()
    page.mode("JOINT")
    if page.text("camera-name") != "front":
        page.thumbnail("front").click()
    page.wait_until_all_is_shown()
    robot.forget()


@pytest.fixture
def untold(clean, robot, page):
    """Nobody has told the page what the robot can do."""
    robot.silence_nodes()
    page.load()
    yield
    robot.publish_node_status()


def test_the_tour_is_shown_once_and_goes_on_by_what_is_done(robot, page):
    page.script("localStorage.clear()")
    page.load()
    assert page.text("tour-count") == "1 of 4"
    page.hold_until(lambda: page.text("tour-count") == "2 of 4", "w")
    page.hold_until(lambda: page.text("tour-count") == "3 of 4", "r")
    page.element("#tour-skip").click()
    assert not page.element("#tour").is_displayed()
    page.load()
    assert not page.element("#tour").is_displayed()
    page.press("/")
    page.element("#tour-start").click()
    assert page.text("tour-count") == "1 of 4"
    for _ in range(4):
        page.element("#tour-next").click()
    assert not page.element("#tour").is_displayed()


@pytest.mark.usefixtures("untold")
def test_nothing_moves_before_the_nodes_have_said_how_fast(robot, page):
    told = False
    for _ in range(5):  # a page that stood still has let go, and says that instead
        with page.hold("w", "j", "r", "."):
            time.sleep(0.3)
            told = "has not said yet how fast" in page.text("warning")
        if told:
            break
    assert told, page.text("warning")
    page.hold_until(lambda: page.text("warning") == "the robot has no flipper preset 3", "3")
    assert all(robot.is_quiet(topic, 0.1) for topic in (DRIVE, ARM, GRIPPER, FLIPPERS, PRESETS))
    assert robot.heard(DRIVE) == robot.heard(ARM) == robot.heard(PRESETS) == []


def test_the_page_shows_picture_joints_and_status(robot, page):
    assert page.text("speed") == "40 %"
    wait_until(lambda: page.element('[data-joint="turret_joint"]').text == "28.6°")
    assert page.element('[data-joint="telescope_joint"]').text == "120 mm"
    assert page.element('[data-joint="gripper"]').text == "17.2°"
    assert page.element('[data-joint="gripper_roll_joint"]').text == "0.0°"
    assert page.text("sim-speed").startswith("1.00")
    assert page.text("sim-state") == "running"
    assert page.text("camera-name") == "front"
    assert page.text("link-text").startswith("connected")
    assert page.text("drive-hud") == "+0.25 m/s 0 °/s"
    assert "limited" in page.element('[data-joint="elbow_joint"]').get_attribute("class")
    assert not page.element("#no-picture").is_displayed()
    assert np.abs(np.subtract(page.pixel("#picture", 0.25, 0.42), (90, 140, 130))).max() < 12
    assert page.errors() == []
    assert page.hosts() == {"127.0.0.1"}


def is_marked(page, selector, number):
    """Tell whether a canvas shows the picture with so many red discs."""
    red = [page.pixel(selector, (120 + 100 * each) / 640, 400 / 480)[0] > 150 for each in range(5)]
    return sum(red) == number


def test_six_views_are_live_and_a_click_makes_one_large(page):
    wait_until(lambda: len(page.thumbnails()) == 5 and page.all_live())
    names = [camera for camera, _ in page.thumbnails()]
    assert sorted(names) == THUMBNAILS  # without the overview
    for number, camera in enumerate(THUMBNAILS, start=1):
        selector = f'[data-camera="{camera}"] canvas'
        wait_until(lambda selector=selector, number=number: is_marked(page, selector, number))
    wait_until(lambda: "fps" in page.text("camera-rate"))
    rate, age = page.text("camera-rate").split(" fps · ")
    assert 0 < float(rate) <= 20
    assert 0 <= float(age[: -len(" ms")]) < 1000
    page.thumbnail("rear").click()
    assert page.text("camera-name") == "rear"
    wait_until(lambda: is_marked(page, "#picture", 4))
    assert [camera for camera, _ in page.thumbnails()][names.index("rear")] == "front"
    wait_until(lambda: page.all_live() and is_marked(page, '[data-camera="front"] canvas', 0))
    page.press("Space")  # must not click it again
    page.thumbnail("front").click()
    wait_until(lambda: page.text("camera-name") == "front" and page.all_live())
    assert page.errors() == []


def test_pictures_that_are_smaller_than_the_cameras_own_are_explained(ros, robot, page):
    ros.master.setParam("/telex/cameras/cameras/front/width", 640)
    robot.publish_camera("front", camera_picture(480, 360), rate=15)
    wait_until(
        lambda: page.text("picture-size") == "smaller pictures: the machine is busy", timeout=20.0
    )
    robot.publish_camera("front", rate=15)
    wait_until(
        lambda: "fps" in page.text("camera-rate") and not page.text("picture-size"), timeout=20.0
    )


def test_heading_gripper_and_link_stand_over_the_picture(robot, page):
    wait_until(lambda: page.text("heading") == "090°")  # clockwise
    wait_until(lambda: page.attribute("link-quality", "textContent") == "link good", timeout=20.0)
    # 0.3 rad open; 2 Nm on either finger at a lever of 0.143 m
    assert page.text("grip") == "114 mm open, force 14 N"
    robot.publish_effort("right_finger_base_joint", 2.0)
    wait_until(lambda: page.text("grip") == "114 mm open, force 0 N")  # a shock: nothing is held
    robot.publish_effort("right_finger_base_joint", -2.4)
    wait_until(lambda: page.text("grip") == "114 mm open, force 14 N")
    pads = [{"link": "left_finger_tip_link", "friction_use": 0.9}, {"friction_use": 0.2}]
    contact = {"object": "cube", "slipping": False, "pads": pads}
    robot.probe.publish(CONTACT, "telex_msgs/GripperContact", contact, rate=10)
    wait_until(lambda: page.text("grip") == "114 mm open, force 14 N, WEAK")
    contact["slipping"] = True
    robot.probe.publish(CONTACT, "telex_msgs/GripperContact", contact, rate=10)
    wait_until(lambda: page.text("grip") == "114 mm open, force 14 N, SLIPPING")
    contact.update(object="", slipping=False)
    robot.probe.publish(CONTACT, "telex_msgs/GripperContact", contact, rate=10)
    wait_until(lambda: page.text("grip") == "114 mm open, force 14 N")
    wait_until(lambda: page.text("drive-hud") == "+0.25 m/s 0 °/s")


def test_dosimeter_is_read_where_there_is_one(robot, page):
    dose_rate = page.element("#dose-rate")
    assert not dose_rate.is_displayed()
    reading = {"hull_rate": 0.0123, "tool_rate": 11.02, "total": 0.5, "alarm": True}
    robot.probe.publish("/telex/dosimeter", "telex_msgs/Dosimeter", reading, rate=5)
    wait_until(dose_rate.is_displayed)
    assert page.text("dose-rate") == "hull 12.3 mGy/h tool 11.0 Gy/h"
    assert page.text("dose-total") == "500 mGy DOSE ALARM"
    assert "dose alarm: hull 12.3 mGy/h" in page.text("log")
    page.element("#radiation-map-open").click()
    wait_until(lambda: page.text("radiation-map-range") == "12.3 mGy/h to 12.3 mGy/h")
    page.element("#radiation-map-close").click()
    robot.probe.publish("/telex/dosimeter", "telex_msgs/Dosimeter", reading)
    wait_until(lambda: not dose_rate.is_displayed())


def test_measured_speed_stands_beside_the_commanded_one(robot, page):
    """Both are shown: what the belts run, and what they were told."""
    wait_until(lambda: page.text("speed-hud") == "+0.31 m/s -1 °/s")
    stuck = "STUCK, belts +0.31 m/s -1 °/s"
    robot.publish_sim(stuck=True)
    wait_until(lambda: page.text("speed-hud") == stuck)
    robot.probe.publish("/telex/sim/status", "telex_msgs/SimStatus", {"stuck": True})
    wait_until(lambda: page.text("speed-hud") != stuck)  # it is not known any more
    robot.publish_sim()
    unknown = {
        "pose": {"pose": {"orientation": {"w": math.nan}}},
        "twist": {"twist": {"linear": {"x": 0.31}, "angular": {"z": math.nan}}},
    }
    robot.probe.publish(ODOM, "nav_msgs/Odometry", unknown, rate=50)
    shown = f"{NOTHING} {NOTHING}", NOTHING
    wait_until(lambda: (page.text("speed-hud"), page.text("heading")) == shown)
    robot.probe.publish(ODOM, "nav_msgs/Odometry", ODOMETRY, rate=50)
    wait_until(lambda: page.text("heading") == "090°")
    robot.probe.publish(ODOM, "nav_msgs/Odometry", ODOMETRY)  # once, and then no more
    wait_until(lambda: (page.text("speed-hud"), page.text("heading")) == (NOTHING, NOTHING))
    robot.probe.publish(ODOM, "nav_msgs/Odometry", ODOMETRY, rate=50)
    wait_until(lambda: page.text("heading") == "090°")


def test_what_was_commanded_is_not_shown_for_long(robot, page):
    topic = "/telex/track_teleop/status"
    robot.probe.publish(topic, "telex_msgs/TrackTeleopStatus")  # once, and then no more
    wait_until(lambda: page.text("drive-hud") == NOTHING)
    robot.publish_node_status()
    wait_until(lambda: page.text("drive-hud") == "+0.25 m/s 0 °/s")


def test_the_heading_follows_as_often_as_pictures_come(robot, page):
    page.script("""
        window.headings = 0;
        const heading = document.getElementById("heading");
        window.counter = new MutationObserver(() => { headings += 1; });
        counter.observe(heading, {childList: true, characterData: true, subtree: true});
    """)
    numbers = itertools.count(1)

    def follows():
        """Whether it changes with most of 50 messages, and clearly more often than at 5 Hz."""
        page.script("headings = 0")
        begin = time.monotonic()
        for number in itertools.islice(numbers, 50):
            yaw = -0.05 * number
            odometry = {"pose": {"pose": {"orientation": {"z": math.sin(yaw), "w": math.cos(yaw)}}}}
            robot.probe.publish(ODOM, "nav_msgs/Odometry", odometry)
            time.sleep(0.04)
        return page.script("return headings") > max(25, 7.0 * (time.monotonic() - begin))

    try:
        # A busy machine publishes seldom, or holds the page up.
        assert any(follows() for _ in range(5))
    finally:
        robot.probe.publish(ODOM, "nav_msgs/Odometry", ODOMETRY, rate=50)
        page.script("counter.disconnect()")


def test_slow_pictures_are_not_blamed_on_the_link(robot, page):
    wait_until(lambda: page.attribute("link-quality", "textContent") == "link good", timeout=20.0)
    robot.publish_camera("front", rate=2)
    wait_until(lambda: page.text("picture-quality") == "picture poor")
    # In one look: two answers that a busy machine holds up make the link fair for a while.
    script = """
        const text = (id) => document.getElementById(id).textContent;
        const {link} = document.getElementById("view").dataset;
        return [text("picture-quality"), text("link-quality"), link];
    """
    shown = ["picture poor", "link good", "good"]
    wait_until(lambda: page.script(script) == shown, timeout=20.0)
    robot.publish_camera("front", rate=15)
    wait_until(lambda: page.text("picture-quality") == "picture good")


def test_an_answer_that_is_still_to_come_makes_the_link_poor(page):
    # A page that has just been loaded may have been late itself.
    wait_until(lambda: page.attribute("link-quality", "textContent") == "link good", timeout=20.0)
    page.script("""
        const send = WebSocket.prototype.send;
        WebSocket.prototype.send = function (text) {
          if (!text.includes("get_time")) return send.call(this, text);
          window.answer = () => {
            WebSocket.prototype.send = send;
            this.send(text);
          };
        };
    """)
    wait_until(lambda: page.attribute("link-quality", "textContent") == "link poor")
    assert float(page.text("link-text").split()[1]) >= 500.0  # it is rounded
    page.script("answer()")
    wait_until(lambda: page.attribute("link-quality", "textContent") == "link good", timeout=20.0)


def test_what_moves_and_what_moves_it(robot, page):
    def moves():
        return page.text("moves"), page.text("moved-by")

    def parts():
        return set(moves()[0].split(", "))

    wait_until(lambda: moves() == (NOTHING, NOTHING))
    robot.publish_node_status(commanders=["/telex/rosbridge"])

    def drives():
        return "drive ahead" in moves()[0] and moves()[1] == "you (keys)"

    page.hold_until(lambda: drives() and not page.element("#others").is_displayed(), "w")
    several = {"front left flipper up", "gripper closing", "zoom in"}
    page.hold_until(lambda: several <= parts(), "q", "r", ",", "PageUp")
    page.hold_until(lambda: "front flippers up" in parts(), "r")
    robot.publish_node_status()
    wait_until(lambda: moves() == (NOTHING, NOTHING))
    robot.publish_node_status(commanders=["/telex/joy_teleop"])
    wait_until(lambda: moves() == ("base, flippers, arm, gripper", "the robot's gamepad"))
    assert page.text("others") == "MOVED BY the robot's gamepad"
    robot.publish_node_status(commanders=["/rostopic_12_1600000000000"])
    wait_until(lambda: page.text("moved-by") == "the program rostopic")
    robot.publish_node_status()
    wait_until(lambda: moves() == (NOTHING, NOTHING))
    wait_until(lambda: not page.element("#others").is_displayed())
    assert "the robot's gamepad moves the robot" in page.text("log")


def test_what_is_held_is_told_to_the_instructor_at_once(robot, page):
    topic = "/telex/console/telemetry"
    robot.probe.subscribe(topic, "std_msgs/String")

    def held():
        return [json.loads(told["data"])["held"] for _, told in robot.probe.heard[topic]]

    page.hold_until(lambda: held()[-1:] == [["drive:forward"]], "w")
    wait_until(lambda: held()[-1:] == [[]])


def test_what_the_instructor_says_stands_there_until_it_is_read(robot, page):
    service, topic = "/telex/training/read", "/telex/training/text"
    response = {"success": True}
    robot.probe.do("serve", service=service, type="telex_msgs/ReadText", response=response)
    told = {"number": 3, "text": "<b>Stop</b> before the step", "by": "Bob"}

    def say(**changes):
        robot.probe.publish(topic, "telex_msgs/TrainingText", {**told, **changes}, latch=True)

    say()
    wait_until(lambda: page.element("#instructor-text").is_displayed())
    assert page.text("instructor-text-words") == told["text"]
    assert page.text("instructor-text-by") == "Bob says:"
    page.press("F7")
    wait_until(lambda: robot.probe.requests_of(service) == [{"number": 3}])
    say(read=True)
    wait_until(lambda: not page.element("#instructor-text").is_displayed())
    page.press("F7")
    say(number=4)
    wait_until(lambda: page.element("#instructor-text").is_displayed())
    page.element("#instructor-text-read").click()
    wait_until(lambda: robot.probe.requests_of(service)[1:] == [{"number": 4}])
    say(number=5, text="", read=True)  # taken back
    wait_until(lambda: not page.element("#instructor-text").is_displayed())


def lines(page):
    """Return the messages as they are shown: how grave, and what; the newest first."""
    return page.script("""
        return [...document.querySelectorAll("#log li")].filter((line) => line.offsetParent)
          .map((line) => [line.dataset.level, line.querySelector(".sentence").textContent]);
    """)


def test_one_news_is_one_line(robot, page):
    def news():
        return lines(page)[: len(lines(page)) - before]

    before = len(lines(page))
    robot.publish_node_status(message="the e-stop is active", sim={"e_stop": True})
    wait_until(lambda: news() == [["alarm", "e-stop is active"]])
    refused = "e-stop is active: release it first"
    page.hold_until(lambda: news()[0] == ["warning", refused], "w")
    time.sleep(1.1)
    twice = ["warning", f"{refused} \N{MULTIPLICATION SIGN}2"]
    page.hold_until(lambda: news()[0] == twice, "w")
    page.press("w")  # within a second: not for the third time
    time.sleep(1.0)  # for the nodes' own words, if they came
    assert news() == [twice, ["alarm", "e-stop is active"]]
    robot.publish_node_status()
    robot.publish_sim()
    wait_until(lambda: news()[0] == ["info", "e-stop is released"])
    before = len(lines(page))
    robot.publish_sim(paused=True)
    robot.publish_node_status(message="no joint_states: the simulation is paused or has ended")
    wait_until(lambda: news() == [["info", "the simulation is paused"]])
    time.sleep(1.0)
    assert len(news()) == 1
    robot.publish_node_status()
    robot.publish_sim()
    wait_until(lambda: news()[0] == ["info", "the simulation goes on"])
    robot.publish_sim(tipped_over=True)
    wait_until(lambda: news()[0] == ["alarm", "the robot has tipped over"])
    robot.publish_sim()
    wait_until(lambda: news()[0] == ["info", "the robot is upright again"])
    # What the simulator does not tell is the nodes' news, and one line of them all.
    before = len(lines(page))
    long = "a sentence that is longer than any line of this panel can be, " * 3
    robot.publish_node_status(message=f"{long}by 1.25 rad")
    wait_until(lambda: len(news()) == 1)
    robot.publish_node_status(message=f"{long}by 1.5 rad")
    time.sleep(1.2)
    assert len(news()) == 1
    assert "\N{MULTIPLICATION SIGN}" not in news()[0][1]
    assert news()[0][1].startswith("arm_teleop, flipper_teleop, gripper_teleop, track_teleop: a")
    cut = "const log = document.getElementById('log'); return log.scrollWidth > log.clientWidth"
    assert not page.script(cut)
    robot.publish_node_status()
    page.element('[data-least="alarm"]').click()
    assert {level for level, _ in lines(page)} == {"alarm"}
    page.element('[data-least="warning"]').click()
    assert {level for level, _ in lines(page)} == {"warning", "alarm"}
    page.element('[data-least="info"]').click()
    assert len(lines(page)) == before + 1


def bar(page, joint):
    """Return the state of a joint's bar, and where it says the joint is, 0 to 1."""
    element = page.element(f'[data-bar="{joint}"]')
    return element.get_attribute("data-state"), float(element.get_attribute("data-at") or "nan")


def drawing(page, name):
    return page.script(f"return document.getElementById('avatar-{name}').toDataURL()")


def test_bars_and_drawing_follow_joints_and_urdf(robot, page):
    wait_until(lambda: bar(page, "shoulder_joint") == ("near", 0.05), timeout=15.0)
    side, top = drawing(page, "side"), drawing(page, "top")
    robot.publish_joint("shoulder_joint", 0.0)
    wait_until(lambda: bar(page, "shoulder_joint") == ("free", 0.55))
    wait_until(lambda: drawing(page, "side") != side and drawing(page, "top") != top)
    robot.publish_joint("shoulder_joint", 0.87)
    wait_until(lambda: bar(page, "shoulder_joint")[0] == "end")  # beyond the soft limit
    assert "limits" not in page.element('[data-bar="elbow_joint"]').get_attribute("class")
    robot.publish_joint("shoulder_joint", -1.0)


def test_drive_mode_leaves_the_arm_alone(robot, page):
    page.press("`")
    assert page.is_in("DRIVE")
    page.hold_until(lambda: len(robot.heard(DRIVE)) >= 3, "j", "w", "c", anew=robot.forget)
    assert robot.is_quiet(ARM, 0.2)
    assert robot.heard(ARM) == []
    page.press("Tab")
    assert page.is_in("JOINT")


def test_camera_mode_pans_zooms_and_switches_lamps(robot, page):
    zoom, lamp = "/telex/cameras/turret/zoom", "/telex/lamps/front_left/command"
    for topic in (zoom, lamp):
        robot.probe.subscribe(topic, "std_msgs/Float64")
    # Somebody has zoomed and lit lamps before the page was opened.
    number = "std_msgs/Float64"
    robot.probe.publish("/telex/cameras/turret/zoom_factor", number, {"data": 1.2}, latch=True)
    level = lamp.replace("command", "level")
    robot.probe.publish(level, number, {"data": 0.3}, latch=True)
    button = page.element('[data-command="lamps:front"]')
    wait_until(lambda: button.get_attribute("aria-checked") == "true")
    robot.probe.publish(level, number, {"data": 0.0}, latch=True)
    wait_until(lambda: button.get_attribute("aria-checked") == "false")
    page.press("Enter")
    assert page.is_in("CAMERA")
    wait_until(lambda: page.text("zoom-value").startswith("1.2"))
    assert page.text("camera-name") == "turret"  # what is moved is seen
    # Only the turret's camera turns, and arm_teleop has not said how fast it may.
    page.hold_until(lambda: "turret_camera_pan_joint" in page.text("warning"), "j")
    page.hold_until(lambda: len(robot.heard(zoom)) > 5, "o", anew=robot.forget)
    factors = [message["data"] for message in robot.heard(zoom)]
    assert factors == sorted(factors)
    assert 1.2 <= factors[0] < factors[-1] <= 2.4
    button.click()
    assert robot.wait_for(lamp)[-1] == {"data": 1.0}
    assert button.get_attribute("aria-checked") == "false"  # until the robot says that it is lit
    robot.probe.publish(level, number, {"data": 1.0}, latch=True)
    wait_until(lambda: button.get_attribute("aria-checked") == "true")
    page.press("Home")
    assert robot.wait_for(lamp, 2)[-1] == {"data": 0.0}
    page.mode("JOINT")
    assert page.is_in("JOINT")
    assert not page.element("#camera-rows").is_displayed()
    assert page.text("camera-name") == "front"


def test_keys_are_listed_and_changed_and_stay_so(robot, page):
    page.press("/")
    assert page.element("#keys").is_displayed()
    page.hold_until(lambda: page.text("warning") == "close the list of keys first", "w")
    page.element('[data-key="drive:forward"]').click()
    page.press("i")  # which moves the shoulder in JOINT mode
    wait_until(lambda: "shoulder up" in page.text("keys-note"))
    page.press("/")
    page.load()
    page.hold_until(lambda: robot.heard(DRIVE)[-1]["linear"]["x"] == 1.2, "i")
    robot.forget()
    page.hold_until(lambda: robot.heard(ARM), "w")
    assert robot.heard(ARM)[0]["joint_names"] == ["shoulder_joint"]
    page.press("/")
    wait_until(lambda: page.element('[data-key="drive:forward"] kbd').text == "I")
    page.element("#keys-reset").click()
    page.press("/")
    robot.forget()
    page.hold_until(lambda: robot.heard(DRIVE), "w")


def test_the_next_camera_comes_by_a_key(page):
    names = [camera for camera, _ in page.thumbnails()]
    for name in [*names[1:], "front"]:  # but for the one in the second view
        page.press("8")
        wait_until(lambda name=name: page.text("camera-name") == name)
    assert [camera for camera, _ in page.thumbnails()] == names
    wait_until(lambda: page.all_live() and page.attribute("view", "data-state") == "live")


def test_a_stick_drives_by_its_deflection_and_must_come_back_to_rest(robot, page):
    page.script("""
        const buttons = Array.from({length: 17}, () => ({value: 0, pressed: false}));
        window.pad = {index: 0, id: "pad", mapping: "standard", axes: [0, 0, 0, 0], buttons};
        navigator.getGamepads = () => [window.pad];
        dispatchEvent(new Event("gamepadconnected"));
    """)
    page.press("`")
    # Nothing moves without the enable button, or by a stick that was not at rest before it.
    page.script("pad.axes[1] = -1")
    time.sleep(0.1)
    page.script("pad.buttons[4].value = 1")
    assert robot.is_quiet(DRIVE, 0.2)
    page.script("pad.axes[1] = 0")
    time.sleep(0.1)
    robot.forget()
    # Half of the way beyond the dead zone, of which 0.4 count by their cube.
    page.script("pad.axes[1] = -0.56")
    wait_until(
        lambda: robot.heard(DRIVE)[-1]["linear"]["x"] == pytest.approx(1.2 * 0.35), timeout=5.0
    )
    page.script("window.dispatchEvent(new Event('blur'))")
    wait_until(lambda: robot.heard(DRIVE)[-1]["linear"]["x"] == 0.0)
    assert robot.is_quiet(DRIVE)
    page.script("pad.axes[1] = 0")
    time.sleep(0.1)
    robot.forget()
    page.script("pad.axes[1] = -1")
    wait_until(lambda: robot.heard(DRIVE)[-1]["linear"]["x"] == pytest.approx(1.2), timeout=5.0)
    page.script("navigator.getGamepads = () => []; dispatchEvent(new Event('gamepaddisconnected'))")
    wait_until(lambda: robot.heard(DRIVE)[-1]["linear"]["x"] == 0.0)


def test_commands_say_when_they_were_sent(robot, page):
    page.script("""
        window.sent = [];
        const send = WebSocket.prototype.send;
        WebSocket.prototype.send = function (text) {
          window.sent.push(text);
          send.call(this, text);
        };
    """)
    page.hold_until(lambda: len(robot.heard(DRIVE)) >= 3, "w", anew=robot.forget)
    times = page.script("""
        return window.sent.map((text) => JSON.parse(text)).filter(({op}) => op === "publish")
          .map(({sent}) => performance.now() - sent);
    """)
    assert len(times) >= 3
    assert all(0.0 <= age < 60_000 for age in times)


def test_another_who_has_control_lets_this_page_watch_only(ros, robot, page):
    def ask_as_other(name):
        return page.script("return other.ask(arguments[0])", name)

    page.hold_until(lambda: page.attribute("control", "data-state") == "mine", "w")

    page.element("#control-button").click()
    wait_until(lambda: page.attribute("control", "data-state") == "free")
    time.sleep(1.0)  # nothing that the page still tells takes it again
    assert page.attribute("control", "data-state") == "free"
    url = f"{ros.param('/telex/rosbridge/url')}?name=Ann"
    assert page.script(OTHER, url)
    assert ask_as_other("take_control")
    wait_until(lambda: page.text("control-text") == "WATCHING · Ann")
    robot.forget()
    watches = "Ann has control: you are watching"
    with page.held_until(lambda: page.text("warning") == watches, lambda: page.hold("w")):
        assert robot.is_quiet(DRIVE)
    lamp = "/telex/lamps/front_left/command"
    robot.probe.subscribe(lamp, "std_msgs/Float64")
    page.press("Home")
    assert robot.is_quiet(lamp)
    assert "holds control" not in page.text("warning")  # the page itself knows better
    page.element("#control-button").click()
    wait_until(lambda: "holds control" in page.text("warning"))
    page.press("Escape")  # everybody may stop the robot
    assert robot.wait_for(ESTOP)[-1] == {"data": True}
    assert ask_as_other("release_control")
    wait_until(lambda: page.attribute("control", "data-state") == "free")
    page.element("#control-button").click()
    wait_until(lambda: page.text("control-text") == "you control")
    page.script("other.close()")
    page.hold_until(lambda: robot.heard(DRIVE), "w")


def test_the_stream_viewer_shows_a_stream(page):
    page.browser.go(f"{page.url}/stream_viewer?topic=/telex/cameras/front/image_raw")
    image = page.element("img")
    wait_until(lambda: image.get_property("naturalWidth") == 640)
    assert page.element("h1").text == "/telex/cameras/front/image_raw"
    page.script("document.body.append(document.createElement('canvas'))")
    drawn = (
        "const canvas = document.querySelector('canvas');"
        "canvas.getContext('2d').drawImage(document.querySelector('img'), 0, 0, 300, 150);"
    )
    page.script(drawn)
    assert np.abs(np.subtract(page.pixel("canvas", 0.25, 0.42), (90, 140, 130))).max() < 12
    page.errors()  # this page has no icon


def test_without_the_websocket_pictures_come_another_way(page, robot, tmp_path):
    original = page.browser.call(
        "Page.addScriptToEvaluateOnNewDocument",
        source="const post = Worker.prototype.postMessage;"
        "Worker.prototype.postMessage = function (message, ...others) {"
        "  if (message.start) message.start.url = 'ws://127.0.0.1:9/video';"
        "  post.call(this, message, ...others);"
        "};",
    )["identifier"]
    try:
        page.load()
        wait_until(lambda: page.attribute("view", "data-state") == "live")
        for number, camera in enumerate(THUMBNAILS, start=1):
            selector = f'[data-camera="{camera}"] canvas'
            wait_until(lambda selector=selector, number=number: is_marked(page, selector, number))
        page.thumbnail("rear").click()
        wait_until(lambda: is_marked(page, "#picture", 4))
    finally:
        page.browser.call("Page.removeScriptToEvaluateOnNewDocument", identifier=original)
        page.load()
        page.errors()
    wait_until(lambda: len(page.thumbnails()) == 5 and page.all_live())


def test_a_page_whose_browser_keeps_nothing_drives_and_stops(robot, page):
    blocked = page.browser.call(
        "Page.addScriptToEvaluateOnNewDocument",
        source="Object.defineProperty(window, 'localStorage', {"
        "  get() { throw new DOMException('Access is denied', 'SecurityError'); }"
        "});",
    )["identifier"]
    try:
        page.load()
        robot.forget()
        page.hold_until(lambda: robot.heard(DRIVE), "w")
        assert robot.heard(DRIVE)[0]["linear"]["x"] == 1.2
        page.press("Escape")
        assert robot.wait_for(ESTOP)[-1] == {"data": True}
    finally:
        page.browser.call("Page.removeScriptToEvaluateOnNewDocument", identifier=blocked)
        page.load()
    page.wait_until_all_is_shown()


def test_a_page_that_is_not_told_the_actions_says_so_and_stops_all_the_same(robot, page):
    def block(*addresses):
        page.browser.call("Network.setBlockedURLs", urls=list(addresses))

    page.browser.call("Network.enable")
    block("*/actions.json")
    try:
        page.load()
        wait_until(lambda: page.text("keys-band").startswith("NO KEYS: /actions.json cannot be"))
        wait_until(lambda: page.attribute("view", "data-state") == "live")
        robot.forget()
        with page.hold("w"):
            assert robot.is_quiet(DRIVE, 0.3)
        page.press("Escape")
        assert robot.wait_for(ESTOP)[-1] == {"data": True}
    finally:
        block()
        page.browser.call("Network.disable")
    # It asks again, and is loaded anew; in one look, for what was found before is gone then.
    wait_until(lambda: page.script("return document.querySelectorAll('[data-action]').length") > 40)
    assert not page.element("#keys-band").is_displayed()
    page.load()
    page.wait_until_all_is_shown()
    page.errors()
    robot.forget()
    page.hold_until(lambda: robot.heard(DRIVE), "w")
    assert robot.heard(DRIVE)[0]["linear"]["x"] == 1.2


OTHER_ACTIONS = """
modes: {DRIVE: tracks, JOINT: each joint, CARTESIAN: tool, CAMERA: look}
groups:
- title: Always
  actions:
    estop: {does: e-stop, key: escape}
    stop: {does: stop, key: space}
    drive:forward: {does: tracks forward, key: up, title: tracks ahead}
- title: Crane
  modes: [JOINT]
  actions:
    jib:up: {does: arm shoulder_joint -, key: w}
    jib:down: {does: arm shoulder_joint +, key: s}
"""


def test_the_page_of_another_robot_has_its_actions(ros, robot, page, tmp_path, monkeypatch):
    path = tmp_path / "crane.yaml"
    path.write_text(OTHER_ACTIONS)
    server, url = ros.serve("video_server", "crane_server", f"_actions:={path}")
    monkeypatch.setattr(page, "url", url)
    try:
        page.load()
        page.element("#tour-skip").click()
        page.mode("JOINT")
        label, _position, *buttons = page.text("arm-rows").split()
        assert (label, buttons) == ("jib", ["W", "▲", "up", "S", "▼", "down"])
        assert page.text("mode-note") == "each joint"
        robot.forget()
        page.hold_until(lambda: robot.heard(ARM), "w")
        command = robot.heard(ARM)[0]
        assert command["joint_names"] == ["shoulder_joint"]
        assert command["velocities"][0] < 0.0
        page.hold_until(lambda: robot.heard(DRIVE), "ArrowUp")
        assert robot.heard(DRIVE)[0]["linear"]["x"] == 1.2
        page.element("#help").click()
        always, crane = (" ".join(group.split()) for group in page.texts("#key-groups section"))
        assert always == "Always Esc estop Space stop ↑ tracks ahead"
        assert crane == "Crane W jib up S jib down"
        assert page.errors() == []
    finally:
        page.browser.go("about:blank")
        ros.stop(server)
        page.errors()


def test_the_attitude_turns_from_calm_to_alarm_and_vanishes_with_its_topic(robot, page):
    def tell(**values):
        topic = "/telex/sim/stability"
        robot.probe.publish(topic, "telex_msgs/Stability", values, rate=10)

    def meter(name):
        return page.element("#attitude-meter").get_attribute(name)

    assert not page.element("#attitude").is_displayed()
    support = [{"x": 0.3, "y": 0.2}, {"x": -0.3, "y": 0.2}]
    tell(state=0, roll=0.0, pitch=-0.35, margin=0.9, direction=-math.pi / 2, support=support)
    wait_until(lambda: page.attribute("attitude", "data-state") == "stable")
    assert page.text("attitude-pitch") == "20° nose up"
    assert page.text("attitude-roll") == "level"
    assert meter("aria-valuetext") == "90 percent, weakest over the right"
    tell(state=1, roll=-0.6, pitch=0.2, margin=0.12, direction=math.pi / 2, support=support)
    wait_until(lambda: page.attribute("attitude", "data-state") == "caution")
    assert (page.text("attitude-way"), page.text("attitude-margin")) == ("over the left", "12 %")
    assert page.text("attitude-roll") == "34° left down"
    assert meter("aria-valuenow") == "12"
    # Once it is about to tip over, only the way counts; and a robot in the air has none.
    tell(state=2, roll=-0.6, pitch=0.2, margin=0.0, direction=math.pi / 2, support=support)
    wait_until(lambda: page.attribute("attitude", "data-state") == "critical")
    assert page.text("attitude-word") == "TIPPING"
    assert (page.text("attitude-way"), page.text("attitude-margin")) == ("over the left", "")
    assert meter("aria-valuetext") == "about to tip over the left"
    assert ["warning", "about to tip over the left"] in lines(page)
    tell(state=2, roll=-0.6, pitch=0.2, margin=0.5, direction=math.pi / 2)
    wait_until(lambda: page.text("attitude-way") == "")
    assert page.text("attitude-margin") == ""
    assert meter("aria-valuetext") == "about to tip over"
    tell(state=3, roll=1.6, pitch=0.0, margin=-0.4, direction=0.0)
    wait_until(lambda: page.text("attitude-word") == "TIPPED OVER")
    assert meter("aria-valuenow") == "0"
    robot.probe.publish("/telex/sim/stability", "telex_msgs/Stability", {"state": 3})
    wait_until(lambda: not page.element("#attitude").is_displayed())
    assert page.errors() == []


def test_a_finger_on_a_button_drives_until_it_is_lifted(robot, page):
    """As on a tablet: two fingers hold two buttons; one slides off its own before both go up."""
    page.mode("DRIVE")
    box = (
        "const box = document.querySelector('[data-action=\"%s\"]').getBoundingClientRect();"
        "return {x: box.x + box.width / 2, y: box.y + box.height / 2};"
    )
    ahead, left = (page.script(box % f"drive:{way}") for way in ("forward", "left"))

    def touch(kind, *points):
        fingers = [{**point, "id": number} for number, point in enumerate(points)]
        page.browser.call("Input.dispatchTouchEvent", type=kind, touchPoints=fingers)

    def commands():
        return [(each["linear"]["x"], each["angular"]["z"] > 0.0) for each in robot.heard(DRIVE)]

    @contextlib.contextmanager
    def fingers():
        touch("touchStart", ahead)
        try:
            time.sleep(0.1)
            touch("touchStart", ahead, left)
            time.sleep(0.1)
            touch("touchMove", ahead, {**left, "y": left["y"] + 300.0})
            yield
        finally:
            touch("touchEnd")

    def both_hold():
        # Of what was sent before the finger slid there are some ten.
        told = commands()
        return told[0] == (1.2, False) and len(told) > 40 and set(told[-20:]) == {(1.2, True)}

    with page.held_until(both_hold, fingers, anew=robot.forget):
        pass
    wait_until(lambda: commands()[-1] == (0.0, False))
    assert robot.is_quiet(DRIVE)


def driving(robot, page):
    """Hold the key that drives ahead: the robot is told to before the caller's block begins."""

    def is_told():
        return len(robot.heard(DRIVE)) >= 5 and robot.heard(DRIVE)[-1]["linear"]["x"] == 1.2

    return page.held_until(is_told, lambda: page.hold("w"), anew=robot.forget)


def keeps_pace(robot, topic):
    """Tell whether the last 25 commands on a topic came 50 times a second, by their median."""
    times = [arrival for arrival, _ in robot.probe.heard[topic][-25:]]
    gaps = [b - a for a, b in zip(times, times[1:])]
    return len(times) == 25 and 0.017 < statistics.median(gaps) < 0.024


def is_held(page, action):
    """Tell whether the page shows that an action is held."""
    return "held" in page.element(f'[data-action="{action}"]').get_attribute("class")


AFTER_RELEASE = """
const [driving] = arguments;
window.afterRelease = [];
window.addEventListener("keyup", () => { window.afterRelease = []; }, {capture: true});
const send = WebSocket.prototype.send;
WebSocket.prototype.send = function (text) {
  const {op, topic, msg} = JSON.parse(text);
  if (op === "publish" && topic === driving) window.afterRelease.push(msg.linear.x);
  send.call(this, text);
};
"""
"""Lets a page note the speeds that it sends on a topic once it has heard that a key was let go."""


def test_a_held_key_drives_50_times_a_second_until_it_is_let_go(robot, page):
    def drives():
        return keeps_pace(robot, DRIVE) and is_held(page, "drive:forward")

    page.script(AFTER_RELEASE, DRIVE)
    with page.held_until(drives, lambda: page.hold("w"), anew=robot.forget):
        assert 1.2 in page.script("return window.afterRelease")
    wait_until(lambda: robot.heard(DRIVE)[-1]["linear"]["x"] == 0.0)
    assert robot.is_quiet(DRIVE)
    # At the page, at once: what is still on its way may take a busy machine a while.
    assert 1.2 not in page.script("return window.afterRelease")
    commands = robot.heard(DRIVE)
    assert {command["linear"]["x"] for command in commands[:-1]} == {1.2}
    assert commands[-1]["linear"]["x"] == 0.0


@pytest.mark.parametrize(
    ("keys", "linear", "angular"),
    [("w", 1.2, 0.0), ("s", -1.2, 0.0), ("a", 0.0, 1.0), ("d", 0.0, -1.0), ("wd", 1.2, -1.0)],
)
def test_driving(robot, page, keys, linear, angular):
    def command():
        last = robot.heard(DRIVE)[-1]
        return last["linear"]["x"], last["angular"]["z"]

    page.hold_until(lambda: command() == (linear, angular), *keys)
    wait_until(lambda: command() == (0.0, 0.0))


@pytest.mark.parametrize(
    ("topic", "key", "joints", "velocity"),
    [
        (ARM, "j", ["turret_joint"], 0.6),
        (ARM, "i", ["shoulder_joint"], -0.6),
        (ARM, "o", ["telescope_joint"], 0.6),
        (ARM, ";", ["elbow_joint"], 0.6),
        (ARM, "n", ["forearm_roll_joint"], -0.6),
        (ARM, "[", ["wrist_pitch_joint"], -0.6),
        (ARM, "0", ["gripper_roll_joint"], 0.6),
        (GRIPPER, ".", ["gripper"], 0.16),
        (GRIPPER, ",", ["gripper"], -0.16),
        (FLIPPERS, "r", ["front_left_flipper_joint", "front_right_flipper_joint"], 0.7),
        (FLIPPERS, "g", ["rear_left_flipper_joint", "rear_right_flipper_joint"], -0.7),
    ],
)
def test_joints_move_at_their_own_limit_and_stop(robot, page, topic, key, joints, velocity):
    page.hold_until(lambda: len(robot.heard(topic)) >= 3, key, anew=robot.forget)
    jog = robot.heard(topic)[0]
    assert (jog["joint_names"], jog["velocities"]) == (joints, [velocity] * len(joints))
    assert jog["header"]["stamp"]["secs"] > 0
    wait_until(lambda: robot.heard(topic)[-1]["velocities"] == [0.0] * len(joints))
    assert robot.is_quiet(topic, 0.1)


def test_a_joint_that_is_let_go_stops_while_another_moves_on(robot, page):
    def velocities():
        return [dict(zip(jog["joint_names"], jog["velocities"])) for jog in robot.heard(ARM)]

    @contextlib.contextmanager
    def one_for_a_moment():
        with page.hold("j"):
            with page.hold("k"):
                time.sleep(0.2)
            yield

    def goes_on():
        told = velocities()
        return any("shoulder_joint" in each for each in told) and told[-1] == {"turret_joint": 0.6}

    with page.held_until(goes_on, one_for_a_moment, anew=robot.forget):
        both = [each for each in velocities() if "shoulder_joint" in each]
    assert both[0] == {"turret_joint": 0.6, "shoulder_joint": 0.6}
    assert both[-1] == {"turret_joint": 0.6, "shoulder_joint": 0.0}


def one_beside_the_other(page, first, second):
    """Return what holds a key, and a moment later another one beside it (for `held_until`)."""

    @contextlib.contextmanager
    def hold():
        with page.hold(first):
            time.sleep(0.2)
            with page.hold(second):
                yield

    return hold


def test_both_keys_of_a_pair_stand_still(robot, page):
    def stands():
        return [robot.heard(ARM)[each]["velocities"] for each in (0, -1)] == [[0.6], [0.0]]

    with page.held_until(stands, one_beside_the_other(page, "j", "l"), anew=robot.forget):
        assert robot.is_quiet(ARM)


def test_one_side_of_the_flippers(robot, page):
    page.mode("DRIVE")
    page.hold_until(lambda: robot.heard(FLIPPERS), "q", "r", anew=robot.forget)
    assert robot.heard(FLIPPERS)[0]["joint_names"] == ["front_left_flipper_joint"]
    robot.forget()
    page.element('[data-side="right"]').click()
    page.hold_until(lambda: robot.heard(FLIPPERS), "t")
    assert robot.heard(FLIPPERS)[0]["joint_names"] == ["rear_right_flipper_joint"]
    page.element('[data-side="both"]').click()


def test_a_digit_holds_a_flipper_preset_until_it_is_let_go(robot, page):
    def moves():
        # What the robot takes for silence is far longer.
        return keeps_pace(robot, PRESETS) and is_held(page, "preset:3")

    page.hold_until(moves, "4", anew=robot.forget)
    wait_until(lambda: robot.heard(PRESETS)[-1]["preset"] == "")
    assert robot.is_quiet(PRESETS)
    commands = robot.heard(PRESETS)
    assert {command["preset"] for command in commands[:-1]} == {"climb"}
    assert all(command["joint_names"] == [] for command in commands)
    assert robot.heard(FLIPPERS) == []


def test_presets_are_buttons_with_the_robots_names(robot, page):
    page.mode("DRIVE")
    assert [text.split() for text in page.texts('[data-action^="preset:"]')] == [
        [str(digit), name] for digit, name in enumerate(PRESET_NAMES, start=1)
    ]
    assert page.element('[data-action="preset:0"]').get_attribute("title") == "for flat"
    button = page.element('[data-action="preset:5"]')
    with page.held_until(lambda: robot.heard(PRESETS), button.held, anew=robot.forget):
        pass
    wait_until(lambda: robot.heard(PRESETS)[-1]["preset"] == "")
    assert {command["preset"] for command in robot.heard(PRESETS)[:-1]} == {"high"}


def test_a_preset_of_one_side(robot, page):
    page.hold_until(lambda: robot.heard(PRESETS), "e", "1", anew=robot.forget)
    names = robot.heard(PRESETS)[0]["joint_names"]
    assert names == ["front_right_flipper_joint", "rear_right_flipper_joint"]


def test_two_presets_at_once_stand_still(robot, page):
    def stands():
        return [robot.heard(PRESETS)[each]["preset"] for each in (0, -1)] == ["flat", ""]

    with page.held_until(stands, one_beside_the_other(page, "1", "2"), anew=robot.forget):
        assert robot.is_quiet(PRESETS)


def test_stop_ends_a_preset_that_nobody_holds_here(robot, page):
    page.press("Space")
    assert robot.wait_for(PRESETS)[-1]["preset"] == ""


def test_a_button_moves_while_the_pointer_holds_it(robot, page):
    @contextlib.contextmanager
    def beside():
        with page.element('[data-action="turret:left"]').held() as move:
            # Beside the button it is still held: the pointer belongs to it until it is lifted.
            move(-300, 0)
            yield

    with page.held_until(lambda: len(robot.heard(ARM)) > 30, beside, anew=robot.forget):
        pass
    wait_until(lambda: robot.heard(ARM)[-1]["velocities"] == [0.0])
    assert robot.is_quiet(ARM)
    held = robot.heard(ARM)[:-1]
    assert {jog["velocities"][0] for jog in held} == {0.6}
    assert len(held) > 20


LOSSES = {
    "blur": "window.dispatchEvent(new Event('blur'))",
    "freeze": "document.dispatchEvent(new Event('freeze'))",
    "hang": "const end = performance.now() + 400; while (performance.now() < end);",
}


@pytest.mark.parametrize("loss", LOSSES)
def test_losing_the_operator_stops_and_only_a_new_press_moves(robot, page, loss):
    with driving(robot, page):
        page.script(LOSSES[loss])
        wait_until(lambda: robot.heard(DRIVE)[-1]["linear"]["x"] == 0.0)
        # The key is still down, and the keyboard repeats it.
        page.script(
            "window.dispatchEvent(new KeyboardEvent('keydown', {code: 'KeyW', repeat: true}))"
        )
        assert robot.is_quiet(DRIVE)
        assert "released:" in page.text("warning")
    robot.forget()
    page.hold_until(lambda: robot.heard(DRIVE)[-1]["linear"]["x"] == 1.2, "w")


def test_a_page_that_is_left_gives_its_connections_up_until_it_is_shown_again(ros, robot, page):
    robot.probe.subscribe(CLIENTS, "telex_msgs/BridgeClients")

    def names():
        return [client["id"] for client in robot.probe.messages(CLIENTS)[-1]["clients"]]

    wait_until(lambda: len(names()) == 1, timeout=20.0)
    (before,) = names()
    with driving(robot, page):
        # At once, for a warning vanishes after 3 s.
        warning = page.script(
            "window.dispatchEvent(new Event('pagehide'));"
            "return document.getElementById('warning').textContent"
        )
        assert "released: the page was left" in warning
        wait_until(lambda: robot.heard(DRIVE)[-1]["linear"]["x"] == 0.0, timeout=5.0)
        # Whoever opens the page anew does not find that this one has control.
        wait_until(lambda: names() == [], timeout=20.0)
        wait_until(lambda: ros.subscribers(PICTURE) == [], timeout=20.0)
    page.script("window.dispatchEvent(new Event('pageshow'))")
    wait_until(lambda: len(names()) == 1 and names() != [before], timeout=20.0)
    wait_until(lambda: page.attribute("link", "data-state") == "up", timeout=20.0)
    page.wait_until_all_is_shown()
    robot.forget()
    page.hold_until(lambda: robot.heard(DRIVE)[-1]["linear"]["x"] == 1.2, "w")


def test_a_page_that_comes_back_from_the_history_is_connected(robot, page):
    page.browser.go("about:blank")
    page.script("setTimeout(() => history.back())")  # the answer comes before the page goes
    wait_until(lambda: page.attribute("link", "data-state") == "up", timeout=30.0)
    page.wait_until_all_is_shown()


def test_another_tab_in_front_stops(ros, robot, page):
    other = page.browser.open_tab()
    with driving(robot, page):
        page.browser.show(other)
        wait_until(lambda: robot.heard(DRIVE)[-1]["linear"]["x"] == 0.0)
        assert robot.is_quiet(DRIVE)
        # Nobody sees the pictures: the cameras need not draw them.
        wait_until(lambda: ros.subscribers(PICTURE) == [], timeout=20.0)
        page.browser.close_tab(other)
        page.browser.show()
        assert robot.is_quiet(DRIVE)


def test_losing_the_operator_stops_a_preset(robot, page):
    def presets():
        return len(robot.heard(PRESETS)) >= 3 and robot.heard(PRESETS)[-1]["preset"] == "high"

    with page.held_until(presets, lambda: page.hold("6"), anew=robot.forget):
        page.script(LOSSES["blur"])
        wait_until(lambda: robot.heard(PRESETS)[-1]["preset"] == "")
        assert robot.is_quiet(PRESETS)


def test_keys_with_modifiers_and_space(robot, page):
    for modifier in ("ctrlKey", "altKey", "metaKey"):
        event = f"new KeyboardEvent('keydown', {{code: 'KeyW', {modifier}: true}})"
        page.script(f"window.dispatchEvent({event})")
    assert robot.is_quiet(DRIVE, 0.2)
    with driving(robot, page):
        page.press("Space")
        wait_until(lambda: robot.heard(DRIVE)[-1]["linear"]["x"] == 0.0)
        assert robot.is_quiet(DRIVE)


def test_speed(robot, page):
    # Noted by the page: as long as the nodes do not confirm it, it counts for 0.5 s.
    page.script("""
        window.speeds = [];
        const speed = document.getElementById("speed");
        window.noting = new MutationObserver(() => speeds.push(speed.textContent));
        noting.observe(speed, {childList: true, characterData: true, subtree: true});
    """)
    page.press("=")
    wait_until(lambda: "50 %" in page.script("return speeds"))
    page.script("noting.disconnect()")
    for node in NODES:
        assert robot.wait_for(f"/telex/{node}/speed_scale")[-1] == {"data": 0.5}
    robot.publish_node_status(0.1)
    wait_until(lambda: page.text("speed") == "10 %")
    page.element("#slower").click()
    topic = "/telex/arm_teleop/speed_scale"
    wait_until(lambda: robot.heard(topic)[-1] == {"data": 0.05})
    robot.publish_node_status(0.05)
    wait_until(lambda: page.text("speed") == "5 %")
    time.sleep(0.6)
    page.press("=")
    wait_until(lambda: robot.heard(topic)[-1] == {"data": 0.1})
    robot.publish_node_status(0.4)


def test_estop_lets_go_and_holds_until_it_is_released(robot, page):
    with driving(robot, page):
        page.press("Escape")
        assert robot.wait_for(ESTOP)[-1] == {"data": True}
        wait_until(lambda: robot.heard(DRIVE)[-1]["linear"]["x"] == 0.0)
        robot.publish_sim(e_stop=True)
        wait_until(lambda: page.element("#estop-band").is_displayed())
        robot.forget()
    refused = "e-stop is active: release it first"
    with page.held_until(lambda: page.text("warning") == refused, lambda: page.hold("w")):
        assert robot.is_quiet(DRIVE)
        page.element("#release").click()
        wait_until(lambda: robot.heard(ESTOP)[-1] == {"data": False})
        robot.publish_sim(e_stop=False)
        wait_until(lambda: not page.element("#estop-band").is_displayed())
        assert robot.is_quiet(DRIVE)
    robot.forget()
    page.element("#estop").click()
    assert robot.wait_for(ESTOP)[-1] == {"data": True}
    # Space after the click must not click again.
    page.press("Space")
    assert robot.is_quiet(ESTOP, 0.2)
    assert robot.heard(ESTOP) == [{"data": True}]


def test_an_e_stop_that_a_dead_network_took_is_sent_again(robot, page):
    page.script(DEAD_NETWORK)
    page.press("Escape")
    assert robot.is_quiet(ESTOP, 0.2)
    page.script("revive()")
    assert robot.wait_for(ESTOP) == [{"data": True}]
    assert "e-stop was NOT sent" in page.text("log")
    robot.publish_sim(e_stop=True)
    wait_until(lambda: page.element("#estop-band").is_displayed())
    # Once the simulator has said so, it is done with, whoever releases it.
    robot.publish_sim()
    wait_until(lambda: not page.element("#estop-band").is_displayed())
    robot.forget()
    page.script("revive()")
    wait_until(lambda: page.attribute("link", "data-state") == "lost")
    wait_until(lambda: page.attribute("link", "data-state") == "up", timeout=15.0)
    assert robot.is_quiet(ESTOP, 0.2)


def test_paused_and_silent_simulator(robot, page):
    warning = ""
    for _ in range(5):  # a page that stood still has let go, and says that instead
        with driving(robot, page):
            robot.publish_sim(paused=True)
            wait_until(lambda: page.text("sim-state") == "PAUSED")
            warning = page.text("warning")
            robot.publish_sim()
            wait_until(lambda: page.text("sim-state") == "running")
            assert robot.is_quiet(DRIVE)
        if "paused" in warning:
            break
    assert warning == "released: the simulation is paused"
    assert robot.heard(DRIVE)[-1]["linear"]["x"] == 0.0
    status = {"paused": False, "real_time_factor": 1.0}
    robot.probe.publish("/telex/sim/status", "telex_msgs/SimStatus", status)
    wait_until(lambda: page.text("sim-state") == "NO STATUS")
    assert "." not in page.text("sim-speed")
    robot.publish_sim()


def test_a_picture_that_stalls_is_not_shown_as_live(robot, page):
    robot.publish_camera("front")
    wait_until(lambda: page.element("#no-picture").is_displayed())
    assert "NO PICTURE" in page.text("no-picture")
    robot.publish_camera("mast", camera_picture(320, 240, 3))
    shown = {"mast": "stalled", "rear": "live"}
    wait_until(lambda: shown.items() <= dict(page.thumbnails()).items())
    assert page.thumbnail("mast").text.split()[:3] == ["mast", "NO", "PICTURE"]
    robot.publish_camera("front", rate=15)
    robot.publish_camera("mast", camera_picture(320, 240, 3), rate=2)
    wait_until(lambda: page.attribute("view", "data-state") == "live")
    wait_until(lambda: page.all_live())


def test_a_lost_bridge_releases_is_announced_and_found_again(ros, robot, page):
    page.errors()
    with driving(robot, page):
        ros.stop(ros.bridge)
        wait_until(lambda: page.element("#link-band").is_displayed())
        assert robot.heard(DRIVE)[-1]["linear"]["x"] == 0.0
        assert "Connection lost" in page.text("link-band")
        robot.forget()
        ros.bridge, _ = ros.serve("rosbridge")
        wait_until(lambda: page.attribute("link", "data-state") == "up", timeout=15.0)
        wait_until(lambda: not page.element("#link-band").is_displayed())
        assert robot.is_quiet(DRIVE)
        assert robot.heard(DRIVE) == []

    def drives():
        with page.hold("w"):
            time.sleep(0.3)
        return any(command["linear"]["x"] == 1.2 for command in robot.heard(DRIVE))

    # A bridge that has only just started may be too late for the first press.
    wait_until(drives, timeout=15.0)
    wait_until(lambda: robot.heard(DRIVE)[-1]["linear"]["x"] == 0.0)
    # The browser itself reports connections that fail; nothing else may be there.
    others = itertools.filterfalse(lambda text: "WebSocket connection to" in text, page.errors())
    assert list(others) == []


def test_closing_the_page_stops(robot, page):
    with driving(robot, page):
        page.browser.go("about:blank")
        wait_until(lambda: robot.heard(DRIVE)[-1]["linear"]["x"] == 0.0)
        assert robot.is_quiet(DRIVE)
