"""The joystick: recorded events, pacing, the device's calls, and its coming and going."""

from __future__ import annotations

import errno
import fcntl
import os

import pytest

from telex_control.common.params import ConfigError, read_config
from telex_teleop.joy import device as device_module
from telex_teleop.joy.device import Joystick, JoystickError, find_joystick
from telex_teleop.joy.events import EVENT, JoystickState
from telex_teleop.joy.pacing import PublishPacer
from telex_teleop.joy.source import JoySettings, JoySource

AXIS, BUTTON, INITIAL = 2, 1, 0x80
# Bytes as joystick-api.rst has them, from an Xbox pad (driver xpad). What it says when opened: 11
# buttons, 8 axes, the two triggers (2 and 5) at the end where they rest. Then button 0 is pressed,
# and the left stick pushed.
OPENED = bytes.fromhex(
    "".join(f"9c3aa1010000{kind:02x}{n:02x}" for kind, count in ((0x81, 11),) for n in range(count))
    + "".join(f"9c3aa101{'0180' if n in (2, 5) else '0000'}82{n:02x}" for n in range(8))
)
PRESSED = bytes.fromhex("e83ca10101000100")
PUSHED = bytes.fromhex("f03ca10101800201")


def event(kind, number, value):
    return EVENT.pack(1, value, kind, number)


@pytest.fixture
def state():
    return JoystickState(axes=8, buttons=11, deadzone=0.0)


class TestEvents:
    def test_recorded_bytes(self, state):
        assert state.feed(OPENED) == (True, False)
        assert state.axes == [0, 0, 1, 0, 0, 1, 0, 0]
        assert state.buttons == [0] * 11
        assert state.feed(PRESSED) == (False, True)
        assert state.buttons == [1] + [0] * 10
        assert state.feed(PUSHED) == (True, False)
        assert state.axes[1] == 1.0

    @pytest.mark.parametrize("piece", [1, 3, 7, 8, 11])
    def test_an_event_may_come_in_pieces(self, state, piece):
        data = OPENED + PRESSED + PUSHED
        for start in range(0, len(data), piece):
            state.feed(data[start : start + piece])
        assert state.buttons[0] == 1
        assert state.axes == [0, 1, 1, 0, 0, 1, 0, 0]

    def test_what_repeats_is_no_change(self, state):
        state.feed(PRESSED)
        assert state.feed(PRESSED) == (False, False)

    def test_directions_are_those_of_joy_node(self, state):
        state.feed(event(AXIS, 0, 32767) + event(AXIS, 1, -32767) + event(AXIS, 2, -32768))
        assert state.axes[:3] == [-1.0, 1.0, 1.0]

    def test_deadzone_is_cut_out_without_a_jump(self):
        state = JoystickState(1, 0, deadzone=0.2)
        shown = []
        for value in (0, 6553, 6554, -6600, 32767):
            state.feed(event(AXIS, 0, value))
            shown += state.axes
        assert shown[:2] == [0.0, 0.0]
        assert shown[2] == pytest.approx(0.0, abs=1e-4)
        assert 0.0 < shown[3] < 0.01
        assert shown[4] == -1.0

    def test_neutral_knows_the_triggers(self, state):
        state.feed(OPENED + PRESSED + PUSHED + event(AXIS, 2, 32767))
        assert state.neutral() == ([0, 0, 1, 0, 0, 1, 0, 0], [0] * 11)

    def test_numbers_beyond_those_announced_find_a_place(self):
        state = JoystickState(1, 1, 0.0)
        state.feed(event(AXIS, 3, -32767) + event(BUTTON, 2, 1))
        assert state.axes == [0, 0, 0, 1.0]
        assert state.buttons == [0, 0, 1]

    def test_an_unknown_type_is_ignored(self, state):
        assert state.feed(event(0x04, 0, 5)) == (False, False)


class TestPacing:
    def test_button_at_once_axis_after_the_interval(self):
        pacer = PublishPacer(autorepeat_rate=0.0, coalesce_interval=0.01)
        assert pacer.wait(1.0) is None
        pacer.changed(1.0, at_once=False)
        assert pacer.wait(1.0) == pytest.approx(0.01)
        pacer.changed(1.005, at_once=False)  # the first one counts
        assert pacer.wait(1.005) == pytest.approx(0.005)
        pacer.changed(1.006, at_once=True)
        assert pacer.wait(1.006) == 0.0
        pacer.sent(1.006)
        assert pacer.wait(1.006) is None

    def test_autorepeat(self):
        pacer = PublishPacer(autorepeat_rate=20.0, coalesce_interval=0.01)
        assert pacer.wait(1.0) == 0.0
        pacer.sent(1.0)
        assert pacer.wait(1.0) == pytest.approx(0.05)
        assert pacer.wait(1.2) == 0.0


class TestDevice:
    @pytest.fixture
    def node(self, tmp_path, monkeypatch):
        """A file that answers as a joystick called `Pad` does."""

        def ioctl(fd, request, buffer):
            if not os.fstat(fd).st_size:
                raise OSError(errno.ENOTTY, os.strerror(errno.ENOTTY))
            return {0x80016A11: b"\x08", 0x80016A12: b"\x0b"}.get(
                request, b"Pad".ljust(len(buffer), b"\0")
            )

        monkeypatch.setattr(fcntl, "ioctl", ioctl)
        monkeypatch.setattr(device_module, "DEVICES", str(tmp_path / "js*"))
        (tmp_path / "js0").write_bytes(b"")
        (tmp_path / "js1").write_bytes(OPENED)
        return tmp_path

    def test_asks_for_name_and_counts(self, node):
        with Joystick.open(str(node / "js1")) as joystick:
            assert (joystick.name, joystick.axes, joystick.buttons) == ("Pad", 8, 11)
            assert joystick.read(0.0) == OPENED

    def test_opens_twice_for_the_present_state_and_closes_what_it_opened(self, node, monkeypatch):
        opened, closed, really_open, really_close = [], [], os.open, os.close

        def note_open(path, flags):
            opened.append(really_open(path, flags))
            return opened[-1]

        def note_close(fd):
            closed.append(fd)
            really_close(fd)

        monkeypatch.setattr(os, "open", note_open)
        monkeypatch.setattr(os, "close", note_close)
        with Joystick.open(str(node / "js1")):
            assert len(opened) == 2
            assert closed == opened[:1]
        with pytest.raises(JoystickError):
            Joystick.open(str(node / "js0"))
        assert closed == opened

    def test_the_kernels_own_numbers_are_used(self):
        # linux/joystick.h: 0x11, 0x12 and 0x13 of 'j'; asm-generic/ioctl.h: how they are made
        def read_request(number, size):
            return 2 << 30 | size << 16 | ord("j") << 8 | number

        assert read_request(0x11, 1) == device_module.GET_AXES
        assert read_request(0x12, 1) == device_module.GET_BUTTONS
        name_length = device_module.NAME_LENGTH
        assert read_request(0x13, name_length) == device_module.GET_NAME

    @pytest.mark.parametrize(("path", "name"), [("", ""), ("", "Pad"), ("/nowhere", "Pad")])
    def test_finds_the_first_that_fits(self, node, path, name):
        with find_joystick(path, name) as joystick:
            assert joystick.path == str(node / "js1")

    def test_says_what_is_there_instead(self, node):
        with pytest.raises(
            JoystickError, match=r"called 'Wheel' is not there.*js1 is called 'Pad'"
        ):
            find_joystick("", "Wheel")

    @pytest.mark.parametrize(
        ("path", "says"), [("js0", "is no joystick device"), ("js7", "cannot be opened: No such")]
    )
    def test_says_why_not(self, node, path, says):
        with pytest.raises(JoystickError, match=says):
            find_joystick(str(node / path), "")


class Bench:
    """A joystick on a pipe that is plugged in and out, and what the source made of it."""

    def __init__(self, plugs):
        self.plugs = list(plugs)  # what each joystick says before it is unplugged; None: none there
        self.log = []
        self.opened = 0
        self.source = JoySource(
            JoySettings(autorepeat_rate=0.0, coalesce_interval=0.0, retry_period=0.05),
            self.find,
            lambda path, axes, buttons: self.log.append((axes, buttons)),
            self.log.append,
            lambda why: self.log.append(f"complaint: {why}"),
        )

    def find(self):
        said = self.plugs.pop(0)
        if said is None:
            raise JoystickError("no pad")
        reading, writing = os.pipe()
        os.write(writing, said)
        os.close(writing)
        self.opened += 1
        return Joystick(reading, "/dev/input/js0", "Pad", 8, 11)

    def run(self):
        self.source.run(lambda: not self.plugs)
        return self.log


class TestSource:
    def test_unplugged_means_nobody_touches_it(self):
        axes = [0, 0, 1, 0, 0, 1, 0, 0]
        held = OPENED + PRESSED + PUSHED
        log = Bench([None, None, held, None, OPENED, None]).run()
        assert log[0:2] == ["complaint: no pad", "Pad"]
        pushed, pressed = log[2]
        assert pushed[1] > 0.99
        assert pressed[0] == 1
        # released, although its last events said that it was held
        assert log[3] == (axes, [0] * 11)
        assert log[4:7] == ["", "complaint: no pad", "Pad"]
        assert log[7] == (axes, [0] * 11)

    def test_ends_with_nobody_touching_it(self):
        bench = Bench([OPENED + PRESSED])
        assert bench.run() == ["Pad", ([0, 0, 0, 0, 0, 0, 0, 0], [0] * 11), ""]


@pytest.mark.parametrize(
    ("params", "says"),
    [
        ({"deadzone": 1.0}, "deadzone is 1.0"),
        ({"autorepeat_rate": -1.0}, "autorepeat_rate is -1.0"),
        ({"coalesce_interval": float("nan")}, "coalesce_interval is nan"),
        ({"device": "/dev/input/js0"}, "device is unknown"),
    ],
)
def test_wrong_parameters_are_refused(params, says):
    with pytest.raises(ConfigError, match=says):
        read_config(JoySettings, params, "/joy")
