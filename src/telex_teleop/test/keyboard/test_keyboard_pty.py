"""The real keyboard_teleop in a pseudo terminal: bytes to messages, and the terminal given back."""

from __future__ import annotations

import contextlib
import fcntl
import os
import pty
import select
import signal
import statistics
import struct
import subprocess
import termios
import threading
import time
from pathlib import Path

import pytest
from fake_robot import gaps
from own_ros import NodeProcess, Topics, wait_until_connected
from waiting import wait_until

from telex_control.common.scheduling import may_come_first
from telex_experiments.rigs.private_master import free_port

pytestmark = pytest.mark.waiting

NODE = Path(__file__).parents[2] / "nodes" / "keyboard_teleop"
ROBOT = "/robot7"
TURRET = "turret_joint"
ARM = [
    TURRET,
    "shoulder_joint",
    "telescope_joint",
    "elbow_joint",
    "forearm_roll_joint",
    "wrist_pitch_joint",
    "gripper_roll_joint",
    "turret_camera_pan_joint",
    "turret_camera_tilt_joint",
]
PRESS_J = b"\x1b[106u"  # of a terminal with the protocol of kitty
RELEASE_J = b"\x1b[106;1:3u"
LOSE_FOCUS = b"\x1b[O"
PERIOD = 0.02  # s between two commands while a key is held
AT_ONCE = 5  # commands that may still move something when the operator has let go
HELD_UP = 0.05  # s without a command: the node or this process got no processor
FIRST_SPEED = 0.5  # scale


class Keyboard:
    """The node in a pseudo terminal, which ends with it (context manager)."""

    def __init__(self, environment):
        self.master, self.slave = pty.openpty()
        fcntl.ioctl(self.slave, termios.TIOCSWINSZ, struct.pack("HHHH", 30, 90, 0, 0))
        self.before = termios.tcgetattr(self.slave)
        self.shown = bytearray()
        self.answers_kitty = False
        self._asked = 0
        self._ended = False
        self.node = NodeProcess(
            [NODE, f"_robot:={ROBOT}"],
            environment,
            stdin=self.slave,
            stdout=self.slave,
            start_new_session=True,
        )
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        self.node.__exit__()
        self.hang_up()
        os.close(self.slave)

    def _read(self):
        while not self._ended:
            if select.select([self.master], [], [], 0.1)[0]:
                self.shown += os.read(self.master, 65536)
                asked, before = self.shown.count(b"\x1b[?u"), self._asked
                self._asked = asked
                if self.answers_kitty and asked > before:
                    os.write(self.master, b"\x1b[?15u")

    def type(self, data):
        """Send what a terminal sends of a key; when that was (s, as stamps have it)."""
        # Before the write: what it causes may be there before this process goes on.
        now = time.time()
        os.write(self.master, data)
        return now

    def repeat(self, data, count):
        """Send a key as a keyboard repeats it; when each was."""
        typed = []
        for _ in range(count):
            typed.append(self.type(data))
            time.sleep(0.033)
        return typed

    def wait_for(self, shown):
        wait_until(lambda: shown in self.shown, f"{shown!r} on the screen", 20.0)

    def become_kitty(self):
        """Answer as a terminal does that tells of releases, from now on."""
        self.type(b"\x1b[?0u")
        self.wait_for(b"\x1b[>15u\x1b[?u")  # it asks again
        self.type(b"\x1b[?15u")
        self.answers_kitty = True
        time.sleep(0.1)

    def hang_up(self):
        """Close the operator's side."""
        # the reader must be gone before the number of its file can be used again
        self._ended = True
        self._reader.join()
        if self.master is not None:
            os.close(self.master)
        self.master = None

    def is_restored(self):
        return termios.tcgetattr(self.slave) == self.before

    def shows_the_normal_screen(self):
        return self.shown.endswith(b"\x1b[?25h\x1b[?1049l")


class ListeningRobot:
    """A robot that only listens and reports, the speed as it was set."""

    def __init__(self, topics):
        from control_msgs.msg import JointJog
        from geometry_msgs.msg import Twist
        from std_msgs.msg import Bool, Float64
        from telex_msgs.msg import JointTeleopStatus, TrackTeleopStatus
        from telex_msgs.srv import SetMode

        self.jogs = []  # (time by the keyboard's stamp, node, joint to rate)
        self.twists = []  # (time of reception, [linear, angular])
        self.heard = time.monotonic()  # when the last of them came
        self.e_stops = []
        self.speeds = []
        self.modes = []
        self.listeners = [
            topics.subscriber(
                f"{node}_teleop/delta_joint_cmds", JointJog, self._on_jog, callback_args=node
            )
            for node in ("arm", "gripper", "flipper")
        ]
        self.e_stop = topics.subscriber("e_stop", Bool, lambda m: self.e_stops.append(m.data))
        self.listeners += [
            topics.subscriber("track_teleop/cmd_vel", Twist, self._on_twist),
            topics.subscriber("flipper_teleop/speed_scale", Float64, self._on_speed),
            self.e_stop,
        ]
        topics.service("arm_teleop/set_mode", SetMode, self._on_mode)
        speed = {"speed_scale": FIRST_SPEED, "min_speed_scale": 0.05, "max_speed_scale": 1.0}
        position = [1.0] + [0.0] * (len(ARM) - 1)
        arm = JointTeleopStatus(mode="JOINT", joint_names=ARM, position=position, **speed)
        self._reports = [
            (topics.publisher(f"{node}_teleop/status", type(message), queue_size=1), message)
            for node, message in (
                ("arm", arm),
                ("flipper", JointTeleopStatus(**speed)),
                ("gripper", JointTeleopStatus(**speed)),
                ("track", TrackTeleopStatus(**speed)),
            )
        ]
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._report, daemon=True)

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *exception):
        self._ended.set()
        self._thread.join()

    def _report(self):
        while not self._ended.wait(0.1):
            for publisher, message in self._reports:
                publisher.publish(message)

    def _on_jog(self, message, node):
        rates = dict(zip(message.joint_names, message.velocities))
        self.heard = time.monotonic()
        self.jogs.append((message.header.stamp.to_sec(), node, rates))

    def _on_twist(self, message):
        self.heard = time.monotonic()
        self.twists.append((time.time(), [message.linear.x, message.angular.z]))

    def _on_speed(self, message):
        self.speeds.append(message.data)
        self._set_speed(message.data)

    def _set_speed(self, scale):
        for _, report in self._reports:
            report.speed_scale = scale

    def _on_mode(self, request):
        from telex_msgs.srv import SetModeResponse

        self.modes.append(request.mode)
        return SetModeResponse(success=False, message="mode is not for sale")

    def first_zero(self):
        """When the first command of joints was sent that stops them."""

        def zeros():
            return [moment for moment, _, rates in [*self.jogs] if not any(rates.values())]

        return wait_until(zeros, "a command that stops the joints")[0]

    def wait_until_still(self, duration=0.3):
        """Wait until no command has come for a while (s)."""
        asked = time.monotonic()

        def still():
            return time.monotonic() - max(asked, self.heard) > duration

        wait_until(still, "no more commands")

    def moving(self, node="arm"):
        """When each command was sent that moves joints of a node."""
        return [stamp for stamp, of, rates in [*self.jogs] if of == node and any(rates.values())]

    def stopped(self):
        """How many joints of each node its last stop was for."""
        return {node: len(rates) for _, node, rates in [*self.jogs] if not any(rates.values())}

    def still_moving(self, released):
        """Commands that move joints although the operator has let go; none follows a stop."""
        self.first_zero()
        self.wait_until_still()
        # Each node hears its commands in their order; those of two nodes may overtake each other.
        stopped = set()
        for _, node, rates in self.jogs:
            moves = any(rates.values())
            assert not (moves and node in stopped)
            if not moves:
                stopped.add(node)
        return [stamp for stamp in self.moving() if stamp > released]

    def forget(self):
        for said in (self.jogs, self.twists, self.e_stops, self.speeds, self.modes):
            said.clear()
        self._set_speed(FIRST_SPEED)


@pytest.fixture(scope="module")
def _coming_first():
    """Let this process come before all others.

    What is judged here is whether the node answers at once, not what else the machine does.
    """
    if not may_come_first(1):
        yield
        return
    set_scheduler(os.SCHED_RR, 1)
    yield
    set_scheduler(os.SCHED_OTHER, 0)


def set_scheduler(policy, priority):
    """Set how all threads of this process are scheduled."""
    for thread in os.listdir("/proc/self/task"):
        with contextlib.suppress(ProcessLookupError):
            os.sched_setscheduler(int(thread), policy, os.sched_param(priority))


@pytest.fixture(scope="module")
def robot(master, _coming_first):
    with Topics(ROBOT) as topics, ListeningRobot(topics) as made:
        yield made


@pytest.fixture
def start(master, robot):
    """Starts the node in a pseudo terminal, which is there once the node is connected."""
    with contextlib.ExitStack() as keyboards:

        def start():
            keyboard = keyboards.enter_context(Keyboard(master))
            keyboard.wait_for(b"READY")
            wait_until_connected(*robot.listeners)
            time.sleep(0.2)
            return keyboard

        robot.forget()
        yield start


@pytest.fixture(scope="class")
def started(master, robot):
    """A keyboard of a plain terminal that several tests use."""
    with Keyboard(master) as keyboard:
        keyboard.wait_for(b"READY")
        wait_until_connected(*robot.listeners)
        yield keyboard


@pytest.fixture
def keyboard(started, robot):
    robot.wait_until_still()
    robot.forget()
    return started


@pytest.fixture(scope="class")
def started_kitty(master, robot):
    """A keyboard of a terminal with the protocol of kitty that several tests use."""
    with Keyboard(master) as keyboard:
        keyboard.wait_for(b"READY")
        wait_until_connected(*robot.listeners)
        keyboard.become_kitty()
        yield keyboard


@pytest.fixture
def kitty(started_kitty, robot):
    started_kitty.answers_kitty = True
    robot.wait_until_still()
    robot.forget()
    return started_kitty


@pytest.mark.ros
class TestPlainTerminal:
    def test_press_is_a_nudge_that_ends_with_zero(self, keyboard, robot):
        for _ in range(5):
            robot.forget()
            pressed = keyboard.type(b"j")
            robot.first_zero()
            robot.wait_until_still()
            moments, rates = [jog[0] for jog in robot.jogs], [jog[2] for jog in robot.jogs]
            if max(gaps([pressed, *moments])) < HELD_UP:
                break
        assert rates[0] == {TURRET: 100.0}
        assert rates[-1] == {TURRET: 0.0}
        assert 0.1 <= moments[-1] - moments[0] <= 0.35
        assert median_period(moments) < 1.5 * PERIOD

    def test_repeating_key_drives_without_gaps(self, keyboard, robot):
        keyboard.type(b"w")
        wait_until(lambda: robot.twists[-1][1] == [0.0, 0.0], "the end of the first press")
        robot.wait_until_still()
        typed, moments = [], []
        for _ in range(5):
            robot.twists.clear()
            typed = keyboard.repeat(b"w", 20)
            wait_until(lambda: robot.twists[-1][1] == [0.0, 0.0], "the stop")
            robot.wait_until_still()
            moments = [moment for moment, _ in robot.twists]
            # Where the node or this process was held up there are gaps, and the key may time out.
            if max(gaps(typed) + gaps(moments)) < 0.1:
                break
        moving, stopped = len(moments) - 1, moments[-1]
        assert [velocity for _, velocity in robot.twists] == [[1.2, 0.0]] * moving + [[0.0, 0.0]]
        # A key that is typed lets the node wait for a period anew: there is a command for each.
        assert median_period(moments) < 1.5 * median_period(typed)
        assert moving * PERIOD > 0.5 * (typed[-1] - typed[0])
        # held from the first repeat until key_timeout after the last one
        assert stopped - typed[-1] >= 0.2
        assert moving * PERIOD <= typed[-1] - typed[0] + 0.2 + 0.25

    def test_space_stops_everything_at_once(self, keyboard, robot):
        keyboard.type(b"j")
        time.sleep(0.03)
        keyboard.type(b"j")
        wait_until(robot.moving, "a command that moves a joint")
        robot.jogs.clear()
        pressed = keyboard.type(b" ")
        joints = {"arm": 9, "gripper": 1, "flipper": 4}
        wait_until(lambda: robot.stopped() == joints, robot.stopped)
        assert len(robot.still_moving(pressed)) < AT_ONCE

    def test_e_stop_needs_no_master_when_it_is_pressed(self, keyboard, robot):
        assert robot.e_stop.get_num_connections() > 0
        assert robot.e_stops == []

    def test_e_stop_and_its_release(self, keyboard, robot):
        keyboard.shown.clear()
        keyboard.type(b"\x1b")
        keyboard.wait_for(b"E-STOP IS ACTIVE")
        time.sleep(0.5)
        keyboard.shown.clear()
        keyboard.type(b"\x12")
        keyboard.wait_for(b"READY")
        wait_until(lambda: robot.e_stops[1:], "the release")
        assert robot.e_stops == [True, False]

    def test_speed(self, keyboard, robot):
        for count in (1, 2):
            keyboard.type(b"-")
            wait_until(lambda count=count: robot.speeds[count - 1 :], "the speed")
            time.sleep(0.25)
        assert robot.speeds == pytest.approx([0.4, 0.3])

    def test_refused_mode_is_told(self, keyboard, robot):
        keyboard.type(b"\t")
        keyboard.wait_for(b"mode is not for sale")
        assert robot.modes == ["CARTESIAN"]


@pytest.mark.ros
class TestKittyTerminal:
    def test_is_exact(self, kitty, robot):
        for _ in range(5):
            robot.forget()
            pressed = kitty.type(PRESS_J)
            time.sleep(0.8)
            released = kitty.type(RELEASE_J)
            late, moving = robot.still_moving(released), robot.moving()
            if max(gaps([pressed, *moving, released])) < HELD_UP:
                break
        assert len(late) < AT_ONCE
        assert robot.first_zero() > released
        assert moving[-1] - moving[0] == pytest.approx(released - pressed, abs=0.15)
        assert median_period(moving) < 1.5 * PERIOD

    def test_lost_focus_stops(self, kitty, robot):
        kitty.type(PRESS_J)
        wait_until(robot.moving, "a command that moves a joint")
        lost = kitty.type(LOSE_FOCUS)
        assert len(robot.still_moving(lost)) < AT_ONCE
        assert robot.first_zero() > lost

    def test_dead_line_stops(self, kitty, robot):
        kitty.answers_kitty = False
        time.sleep(0.3)
        robot.jogs.clear()
        pressed = kitty.type(PRESS_J)
        assert robot.first_zero() - pressed >= 0.35
        assert len(robot.moving()) * PERIOD <= 0.7
        kitty.answers_kitty = True
        kitty.type(RELEASE_J)


@pytest.mark.ros
class TestEnd:
    @pytest.mark.parametrize("way", ["ctrl+c", "SIGTERM", "SIGINT", "hang-up"])
    def test_ends_with_zeros_and_restores_the_terminal(self, start, robot, way):
        keyboard = start()
        assert_screen(keyboard.shown.decode())
        if way == "SIGTERM":
            keyboard.become_kitty()
        keyboard.type(b"\x1b[106;1:1u")  # held, on any terminal
        wait_until(robot.moving, "a command that moves a joint")
        if way == "ctrl+c":
            keyboard.type(b"\x03")
        elif way == "hang-up":
            keyboard.hang_up()
        else:
            keyboard.node.process.send_signal(getattr(signal, way))
        assert keyboard.node.process.wait(10.0) == 0
        wait_until(lambda: robot.jogs[-1][2] == {TURRET: 0.0}, "the stop")
        if way != "hang-up":
            assert keyboard.is_restored()
            wait_until(keyboard.shows_the_normal_screen)
        if way == "SIGTERM":
            assert b"\x1b[<u" in keyboard.shown  # the protocol of kitty is given back


@pytest.mark.ros
def test_status_of_the_simulator_tells_whether_the_e_stop_holds(start):
    """Tell of an e-stop that nobody's message told of, then of its release."""
    keyboard = start()  # of its own: once it is told by the status, it believes no other release
    from std_msgs.msg import Bool
    from telex_msgs.msg import SimStatus

    with Topics(ROBOT) as topics:
        status = topics.publisher("sim/status", SimStatus, queue_size=1, latch=True)
        other = topics.publisher("e_stop", Bool, queue_size=1, latch=True)
        wait_until_connected(status, other)
        keyboard.shown.clear()
        status.publish(SimStatus(e_stop=True))
        keyboard.wait_for(b"E-STOP IS ACTIVE")
        keyboard.shown.clear()
        other.publish(Bool(False))
        time.sleep(1.0)
        assert b"READY" not in keyboard.shown
        keyboard.shown.clear()
        status.publish(SimStatus(e_stop=False))
        keyboard.wait_for(b"READY")


def median_period(stamps):
    """Time (s) from one command to the next, whatever held a few of them up."""
    return statistics.median(gaps(stamps))


def assert_screen(shown):
    for word in ("TELEX KEYBOARD", "robot /robot7", "speed 50 %", "+57.3 deg", "space: stop"):
        assert word in shown


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
