"""Garbage on every topic and service of the robot while the console's simulator runs."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from typing import List

from telex_experiments.console.rig import ConsoleRig
from telex_experiments.rigs.report import Figure, MeasurementError

from ..workspace import ROOT

_PROGRAM = ROOT / "tests" / "nodes" / "garbage.py"


def garbage(rig: ConsoleRig, seconds: float) -> List[Figure]:
    """Throw garbage for `seconds`, with everything else as an operator has it."""
    done = subprocess.run(
        [sys.executable, str(_PROGRAM), str(seconds)],
        env={**os.environ, "ROS_NAMESPACE": "/telex"},
        capture_output=True,
        text=True,
        timeout=seconds + 120.0,
        check=False,
    )
    if done.returncode:
        raise MeasurementError(f"no garbage was thrown:\n{done.stderr[-2000:]}")
    result = json.loads(done.stdout.splitlines()[-1])
    growth = result["growth"]
    most = max(growth, key=growth.get)
    rig.reset()
    return [
        Figure("garbage: messages and calls", result["messages"] + result["calls"]),
        Figure("garbage: nodes that ended", len(result["lost"]), at_most=0),
        Figure("garbage: the base moved", 1e3 * result["moved"], "mm", at_most=10.0),
        Figure("garbage: a joint beyond its limits", result["beyond"], "rad or m", at_most=0.005),
        Figure("garbage: worst real-time factor in a second", result["factor"], "", 0.95),
        Figure(f"garbage: memory, most at {most}", growth[most], "MB", at_most=10.0),
    ]
