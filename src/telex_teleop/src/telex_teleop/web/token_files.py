"""Tokens in files that only their user can read: not on parameters, arguments or logs."""

from __future__ import annotations

import contextlib
import os
import re
import secrets
import stat
import tempfile

from telex_control.common.params import ConfigError

TOKEN_BYTES = 12
"""Random bytes of a token that is made."""

_TOKEN = re.compile(r"[A-Za-z0-9._~-]+")
_MOST = 1024
"""Bytes that a file of a token may have."""


def read_or_make_token(path: str, where: str) -> str:
    """Return the token in a file; makes the file, mode 0600, with a fresh one if there is none.

    Parameters
    ----------
    path
        Absolute, or with a tilde at its beginning.
    where
        The parameter that names it, for messages; none of these shows what the file holds.

    Raises
    ------
    telex_control.common.params.ConfigError
        Others may read the file, it holds no token, or it cannot be read or made.
    """
    try:
        return read_token(path, where)
    except FileNotFoundError:
        pass
    try:
        _make(os.path.expanduser(path))
        return read_token(path, where)
    except OSError as error:
        raise ConfigError(f"{where}: {path!r} cannot be made: {error.strerror}") from None


def read_token(path: str, where: str) -> str:
    """Return the token in a file.

    Parameters
    ----------
    path, where
        As `read_or_make_token` takes them.

    Raises
    ------
    FileNotFoundError
        There is no such file.
    telex_control.common.params.ConfigError
        Others may read the file, it holds no token, or it cannot be read.
    """
    full = os.path.expanduser(path)
    if not os.path.isabs(full):
        raise ConfigError(f"{where}: {path!r} is no absolute path")
    try:
        # A pipe without a writer would not let it be opened.
        file = os.open(full, os.O_RDONLY | os.O_NONBLOCK)
    except FileNotFoundError:
        raise
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise ConfigError(f"{where}: {path!r} cannot be read: {reason}") from None
    try:
        _require_private(os.fstat(file), path, where)
        data = os.read(file, _MOST + 1)
    finally:
        os.close(file)
    token = data.decode("ascii", "replace").strip()
    if len(data) > _MOST or not _TOKEN.fullmatch(token):
        raise ConfigError(
            f"{where}: {path!r} holds no token: one word of letters, digits and . _ ~ - is needed; "
            "if the file is deleted, one with a fresh token is made"
        )
    return token


def _require_private(status: os.stat_result, path: str, where: str) -> None:
    """Raise a ConfigError unless this is a file that nobody else can read."""
    if not stat.S_ISREG(status.st_mode):
        raise ConfigError(f"{where}: {path!r} is no file")
    if status.st_uid != os.geteuid():
        raise ConfigError(
            f"{where}: {path!r} belongs to another user (uid {status.st_uid}), who may read the "
            "token; it must be this one's own"
        )
    mode = stat.S_IMODE(status.st_mode)
    if mode & 0o077:
        raise ConfigError(
            f"{where}: others may read {path!r} (mode {mode:04o}); delete it, for a fresh token, "
            "or chmod 600 it if nobody has read it yet"
        )


def _make(path: str) -> None:
    """Make a file with a fresh token, unless there is one meanwhile; never half of one."""
    folder = os.path.dirname(path)
    descriptor, unfinished = tempfile.mkstemp(dir=folder)  # mode 0600
    try:
        with os.fdopen(descriptor, "w") as file:
            file.write(f"{secrets.token_urlsafe(TOKEN_BYTES)}\n")
        with contextlib.suppress(FileExistsError):
            os.link(unfinished, path)
    finally:
        os.remove(unfinished)
