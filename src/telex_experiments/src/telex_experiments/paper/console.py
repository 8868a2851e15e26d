"""The operator's console in a headless browser."""

from __future__ import annotations

import contextlib
import time
from typing import Iterator, List, Set, Tuple

from telex_experiments.rigs.chromium import BrowserError, Chromium
from telex_experiments.rigs.report import wait_until

_TIMEOUT = 120.0  # s, for a machine that has other things to do
_PERIOD = 0.1  # s, between two looks at the page
_STEADY = 1.0
"""Time for the page to settle once all has been seen (s)."""


class Console:
    """The page as an operator has it before him."""

    def __init__(self, browser: Chromium) -> None:
        self.browser = browser

    def wait_until_live(self) -> None:
        """Wait until robot and all cameras are there, and end the tour for new operators.

        Each camera has to show itself once: on a busy machine they may stall in turn, and how many
        are live together is for the caller to count.

        Raises
        ------
        MeasurementError
            They do not come.
        """
        wait_until("the console's link to the robot", self.is_linked, _TIMEOUT, _PERIOD)
        with contextlib.suppress(BrowserError):
            self.browser.click("#tour-skip")
        seen: Set[str] = set()

        def all_seen() -> bool:
            cameras = self.thumbnails()
            seen.update(camera for camera, live in cameras if live)
            return all(camera in seen for camera, _ in cameras)

        wait_until("pictures of all cameras on the console", all_seen, _TIMEOUT, _PERIOD)
        time.sleep(_STEADY)

    def is_linked(self) -> bool:
        """Tell whether the page says that it is connected."""
        return bool(
            self.browser.evaluate("document.getElementById('link')?.dataset.state === 'up'")
        )

    def thumbnails(self) -> List[Tuple[str, bool]]:
        """Return the cameras of the small views, and whether they are live."""
        found = self.browser.evaluate(
            "[...document.querySelectorAll('.thumbnail')]"
            ".map(({dataset}) => [dataset.camera, dataset.state === 'live'])"
        )
        return [(camera, live) for camera, live in found] or [("none", False)]

    @contextlib.contextmanager
    def hold(self, code: str) -> Iterator[None]:
        """Hold the key of a position down."""
        self.browser.press(code)
        try:
            yield
        finally:
            self.browser.release(code)


@contextlib.contextmanager
def opened(url: str, size: Tuple[int, int]) -> Iterator[Console]:
    """Open the console at an address, with width and height (px)."""
    with Chromium(url, size=size, exact=True) as browser:
        yield Console(browser)
