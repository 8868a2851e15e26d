"""Who may connect: what a client has to know when a server listens to more than its machine."""

from __future__ import annotations

import dataclasses
import hmac
import ipaddress
import secrets
import socket
from typing import Any, Mapping, Optional, Protocol

from aiohttp import web

TOKEN_BYTES = 12
"""Random bytes of a token that is made up."""

INSTRUCTOR = "instructor"
_ROLES = ("operator", INSTRUCTOR)
_PARAMETERS = _CLIENT, _INSTRUCTOR = "token", "instructor_token"


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
    made_up
        Those of them that nobody gave, by the parameter that would: somebody has to be told, and a
        successor has to know them.
    """

    client: str
    instructor: str
    made_up: Mapping[str, str] = dataclasses.field(default_factory=dict)


class TokenConfig(Protocol):
    """The parameters of a server that say who may connect."""

    @property
    def address(self) -> str:
        """Address that the server listens on."""

    @property
    def token(self) -> str:
        """Token of every client; may be empty."""

    @property
    def instructor_token(self) -> str:
        """Token of instructors; may be empty."""


def tokens_of(config: TokenConfig, earlier: Optional[Mapping[str, Any]] = None) -> Tokens:
    """Return the tokens to ask for; makes up what is needed and not given.

    Parameters
    ----------
    config
        The bridge's parameters.
    earlier
        `Tokens.made_up` of a bridge that has crashed: those whom it told its tokens know no others.
    """
    left = earlier or {}
    given = {name: _given(getattr(config, name), left.get(name)) for name in _PARAMETERS}
    if not given[_CLIENT] and is_loopback(config.address):
        return Tokens("", given[_INSTRUCTOR])
    made_up = {name: _made_up(left.get(name)) for name in _PARAMETERS if not given[name]}
    both = {**given, **made_up}
    return Tokens(both[_CLIENT], both[_INSTRUCTOR], made_up)


def _given(token: str, left: Any) -> str:
    # What a bridge made up that has crashed still stands among its parameters.
    return "" if token == left else token


def _made_up(left: Any) -> str:
    return left if isinstance(left, str) and left else secrets.token_urlsafe(TOKEN_BYTES)


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
    role = request.query.get("role", "operator")
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


def _token_of(request: web.Request) -> Optional[str]:
    kind, _, token = request.headers.get("Authorization", "").partition(" ")
    return token.strip() if kind.lower() == "bearer" else request.query.get("token")


def _same(given: Optional[str], token: str) -> bool:
    """Compare in a time that tells nothing of the token."""
    if given is None or not token:
        return False
    return hmac.compare_digest(given.encode("utf-8", "replace"), token.encode())


def _complaint(given: Optional[str], what: str) -> str:
    if given is None:
        return (
            f"This server asks for {what}: add ?token=... to its address; unless it was given as a "
            "parameter, it was printed when the bridge started."
        )
    return f"This is not {what} of this server."
