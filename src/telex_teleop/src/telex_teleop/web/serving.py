"""Life of a server node: bind, announce the address, serve until told to stop, leave at once."""

from __future__ import annotations

import asyncio
import contextlib
import errno
import ipaddress
import logging
import signal
import socket
import sys
import urllib.parse
from typing import Any, Callable, Optional, Type, TypeVar

import rospy
from aiohttp import web
from aiohttp.http_exceptions import HttpProcessingError

from telex_control.common.params import ConfigError
from telex_control.ros.node_start import init_node

from .server_config import read_server_config

SHUTDOWN_GRACE = 0.3
"""Time (s) that requests under way get to finish when the node ends."""

REQUEST_TIMEOUT = 20.0
"""Time (s) that a connection gets to deliver its first request, and the next one after each."""

Config = TypeVar("Config")


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


async def _serve_until_signal(
    app: web.Application, listener: socket.socket, on_ready: Callable[[], None]
) -> None:
    loop, stop = asyncio.get_running_loop(), asyncio.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        loop.add_signal_handler(number, stop.set)

    def stop_from_ros() -> None:
        with contextlib.suppress(RuntimeError):  # the loop may have ended already
            loop.call_soon_threadsafe(stop.set)

    rospy.on_shutdown(stop_from_ros)
    await serve(app, listener, stop, on_ready)


def run_node(
    name: str,
    scheme: str,
    config_class: Type[Config],
    make_app: Callable[[Any], web.Application],
    coarse_clock: bool = False,
) -> int:
    """Run a server as a ROS node and return its exit status.

    Sets the private parameter `url` while it serves.

    Parameters
    ----------
    name
        Default name of the node.
    scheme
        Scheme of its address: http or ws.
    config_class
        Configuration dataclass with the fields `address` and `port`.
    make_app
        Makes the application from the configuration, on the loop's thread; may raise a ConfigError.
    coarse_clock
        See `telex_control.ros.node_start.init_node`.
    """
    try:
        return _run_node(name, scheme, config_class, make_app, coarse_clock)
    except KeyboardInterrupt:  # before the loop handles it: there are no clients yet
        rospy.signal_shutdown("interrupted")
        return 130


def _run_node(
    name: str,
    scheme: str,
    config_class: Type[Config],
    make_app: Callable[[Any], web.Application],
    coarse_clock: bool,
) -> int:
    try:
        # The loop handles the signals: it has clients to take leave of first.
        init_node(name, own_signals=True, coarse_clock=coarse_clock)
    except rospy.ROSException as error:
        print(f"{name}: {error}", file=sys.stderr)
        return 1
    try:
        config: Any = read_server_config(config_class, rospy.get_param("~", {}), rospy.get_name())
        # One that ends in order withdraws it.
        earlier_url = rospy.get_param("~url", None)
        listener = bind_again(config.address, config.port, rospy.get_name(), earlier_url)
    except (ConfigError, BindError) as error:
        rospy.logfatal("%s", error)
        rospy.signal_shutdown(str(error))
        return 1
    url = url_of(scheme, listener)

    def announce() -> None:
        rospy.set_param("~url", url)
        rospy.loginfo("%s serves at %s", rospy.get_name(), url)

    async def main() -> None:
        await _serve_until_signal(make_app(config), listener, announce)

    try:
        asyncio.run(main())
    except ConfigError as error:  # of a file that a parameter names
        rospy.logfatal("%s", error)
        return 1
    finally:
        _withdraw(url)
        rospy.signal_shutdown("the server has ended")
    return 0


def _withdraw(url: str) -> None:
    """Delete the announced address, unless another process has announced its own meanwhile."""
    # Without a master there is no parameter either.
    with contextlib.suppress(OSError, rospy.ROSException, KeyError):
        if rospy.get_param("~url", None) == url:
            rospy.delete_param("~url")
