"""Starts the rehearsal process: it steps back before it imports what takes a second to import."""

from __future__ import annotations

import os
import sys

_NICENESS = 5


def main() -> None:
    """Become an ordinary process, and serve as `rehearsal_process` does, with its arguments."""
    # The simulator may be a real-time process, whose children are real-time ones.
    os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
    os.nice(_NICENESS)
    from .process import main as serve

    serve(sys.argv[1:])


if __name__ == "__main__":
    main()
