"""Chromium without a window, for the console's tests, benchmarks and reports."""

from __future__ import annotations

import shutil
from typing import Any, Mapping, Optional

__all__ = ["FLAGS", "chromium", "lacking", "start"]

FLAGS = (
    "--headless=new",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
)
"""It asks no other host for anything, and nobody for a choice."""


def chromium() -> Optional[str]:
    """Return the program's path; None where there is none."""
    return shutil.which("chromium") or shutil.which("chromium-browser")


def lacking() -> str:
    """Return what to do to have a browser that scripts drive; empty where there is one."""
    for name, path in (("chromium", chromium()), ("chromedriver", shutil.which("chromedriver"))):
        if path is None:
            return f"{name} is not installed (apt-get install chromium chromium-driver)"
    return ""


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
    from selenium import webdriver  # only what opens a page needs it

    options = webdriver.ChromeOptions()
    options.binary_location = chromium() or ""
    for flag in (*FLAGS, "--window-size=1280,720", f"--user-data-dir={profile}", *flags):
        options.add_argument(flag)
    if logs is not None:
        options.set_capability("goog:loggingPrefs", dict(logs))
    service = webdriver.ChromeService(shutil.which("chromedriver"))
    return webdriver.Chrome(options=options, service=service)
