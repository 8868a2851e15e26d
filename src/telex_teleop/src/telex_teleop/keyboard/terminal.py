"""The terminal as a full screen with single keys, given back as it was whatever happens."""

from __future__ import annotations

import contextlib
import os
import select
import termios
import time
from typing import Any, List, Optional, Sequence, Tuple

from telex_teleop.keyboard.screen import ScreenLine, Style

ALTERNATE_SCREEN, NORMAL_SCREEN = "\x1b[?1049h", "\x1b[?1049l"
HIDE_CURSOR, SHOW_CURSOR = "\x1b[?25l", "\x1b[?25h"
# reports when the window gets or loses the keyboard, marks around pasted text
REPORTS_ON, REPORTS_OFF = "\x1b[?1004h\x1b[?2004h", "\x1b[?2004l\x1b[?1004l"
ASK_KITTY = "\x1b[?u"
# disambiguate 1, event types 2, shifted keys 4, all keys as sequences 8
KITTY_ON, KITTY_OFF = "\x1b[>15u", "\x1b[<u"
HOME, CLEAR_LINE, CLEAR_BELOW = "\x1b[H", "\x1b[K", "\x1b[J"
STYLES = {
    Style.NORMAL: "",
    Style.TITLE: "\x1b[1m",
    Style.GOOD: "\x1b[1;32m",
    Style.WARNING: "\x1b[1;33m",
    Style.ALARM: "\x1b[1;37;41m",
}
PLAIN = "\x1b[0m"
ANSWER_TIME = 0.2  # s; a late answer to our question must not end up in the shell


class TerminalError(RuntimeError):
    """There is no terminal to work on."""


class Terminal:
    """Context manager around a terminal.

    Parameters
    ----------
    input_fd, output_fd
        File descriptors of the terminal.

    Raises
    ------
    TerminalError
        When one of them is no terminal.
    """

    def __init__(self, input_fd: int, output_fd: int) -> None:
        if not (os.isatty(input_fd) and os.isatty(output_fd)):
            raise TerminalError(
                "keyboard_teleop needs a terminal for keys and screen; start it with rosrun "
                "in one, not from roslaunch or with its input or output redirected"
            )
        self._input = input_fd
        self._output = output_fd
        self._asked = -ANSWER_TIME
        self._kitty = False
        self._gone = False
        self._saved: List[Any] = []
        self._shown: List[ScreenLine] = []
        self._shown_size = (0, 0)

    def __enter__(self) -> Terminal:
        self._saved = termios.tcgetattr(self._input)
        raw = termios.tcgetattr(self._input)
        raw[0] &= ~(termios.ICRNL | termios.INLCR | termios.IGNCR | termios.IXON | termios.ISTRIP)
        raw[3] &= ~(termios.ICANON | termios.ECHO | termios.ISIG | termios.IEXTEN)
        raw[6][termios.VMIN], raw[6][termios.VTIME] = 1, 0
        termios.tcsetattr(self._input, termios.TCSAFLUSH, raw)
        self._write(ALTERNATE_SCREEN + HIDE_CURSOR + REPORTS_ON)
        self.ask()
        return self

    def __exit__(self, *exception: object) -> None:
        kitty_off = KITTY_OFF if self._kitty else ""
        self._write(kitty_off + REPORTS_OFF + PLAIN + SHOW_CURSOR + NORMAL_SCREEN)
        time.sleep(max(0.0, self._asked + ANSWER_TIME - time.monotonic()))
        # the terminal may have hung up, and then there is nothing to restore
        with contextlib.suppress(termios.error):
            termios.tcsetattr(self._input, termios.TCSAFLUSH, self._saved)

    def read(self, timeout: float) -> Optional[bytes]:
        """Return what was typed within a time (s), empty when nothing was, None at its end."""
        if self._gone:
            return None
        ready, _, _ = select.select([self._input], [], [], timeout)
        if not ready:
            return b""
        try:
            data = os.read(self._input, 4096)
        except OSError:
            # the other end of the line has hung up
            return None
        return data or None

    def answer(self, exact: bool) -> None:
        """Take the terminal's answer that it speaks the kitty protocol; have it report releases."""
        if not exact and not self._kitty:
            self._kitty = True
            self._write(KITTY_ON)
            # the second answer tells from which byte on its reports are exact
            self.ask()

    def ask(self) -> None:
        """Ask whether it speaks the kitty protocol; a terminal that does answers at once."""
        self._asked = time.monotonic()
        self._write(ASK_KITTY)

    def size(self) -> Tuple[int, int]:
        """Return columns and lines."""
        try:
            size = os.get_terminal_size(self._output)
        except OSError:
            return 80, 24
        return (size.columns or 80, size.lines or 24)

    def show(self, lines: Sequence[ScreenLine]) -> None:
        """Show lines, writing only when something has changed."""
        size = self.size()
        if list(lines) == self._shown and size == self._shown_size:
            return
        self._shown, self._shown_size = list(lines), size
        rows = [f"{STYLES[line.style]}{line.text}{PLAIN}{CLEAR_LINE}" for line in lines]
        self._write(HOME + "\r\n".join(rows) + CLEAR_BELOW)

    def _write(self, text: str) -> None:
        data = text.encode("utf-8", "replace")
        try:
            while data:
                data = data[os.write(self._output, data) :]
        except OSError:
            # Hung up. The next read ends the program, which first stops the robot.
            self._gone = True
