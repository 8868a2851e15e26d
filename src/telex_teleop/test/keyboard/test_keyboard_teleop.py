"""The keyboard's main loop with a terminal and a robot of paper."""

import pytest

from telex_teleop.keyboard.decoding import FocusEvent, KeyDecoder, KittyReply
from telex_teleop.keyboard.map import KeyboardSettings
from telex_teleop.keyboard.teleop import KeyboardTeleop
from telex_teleop.tracks.track_drive import Velocity

KEYS = {
    "w": "tracks forward",
    "j": "arm turret_joint +",
    "space": "stop",
    "escape": "e-stop",
    "ctrl+r": "release e-stop",
    "+": "faster",
    "-": "slower",
    "tab": "mode",
    "8": "lamps front rear",
    "\\": "proximity guard",
    "]": "bookmark",
    "backspace": "go back",
    "?": "help",
    "ctrl+c": "quit",
}


class Terminal:
    """Answers `read` from a script of (bytes or None); keeps what it is shown."""

    def __init__(self, script=()):
        self.script = list(script)
        self.pictures = []
        self.answers = []
        self.asked = 0

    def ask(self):
        self.asked += 1

    def read(self, timeout):
        item = self.script.pop(0) if self.script else b"\x03"
        return item(timeout) if callable(item) else item

    def answer(self, exact):
        self.answers.append(exact)

    def size(self):
        return 80, 24

    def show(self, lines):
        self.pictures.append(lines)


class Robot:
    namespace, mode, speed_scale, e_stop, driven, notice = (
        "/r",
        "JOINT",
        1.0,
        False,
        Velocity(0, 0),
        "",
    )
    tool, arm_notice, zoom, lit = None, "", 1.0, ()

    def __init__(self):
        self.sent = []
        self.done = []

    def send(self, commands):
        self.sent.append(commands)

    def change_speed(self, direction, step):
        self.done.append((direction, step))

    def set_e_stop(self, active):
        self.done.append(active)

    def toggle_mode(self):
        self.done.append("mode")

    def toggle_hold(self):
        self.done.append("hold")

    def next_frame(self):
        self.done.append("frame")

    def toggle_guard(self):
        self.done.append("guard")

    def set_bookmark(self):
        self.done.append("bookmark")

    def go_back(self):
        self.done.append("back")

    def switch_lamps(self, names):
        self.done.append(names)

    def node_views(self):
        return {}

    def joint_views(self):
        return {}


@pytest.fixture
def robot():
    return Robot()


@pytest.fixture
def settings():
    return KeyboardSettings(KEYS)


@pytest.fixture
def terminal():
    return Terminal()


@pytest.fixture
def keyboard(robot, settings, terminal):
    return KeyboardTeleop(settings, robot, terminal)


def press(keyboard, data, now):
    keyboard.take(KeyDecoder().feed(data, now), now)
    keyboard.send(now)


def test_command_leaves_with_the_press_and_repeats_at_the_rate(keyboard, robot):
    press(keyboard, b"j", 1.0)
    assert robot.sent[0].jogs == {"arm": {"turret_joint": 100.0}}
    keyboard.send(1.01)
    assert len(robot.sent) == 1
    keyboard.send(1.021)
    assert len(robot.sent) == 2
    keyboard.send(1.2)
    assert robot.sent[-1].jogs == {"arm": {"turret_joint": 0.0}}
    keyboard.send(1.3)
    assert len(robot.sent) == 3


def test_idle_keyboard_sends_nothing(keyboard, robot):
    for tick in range(100):
        keyboard.send(0.02 * tick)
    assert robot.sent == []


def test_lost_focus_stops(keyboard, robot):
    press(keyboard, b"w", 1.0)
    keyboard.take([FocusEvent(False)], 1.02)
    keyboard.send(1.02)
    assert robot.sent[-1].drive == (Velocity(0.0, 0.0),)


def test_stop_is_done_however_often_its_key_repeats(keyboard, robot):
    for tick in range(3):
        press(keyboard, b" ", 1.0 + 0.03 * tick)
    stops = [commands for commands in robot.sent if commands.jogs]
    assert len(stops) == 3
    assert stops[0].jogs == {"arm": {"turret_joint": 0.0}}


def test_e_stop_also_stops(keyboard, robot):
    press(keyboard, b"j", 1.0)
    press(keyboard, b"\x1b", 1.02)
    decoder = KeyDecoder()
    decoder.feed(b"\x1b", 1.02)
    keyboard.take(decoder.feed(b"", 1.1), 1.1)
    assert robot.done == [True]
    assert robot.sent[-1].jogs == {"arm": {"turret_joint": 0.0}}


def test_commands_happen_once_per_press(keyboard, robot):
    for data in (b"+", b"-", b"\t", b"\x12"):
        press(keyboard, data, 1.0)
        press(keyboard, data, 1.05)
    assert robot.done == [(1, 0.1), (-1, 0.1), "mode", False]


class TestCartesian:
    KEYS = {**KEYS, "y": "frame", "h": "hold tool", "c": "pose ready"}

    @pytest.fixture
    def settings(self):
        return KeyboardSettings(
            self.KEYS, {"j": "tool y +"}, jog_rate=0.5, tool_linear=0.2, tool_angular=0.7
        )

    def test_key_moves_the_tool_and_letting_go_sends_a_zero(self, keyboard, robot):
        robot.mode = "CARTESIAN"
        keyboard.send(0.5)
        press(keyboard, b"j", 1.0)
        assert robot.sent[-1].tool == ((0.0, 0.2, 0.0, 0.0, 0.0, 0.0),)
        assert robot.sent[-1].jogs == {}
        keyboard.send(2.0)
        assert robot.sent[-1].tool == ((0.0,) * 6,)

    def test_key_that_is_held_while_the_mode_changes_needs_a_new_press(self, keyboard, robot):
        press(keyboard, b"j", 1.0)
        assert robot.sent[-1].jogs == {"arm": {"turret_joint": 0.5}}
        robot.mode = "CARTESIAN"
        keyboard.send(1.05)
        assert robot.sent[-1].jogs == {"arm": {"turret_joint": 0.0}}
        assert robot.sent[-1].tool == ()

    @pytest.mark.parametrize("mode", ["JOINT", "CARTESIAN"])
    def test_named_pose_is_sent_while_its_key_is_held(self, keyboard, robot, mode):
        robot.mode = mode
        keyboard.send(0.5)
        press(keyboard, b"c", 1.0)
        assert robot.sent[-1].pose == ("ready",)
        keyboard.send(2.0)
        assert robot.sent[-1].pose == ("",)

    def test_stop_stops_the_tool_and_the_way_to_a_pose(self, keyboard, robot):
        robot.mode = "CARTESIAN"
        keyboard.send(0.5)
        press(keyboard, b" ", 1.0)
        assert robot.sent[-1].tool == ((0.0,) * 6,)
        assert robot.sent[-1].pose == ("",)

    def test_frame_and_hold_are_done_once(self, keyboard, robot):
        press(keyboard, b"y", 1.0)
        press(keyboard, b"h", 1.1)
        assert robot.done == ["frame", "hold"]


def test_terminal_is_told_of_its_answers(robot, settings):
    terminal = Terminal()
    keyboard = KeyboardTeleop(settings, robot, terminal)
    keyboard.take([KittyReply(False), KittyReply(True)], 1.0)
    assert terminal.answers == [False, True]
    assert "exactly" not in "".join(line.text for line in keyboard.picture(1.0))
    press(keyboard, b"?", 1.0)
    assert "exactly" in "".join(line.text for line in keyboard.picture(1.0))


def test_quit_ends_the_loop_with_zeros(robot, settings):
    KeyboardTeleop(settings, robot, Terminal([b"j", b"\x03"])).run(lambda: False)
    assert robot.sent[-1].jogs == {"arm": {"turret_joint": 0.0}}


def test_end_of_the_terminal_ends_the_loop_with_zeros(robot, settings):
    terminal = Terminal([b"j", None])
    KeyboardTeleop(settings, robot, terminal).run(lambda: False)
    assert terminal.pictures
    assert robot.sent[-1].jogs == {"arm": {"turret_joint": 0.0}}


def test_failure_ends_with_zeros_too(robot, settings):
    def fail(_timeout):
        raise RuntimeError("out of paper")

    with pytest.raises(RuntimeError, match="out of paper"):
        KeyboardTeleop(settings, robot, Terminal([b"j", fail])).run(lambda: False)
    assert robot.sent[-1].jogs == {"arm": {"turret_joint": 0.0}}


def test_interruption_ends_the_loop(robot, settings):
    terminal = Terminal([b""] * 100)
    KeyboardTeleop(settings, robot, terminal).run(lambda: len(terminal.script) < 98)
    assert len(terminal.script) == 97


def test_standstill_of_the_program_releases_the_keys(robot, settings, monkeypatch):
    clock = iter([0.0, 0.02, 0.04, 5.0, 5.02, 5.04])
    monkeypatch.setattr("telex_teleop.keyboard.teleop.time.monotonic", lambda: next(clock))
    exact = b"\x1b[?15u\x1b[106u"
    KeyboardTeleop(settings, robot, Terminal([exact, b"", b"", b"", b"\x03"])).run(lambda: False)
    moving = [commands.jogs["arm"]["turret_joint"] for commands in robot.sent if commands.jogs]
    assert moving == [100.0, 100.0, 0.0]


@pytest.fixture
def clock(monkeypatch):
    """Set what the loop takes for the time at each of its turns."""

    def set_moments(*moments):
        turns = iter(moments)
        monkeypatch.setattr("telex_teleop.keyboard.teleop.time.monotonic", lambda: next(turns))

    return set_moments


def rates(robot):
    return [commands.jogs["arm"]["turret_joint"] for commands in robot.sent if commands.jogs]


@pytest.mark.parametrize("piled_up", [b"j", b"jjjjjjjj", b"\x1b[106u", b"+++"])
def test_what_was_typed_while_the_program_stood_still_is_no_command(
    robot, settings, clock, piled_up
):
    clock(0.0, 0.02, 1.1, 1.12, 1.3, 1.32)
    terminal = Terminal([b"\x1b[?15u", piled_up, piled_up[:1].strip(b"\x1b"), b"", b"\x03"])
    KeyboardTeleop(settings, robot, terminal).run(lambda: False)
    assert rates(robot) == []
    assert robot.done == []


def test_stops_that_were_typed_meanwhile_are_obeyed(robot, settings, clock):
    clock(0.0, 0.02, 1.1, 1.12, 1.2, 1.22)
    script = [b"", b"j\x1b\x1b j", b"", b"\x03"]
    KeyboardTeleop(settings, robot, Terminal(script)).run(lambda: False)
    assert robot.done == [True, True]
    assert rates(robot) == [0.0, 0.0, 0.0]


def test_quit_that_was_typed_meanwhile_is_obeyed(robot, settings, clock):
    clock(0.0, 0.02, 1.1)
    terminal = Terminal([b"", b"jj\x03", b"x"])
    KeyboardTeleop(settings, robot, terminal).run(lambda: False)
    assert terminal.script == [b"x"]


class TestLine:
    """A key is held by an exact report; its release may never come."""

    def hold(self, keyboard, start, duration, answers):
        for tick in range(round(duration / 0.02)):
            now = start + 0.02 * tick
            if answers and tick % 5 == 4:
                keyboard.hear(now)
            keyboard.check_line(now)
            keyboard.send(now)

    @pytest.fixture
    def holding(self, keyboard):
        decoder = KeyDecoder()
        keyboard.take(decoder.feed(b"\x1b[?15u\x1b[106u", 1.0), 1.0)
        return keyboard

    def test_dead_line_releases_the_keys(self, holding, robot):
        self.hold(holding, 1.0, 0.36, answers=False)
        assert rates(robot)[-1] == 100.0
        self.hold(holding, 1.36, 0.1, answers=False)
        assert rates(robot)[-1] == 0.0

    def test_key_is_held_while_the_terminal_answers(self, holding, robot, terminal):
        self.hold(holding, 1.0, 5.0, answers=True)
        assert set(rates(robot)) == {100.0}
        assert terminal.asked == pytest.approx(50, abs=9)

    def test_terminal_is_not_asked_while_nothing_is_held(self, keyboard, terminal):
        self.hold(keyboard, 1.0, 5.0, answers=True)
        keyboard.take(KeyDecoder().feed(b"j", 6.0), 6.0)
        self.hold(keyboard, 6.0, 1.0, answers=True)
        assert terminal.asked == 0


def test_lamps_guard_and_bookmarks_are_done_once(keyboard, robot):
    press(keyboard, b"8", 1.0)
    press(keyboard, b"8", 1.1)  # repeated by the terminal
    press(keyboard, b"\\", 2.0)
    press(keyboard, b"]", 3.0)
    press(keyboard, b"\x7f", 4.0)
    press(keyboard, b"\x7f", 4.1)
    assert robot.done == [("front", "rear"), "guard", "bookmark", "back"]
    assert keyboard.picture(1.05)
    assert not robot.sent or not robot.sent[-1].jogs
