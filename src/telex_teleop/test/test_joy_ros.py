"""The real joy_teleop and joy: messages of a gamepad in, commands of a robot out.

As in test_teleop_ros.py, this file run as a program plays the drill and prints what it saw as JSON.
"""

from __future__ import annotations

import contextlib
import json
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import pytest
from teleop_drill import wait_for

from telex_control.ros.rospy_fixes.connecting import miss_nothing
from telex_experiments.rigs.private_master import PrivateMaster

NODES = Path(__file__).parents[1] / "nodes"
ROBOT = "/robot7"
BUTTONS = {"south": 0, "left_bumper": 4, "back": 6, "start": 7, "left_stick": 9}


# ---------------------------------------------------------------- the tests


@pytest.fixture(scope="module")
def drill():
    with PrivateMaster() as master:
        done = subprocess.run(
            [sys.executable, __file__],
            env=master.environment(),
            capture_output=True,
            text=True,
            timeout=240.0,
            check=False,
        )
    assert done.returncode == 0, done.stdout[-4000:] + done.stderr[-4000:]
    return json.loads(done.stdout.splitlines()[-1])


@pytest.mark.ros
class TestJoyTeleop:
    def test_recognizes_the_pad_by_its_device(self, drill):
        assert "pad xbox" in drill["log"]
        assert drill["modes"][0] == "DRIVE"

    def test_what_is_held_at_the_start_moves_nothing(self, drill):
        assert drill["at_start"] == []
        assert "let go first, nothing moves by it: left_stick_y" in drill["log"]

    def test_drives_as_far_as_the_stick_is_pushed(self, drill):
        assert drill["full"] == pytest.approx([1.2, 0.0])
        part = 0.6 * 0.5 + 0.4 * 0.5**3  # half of the way between deadzone and end, with expo 0.4
        assert drill["half"] == pytest.approx([1.2 * part, 0.0])

    @pytest.mark.parametrize("end", ["silence", "enable", "SIGTERM"])
    def test_ends_with_zero(self, drill, end):
        assert drill["ends"][end] == [0.0, 0.0]

    def test_after_silence_it_needs_the_centre(self, drill):
        assert drill["after_silence"] == []
        assert "no joy message for 0.3 s: stopped" in drill["log"]

    def test_wrong_messages_move_nothing_and_are_told(self, drill):
        assert drill["wrong"] == []
        assert "axes[1] is nan" in drill["log"]
        assert "axes has 2 values" in drill["log"]

    def test_modes(self, drill):
        assert drill["modes"] == ["DRIVE", "JOINT", "CARTESIAN"]
        assert drill["asked"] == ["CARTESIAN"]

    def test_a_joint_turns_at_a_share_of_what_its_node_says(self, drill):
        assert drill["turret"] == pytest.approx({"turret_joint": 0.5})

    def test_e_stop_and_its_release(self, drill):
        assert drill["e_stop"] == [True, False]

    def test_speed(self, drill):
        assert drill["speed"] == pytest.approx(0.4)

    def test_statuses(self, drill):
        assert drill["status"] == {"joy_teleop": 0, "joy": 0}

    def test_the_source_waits_for_its_device(self, drill):
        assert "/nowhere/js0 cannot be opened: No such file" in drill["source_log"]
        assert "Traceback" not in drill["source_log"]


# ---------------------------------------------------------------- the drill


def _numbers(command):
    return command.values() if isinstance(command, dict) else command


class Node:
    """A node of this package, and what it says."""

    def __init__(self, said, name, *arguments):
        self._said = said
        self.process = subprocess.Popen(
            [str(NODES / name), f"__ns:={ROBOT}", *arguments],
            stdout=self._said,
            stderr=subprocess.STDOUT,
        )

    @property
    def said(self):
        self._said.seek(0)
        return self._said.read().decode()

    def end(self):
        self.process.terminate()
        return self.process.wait(15.0)


class Drill:
    """A robot that only listens and reports, and a gamepad that is played on."""

    def __init__(self):
        import rospy
        from control_msgs.msg import JointJog
        from geometry_msgs.msg import Twist
        from sensor_msgs.msg import Joy
        from std_msgs.msg import Bool, Float64, String
        from telex_msgs.msg import JointTeleopStatus, TrackTeleopStatus
        from telex_msgs.srv import SetMode

        self.message = Joy
        self.twists, self.jogs, self.e_stops, self.speeds, self.modes, self.asked = (
            [] for _ in range(6)
        )
        heard = (
            ("track_teleop/cmd_vel", Twist, self._on_twist),
            ("arm_teleop/delta_joint_cmds", JointJog, self._on_jog),
            ("e_stop", Bool, lambda m: self.e_stops.append(m.data)),
            ("arm_teleop/speed_scale", Float64, lambda m: self.speeds.append(m.data)),
            ("joy_teleop/mode", String, lambda m: self.modes.append(m.data)),
        )
        self.listeners = [rospy.Subscriber(f"{ROBOT}/{n}", kind, cb) for n, kind, cb in heard]
        rospy.Service(f"{ROBOT}/arm_teleop/set_mode", SetMode, self._on_mode)
        speed = {"speed_scale": 0.5, "min_speed_scale": 0.05, "max_speed_scale": 1.0}
        self.arm = JointTeleopStatus(
            mode="JOINT", joint_names=["turret_joint"], max_velocity=[0.5], **speed
        )
        tracks = TrackTeleopStatus(max_linear=1.2, max_angular=1.0, **speed)
        self.reports = [
            (rospy.Publisher(f"{ROBOT}/{name}_teleop/status", type(m), queue_size=1), m)
            for name, m in (("arm", self.arm), ("track", tracks))
        ]
        self.device = rospy.Publisher(f"{ROBOT}/joy_device", String, queue_size=1, latch=True)
        self.joy = rospy.Publisher(f"{ROBOT}/joy", Joy, queue_size=10, tcp_nodelay=True)
        self.held = None
        threading.Thread(target=self._play, daemon=True).start()

    def _play(self):
        """Report what the robot does, and repeat what the hands hold."""
        while True:
            for publisher, message in self.reports:
                publisher.publish(message)
            held = self.held
            if held is not None:
                self.joy.publish(held)
            time.sleep(0.03)

    def hold(self, *buttons, x=0.0, y=0.0):
        """Hold the left stick (right and down positive) and buttons of an Xbox pad."""
        message = self.message(axes=[-x, -y, 1, 0, 0, 1, 0, 0], buttons=[0] * 11)
        for name in buttons:
            message.buttons[BUTTONS[name]] = 1
        self.held = message
        # at once: on a busy machine the thread that repeats it may come late, and miss a press
        self.joy.publish(message)
        time.sleep(0.05)

    def _on_twist(self, message):
        self.twists.append([message.linear.x, message.angular.z])

    def _on_jog(self, message):
        self.jogs.append(dict(zip(message.joint_names, message.velocities)))

    def _on_mode(self, request):
        from telex_msgs.srv import SetModeResponse

        self.asked.append(request.mode)
        self.arm.mode = request.mode
        return SetModeResponse(success=True)

    def run(self):
        results = {"ends": {}}
        with contextlib.ExitStack() as files:
            logs = [files.enter_context(tempfile.TemporaryFile()) for _ in range(2)]
            source = Node(logs[0], "joy", "_dev:=/nowhere/js0")
            node = Node(logs[1], "joy_teleop")
            for each in (source, node):
                # whatever goes wrong here, nothing is left behind
                files.callback(each.process.kill)
            wait_for(
                lambda: all(each.get_num_connections() for each in self.listeners), "connections"
            )
            self.hold("left_bumper", y=-1.0)
            self.device.publish("Microsoft X-Box 360 pad")
            wait_for(lambda: self.modes, "the mode")
            wait_for(lambda: "let go first" in node.said, "the hint")
            results["at_start"] = list(self.twists)
            results.update(self.drive(node, results["ends"]))
            results.update(self.work())
            results["e_stop"] = self.e_stop()
            self.push(self.twists, y=-1.0)
            status = node.end()
            wait_for(lambda: not any(self.twists[-1]), "the zero at the end")
            results["ends"]["SIGTERM"] = self.twists[-1]
            wait_for(lambda: "No such file" in source.said, "the source's complaint")
            results.update(
                asked=self.asked,
                log=node.said,
                source_log=source.said,
                status={
                    "joy_teleop": status,
                    "joy": source.end(),
                },
            )
        return results

    def push(self, said, **stick):
        """Push the stick until something moves; return what is said to it.

        As an operator would, from the centre again when nothing moves: on a busy machine the stream
        may have paused, which is a command to stop.
        """
        deadline = time.monotonic() + 60.0
        while time.monotonic() < deadline:
            self.hold("left_bumper")
            said.clear()
            self.hold("left_bumper", **stick)
            time.sleep(0.15)
            moving = [command for command in said if command and any(_numbers(command))]
            if moving:
                return moving[-1]
        raise TimeoutError(f"nothing moves by {stick}")

    def press(self, button, done, *held):
        """Press a button, while others are held, until something is done.

        Again after a while: a press that ends a pause of the stream does not count.
        """
        for _ in range(10):
            self.hold(*held)
            self.hold(button, *held)
            with contextlib.suppress(TimeoutError):
                wait_for(done, button, timeout=3.0)
                self.hold(*held)
                return
        raise TimeoutError(f"{button} has no effect")

    def drive(self, node, ends):
        results = {}
        results["full"] = self.push(self.twists, y=-1.0)
        results["half"] = self.push(self.twists, y=-0.56)
        self.held = None
        wait_for(lambda: not any(self.twists[-1]), "the zero after silence")
        ends["silence"] = self.twists[-1]
        self.twists.clear()
        self.hold("left_bumper", y=-1.0)
        time.sleep(0.1)
        results["after_silence"] = list(self.twists)
        self.push(self.twists, y=-1.0)
        self.hold(y=-1.0)
        wait_for(lambda: not any(self.twists[-1]), "the zero without the enable button")
        ends["enable"] = self.twists[-1]
        self.hold("left_bumper")
        self.twists.clear()
        for axes, says in (
            ([0, float("nan"), 1, 0, 0, 1, 0, 0], "axes[1] is nan"),
            ([0.0, 1.0], "axes has 2 values"),
        ):
            self.held = self.message(axes=axes, buttons=[0, 0, 0, 0, 1] + [0] * 6)
            wait_for(lambda says=says: says in node.said, says)
        results["wrong"] = list(self.twists)
        self.hold()
        return results

    def work(self):
        self.press("start", lambda: "JOINT" in self.modes)
        turret = self.push(self.jogs, x=-1.0)
        self.press("start", lambda: "CARTESIAN" in self.modes)
        wait_for(lambda: self.asked, "the arm's mode")
        self.press("south", lambda: self.speeds)
        modes = list(self.modes)
        self.press("start", lambda: "CAMERA" in self.modes)
        self.press("start", lambda: self.modes[-1] == "DRIVE")
        return {"turret": turret, "speed": self.speeds[0], "modes": modes}

    def e_stop(self):
        self.press("left_stick", lambda: True in self.e_stops)
        self.press("back", lambda: False in self.e_stops, "left_bumper")
        return [self.e_stops[0], self.e_stops[-1]]


if __name__ == "__main__":
    import rospy

    miss_nothing()
    rospy.init_node("drill", anonymous=True)
    print(json.dumps(Drill().run()))
