"""The station's pages in headless Chromium, as people use them."""

from __future__ import annotations

import time
from typing import Any, Callable, List

import axe
from waiting import wait_until

from telex_experiments.rigs.chromium import Chromium

RELEASED = "released: "
"""Begin of the line that the page logs when it lets go of what is held."""
PATIENCE = 6.0
"""Time (s) without any effect after which an operator presses a key anew."""


class Page:
    """A page at an address; `quit` ends the browser."""

    def __init__(self, url: str) -> None:
        self._browser = Chromium(url, listens=True)

    def quit(self) -> None:
        self._browser.close()

    def show(self, url: str) -> None:
        """Go to another page."""
        self._browser.call("Page.navigate", url=url)

    @property
    def complaints(self) -> List[str]:
        """Errors of the page so far."""
        return self._browser.complaints

    def ask(self, script: str) -> Any:
        """Return what a script returns in the page."""
        return self._browser.evaluate(f"(() => {{ {script} }})()")

    def wait_for(self, what: str, script: str) -> Any:
        """Wait until an expression on the page is true, and return its value."""
        return self._browser.wait_for(what, script)

    def click(self, selector: str) -> None:
        """Click the first element of a CSS selector."""
        self._browser.click(selector)

    def findings(self) -> List[str]:
        """What axe-core finds about the page; nothing where there is no axe-core."""
        return [] if axe.lacking() else axe.findings(self.ask)

    def text(self, element: str) -> str:
        """Text of an element, by its id; empty while it is hidden."""
        return self.ask(
            f"const e = document.getElementById('{element}'); return e.hidden ? '' : e.textContent;"
        )


class ConsolePage(Page):
    """The console, connected and with a picture.

    Parameters
    ----------
    url : str
    cameras : bool
        Whether there are pictures to wait for.
    """

    def __init__(self, url: str, cameras: bool = True) -> None:
        super().__init__(url)
        self._cameras = cameras
        self.settle()

    def settle(self) -> None:
        """Wait until an operator would begin."""
        wait_until(self.settled, "the console to be connected and to show a picture", 30.0)

    def settled(self) -> bool:
        """Tell whether an operator would begin: a page that still loads lets go of held keys."""
        view = 'document.getElementById("view")?.dataset.state === "live"'
        return self.ask(
            f"""
            return document.getElementById("link")?.dataset.state === "up"
              && {view if self._cameras else "true"}
              && document.getElementById("speed")?.textContent.includes("%");
            """
        )

    def reload(self, meanwhile: Callable[[], None] = lambda: None) -> None:
        """Load the page anew, and do something before an operator would go on."""
        self._browser.call("Page.reload")
        meanwhile()
        self.settle()

    def log(self) -> List[str]:
        """Lines of the console's log, newest first."""
        return self.ask(
            "return [...document.querySelectorAll('#log li')].map((line) => line.title);"
        )

    def hold(self, key: str, until: Callable[[], object], what: str) -> None:
        """Hold a key until something is seen, as an operator: pressed anew where it has no effect.

        On a loaded machine the page may let go, and say so, since it stood still or its commands
        came too late; or it does not take the press of a key whose node has not told it yet how
        fast it moves.
        """

        def seen() -> bool:
            if until():
                return True
            count, now = self._count_released(), time.monotonic()
            if count > released[0] or now > pressed[0] + PATIENCE:
                released[0], pressed[0] = count, now
                self.release(key)
                self.press(key)
            return False

        released, pressed = [self._count_released()], [time.monotonic()]
        self.press(key)
        try:
            wait_until(seen, what, 15.0)
        except AssertionError as error:
            raise AssertionError(
                f"{error}; the console says, newest first: {self.log()}"
            ) from error

    def press(self, key: str) -> None:
        self._browser.press(f"Key{key.upper()}")

    def release(self, key: str) -> None:
        """Let a key go, and wait until the page has taken note."""
        self._browser.handled(self._browser.key("keyUp", f"Key{key.upper()}"))

    def _count_released(self) -> int:
        lines = self.ask(
            "return [...document.querySelectorAll('#log li')]"
            ".map((line) => [line.title, line.dataset.count]);"
        )
        return sum(int(count) for title, count in lines if title.startswith(RELEASED))
