"""Settings of the Python interpreter for a process with a control loop."""

from __future__ import annotations

import gc
import sys

SWITCH_INTERVAL = 5e-4
"""After this time (s) a thread that computes hands the interpreter back to the loop."""


def prepare_for_loop() -> None:
    """Keep other threads and the garbage collector from holding the control loop up.

    A full collection looks at every object, also at the tens of thousands that were made by
    imports and will stay: 40 ms, in the middle of a cycle. They are set aside. Call it when
    everything is made that lives as long as the process.
    """
    sys.setswitchinterval(SWITCH_INTERVAL)
    gc.collect()
    gc.freeze()
