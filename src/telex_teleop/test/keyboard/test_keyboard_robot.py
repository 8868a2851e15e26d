"""What the operator's devices publish to a robot, without ROS around it."""

from __future__ import annotations

import math

import pytest
import rospy
from std_msgs.msg import Float64
from telex_msgs.msg import (
    CartesianTeleopStatus,
    FlipperPresets,
    GripperContact,
    JointTeleopStatus,
    LinkState,
    TrackTeleopStatus,
)

from telex_teleop.keyboard.robot_status import ShownRobot
from telex_teleop.operating.commander import Commands, PresetCommand
from telex_teleop.operating.operated_robot import OperatedRobot
from telex_teleop.tracks.track_drive import Velocity


class Graph:
    """Stands for ROS: what was published, and who listens."""

    def __init__(self):
        self.sent = []
        self.receivers = {}

    def publisher(self, name, _kind, **_options):
        graph = self

        class Publisher:
            def publish(self, message):
                graph.sent.append((name, message))

        return Publisher()

    def subscriber(self, name, _kind, callback, callback_args=None, **_options):
        arguments = () if callback_args is None else (callback_args,)
        self.receivers[name] = lambda message: callback(message, *arguments)

    def say(self, name, message):
        self.receivers[name](message)


@pytest.fixture
def graph(monkeypatch):
    graph = Graph()
    monkeypatch.setattr(rospy, "Publisher", graph.publisher)
    monkeypatch.setattr(rospy, "Subscriber", graph.subscriber)
    monkeypatch.setattr(rospy.Time, "now", rospy.Time)
    monkeypatch.setattr(rospy, "get_name", lambda: "/us")
    return graph


def test_a_preset_that_the_robot_lacks_is_told_and_not_sent(graph):
    robot = OperatedRobot("/r")
    presets = "/r/flipper_teleop/presets"
    graph.receivers[presets](FlipperPresets(names=["flat", "high"]))
    for name in ("somersault", "high", ""):
        robot.send(Commands(jogs={}, drive=(), preset=(PresetCommand(name),)))
    topic = "/r/flipper_teleop/preset_cmds"
    sent = [(name, message.preset) for name, message in graph.sent]
    assert sent == [(topic, "high"), (topic, "")]
    assert robot.notice == "preset somersault: the robot has flat, high"


def test_before_the_robot_has_named_its_presets_they_are_sent(graph):
    robot = OperatedRobot("/r")
    robot.send(Commands(jogs={}, drive=(), preset=(PresetCommand("somersault"),)))
    assert [message.preset for _, message in graph.sent] == ["somersault"]
    assert robot.notice == ""


def test_while_the_line_is_impaired_only_stops_pass_and_the_operator_is_told_why(graph):
    robot = OperatedRobot("/r", ["front"])
    ahead = Commands(jogs={}, drive=(Velocity(1.0, 0.0),))
    still = Commands(jogs={}, drive=(Velocity(0.0, 0.0),))
    robot.send(ahead)
    graph.receivers["/r/link/state"](LinkState(profile="300", perfect=False))
    for commands in (ahead, ahead, still):
        robot.send(commands)
    speeds = [message.linear.x for _, message in graph.sent]
    # What moved is stopped, once: zeros of a device that is refused are no commands for others.
    assert speeds == [1.0, 0.0, 0.0]
    assert robot.notice.startswith("refused: the line is set to 300")
    robot.switch_lamps(["front"])
    robot.set_e_stop(False)
    assert len(graph.sent) == 3
    robot.set_e_stop(True)
    assert graph.sent[-1][1].data
    graph.receivers["/r/link/state"](LinkState(profile="perfect", perfect=True))
    robot.send(ahead)
    assert graph.sent[-1][1].linear.x == 1.0


SCALES = {"speed_scale": 0.5, "min_speed_scale": 0.05, "max_speed_scale": 1.0}


@pytest.mark.parametrize("field", SCALES)
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, 1e308])
def test_a_speed_that_is_no_number_is_no_answer(graph, field, value):
    robot = OperatedRobot("/r")
    status = "/r/arm_teleop/status"
    graph.say(status, JointTeleopStatus(**{**SCALES, field: value}))
    robot.change_speed(-1, 0.1)
    assert robot.notice == "speed: no answer from the robot"
    assert graph.sent == []
    assert robot.speed_scale == (None if field == "speed_scale" else 0.5)
    graph.say(status, JointTeleopStatus(**SCALES))
    robot.change_speed(-1, 0.1)
    assert [message.data for _, message in graph.sent] == [pytest.approx(0.4)] * 4


def test_a_stop_ends_all_that_commands_ask_for():
    moving = Commands(
        jogs={"arm": {"turret_joint": 0.5}},
        drive=(Velocity(1.0, 0.0),),
        preset=(PresetCommand("flat", "left"),),
        tool=((0.1, 0.0, 0.0, 0.0, 0.0, 0.0),),
        pose=("home",),
        zoom=(0.5,),
    )
    assert moving.moves
    stopped = moving.stopped()
    assert not stopped.moves
    assert stopped.jogs == {"arm": {"turret_joint": 0.0}}
    assert (len(stopped.drive), len(stopped.tool[0]), stopped.pose) == (1, 6, ("",))


def test_a_preset_for_a_side_names_the_flippers_of_that_side(graph):
    robot = OperatedRobot("/r")
    left = Commands(jogs={}, drive=(), preset=(PresetCommand("flat", "left"),))
    robot.send(left)
    # without a name it would move all of them
    assert graph.sent == []
    assert robot.notice == "preset flat: no flippers known on the left"
    names = ["front_left_flipper_joint", "front_right_flipper_joint", "left_rear_flipper_joint"]
    graph.say("/r/flipper_teleop/status", JointTeleopStatus(joint_names=names))
    robot.send(left)
    assert graph.sent[0][1].joint_names == [names[0], names[2]]


def test_a_stop_of_what_the_robot_lacks_keeps_no_other_from_stopping(graph):
    # the node refuses a message with an unknown joint as a whole
    robot = OperatedRobot("/r")
    graph.say("/r/arm_teleop/status", JointTeleopStatus(joint_names=["turret_joint"]))
    for rates in (
        {"turret_joint": 0.0, "telescope_joint": 0.0},
        {"telescope_joint": 0.0},
        {"telescope_joint": 1.0},  # a wish is told to the node, which says why it refuses it
    ):
        robot.send(Commands(jogs={"arm": rates}, drive=()))
    assert [message.joint_names for _, message in graph.sent] == [
        ["turret_joint"],
        ["telescope_joint"],
    ]


class TestLamps:
    def test_a_press_switches_all_of_them(self, graph):
        robot = OperatedRobot("/r", lamps=("a", "b"))
        for levels, lit in (([1.0, 1.0], ("a", "b")), ([0.0, 0.0], ())):
            graph.sent.clear()
            robot.switch_lamps(("a", "b"))
            topics = ["/r/lamps/a/command", "/r/lamps/b/command"]
            assert [(n, m.data) for n, m in graph.sent] == list(zip(topics, levels))
            assert robot.lit == lit

    def test_what_others_have_lit_is_known(self, graph):
        robot = OperatedRobot("/r", lamps=("a", "b"))
        graph.say("/r/lamps/b/level", Float64(0.4))
        assert robot.lit == ("b",)
        robot.switch_lamps(("a", "b"))
        assert [message.data for _, message in graph.sent] == [0.0, 0.0]


def test_zoom_goes_on_from_where_the_camera_is(graph, monkeypatch):
    robot = OperatedRobot("/r", zoom_rate=1.0, max_zoom=6.0)
    now = [10.0]
    monkeypatch.setattr("telex_teleop.operating.operated_robot.time.monotonic", lambda: now[0])
    graph.say("/r/cameras/turret/zoom_factor", Float64(3.0))
    for share in (1.0, 1.0, 0.0):
        robot.send(Commands(jogs={}, drive=(), zoom=(share,)))
        now[0] += 0.1
    name, message = graph.sent[0]
    assert name == "/r/cameras/turret/zoom"
    assert message.data == pytest.approx(3.0 * 1.10517, rel=1e-4)
    # A factor from before what was sent last undoes nothing; one from long after it counts.
    for later, factor in ((0.2, message.data), (2.0, 1.5)):
        now[0] += later
        graph.say("/r/cameras/turret/zoom_factor", Float64(1.5))
        assert robot.zoom == pytest.approx(factor)


def test_full_rates_are_what_the_nodes_say(graph):
    robot = OperatedRobot("/r")
    assert (robot.joint("arm", "a"), robot.drive(), robot.tool_speed()) == (None, None, None)
    status = JointTeleopStatus(joint_names=["a", "b"], max_velocity=[0.5, 0.0])
    graph.say("/r/arm_teleop/status", status)
    graph.say("/r/track_teleop/status", TrackTeleopStatus(max_linear=1.2, max_angular=0.9))
    tool = CartesianTeleopStatus(max_linear=0.15, max_angular=0.6)
    graph.say("/r/arm_teleop/cartesian_status", tool)
    assert [robot.joint("arm", name) for name in "abc"] == [0.5, None, None]
    assert robot.drive() == Velocity(1.2, 0.9)
    assert robot.tool_speed() == (0.15, 0.6)


def test_what_slips_in_the_gripper_is_told_while_it_slips(graph):
    robot = ShownRobot("/r")
    tell, arm = graph.receivers["/r/sim/gripper_contact"], "/r/arm_teleop/status"
    assert robot.arm_notice == ""
    tell(GripperContact(object="cube_5", slipping=True, slip_speed=0.0123))
    assert robot.arm_notice == "cube_5 slips in the gripper, 12 mm/s"
    graph.receivers[arm](JointTeleopStatus(notice="stopped: 5 mm from floor"))
    assert robot.arm_notice == "cube_5 slips in the gripper, 12 mm/s; stopped: 5 mm from floor"
    tell(GripperContact(object="cube_5", slip_speed=0.0004))
    assert robot.arm_notice == "stopped: 5 mm from floor"
