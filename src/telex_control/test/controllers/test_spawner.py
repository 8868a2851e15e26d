"""Which controllers the spawner starts on a robot that lacks some joints."""

from __future__ import annotations

import math
import threading
import time
from types import SimpleNamespace

import pytest
import rospy
from waiting import wait_until

from telex_control.command_lines import last_calls
from telex_control.command_lines.spawner import Spawner, SpawnerError, parse, read_file
from telex_control.common.yaml_files import load_yaml
from telex_control.manager.controller_joints import controller_joints, without_joints

PARAMETERS = {
    "arm/states": {"type": "joint_state_controller/JointStateController"},
    "arm/elbow": {"type": "effort_controllers/JointPositionController", "joint": "elbow_joint"},
    "arm/slide": {"type": "effort_controllers/JointPositionController", "joint": "slide_joint"},
    "arm/tracks": {"left_wheel": ["left_joint"], "right_wheel": "right_joint"},
}


def robot(*joints):
    drives = "".join(
        f'<joint name="{name}" type="continuous"/><transmission name="{name}">'
        f'<type>transmission_interface/SimpleTransmission</type><joint name="{name}">'
        "<hardwareInterface>hardware_interface/EffortJointInterface</hardwareInterface></joint>"
        f'<actuator name="{name}_motor"><mechanicalReduction>1</mechanicalReduction></actuator>'
        "</transmission>"
        for name in joints
    )
    return f'<robot name="r">{drives}</robot>'


@pytest.fixture
def spawner(monkeypatch):
    said = []

    def make(*joints, **more):
        parameters = {**PARAMETERS, "arm/robot_description": robot(*joints), **more}
        monkeypatch.setattr(rospy, "get_param", lambda name, default: parameters.get(name, default))
        monkeypatch.setattr(rospy, "loginfo", lambda text, *args: said.append(text % args))
        made = Spawner("arm")
        made.said = said
        return made

    return make


def test_the_command_line():
    options = parse(["--timeout", "60", "states", "elbow", "--optional", "slide", "tracks"])
    assert (options.controllers, options.optional) == (["states", "elbow"], ["slide", "tracks"])
    assert parse(["states"]).optional == []
    assert parse(["states", "--optional-stopped", "arm"]).optional_stopped == ["arm"]


def test_a_controller_whose_joints_are_there_is_started(spawner):
    tested = spawner("elbow_joint", "slide_joint", "left_joint", "right_joint")
    names = tested.present(["states", "elbow"], ["slide", "tracks"])
    assert names == ["states", "elbow", "slide", "tracks"]
    assert tested.said == []


def test_one_whose_joints_are_not_there_is_left_out_with_a_word(spawner):
    tested = spawner("elbow_joint")
    assert tested.present(["states", "elbow"], ["slide", "tracks"]) == ["states", "elbow"]
    assert tested.said == [
        "Left out: slide, for this robot has no slide_joint",
        "Left out: tracks, for this robot has no left_joint, right_joint",
    ]


def test_one_with_some_of_its_joints_is_kept_and_fails_by_itself(spawner):
    tested = spawner("elbow_joint", "left_joint")
    assert tested.present(["elbow"], ["tracks"]) == ["elbow", "tracks"]


def test_one_for_many_joints_does_without_those_that_are_gone(spawner, monkeypatch):
    written = {}
    monkeypatch.setattr(rospy, "set_param", written.__setitem__)
    gains = {"elbow_joint": {"p": 1.0}, "slide_joint": {"p": 2.0}}
    params = {"type": "x/Arm", "joints": ["elbow_joint", "slide_joint"], "gains": gains}
    tested = spawner("elbow_joint", **{"arm/both": params})
    assert tested.present(["elbow"], ["slide", "both"]) == ["elbow", "both"]
    assert written == {
        "arm/both": {
            "type": "x/Arm",
            "joints": ["elbow_joint"],
            "gains": {"elbow_joint": {"p": 1.0}},
        }
    }
    assert tested.said[-1] == "both does without slide_joint"


def test_a_misspelt_joint_among_many_stays_a_mistake(spawner):
    params = {"joints": ["elbow_joint", "silde_joint"]}
    tested = spawner("elbow_joint", "slide_joint", **{"arm/both": params})
    # The controller itself refuses it: nothing else says that the joint may be missing.
    assert tested.present(["elbow"], ["slide", "both"]) == ["elbow", "slide", "both"]


def test_what_is_optional_and_stopped_is_not_started(spawner, monkeypatch):
    tested = spawner("elbow_joint")
    switched = []

    class Client:
        def load(self, name):
            return True

        def switch(self, start, stop):
            switched.append((start, stop))
            return True

    monkeypatch.setattr(tested, "_client", Client())
    tested.load(["states", "elbow", "slide"])
    tested.start(but=["slide"])
    assert switched == [(["states", "elbow"], [])]


def test_a_misspelt_joint_leaves_the_robots_own_without_controller(spawner):
    wrong = {"arm/slide": {"joint": "silde_joint"}}
    with pytest.raises(SpawnerError, match=r"slide is for silde_joint.* for its slide_joint"):
        spawner("elbow_joint", "slide_joint", **wrong).present(["elbow"], ["slide"])


def test_a_misspelt_controller_is_refused(spawner):
    with pytest.raises(SpawnerError, match="--optional silde: its parameters name no joint"):
        spawner("elbow_joint", "slide_joint").present(["elbow"], ["silde"])


def test_optional_controllers_need_a_robot(spawner):
    without = {"arm/robot_description": None}
    with pytest.raises(SpawnerError, match="arm/robot_description, which is not set"):
        spawner(**without).present(["elbow"], ["slide"])
    with pytest.raises(SpawnerError, match="robot_description is no XML"):
        spawner(**{"arm/robot_description": "<"}).present(["elbow"], ["slide"])
    assert spawner(**without).present(["elbow"], []) == ["elbow"]


@pytest.mark.parametrize(
    ("params", "joints"),
    [
        ({}, []),
        (None, []),
        ("text", []),
        ({"joint": "a"}, ["a"]),
        ({"joints": ["a", "b"]}, ["a", "b"]),
        ({"left_wheel": "a", "right_wheel": ["b", "c"]}, ["a", "b", "c"]),
        ({"left_joints": ["a"], "right_joints": ["b", "c"]}, ["a", "b", "c"]),
        ({"joint": 3, "joints": [4, "a"]}, ["a"]),
    ],
)
def test_joints_of_a_controller(params, joints):
    assert controller_joints(params) == joints


def test_a_list_of_anything_loses_the_joints_that_are_gone():
    params = {"joints": ["a", "b"], "rests": [["a"], {"a": 1}, "a", 2]}
    assert without_joints(params, {"a"}) == {"joints": ["b"], "rests": [["a"], {"a": 1}, 2]}


class SlowManager:
    """A manager whose answer to a load waits for `answer`."""

    prefix = "controller_manager"

    def __init__(self):
        self.asked, self.answer = threading.Event(), threading.Event()
        self.loaded, self.unloaded = [], []

    def load(self, name):
        self.asked.set()
        assert self.answer.wait(5.0)
        self.loaded.append(name)
        return True

    def list_controllers(self):
        return [SimpleNamespace(name=name, state="initialized") for name in self.loaded]

    def unload(self, name):
        self.unloaded.append(name)
        return True


def test_what_is_being_loaded_when_the_spawner_ends_is_unloaded(spawner, monkeypatch):
    monkeypatch.setattr(last_calls, "STALL", 30.0)
    ended = spawner()
    ended._client = manager = SlowManager()
    loading = threading.Thread(target=ended.load, args=(["elbow", "slide"],), daemon=True)
    loading.start()
    assert manager.asked.wait(5.0)
    stopping = threading.Thread(target=ended.stop, daemon=True)
    stopping.start()
    wait_until(lambda: ended._ending)
    manager.answer.set()
    for each in (loading, stopping):
        each.join(5.0)
        assert not each.is_alive()
    assert manager.loaded == manager.unloaded == ["elbow"]


def test_another_manager_is_one_at_another_address(spawner, monkeypatch):
    tested = spawner("elbow_joint")
    seen = iter(["rosrpc://a:1", None, "rosrpc://a:1", "rosrpc://a:2"])
    monkeypatch.setattr(tested, "manager_address", lambda: next(seen))
    monkeypatch.setattr("telex_control.command_lines.spawner._WATCH_PERIOD", 0.0)
    monkeypatch.setattr(rospy, "is_shutdown", lambda: False)
    assert tested.wait_for_another_manager("rosrpc://a:1")
    assert list(seen) == []
    monkeypatch.setattr(rospy, "is_shutdown", lambda: True)
    assert not tested.wait_for_another_manager("rosrpc://a:2")


class ListingManager:
    """A manager that gives one list after the other, the last of them again and again."""

    prefix = "controller_manager"

    def __init__(self, *lists):
        self.lists, self.asked = lists, 0

    def list_controllers(self):
        listed = self.lists[min(self.asked, len(self.lists) - 1)]
        self.asked += 1
        if isinstance(listed, Exception):
            raise listed
        return [SimpleNamespace(name=name, state="running") for name in listed]


@pytest.fixture
def watching(spawner, monkeypatch):
    """Watch a manager whose address stays the same until it was asked for its list often enough."""
    monkeypatch.setattr("telex_control.command_lines.spawner._WATCH_PERIOD", 0.001)
    monkeypatch.setattr("telex_control.command_lines.spawner._LIST_PERIOD", 0.0)
    monkeypatch.setattr(rospy, "logwarn", lambda text, *args: None)

    def watch(manager, address="rosrpc://a:1", patience=5.0):
        tested = spawner()
        tested._client, tested._loaded = manager, ["states", "elbow"]
        end = time.monotonic() + patience
        monkeypatch.setattr(
            rospy, "is_shutdown", lambda: manager.asked >= 6 or time.monotonic() > end
        )
        monkeypatch.setattr(tested, "manager_address", lambda: address)
        return tested.wait_for_another_manager("rosrpc://a:1")

    return watch


@pytest.mark.parametrize("lists", [([],), (["states"], ["foreign"])])
def test_a_manager_that_has_none_of_ours_any_more_is_another_one(watching, lists):
    assert watching(ListingManager(*lists))


@pytest.mark.parametrize(
    "lists",
    [
        (["elbow", "foreign"],),
        # Libraries are being reloaded, and all is loaded again.
        (["elbow"], [], ["states", "elbow"]),
        (rospy.ServiceException("it has gone"),),
        (rospy.ROSInterruptException("shut down"),),
    ],
)
def test_one_that_has_some_of_ours_or_does_not_answer_is_the_same(watching, lists):
    manager = ListingManager(*lists)
    assert not watching(manager)
    assert manager.asked >= 6


def test_without_an_address_nobody_is_asked(watching):
    manager = ListingManager([])
    assert not watching(manager, address=None, patience=0.1)
    assert manager.asked == 0


def test_another_manager_is_seen_while_the_former_one_does_not_answer(spawner, monkeypatch):
    monkeypatch.setattr("telex_control.command_lines.spawner._WATCH_PERIOD", 0.001)
    monkeypatch.setattr("telex_control.command_lines.spawner._LIST_PERIOD", 0.0)
    asked, end = threading.Event(), threading.Event()

    class Hanging:
        prefix = "controller_manager"

        def list_controllers(self):
            asked.set()
            assert end.wait(30.0)
            return []

    tested = spawner()
    tested._client, tested._loaded = Hanging(), ["elbow"]
    monkeypatch.setattr(
        tested, "manager_address", lambda: "rosrpc://a:2" if asked.is_set() else "rosrpc://a:1"
    )
    give_up = time.monotonic() + 5.0
    monkeypatch.setattr(rospy, "is_shutdown", lambda: time.monotonic() > give_up)
    monkeypatch.setattr(rospy, "logwarn", lambda text, *args: None)
    try:
        assert tested.wait_for_another_manager("rosrpc://a:1")
        assert asked.is_set()
    finally:
        end.set()


def test_what_another_manager_has_of_ours_is_unloaded_before_it_is_loaded_anew(
    spawner, monkeypatch
):
    tested = spawner("elbow_joint")
    asked = []

    class Client:
        def load(self, name):
            asked.append(("load", name))
            return True

        def unload(self, name):
            asked.append(("unload", name))
            return True

        def switch(self, start, stop):
            asked.append(("switch", start, stop))
            return True

        def list_controllers(self):
            return [
                SimpleNamespace(name="elbow", state="running"),
                SimpleNamespace(name="states", state="initialized"),
                SimpleNamespace(name="foreign", state="running"),
            ]

    monkeypatch.setattr(tested, "_client", Client())
    tested.load(["states", "elbow", "slide"])
    del asked[:]
    tested.clear()
    assert asked == [("switch", [], ["elbow"]), ("unload", "elbow"), ("unload", "states")]
    del asked[:]
    assert tested.load(["states"]) == ["states"]


# ---- a file with alternatives, and one with a namespace


def listed(name, *claims, state="initialized"):
    resources = [SimpleNamespace(resources=list(joints)) for joints in claims]
    return SimpleNamespace(name=name, state=state, claimed_resources=resources)


@pytest.mark.parametrize(
    ("only", "settled", "started"),
    [
        (None, [], ["states", "arm", "elbow", "twice", "hand"]),
        ([], [], ["states", "arm", "hand"]),
        (["elbow", "states"], [], ["states", "elbow"]),
        ([], ["elbow"], ["states", "hand"]),
    ],
)
def test_of_alternatives_the_first_is_started(spawner, monkeypatch, only, settled, started):
    tested = spawner()
    warned, switched = [], []
    claims = {
        "states": [],
        "arm": [["shoulder_joint", "elbow_joint"]],
        "elbow": [["elbow_joint"]],
        "twice": [["wrist_joint"], ["wrist_joint"]],
        "hand": [["finger_joint"]],
    }
    states = {name: "running" if name in settled else "initialized" for name in claims}

    class Client:
        def load(self, name):
            return True

        def list_controllers(self):
            return [listed(name, *claims[name], state=states[name]) for name in claims]

        def switch(self, start, stop):
            switched.append(start)
            return True

    monkeypatch.setattr(tested, "_client", Client())
    monkeypatch.setattr(rospy, "logwarn", lambda text, *args: warned.append(text % args))
    tested.load(claims)
    tested.start(settled, only)
    assert switched == [started]
    stopped = [name for name in claims if name not in [*started, *settled]]
    assert len(warned) == (len(stopped) if only == [] else 0)
    if only == []:
        assert all(f"stopped: {name}, for" in text for name, text in zip(stopped, warned))
        assert any("it takes a joint through two interfaces" in text for text in warned)


def test_the_command_line_of_start():
    assert parse(["a.yaml"]).start is None
    assert parse(["a.yaml", "--start"]).start == []
    assert parse(["a.yaml", "--start", "arm", "hand"]).start == ["arm", "hand"]


STATES = "states: {type: joint_state_controller/JointStateController}"


@pytest.mark.parametrize(
    ("text", "names"),
    [
        (STATES, ["states"]),
        (f"rrbot: {{{STATES}}}", ["states"]),
        (
            f"/rrbot: {{lower: {{{STATES}, rate: 3}}}}\nlimits: {{a: 1}}",
            ["limits", "states", "rate"],
        ),
        (f"left: {{{STATES}}}\n/arm: {{{STATES}, mine: 1}}", ["left", "states", "mine"]),
    ],
)
def test_a_namespace_in_the_file_is_the_robots(tmp_path, text, names):
    file = tmp_path / "controllers.yaml"
    file.write_text(text)
    params = read_file(str(file), "/lab/arm")
    assert list(params) == names
    assert params["states"] == {"type": "joint_state_controller/JointStateController"}


def test_angles_in_degrees_are_read_as_roslaunch_does(tmp_path):
    file = tmp_path / "arm.yaml"
    file.write_text("arm: {type: a/B, rest: [!degrees 180, !radians pi/2, deg(90), rad(pi)]}")
    assert read_file(str(file))["arm"]["rest"] == pytest.approx(
        [math.pi, math.pi / 2, math.pi / 2, math.pi]
    )


@pytest.mark.parametrize(
    "bad", ["!degrees x", "!radians x", "!metres 1", "[", "[" * 4000, "&a [*a]"]
)
def test_a_file_that_cannot_be_read_is_named(tmp_path, bad):
    file = tmp_path / "arm.yaml"
    file.write_text(f"arm: {{type: a/B, rest: {bad}}}")
    with pytest.raises(SpawnerError, match=f"^{file}: "):
        read_file(str(file))


@pytest.mark.parametrize(
    ("bad", "named"),
    [
        ("joint:", "arm/joint is None; text, a number, a list or a struct is needed"),
        ("since: 2024-01-31", r"arm/since is datetime.date\(2024, 1, 31\); text, a number"),
        ("rests: [1, [2, ~]]", r"arm/rests\[1\]\[1\] is None; text"),
        ("gains: {1: 2.0}", "a key of arm/gains is 1; text is needed"),
        ("gains: {'': 2.0}", "a key of arm/gains is ''; text is needed"),
        ("gains: {p: 2147483648}", "arm/gains/p is 2147483648; a whole number of 32 bits"),
        ("low: -2147483649", "arm/low is -2147483649; a whole number of 32 bits"),
    ],
)
def test_what_the_parameter_server_does_not_take_is_named(tmp_path, bad, named):
    file = tmp_path / "arm.yaml"
    file.write_text(f"arm:\n  type: a/B\n  {bad}\n")
    with pytest.raises(SpawnerError, match=f"^{file}: {named}"):
        read_file(str(file))


def test_what_the_parameter_server_takes_is_read(tmp_path):
    file = tmp_path / "arm.yaml"
    file.write_text(
        "arm: {type: a/B, low: -2147483648, high: 2147483647, loud: true, x: [], y: {}, z: .inf}"
    )
    arm = read_file(str(file))["arm"]
    assert (arm["low"], arm["high"], arm["z"]) == (-(2**31), 2**31 - 1, math.inf)


def test_a_file_with_an_anchor_may_be_large_but_holds_nothing_of_itself(tmp_path):
    file = tmp_path / "arm.yaml"
    levels = "".join(f"l{n}: &l{n} [*l{n - 1}, *l{n - 1}]\n" for n in range(1, 60))
    file.write_text("l0: &l0 [1]\n" + levels)
    with file.open() as text:
        assert load_yaml(text)["l1"] == [[1], [1]]
    file.write_text("top: &top\n  type: a/B\n  more: [{gains: *top}]\n")
    with pytest.raises(SpawnerError, match=f"^{file}: 'gains' is an alias .* cannot hold itself"):
        read_file(str(file))


def test_of_several_namespaces_one_has_to_be_the_robots(tmp_path):
    file = tmp_path / "controllers.yaml"
    file.write_text(f"left: {{{STATES}}}\nright: {{{STATES}}}")
    with pytest.raises(SpawnerError, match="namespaces left, right; one .* as the robot's, /arm"):
        read_file(str(file), "/arm")
