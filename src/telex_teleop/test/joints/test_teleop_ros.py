"""The nodes on a ROS master of their own, with a fake robot whose joints follow references."""

from __future__ import annotations

import contextlib
import statistics
import subprocess
import time

import pytest
import yaml
from fake_robot import (
    PACKAGE,
    TICK,
    FakeRobot,
    description,
    gaps,
    held_until,
    holding,
    rate,
    repeat,
    wait_until_listening,
    wait_until_told,
)
from own_ros import NodeProcess, Topics, wait_until_connected
from waiting import wait_until

from telex_teleop.motion.teleop_core import NEEDS_NEW_PRESS

pytestmark = [pytest.mark.ros, pytest.mark.waiting]

NAMESPACE = "/telex"
LONGEST_SILENCE = 0.5  # s from the last message to the first sign of the stop
TURRET = "turret_joint"
BELT = "front_left_track_joint"
ARM = {
    TURRET: ("revolute", -3.4, 3.4, 0.6),
    "shoulder_joint": ("revolute", -2.7, 1.0, 0.3),
    "telescope_joint": ("prismatic", 0.0, 0.3, 0.05),
    "elbow_joint": ("revolute", -2.9, 2.9, 0.6),
    "forearm_roll_joint": ("revolute", -3.4, 3.4, 1.2),
    "wrist_pitch_joint": ("revolute", -2.2, 2.2, 1.3),
    "gripper_roll_joint": ("revolute", -6.2, 6.2, 1.3),
    "turret_camera_pan_joint": ("revolute", -2.9, 2.9, 1.0),
    "turret_camera_tilt_joint": ("revolute", -0.7, 1.0, 1.0),
}
FLIPPERS = {
    f"{end}_{side}_flipper_joint": ("revolute", -1.9, 2.0, 1.0)
    for end in ("front", "rear")
    for side in ("left", "right")
}
FRONT_LEFT, FRONT_RIGHT, REAR_LEFT, _ = FLIPPERS
FINGERS = {
    f"{side}_finger_{part}_joint": ("revolute", -1.2, 1.2, 2.0)
    for side in ("left", "right")
    for part in ("base", "middle", "tip")
}


@contextlib.contextmanager
def running(environment, name, joints, *files):
    """Give a fake robot, topics beside it, and one of our nodes that starts with some files."""
    import rospy

    settings = {}
    for file in (name, *files):
        settings.update(yaml.safe_load((PACKAGE / "config" / f"{file}.yaml").read_text()))
    rospy.set_param("/use_sim_time", True)
    rospy.set_param(f"{NAMESPACE}/robot_description", description(joints))
    rospy.set_param(f"{NAMESPACE}/{name}", settings)
    program = [PACKAGE / "nodes" / name]
    with Topics(NAMESPACE) as topics, FakeRobot(topics, joints) as robot, NodeProcess(
        program, dict(environment, ROS_NAMESPACE=NAMESPACE)
    ) as node:
        yield robot, topics, node


def jog(joint=TURRET, rate=0.3):
    from control_msgs.msg import JointJog

    return JointJog(joint_names=[joint], velocities=[rate])


# ---------------------------------------------------------------- the arm


class ArmOperator:
    """Operates arm_teleop beside a fake robot that has a status as the simulator has it."""

    def __init__(self, robot, topics, node):
        from control_msgs.msg import JointJog
        from std_msgs.msg import Bool, Float64
        from telex_msgs.msg import JointTeleopStatus, SimStatus
        from telex_msgs.srv import SetMode

        self.robot, self.node = robot, node
        self.jogs = topics.publisher("arm_teleop/delta_joint_cmds", JointJog)
        self.e_stop = topics.publisher("e_stop", Bool)
        self.speed = topics.publisher("arm_teleop/speed_scale", Float64)
        self.sim_status = topics.publisher("sim/status", SimStatus, latch=True)
        self.status = topics.heard("arm_teleop/status", JointTeleopStatus)
        self.set_mode = topics.calls("arm_teleop/set_mode", SetMode)
        self.resets = None  # as the robot's status says; nothing is said before the first

    def wait_until_ready(self):
        wait_until_connected(self.jogs, self.e_stop, self.speed, self.sim_status)
        self.status.clear()
        wait_until_listening(self.status)

    def reset(self):
        """Let everything be as at the start: nothing stopped or held, full speed, at rest."""
        from std_msgs.msg import Bool, Float64

        self.robot.paused = False
        self.e_stop.publish(Bool(False))
        if self.resets is not None:
            self.tell_status(self.resets)
        self.speed.publish(Float64(1.0))
        self.robot.rest()
        wait_until_told(self.status, "")

    def press_e_stop(self):
        from std_msgs.msg import Bool

        self.e_stop.publish(Bool(True))

    def release_e_stop(self):
        from std_msgs.msg import Bool

        self.e_stop.publish(Bool(False))
        if self.resets is not None:
            self.tell_status(self.resets)

    def tell_status(self, resets, **values):
        from telex_msgs.msg import SimStatus

        self.resets = resets
        message = SimStatus(resets=resets, **values)
        message.header.stamp.secs = int(self.robot.sim_time)
        message.header.stamp.nsecs = round(self.robot.sim_time % 1.0 * 1e9)
        self.sim_status.publish(message)

    def travel(self, action):
        return self.robot.travel(TURRET, action)

    def key(self, duration):
        """Hold a key of the turret; how far it turns meanwhile."""
        return self.travel(lambda: repeat(self.jogs, jog(), duration))

    def turn(self):
        """Hold a key of the turret; steps of the first 1.6 s after the press, but for the ramp."""
        references = self.robot.references[TURRET]
        first = len(references)

        def begin():
            nonlocal first
            first = len(references)

        def turned():
            return len(references) > first + 160

        with held_until(turned, "160 references", self.jogs, jog(), self.status, begin):
            pass
        return self.robot.steps(TURRET, first)[60:160]

    def let_go(self, full_speed):
        """Let a key go at full speed; when its last message went out, and the steps after it."""
        references = self.robot.references[TURRET]
        first = len(references)

        def is_fast():
            steps = self.robot.steps(TURRET, first)[-20:]
            return len(steps) == 20 and rate(steps) == pytest.approx(full_speed)

        message = jog(rate=full_speed)
        with held_until(is_fast, "full speed", self.jogs, message, self.status) as sent:
            pass
        known = len(references)
        self.robot.rest()
        return sent[-1], self.robot.steps(TURRET, known)

    @contextlib.contextmanager
    def driving(self, least=0.05):
        """Hold a key of the turret; gives it once it has turned so far (rad)."""
        before = self.robot.positions[TURRET]

        def turned():
            return abs(self.robot.positions[TURRET] - before) > least

        with held_until(turned, "the turret to turn", self.jogs, jog(), self.status):
            yield

    def drive(self):
        with self.driving():
            pass

    def stays(self, duration=0.6):
        """Whether nothing moves for a while (s), once what was sent before has come."""
        self.robot.rest(10 * TICK)
        messages = self.robot.messages
        time.sleep(duration)
        return self.robot.messages == messages

    def restart_node(self):
        """Kill the node and start it again; how far the turret turns until it listens."""
        self.node.kill()
        # what it had sent is on its way, and is not what is measured
        time.sleep(0.1)

        def start():
            self.node.start()
            self.wait_until_ready()
            time.sleep(0.5)

        return self.travel(start)


@pytest.fixture(scope="class")
def started_arm(master):
    with running(master, "arm_teleop", ARM) as parts:
        operator = ArmOperator(*parts)
        operator.wait_until_ready()
        yield operator


@pytest.fixture
def arm(started_arm):
    started_arm.reset()
    return started_arm


class TestArm:
    def test_moves_at_the_commanded_rate_and_no_other_joint(self, arm):
        before = dict(arm.robot.positions)
        assert rate(arm.turn()) == pytest.approx(0.3, rel=0.02)
        assert [j for j, p in arm.robot.positions.items() if p != before[j]] == [TURRET]

    def test_speed_scale_halves_the_rate(self, arm):
        from std_msgs.msg import Float64

        for value in (0.5, float("nan")):
            arm.speed.publish(Float64(value))
        wait_until_told(arm.status, "", speed_scale=0.5)
        assert rate(arm.turn()) == pytest.approx(0.15, rel=0.02)

    def test_silence_is_a_command_to_stop(self, arm):
        full_step, ramp = -0.6 * TICK, 0.3
        slower = []
        for _ in range(5):  # a node that is held up for half a second stops without a ramp
            last, steps = arm.let_go(-0.6)
            slower = [moment for moment, step in steps if step > 0.9 * full_step]
            if slower:
                break
        # From the last message to the first slower step, then the ramp of 0.3 s at full rate. The
        # watchdog's 0.28 s are judged to the millisecond in test_teleop_stream.py; here two
        # processes on a loaded machine take their time between sending, hearing and being seen.
        assert slower, "it stops without a ramp"
        assert slower[0] - last >= 0.2
        assert (len(steps) - len(slower)) * TICK <= LONGEST_SILENCE
        assert len(steps) * TICK <= LONGEST_SILENCE + ramp

    def test_idle_it_publishes_its_status_and_no_reference(self, arm):
        from telex_msgs.msg import JointTeleopStatus

        heard = []
        messages = arm.robot.messages
        with Topics(NAMESPACE) as topics:
            topics.subscriber(
                "arm_teleop/status", JointTeleopStatus, lambda _: heard.append(time.monotonic())
            )
            wait_until(lambda: len(heard) > 12, "statuses")
        assert arm.robot.messages == messages
        assert statistics.median(gaps(heard)) == pytest.approx(0.1, abs=0.02)
        status = arm.status[-1]
        assert status.mode == "JOINT"
        assert list(status.joint_names) == list(ARM)
        assert list(status.max_velocity) == pytest.approx([joint[3] for joint in ARM.values()])

    def test_e_stop_ends_motion_and_latches(self, arm):
        with arm.driving():
            arm.press_e_stop()
            wait_until_told(arm.status, "the e-stop is active")
            assert arm.stays()
            # without a ramp
            assert arm.robot.steps(TURRET)[-1][1] > 0.9 * 0.3 * TICK
            arm.release_e_stop()
            wait_until_told(arm.status, NEEDS_NEW_PRESS)
            assert arm.stays()
        wait_until_told(arm.status, "")
        arm.drive()

    def test_bad_messages_move_nothing(self, arm):
        from control_msgs.msg import JointJog

        bad = [
            JointJog(joint_names=[TURRET], velocities=[float("nan")]),
            JointJog(joint_names=[TURRET, "no_joint"], velocities=[0.3, 0.3]),
            JointJog(joint_names=[TURRET, TURRET], velocities=[0.3, 0.3]),
            JointJog(joint_names=[TURRET], velocities=[0.3, 0.3]),
            JointJog(joint_names=[TURRET], velocities=[0.3], displacements=[0.1]),
            JointJog(joint_names=[TURRET]),
        ]
        assert arm.travel(lambda: [repeat(arm.jogs, message, 0.1) for message in bad]) == 0.0
        arm.drive()

    def test_stale_stream_moves_nothing_after_a_pause(self, arm):
        arm.robot.paused = True
        time.sleep(0.1)
        arm.key(0.3)
        time.sleep(0.5)

        def unpause():
            arm.robot.paused = False
            time.sleep(0.5)

        assert arm.travel(unpause) == 0.0

    def test_killed_and_restarted_node_moves_nothing(self, arm):
        arm.drive()
        arm.node.kill()
        time.sleep(0.1)
        messages = arm.robot.messages
        assert arm.restart_node() == 0.0
        assert arm.robot.messages == messages
        arm.drive()

    def test_stream_that_outlives_its_node_needs_a_new_press(self, arm):
        with holding(arm.jogs, jog()):
            assert arm.restart_node() == 0.0

    def test_stream_that_outlives_a_reset_needs_a_new_press(self, arm):
        # of which it tells that it has heard it
        arm.tell_status(resets=3, e_stop=True)
        wait_until_told(arm.status, "the e-stop is active")
        arm.tell_status(resets=3)
        wait_until_told(arm.status, "")
        with arm.driving():
            # so little that only the status tells of it
            arm.robot.positions[TURRET] -= 0.05
            arm.tell_status(resets=4)
            wait_until_told(arm.status, NEEDS_NEW_PRESS)
            assert arm.stays()
        arm.robot.rest()
        arm.drive()

    def test_restarted_node_believes_the_status_that_the_e_stop_is_set(self, arm):
        """The one who pressed is gone; what is left of the topic is somebody's older release."""
        from std_msgs.msg import Bool

        with Topics(NAMESPACE) as topics:
            topics.publisher("e_stop", Bool, queue_size=1, latch=True).publish(Bool(False))
            arm.tell_status(resets=4, e_stop=True)
            arm.restart_node()
            assert arm.key(0.6) == 0.0
            assert arm.status[-1].message == "the e-stop is active"
            arm.tell_status(resets=4)
            wait_until_told(arm.status, "")
            arm.drive()

    def test_modes(self, arm):
        answers = {mode: arm.set_mode(mode) for mode in ("JOINT", "CARTESIAN", "FLY")}
        assert (answers["JOINT"].success, answers["JOINT"].message) == (True, "")
        assert answers["CARTESIAN"].success is False
        assert "not available" in answers["CARTESIAN"].message
        assert answers["FLY"].success is False

    def test_wrong_parameters_end_the_node_with_one_line(self, master):
        done = subprocess.run(
            [str(PACKAGE / "nodes" / "arm_teleop"), "__name:=broken", "_jonts:=[a]"],
            env=master,
            capture_output=True,
            text=True,
            timeout=30.0,
            check=False,
        )
        assert done.returncode == 1
        assert "parameter /broken/jonts is unknown; known are" in done.stderr
        assert "Traceback" not in done.stderr


# ---------------------------------------------------------------- the gripper


def test_six_joints_of_the_gripper_move_together(master):
    from control_msgs.msg import JointJog
    from telex_msgs.msg import JointTeleopStatus

    with running(master, "gripper_teleop", FINGERS) as (robot, topics, _):
        robot.positions.update(dict.fromkeys(FINGERS, 0.0))
        jogs = topics.publisher("gripper_teleop/delta_joint_cmds", JointJog)
        status = topics.heard("gripper_teleop/status", JointTeleopStatus)
        wait_until_connected(jogs)
        wait_until_listening(status)

        def is_open():
            return robot.positions["left_finger_base_joint"] > 0.05

        with held_until(is_open, "it to open", jogs, jog("gripper", 0.1), status):
            pass
        robot.rest()
        opened = robot.positions["left_finger_base_joint"]
        assert opened > 0.05
        for joint, position in robot.positions.items():
            ratio = -2.0 if "tip" in joint else 1.0
            assert position == pytest.approx(ratio * opened, abs=1e-6)


# ---------------------------------------------------------------- the flippers


class FlipperOperator:
    """Holds keys of flipper_teleop, and sends it goals."""

    def __init__(self, robot, topics, _node):
        import actionlib
        from control_msgs.msg import JointJog
        from std_msgs.msg import Bool
        from telex_msgs.msg import (
            FlipperPresetAction,
            FlipperPresetHold,
            FlipperPresets,
            JointTeleopStatus,
        )

        self.robot = robot
        self.keys = topics.publisher("flipper_teleop/preset_cmds", FlipperPresetHold)
        self.jogs = topics.publisher("flipper_teleop/delta_joint_cmds", JointJog)
        self.e_stop = topics.publisher("e_stop", Bool)
        action = topics.name("flipper_teleop/preset")
        self.client = actionlib.SimpleActionClient(action, FlipperPresetAction)
        self.status = topics.heard("flipper_teleop/status", JointTeleopStatus)
        wait_until_connected(self.keys, self.jogs, self.e_stop)
        wait_until_listening(self.status)
        # not before the node is there: a latched message tells those who come late
        self.presets = topics.heard("flipper_teleop/presets", FlipperPresets)
        self.stop_action_client = self.client.action_client.stop

    def reset(self):
        """Let the flippers rest at zero, as if somebody had put them there, and nothing stop."""
        from std_msgs.msg import Bool

        self.e_stop.publish(Bool(False))
        self.client.cancel_all_goals()
        self.robot.rest()
        self.put(0.0)
        wait_until(
            lambda: self.status[-1].message == "",
            lambda: f"flipper_teleop to be ready (its status: {self.status[-1:]})",
        )

    def put(self, position):
        self.robot.put(dict.fromkeys(FLIPPERS, position), self.status)

    def hold(self, preset, duration, **values):
        from telex_msgs.msg import FlipperPresetHold

        repeat(self.keys, FlipperPresetHold(preset=preset, **values), duration)

    @contextlib.contextmanager
    def held_until_moved(self, joint, count, **values):
        """Hold the preset high until it has made so many steps of a joint; gives them, on call."""
        from telex_msgs.msg import FlipperPresetHold

        references = self.robot.references[joint]
        first = len(references)

        def begin():
            nonlocal first
            self.reset()
            first = len(references)

        def moved():
            return len(references) > first + count

        message = FlipperPresetHold(preset="high", **values)
        with held_until(moved, f"{count} steps", self.keys, message, self.status, begin):
            yield lambda: self.robot.steps(joint, first)

    def send(self, preset, feedback=None):
        from telex_msgs.msg import FlipperPresetGoal

        self.client.send_goal(
            FlipperPresetGoal(preset=preset),
            feedback_cb=lambda message: (
                None if feedback is None else feedback.append(list(message.remaining))
            ),
        )

    def outcome(self):
        """The state by which the goal ends, and its result."""
        import rospy
        from actionlib_msgs.msg import GoalStatus

        assert self.client.wait_for_result(rospy.Duration(10.0))
        names = {value: name for name, value in vars(GoalStatus).items() if isinstance(value, int)}
        return names[self.client.get_state()], self.client.get_result()

    def under_way(self):
        """Send a goal that takes a while, and come back while it moves."""
        self.send("high")
        wait_until(lambda: self.robot.positions[FRONT_RIGHT] < -0.2, "the flippers to move")


@pytest.fixture(scope="class")
def started_flippers(master):
    import rospy

    with running(master, "flipper_teleop", FLIPPERS, "flipper_presets") as parts:
        parts[0].positions.update(dict.fromkeys(FLIPPERS, 0.0))
        operator = FlipperOperator(*parts)
        try:
            assert operator.client.wait_for_server(rospy.Duration(30.0))
            yield operator
        finally:
            operator.stop_action_client()


@pytest.fixture
def flippers(started_flippers):
    started_flippers.reset()
    return started_flippers


class TestFlippers:
    def test_presets_are_announced_to_late_comers(self, flippers):
        names = ["flat", "drive", "approach", "climb", "descend", "high", "folded"]
        wait_until(lambda: flippers.presets, "the presets")
        assert list(flippers.presets[-1].names) == names

    def test_a_held_preset_moves_one_side_only_at_the_flippers_rate(self, flippers):
        positions = flippers.robot.positions
        left = [joint for joint in FLIPPERS if "left" in joint]
        with flippers.held_until_moved(FRONT_LEFT, 80, joint_names=left) as steps:
            pass
        moved = [joint for joint, position in positions.items() if position != 0.0]
        assert moved == [FRONT_LEFT, REAR_LEFT]
        assert rate(steps()[50:80]) == pytest.approx(-1.0, rel=0.05)

    def test_silence_is_a_command_to_stop(self, flippers):
        with flippers.held_until_moved(FRONT_LEFT, 60):
            pass
        ramp, way = 0.25, 1.0 * LONGEST_SILENCE
        before = flippers.robot.positions[FRONT_LEFT]
        flippers.robot.rest()
        assert 0.0 < before - flippers.robot.positions[FRONT_LEFT] <= way + 0.5 * ramp

    def test_an_unknown_held_preset_moves_nothing(self, flippers):
        assert flippers.robot.travel(FRONT_LEFT, lambda: flippers.hold("somersault", 0.3)) == 0.0

    def test_the_newer_of_two_clients_of_one_node_wins(self, flippers):
        from telex_msgs.msg import FlipperPresetHold

        first = FlipperPresetHold(preset="high", client="1")
        second = FlipperPresetHold(preset="folded", client="2")
        positions, references = flippers.robot.positions, flippers.robot.references[REAR_LEFT]
        for _ in range(5):  # to a node that is held up, both are pressed anew
            begin, known = time.monotonic(), len(references)
            repeat(flippers.keys, first, 0.3)
            before = positions[REAR_LEFT]
            for _ in range(40):
                flippers.keys.publish(second)
                flippers.keys.publish(first)
                time.sleep(0.02)
            moved = positions[REAR_LEFT] - before
            moments = [moment for moment, _ in references[known:]]
            if moved > 0.3 or max(gaps([begin, *moments, time.monotonic()])) < 0.05:
                break
            flippers.reset()
        # 1 rad/s for 0.8 s, less the ramps; in turns they would get nowhere
        assert moved > 0.3

    def test_a_goal_succeeds_with_feedback(self, flippers):
        flippers.put(-1.0)
        feedback = []
        flippers.send("flat", feedback)
        state, result = flippers.outcome()
        assert state == "SUCCEEDED"
        assert list(result.joint_names) == list(FLIPPERS)
        assert max(map(abs, result.error)) < 0.01
        assert len(feedback) >= 5
        farthest = [max(map(abs, remaining)) for remaining in feedback]
        assert farthest == sorted(farthest, reverse=True)

    def test_cancel_stops_at_once(self, flippers):
        flippers.under_way()
        known = len(flippers.robot.references[FRONT_RIGHT])
        flippers.client.cancel_goal()
        assert flippers.outcome()[0] == "PREEMPTED"
        flippers.robot.rest()
        # the ramp, and what two processes need to hear of it
        steps = flippers.robot.steps(FRONT_RIGHT, known)
        assert len([step for _, step in steps if step < -0.9 * TICK]) * TICK < 0.275
        assert len(steps) * TICK < 0.275 + 0.25

    def test_a_flipper_key_ends_a_goal(self, flippers):
        flippers.under_way()
        repeat(flippers.jogs, jog(REAR_LEFT, 0.1), 0.1)
        state, result = flippers.outcome()
        assert state == "ABORTED"
        assert "by hand" in result.message

    def test_the_e_stop_ends_a_goal_and_rejects_the_next(self, flippers):
        from std_msgs.msg import Bool

        flippers.under_way()
        flippers.e_stop.publish(Bool(True))
        state, result = flippers.outcome()
        assert (state, result.message) == ("ABORTED", "the e-stop is active")
        flippers.send("flat")
        state, result = flippers.outcome()
        assert state == "REJECTED"
        assert "the e-stop is active" in result.message

    def test_unknown_presets_are_rejected_with_what_there_is(self, flippers):
        flippers.send("somersault")
        assert flippers.outcome()[0] == "REJECTED"
        text = flippers.client.get_goal_status_text()
        assert "preset is 'somersault'; this robot has flat, drive" in text


# ---------------------------------------------------------------- the tracks


class TrackOperator:
    """Drives through track_teleop, and notes what the robot is told."""

    def __init__(self, robot, topics, _node):
        from geometry_msgs.msg import Twist
        from sensor_msgs.msg import JointState
        from std_msgs.msg import Float64
        from telex_msgs.msg import TrackTeleopStatus

        self.robot = robot
        self.sent = []  # (sim time, twist)
        # another robot's, with a clock of its own; the topic is shared
        self.other = topics.publisher("joint_states", JointState)
        status = topics.heard("track_teleop/status", TrackTeleopStatus)
        self.twists = topics.publisher("track_teleop/cmd_vel", Twist)
        self.speed = topics.publisher("track_teleop/speed_scale", Float64)
        topics.subscriber(
            "track_controller/cmd_vel",
            Twist,
            lambda message: self.sent.append((self.robot.sim_time, message)),
        )
        wait_until_connected(self.twists, self.speed)
        wait_until_listening(status)

    def drive(self, duration, linear, angular=0.0, lateral=0.0):
        from geometry_msgs.msg import Twist, Vector3

        message = Twist(linear=Vector3(x=linear, y=lateral), angular=Vector3(z=angular))
        return repeat(self.twists, message, duration)

    def driven(self, now):
        """Twists from a second before a moment on (s of sim time) that are no stops, with times."""
        from geometry_msgs.msg import Twist

        since = now - 1.0
        return [each for each in self.sent if each[0] > since and each[1] != Twist()]

    def silent(self):
        """Whether nothing has been sent for longer than a command lives."""
        return not self.sent or self.robot.sim_time - self.sent[-1][0] > 0.4

    def reset(self):
        from std_msgs.msg import Float64

        self.speed.publish(Float64(1.0))
        wait_until(self.silent, "silence")
        self.sent.clear()


def assert_at_fifty_hertz(driven):
    """Judge commands where the machine holds nothing up: it is shared with other tests."""
    times = [moment for moment, _ in driven]
    assert statistics.median(gaps(times)) == pytest.approx(0.02)
    # no command is left out: ten in a row take no longer than ten periods
    assert min(after - before for before, after in zip(times, times[10:])) < 0.215


@pytest.fixture(scope="class")
def started_tracks(master):
    joints = {**ARM, BELT: ("continuous", 0.0, 0.0, 11.0)}
    with running(master, "track_teleop", joints) as parts:
        yield TrackOperator(*parts)


@pytest.fixture
def tracks(started_tracks):
    started_tracks.reset()
    return started_tracks


class TestTracks:
    def test_commands_at_fifty_hertz_then_stops_then_is_silent(self, tracks):
        from geometry_msgs.msg import Twist
        from std_msgs.msg import Float64

        tracks.speed.publish(Float64(0.5))
        time.sleep(0.1)
        for _ in range(5):  # a node that is held up leaves stops out, or stops on the way
            tracks.sent.clear()
            silent_since = tracks.drive(1.2, 2.0, angular=-0.5, lateral=1.0)
            last, known = tracks.robot.sim_time, len(tracks.sent)
            driven = tracks.driven(last)
            wait_until(lambda: tracks.sent[-1][1] == Twist(), "the first stop")
            stopped = time.monotonic()
            wait_until(tracks.silent, "silence after the stops")
            stops = [message == Twist() for _, message in tracks.sent]
            first = stops.index(True)
            times = [moment for moment, _ in tracks.sent]
            # from the last command to the first stop, and so on to the end of the stops
            if max(gaps([*times[max(0, first - 1) :], times[first] + 0.2])) < 0.045:
                break
        assert_at_fifty_hertz(driven)
        assert driven[-1][1].linear.x == pytest.approx(0.6)  # 2 m/s clamped to 1.2, at half speed
        assert driven[-1][1].angular.z == pytest.approx(-0.25)
        assert stopped - silent_since >= 0.2
        assert (first - known) * 0.02 <= LONGEST_SILENCE
        assert all(stops[first:])
        assert 5 <= len(stops) - first <= 12
        before = len(tracks.sent)
        time.sleep(0.5)
        assert len(tracks.sent) == before

    def test_joint_states_of_others_do_not_disturb_the_drive(self, tracks):
        from sensor_msgs.msg import JointState

        with holding(tracks.other, JointState(name=["wheel_joint"], position=[0.0])):
            tracks.drive(1.2, 0.5)
            last = tracks.robot.sim_time
        assert_at_fifty_hertz(tracks.driven(last))

    def test_bad_twists_drive_nothing(self, tracks):
        tracks.drive(0.3, float("nan"))
        time.sleep(0.2)
        assert tracks.sent == []
