"""Tokens in files that only their user can read: not on parameters, arguments or logs."""

from __future__ import annotations

import os
import re
import secrets

from telex_control.common.params import ConfigError
from telex_control.common.private_file import make_private_file, read_private_file

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
        token = f"{secrets.token_urlsafe(TOKEN_BYTES)}\n"
        make_private_file(os.path.expanduser(path), token.encode())
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
    try:
        data = read_private_file(path, _MOST + 1, "token")
    except ConfigError as error:
        raise ConfigError(f"{where}: {error}") from None
    token = data.decode("ascii", "replace").strip()
    if len(data) > _MOST or not _TOKEN.fullmatch(token):
        raise ConfigError(
            f"{where}: {path!r} holds no token: one word of letters, digits and . _ ~ - is needed; "
            "if the file is deleted, one with a fresh token is made"
        )
    return token
