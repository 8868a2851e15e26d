"""The end of a command line whose reader has gone, as with ``| head``: no traceback."""

from __future__ import annotations

import os
import sys
from typing import Callable, Optional

SIGPIPE_STATUS = 141
"""Exit status of a program that SIGPIPE ended, by convention of shells."""


def ending_quietly(main: Callable[[], Optional[int]]) -> Optional[int]:
    """Run a command line; once nobody reads its standard output any more, end the process.

    Parameters
    ----------
    main : callable
        Prints, and returns an exit status or raises SystemExit.

    Returns
    -------
    int, optional
        What `main` returned.

    Raises
    ------
    SystemExit
        That of `main`; with `SIGPIPE_STATUS`, the reader has gone.
    BrokenPipeError
        Another pipe than standard output broke.
    """
    try:
        try:
            return main()
        finally:
            # What is buffered yet would fail only as the interpreter ends, where nobody catches it.
            sys.stdout.flush()
    except BrokenPipeError:
        if not _reader_has_gone():
            raise
    # The interpreter flushes once more.
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    sys.exit(SIGPIPE_STATUS)


def _reader_has_gone() -> bool:
    try:
        os.write(sys.stdout.fileno(), b"\n")
    except BrokenPipeError:
        return True
    return False
