"""WebSocket side of the bridge."""

from __future__ import annotations

import asyncio
import contextlib
import ipaddress
import itertools
import socket
from typing import Callable, Set
from urllib.parse import urlsplit

from aiohttp import WSCloseCode, WSMsgType, web

from ..config import RosbridgeConfig
from ..freshness import Backlog
from ..workers import OrderedWorker
from .feeds import FeedPool
from .outbox import Outbox
from .publishers import PublisherPool
from .ros import Ros
from .services import ServiceDesk
from .session import ClientSession

BACKLOG_POLL = 0.005
"""Period (s) at which a client that has not taken its messages yet is looked at."""

LAST_WORDS = 0.1
"""Time (s) between the last stop command and the node's end, for it to get out."""

CLOSE_TIMEOUT = 0.2
"""Time (s) that a client gets to answer the closing handshake."""

_LOOPBACK = ("127.0.0.1", "::1", "localhost")


def origin_allowed(request: web.Request, allowed: Set[str]) -> bool:
    """Tell whether the page that opens a connection may do so.

    A browser lets any web page connect to a server on its own machine; without this check every
    page that an operator visits could drive the robot. Programs that are no browser send no
    origin.

    Parameters
    ----------
    request
        The WebSocket's HTTP request.
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
    # The same host as the bridge's, unless that is a foreign name which somebody let point here.
    return host is not None and host == request.url.host and _is_own_name(host)


def _is_own_name(host: str) -> bool:
    """Tell whether a host is given by its IP address or by this machine's own name."""
    try:
        ipaddress.ip_address(host)
    except ValueError:
        own = socket.gethostname().lower()
        return host.lower() in (own, own.partition(".")[0])
    return True


class Rosbridge:
    """Accepts clients and serves each until it goes; make it on the loop's thread.

    Parameters
    ----------
    config
        The node's parameters.
    ros
        ROS.
    warn
        Called with what an administrator should know.
    """

    def __init__(self, config: RosbridgeConfig, ros: Ros, warn: Callable[[str], None]) -> None:
        self._config = config
        self._ros = ros
        self._warn = warn
        self._worker = OrderedWorker("bridge to ROS")
        self.publishers = PublisherPool(ros, self._worker)
        self.feeds = FeedPool(ros, self._worker)
        self._services = ServiceDesk(ros, self._worker, config.service_timeout)
        self._clients: Set[web.WebSocketResponse] = set()
        self._numbers = itertools.count(1)

    def make_app(self) -> web.Application:
        """Return the application."""
        app = web.Application()
        app.router.add_get("/{path:.*}", self.accept, allow_head=False)
        app.on_shutdown.append(self._dismiss_clients)
        return app

    async def accept(self, request: web.Request) -> web.StreamResponse:
        """Serve one client."""
        if not origin_allowed(request, set(self._config.allowed_origins)):
            origin = request.headers["Origin"]
            self._warn(
                f"refused a page of {origin[:200]!r}; if it may command the robot, add it to the "
                "parameter allowed_origins"
            )
            return web.Response(status=403, text="This page's origin may not use the bridge.\n")
        websocket = web.WebSocketResponse(
            heartbeat=self._config.ping_interval,
            max_msg_size=self._config.max_message_size,
            compress=False,
            timeout=CLOSE_TIMEOUT,
        )
        if not websocket.can_prepare(request):
            return web.Response(
                status=426,
                text="This is a rosbridge v2 server; connect to it by WebSocket.\n",
                headers={"Upgrade": "websocket"},
            )
        await websocket.prepare(request)
        transport = request.transport
        if transport is None:
            return websocket
        outbox = Outbox(self._config.max_queue_bytes)
        session = self._make_session(outbox, transport)
        sender = asyncio.ensure_future(self._send_all(websocket, transport, outbox))
        self._clients.add(websocket)
        try:
            await self._receive_all(websocket, session)
        finally:
            self._clients.discard(websocket)
            sender.cancel()
            session.close()
        return websocket

    def _make_session(self, outbox: Outbox, transport: asyncio.Transport) -> ClientSession:
        def drop(reason: str) -> None:
            self._warn(f"dropped a client that does not read: {reason}")
            transport.abort()

        return ClientSession(
            str(next(self._numbers)),
            self._config,
            self._ros,
            publishers=self.publishers,
            feeds=self.feeds,
            services=self._services,
            outbox=outbox,
            drop=drop,
        )

    async def _receive_all(self, websocket: web.WebSocketResponse, session: ClientSession) -> None:
        async for message in websocket:
            if message.type == WSMsgType.TEXT:
                session.receive(message.data)
            elif message.type == WSMsgType.BINARY:
                session.report("messages must be text; binary ones are not offered")

    async def _send_all(
        self, websocket: web.WebSocketResponse, transport: asyncio.Transport, outbox: Outbox
    ) -> None:
        """Send what is in the outbox, and let it wait there rather than in the kernel's buffers."""
        backlog = Backlog(transport, self._config.send_buffer)
        with contextlib.suppress(ConnectionError):
            while True:
                await websocket.send_str(await outbox.get())
                while not backlog.clear(self._config.max_in_flight):
                    await asyncio.sleep(BACKLOG_POLL)

    async def _dismiss_clients(self, _app: web.Application) -> None:
        """Close all connections; with each its session ends and stops what it drove."""
        if not self._clients:
            return
        farewells = [
            asyncio.ensure_future(
                websocket.close(code=WSCloseCode.GOING_AWAY, message=b"the bridge ends")
            )
            for websocket in tuple(self._clients)
        ]
        await asyncio.wait(farewells, timeout=2 * CLOSE_TIMEOUT)
        await asyncio.sleep(LAST_WORDS)
