"""Headless Chromium: pictures of pages and drawings."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import Tuple

CHROMIUM, DRIVER = "/usr/bin/chromium", "/usr/bin/chromedriver"
"""Debian's, as the browser tests find them."""

FLAGS = (
    "--headless=new",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--hide-scrollbars",
    "--no-first-run",
)
_TIMEOUT = 60.0  # s


def lacking() -> str:
    """Return what to do to have a browser; empty where there is one."""
    for program in (CHROMIUM, DRIVER):
        if shutil.which(program) is None:
            return f"{program} is not installed (apt-get install chromium chromium-driver)"
    return ""


def screenshot(page: Path, picture: Path, size: Tuple[int, int]) -> str:
    """Write a PNG of a page or drawing, with width and height (px).

    Returns
    -------
    str
        Why there is none; empty when there is.
    """
    problem = lacking()
    if problem:
        return problem
    with tempfile.TemporaryDirectory(prefix="telex-chromium-") as profile:
        command = [CHROMIUM, *FLAGS, f"--user-data-dir={profile}"]
        command += [f"--window-size={size[0]},{size[1]}", f"--screenshot={picture}", page.as_uri()]
        try:
            subprocess.run(command, check=True, capture_output=True, timeout=_TIMEOUT)
        except (OSError, subprocess.SubprocessError) as error:
            return f"Chromium failed: {error}"
    return "" if picture.exists() else "Chromium wrote no picture"
