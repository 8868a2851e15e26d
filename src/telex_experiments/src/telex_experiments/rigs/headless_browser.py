"""Headless Chromium with the console, for benchmarks; needs the tests' packages."""

from __future__ import annotations

import contextlib
import tempfile
from pathlib import Path
from typing import Any, Iterator, List

from telex_control.ros.private_master import descendants
from telex_teleop import headless_chromium


@contextlib.contextmanager
def browser(url: str, before: str = "") -> Iterator[Any]:
    """A page in a Chromium of its own, which ends with the context.

    Parameters
    ----------
    url : str
    before : str
        Script that runs in every document before the page's own.
    """
    with tempfile.TemporaryDirectory(prefix="telex-chromium-") as profile:
        driver = headless_chromium.start(profile)
        try:
            # What the page allows itself to load does not allow for what a benchmark adds to it.
            driver.execute_cdp_cmd("Page.enable", {})
            driver.execute_cdp_cmd("Page.setBypassCSP", {"enabled": True})
            driver.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": before})
            driver.get(url)
            yield driver
        finally:
            driver.quit()


def renderers(driver: Any) -> List[int]:
    """Process ids of the pages' processes."""
    found = []
    for pid in descendants(driver.service.process.pid):
        with contextlib.suppress(OSError):
            command = Path(f"/proc/{pid}/cmdline").read_bytes()
            if b"--type=renderer" in command:
                found.append(pid)
    return found
