"""The kernel's joystick events, and the state that they make.

A device ``/dev/input/js*`` sends a ``struct js_event`` for every change, and at its opening one for
each axis and button (Linux, Documentation/input/joydev/joystick-api.rst). Axes and buttons are
numbered as ROS's joy_node numbers them, which reads the same interface.
"""

from __future__ import annotations

import struct
from typing import Dict, List, Tuple

EVENT = struct.Struct("=IhBB")
"""Time (ms), value, type, number of the axis or button."""

BUTTON, AXIS, INITIAL = 0x01, 0x02, 0x80
FULL = 32767.0
# An axis deflected this far before anybody has touched it is a trigger.
RESTS_AT_END = 0.99


class JoystickState:
    """Axes and buttons of a joystick, after the events so far.

    Parameters
    ----------
    axes, buttons
        How many there are.
    deadzone
        Share of an axis' way on both sides of its centre that counts as the centre; the rest of
        the way is stretched, so that nothing jumps.
    """

    def __init__(self, axes: int, buttons: int, deadzone: float) -> None:
        self._axes = [0] * axes
        self._buttons = [0] * buttons
        self._deadzone = deadzone
        self._first: Dict[int, int] = {}
        self._rest = b""

    @property
    def axes(self) -> List[float]:
        """Positions, -1 to 1: left and up are positive, a trigger goes from 1 to -1."""
        return [self._scaled(value) for value in self._axes]

    @property
    def buttons(self) -> List[int]:
        """1 for the buttons that are held, else 0."""
        return list(self._buttons)

    def neutral(self) -> Tuple[List[float], List[int]]:
        """Return axes and buttons of the joystick when nobody touches it."""
        axes = [self._scaled(self._first.get(index, 0)) for index in range(len(self._axes))]
        return [axis if axis >= RESTS_AT_END else 0.0 for axis in axes], [0] * len(self._buttons)

    def feed(self, data: bytes) -> Tuple[bool, bool]:
        """Take bytes of the device; an event may be split between two calls.

        Returns
        -------
        tuple of bool
            Whether an axis has moved, and whether a button has.
        """
        data = self._rest + data
        whole = len(data) - len(data) % EVENT.size
        self._rest = data[whole:]
        moved = pressed = False
        for _time, value, kind, number in EVENT.iter_unpack(data[:whole]):
            if kind & ~INITIAL == AXIS:
                if kind & INITIAL:
                    self._first.setdefault(number, value)
                moved |= _put(self._axes, number, value)
            elif kind & ~INITIAL == BUTTON:
                pressed |= _put(self._buttons, number, int(value != 0))
        return moved, pressed

    def _scaled(self, value: int) -> float:
        way = min(abs(value) / FULL, 1.0) - self._deadzone
        if way <= 0.0:
            return 0.0
        share = way / (1.0 - self._deadzone)
        return -share if value > 0 else share


def _put(values: List[int], number: int, value: int) -> bool:
    """Put a value into its place; tell whether it has changed."""
    values.extend([0] * (number + 1 - len(values)))
    changed, values[number] = values[number] != value, value
    return changed
