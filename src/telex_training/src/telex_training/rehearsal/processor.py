"""The processor of this machine, by its name."""

from __future__ import annotations

import contextlib
import platform
from pathlib import Path


def processor() -> str:
    """Return the name of the processor; of its kind where the system does not tell it."""
    with contextlib.suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.machine()
