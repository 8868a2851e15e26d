"""The console's arm panel in headless Chromium: modes, frames, tool and named poses."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from console_page import page, robot, ros
from waiting import wait_until
from web_robot import ARM, ARM_JOINTS, PRESETS

# the fixtures of the console's other tests, started anew for this file
__all__ = ["page", "robot", "ros"]

pytestmark = [pytest.mark.ros, pytest.mark.browser]

TWIST = "/telex/arm_teleop/delta_twist_cmds"
POSE = "/telex/arm_teleop/named_pose_cmds"
MODES = ("JOINT", "CARTESIAN")
NOTICE = "slowed to 35 %: elbow_joint is 1.2 deg from its limit"
AXES = ("x", "y", "z")


class Arm:
    """Plays arm_teleop's side of the modes."""

    def __init__(self, robot):
        self.robot, self.probe = robot, robot.probe
        self.probe.subscribe(TWIST, "geometry_msgs/TwistStamped")
        self.probe.subscribe(POSE, "std_msgs/String")
        answer = {"success": True, "message": ""}
        for name, kind in (
            ("set_mode", "telex_msgs/SetMode"),
            ("hold_tool", "std_srvs/SetBool"),
            ("set_proximity_guard", "std_srvs/SetBool"),
        ):
            self.probe.do("serve", service=f"/telex/arm_teleop/{name}", type=kind, response=answer)
        self.report("JOINT")

    def report(self, mode, notice="", holds=False, guard=True):
        status = {
            "mode": mode,
            "notice": notice,
            "joint_names": ARM_JOINTS,
            "max_velocity": [0.6] * len(ARM_JOINTS),
            "speed_scale": 0.4,
            "min_speed_scale": 0.05,
            "max_speed_scale": 1.0,
        }
        cartesian = {
            "ready": True,
            "frames": ["tool_link", "base_link", "world"],
            "default_frame": "tool_link",
            "max_linear": 0.15,
            "max_angular": 0.6,
            "tool": {
                "position": {"x": 0.8, "y": -0.012, "z": 0.3},
                "orientation": {"y": 0.2164, "w": 0.9763},
            },
            "share": 1.0,
            "holds_tool": holds,
            "guard": guard,
            "poses": ["stow", "drive", "ready", "look_front"],
        }
        for topic, kind, message in (
            ("status", "telex_msgs/JointTeleopStatus", status),
            ("cartesian_status", "telex_msgs/CartesianTeleopStatus", cartesian),
        ):
            self.probe.publish(f"/telex/arm_teleop/{topic}", kind, message, rate=10)

    def forget(self):
        """Forget what was heard, once all that was sent has arrived."""
        wait_until(lambda: all(self.robot.is_quiet(topic, 0.1) for topic in (TWIST, POSE)))
        self.robot.forget()

    def twists(self):
        return [
            [
                *(message["twist"]["linear"][axis] for axis in AXES),
                *(message["twist"]["angular"][axis] for axis in AXES),
            ]
            for message in self.probe.messages(TWIST)
        ]

    def frames(self):
        return [message["header"]["frame_id"] for message in self.probe.messages(TWIST)]


@pytest.fixture(scope="module")
def arm(robot, page):
    robot.publish_node_status()
    arm = Arm(robot)
    page.mode("JOINT")
    return arm


@pytest.fixture
def in_mode(arm, page):
    """Put page and robot into a mode, whatever the last test left."""

    def put(mode, **what):
        arm.report(mode, **what)
        wait_until(lambda: is_checked(page, f'[data-mode="{mode}"]'), timeout=3.0)
        for topic in (TWIST, POSE, ARM):
            arm.probe.heard[topic].clear()
        arm.probe.requests.clear()

    page.resize(1280, 720)
    return put


def is_checked(page, selector):
    return page.element(selector).get_attribute("aria-checked") == "true"


def test_panel_shows_joints_or_tool_by_the_mode(arm, page, in_mode, tmp_path):
    in_mode("JOINT")
    assert page.element("#arm-rows").is_displayed()
    assert not page.element("#tool-rows").is_displayed()
    folder = Path(os.environ.get("TELEX_SCREENSHOTS", tmp_path))
    (folder / "console_joint.png").write_bytes(page.browser.screenshot())
    in_mode("CARTESIAN", notice=NOTICE)
    assert not page.element("#arm-rows").is_displayed()
    wait_until(lambda: page.text("tool_x-value") == "800 mm")
    assert page.text("tool_y-value") == "-12 mm"
    assert page.text("tool_pitch-value") == "25.0°"
    assert page.text("tool_roll-value") == "0.0°"
    assert page.text("arm-hud") == NOTICE
    (folder / "console_cartesian.png").write_bytes(page.browser.screenshot())
    assert page.errors() == []


@pytest.mark.parametrize(
    ("key", "index", "rate"),
    [
        ("o", 0, 0.15),
        ("u", 0, -0.15),
        ("j", 1, 0.15),
        ("l", 1, -0.15),
        ("i", 2, 0.15),
        ("k", 2, -0.15),
        ("0", 3, 0.6),
        ("9", 3, -0.6),
        ("'", 4, 0.6),
        ("[", 4, -0.6),
        ("n", 5, 0.6),
        ("m", 5, -0.6),
    ],
)
def test_keys_of_the_arm_move_the_tool_in_cartesian_mode(arm, page, in_mode, key, index, rate):
    in_mode("CARTESIAN")
    wanted = [0.0] * 6
    wanted[index] = rate
    page.hold_until(lambda: wanted in arm.twists(), key)
    wait_until(lambda: arm.twists()[-1] == [0.0] * 6, timeout=10.0)
    assert arm.probe.messages(ARM) == []


def test_joint_keys_without_meaning_for_the_tool_do_nothing(arm, page, in_mode):
    in_mode("CARTESIAN")
    page.hold_until(lambda: len(arm.twists()) > 5, "p", "o", anew=arm.forget)
    assert arm.probe.messages(ARM) == []


def test_the_same_keys_move_joints_in_joint_mode(arm, page, in_mode):
    in_mode("JOINT")
    page.hold_until(lambda: len(arm.probe.messages(ARM)) > 3, "o", anew=arm.forget)
    assert arm.probe.messages(ARM)[0]["joint_names"] == ["telescope_joint"]
    assert arm.twists() == []


def test_frame_is_chosen_by_key_and_by_button(arm, page, in_mode):
    in_mode("CARTESIAN")
    page.element('[data-frame="0"]').click()
    for frame in ("tool_link", "base_link", "world"):
        arm.probe.heard[TWIST].clear()
        page.hold_until(arm.frames, "i")
        wait_until(lambda: arm.twists()[-1] == [0.0] * 6, timeout=10.0)
        assert set(arm.frames()) == {frame}
        page.press("y")
    page.element('[data-frame="1"]').click()
    assert is_checked(page, '[data-frame="1"]')
    assert page.element('[data-frame="1"]').text == "base"


@pytest.mark.parametrize(("mode", "other"), [MODES, MODES[::-1]])
def test_mode_is_asked_for_by_key_and_by_button(arm, page, in_mode, mode, other):
    in_mode(mode)
    page.press("Tab")
    wait_until(lambda: arm.probe.requests == [{"mode": other}], timeout=10.0)
    page.element(f'[data-mode="{other}"]').click()
    wait_until(lambda: arm.probe.requests == [{"mode": other}] * 2, timeout=10.0)
    assert is_checked(page, f'[data-mode="{mode}"]')  # only the arm itself says which mode it is in


def test_change_of_mode_lets_go(arm, page, in_mode):
    in_mode("CARTESIAN")
    with page.held_until(lambda: len(arm.twists()) > 3, lambda: page.hold("j"), anew=arm.forget):
        arm.report("JOINT")
        wait_until(lambda: arm.twists()[-1] == [0.0] * 6, timeout=10.0)
        wait_until(lambda: is_checked(page, '[data-mode="JOINT"]'), timeout=10.0)
    assert arm.probe.messages(ARM) == []


@pytest.mark.parametrize("mode", MODES)
def test_named_pose_is_asked_for_while_its_key_is_held(arm, page, in_mode, mode):
    def names():
        return [message["data"] for message in arm.probe.messages(POSE)]

    in_mode(mode)
    page.hold_until(lambda: len(names()) > 10, "c", anew=arm.forget)
    wait_until(lambda: names()[-1] == "", timeout=10.0)
    assert set(names()[:-1]) == {"ready"}


def test_two_poses_at_once_stand_still(arm, page, in_mode):
    def names():
        return [message["data"] for message in arm.probe.messages(POSE)]

    in_mode("JOINT")
    with page.held_until(lambda: "ready" in names(), lambda: page.hold("c"), anew=arm.forget):
        with page.hold("z"):
            wait_until(lambda: names()[-1] == "", timeout=10.0)
        wait_until(lambda: names()[-1] == "ready", timeout=10.0)
    wait_until(lambda: names()[-1] == "", timeout=10.0)
    assert set(names()) == {"ready", ""}


@pytest.mark.parametrize("mode", MODES)
def test_flipper_presets_have_their_keys_in_both_modes(robot, arm, page, in_mode, mode):
    in_mode(mode)
    robot.forget()
    page.hold_until(lambda: robot.heard(PRESETS), "4")
    wait_until(lambda: robot.heard(PRESETS)[-1]["preset"] == "", timeout=10.0)
    assert {message["preset"] for message in robot.heard(PRESETS)} == {"climb", ""}
    assert arm.twists() == []


def test_pose_that_the_robot_does_not_have_cannot_be_held(page, in_mode):
    in_mode("JOINT")
    wait_until(
        lambda: not page.element('[data-action="pose:floor_pick"]').is_enabled(), timeout=3.0
    )
    assert page.element('[data-action="pose:stow"]').is_enabled()


def test_holding_the_tool_and_the_guard_are_switched(arm, page, in_mode):
    in_mode("CARTESIAN", holds=False)
    page.press("h")
    wait_until(lambda: arm.probe.requests == [{"data": True}], timeout=10.0)
    in_mode("CARTESIAN", holds=True)
    wait_until(lambda: is_checked(page, "#hold-tool"), timeout=3.0)
    page.element("#hold-tool").click()
    wait_until(lambda: arm.probe.requests == [{"data": False}], timeout=10.0)
    arm.probe.requests.clear()
    page.element("#guard").click()
    wait_until(lambda: arm.probe.requests == [{"data": False}], timeout=10.0)
