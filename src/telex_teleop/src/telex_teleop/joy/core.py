"""From sensor_msgs/Joy to what the operator demands.

Nothing moves but by a control that has been seen at rest since the last change: since the start of
the stream, the emergency stop, a change of mode, the press of the enable button, or since the
control got another meaning. So a stick that somebody holds, or leans on, is never a command.
"""

from __future__ import annotations

import math
from typing import Dict, List, Mapping, Optional, Sequence, Set, Tuple

from telex_teleop.actions.grammar import Action, Command, is_momentary
from telex_teleop.joy.maps import Binding, ButtonBinding, JoyMap, PadMode, StickBinding
from telex_teleop.joy.pads import Pad

# Time (s) for which messages may still arrive that waited while the program was held up.
CATCHING_UP = 0.1
PRESSED = 0.5  # of a button or trigger that does something once
# They count whenever they are pressed, also at the very start of a stream.
ALWAYS = (Command.E_STOP, Command.STOP)


class JoyTeleop:
    """Decides what a gamepad demands.

    Parameters
    ----------
    pad
        Where they are in the messages.
    timeout
        A stream that is silent for longer (s) is a command to stop.
    """

    def __init__(self, joy_map: JoyMap, pad: Pad, timeout: float) -> None:
        joy_map.require_on(pad)
        self._map = joy_map
        self._pad = pad
        self._timeout = timeout
        self._mode = 0
        self._arm_mode: Optional[str] = None
        self._e_stop = False
        self._heard: Optional[float] = None
        self._catching_up_until = -math.inf
        self._values: Dict[str, float] = {}
        self._bindings = {
            (index, shifted): joy_map.bindings(mode, shifted)
            for index, mode in enumerate(joy_map.modes)
            for shifted in (False, True)
        }
        self._bound: Mapping[str, Binding] = {}
        self._armed: Set[str] = set()
        self._down: Set[str] = set()

    @property
    def mode(self) -> PadMode:
        """Present mode."""
        return self._map.modes[self._mode]

    @property
    def enabled(self) -> bool:
        """Whether the enable button is held, as far as the last message says."""
        return self._values.get(self._map.enable, 0.0) > PRESSED

    def alive(self, now: float) -> bool:
        """Tell whether a message came within the timeout before `now` (monotonic time, s)."""
        return self._heard is not None and now - self._heard <= self._timeout

    def take(self, axes: Sequence[float], buttons: Sequence[int], now: float) -> List[Action]:
        """Take a message that came at `now` (monotonic time, s).

        Returns
        -------
        list
            What is to be done once; a change of the mode has been done already, and is in it.

        Raises
        ------
        telex_teleop.joy.pads.InvalidJoy
            When the message is wrong; it is as if it had not come.
        """
        values = self._pad.read(axes, buttons)
        if not self.alive(now):
            self._armed.clear()
            self._down.clear()
        self._heard = now
        self._values = values
        self._bind()
        if now < self._catching_up_until:
            self._armed.clear()
        presses = self._presses()
        for action in presses:
            if action is Command.MODE:
                self._mode = (self._mode + 1) % len(self._map.modes)
                self._bind()
            if action in (Command.MODE, *ALWAYS):
                self.release()
        if self._e_stop or not self.enabled:
            self.release()
        return presses

    def demands(self, now: float) -> Dict[Action, float]:
        """Return what is demanded at `now` (monotonic time, s), and how far (above 0, up to 1)."""
        if not self.alive(now) or self._e_stop or not self.enabled:
            return {}
        demanded: Dict[Action, float] = {}
        for name, binding in self._moving():
            if name in self._armed:
                action, share = binding.demand(self._values[name])
                demanded[action] = min(1.0, demanded.get(action, 0.0) + share)
        return demanded

    def waiting(self, now: float) -> List[str]:
        """Return the controls that would move something if they had been at rest before."""
        if not self.alive(now) or self._e_stop or not self.enabled:
            return []
        return [name for name, _ in self._moving() if name not in self._armed]

    def set_e_stop(self, active: bool) -> None:
        """Take that the emergency stop is set, or not; what is held then must be let go first."""
        self._e_stop = active
        if active:
            self.release()

    def interrupt(self, now: float) -> None:
        """Take that the program was held up until `now`: what the hands did meanwhile is unknown.

        Neither what is held counts, nor what the messages say that have waited.
        """
        self._catching_up_until = now + CATCHING_UP
        self._armed.clear()

    def release(self) -> None:
        """Let go what moves; it counts again when it has been at rest."""
        self._armed -= {name for name, _ in self._moving()}

    def follow_arm(self, arm_mode: Optional[str]) -> bool:
        """Take the arm's mode; when somebody else has changed it, change with it.

        Returns
        -------
        bool
            Whether the mode has changed.
        """
        before, self._arm_mode = self._arm_mode, arm_mode
        if arm_mode == before or not self.mode.arm_mode or self.mode.arm_mode == arm_mode:
            return False
        for index, mode in enumerate(self._map.modes):
            if mode.arm_mode and mode.arm_mode == arm_mode:
                self._mode = index
                self._bind()
                self.release()
                return True
        return False

    def _bind(self) -> None:
        shifted = bool(self._map.shift) and self._values.get(self._map.shift, 0.0) > PRESSED
        bound = self._bindings[self._mode, shifted]
        self._armed = {n for n in self._armed if bound.get(n) == self._bound.get(n)}
        self._bound = bound
        self._armed |= {n for n in bound if n in self._values and self._rests(n)}

    def _rests(self, name: str) -> bool:
        binding, value = self._bound[name], self._values[name]
        if isinstance(binding, ButtonBinding) and is_momentary(binding.action):
            return value <= PRESSED
        return abs(value) <= binding.deadzone

    def _moving(self) -> List[Tuple[str, Binding]]:
        """Return the controls that are off their rest and demand something while they are."""
        return [
            (name, binding)
            for name, binding in self._bound.items()
            if name in self._values
            and not self._rests(name)
            and (isinstance(binding, StickBinding) or not is_momentary(binding.action))
        ]

    def _presses(self) -> List[Action]:
        presses: List[Action] = []
        for name, binding in self._bound.items():
            if isinstance(binding, StickBinding) or not is_momentary(binding.action):
                continue
            if name not in self._values or self._rests(name):
                self._down.discard(name)
                continue
            action, fresh = binding.action, name not in self._down
            self._down.add(name)
            if action is Command.RELEASE_E_STOP and not self.enabled:
                continue
            if fresh and (name in self._armed or action in ALWAYS):
                presses.append(action)
        return presses
