"""Opening and closing of clients' WebSockets, for bridge and video server."""

from __future__ import annotations

import asyncio
from typing import Any, Coroutine, Iterable

from aiohttp import web

CLOSE_TIMEOUT = 0.2
"""Time (s) that a client gets to answer the closing handshake."""


def new_websocket(ping_interval: float, max_message_size: int) -> web.WebSocketResponse:
    """Return a WebSocket that is to be prepared.

    Parameters
    ----------
    ping_interval
        Time (s) between two pings; a client that does not answer one is gone.
    max_message_size
        Bytes of the longest message taken from the client.
    """
    return web.WebSocketResponse(
        heartbeat=ping_interval,
        max_msg_size=max_message_size,
        compress=False,
        timeout=CLOSE_TIMEOUT,
    )


def upgrade_required(text: str) -> web.Response:
    """Return the answer to a request that asks for no WebSocket; `text` says what stands here."""
    return web.Response(status=426, text=text, headers={"Upgrade": "websocket"})


async def take_leave(closings: Iterable[Coroutine[Any, Any, object]]) -> None:
    """Close connections side by side, and wait no longer than twice the time that each may take."""
    farewells = [asyncio.ensure_future(closing) for closing in closings]
    if farewells:
        await asyncio.wait(farewells, timeout=2 * CLOSE_TIMEOUT)
