"""Step responses: figures against closed forms, the order of a measurement, what is written."""

from __future__ import annotations

import contextlib
import csv
import json
import math
from pathlib import Path

import numpy as np
import pytest
import rospkg
import yaml

from telex_control.common.params import ConfigError
from telex_control.manager.client import STRICT
from telex_control.step_response import command_line, report, ros_session, table
from telex_control.step_response.analysis import StepRecording, StepRecordingError, analyse
from telex_control.step_response.plan import CURRENT, Plan
from telex_control.step_response.ros_session import RosRig
from telex_control.step_response.runner import Runner, StepError, fitted_step
from telex_control.urdf.joints import UrdfJoint

CONFIG = Path(rospkg.RosPack().get_path("telex_control")) / "config"


def joint(name="a_joint", kind="revolute", lower=-1.0, upper=1.0):
    return UrdfJoint(name, kind, lower, upper, 1.0, 50.0, 0.0, 0.0, None)


def second_order(damping, frequency=10.0, start=0.2, step=0.3, seconds=4.0, rate=1000.0):
    """The step response of w^2 / (s^2 + 2 D w s + w^2), below or at critical damping."""
    times = np.arange(-0.1, seconds, 1.0 / rate)
    after = np.maximum(times, 0.0)
    decay = np.exp(-damping * frequency * after)
    if damping < 1.0:
        root = math.sqrt(1.0 - damping**2)
        turn = frequency * root * after
        response = 1.0 - decay * (np.cos(turn) + damping / root * np.sin(turn))
    else:
        response = 1.0 - decay * (1.0 + frequency * after)
    efforts = np.where(times < 0.0, 100.0, -7.0 * decay)
    return StepRecording(times, start + step * response, efforts, start, start + step)


# --- analysis -----------------------------------------------------------------------------------


@pytest.mark.parametrize("damping", [0.2, 0.5, 0.7, 0.9])
@pytest.mark.parametrize("step", [0.3, -0.05])
def test_overshoot_is_that_of_the_closed_form(damping, step):
    figures = analyse(second_order(damping, step=step))
    expected = 100.0 * math.exp(-math.pi * damping / math.sqrt(1.0 - damping**2))
    assert figures.overshoot == pytest.approx(expected, abs=0.01)


def test_critical_damping_has_the_times_of_the_closed_form():
    # (1 + x) exp(-x) falls to 0.9, 0.1 and 0.02 at these x = w t.
    figures = analyse(second_order(1.0, frequency=10.0))
    assert figures.rise_time == pytest.approx((3.889720 - 0.531812) / 10.0, abs=1e-5)
    assert figures.settling_time == pytest.approx(5.833922 / 10.0, abs=1e-5)
    assert figures.overshoot == 0.0


def test_settling_counts_the_last_time_outside_of_the_band():
    figures = analyse(second_order(0.2, frequency=10.0, seconds=8.0))
    # The envelope passes 2 % at 1.97 s; the response leaves the band for the last time before.
    envelope = -math.log(0.02 * math.sqrt(1.0 - 0.2**2)) / (0.2 * 10.0)
    assert envelope - math.pi / (10.0 * math.sqrt(1.0 - 0.2**2)) < figures.settling_time < envelope


def test_coarse_samples_give_nearly_the_same():
    fine, coarse = analyse(second_order(0.7)), analyse(second_order(0.7, rate=100.0))
    assert coarse.rise_time == pytest.approx(fine.rise_time, abs=2e-3)
    assert coarse.settling_time == pytest.approx(fine.settling_time, abs=4e-3)
    assert coarse.overshoot == pytest.approx(fine.overshoot, abs=0.15)


def test_error_and_effort():
    recording = second_order(1.0)
    short = StepRecording(
        recording.times, recording.positions - 0.01, recording.efforts, 0.2, recording.target
    )
    figures = analyse(short)
    assert figures.steady_state_error == pytest.approx(0.01, abs=1e-9)
    assert math.isnan(figures.settling_time)
    # What was applied before the step does not count.
    assert figures.peak_effort == pytest.approx(7.0)


def test_a_joint_that_stays_where_it_is_has_no_rise():
    times = np.linspace(-0.1, 2.0, 211)
    figures = analyse(StepRecording(times, np.zeros(211), np.zeros(211), 0.0, 0.1))
    assert math.isnan(figures.rise_time)
    assert figures.overshoot == 0.0
    assert figures.steady_state_error == pytest.approx(0.1)


def test_oscillation_is_told_from_slow_settling():
    recording = second_order(1.0)
    creeping = recording.positions + 0.001 * recording.times
    swinging = creeping + 0.002 * np.sin(40.0 * recording.times)
    still, moving = (
        analyse(StepRecording(recording.times, each, recording.efforts, 0.2, recording.target))
        for each in (creeping, swinging)
    )
    assert still.oscillation < 1e-9
    assert moving.oscillation == pytest.approx(0.002, rel=0.15)


@pytest.mark.parametrize(
    ("times", "positions", "target", "named"),
    [
        ([0.0, 1.0], [0.0], 1.0, "2 times, 1 positions"),
        ([0.0, 1.0], [0.0, 0.0], 0.0, "no step"),
        ([-1.0, 0.2], [0.0, 0.0], 1.0, r"1 samples up to 0\.200 s"),
        ([], [], 1.0, "0 samples"),
    ],
)
def test_a_recording_that_says_nothing_is_refused(times, positions, target, named):
    with pytest.raises(StepRecordingError, match=named):
        StepRecording(np.array(times), np.array(positions), np.zeros(len(times)), 0.0, target)


# --- plan ---------------------------------------------------------------------------------------

POSES = {"home": {"a_joint": 0.5, "b_joint": 0.0}, "way": {"a_joint": 0.1}}


def config(**more):
    return {
        "groups": {"one": ["a_joint"], "two": ["b_joint", "c_joint"]},
        "via": "way",
        "postures": {
            "up": {
                "pose": "home",
                "positions": {"b_joint": 0.2},
                "steps": {"a_joint": 0.3, "b_joint": -0.1},
            }
        },
        "rest_time": 0.2,
        "record_time": 1.0,
        **more,
    }


def test_the_plan_knows_postures_and_groups():
    plan = Plan(config(), POSES)
    assert plan.positions("up") == {"a_joint": 0.5, "b_joint": 0.2}
    assert plan.select([]) == ["a_joint", "b_joint", "c_joint"]
    assert plan.select(["c_joint", "two", "x"]) == ["c_joint", "b_joint", "x"]
    assert plan.group("c_joint") == "two"
    assert plan.step(CURRENT, "b_joint") == -0.1
    with pytest.raises(ConfigError, match="postures/up/steps has no 'c_joint'"):
        plan.step("up", "c_joint")


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"via": "nowhere"}, "via is 'nowhere'; there are: home, way"),
        ({"postures": {}}, "postures is empty"),
        ({"speed": 1.5}, "speed is 1.5"),
        ({"postures": {"up": {"pose": "x", "steps": {}}}}, "postures/up/pose is 'x'"),
        ({"postures": {"up": {"pose": "way", "steps": {"a": 0}}}}, "steps/a is 0"),
        ({"postures": {"current": {"pose": "way", "steps": {}}}}, "postures/current"),
        ({"other": 1}, "other is unknown"),
    ],
)
def test_a_wrong_plan_is_refused(change, named):
    with pytest.raises(ConfigError, match=named):
        Plan(config(**change), POSES)


def test_the_shipped_plan_fits_the_shipped_controllers():
    plan = command_line.read_plan(command_line.default_plan())
    controllers = yaml.safe_load((CONFIG / "telex_controllers.yaml").read_text())
    driven = {each["joint"] for each in controllers.values() if "joint" in each}
    joints = plan.select([])
    assert {name for name in driven if "camera" not in name} == set(joints)
    assert len(joints) == 17
    for posture in plan.postures():
        for name in joints:
            assert name in plan.positions(posture)
            assert 0.04 < abs(plan.step(posture, name)) < 0.27


# --- runner -------------------------------------------------------------------------------------


class FakeRig:
    """Joints that are where they are commanded; `stuck` ones stay."""

    def __init__(self, **positions):
        self.references = dict(positions)
        self.stuck = {}
        self.commands = []
        self.log = []

    def position(self, name):
        return self.stuck.get(name, self.references[name])

    def reference(self, name):
        return self.references[name]

    def command(self, name, position):
        self.commands.append((name, position))
        self.references[name] = position

    def wait(self, seconds):
        assert seconds >= 0.0

    def record(self, name, target, seconds):
        start = self.references[name]
        self.log.append((name, round(start, 6), round(target, 6), seconds))
        self.references[name] = target
        return second_order(1.0, start=start, step=target - start)

    @contextlib.contextmanager
    def raw(self, name):
        self.log.append("raw")
        yield
        self.log.append("as before")


@pytest.fixture
def joints():
    return {name: joint(name) for name in ("a_joint", "b_joint")}


def test_joints_are_stepped_in_the_posture_and_brought_back(joints):
    rig = FakeRig(a_joint=-0.4, b_joint=0.05)
    runner = Runner(rig, Plan(config(), POSES), joints)
    results = list(runner.run(["up"], ["a_joint", "b_joint"]))
    assert rig.log == [
        ("a_joint", 0.5, 0.8, 1.0),
        "raw",
        ("a_joint", 0.5, 0.8, 1.0),
        "as before",
        ("b_joint", 0.2, 0.1, 1.0),
        "raw",
        ("b_joint", 0.2, 0.1, 1.0),
        "as before",
    ]
    assert [(each.joint.name, each.raw) for each in results] == [
        ("a_joint", False),
        ("a_joint", True),
        ("b_joint", False),
        ("b_joint", True),
    ]
    assert rig.references == pytest.approx({"a_joint": -0.4, "b_joint": 0.05})


def test_the_present_posture_is_not_left(joints):
    rig = FakeRig(a_joint=0.9, b_joint=0.0)
    runner = Runner(rig, Plan(config(), POSES), joints)
    list(runner.run([CURRENT], ["a_joint"], kinds=(False,), size=10.0))
    # Upwards there is no room; and the size is in degrees.
    assert rig.log == [("a_joint", 0.9, round(0.9 - math.radians(10.0), 6), 1.0)]
    assert {name for name, _ in rig.commands} == {"a_joint"}


def test_moves_are_smooth_and_not_too_fast(joints):
    rig = FakeRig(a_joint=0.0, b_joint=0.0)
    Runner(rig, Plan(config(speed=0.5), POSES), joints).move({"a_joint": 0.6, "x_joint": 1.0})
    way = np.array([0.0, *(position for name, position in rig.commands if name == "a_joint")])
    speed = np.diff(way) / 0.02
    assert way[-1] == pytest.approx(0.6)
    assert speed.min() >= 0.0
    assert 0.45 < speed.max() <= 0.5 + 1e-9
    assert speed[0] < 0.01
    assert speed[-1] < 0.01


def test_a_joint_that_is_held_ends_the_measurement(joints):
    rig = FakeRig(a_joint=0.0, b_joint=0.0)
    rig.stuck["a_joint"] = 0.2
    with pytest.raises(StepError, match=r"a_joint is 0\.300 short of 0\.500 after a move"):
        list(Runner(rig, Plan(config(), POSES), joints).run(["up"], ["b_joint"]))


def test_a_step_without_room_is_refused():
    assert fitted_step(joint(), 0.5, 0.4) == 0.4
    assert fitted_step(joint(), 0.9, 0.4) == -0.4
    with pytest.raises(StepError, match="leaves its limits, -1.000 to 1.000, both ways"):
        fitted_step(joint(), 0.0, 1.2)


def test_a_joint_without_a_step_is_refused_before_anything_moves(joints):
    rig = FakeRig(a_joint=0.0, b_joint=0.0)
    runner = Runner(rig, Plan(config(), POSES), {**joints, "c_joint": joint("c_joint")})
    with pytest.raises(ConfigError, match="postures/up/steps has no 'c_joint'"):
        list(runner.run(["up"], ["a_joint", "c_joint"]))
    assert rig.commands == []


# --- raw steps over ROS -------------------------------------------------------------------------


class FakeManager:
    """One controller; `refused` says which calls fail."""

    def __init__(self):
        self.running = self.loaded = True
        self.refused = set()
        self.params = {"/r/c": {"joint": "j", "command_limits": True}}
        self.used = dict(self.params["/r/c"])

    def switch(self, start, stop, strictness=STRICT):
        if "stop" in self.refused and stop:
            return False
        if strictness == STRICT and self.running is not bool(stop):
            return False
        self.running = self.loaded and (self.running or bool(start)) and not stop
        return self.loaded

    def unload(self, name):
        done, self.loaded = self.loaded and not self.running, self.running
        return done

    def load(self, name):
        if "load" in self.refused or self.loaded:
            return False
        self.loaded, self.used = True, dict(self.params["/r/c"])
        return True


@pytest.fixture
def raw_rig(monkeypatch):
    rig = RosRig.__new__(RosRig)
    rig._namespace, rig._controllers, rig._states = "/r", {"j": "c"}, {}
    rig._manager = manager = FakeManager()
    rig._await_controller = lambda name: None
    monkeypatch.setattr(ros_session.rospy, "get_param", manager.params.get)
    monkeypatch.setattr(ros_session.rospy, "set_param", manager.params.__setitem__)
    return rig


def assert_as_before(manager):
    shaped = {"joint": "j", "command_limits": True}
    assert (manager.params["/r/c"], manager.used, manager.running) == (shaped, shaped, True)


def test_a_raw_step_leaves_the_controller_as_it_was(raw_rig):
    with raw_rig.raw("j"):
        assert raw_rig._manager.used == {"joint": "j"}
        assert raw_rig._manager.running
    assert_as_before(raw_rig._manager)


@pytest.mark.parametrize("ended", [StepError("the emergency stop is pressed"), KeyboardInterrupt()])
def test_a_raw_step_that_breaks_off_leaves_the_controller_as_it_was(raw_rig, ended):
    waited = []

    def wait(name):
        waited.append(name)
        if len(waited) == 1 or isinstance(ended, StepError):
            raise ended if len(waited) == 1 else StepError("another reason")

    raw_rig._await_controller = wait
    with pytest.raises(type(ended)) as raised, raw_rig.raw("j"):
        raise AssertionError("it was not loaded")
    assert raised.value is ended
    assert_as_before(raw_rig._manager)


@pytest.mark.parametrize("call", ["stop", "load"])
def test_a_controller_that_cannot_be_made_raw_gets_its_parameters_back(raw_rig, call):
    manager = raw_rig._manager
    manager.refused.add(call)
    with pytest.raises(StepError, match="c cannot be loaded anew"), raw_rig.raw("j"):
        raise AssertionError("it was not loaded")
    assert manager.params["/r/c"] == {"joint": "j", "command_limits": True}


def test_a_controller_that_was_stopped_or_unloaded_meanwhile_is_loaded_as_it_was(raw_rig):
    manager = raw_rig._manager
    for loaded in (True, False):
        with raw_rig.raw("j"):
            manager.running, manager.loaded = False, loaded
        assert_as_before(manager)


# --- output -------------------------------------------------------------------------------------


@pytest.fixture
def results():
    slide = joint("slide_joint", "prismatic")
    described = {"a_joint": joint(), "slide_joint": slide}
    groups = {"one": ["a_joint", "slide_joint"]}
    steps = {"up": {"pose": "way", "steps": {"a_joint": 0.1, "slide_joint": 0.05}}}
    plan = Plan(config(groups=groups, postures=steps), POSES)
    runner = Runner(FakeRig(a_joint=0.0, slide_joint=0.0), plan, described)
    return plan, list(runner.run(["up"], ["a_joint", "slide_joint"]))


def test_the_tables_agree(results):
    _, steps = results
    rows = [line.split("|")[1:-1] for line in table.text(steps).splitlines()]
    assert [cell.strip() for cell in rows[4]] == [
        *("up", "slide", "shaped", "50.0 mm", "0.34", "0.0", "0.58", "0.000 mm", "7.0 N", "14"),
    ]
    assert len({len(line) for line in table.text(steps).splitlines()}) == 1
    records = json.loads(table.as_json(steps))
    assert records[2]["target"] - records[2]["start"] == pytest.approx(0.05)
    assert records[3]["reference"] == "raw"
    written = list(csv.DictReader(table.as_csv(steps).splitlines()))
    assert [float(row["settling_time"]) for row in written] == [
        pytest.approx(record["settling_time"]) for record in records
    ]


def test_what_was_not_reached_is_no_number(results):
    _, steps = results
    times = np.linspace(-0.1, 2.0, 211)
    stuck = StepRecording(times, np.zeros(211), np.zeros(211), 0.0, 0.1)
    lost = [type(steps[0])("up", joint(), False, stuck, analyse(stuck))]
    assert json.loads(table.as_json(lost))[0]["settling_time"] is None
    assert " - " in table.text(lost)


def test_figures_are_written_and_come_out_the_same_again(results, tmp_path):
    plan, steps = results
    files = report.write(tmp_path / "new" / "folder", plan, steps)
    assert sorted(path.name for path in files) == [
        *("one_up.png", "one_up.svg", "steps.csv", "steps.json", "steps.md"),
    ]
    svg = (tmp_path / "new" / "folder" / "one_up.svg").read_text()
    again = report.write(tmp_path / "again", plan, steps)
    assert (tmp_path / "again" / "one_up.svg").read_text() == svg
    assert all(path.stat().st_size > 100 for path in again)


# --- command line -------------------------------------------------------------------------------


def test_the_command_line():
    options = command_line.parse(["arm", "x_joint", "--pose", "folded", "--step", "5", "--no-raw"])
    assert (options.joints, options.pose, options.step) == (["arm", "x_joint"], ["folded"], 5.0)
    assert command_line.parse(["--all"]).joints == []


@pytest.mark.parametrize("arguments", [[], ["--all", "arm"], ["arm", "--step", "0"]])
def test_a_wrong_command_line_is_refused(arguments, capsys):
    with pytest.raises(SystemExit):
        command_line.parse(arguments)
    assert "usage" in capsys.readouterr().err


def test_without_a_master_it_says_so(monkeypatch, capsys):
    monkeypatch.setenv("ROS_MASTER_URI", "http://127.0.0.1:1")
    monkeypatch.setattr("sys.argv", ["step_response", "--all"])
    # Other tests in this process still want a node.
    monkeypatch.setattr("rospy.signal_shutdown", lambda _: None)
    with pytest.raises(SystemExit) as ended:
        command_line.main()
    assert ended.value.code == 1
    assert "no ROS master at http://127.0.0.1:1" in capsys.readouterr().err
