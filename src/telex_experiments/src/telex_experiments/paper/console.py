"""The operator's console in a headless browser."""

from __future__ import annotations

import contextlib
import tempfile
import time
from typing import Callable, Iterator, List, Set, Tuple

from selenium import webdriver
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

from telex_teleop import headless_chromium

_TIMEOUT = 120.0  # s, for a machine that has other things to do
_STEADY = 1.0
"""Time for the page to settle once all has been seen (s)."""


class ConsoleError(RuntimeError):
    """The console does not come up; the message says what is missing."""


class Console:
    """The page as an operator has it before him.

    Parameters
    ----------
    driver : WebDriver
    """

    def __init__(self, driver: webdriver.Chrome) -> None:
        self._driver = driver

    def wait_until_live(self) -> None:
        """Wait until robot and all cameras are there, and end the tour for new operators.

        Each camera has to show itself once: on a busy machine they may stall in turn, and how many
        are live together is for the caller to count.

        Raises
        ------
        ConsoleError
        """
        self._await("the link to the robot", self.is_linked)
        with contextlib.suppress(Exception):
            self._driver.find_element(By.ID, "tour-skip").click()
        seen: Set[str] = set()

        def all_seen() -> bool:
            cameras = self.thumbnails()
            seen.update(camera for camera, live in cameras if live)
            return all(camera in seen for camera, _ in cameras)

        self._await("pictures of all cameras", all_seen)
        time.sleep(_STEADY)

    def is_linked(self) -> bool:
        """Tell whether the page says that it is connected."""
        return self._driver.find_element(By.ID, "link").get_attribute("data-state") == "up"

    def thumbnails(self) -> List[Tuple[str, bool]]:
        """Return the cameras of the small views, and whether they are live."""
        found = self._driver.execute_script(
            "return [...document.querySelectorAll('.thumbnail')]"
            ".map(({dataset}) => [dataset.camera, dataset.state === 'live'])"
        )
        return [(camera, live) for camera, live in found] or [("none", False)]

    @contextlib.contextmanager
    def hold(self, key: str) -> Iterator[None]:
        """Hold a key down."""
        ActionChains(self._driver).key_down(key).perform()
        try:
            yield
        finally:
            ActionChains(self._driver).key_up(key).perform()

    def press(self, key: str) -> None:
        """Press a key of the keyboard and let go: a letter, or a name such as ``escape``."""
        character = getattr(Keys, key.upper(), key)
        ActionChains(self._driver).send_keys(character).perform()

    def show(self, camera: str) -> None:
        """Have a camera in the large view."""
        selector = f".thumbnail[data-camera={camera}]"
        self._driver.find_element(By.CSS_SELECTOR, selector).click()

    def screenshot(self) -> bytes:
        """Return the page as PNG."""
        return self._driver.get_screenshot_as_png()

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
    with tempfile.TemporaryDirectory(prefix="telex-chromium-") as profile:
        driver = headless_chromium.start(
            profile, "--hide-scrollbars", f"--window-size={size[0]},{size[1]}"
        )
        try:
            driver.execute_cdp_cmd(
                "Emulation.setDeviceMetricsOverride",
                {"width": size[0], "height": size[1], "deviceScaleFactor": 1, "mobile": False},
            )
            driver.get(url)
            yield Console(driver)
        finally:
            driver.quit()
