"""The keyboard: key events in, commands and a screen out."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Callable, FrozenSet, List

from telex_teleop.actions.grammar import Action, Command, Lamps, is_momentary
from telex_teleop.keyboard.decoding import Event, FocusEvent, KeyDecoder, KeyEvent, KeyKind
from telex_teleop.keyboard.held import HeldKeys
from telex_teleop.keyboard.map import KeyboardSettings, KeyMap
from telex_teleop.keyboard.screen import ScreenLine, ScreenState, render
from telex_teleop.keyboard.terminal_check import TerminalCheck
from telex_teleop.operating.commander import Commander, FixedRates

if TYPE_CHECKING:
    from telex_teleop.keyboard.robot_status import ShownRobot
    from telex_teleop.keyboard.terminal import Terminal

IDLE_PERIOD = 0.05  # s between two looks at the terminal while no key is held
# What an operator may have meant for good while the program did not listen.
NEVER_TOO_LATE = (Command.STOP, Command.E_STOP, Command.QUIT)


class KeyboardTeleop:
    """Drives a robot from the keys of a terminal."""

    def __init__(self, settings: KeyboardSettings, robot: ShownRobot, terminal: Terminal) -> None:
        self._settings = settings
        self._robot = robot
        self._terminal = terminal
        self._decoder = KeyDecoder({**settings.key_map.actions, **settings.cartesian_map.actions})
        self._line = TerminalCheck()
        self._held = HeldKeys(settings.tap_time, settings.key_timeout)
        self._commander = Commander(
            FixedRates(
                settings.jog_rate,
                settings.linear,
                settings.angular,
                settings.tool_linear,
                settings.tool_angular,
            )
        )
        self._ended = False
        self._cartesian = False
        self._exact_keys = False
        self._show_help = False
        self._sent_at = 0.0
        self._sent: FrozenSet[Action] = frozenset()

    def run(self, interrupted: Callable[[], bool]) -> None:
        """Work until the operator quits, the terminal ends, or `interrupted` says so.

        However it ends, what was moving is told to stop.
        """
        drawn = 0.0
        last = time.monotonic()
        try:
            while not (self._ended or interrupted()):
                data = self._terminal.read(self._wait())
                now = time.monotonic()
                if data is None:
                    break
                late = now - last > self._settings.longest_gap
                last = now
                if data:
                    self.hear(now)
                self.take(self._decoder.feed(data, now), now, late)
                self.check_line(now)
                self.send(now)
                if now - drawn >= 1.0 / self._settings.redraw_rate:
                    drawn = now
                    self._terminal.show(self.picture(now))
        finally:
            self._robot.send(self._commander.update(()))

    def take(self, events: List[Event], now: float, late: bool = False) -> None:
        """Act on events.

        Parameters
        ----------
        now
            When it was read (monotonic time, s).
        late
            The program was held up before: what the keys did meanwhile is unknown, and what was
            typed long ago is no command any more, unless it is to stop.
        """
        for event in events:
            if isinstance(event, KeyEvent):
                self._take_key(event, now, late)
            elif isinstance(event, FocusEvent):
                if not event.gained:
                    self._held.release_all(now)
            else:
                self._exact_keys = event.exact
                self._terminal.answer(event.exact)
        if late:
            self._held.release_all(now)

    def hear(self, now: float) -> None:
        """Take note that the terminal said something at `now` (monotonic time, s)."""
        self._line.hear(now)

    def check_line(self, now: float) -> None:
        """Release the keys whose release a dead line would never report."""
        if self._line.dead(self._held.exact, now):
            self._held.release_all(now)
        elif self._line.asks(now):
            self._terminal.ask()

    def send(self, now: float) -> None:
        """Send what the held keys command: at once when it has changed, else at the send rate."""
        cartesian = self._robot.mode == "CARTESIAN"
        if cartesian != self._cartesian:
            # what is held was pressed for something else
            self._cartesian = cartesian
            self._held.release_all(now)
        held = self._held_actions(now)
        due = now - self._sent_at >= 1.0 / self._settings.send_rate
        if held != self._sent or (due and self._commander.busy):
            self._sent, self._sent_at = held, now
            self._robot.send(self._commander.update(held))

    def picture(self, now: float) -> List[ScreenLine]:
        """Return the screen at `now`."""
        robot = self._robot
        state = ScreenState(
            robot=robot.namespace,
            exact_keys=self._exact_keys,
            mode=robot.mode,
            speed_scale=robot.speed_scale,
            e_stop=robot.e_stop,
            nodes=robot.node_views(),
            joints=robot.joint_views(),
            drive=robot.driven,
            held=self._held_actions(now),
            notice=robot.notice,
            tool=robot.tool,
            arm_notice=robot.arm_notice,
            zoom=robot.zoom,
            lit=robot.lit,
        )
        columns, lines = self._terminal.size()
        settings = self._settings
        return render(self._key_map, settings.lengths, state, columns, lines, self._show_help)

    @property
    def _key_map(self) -> KeyMap:
        settings = self._settings
        return settings.cartesian_map if self._cartesian else settings.key_map

    def _wait(self) -> float:
        busy = self._commander.busy or self._decoder.incomplete
        return 1.0 / self._settings.send_rate if busy else IDLE_PERIOD

    def _held_actions(self, now: float) -> FrozenSet[Action]:
        actions = (self._key_map.action(name) for name in self._held.names(now))
        return frozenset(
            action for action in actions if action is not None and not is_momentary(action)
        )

    def _take_key(self, event: KeyEvent, now: float, late: bool) -> None:
        went_down = self._held.take(event, now)
        action = self._key_map.action(event.name)
        if action is None or not is_momentary(action) or event.kind is KeyKind.RELEASED:
            return
        if late and action not in NEVER_TOO_LATE:
            return
        # A stop is done however often it comes; of the others only the press counts.
        if action is Command.STOP:
            self._stop(now)
        elif action is Command.E_STOP:
            self._stop(now)
            self._robot.set_e_stop(True)
        elif went_down:
            self._do(action)

    def _stop(self, now: float) -> None:
        self._held.release_all(now)
        self._sent = frozenset()
        self._robot.send(self._commander.stop(self._key_map.actions.values()))

    def _do(self, command: Action) -> None:
        self._robot.notice = ""
        if isinstance(command, Lamps):
            self._robot.switch_lamps(command.names)
        elif command is Command.RELEASE_E_STOP:
            self._robot.set_e_stop(False)
        elif command is Command.FASTER:
            self._robot.change_speed(1, self._settings.speed_step)
        elif command is Command.SLOWER:
            self._robot.change_speed(-1, self._settings.speed_step)
        elif command is Command.MODE:
            self._robot.toggle_mode()
        elif command is Command.FRAME:
            self._robot.next_frame()
        elif command is Command.HOLD_TOOL:
            self._robot.toggle_hold()
        elif command is Command.GUARD:
            self._robot.toggle_guard()
        elif command is Command.BOOKMARK:
            self._robot.set_bookmark()
        elif command is Command.GO_BACK:
            self._robot.go_back()
        elif command is Command.HELP:
            self._show_help = not self._show_help
        elif command is Command.QUIT:
            self._ended = True
