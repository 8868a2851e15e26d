"""Text files of unknown origin: no larger than is meant, and UTF-8."""

from __future__ import annotations

from pathlib import Path
from typing import Type


def read_text_file(path: Path, most_bytes: int, error: Type[Exception]) -> str:
    """Read a file's text, if it is not too long.

    Parameters
    ----------
    most_bytes : int
        A longer file is refused before it is read.

    Raises
    ------
    Exception
        `error`, as ``FILE: what``.
    """
    try:
        # The size first: nobody waits for 10 MB to be read, only to hear that it is too much.
        size = path.stat().st_size
        if size > most_bytes:
            raise error(f"{path}: it has {size} bytes; at most {most_bytes} are read")
        return path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as cause:
        reason = cause.strerror if isinstance(cause, OSError) else "it is no UTF-8 text"
        raise error(f"{path}: {reason}") from cause
