"""Web pages that may make a browser connect to bridge and video server."""

from __future__ import annotations

import ipaddress
import socket
from typing import Container
from urllib.parse import urlsplit

from aiohttp import web

_LOOPBACK = ("127.0.0.1", "::1", "localhost")


def origin_allowed(request: web.Request, allowed: Container[str] = ()) -> bool:
    """Tell whether the page that sends a request may do so.

    A browser lets any web page connect to a server on its own machine; without this check every
    page that an operator visits could drive the robot. Programs that are no browser send no
    origin.

    Parameters
    ----------
    allowed
        Origins allowed besides those of this machine and of the host that the client asked for;
        "*" allows all.
    """
    origin = request.headers.get("Origin")
    if origin is None or "*" in allowed or origin in allowed:
        return True
    try:
        host = urlsplit(origin).hostname
    except ValueError:
        return False
    if host in _LOOPBACK:
        return True
    # The same host as this server's, unless that is a foreign name which somebody let point here.
    return host is not None and host == request.url.host and _is_own_name(host)


def _is_own_name(host: str) -> bool:
    """Tell whether a host is given by its IP address or by this machine's own name."""
    try:
        ipaddress.ip_address(host)
    except ValueError:
        own = socket.gethostname().lower()
        return host.lower() in (own, own.partition(".")[0])
    return True
