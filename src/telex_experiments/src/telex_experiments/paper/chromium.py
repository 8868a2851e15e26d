"""Pictures of pages and drawings, by headless Chromium."""

from __future__ import annotations

import subprocess
import tempfile
from pathlib import Path
from typing import Tuple

from telex_teleop.headless_chromium import FLAGS, chromium, lacking

_TIMEOUT = 60.0  # s


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
        command = [str(chromium()), *FLAGS, "--hide-scrollbars", f"--user-data-dir={profile}"]
        command += [f"--window-size={size[0]},{size[1]}", f"--screenshot={picture}", page.as_uri()]
        try:
            subprocess.run(command, check=True, capture_output=True, timeout=_TIMEOUT)
        except (OSError, subprocess.SubprocessError) as error:
            return f"Chromium failed: {error}"
    return "" if picture.exists() else "Chromium wrote no picture"
