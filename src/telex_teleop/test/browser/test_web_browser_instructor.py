"""The instructor's page in headless Chromium."""

from __future__ import annotations

import json
import math
import re
import time

import axe
import numpy as np
import pytest
import simplejpeg
from console_page import DEAD_NETWORK, NOTHING, OTHER, SHIFT
from instructor_page import (
    HALL,
    START,
    VIEW,
    YARD,
    answer,
    outside,
    page,
    robot,
    ros,
    simulator,
)
from waiting import wait_until
from web_robot import ESTOP, THUMBNAILS

# the fixtures of the console's tests, started anew for this file
__all__ = ["page", "robot", "ros", "simulator"]

pytestmark = [pytest.mark.ros, pytest.mark.browser]

LOADED = {"success": True, "message": "scene yard: 2 objects in 0.10 s"}
REFUSED = {"success": False, "message": "yard.yaml: objects[0]: type is 'unicorn'"}


@pytest.fixture(autouse=True)
def clean(simulator, page):
    """Begin each test with a page that was just loaded, whatever the last one left."""
    simulator.reset()
    page.load(steady=False)
    # Where the last test has sent the camera is known to the bridge still.
    simulator.send_view(START)
    wait_until(lambda: page.text("view-hint") == "orbit · 4.0 m")
    time.sleep(0.2)  # the rest of the view came with it
    simulator.probe.heard[VIEW].clear()


def test_overview_and_all_cameras_are_live(page):
    wait_until(lambda: page.attribute("view", "data-state") == "live", timeout=20.0)
    assert page.text("camera-name") == "overview"
    wait_until(
        lambda: sorted(page.thumbnails())
        == [[camera, "live"] for camera in sorted([*THUMBNAILS, "front"])],
        timeout=20.0,
    )
    wait_until(lambda: page.text("sim-state") == "running")
    assert page.text("scene-name") == "hall"
    page.thumbnail("front").click()
    assert page.text("camera-name") == "front"
    wait_until(lambda: not page.element("#view-modes").is_displayed())
    page.thumbnail("overview").click()
    wait_until(lambda: page.element("#view-modes").is_displayed())
    assert page.errors() == []
    assert page.hosts() == {"127.0.0.1"}


def test_dragging_and_the_wheel_send_the_camera_about(simulator, page):
    heard = simulator.probe.heard[VIEW]
    wait_until(lambda: page.text("view-hint") == "orbit · 4.0 m")
    picture = page.element("#picture")
    picture.drag(100, 50)
    wait_until(lambda: heard and heard[-1][1]["azimuth"] == pytest.approx(1.0 - 0.6))
    view = heard[-1][1]
    assert view["elevation"] == pytest.approx(0.5 + 0.3)
    assert (view["mode"], view["distance"], view["center"]["z"]) == ("orbit", 4.0, 0.2)
    picture.wheel(200)
    wait_until(lambda: heard[-1][1]["distance"] == pytest.approx(4.0 * math.exp(0.24)))
    before = heard[-1][1]
    picture.drag(100, 0, SHIFT)
    wait_until(lambda: heard[-1][1]["center"] != before["center"])
    moved = heard[-1][1]
    assert moved["azimuth"] == before["azimuth"]
    # As if the ground were dragged to the right: the point goes to the camera's left.
    way = 0.16 * before["distance"]
    assert moved["center"]["x"] == pytest.approx(way * math.sin(0.4))
    assert moved["center"]["y"] == pytest.approx(-way * math.cos(0.4))


def test_the_camera_can_be_sent_about_while_no_picture_comes(simulator, page):
    heard = simulator.probe.heard[VIEW]
    simulator.robot.publish_camera("overview")
    wait_until(lambda: page.element("#no-picture").is_displayed())
    before = START
    page.element("#picture").drag(50, 0)
    wait_until(lambda: heard[-1][1]["azimuth"] == pytest.approx(before["azimuth"] - 0.3))
    simulator.robot.publish_camera("overview", rate=1)
    page.element("#picture").drag(-50, 0)
    wait_until(lambda: heard[-1][1]["azimuth"] == pytest.approx(before["azimuth"]))


def test_another_mode_keeps_the_place_of_the_camera(simulator, page):
    heard = simulator.probe.heard[VIEW]
    half = math.sqrt(0.5)
    pose = {"position": {"x": 2.0, "y": 1.0}, "orientation": {"z": half, "w": half}}
    base_pose = {"pose": pose}
    simulator.probe.publish("/telex/sim/base_pose", "geometry_msgs/PoseStamped", base_pose, rate=10)
    wait_until(lambda: page.text("robot-place") == "2.0 1.0 m")
    before = START
    page.element('[data-view="fixed"]').click()
    wait_until(lambda: heard[-1][1]["mode"] == "fixed")
    fixed = heard[-1][1]
    assert fixed["azimuth"] == before["azimuth"]
    assert fixed["center"]["x"] == pytest.approx(before["center"]["x"] + 2.0)
    assert fixed["center"]["y"] == pytest.approx(before["center"]["y"] + 1.0)
    page.element('[data-view="follow"]').click()
    wait_until(lambda: heard[-1][1]["mode"] == "follow")
    follow = heard[-1][1]
    assert follow["azimuth"] == pytest.approx(before["azimuth"] - math.pi / 2)
    assert follow["center"] == pytest.approx({"x": 0.0, "y": 0.0, "z": 0.3})


def test_the_robots_figures_are_those_that_are_known(simulator, page):
    def tell(**values):
        topic = "/telex/sim/stability"
        simulator.probe.publish(topic, "telex_msgs/Stability", {"state": 0, **values}, rate=10)

    def figures():
        return [page.text(f"robot-{each}") for each in ("roll", "pitch", "margin")]

    # the operator's
    wait_until(
        lambda: [page.text(f"robot-{each}") for each in ("heading", "speed")]
        == ["090°", "0.31 m/s"]
    )
    tell(roll=0.1, pitch=-0.2, margin=0.5)
    wait_until(lambda: figures() == ["6°", "-11°", "50 %"])
    tell(roll=0.1, pitch=math.nan, margin=math.nan)
    wait_until(lambda: figures() == ["6°", NOTHING, NOTHING])
    simulator.probe.publish("/telex/sim/stability", "telex_msgs/Stability")  # and then no more
    wait_until(lambda: figures() == [NOTHING] * 3)


def test_pause_step_and_reset(simulator, page):
    assert not page.element("#step").is_enabled()
    page.element("#pause").click()
    wait_until(lambda: simulator.asked("pause"))
    simulator.tell(paused=True)
    wait_until(lambda: page.text("sim-state") == "PAUSED")
    page.element("#step").click()
    wait_until(lambda: simulator.asked("step") == [{"steps": 50}])
    page.element("#pause").click()
    wait_until(lambda: simulator.asked("unpause"))
    simulator.tell()
    page.element("#reset").click()
    assert "Reset the scene?" in answer(page, "no")
    page.element("#reset").click()
    answer(page, "yes")
    wait_until(lambda: simulator.asked("reset"))
    assert len(simulator.asked("reset")) == 1


def test_a_scene_is_loaded_once_that_is_confirmed(simulator, page):
    def scenes():
        return page.script(
            "return [...document.querySelectorAll('#scenes li')]"
            ".map(({dataset}) => [dataset.scene, dataset.loaded])"
        )

    page.element("#tab-scene").click()
    wait_until(lambda: scenes() == [["hall", "true"], ["yard", "false"], ["broken", "false"]])
    sources = "[...document.querySelectorAll('#scenes img')].map(({src}) => src)"
    assert page.script(f"return {sources}") == ["data:image/jpeg;base64,/9j/2Q=="]
    assert "A step and a crate." in page.element('[data-scene="yard"]').text
    assert not page.element('[data-scene="broken"] button').is_enabled()
    simulator.serve("load_scene", "telex_msgs/LoadScene", held=True, **LOADED)
    page.element('[data-scene="yard"] button').click()
    assert answer(page, "no").startswith("Load yard? The robot starts anew")
    page.element('[data-scene="yard"] button').click()
    answer(page, "yes")
    wait_until(lambda: page.element("#scene-progress").is_displayed())
    assert page.text("scene-note").startswith("loading yard … ")
    simulator.serve(
        "list_scenes", "telex_msgs/ListScenes", scenes=[HALL, YARD], current="/scenes/yard.yaml"
    )
    simulator.release("load_scene")
    wait_until(lambda: page.text("scene-note") == LOADED["message"])
    assert simulator.asked("load_scene") == [{"world": "yard"}]
    assert not page.element("#scene-progress").is_displayed()
    wait_until(lambda: scenes() == [["yard", "true"], ["hall", "false"]])


def test_a_scene_that_takes_long_is_waited_for(simulator, page):
    """Longer than the 5 s after which other calls are given up."""
    page.element("#tab-scene").click()
    simulator.serve("load_scene", "telex_msgs/LoadScene", held=True, **LOADED)
    page.element('[data-scene="hall"] button').click()
    answer(page, "yes")
    longer = re.compile(r"loading hall … (5\.[4-9]|[6-9]|\d\d)")
    wait_until(lambda: longer.match(page.text("scene-note")))
    simulator.release("load_scene")
    wait_until(lambda: page.text("scene-note") == LOADED["message"])


def test_a_scene_that_is_refused_says_why(simulator, page):
    page.element("#tab-scene").click()
    simulator.serve("load_scene", "telex_msgs/LoadScene", **REFUSED)
    page.element('[data-scene="yard"] button').click()
    answer(page, "yes")
    wait_until(lambda: REFUSED["message"] in page.text("warning"))
    assert page.text("scene-note") == "refused"


def test_the_first_picture_of_another_scene_is_awaited(simulator, page):
    page.element("#tab-scene").click()
    simulator.serve("load_scene", "telex_msgs/LoadScene", **LOADED)
    simulator.robot.publish_camera("overview")  # once, and then no more
    wait_until(lambda: page.element("#no-picture").is_displayed())
    page.element('[data-scene="yard"] button').click()
    answer(page, "yes")
    wait_until(lambda: page.text("no-picture-why").startswith("drawing the new scene"))
    simulator.robot.publish_camera("overview", rate=5)
    wait_until(lambda: "fps" in page.text("camera-rate"))
    simulator.robot.publish_camera("overview", rate=1)


def test_the_e_stop_is_set_at_once_and_released_once_that_is_confirmed(simulator, robot, page):
    page.press("Escape")
    assert robot.wait_for(ESTOP)[-1] == {"data": True}
    simulator.tell(e_stop=True)
    wait_until(lambda: page.element("#estop-band").is_displayed())
    page.element("#release").click()
    answer(page, "yes")
    assert robot.wait_for(ESTOP, 2)[-1] == {"data": False}
    simulator.tell()
    wait_until(lambda: not page.element("#estop-band").is_displayed())


def test_an_e_stop_that_a_dead_network_took_is_sent_again(robot, page):
    robot.forget()
    page.script(DEAD_NETWORK)
    page.press("Escape")
    assert robot.is_quiet(ESTOP, 0.2)
    page.script("revive()")
    assert robot.wait_for(ESTOP) == [{"data": True}]
    assert "e-stop was NOT sent" in page.text("log")


def row(page, name):
    """Texts of the line of a client; raises LookupError while there is none."""
    rows = page.script(
        "return [...document.querySelectorAll('#roster tr')]"
        ".map((row) => [...row.cells].map((cell) => cell.innerText.trim()))"
    )
    return {cells[0]: cells[1:] for cells in rows}[name]


def test_who_is_connected_and_who_gets_control(ros, page):
    wait_until(lambda: row(page, "instructor (you)")[0] == "instructor")
    assert page.text("control-holder") == "free"
    url = f"{ros.param('/telex/rosbridge/url')}?name=Ann"
    assert page.script(OTHER, url)
    wait_until(lambda: row(page, "Ann")[:2] == ["watcher", "127.0.0.1"])
    assert page.script("return other.ask('take_control')")
    wait_until(lambda: page.text("control-holder") == "Ann")
    assert row(page, "Ann")[0] == "operator"
    page.element("#take").click()
    assert answer(page, "yes") == "Take control from Ann? What moves stops."
    wait_until(lambda: page.text("control-holder") == "you")
    button = '#roster tr[data-holds="false"] button'
    page.element(button).click()
    assert answer(page, "yes").startswith("Give control to Ann?")
    wait_until(lambda: row(page, "Ann")[3] == "in control")
    page.element("#take").click()
    answer(page, "yes")
    wait_until(lambda: page.element("#give-up").is_enabled())
    page.element("#give-up").click()
    wait_until(lambda: page.text("control-holder") == "free")
    page.script("other.close()")
    wait_until(lambda: len(page.texts("#roster tr")) == 1)


def test_warnings_of_nodes_are_logged(simulator, page):
    message = {"level": 4, "name": "/telex/arm_teleop", "msg": "the arm is held"}
    simulator.probe.publish("/rosout_agg", "rosgraph_msgs/Log", message, rate=5)
    wait_until(lambda: "arm_teleop: the arm is held" in page.text("log"))


@pytest.mark.parametrize("size", [(1280, 720), (1920, 1080)])
def test_nothing_is_cut_off(page, size):
    page.resize(*size)
    for tab in ("lesson", "scene", "faults"):
        page.element(f"#tab-{tab}").click()
        assert outside(page) == []
    page.resize(1280, 720)


# What is cut off or goes beyond its part of the page, or is too small for a finger, on a tablet.
FAULTS = """
    const parts = [...document.querySelectorAll("button, select, input:not([type=checkbox]), a")];
    return parts.filter((each) => each.checkVisibility()).flatMap((each) => {
      const {left, right, width, height} = each.getBoundingClientRect();
      const part = each.closest("td, .card, .panel, .pictures, header, footer");
      const room = part.getBoundingClientRect();
      const name = each.id || each.innerText;
      return [
        each.tagName === "BUTTON" && each.scrollWidth > each.clientWidth + 2 && `cut: ${name}`,
        (left < room.left - 1 || right > room.right + 1) && `beyond its part: ${name}`,
        innerWidth <= 900 && Math.min(width, height) < 44 && `${width} x ${height}: ${name}`,
      ].filter(Boolean);
    });
"""


def test_words_of_all_languages_have_room_on_a_tablet(ros, page):
    assert page.script(OTHER, f"{ros.param('/telex/rosbridge/url')}?name=Ann")
    wait_until(lambda: page.texts("#roster button"))
    faults = {}
    for language in ("en", "de", "fr"):
        assert page.script("return document.documentElement.lang") == language
        for size in ((820, 1180), (1024, 768)):
            page.resize(*size)
            for tab in ("scene", "faults", "lesson"):
                page.element(f"#tab-{tab}").click()
                faults[language, size, tab] = page.script(FAULTS)
        page.element("#language").click()
    page.resize(1280, 720)
    page.script("other.close(); localStorage.removeItem('telex.language')")
    assert {state: found for state, found in faults.items() if found} == {}


@pytest.mark.skipif(axe.lacking() != "", reason=axe.lacking())
def test_axe_finds_nothing(page):
    found = axe.findings(page.script)
    page.element("#tab-scene").click()
    for tool in ("put", "take"):
        page.element(f'[data-tool="{tool}"]').click()
        found += axe.findings(page.script)
    page.element("#tab-lesson").click()
    page.element("#reset").click()
    wait_until(lambda: page.element("#ask").is_displayed())
    found += axe.findings(page.script)
    answer(page, "no")
    assert found == []


SQUARE = {"corners": [4], "outlines": [0.5, 0.5, -0.5, 0.5, -0.5, -0.5, 0.5, -0.5]}
DOT = list(simplejpeg.encode_jpeg(np.zeros((1, 1, 3), np.uint8)))
LISTED = {
    "revision": 3,
    "frames": ["world", "telex/base_link", "box/body"],
    "robots": ["telex"],
    "bases": ["telex/base_link"],
    "floor": 40.0,
    "objects": [
        {"name": "wall", "frame": "world", "top": 2.0, **SQUARE},
        {"name": "box", "frame": "box/body", "movable": True, "top": 0.4, **SQUARE},
    ],
    "library": [
        {"type": "crate", "group": "tasks", "text": "A wooden crate.", "picture": DOT},
        {"type": "cone", "group": "building", "text": "A traffic cone."},
    ],
    "daylight": 1.0,
    "lamps": 1.0,
}
PLACE = {"position": {"x": 1.5, "y": -2.0, "z": 0.001}, "orientation": {"w": 1.0}}
FOUND = {"success": True, "met": "box", "movable": True, "pose": PLACE}


@pytest.fixture
def scene(simulator, page):
    """The scene's tab, with a box and a wall on its map."""
    simulator.serve("list_objects", "telex_msgs/ListObjects", **LISTED)
    simulator.serve("find_place", "telex_msgs/FindPlace", **FOUND)
    simulator.serve("spawn", "telex_msgs/Spawn", success=True, message="spawned: cone_1")
    simulator.serve("move", "telex_msgs/Move", success=True, message="moved: box")
    simulator.serve("delete", "telex_msgs/Delete", success=True, message="gone: box")
    poses = [*(0, 0, 0, 0, 0, 0, 1), *(-2, 0, 0.1, 0, 0, 0, 1), *(1.5, 1, 0, 0, 0, 0, 1)]
    message = {"revision": 3, "poses": [float(number) for number in poses]}
    simulator.probe.publish("/telex/sim/poses", "telex_msgs/ScenePoses", message, rate=5)
    page.element("#tab-scene").click()
    wait_until(lambda: simulator.asked("list_objects"))
    yield simulator
    simulator.probe.publish("/telex/sim/poses", "telex_msgs/ScenePoses")


def note(page):
    return page.text("arrange-note")


def have_put(page):
    """Choose the tool that puts objects, once it is known which there are."""
    page.element('[data-tool="put"]').click()
    chosen = "return document.querySelector('#arrange-kinds :checked')?.value"
    wait_until(lambda: page.script(chosen) == "crate")


def test_objects_are_put_moved_and_taken_on_the_map_by_keys(scene, page):
    have_put(page)
    assert page.script("return document.querySelector('#arrange-kinds img').naturalWidth") == 1
    page.element("#arrange-kinds [value=crate]").press("ArrowRight")
    assert page.element("#arrange-kinds [value=cone]").get_property("checked")
    assert note(page) == "A traffic cone."
    turn = page.element("#arrange-turn")
    turn.set("90")
    plan = page.element("#plan")
    plan.press("ArrowRight", "ArrowUp")
    assert note(page).startswith("the cross is at ")
    plan.press("Enter")
    wait_until(lambda: note(page) == "spawned: cone_1")
    (asked,) = scene.asked("find_place")
    assert (asked["object"], asked["yaw"]) == ("{type: cone}", pytest.approx(math.pi / 2))
    assert asked["direction"] == {"x": 0, "y": 0, "z": -1}
    assert asked["origin"]["z"] == pytest.approx(2.1)
    (put,) = scene.asked("spawn")
    assert put["object"] == "{type: cone, position: [1.5000, -2.0000, 0.0010], yaw: 1.5708}"
    page.element('[data-tool="move"]').click()
    turn.set("")
    plan.press("Enter")
    wait_until(lambda: "box is picked" in note(page))
    plan.press("ArrowLeft", "Enter")
    wait_until(lambda: scene.asked("move"))
    assert scene.asked("move")[0]["name"] == "box"
    assert scene.asked("move")[0]["pose"]["position"] == PLACE["position"]
    page.element('[data-tool="take"]').click()
    plan.press("Enter")
    assert answer(page, "no") == "Take box out of the scene?"
    plan.press("ArrowLeft", "Enter")
    answer(page, "yes")
    wait_until(lambda: scene.asked("delete") == [{"name": "box"}])
    assert page.errors() == []


def test_a_robot_and_what_stands_fast_are_left_where_they_are(scene, page):
    page.element('[data-tool="move"]').click()
    plan = page.element("#plan")
    for found, said in (
        ({"met": "telex", "robot": True, "movable": False}, "telex is a robot"),
        ({"met": "wall", "movable": False}, "wall stands fast"),
        ({"success": False, "message": "there is nothing in that direction"}, "nothing in that"),
    ):
        scene.serve("find_place", "telex_msgs/FindPlace", **{**FOUND, **found})
        plan.press("ArrowLeft", "Enter")
        wait_until(lambda said=said: said in note(page))
    assert scene.asked("move") == []


def test_a_drag_in_the_overview_moves_by_the_cameras_calibration(scene, page):
    camera = {"width": 960, "height": 540, "K": [800, 0, 480, 0, 800, 270, 0, 0, 1]}
    pose = {"pose": {"position": {"z": 3.0}, "orientation": {"x": 1.0, "w": 0.0}}}  # looks down
    topic = "/telex/cameras/overview"
    scene.probe.publish(f"{topic}/camera_info", "sensor_msgs/CameraInfo", camera, rate=10)
    scene.probe.publish(f"{topic}/pose", "geometry_msgs/PoseStamped", pose, rate=10)
    scene.serve("find_place", "telex_msgs/FindPlace", held=True, **FOUND)
    page.element('[data-tool="move"]').click()

    # Until the page knows the camera a drag does nothing, and once it has asked, as little.
    def is_picked():
        page.element("#picture").drag(80, 0)
        return scene.asked("find_place")

    wait_until(is_picked)
    scene.release("find_place")
    wait_until(lambda: scene.asked("move"))
    pick, place = scene.asked("find_place")
    assert (pick["object"], place["object"]) == ("", "box")
    assert pick["origin"] == {"x": 0, "y": 0, "z": 3}
    right = place["direction"]["x"] / -place["direction"]["z"]
    width = page.script("return document.getElementById('picture').getBoundingClientRect().width")
    assert right == pytest.approx(80 / width * 960 / 800, rel=0.03)
    assert scene.probe.heard[VIEW] == [], "the camera stays where it is"
    for name, kind in (
        ("camera_info", "sensor_msgs/CameraInfo"),
        ("pose", "geometry_msgs/PoseStamped"),
    ):
        scene.probe.publish(f"{topic}/{name}", kind)


def test_in_an_exam_it_is_said_first_that_it_becomes_invalid(scene, page):
    kind = "telex_msgs/TrainingState"
    state = {"phase": "running", "mode": "exam", "operator": "Ann", "valid": True}
    scene.probe.publish("/telex/training/state", kind, state, latch=True)
    wait_until(lambda: page.text("training-title").endswith("EXAM"))
    have_put(page)
    page.element("#plan").press("ArrowLeft", "Enter")
    assert answer(page, "no") == "Put crate there? The exam of Ann is invalid then."
    assert scene.asked("spawn") == []
    scene.probe.publish("/telex/training/state", kind, {"phase": "idle"}, latch=True)


def test_it_becomes_night_and_lamps_are_lit(scene, page):
    scene.serve("set_light", "telex_msgs/SetLight", success=True, message="night")
    page.element("[data-daylight='0.02']").click()
    wait_until(lambda: scene.asked("set_light") == [{"daylight": 0.02, "lamps": 1}])
    wait_until(
        lambda: page.element("[data-daylight='0.02']").get_attribute("aria-checked") == "true"
    )
    lamp = "/telex/lamps/front_left/command"
    scene.probe.subscribe(lamp, "std_msgs/Float64")
    page.element("[data-lamps='lamps:front']").click()
    wait_until(lambda: [told for _, told in scene.probe.heard[lamp]] == [{"data": 1.0}])


def test_what_the_trainee_sees_and_holds_and_what_is_said_to_him(simulator, page):
    seen = {"view": "turret", "picture_age": 0.21, "held": ["drive:forward", "another's"]}
    told = {"data": json.dumps(seen)}
    simulator.probe.publish("/telex/console/telemetry", "std_msgs/String", told, rate=5)
    wait_until(lambda: page.text("trainee-view") == "turret · picture 0.2 s old")
    assert page.text("trainee-keys") == "W drive ahead, another's"
    simulator.probe.publish("/telex/console/telemetry", "std_msgs/String", {"data": "["}, rate=5)
    wait_until(lambda: page.text("trainee-view") == NOTHING)
    service = "/telex/training/tell"
    kind, text = "telex_msgs/TellTrainee", "<b>Stop</b>"
    answer_ = {"success": True, "number": 1}
    simulator.probe.do("serve", service=service, type=kind, response=answer_)
    page.element("#trainee-words").type(f"{text}\n")
    wait_until(lambda: simulator.probe.requests_of(service) == [{"text": text, "by": "instructor"}])
    for read, said in ((False, f"not read yet: {text}"), (True, f"✔ read: {text}")):
        shown = {"number": 1, "text": text, "by": "Bob", "read": read}
        topic, kind = "/telex/training/text", "telex_msgs/TrainingText"
        simulator.probe.publish(topic, kind, shown, latch=True)
        wait_until(lambda said=said: page.text("trainee-note") == said)


def test_a_lost_bridge_is_said(ros, simulator, page):
    page.element("#tab-scene").click()
    simulator.serve("load_scene", "telex_msgs/LoadScene", delay=5.0, **LOADED)
    page.element('[data-scene="yard"] button').click()
    answer(page, "yes")
    wait_until(lambda: page.element("#scene-progress").is_displayed())
    ros.stop(ros.bridge)
    try:
        wait_until(lambda: page.text("scene-note") == "the connection was lost")
        assert not page.element("#scene-progress").is_displayed()
        wait_until(lambda: "Connection lost" in page.text("link-band"))
        assert page.element("#link-band").is_displayed()
        assert page.text("sim-state") == "NO STATUS"
    finally:
        ros.bridge, _ = ros.serve("rosbridge")
