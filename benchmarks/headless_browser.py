"""Headless Chromium with the console, for benchmarks; needs the tests' packages."""

from __future__ import annotations

import contextlib
import shutil
import tempfile
from pathlib import Path
from typing import Any, Iterator, List

from telex_control.private_master import descendants


@contextlib.contextmanager
def browser(url: str, before: str = "") -> Iterator[Any]:
    """A page in a Chromium of its own, which ends with the context.

    Parameters
    ----------
    url : str
    before : str
        Script that runs in every document before the page's own.
    """
    from selenium import webdriver  # only what opens a page needs it

    options = webdriver.ChromeOptions()
    options.binary_location = shutil.which("chromium") or shutil.which("chromium-browser") or ""
    with tempfile.TemporaryDirectory(prefix="telex-chromium-") as profile:
        for flag in (
            "--headless=new",
            "--no-sandbox",
            "--disable-gpu",
            "--disable-background-networking",
            "--no-first-run",
            "--disable-component-update",
            "--disable-sync",
            "--window-size=1280,720",
            f"--user-data-dir={profile}",
        ):
            options.add_argument(flag)
        service = webdriver.chrome.service.Service(shutil.which("chromedriver"))
        driver = webdriver.Chrome(options=options, service=service)
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
