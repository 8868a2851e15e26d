"""Life of a server node: bind, announce the address, serve until told to stop, end at once."""

from __future__ import annotations

import asyncio
import contextlib
import signal
import socket
import sys
from typing import Any, Callable, Mapping, Type, TypeVar

import rospy
from aiohttp import web

from telex_control.common.params import ConfigError
from telex_control.ros.node_start import init_node

from .listening import BindError, bind_again, serve, url_of
from .server_config import read_server_config

Config = TypeVar("Config")


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
    **start: bool,
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
    start
        Further arguments of `telex_control.ros.node_start.init_node`.
    """
    try:
        return _run_node(name, scheme, config_class, make_app, start)
    except KeyboardInterrupt:  # before the loop handles it: there are no clients yet
        rospy.signal_shutdown("interrupted")
        return 130


def _run_node(
    name: str,
    scheme: str,
    config_class: Type[Config],
    make_app: Callable[[Any], web.Application],
    start: Mapping[str, bool],
) -> int:
    try:
        # The loop handles the signals: it has to disconnect its clients first.
        init_node(name, own_signals=True, **start)
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
