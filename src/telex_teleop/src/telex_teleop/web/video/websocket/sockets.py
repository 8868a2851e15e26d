"""The WebSocket side of the video server: everybody who is connected to `/video`."""

from __future__ import annotations

import asyncio
import contextlib
from typing import Awaitable, Callable, Dict, Set

from aiohttp import web

from ...exam.exam_list import Exam
from ...line.line import Line
from ...server_config import VideoServerConfig
from ...websockets import new_websocket, take_leave, upgrade_required
from ..cameras import CameraList
from ..hub import PictureHubs
from ..topics import Topics
from ..viewers import client_of
from .multiplex import VideoClient

CAMERAS_PERIOD = 2.0
"""Period (s) at which the published topics are looked at while somebody is connected."""

MAX_MESSAGE_SIZE = 16384
"""Bytes of the longest message taken from a client."""


class VideoSockets:
    """Accepts clients of `/video`; make it on the loop's thread.

    Parameters
    ----------
    namespace
        The node's namespace, with slashes around it.
    topics
        Asks for the published topics; may raise OSError.
    line
        What passes between the robot and clients that are no instructors.
    sim_time
        Its clock (s).
    exam
        What operators may see while an exam runs.
    """

    def __init__(
        self,
        config: VideoServerConfig,
        namespace: str,
        hubs: PictureHubs,
        topics: Callable[[], Awaitable[Topics]],
        *,
        line: Line,
        sim_time: Callable[[], float],
        exam: Exam,
    ) -> None:
        self._exam = exam
        self._config = config
        self._hubs = hubs
        self._topics = topics
        self._line = line
        self._sim_time = sim_time
        self._cameras: Dict[bool, CameraList] = {
            False: CameraList(namespace, config.hidden_cameras),
            True: CameraList(namespace),
        }
        self._clients: Set[VideoClient] = set()

    async def accept(self, request: web.Request, *, instructor: bool) -> web.StreamResponse:
        """Serve one client, an instructor with the hidden cameras."""
        websocket = new_websocket(self._config.ping_interval, MAX_MESSAGE_SIZE)
        if not websocket.can_prepare(request):
            return upgrade_required("This address is a WebSocket; see docs/engineer/video.md\n")
        await self._look()
        await websocket.prepare(request)
        transport = request.transport
        if transport is None:
            return websocket
        client = VideoClient(
            websocket,
            transport,
            client_of(request, transport),
            self._cameras[instructor],
            self._hubs,
            max_size=self._config.max_size,
            send_buffer=self._config.send_buffer,
            preview_rate=self._config.preview_rate,
            line=None if instructor else self._line,
            sim_time=self._sim_time,
            exam=None if instructor else self._exam,
        )
        self._clients.add(client)
        try:
            await client.serve()
        finally:
            self._clients.discard(client)
        return websocket

    async def follow_cameras(self) -> None:
        """Look for new cameras for as long as somebody is connected, for ever."""
        while True:
            await asyncio.sleep(CAMERAS_PERIOD)
            if self._clients:
                await self._look()
                for client in tuple(self._clients):
                    with contextlib.suppress(ConnectionError):
                        await client.cameras_changed()

    def review(self) -> None:
        """End what operators may not see any more."""
        for client in self._clients:
            client.review()

    async def dismiss(self) -> None:
        """Close all connections."""
        await take_leave(client.dismiss() for client in self._clients)

    async def _look(self) -> None:
        # Without a master the cameras stay those that are known.
        with contextlib.suppress(OSError):
            topics = await self._topics()
            for cameras in self._cameras.values():
                cameras.update(topics)
