"""Tokens of clients, where a server listens to more than its own machine."""

from __future__ import annotations

import dataclasses
import hmac
import ipaddress
import socket
from typing import TYPE_CHECKING, Dict, Mapping, Optional, Union

from aiohttp import web

from telex_control.common.params import require

from .token_files import read_or_make_token

if TYPE_CHECKING:
    from .server_config import RosbridgeConfig, VideoServerConfig

_ROLES = OPERATOR, INSTRUCTOR = ("operator", "instructor")
MAX_NAME = 40
"""Characters of the longest name that a client may give itself."""
FILES = CLIENT_FILE, INSTRUCTOR_FILE = ("token_file", "instructor_token_file")
"""Parameters of a server that name the files of its tokens."""


class ForbiddenError(Exception):
    """The client may not connect; the text says why, `status` is that of the HTTP reply."""

    def __init__(self, status: int, sentence: str) -> None:
        super().__init__(sentence)
        self.status = status


@dataclasses.dataclass(frozen=True)
class Tokens:
    """What clients must know; an empty one asks for nothing.

    Attributes
    ----------
    client
        Of every client.
    instructor
        Of those that connect as an instructor; it is good for every other client, too.
    """

    client: str = ""
    instructor: str = ""


def files_of(
    config: Union[RosbridgeConfig, VideoServerConfig], makeshift: Mapping[str, str]
) -> Dict[str, str]:
    """Return the paths of the tokens that a server asks for, by the parameters in `FILES`.

    Parameters
    ----------
    makeshift
        The paths to use where tokens are needed and no file was given. A server that has crashed
        leaves them among its parameters, which does not mean that they were given.
    """
    parameters = {name: getattr(config, name) for name in FILES}
    given = {name: path for name, path in parameters.items() if path not in ("", makeshift[name])}
    needed = CLIENT_FILE in given or not is_loopback(config.address)
    return {**makeshift, **given} if needed else given


def read_tokens(files: Mapping[str, str], where: str) -> Tokens:
    """Read the tokens from their files, and make those files that are not there.

    Parameters
    ----------
    files
        As `files_of` returns them.
    where
        Name of the node, for messages.

    Raises
    ------
    telex_control.common.params.ConfigError
        A file cannot be used, or both hold the same.
    """
    read = {name: read_or_make_token(path, f"{where}/{name}") for name, path in files.items()}
    tokens = Tokens(read.get(CLIENT_FILE, ""), read.get(INSTRUCTOR_FILE, ""))
    require(
        not tokens.client or tokens.client != tokens.instructor,
        f"{where}: {CLIENT_FILE} and {INSTRUCTOR_FILE} hold the same token; every client would be "
        "an instructor",
    )
    return tokens


def is_loopback(address: str) -> bool:
    """Tell whether an address to listen on can be reached from this machine only."""
    try:
        found = socket.getaddrinfo(address, None, type=socket.SOCK_STREAM)
        addresses = [ipaddress.ip_address(str(entry[4][0]).split("%")[0]) for entry in found]
    except (OSError, UnicodeError, ValueError):
        return False
    return all(address.is_loopback for address in addresses)


def is_instructor(request: web.Request, tokens: Tokens) -> bool:
    """Check a client's token and return whether it connects as an instructor.

    Raises
    ------
    ForbiddenError
        The token is missing or wrong, or there is no such role.
    """
    role = request.query.get("role", OPERATOR)
    if role not in _ROLES:
        raise ForbiddenError(400, f"There is no role of this name; known are {', '.join(_ROLES)}.")
    given = _token_of(request)
    as_instructor = _same(given, tokens.instructor)
    if role == INSTRUCTOR:
        if tokens.instructor and not as_instructor:
            raise ForbiddenError(401, _complaint(given, "the instructor's token"))
        return True
    if tokens.client and not (_same(given, tokens.client) or as_instructor):
        raise ForbiddenError(401, _complaint(given, "a token"))
    return False


def client_name(request: web.Request) -> str:
    """Return what a client calls itself, by `?name=`; empty if it does not, or not in one line."""
    name = request.query.get("name", "")[:MAX_NAME]
    return name if name.isprintable() else ""


def _token_of(request: web.Request) -> Optional[str]:
    kind, _, token = request.headers.get("Authorization", "").partition(" ")
    return token.strip() if kind.lower() == "bearer" else request.query.get("token")


def _same(given: Optional[str], token: str) -> bool:
    """Compare in constant time."""
    if given is None or not token:
        return False
    return hmac.compare_digest(given.encode("utf-8", "replace"), token.encode())


def _complaint(given: Optional[str], what: str) -> str:
    if given is None:
        return (
            f"This server asks for {what}: add ?token=... to its address. The token stands in a "
            "file of whoever started it; run.sh prints it, too."
        )
    return f"This is not {what} of this server."
