"""The real keyboard_teleop in a pseudo terminal: bytes to messages, and the terminal given back.

As in test_teleop_ros.py, this file run as a program plays the drill and prints what it saw as JSON.
"""

from __future__ import annotations

import contextlib
import fcntl
import json
import os
import pty
import select
import signal
import struct
import subprocess
import sys
import termios
import threading
import time
from pathlib import Path

import pytest
from teleop_drill import wait_for

from telex_control.common.scheduling import may_come_first
from telex_control.ros.rospy_fixes.connecting import miss_nothing
from telex_experiments.rigs.private_master import PrivateMaster, free_port

NODE = Path(__file__).parents[1] / "nodes" / "keyboard_teleop"
ROBOT = "/robot7"
ARM = [
    "turret_joint",
    "shoulder_joint",
    "telescope_joint",
    "elbow_joint",
    "forearm_roll_joint",
    "wrist_pitch_joint",
    "gripper_roll_joint",
    "turret_camera_pan_joint",
    "turret_camera_tilt_joint",
]


# ---------------------------------------------------------------- the tests


@pytest.fixture(scope="module")
def master():
    """Environment of a roscore on a free port."""
    with PrivateMaster() as master:
        yield master.environment()


@pytest.fixture(scope="module")
def drill(master):
    # What is judged here is whether the node answers at once, not what else the machine does.
    first = ("chrt", "--rr", "1") if may_come_first(1) else ()
    done = subprocess.run(
        [*first, sys.executable, __file__],
        env=master,
        capture_output=True,
        text=True,
        timeout=120.0,
        check=False,
    )
    assert done.returncode == 0, done.stdout[-4000:] + done.stderr[-4000:]
    return json.loads(done.stdout.splitlines()[-1])


def run_node(environment, **arguments):
    return subprocess.run(
        [str(NODE)],
        env=environment,
        capture_output=True,
        text=True,
        timeout=30.0,
        check=False,
        **arguments,
    )


@pytest.mark.ros
class TestKeyboard:
    def test_press_is_a_nudge_that_ends_with_zero(self, drill):
        nudge = drill["nudge"]
        assert nudge["first"] == {"turret_joint": 100.0}
        assert nudge["last"] == {"turret_joint": 0.0}
        assert 0.1 <= nudge["duration"] <= 0.35
        assert nudge["count"] >= 5

    def test_repeating_key_drives_without_gaps(self, drill):
        drive = drill["drive"]
        assert drive["first"] == [1.2, 0.0]
        assert drive["last"] == [0.0, 0.0]
        assert drive["zeros"] == 1
        # held from the first repeat until key_timeout after the last one
        assert 0.6 <= drive["duration"] <= 1.1

    def test_space_stops_everything_at_once(self, drill):
        assert drill["space"]["delay"] < 0.1
        assert drill["space"]["joints"] == {"arm": 9, "gripper": 1, "flipper": 4}
        assert drill["space"]["later"] == []

    def test_e_stop_needs_no_master_when_it_is_pressed(self, drill):
        assert drill["e_stop_connected"]
        assert drill["e_stop_before_the_press"] == []

    def test_status_of_the_simulator_tells_whether_the_e_stop_holds(self, drill):
        assert drill["told"] == {"stopped": True, "still_stopped": True, "released": True}

    def test_e_stop_and_its_release(self, drill):
        assert drill["e_stop"] == [True, False]

    def test_speed(self, drill):
        assert drill["speed"] == pytest.approx([0.4, 0.3])

    def test_refused_mode_is_told(self, drill):
        assert drill["mode"] == {"asked": ["CARTESIAN"], "told": True}

    def test_screen(self, drill):
        for word in ("TELEX KEYBOARD", "robot /robot7", "speed 50 %", "+57.3 deg", "space: stop"):
            assert word in drill["screen"]

    def test_kitty_terminal_is_exact(self, drill):
        kitty = drill["kitty"]
        assert kitty["asked_again"]
        assert kitty["held_for"] == pytest.approx(0.8, abs=0.15)
        assert kitty["largest_gap"] < 0.15
        assert kitty["release_delay"] < 0.1
        assert kitty["popped"]

    def test_lost_focus_stops(self, drill):
        assert drill["focus_delay"] < 0.1

    def test_dead_line_stops(self, drill):
        assert 0.35 <= drill["dead_line_delay"] <= 0.7

    @pytest.mark.parametrize("way", ["ctrl+c", "SIGTERM", "SIGINT", "hang-up"])
    def test_ends_with_zeros(self, drill, way):
        assert drill["ends"][way]["status"] == 0
        assert drill["ends"][way]["last"] == {"turret_joint": 0.0}

    @pytest.mark.parametrize("way", ["ctrl+c", "SIGTERM", "SIGINT"])
    def test_restores_the_terminal(self, drill, way):
        end = drill["ends"][way]
        assert end["restored"]
        assert end["normal_screen"]


@pytest.mark.ros
def test_without_a_terminal_it_says_what_to_do(master):
    done = run_node(master, stdin=subprocess.DEVNULL)
    assert done.returncode == 1
    assert "needs a terminal" in done.stderr
    assert "Traceback" not in done.stderr


def test_without_a_master_it_says_what_to_do():
    done = run_node(dict(os.environ, ROS_MASTER_URI=f"http://127.0.0.1:{free_port()}"))
    assert done.returncode == 1
    assert "no ROS master" in done.stderr
    assert "Traceback" not in done.stderr


def test_usage():
    done = subprocess.run(
        [str(NODE), "--help"], capture_output=True, text=True, timeout=30.0, check=False
    )
    assert done.returncode == 0
    assert "_robot:=/telex" in done.stdout


# ---------------------------------------------------------------- the drill


class Keyboard:
    """The node in a pseudo terminal."""

    def __init__(self):
        self.master, self.slave = pty.openpty()
        fcntl.ioctl(self.slave, termios.TIOCSWINSZ, struct.pack("HHHH", 30, 90, 0, 0))
        self.before = termios.tcgetattr(self.slave)
        self.shown = bytearray()
        self.answers_kitty = False
        self._asked = 0
        self._ended = False
        self.process = subprocess.Popen(
            [str(NODE), f"_robot:={ROBOT}"],
            stdin=self.slave,
            stdout=self.slave,
            stderr=sys.stderr,
            start_new_session=True,
        )
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self):
        while not self._ended:
            if select.select([self.master], [], [], 0.1)[0]:
                self.shown += os.read(self.master, 65536)
                asked, before = self.shown.count(b"\x1b[?u"), self._asked
                self._asked = asked
                if self.answers_kitty and asked > before:
                    os.write(self.master, b"\x1b[?15u")

    def type(self, data):
        # Before the write: what it causes may be there before this process goes on.
        now = time.monotonic()
        os.write(self.master, data)
        return now

    def wait_for(self, shown, timeout=20.0):
        wait_for(lambda: shown in self.shown, f"{shown!r} on the screen", timeout)

    def hang_up(self):
        """Close the operator's side."""
        # the reader must be gone before the number of its file can be used again
        self._ended = True
        self._reader.join()
        if self.master is not None:
            os.close(self.master)
        self.master = None

    def end(self):
        """Return the exit status and whether the terminal is as it was."""
        status = self.process.wait(10.0)
        restored = self.master is not None and termios.tcgetattr(self.slave) == self.before
        time.sleep(0.2)
        self.hang_up()
        os.close(self.slave)
        return status, restored


class Drill:
    """A robot that only listens and reports, and the operator's fingers."""

    def __init__(self):
        import rospy
        from control_msgs.msg import JointJog
        from geometry_msgs.msg import Twist
        from std_msgs.msg import Bool, Float64
        from telex_msgs.msg import JointTeleopStatus, TrackTeleopStatus
        from telex_msgs.srv import SetMode

        self.jogs = []  # (time, node, joint to rate)
        self.twists = []  # (time, [linear, angular])
        self.e_stops = []
        self.speeds = []
        self.modes = []
        self.listeners = [
            rospy.Subscriber(
                f"{ROBOT}/{node}_teleop/delta_joint_cmds", JointJog, self._on_jog, node
            )
            for node in ("arm", "gripper", "flipper")
        ]
        self.listeners += [
            rospy.Subscriber(f"{ROBOT}/track_teleop/cmd_vel", Twist, self._on_twist),
            rospy.Subscriber(f"{ROBOT}/e_stop", Bool, lambda m: self.e_stops.append(m.data)),
            rospy.Subscriber(
                f"{ROBOT}/flipper_teleop/speed_scale",
                Float64,
                lambda m: self.speeds.append(m.data),
            ),
        ]
        rospy.Service(f"{ROBOT}/arm_teleop/set_mode", SetMode, self._on_mode)
        self.status = JointTeleopStatus(
            mode="JOINT",
            speed_scale=0.5,
            min_speed_scale=0.05,
            max_speed_scale=1.0,
            joint_names=ARM,
            position=[1.0] + [0.0] * (len(ARM) - 1),
        )
        self.track_status = TrackTeleopStatus(speed_scale=0.5, min_speed_scale=0.05)
        self.publishers = [
            (rospy.Publisher(f"{ROBOT}/{node}_teleop/status", kind, queue_size=1), message)
            for node, kind, message in (
                ("arm", JointTeleopStatus, self.status),
                ("flipper", JointTeleopStatus, JointTeleopStatus(**self._speed())),
                ("gripper", JointTeleopStatus, JointTeleopStatus(**self._speed())),
                ("track", TrackTeleopStatus, TrackTeleopStatus(**self._speed())),
            )
        ]
        threading.Thread(target=self._report, daemon=True).start()

    @staticmethod
    def _speed():
        return {"speed_scale": 0.5, "min_speed_scale": 0.05, "max_speed_scale": 1.0}

    def _report(self):
        while True:
            for publisher, message in self.publishers:
                publisher.publish(message)
            time.sleep(0.1)

    def _on_jog(self, message, node):
        rates = dict(zip(message.joint_names, message.velocities))
        self.jogs.append((time.monotonic(), node, rates))

    def _on_twist(self, message):
        self.twists.append((time.monotonic(), [message.linear.x, message.angular.z]))

    def _on_mode(self, request):
        from telex_msgs.srv import SetModeResponse

        self.modes.append(request.mode)
        return SetModeResponse(success=False, message="mode is not for sale")

    def start(self):
        keyboard = Keyboard()
        keyboard.wait_for(b"READY")
        wait_for(lambda: all(s.get_num_connections() for s in self.listeners[:4]), "connections")
        time.sleep(0.2)
        return keyboard

    def run(self):
        results = {"ends": {}}
        keyboard = self.start()
        results.update(self.before_the_e_stop())
        results["screen"] = keyboard.shown.decode()
        results["nudge"] = self.nudge(keyboard)
        results["drive"] = self.drive(keyboard)
        results["space"] = self.space(keyboard)
        results["e_stop"] = self.e_stop(keyboard)
        results["speed"] = self.speed(keyboard)
        results["mode"] = self.mode(keyboard)
        results["told"] = self.told_by_status(keyboard)
        results["ends"]["ctrl+c"] = self.end(keyboard, lambda: keyboard.type(b"\x03"))
        keyboard = self.start()
        results["kitty"] = self.kitty(keyboard)
        results["focus_delay"] = self.lose_focus(keyboard)
        results["dead_line_delay"] = self.lose_the_line(keyboard)
        results["ends"]["SIGTERM"] = self.end(keyboard, keyboard.process.terminate)
        results["kitty"]["popped"] = b"\x1b[<u" in keyboard.shown
        for way, end in (
            ("SIGINT", lambda k: k.process.send_signal(signal.SIGINT)),
            ("hang-up", Keyboard.hang_up),
        ):
            keyboard = self.start()
            results["ends"][way] = self.end(keyboard, lambda k=keyboard, end=end: end(k))
        return results

    def nudge(self, keyboard):
        self.jogs.clear()
        keyboard.type(b"j")
        time.sleep(0.6)
        moments, rates = [jog[0] for jog in self.jogs], [jog[2] for jog in self.jogs]
        return {
            "first": rates[0],
            "last": rates[-1],
            "count": len(rates),
            "duration": moments[-1] - moments[0],
        }

    def drive(self, keyboard):
        keyboard.type(b"w")
        time.sleep(0.4)
        self.twists.clear()
        for _ in range(20):
            keyboard.type(b"w")
            time.sleep(0.033)
        time.sleep(0.6)
        velocities = [velocity for _, velocity in self.twists]
        return {
            "first": velocities[0],
            "last": velocities[-1],
            "zeros": velocities.count([0.0, 0.0]),
            "duration": self.twists[-1][0] - self.twists[0][0],
        }

    def space(self, keyboard):
        keyboard.type(b"j")
        time.sleep(0.03)
        keyboard.type(b"j")
        time.sleep(0.05)
        self.jogs.clear()
        pressed = keyboard.type(b" ")
        time.sleep(0.4)
        stops = [jog for jog in self.jogs if jog[0] > pressed and not any(jog[2].values())]
        first = stops[0][0]
        # Each node hears its commands in their order; those of two nodes may overtake each other.
        of_node = {node: moment for moment, node, _ in reversed(stops)}
        return {
            "delay": first - pressed,
            "joints": {node: len(rates) for moment, node, rates in stops if moment < first + 0.1},
            "later": [
                jog
                for jog in self.jogs
                if jog[0] > of_node.get(jog[1], first) and any(jog[2].values())
            ],
        }

    def e_stop(self, keyboard):
        keyboard.type(b"\x1b")
        time.sleep(1.0)
        keyboard.type(b"\x12")
        time.sleep(0.5)
        return list(self.e_stops)

    def speed(self, keyboard):
        keyboard.type(b"-")
        time.sleep(0.25)
        keyboard.type(b"-")
        time.sleep(0.25)
        return self.speeds

    def mode(self, keyboard):
        keyboard.type(b"\t")
        with contextlib.suppress(TimeoutError):
            keyboard.wait_for(b"mode is not for sale", 3.0)
        return {"asked": self.modes, "told": b"mode is not for sale" in keyboard.shown}

    def kitty(self, keyboard):
        keyboard.type(b"\x1b[?0u")
        again = b"\x1b[>15u\x1b[?u"
        with contextlib.suppress(TimeoutError):
            keyboard.wait_for(again, 3.0)
        keyboard.type(b"\x1b[?15u")
        keyboard.answers_kitty = True
        time.sleep(0.1)
        self.jogs.clear()
        keyboard.type(b"\x1b[106u")
        time.sleep(0.8)
        released = keyboard.type(b"\x1b[106;1:3u")
        time.sleep(0.3)
        moving = [moment for moment, _, rates in self.jogs if any(rates.values())]
        zero = self.first_zero()
        return {
            "asked_again": again in keyboard.shown,
            "held_for": moving[-1] - moving[0],
            "largest_gap": max(b - a for a, b in zip(moving, moving[1:])),
            "release_delay": zero - released,
        }

    def lose_focus(self, keyboard):
        keyboard.type(b"\x1b[106u")
        time.sleep(0.3)
        self.jogs.clear()
        lost = keyboard.type(b"\x1b[O")
        time.sleep(0.3)
        return self.first_zero() - lost

    def lose_the_line(self, keyboard):
        keyboard.answers_kitty = False
        time.sleep(0.3)
        self.jogs.clear()
        pressed = keyboard.type(b"\x1b[106u")
        time.sleep(1.0)
        return self.first_zero() - pressed

    def first_zero(self):
        return next(moment for moment, _, rates in self.jogs if not any(rates.values()))

    def before_the_e_stop(self):
        e_stop = self.listeners[4]
        with contextlib.suppress(TimeoutError):
            wait_for(e_stop.get_num_connections, "the publisher of e_stop", 5.0)
        return {
            "e_stop_connected": e_stop.get_num_connections() > 0,
            "e_stop_before_the_press": list(self.e_stops),
        }

    def told_by_status(self, keyboard):
        """Tell of an e-stop that nobody's message told of, then of its release."""
        import rospy
        from std_msgs.msg import Bool
        from telex_msgs.msg import SimStatus

        status = rospy.Publisher(f"{ROBOT}/sim/status", SimStatus, queue_size=1, latch=True)
        other = rospy.Publisher(f"{ROBOT}/e_stop", Bool, queue_size=1, latch=True)
        wait_for(lambda: status.get_num_connections() and other.get_num_connections(), "keyboard")

        def says(word, message, publisher):
            keyboard.shown.clear()
            publisher.publish(message)
            with contextlib.suppress(TimeoutError):
                keyboard.wait_for(word, 1.0)
            return word in keyboard.shown

        stopped = says(b"E-STOP IS ACTIVE", SimStatus(e_stop=True), status)
        still = not says(b"READY", Bool(False), other)
        released = says(b"READY", SimStatus(e_stop=False), status)
        status.unregister()
        other.unregister()
        return {"stopped": stopped, "still_stopped": still, "released": released}

    def end(self, keyboard, do):
        keyboard.type(b"\x1b[106;1:1u")  # held, on any terminal
        time.sleep(0.2)
        do()
        status, restored = keyboard.end()
        return {
            "status": status,
            "restored": restored,
            "last": self.jogs[-1][2],
            "normal_screen": keyboard.shown.endswith(b"\x1b[?25h\x1b[?1049l"),
        }


def main():
    """Play the drill and print its results."""
    import rospy

    miss_nothing()
    rospy.init_node("drill", disable_signals=True)
    results = Drill().run()
    print(json.dumps(results))
    rospy.signal_shutdown("done")


if __name__ == "__main__":
    main()
