"""WebSocket side of the bridge."""

from __future__ import annotations

import asyncio
import contextlib
import itertools
import time
from typing import AsyncIterator, Callable, Dict, List, Optional, Set

from aiohttp import WSCloseCode, WSMsgType, web

from ..freshness import Backlog
from ..line.profiles import Profiles
from ..origins import origin_allowed
from ..rights import ExamRights, Rights
from ..server_config import RosbridgeConfig
from ..tokens import ForbiddenError, Tokens, client_name, is_instructor
from ..websockets import new_websocket, take_leave, upgrade_required
from .clients.control import Member
from .clients.outbox import Outbox
from .exam_watch import ExamWatch
from .link.downlink import Downlink
from .link.link_service import LinkService, Memory, initial_setting
from .ros import Ros
from .session import ClientSession, Shared
from .status_topics import NodeWatch, Roster

BACKLOG_POLL = 0.005
"""Period (s) at which a client that has not taken its messages yet is looked at."""

LAST_WORDS = 0.1
"""Time (s) between the last stop command and the node's end, in which the command is sent."""


_NO_TOKENS = Tokens()


class Rosbridge:
    """Accepts clients and serves each until it goes; make it on the loop's thread.

    Parameters
    ----------
    warn
        Called with what an administrator should know.
    memory
        Where the line's setting outlives a crash; None: it does not.
    """

    def __init__(
        self,
        config: RosbridgeConfig,
        ros: Ros,
        warn: Callable[[str], None],
        tokens: Tokens = _NO_TOKENS,
        memory: Optional[Memory] = None,
    ) -> None:
        self._config = config
        self._warn = warn
        self._tokens = tokens
        hidden = _hidden_cameras(ros)
        self.shared = Shared(
            config,
            ros,
            Rights.read(config.rights).hiding(hidden),
            exam_rights=ExamRights.read(config.exam_rights).hiding(hidden),
            proven=bool(tokens.instructor),
        )
        self._exam_watch = ExamWatch(self.shared, warn)
        self._roster = Roster(self.shared.control, self.shared.publishers, ros)
        self._node_watch = NodeWatch(
            ros, self.shared.publishers, self.shared.other_robots, config.simulator
        )
        profiles = Profiles.read(config.link_profiles)
        recalled = {} if memory is None else memory.recall()
        self._link = LinkService(
            self.shared.line,
            self.shared.control,
            profiles,
            initial_setting(profiles, config.link, recalled, ros.resolve("~link")),
            ros=ros,
            worker=self.shared.worker,
            publishers=self.shared.publishers,
            subscribers=self.shared.subscribers,
            warn=warn,
            memory=memory,
        )
        self._e_stop_topic = ros.resolve(config.e_stop_topic)
        self._leaving: Dict[ClientSession, None] = {}  # those whose client has gone, in order
        self._is_ending = False
        self._sockets: Set[web.WebSocketResponse] = set()
        self._places: List[bool] = []  # of each client, whether it is an instructor
        self._numbers = itertools.count(1)

    def make_app(self) -> web.Application:
        """Return the application."""
        app = web.Application()
        app.router.add_get("/{path:.*}", self.accept, allow_head=False)
        app.cleanup_ctx.append(self._keep_publishing)
        app.on_shutdown.append(self._dismiss_clients)
        return app

    async def _keep_publishing(self, _app: web.Application) -> AsyncIterator[None]:
        """Tell who is connected and missing, of exams and the line; hold the e-stop ready."""
        works = (
            self._exam_watch.run(),
            self._roster.run(),
            self._node_watch.run(),
            self.shared.actions.run(),
            self._link.run(),
            self.shared.stuck_key.run(),
            self._prepare_e_stop(),
        )
        tasks = [asyncio.ensure_future(work) for work in works]
        yield
        for task in tasks:
            task.cancel()

    async def _prepare_e_stop(self) -> None:
        """Open the topic of the e-stop in advance, so that the first one is not delayed."""
        try:
            publisher = await self.shared.publishers.acquire(
                self._e_stop_topic, "std_msgs/Bool", latch=False, queue_size=10
            )
            await publisher.settle(self._config.connect_timeout)
        except Exception as error:  # whatever ROS raises
            self._warn(f"the e-stop's topic cannot be opened: {error}")

    async def accept(self, request: web.Request) -> web.StreamResponse:
        """Serve one client."""
        if not origin_allowed(request, self._config.allowed_origins):
            origin = request.headers["Origin"]
            self._warn(
                f"refused a page of {origin[:200]!r}; if it may command the robot, add it to the "
                "parameter allowed_origins"
            )
            return web.Response(status=403, text="This page's origin may not use the bridge.\n")
        try:
            instructor = is_instructor(request, self._tokens)
        except ForbiddenError as error:
            self._warn(f"refused {request.remote}: {error}")
            return web.Response(status=error.status, text=f"{error}\n")
        if not self._has_place(instructor=instructor):
            self._warn(f"refused {request.remote}: {len(self._places)} clients are connected")
            return web.Response(status=503, text="The bridge has as many clients as it may.\n")
        websocket = new_websocket(self._config.ping_interval, self._config.max_message_size)
        if not websocket.can_prepare(request):
            return upgrade_required("This is a rosbridge v2 server; connect to it by WebSocket.\n")
        self._places.append(instructor)  # now, for others may come during the handshake
        try:
            await websocket.prepare(request)
            if request.transport is not None:
                await self._serve(request, instructor, websocket, request.transport)
        finally:
            self._places.remove(instructor)
        return websocket

    async def _serve(
        self,
        request: web.Request,
        instructor: bool,
        websocket: web.WebSocketResponse,
        transport: asyncio.Transport,
    ) -> None:
        """Serve a client that is connected."""
        outbox = Outbox(self._config.max_queue_bytes)
        session = self._make_session(request, instructor, outbox, transport)
        line = None if instructor else self.shared.line
        downlink = Downlink(outbox, line, self.shared.ros.sim_time)
        sender = asyncio.ensure_future(self._send_all(websocket, transport, downlink))
        self._sockets.add(websocket)
        try:
            await self._receive_all(websocket, session, outbox)
        finally:
            self._sockets.discard(websocket)
            sender.cancel()
            downlink.close()
            self._see_off(session)

    def _see_off(self, session: ClientSession) -> None:
        """End the session of a client that has gone, as soon as that has passed the line."""
        self._leaving[session] = None
        session.ended = lambda: self._leaving.pop(session, None)
        if self._is_ending:
            session.end()
        else:
            session.close()
        while len(self._leaving) > self._config.max_clients:
            next(iter(self._leaving)).end()

    def _has_place(self, *, instructor: bool) -> bool:
        """Tell whether one more client may connect: operators leave some places to instructors."""
        if len(self._places) >= self._config.max_clients:
            return False
        # However few there are in all, one is for operators.
        reserved = min(self._config.reserved_clients, self._config.max_clients - 1)
        operators = self._places.count(False)
        return instructor or operators < self._config.max_clients - reserved

    def _make_session(
        self,
        request: web.Request,
        instructor: bool,
        outbox: Outbox,
        transport: asyncio.Transport,
    ) -> ClientSession:
        def drop(reason: str) -> None:
            self._warn(f"dropped a client that does not read: {reason}")
            transport.abort()

        number = str(next(self._numbers))
        member = Member(number, request.remote or "", instructor, time.time())
        session = ClientSession(member, self.shared, outbox, drop)
        self.shared.control.rename(member, client_name(request))
        if request.query.get("status") == "1":
            session.set_level("warning")
        return session

    async def _receive_all(
        self, websocket: web.WebSocketResponse, session: ClientSession, outbox: Outbox
    ) -> None:
        async for message in websocket:
            if message.type == WSMsgType.TEXT:
                session.receive(message.data)
            elif message.type == WSMsgType.BINARY:
                session.report("messages must be text; binary ones are not offered")
            # A client that sends without a pause must yield to the others; one that does not read
            # its replies is not read either until it does.
            await asyncio.sleep(0)
            await outbox.room()
            await session.room()

    async def _send_all(
        self, websocket: web.WebSocketResponse, transport: asyncio.Transport, downlink: Downlink
    ) -> None:
        """Send what has passed the line; it waits there rather than in the kernel's buffers."""
        backlog = Backlog(transport, self._config.send_buffer)
        with contextlib.suppress(ConnectionError):
            while True:
                message = await downlink.get()
                if isinstance(message, str):
                    await websocket.send_str(message)
                else:
                    await websocket.send_bytes(message)
                while not backlog.clear(self._config.max_in_flight):
                    await asyncio.sleep(BACKLOG_POLL)

    async def _dismiss_clients(self, _app: web.Application) -> None:
        """Close all connections; with each its session ends and stops what it drove."""
        if not (self._sockets or self._leaving):
            return
        self._is_ending = True
        await take_leave(
            websocket.close(code=WSCloseCode.GOING_AWAY, message=b"the bridge ends")
            for websocket in tuple(self._sockets)
        )
        for session in tuple(self._leaving):
            session.end()
        await asyncio.sleep(LAST_WORDS)


def _hidden_cameras(ros: Ros) -> object:
    """Return the video server's list of cameras for instructors, None if it has none."""
    try:
        return ros.get_param(ros.resolve("video_server/hidden_cameras"))
    except KeyError:
        return None
