"""The joystick's loop: opens it, publishes its state, and outlives its being unplugged."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Callable, List

from telex_control.common.params import Declared, number, parameter
from telex_teleop.joy.device import Joystick, JoystickError
from telex_teleop.joy.events import JoystickState
from telex_teleop.joy.pacing import PublishPacer

LONGEST_WAIT = 0.1  # s between two looks at whether the node shall end


@dataclass(frozen=True)
class JoySettings(Declared):
    """Parameters of the node joy, called as those of ROS's joy_node.

    Raises
    ------
    telex_control.common.params.ConfigError
        When one is out of range.
    """

    dev: str = parameter("/dev/input/js0", "Path of the device; empty: the first one.")
    dev_name: str = parameter("", "Name of the device, in place of its path.")
    deadzone: float = number(
        0.05,
        "Share of an axis' way on both sides of the centre that counts as the centre.",
        0.0,
        0.9,
    )
    autorepeat_rate: float = number(
        20.0, "Messages per second while nothing changes; 0: none.", 0.0, 1000.0
    )
    coalesce_interval: float = number(
        0.001, "Time (s) for which an axis that has moved waits for others.", 0.0, 1.0
    )
    retry_period: float = number(
        1.0, "Time (s) between two attempts to open the device.", 0.05, 60.0
    )


class JoySource:
    """Publishes a joystick's state until it is told to end.

    Parameters
    ----------
    find
        Opens the joystick, or raises `JoystickError`.
    publish
        Takes the path of the device, axes and buttons.
    announce
        Takes the name of the device when it comes, and an empty one when it goes.
    complain
        Takes why there is no joystick, each time the reason changes.
    """

    def __init__(
        self,
        settings: JoySettings,
        find: Callable[[], Joystick],
        publish: Callable[[str, List[float], List[int]], None],
        announce: Callable[[str], None],
        complain: Callable[[str], None],
    ) -> None:
        self._settings = settings
        self._find = find
        self._publish = publish
        self._announce = announce
        self._complain = complain
        self._complaint = ""

    def run(self, ended: Callable[[], bool]) -> None:
        """Work until `ended` says so."""
        while not ended():
            try:
                joystick = self._find()
            except JoystickError as error:
                self._wait(str(error), ended)
                continue
            with joystick:
                self._complaint = ""
                self._announce(joystick.name)
                self._follow(joystick, ended)
            self._announce("")

    def _follow(self, joystick: Joystick, ended: Callable[[], bool]) -> None:
        """Publish what a joystick does until it is gone; then, that nobody touches it."""
        settings = self._settings
        state = JoystickState(joystick.axes, joystick.buttons, settings.deadzone)
        pacer = PublishPacer(settings.autorepeat_rate, settings.coalesce_interval)
        try:
            while not ended():
                wait = pacer.wait(time.monotonic())
                data = joystick.read(LONGEST_WAIT if wait is None else min(wait, LONGEST_WAIT))
                if data is None:
                    break
                now = time.monotonic()
                moved, pressed = state.feed(data)
                if moved or pressed:
                    pacer.changed(now, at_once=pressed)
                if pacer.wait(now) == 0.0:
                    self._publish(joystick.path, state.axes, state.buttons)
                    pacer.sent(now)
        finally:
            self._publish(joystick.path, *state.neutral())

    def _wait(self, complaint: str, ended: Callable[[], bool]) -> None:
        if complaint != self._complaint:
            self._complaint = complaint
            self._complain(complaint)
        until = time.monotonic() + self._settings.retry_period
        while not ended() and time.monotonic() < until:
            time.sleep(min(LONGEST_WAIT, self._settings.retry_period))
