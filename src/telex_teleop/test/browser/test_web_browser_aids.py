"""Aids in the console's pictures: how they are switched, what they cost, what they need."""

from __future__ import annotations

import json

import pytest
from console_page import page, robot, ros
from waiting import wait_until
from web_robot import CONTACT, SHOULDER, THUMBNAILS

# the fixtures of the console's other tests, started anew for this file
__all__ = ["page", "robot", "ros"]

pytestmark = [pytest.mark.ros, pytest.mark.browser]

# Looks ahead and level, 0.3 m over the axles; the tracks' wheels are 0.1 m in radius, 0.4 m apart.
EYE = (0.4, 0.0, 0.3)
RADIUS = 0.1
URDF = f"""
<robot name="telex">
  <link name="base_link"/><link name="upper_arm_link"/><link name="eye_frame"/>
  <link name="left_link"/><link name="right_link"/><link name="pad_link"/>
  {SHOULDER}
  <joint name="eye_joint" type="fixed">
    <parent link="base_link"/><child link="eye_frame"/>
    <origin xyz="{EYE[0]} {EYE[1]} {EYE[2]}" rpy="-1.5707963 0 -1.5707963"/>
  </joint>
  <joint name="pad_joint" type="fixed">
    <parent link="base_link"/><child link="pad_link"/><origin xyz="1.4 0.2 0.3"/>
  </joint>
  <joint name="left_joint" type="continuous">
    <parent link="base_link"/><child link="left_link"/><origin xyz="0.3 0.2 0"/><axis xyz="0 1 0"/>
  </joint>
  <joint name="right_joint" type="continuous">
    <parent link="base_link"/><child link="right_link"/><origin xyz="0.3 -0.2 0"/>
    <axis xyz="0 1 0"/>
  </joint>
</robot>
"""
TRACKS = {
    "left_wheel": ["left_joint"],
    "right_wheel": "right_joint",
    "wheel_radius": RADIUS,
    "wheel_separation": 0.4,
}
FOCAL = 400.0
INFO = {
    "header": {"frame_id": "eye_frame"},
    "width": 640,
    "height": 480,
    "distortion_model": "plumb_bob",
    "D": [0.0] * 5,
    "K": [FOCAL, 0.0, 319.5, 0.0, FOCAL, 239.5, 0.0, 0.0, 1.0],
}

# The colours of a canvas over a view, and how many of its pixels have anything.
PAINTED = """
    const canvas = document.querySelector("%s > canvas.aids");
    if (canvas === null || canvas.hidden || canvas.width === 0) return 0;
    const {data} = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    let count = 0;
    for (let at = 3; at < data.length; at += 4) if (data[at] > 0) count += 1;
    return count;
"""
# Where, in rows of the camera, a column of the canvas has a colour of the 1 m line.
ROWS = """
    const canvas = document.querySelector("#view > canvas.aids");
    const {clientWidth: width, clientHeight: height} = canvas.parentElement;
    const scale = Math.min(width / 640, height / 480);
    const left = (width - 640 * scale) / 2 - canvas.offsetLeft;
    const context = canvas.getContext("2d");
    const {data} = context.getImageData(Math.round(left + %s * scale), 0, 1, canvas.height);
    const rows = [];
    for (let row = 0; row < canvas.height; row += 1) {
      const [red, green, blue] = data.slice(4 * row, 4 * row + 3);
      const isLine = red === 255 && green === 211 && blue === 92;
      if (isLine) rows.push((canvas.offsetTop + row + 0.5) / scale - 0.5);
    }
    return rows;
"""


@pytest.fixture(scope="module", autouse=True)
def calibrated(ros, robot, page):
    ros.master.setParam("/telex/robot_description", URDF)
    ros.master.setParam("/telex/track_controller", TRACKS)
    ros.master.setParam("/telex/arm_teleop/frames/tool", "upper_arm_link")
    robot.publish_node_status()
    for camera in ("front", *THUMBNAILS):  # whichever the second view shows
        topic = f"/telex/cameras/{camera}/camera_info"
        robot.probe.publish(topic, "sensor_msgs/CameraInfo", INFO, rate=10)
    page.load()  # which is else about the robot before, until it loads itself anew
    page.element("#tour-skip").click()


@pytest.fixture(autouse=True)
def loaded(calibrated, page):
    page.script("for (const name of Object.keys(localStorage)) localStorage.removeItem(name)")
    page.script("localStorage.setItem('telex.tour', 'seen')")
    page.load()
    page.wait_until_all_is_shown()


def painted(page, view="#view"):
    return page.script(PAINTED % view)


def test_the_guide_line_is_where_the_camera_shows_the_floor(page):
    wait_until(lambda: painted(page) > 0)
    # 1 m from the end of the wheels, which stand RADIUS below the axles; in the picture's middle
    ahead = 0.3 + RADIUS + 1.0 - EYE[0]
    row = 239.5 + FOCAL * (EYE[2] + RADIUS) / ahead
    rows = page.script(ROWS % 330)
    assert rows
    assert abs(sum(rows) / len(rows) - row) < 0.7
    # In both large views, whichever camera they show.
    wait_until(lambda: painted(page, "#second .thumbnail") > 0)


def test_a_calibration_is_asked_for_once_and_nothing_is_done_when_all_are_off(ros, page):
    topic = "/telex/cameras/front/camera_info"
    wait_until(lambda: painted(page) > 0)
    wait_until(lambda: not ros.subscribers(topic))
    page.press("Numpad1")
    wait_until(lambda: painted(page) == 0)
    page.script("window.drawn = 0; const take = CanvasRenderingContext2D.prototype.clearRect;"
                "CanvasRenderingContext2D.prototype.clearRect = function (...all) {"
                "if (this.canvas.className === 'aids') window.drawn += 1;"
                "return take.apply(this, all); };")  # fmt: skip
    page.script("return new Promise((resolve) => setTimeout(resolve, 500))")
    assert page.script("return window.drawn") == 0
    assert not ros.subscribers(topic)


def test_aids_are_switched_by_key_and_button_and_kept_for_each_layout(page):
    def on():
        return page.script(
            "return [...document.querySelectorAll('#aids-switches [aria-checked=\"true\"]')]"
            ".map(({dataset}) => dataset.command)"
        )

    assert on() == ["aid:guides"]
    page.press("Numpad0")
    assert page.element("#aids-switches").is_displayed()
    assert page.attribute("aids-open", "aria-expanded") == "true"
    page.press("Numpad5")
    page.element('[data-command="aid:compass"]').click()
    page.element('[data-command="aid:guides"]').click()
    assert on() == ["aid:horizon", "aid:compass"]
    page.mode("JOINT")
    assert on() == ["aid:aim", "aid:contact"]
    page.mode("DRIVE")
    page.load()
    assert on() == ["aid:horizon", "aid:compass"]
    page.press("Numpad0")
    page.press("Numpad8")
    wait_until(lambda: page.element("#radiation-map").is_displayed())
    page.element("#radiation-map-close").click()
    assert on() == ["aid:horizon", "aid:compass"]


def test_an_exam_leaves_no_training_aid(robot, page):
    def exam(phase):
        state = {"phase": phase, "mode": "exam", "valid": True}
        topic = "/telex/training/state"
        robot.probe.publish(topic, "telex_msgs/TrainingState", state, latch=True)

    touch = {"pads": [{"link": "pad_link", "normal_force": 12.0}], "object": "cube"}
    robot.probe.publish(CONTACT, "telex_msgs/GripperContact", touch, rate=20)
    page.press("Numpad1")
    page.press("Numpad4")
    wait_until(lambda: painted(page) > 0)
    note = '[data-command="aid:contact"] .aid-note'
    page.press("Numpad0")
    assert page.element(note).text == "\N{WHITE DIAMOND} training aid"
    told = "/telex/console/telemetry"
    robot.probe.subscribe(told, "std_msgs/String")
    # who has control tells what he sees
    page.hold_until(lambda: aids_told(robot, told).get("contact marks") is True, "w")
    try:
        exam("running")
        wait_until(lambda: painted(page) == 0)
        assert page.element(note).text == "not in an exam"
        page.press("Numpad4")
        assert "not in an exam: this robot has no pads" in page.text("warning")
        robot.probe.heard[told].clear()
        wait_until(lambda: robot.heard(told) and "contact marks" not in aids_told(robot, told))
        exam("ended")
        wait_until(lambda: painted(page) > 0)
    finally:
        exam("idle")
        robot.probe.publish(CONTACT, "telex_msgs/GripperContact")


def test_a_page_loaded_in_an_exam_knows_the_robot_and_hears_afterwards_what_was_closed(robot, page):
    def exam(trial):
        topic = "/telex/training/exam"
        robot.probe.publish(topic, "std_msgs/String", {"data": trial}, latch=True)

    touch = {"pads": [{"link": "pad_link", "normal_force": 12.0}], "object": "cube"}
    robot.probe.publish(CONTACT, "telex_msgs/GripperContact", touch, rate=20)
    try:
        page.press("Numpad1")
        page.press("Numpad4")
        wait_until(lambda: painted(page) > 0)
        exam("t1")
        wait_until(lambda: painted(page) == 0)
        page.load()
        page.press("Numpad1")
        wait_until(lambda: painted(page) > 0)
        page.press("Numpad1")
        wait_until(lambda: painted(page) == 0)
        exam("")
        wait_until(lambda: painted(page) > 0)
    finally:
        exam("")
        robot.probe.publish(CONTACT, "telex_msgs/GripperContact")


def aids_told(robot, topic):
    heard = robot.heard(topic)
    return json.loads(heard[-1]["data"])["aids"] if heard else {}
