"""The nodes on a ROS master of their own, with a fake robot whose joints follow their references.

One run of this file as a program (`python test_teleop_ros.py ROLE`) plays a drill and prints what
it measured as JSON; the tests judge that. The drill has a process of its own because rospy can be
initialised only once per process.
"""

from __future__ import annotations

import json
import subprocess
import sys
import time

import pytest
from teleop_drill import PACKAGE, TICK, FakeRobot, Held, Node, description, repeat, wait_for

from telex_control.ros.rospy_fixes.connecting import miss_nothing
from telex_experiments.rigs.private_master import PrivateMaster

LONGEST_SILENCE = 0.5  # s from the last message to the first sign of the stop
BELT = "front_left_track_joint"
ARM = {
    "turret_joint": ("revolute", -3.4, 3.4, 0.6),
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
FINGERS = {
    f"{side}_finger_{part}_joint": ("revolute", -1.2, 1.2, 2.0)
    for side in ("left", "right")
    for part in ("base", "middle", "tip")
}


# ---------------------------------------------------------------- the tests


@pytest.fixture(scope="module")
def master():
    """Environment of a roscore on a free port."""
    with PrivateMaster() as master:
        yield master.environment()


def play(environment, role):
    done = subprocess.run(
        [sys.executable, __file__, role],
        env=dict(environment, ROS_NAMESPACE="/telex"),
        capture_output=True,
        text=True,
        timeout=120.0,
        check=False,
    )
    assert done.returncode == 0, done.stdout[-4000:] + done.stderr[-4000:]
    return json.loads(done.stdout.splitlines()[-1])


@pytest.fixture(scope="module")
def arm(master):
    return play(master, "arm")


@pytest.fixture(scope="module")
def gripper(master):
    return play(master, "gripper")


@pytest.fixture(scope="module")
def flippers(master):
    return play(master, "flippers")


@pytest.fixture(scope="module")
def tracks(master):
    return play(master, "tracks")


@pytest.mark.ros
class TestArm:
    def test_moves_at_the_commanded_rate(self, arm):
        assert arm["rate"] == pytest.approx(0.3, rel=0.02)

    def test_moves_no_other_joint(self, arm):
        assert arm["moved"] == ["turret_joint"]

    def test_speed_scale_halves_the_rate(self, arm):
        assert arm["half_rate"] == pytest.approx(0.15, rel=0.02)

    def test_silence_is_a_command_to_stop(self, arm):
        # From the last message to the first slower step, then the ramp of 0.3 s at full rate. The
        # watchdog's 0.28 s are judged to the millisecond in test_teleop_stream.py; here two
        # processes on a loaded machine take their time between sending, hearing and being seen.
        assert 0.2 <= arm["slower_after"] <= LONGEST_SILENCE
        assert arm["rest_after"] <= LONGEST_SILENCE + arm["ramp"]

    def test_holds_and_publishes_nothing_when_idle(self, arm):
        assert arm["idle_messages"] == 0

    def test_e_stop_ends_motion_and_latches(self, arm):
        assert arm["e_stop_moved"] < 0.02
        assert arm["held_key_moved"] == 0.0
        assert arm["new_press_moved"] > 0.05

    def test_bad_messages_move_nothing(self, arm):
        assert arm["bad_moved"] == 0.0
        assert arm["after_bad_moved"] > 0.05

    def test_stale_stream_moves_nothing_after_a_pause(self, arm):
        assert arm["pause_moved"] == 0.0

    def test_killed_and_restarted_node_moves_nothing(self, arm):
        assert arm["restart_messages"] == 0
        assert arm["restart_moved"] == 0.0
        assert arm["after_restart_moved"] > 0.05

    def test_stream_that_outlives_its_node_needs_a_new_press(self, arm):
        assert arm["old_stream_moved"] == 0.0

    def test_stream_that_outlives_a_reset_needs_a_new_press(self, arm):
        assert arm["reset_moved"] == 0.0
        assert arm["after_reset_moved"] > 0.05

    def test_restarted_node_believes_the_status_that_the_e_stop_is_set(self, arm):
        assert arm["respawned_message"] == "the e-stop is active"
        assert arm["respawned_moved"] == 0.0
        assert arm["after_release_moved"] > 0.05

    def test_modes(self, arm):
        assert arm["modes"]["JOINT"] == [True, ""]
        assert arm["modes"]["CARTESIAN"][0] is False
        assert "not available" in arm["modes"]["CARTESIAN"][1]
        assert arm["modes"]["FLY"][0] is False

    def test_status(self, arm):
        assert arm["status_rate"] == pytest.approx(10.0, abs=2.0)
        assert arm["status"]["mode"] == "JOINT"
        assert arm["status"]["joint_names"] == list(ARM)
        assert arm["status"]["max_velocity"] == pytest.approx([joint[3] for joint in ARM.values()])

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


@pytest.mark.ros
class TestGripper:
    def test_six_joints_move_together(self, gripper):
        opened = gripper["opened"]
        assert opened > 0.05
        for joint, position in gripper["positions"].items():
            ratio = -2.0 if "tip" in joint else 1.0
            assert position == pytest.approx(ratio * opened, abs=1e-6)


@pytest.mark.ros
class TestFlippers:
    def test_presets_are_announced_to_late_comers(self, flippers):
        names = ["flat", "drive", "approach", "climb", "descend", "high", "folded"]
        assert flippers["presets"] == names

    def test_a_held_preset_moves_at_the_flippers_rate(self, flippers):
        assert flippers["rate"] == pytest.approx(-1.0, rel=0.05)

    def test_silence_is_a_command_to_stop(self, flippers):
        ramp, way = 0.25, 1.0 * LONGEST_SILENCE
        assert 0.0 < flippers["run_on"] <= way + 0.5 * ramp

    def test_one_side_only(self, flippers):
        assert flippers["moved"] == ["front_left_flipper_joint", "rear_left_flipper_joint"]

    def test_the_newer_of_two_clients_of_one_node_wins(self, flippers):
        # 1 rad/s for 0.8 s, less the ramps; in turns they would get nowhere
        assert flippers["shared"] > 0.3

    def test_a_goal_succeeds_with_feedback(self, flippers):
        goal = flippers["reached"]
        assert goal["state"] == "SUCCEEDED"
        assert goal["joint_names"] == list(FLIPPERS)
        assert max(map(abs, goal["error"])) < 0.01
        assert len(goal["feedback"]) >= 5
        farthest = [max(map(abs, remaining)) for remaining in goal["feedback"]]
        assert farthest == sorted(farthest, reverse=True)

    def test_cancel_stops_at_once(self, flippers):
        goal = flippers["cancelled"]
        assert goal["state"] == "PREEMPTED"
        # the ramp, and what two processes need to hear of it
        assert goal["run_on"] < 0.4

    def test_a_flipper_key_ends_a_goal(self, flippers):
        goal = flippers["manual"]
        assert goal["state"] == "ABORTED"
        assert "by hand" in goal["message"]

    def test_the_e_stop_ends_a_goal_and_rejects_the_next(self, flippers):
        assert flippers["stopped"]["state"] == "ABORTED"
        assert flippers["stopped"]["message"] == "the e-stop is active"
        assert flippers["refused"]["state"] == "REJECTED"
        assert "the e-stop is active" in flippers["refused"]["message"]

    def test_unknown_presets_are_rejected_with_what_there_is(self, flippers):
        assert flippers["unknown"]["state"] == "REJECTED"
        assert "preset is 'somersault'; this robot has flat, drive" in flippers["unknown"]["text"]

    def test_an_unknown_held_preset_moves_nothing(self, flippers):
        assert flippers["unknown_held_moved"] == 0.0


@pytest.mark.ros
class TestTracks:
    def test_commands_at_fifty_hertz_while_alive(self, tracks):
        assert tracks["count"] == pytest.approx(50, abs=4)
        assert tracks["linear"] == pytest.approx(0.6)  # 2 m/s clamped to 1.2, at half speed
        assert tracks["angular"] == pytest.approx(-0.25)

    def test_stops_then_is_silent(self, tracks):
        assert 0.2 <= tracks["stop_after"] <= LONGEST_SILENCE
        assert 5 <= tracks["stops"] <= 12
        assert tracks["messages_later"] == 0

    def test_joint_states_of_others_do_not_disturb_the_drive(self, tracks):
        assert tracks["count_beside_others"] == pytest.approx(50, abs=4)

    def test_bad_twists_drive_nothing(self, tracks):
        assert tracks["bad_messages"] == 0


# ---------------------------------------------------------------- the drill


def wait_until_listening(statuses):
    """Wait until a node has joint states and the time is over in which it is deaf."""
    wait_for(
        lambda: statuses and not statuses[-1].message.startswith(("just started", "no joint")),
        "the node to listen",
    )


def jog(joint="turret_joint", rate=0.3):
    from control_msgs.msg import JointJog

    return JointJog(joint_names=[joint], velocities=[rate])


class ArmDrill:
    """Everything that is measured on arm_teleop."""

    def __init__(self, robot, node):
        import rospy
        from control_msgs.msg import JointJog
        from std_msgs.msg import Bool, Float64
        from telex_msgs.msg import JointTeleopStatus, SimStatus

        self.robot = robot
        self.node = node
        self.jogs = rospy.Publisher("arm_teleop/delta_joint_cmds", JointJog, queue_size=10)
        self.e_stop = rospy.Publisher("e_stop", Bool, queue_size=10)
        self.speed = rospy.Publisher("arm_teleop/speed_scale", Float64, queue_size=10)
        self.sim_status = rospy.Publisher("sim/status", SimStatus, queue_size=10, latch=True)
        self.status = []
        rospy.Subscriber("arm_teleop/status", JointTeleopStatus, self.status.append)
        self.wait_until_ready()

    def wait_until_ready(self):
        self.status.clear()
        wait_for(lambda: self.jogs.get_num_connections() and self.status, "arm_teleop")
        wait_until_listening(self.status)

    def travel(self, action):
        before = self.robot.positions["turret_joint"]
        action()
        return abs(self.robot.positions["turret_joint"] - before)

    def key(self, duration, rate=0.3):
        repeat(self.jogs, jog(rate=rate), duration)

    def settle(self):
        time.sleep(0.8)

    def run(self):
        results = {}
        before = dict(self.robot.positions)
        self.key(1.6)
        results["rate"] = self.robot.rate("turret_joint", 1.0)
        results["moved"] = [j for j, p in self.robot.positions.items() if p != before[j]]
        self.settle()
        results.update(self.measure_stop())
        results.update(self.measure_idle())
        results.update(self.measure_speed())
        results.update(self.measure_e_stop())
        results.update(self.measure_bad_messages())
        results.update(self.measure_pause())
        results.update(self.measure_restart())
        results.update(self.measure_reset())
        results.update(self.measure_e_stop_across_a_restart())
        results["modes"] = self.ask_modes()
        return results

    def measure_stop(self):
        self.key(1.0, rate=-0.6)
        last = self.robot.sim_time
        full_step = 0.6 * TICK
        self.settle()
        steps = [
            (time_b, abs(b["turret_joint"] - a["turret_joint"]))
            for (_, a), (time_b, b) in zip(self.robot.history, self.robot.history[1:])
            if time_b > last
        ]
        slower = next(t for t, _ in steps if self.is_final(steps, t, 0.9 * full_step))
        rest = next(t for t, _ in steps if self.is_final(steps, t, 1e-9))
        return {"slower_after": slower - last, "rest_after": rest - last, "ramp": 0.3}

    @staticmethod
    def is_final(steps, moment, bound):
        """Tell whether all steps from a moment on are small: jitter makes single ones so."""
        return all(step < bound for t, step in steps if t >= moment)

    def measure_idle(self):
        before, count = self.robot.messages, len(self.status)
        time.sleep(1.0)
        message = self.status[-1]
        return {
            "idle_messages": self.robot.messages - before,
            "status_rate": float(len(self.status) - count),
            "status": {
                "mode": message.mode,
                "joint_names": list(message.joint_names),
                "max_velocity": list(message.max_velocity),
            },
        }

    def measure_speed(self):
        from std_msgs.msg import Float64

        for value in (0.5, float("nan")):
            self.speed.publish(Float64(value))
        time.sleep(0.2)
        self.key(1.6)
        half = self.robot.rate("turret_joint", 1.0)
        self.speed.publish(Float64(1.0))
        self.settle()
        return {"half_rate": half}

    def measure_e_stop(self):
        from std_msgs.msg import Bool

        self.key(0.6)
        self.e_stop.publish(Bool(True))
        stopping = self.travel(lambda: self.key(0.5))
        self.e_stop.publish(Bool(False))
        time.sleep(0.05)
        held = self.travel(lambda: self.key(0.6))
        time.sleep(0.4)
        pressed = self.travel(lambda: self.key(0.6))
        self.settle()
        return {"e_stop_moved": stopping, "held_key_moved": held, "new_press_moved": pressed}

    def measure_bad_messages(self):
        from control_msgs.msg import JointJog

        turret = "turret_joint"
        bad = [
            JointJog(joint_names=[turret], velocities=[float("nan")]),
            JointJog(joint_names=[turret, "no_joint"], velocities=[0.3, 0.3]),
            JointJog(joint_names=[turret, turret], velocities=[0.3, 0.3]),
            JointJog(joint_names=[turret], velocities=[0.3, 0.3]),
            JointJog(joint_names=[turret], velocities=[0.3], displacements=[0.1]),
            JointJog(joint_names=[turret]),
        ]
        moved = self.travel(lambda: [repeat(self.jogs, message, 0.1) for message in bad])
        after = self.travel(lambda: self.key(0.6))
        self.settle()
        return {"bad_moved": moved, "after_bad_moved": after}

    def measure_pause(self):
        self.robot.paused = True
        time.sleep(0.1)
        self.key(0.3)
        time.sleep(0.5)

        def unpause():
            self.robot.paused = False
            time.sleep(0.5)

        return {"pause_moved": self.travel(unpause)}

    def measure_restart(self):
        self.key(0.6)
        self.node.kill()
        time.sleep(0.1)
        before, messages = self.robot.positions["turret_joint"], self.robot.messages
        self.node.start()
        self.wait_until_ready()
        time.sleep(0.5)
        moved = abs(self.robot.positions["turret_joint"] - before)
        messages = self.robot.messages - messages
        after = self.travel(lambda: self.key(0.6))
        self.settle()
        return {
            "restart_moved": moved,
            "restart_messages": messages,
            "after_restart_moved": after,
            "old_stream_moved": self.hold_across_a_restart(),
        }

    def hold_across_a_restart(self):
        with Held(self.jogs, jog()):
            self.node.kill()
            # what it had sent is on its way, and is not what is measured
            time.sleep(0.1)
            before = self.robot.positions["turret_joint"]
            self.node.start()
            self.wait_until_ready()
            time.sleep(0.6)
            moved = abs(self.robot.positions["turret_joint"] - before)
        self.settle()
        return moved

    def tell_status(self, **values):
        from telex_msgs.msg import SimStatus

        message = SimStatus(**values)
        message.header.stamp.secs = int(self.robot.sim_time)
        message.header.stamp.nsecs = round(self.robot.sim_time % 1.0 * 1e9)
        self.sim_status.publish(message)

    def measure_reset(self):
        self.tell_status(resets=3)
        time.sleep(0.3)
        with Held(self.jogs, jog()):
            time.sleep(0.6)
            # so little that only the status tells of it
            self.robot.positions["turret_joint"] -= 0.05
            self.tell_status(resets=4)
            time.sleep(0.1)
            moved = self.travel(lambda: time.sleep(0.6))
        self.settle()
        after = self.travel(lambda: self.key(0.6))
        self.settle()
        return {"reset_moved": moved, "after_reset_moved": after}

    def measure_e_stop_across_a_restart(self):
        """The one who pressed is gone; what is left of the topic is somebody's older release."""
        import rospy
        from std_msgs.msg import Bool

        released = rospy.Publisher("e_stop", Bool, queue_size=1, latch=True)
        released.publish(Bool(False))
        self.tell_status(resets=4, e_stop=True)
        self.node.kill()
        self.node.start()
        self.wait_until_ready()
        moved = self.travel(lambda: self.key(0.6))
        message = self.status[-1].message
        self.tell_status(resets=4)
        time.sleep(0.5)
        after = self.travel(lambda: self.key(0.6))
        self.settle()
        return {
            "respawned_moved": moved,
            "respawned_message": message,
            "after_release_moved": after,
        }

    @staticmethod
    def ask_modes():
        import rospy
        from telex_msgs.srv import SetMode

        set_mode = rospy.ServiceProxy("arm_teleop/set_mode", SetMode)
        answers = {mode: set_mode(mode) for mode in ("JOINT", "CARTESIAN", "FLY")}
        return {mode: [answer.success, answer.message] for mode, answer in answers.items()}


class GripperDrill:
    def __init__(self, robot, _node):
        import rospy
        from control_msgs.msg import JointJog
        from telex_msgs.msg import JointTeleopStatus

        self.robot = robot
        self.robot.positions.update(dict.fromkeys(robot.joints, 0.0))
        self.jogs = rospy.Publisher("gripper_teleop/delta_joint_cmds", JointJog, queue_size=10)
        status = []
        rospy.Subscriber("gripper_teleop/status", JointTeleopStatus, status.append)
        wait_for(self.jogs.get_num_connections, "gripper_teleop")
        wait_until_listening(status)

    def run(self):
        repeat(self.jogs, jog("gripper", 0.1), 1.0)
        time.sleep(0.8)
        positions = dict(self.robot.positions)
        return {"opened": positions["left_finger_base_joint"], "positions": positions}


class FlipperDrill:
    def __init__(self, robot, _node):
        import actionlib
        import rospy
        from control_msgs.msg import JointJog
        from std_msgs.msg import Bool
        from telex_msgs.msg import FlipperPresetAction, FlipperPresetHold, JointTeleopStatus

        self.robot = robot
        self.robot.positions.update(dict.fromkeys(robot.joints, 0.0))
        self.keys = rospy.Publisher("flipper_teleop/preset_cmds", FlipperPresetHold, queue_size=10)
        self.jogs = rospy.Publisher("flipper_teleop/delta_joint_cmds", JointJog, queue_size=10)
        self.e_stop = rospy.Publisher("e_stop", Bool, queue_size=10)
        self.client = actionlib.SimpleActionClient("flipper_teleop/preset", FlipperPresetAction)
        status = []
        rospy.Subscriber("flipper_teleop/status", JointTeleopStatus, status.append)
        for publisher in (self.keys, self.jogs, self.e_stop):
            wait_for(publisher.get_num_connections, "flipper_teleop")
        wait_until_listening(status)
        assert self.client.wait_for_server(rospy.Duration(10.0))

    def run(self):
        import rospy
        from std_msgs.msg import Bool
        from telex_msgs.msg import FlipperPresets

        announced = rospy.wait_for_message("flipper_teleop/presets", FlipperPresets, 5.0)
        results = {"presets": list(announced.names), **self.hold_keys()}
        results["shared"] = self.share_a_node()
        results["reached"] = self.reach("flat")
        results["cancelled"] = self.interrupt(self.client.cancel_goal)
        results["manual"] = self.interrupt(
            lambda: repeat(self.jogs, jog("rear_left_flipper_joint", 0.1), 0.1)
        )
        time.sleep(0.5)
        results["stopped"] = self.interrupt(lambda: self.e_stop.publish(Bool(True)))
        results["refused"] = self.outcome("flat")
        self.e_stop.publish(Bool(False))
        time.sleep(0.2)
        results["unknown"] = self.outcome("somersault")
        return results

    def hold_keys(self):
        from telex_msgs.msg import FlipperPresetHold

        left = [joint for joint in FLIPPERS if "left" in joint]
        repeat(self.keys, FlipperPresetHold(preset="high", joint_names=left), 0.8)
        moved = [joint for joint, position in self.robot.positions.items() if position != 0.0]
        rate = self.robot.rate("front_left_flipper_joint", 0.3)
        before = self.robot.positions["front_left_flipper_joint"]
        time.sleep(1.0)
        after = self.robot.positions["front_left_flipper_joint"]
        repeat(self.keys, FlipperPresetHold(preset="somersault"), 0.3)
        unknown = abs(self.robot.positions["front_left_flipper_joint"] - after)
        return {
            "moved": moved,
            "rate": rate,
            "run_on": before - after,
            "unknown_held_moved": unknown,
        }

    def share_a_node(self):
        """Two clients of one node hold presets, the second one later; how far that one gets."""
        from telex_msgs.msg import FlipperPresetHold

        first = FlipperPresetHold(preset="high", client="1")
        second = FlipperPresetHold(preset="folded", client="2")
        repeat(self.keys, first, 0.3)
        before = self.robot.positions["rear_left_flipper_joint"]
        for _ in range(40):
            self.keys.publish(second)
            self.keys.publish(first)
            time.sleep(0.02)
        moved = self.robot.positions["rear_left_flipper_joint"] - before
        time.sleep(0.6)
        return moved

    def reach(self, preset):
        feedback = []
        return {**self.outcome(preset, feedback), "feedback": feedback}

    def interrupt(self, act):
        """Begin a goal, do something after a while, and tell how the goal ended."""
        self.send("high" if self.robot.positions["front_right_flipper_joint"] > -0.6 else "folded")
        time.sleep(0.6)
        before = self.robot.positions["front_right_flipper_joint"]
        act()
        outcome = self.wait()
        time.sleep(0.5)
        after = self.robot.positions["front_right_flipper_joint"]
        return {**outcome, "run_on": abs(after - before)}

    def outcome(self, preset, feedback=None):
        self.send(preset, feedback)
        return self.wait()

    def send(self, preset, feedback=None):
        from telex_msgs.msg import FlipperPresetGoal

        self.client.send_goal(
            FlipperPresetGoal(preset=preset),
            feedback_cb=lambda message: (
                None if feedback is None else feedback.append(list(message.remaining))
            ),
        )

    def wait(self):
        import rospy
        from actionlib_msgs.msg import GoalStatus

        assert self.client.wait_for_result(rospy.Duration(10.0))
        names = {value: name for name, value in vars(GoalStatus).items() if isinstance(value, int)}
        result = self.client.get_result()
        return {
            "state": names[self.client.get_state()],
            "text": self.client.get_goal_status_text(),
            "message": result.message,
            "joint_names": list(result.joint_names),
            "error": list(result.error),
        }


class TrackDrill:
    def __init__(self, robot, _node):
        import rospy
        from geometry_msgs.msg import Twist
        from sensor_msgs.msg import JointState
        from std_msgs.msg import Float64
        from telex_msgs.msg import TrackTeleopStatus

        self.robot = robot
        self.sent = []
        # another robot's, with a clock of its own; the topic is shared
        self.other = rospy.Publisher("joint_states", JointState, queue_size=10)
        status = []
        rospy.Subscriber("track_teleop/status", TrackTeleopStatus, status.append)
        self.twists = rospy.Publisher("track_teleop/cmd_vel", Twist, queue_size=10)
        self.speed = rospy.Publisher("track_teleop/speed_scale", Float64, queue_size=10)
        rospy.Subscriber(
            "track_controller/cmd_vel",
            Twist,
            lambda message: self.sent.append((self.robot.sim_time, message)),
        )
        wait_for(
            lambda: self.twists.get_num_connections() and self.speed.get_num_connections(),
            "track_teleop",
        )
        wait_until_listening(status)

    def run(self):
        from geometry_msgs.msg import Twist, Vector3
        from std_msgs.msg import Float64

        bad = Twist(linear=Vector3(x=float("nan")))
        repeat(self.twists, bad, 0.3)
        time.sleep(0.2)
        results = {"bad_messages": len(self.sent)}
        self.speed.publish(Float64(0.5))
        time.sleep(0.1)
        repeat(self.twists, Twist(linear=Vector3(x=2.0, y=1.0), angular=Vector3(z=-0.5)), 1.2)
        last = self.robot.sim_time
        driven = [message for moment, message in self.sent if moment > last - 1.0]
        results["count"] = len(driven)
        results["linear"] = driven[-1].linear.x
        results["angular"] = driven[-1].angular.z
        time.sleep(0.8)
        stops = [moment for moment, message in self.sent if message == Twist()]
        results["stops"] = len(stops)
        results["stop_after"] = stops[0] - last
        before = len(self.sent)
        time.sleep(0.5)
        results["messages_later"] = len(self.sent) - before
        results["count_beside_others"] = self.drive_beside_others()
        return results

    def drive_beside_others(self):
        from geometry_msgs.msg import Twist, Vector3
        from sensor_msgs.msg import JointState

        with Held(self.other, JointState(name=["wheel_joint"], position=[0.0])):
            repeat(self.twists, Twist(linear=Vector3(x=0.5)), 1.2)
            last = self.robot.sim_time
        return len([m for moment, m in self.sent if moment > last - 1.0 and m != Twist()])


def main(role):
    """Play one drill and print its results."""
    import rospy
    import yaml

    drill_class, joints, name = {
        "arm": (ArmDrill, ARM, "arm_teleop"),
        "flippers": (FlipperDrill, FLIPPERS, "flipper_teleop"),
        "gripper": (GripperDrill, FINGERS, "gripper_teleop"),
        "tracks": (TrackDrill, {**ARM, BELT: ("continuous", 0.0, 0.0, 11.0)}, "track_teleop"),
    }[role]
    rospy.set_param("/use_sim_time", True)
    rospy.set_param("/telex/robot_description", description(joints))
    settings = yaml.safe_load((PACKAGE / "config" / f"{name}.yaml").read_text())
    if role == "flippers":
        settings.update(yaml.safe_load((PACKAGE / "config" / "flipper_presets.yaml").read_text()))
    rospy.set_param(f"/telex/{name}", settings)
    miss_nothing()
    rospy.init_node("drill", disable_signals=True)
    robot = FakeRobot(joints)
    node = Node(name)
    try:
        results = drill_class(robot, node).run()
    finally:
        robot.end()
        node.end()
    print(json.dumps(results))
    rospy.signal_shutdown("done")


if __name__ == "__main__":
    main(sys.argv[1])
