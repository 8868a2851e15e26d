"""Runs the command line tools that the packages ship, as a user does."""

from __future__ import annotations

import subprocess
from typing import Callable, List

from telex_control.common.child_processes import DIES_WITH_US
from telex_experiments.rigs.private_master import end_tree


class ToolError(RuntimeError):
    """A tool did not succeed; the message holds the end of what it said."""


def rosrun(package: str, program: str, *arguments: str, say: Callable[[str], None]) -> None:
    """Run a node's program until it ends; each line that it prints is said.

    Raises
    ------
    ToolError
        Its exit status is not 0.
    """
    command = [*DIES_WITH_US, "rosrun", package, program, *arguments]
    process = subprocess.Popen(
        command,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    )
    lines: List[str] = []
    try:
        if process.stdout is not None:
            for line in process.stdout:
                lines.append(line.rstrip())
                if lines[-1] and not lines[-1].startswith(("|", "/")):
                    say(lines[-1])
        process.wait()
    finally:
        end_tree(process)
    if process.returncode != 0:
        end = "\n".join(lines[-5:])
        raise ToolError(f"{program} ended with status {process.returncode}: {end}")
