"""Listening sockets, and serving an application on one until told to stop; without ROS."""

from __future__ import annotations

import asyncio
import contextlib
import errno
import ipaddress
import logging
import socket
import urllib.parse
from typing import Any, Callable, Optional

from aiohttp import web
from aiohttp.http_exceptions import HttpProcessingError

SHUTDOWN_GRACE = 0.3
"""Time (s) that requests under way get to finish when the node ends."""

REQUEST_TIMEOUT = 20.0
"""Time (s) that a connection gets to deliver its first request, and the next one after each."""


def _is_own_fault(record: logging.LogRecord) -> bool:
    """Tell whether a record is about more than a request that is no HTTP, or a client that left.

    Who sends such a request is told so; a traceback for each would let anybody fill the log.
    """
    others = (HttpProcessingError, ConnectionError)
    return not (record.exc_info and isinstance(record.exc_info[1], others))


_LOGGER = logging.getLogger(__name__)
_LOGGER.addFilter(_is_own_fault)


class BindError(OSError):
    """The address cannot be served; the text names the parameter, its value and what to do."""


def bind(address: str, port: int, where: str) -> socket.socket:
    """Open a listening socket.

    Parameters
    ----------
    address
        Host name or IP address to listen on.
    port
        TCP port; 0 takes any free one.
    where
        Name of the node, for messages.

    Raises
    ------
    BindError
        The address is not one of this machine, or the port is taken or not allowed.
    """
    try:
        family, kind, protocol, _, name = socket.getaddrinfo(
            address, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE
        )[0]
    except (socket.gaierror, UnicodeError) as error:
        raise BindError(f"{where}/address: {address!r} is no address: {error}") from None
    listener = socket.socket(family, kind, protocol)
    try:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind(name)
        listener.listen(128)
    except OSError as error:
        listener.close()
        raise BindError(_bind_failure(error, address, port, where)) from None
    return listener


def bind_again(address: str, port: int, where: str, earlier_url: Any) -> socket.socket:
    """Open a listening socket, where there is a choice at the port of a server that has crashed.

    Its clients know that port, and no other.

    Parameters
    ----------
    address, port, where
        As `bind` takes them.
    earlier_url
        What that server announced, if there was one.

    Raises
    ------
    BindError
        As `bind` does.
    """
    earlier_port = _port_of(earlier_url)
    if port == 0 and earlier_port is not None:
        with contextlib.suppress(BindError):  # somebody else has it now
            return bind(address, earlier_port, where)
    return bind(address, port, where)


def _port_of(url: Any) -> Optional[int]:
    try:
        return urllib.parse.urlsplit(url).port if isinstance(url, str) else None
    except ValueError:
        return None


def _bind_failure(error: OSError, address: str, port: int, where: str) -> str:
    """Say in a sentence why a socket could not be bound, and what to do."""
    if error.errno == errno.EADDRINUSE:
        return (
            f"{where}/port: {port} on {address} is in use by another program; stop that program, "
            "or set the parameter to another port (0: any free one)"
        )
    if error.errno == errno.EACCES:
        return f"{where}/port: {port} needs root's rights; set the parameter to a port from 1024 on"
    if error.errno == errno.EADDRNOTAVAIL:
        return (
            f"{where}/address: {address!r} is not an address of this machine; set 127.0.0.1 for "
            "this machine only, 0.0.0.0 for all its networks"
        )
    return f"{where}/address: cannot listen on {address} port {port}: {error.strerror}"


def url_of(scheme: str, listener: socket.socket) -> str:
    """Return the address at which a program on this machine reaches a listening socket."""
    host, port = listener.getsockname()[:2]
    ip = ipaddress.ip_address(host.split("%")[0])
    if ip.is_unspecified:
        ip = ipaddress.ip_address("127.0.0.1" if ip.version == 4 else "::1")
    return f"{scheme}://[{ip}]:{port}" if ip.version == 6 else f"{scheme}://{ip}:{port}"


async def serve(
    app: web.Application, listener: socket.socket, stop: asyncio.Event, on_ready: Callable[[], None]
) -> None:
    """Serve an application on a socket until `stop` is set.

    A handler is cancelled as soon as its client's connection is lost, so that streams end with
    their client.
    """
    runner = web.AppRunner(
        app,
        access_log=None,
        logger=_LOGGER,
        handler_cancellation=True,
        keepalive_timeout=REQUEST_TIMEOUT,
        shutdown_timeout=SHUTDOWN_GRACE,
    )
    await runner.setup()
    try:
        await web.SockSite(runner, listener).start()
        on_ready()
        await stop.wait()
    finally:
        await runner.cleanup()
