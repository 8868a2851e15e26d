"""Joystick devices of Linux: finding, opening and reading them."""

from __future__ import annotations

import contextlib
import fcntl
import glob
import os
import select
from typing import List, Optional

DEVICES = "/dev/input/js*"
NAME_LENGTH = 128
# linux/joystick.h: _IOR('j', number, size)
GET_AXES, GET_BUTTONS = 0x80016A11, 0x80016A12
GET_NAME = 0x80006A13 | NAME_LENGTH << 16
READ_SIZE = 4096


class JoystickError(RuntimeError):
    """There is no joystick to read; the message names the device and says why."""


class Joystick:
    """An open joystick; it is closed at the end of a `with` block.

    Parameters
    ----------
    fd
        File descriptor that delivers the events.
    path, name
        Of the device.
    axes, buttons
        How many it has.
    """

    def __init__(self, fd: int, path: str, name: str, axes: int, buttons: int) -> None:
        self._fd = fd
        self.path = path
        self.name = name
        self.axes = axes
        self.buttons = buttons

    @classmethod
    def open(cls, path: str) -> Joystick:
        """Open a device.

        Raises
        ------
        JoystickError
            When it cannot be opened, or is no joystick.
        """
        try:
            # The kernel may tell a first opening what was held when the device was last closed.
            os.close(os.open(path, os.O_RDONLY | os.O_NONBLOCK))
            fd = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
        except OSError as error:
            raise JoystickError(f"{path} cannot be opened: {error.strerror}") from error
        try:
            axes = fcntl.ioctl(fd, GET_AXES, bytes(1))[0]
            buttons = fcntl.ioctl(fd, GET_BUTTONS, bytes(1))[0]
            name = fcntl.ioctl(fd, GET_NAME, bytes(NAME_LENGTH)).split(b"\0")[0]
        except OSError as error:
            os.close(fd)
            raise JoystickError(
                f"{path} is no joystick device ({error.strerror}); one is called {DEVICES}"
            ) from error
        return cls(fd, path, name.decode("utf-8", "replace"), axes, buttons)

    def __enter__(self) -> Joystick:
        return self

    def __exit__(self, *exception: object) -> None:
        with contextlib.suppress(OSError):
            os.close(self._fd)

    def read(self, timeout: float) -> Optional[bytes]:
        """Return what came within a time (s), empty when nothing did, None when it is gone."""
        ready, _, _ = select.select([self._fd], [], [], timeout)
        if not ready:
            return b""
        try:
            return os.read(self._fd, READ_SIZE) or None
        except BlockingIOError:
            return b""
        except OSError:
            # unplugged
            return None


def find_joystick(path: str, name: str) -> Joystick:
    """Open a joystick.

    Parameters
    ----------
    path
        Of the device; empty: the first one.
    name
        What the device is called; where it is given, the path does not count.

    Raises
    ------
    JoystickError
        When there is none; a device that is there and cannot be opened is told first.
    """
    if path and not name:
        return Joystick.open(path)
    refusals: List[str] = []
    for device in sorted(glob.glob(DEVICES)):
        try:
            joystick = Joystick.open(device)
        except JoystickError as error:
            refusals.append(str(error))
            continue
        if not name or joystick.name == name:
            return joystick
        refusals.append(f"{device} is called {joystick.name!r}")
        with joystick:
            pass
    wanted = f"a joystick called {name!r}" if name else "a joystick"
    raise JoystickError(f"{wanted} is not there: {'; '.join(refusals) or f'no {DEVICES}'}")
