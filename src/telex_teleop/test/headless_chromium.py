"""Chromium under selenium, for the tests that touch and click what the console's page has."""

from __future__ import annotations

import shutil
from typing import Any, Mapping, Optional

from selenium import webdriver

from telex_experiments.rigs import chromium

__all__ = ["lacking", "start"]


def lacking() -> str:
    """Return what to do to have a browser that selenium drives; empty where there is one."""
    if chromium.program() and not shutil.which("chromedriver"):
        return "chromedriver is not installed (apt-get install chromium-driver)"
    return chromium.lacking()


def start(profile: str, *flags: str, logs: Optional[Mapping[str, str]] = None) -> Any:
    """Start a browser of 1280x720 pixels under selenium.

    Parameters
    ----------
    profile : str
        Folder for what it keeps; its own.
    *flags : str
        Further flags; the last one of a kind holds.
    logs : mapping of str to str, optional
        Which of its logs are kept, and from what level on, as selenium has it.

    Returns
    -------
    selenium.webdriver.Chrome
    """
    options = webdriver.ChromeOptions()
    options.binary_location = chromium.program() or ""
    for flag in (*chromium.FLAGS, "--window-size=1280,720", f"--user-data-dir={profile}", *flags):
        options.add_argument(flag)
    if logs is not None:
        options.set_capability("goog:loggingPrefs", dict(logs))
    service = webdriver.ChromeService(shutil.which("chromedriver"))
    return webdriver.Chrome(options=options, service=service)
