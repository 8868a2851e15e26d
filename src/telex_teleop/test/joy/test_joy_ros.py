"""The real joy_teleop and joy: messages of a gamepad in, commands of a robot out."""

from __future__ import annotations

import contextlib
import threading
import time
from pathlib import Path

import pytest
from own_ros import NodeProcess, Topics, wait_until_connected
from waiting import wait_until

pytestmark = [pytest.mark.ros, pytest.mark.waiting]

NODES = Path(__file__).parents[2] / "nodes"
ROBOT = "/robot7"
BUTTONS = {
    "south": 0,
    "left_bumper": 4,
    "right_bumper": 5,
    "back": 6,
    "start": 7,
    "left_stick": 9,
    "right_stick": 10,
}
MODES = ("DRIVE", "JOINT", "CARTESIAN", "CAMERA")  # in the order of the button


def numbers(command):
    return command.values() if isinstance(command, dict) else command


class Player:
    """A robot that only listens and reports, and a gamepad that is played on."""

    def __init__(self, topics):
        from control_msgs.msg import JointJog
        from geometry_msgs.msg import Twist
        from sensor_msgs.msg import Joy
        from std_msgs.msg import Bool, Float64, String
        from telex_msgs.msg import JointTeleopStatus, TrackTeleopStatus
        from telex_msgs.srv import Bookmark, Restore, SetMode

        self.message = Joy
        self.twists, self.jogs, self.e_stops, self.speeds, self.modes, self.asked, self.training = (
            [] for _ in range(7)
        )
        heard = (
            ("track_teleop/cmd_vel", Twist, self._on_twist),
            ("arm_teleop/delta_joint_cmds", JointJog, self._on_jog),
            ("e_stop", Bool, lambda m: self.e_stops.append(m.data)),
            ("arm_teleop/speed_scale", Float64, lambda m: self.speeds.append(m.data)),
            ("joy_teleop/mode", String, lambda m: self.modes.append(m.data)),
        )
        self.listeners = [topics.subscriber(*each) for each in heard]
        topics.service("arm_teleop/set_mode", SetMode, self._on_mode)
        topics.service("training/bookmark", Bookmark, self._training("bookmark"))
        topics.service("training/back", Restore, self._training("back"))
        speed = {"speed_scale": 0.5, "min_speed_scale": 0.05, "max_speed_scale": 1.0}
        self.arm = JointTeleopStatus(
            mode="JOINT", joint_names=["turret_joint"], max_velocity=[0.5], **speed
        )
        tracks = TrackTeleopStatus(max_linear=1.2, max_angular=1.0, **speed)
        self.reports = [
            (topics.publisher(f"{name}_teleop/status", type(m), queue_size=1), m)
            for name, m in (("arm", self.arm), ("track", tracks))
        ]
        self.device = topics.publisher("joy_device", String, queue_size=1, latch=True)
        self.joy = topics.publisher("joy", Joy)
        self.held = None
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._play, daemon=True)

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *exception):
        self._ended.set()
        self._thread.join()

    def _play(self):
        """Report what the robot does, and repeat what the hands hold."""
        while not self._ended.wait(0.03):
            for publisher, message in self.reports:
                publisher.publish(message)
            held = self.held
            if held is not None:
                self.joy.publish(held)

    def _on_twist(self, message):
        self.twists.append([message.linear.x, message.angular.z])

    def _on_jog(self, message):
        self.jogs.append(dict(zip(message.joint_names, message.velocities)))

    def _on_mode(self, request):
        from telex_msgs.srv import SetModeResponse

        self.asked.append(request.mode)
        self.arm.mode = request.mode
        return SetModeResponse(success=True)

    def _training(self, name):
        def answer(request):
            self.training.append((name, request.name))
            return {"success": True}

        return answer

    def plug_in(self):
        self.device.publish("Microsoft X-Box 360 pad")
        wait_until(lambda: self.modes, "the mode")

    def hold(self, *buttons, x=0.0, y=0.0):
        """Hold the left stick (right and down positive) and buttons of an Xbox pad."""
        message = self.message(axes=[-x, -y, 1, 0, 0, 1, 0, 0], buttons=[0] * 11)
        for name in buttons:
            message.buttons[BUTTONS[name]] = 1
        self.held = message
        # at once: on a busy machine the thread that repeats it may come late, and miss a press
        self.joy.publish(message)
        time.sleep(0.05)

    def push(self, said, **stick):
        """Push the stick until something moves; return what is said to it.

        As an operator would, from the centre again when nothing moves: on a busy machine the stream
        may have paused, which is a command to stop.
        """

        def try_it():
            self.hold("left_bumper")
            said.clear()
            self.hold("left_bumper", **stick)
            time.sleep(0.15)
            return [command for command in said if command and any(numbers(command))]

        return wait_until(try_it, f"something to move by {stick}", 60.0)[-1]

    def press(self, button, done, *held):
        """Press a button, while others are held, until something is done.

        Again after a while: a press that ends a pause of the stream does not count.
        """
        for _ in range(9):
            self.hold(*held)
            self.hold(button, *held)
            with contextlib.suppress(AssertionError):
                wait_until(done, button, 3.0)
                break
        wait_until(done, f"{button} to have an effect", 3.0)
        self.hold(*held)

    def select(self, mode):
        """Press the button of the modes until the gamepad has one of them."""
        while self.modes[-1] != mode:
            before = self.modes[-1]
            self.press("start", lambda before=before: self.modes[-1] != before)
            expected = MODES[(MODES.index(before) + 1) % len(MODES)]
            assert self.modes[-1] == expected

    def wait_until_stopped(self, what):
        wait_until(lambda: not any(self.twists[-1]), f"the zero {what}")
        assert self.twists[-1] == [0.0, 0.0]

    def reset(self):
        """Let the hands rest on a pad in mode DRIVE, without a memory of what was before."""
        self.hold()
        self.select("DRIVE")
        self.arm.mode = "JOINT"
        for said in (
            self.twists,
            self.jogs,
            self.e_stops,
            self.speeds,
            self.asked,
            self.training,
        ):
            said.clear()


def log_of(path):
    return path.read_text(errors="replace")


@pytest.fixture(scope="module")
def player(master):
    with Topics(ROBOT) as topics, Player(topics) as made:
        yield made


@pytest.fixture
def start(master, tmp_path):
    """Starts a node of this package; gives its process and the file of what it says."""
    with contextlib.ExitStack() as nodes:

        def start(name, *arguments):
            log = tmp_path / f"{name}.log"
            command = [NODES / name, f"__ns:={ROBOT}", *arguments]
            with log.open("wb") as output:
                node = NodeProcess(command, master, stdout=output, stderr=output)
            return nodes.enter_context(node), log

        yield start


@pytest.fixture(scope="class")
def teleop_log(player, master, tmp_path_factory):
    """What a joy_teleop says that runs for all tests of a class, with an Xbox pad."""
    log = tmp_path_factory.mktemp("joy") / "joy_teleop.log"
    with log.open("wb") as output, NodeProcess(
        [NODES / "joy_teleop", f"__ns:={ROBOT}"], master, stdout=output, stderr=output
    ):
        wait_until_connected(*player.listeners)
        player.hold()
        player.plug_in()
        yield log


@pytest.fixture
def pad(player, teleop_log):
    player.reset()
    return player


class TestJoyTeleop:
    def test_drives_as_far_as_the_stick_is_pushed(self, pad):
        assert pad.push(pad.twists, y=-1.0) == pytest.approx([1.2, 0.0])
        part = 0.6 * 0.5 + 0.4 * 0.5**3  # half of the way between deadzone and end, with expo 0.4
        assert pad.push(pad.twists, y=-0.56) == pytest.approx([1.2 * part, 0.0])

    def test_silence_stops_and_then_the_stick_needs_the_centre(self, pad, teleop_log):
        pad.push(pad.twists, y=-1.0)
        pad.held = None
        pad.wait_until_stopped("after silence")
        pad.twists.clear()
        pad.hold("left_bumper", y=-1.0)
        time.sleep(0.1)
        assert pad.twists == []
        assert "no joy message for 0.3 s: stopped" in log_of(teleop_log)
        pad.push(pad.twists, y=-1.0)

    def test_without_the_enable_button_it_stops(self, pad):
        pad.push(pad.twists, y=-1.0)
        pad.hold(y=-1.0)
        pad.wait_until_stopped("without the enable button")

    @pytest.mark.parametrize(
        ("axes", "says"),
        [
            ([0, float("nan"), 1, 0, 0, 1, 0, 0], "axes[1] is nan"),
            ([0.0, 1.0], "axes has 2 values"),
        ],
    )
    def test_wrong_messages_move_nothing_and_are_told(self, pad, teleop_log, axes, says):
        pad.hold("left_bumper")
        pad.twists.clear()
        pad.held = pad.message(axes=axes, buttons=[0, 0, 0, 0, 1] + [0] * 6)
        wait_until(lambda: says in log_of(teleop_log), says)
        assert pad.twists == []

    def test_modes_one_after_the_other(self, pad):
        pad.modes[:] = pad.modes[-1:]
        pad.select("CARTESIAN")
        assert pad.modes == ["DRIVE", "JOINT", "CARTESIAN"]
        wait_until(lambda: pad.asked, "the arm's mode")
        assert pad.asked == ["CARTESIAN"]

    def test_a_joint_turns_at_a_share_of_what_its_node_says(self, pad):
        pad.select("JOINT")
        assert pad.push(pad.jogs, x=-1.0) == pytest.approx({"turret_joint": 0.5})

    def test_e_stop_and_its_release(self, pad):
        pad.press("left_stick", lambda: True in pad.e_stops)
        pad.press("back", lambda: False in pad.e_stops, "left_bumper")
        assert [pad.e_stops[0], pad.e_stops[-1]] == [True, False]

    def test_bookmarks_of_an_exercise(self, pad):
        pad.press("right_stick", lambda: pad.training)
        assert set(pad.training) == {("bookmark", "")}
        pad.training.clear()
        pad.press("right_stick", lambda: pad.training, "right_bumper")
        assert ("back", "") in pad.training

    def test_speed(self, pad):
        pad.select("CARTESIAN")
        pad.press("south", lambda: pad.speeds)
        assert pad.speeds[0] == pytest.approx(0.4)


def test_what_is_held_at_the_start_moves_nothing_and_the_end_is_a_zero(player, start):
    player.twists.clear()
    player.modes.clear()
    player.hold("left_bumper", y=-1.0)
    node, log = start("joy_teleop")
    wait_until_connected(*player.listeners)
    player.plug_in()
    assert player.modes[0] == "DRIVE"
    wait_until(lambda: "let go first" in log_of(log), "the hint")
    assert player.twists == []
    wait_until(lambda: "pad xbox" in log_of(log), "the pad's name")
    assert "let go first, nothing moves by it: left_stick_y" in log_of(log)
    player.push(player.twists, y=-1.0)
    assert node.end() == 0
    player.wait_until_stopped("at the end")


def test_the_source_waits_for_its_device(start):
    source, log = start("joy", "_dev:=/nowhere/js0")
    wait_until(lambda: "No such file" in log_of(log), "the source's complaint", 30.0)
    assert "/nowhere/js0 cannot be opened: No such file" in log_of(log)
    assert source.end() == 0
    assert "Traceback" not in log_of(log)
