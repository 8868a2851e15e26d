"""The operator's console in a headless browser."""

from __future__ import annotations

import contextlib
import time
from typing import Callable, Iterator, List, Set, Tuple

from telex_experiments.rigs.chromium import BrowserError, Chromium

_TIMEOUT = 120.0  # s, for a machine that has other things to do
_STEADY = 1.0
"""Time for the page to settle once all has been seen (s)."""


class ConsoleError(RuntimeError):
    """The console does not come up; the message says what is missing."""


class Console:
    """The page as an operator has it before him."""

    def __init__(self, browser: Chromium) -> None:
        self._browser = browser

    def wait_until_live(self) -> None:
        """Wait until robot and all cameras are there, and end the tour for new operators.

        Each camera has to show itself once: on a busy machine they may stall in turn, and how many
        are live together is for the caller to count.

        Raises
        ------
        ConsoleError
        """
        self._await("the link to the robot", self.is_linked)
        with contextlib.suppress(BrowserError):
            self._browser.click("#tour-skip")
        seen: Set[str] = set()

        def all_seen() -> bool:
            cameras = self.thumbnails()
            seen.update(camera for camera, live in cameras if live)
            return all(camera in seen for camera, _ in cameras)

        self._await("pictures of all cameras", all_seen)
        time.sleep(_STEADY)

    def is_linked(self) -> bool:
        """Tell whether the page says that it is connected."""
        return bool(
            self._browser.evaluate("document.getElementById('link')?.dataset.state === 'up'")
        )

    def thumbnails(self) -> List[Tuple[str, bool]]:
        """Return the cameras of the small views, and whether they are live."""
        found = self._browser.evaluate(
            "[...document.querySelectorAll('.thumbnail')]"
            ".map(({dataset}) => [dataset.camera, dataset.state === 'live'])"
        )
        return [(camera, live) for camera, live in found] or [("none", False)]

    @contextlib.contextmanager
    def hold(self, key: str) -> Iterator[None]:
        """Hold a key down: a letter, or a name such as ``escape``."""
        self._browser.press(_code(key))
        try:
            yield
        finally:
            self._browser.release(_code(key))

    def press(self, key: str) -> None:
        """Press a key and let go."""
        with self.hold(key):
            pass

    def show(self, camera: str) -> None:
        """Have a camera in the large view."""
        self._browser.click(f".thumbnail[data-camera={camera}]")

    def screenshot(self) -> bytes:
        """Return the page as PNG."""
        return self._browser.screenshot()

    @staticmethod
    def _await(what: str, condition: Callable[[], bool]) -> None:
        end = time.monotonic() + _TIMEOUT
        while not condition():
            if time.monotonic() > end:
                raise ConsoleError(f"the console shows no sign of {what} within {_TIMEOUT:g} s")
            time.sleep(0.1)


@contextlib.contextmanager
def opened(url: str, size: Tuple[int, int]) -> Iterator[Console]:
    """Open the console at an address, with width and height (px)."""
    with Chromium(url, size=size, exact=True) as browser:
        yield Console(browser)


def _code(key: str) -> str:
    """Return a key's position on the keyboard."""
    return f"Key{key.upper()}" if len(key) == 1 else key.capitalize()
