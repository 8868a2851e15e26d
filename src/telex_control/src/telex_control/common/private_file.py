"""Files with secrets that only their user can read."""

from __future__ import annotations

import contextlib
import os
import stat
import tempfile

from .params import ConfigError


def make_private_file(path: str, content: bytes) -> None:
    """Make a file of mode 0600, whole from its first moment, unless there is one meanwhile.

    Raises
    ------
    OSError
    """
    descriptor, unfinished = tempfile.mkstemp(dir=os.path.dirname(path))  # mode 0600
    try:
        with os.fdopen(descriptor, "wb") as file:
            file.write(content)
        # A link fails where another process was quicker; its file then counts.
        with contextlib.suppress(FileExistsError):
            os.link(unfinished, path)
    finally:
        os.remove(unfinished)


def read_private_file(path: str, most: int, secret: str) -> bytes:
    """Return what a file holds that nobody but this process's user can read.

    Parameters
    ----------
    path
        Absolute, or with a tilde at its beginning.
    most
        Bytes that are read.
    secret
        What it holds, for messages; none of these shows it.

    Raises
    ------
    FileNotFoundError
        There is no such file.
    ConfigError
        Others may read it, or it cannot be read.
    """
    full = os.path.expanduser(path)
    if not os.path.isabs(full):
        raise ConfigError(f"{path!r} is no absolute path")
    try:
        # A pipe without a writer would not let it be opened.
        file = os.open(full, os.O_RDONLY | os.O_NONBLOCK)
    except FileNotFoundError:
        raise
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise ConfigError(f"{path!r} cannot be read: {reason}") from None
    try:
        _require_private(os.fstat(file), path, secret)
        return os.read(file, most)
    finally:
        os.close(file)


def _require_private(status: os.stat_result, path: str, secret: str) -> None:
    """Raise a ConfigError unless this is a file that nobody else can read."""
    if not stat.S_ISREG(status.st_mode):
        raise ConfigError(f"{path!r} is no file")
    if status.st_uid != os.geteuid():
        raise ConfigError(
            f"{path!r} belongs to another user (uid {status.st_uid}), who may read the {secret}; "
            "it must be this one's own"
        )
    mode = stat.S_IMODE(status.st_mode)
    if mode & 0o077:
        raise ConfigError(
            f"others may read {path!r} (mode {mode:04o}); delete it, for a fresh {secret}, or "
            "chmod 600 it if nobody has read it yet"
        )
