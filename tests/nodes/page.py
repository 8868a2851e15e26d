"""The console's page in headless Chromium, as an operator uses it."""

from __future__ import annotations

from typing import Any, Callable, List

from robot import eventually

from telex_experiments.rigs.chromium import Chromium

RELEASED = "released: "
"""Begin of the line that the page logs when it lets go of what is held."""


class Page:
    """The console at an address, connected and with a picture; `quit` ends the browser."""

    def __init__(self, url: str) -> None:
        self._browser = Chromium(f"{url}/", listens=True)
        eventually(self.settled, 30.0, "the console to be connected and to show a picture")

    def quit(self) -> None:
        self._browser.close()

    @property
    def complaints(self) -> List[str]:
        """Errors of the page so far."""
        return self._browser.complaints

    def ask(self, script: str) -> Any:
        """Return what a script returns in the page."""
        return self._browser.evaluate(f"(() => {{ {script} }})()")

    def text(self, element: str) -> str:
        """Text of an element, by its id; empty while it is hidden."""
        return self.ask(
            f"const e = document.getElementById('{element}'); return e.hidden ? '' : e.textContent;"
        )

    def settled(self) -> bool:
        """Tell whether an operator would begin: a page that still loads lets go of held keys."""
        return self.ask(
            """
            return document.getElementById("link")?.dataset.state === "up"
              && document.getElementById("view")?.dataset.state === "live"
              && document.getElementById("speed")?.textContent.includes("%");
            """
        )

    def log(self) -> List[str]:
        """Lines of the console's log, newest first."""
        return self.ask(
            "return [...document.querySelectorAll('#log li')].map((line) => line.title);"
        )

    def hold(self, key: str, until: Callable[[], object], what: str) -> None:
        """Hold a key until something is seen, as an operator: pressed anew if the page let go.

        It lets go, and says so, when it stood still or its commands came too late, as may be on a
        loaded machine.
        """

        def seen() -> bool:
            if until():
                return True
            count = self._count_released()
            if count > released[0]:
                released[0] = count
                self.release(key)
                self.press(key)
            return False

        released = [self._count_released()]
        self.press(key)
        try:
            eventually(seen, 15.0, what)
        except AssertionError as error:
            raise AssertionError(
                f"{error}; the console says, newest first: {self.log()}"
            ) from error

    def press(self, key: str) -> None:
        self._browser.press(f"Key{key.upper()}")

    def release(self, key: str) -> None:
        self._browser.release(f"Key{key.upper()}")

    def _count_released(self) -> int:
        lines = self.ask(
            "return [...document.querySelectorAll('#log li')]"
            ".map((line) => [line.title, line.dataset.count]);"
        )
        return sum(int(count) for title, count in lines if title.startswith(RELEASED))
