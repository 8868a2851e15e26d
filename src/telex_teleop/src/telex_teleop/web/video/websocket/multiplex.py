"""All cameras over one WebSocket: one client of `/video`."""

from __future__ import annotations

import asyncio
import contextlib
import itertools
import json
import time
from typing import Any, Callable, Dict, Hashable, List, Optional, Set

from aiohttp import WSCloseCode, WSMessage, WSMsgType, web

from ...exam.exam_list import Exam
from ...freshness import Backlog
from ...line.line import Line
from ...link.uplink import Sent, Uplink
from ..cameras import Camera, CameraList
from ..hub import EncoderFullError, PictureHubs
from ..late.held_pictures import HeldPictures, LateViewer
from ..topics import PictureTopic
from ..viewers import Viewer
from .feed import Feed
from .frame_head import binary_frame_head
from .messages import VERSION, Ack, Message, Ping, ProtocolError, Show, WantedView, parse

BACKLOG_POLL = 0.005
"""Period (s) at which a client whose connection is full is looked at."""

MAX_REPLY_BACKLOG = 65536
"""Bytes of replies that may wait for a client before it counts as one that does not read."""


PING_COST = 5.0
SHOW_COST = 20.0
"""What messages of a client cost of the patience with it, by the work that they make."""

SHOW_BYTES = 200
"""Size (bytes) of such a message on a capped line, near enough."""

ACK_COST = 1.0
"""What each picture costs that is acknowledged."""

ERROR_COST = 50.0
"""What a message costs that cannot be used."""


class Patience:
    """How much of a client's chatter is taken before it is sent away: what fits into a bucket.

    Six cameras at 60 pictures a second are acknowledged 360 times; `REFILL` come back per second.
    """

    CAPACITY = 2000.0
    REFILL = 1000.0

    def __init__(self) -> None:
        self._left = self.CAPACITY
        self._since = time.monotonic()

    def spend(self, cost: float) -> bool:
        """Take note of a message; False when there is no patience left."""
        now = time.monotonic()
        self._left = min(self.CAPACITY, self._left + (now - self._since) * self.REFILL) - cost
        self._since = now
        return self._left > 0.0


class VideoClient:
    """Serves one client: what it asks for, and pictures as it acknowledges them.

    Parameters
    ----------
    client
        Whose share of the encoder's time its pictures take.
    cameras
        All cameras.
    max_size
        Largest width and height (pixels) that the client may ask for.
    send_buffer
        Size of the kernel's send buffer (bytes).
    preview_rate
        Rate (1/s) up to which a view may get the camera's preview.
    line
        What passes between it and the server; None: nothing, as for instructors.
    sim_time
        The line's clock (s).
    exam
        The exam whose list holds for the client while it runs; None: there is none.
    """

    def __init__(
        self,
        websocket: web.WebSocketResponse,
        transport: asyncio.Transport,
        client: Hashable,
        cameras: CameraList,
        hubs: PictureHubs,
        *,
        max_size: int,
        send_buffer: int,
        preview_rate: float,
        line: Optional[Line],
        sim_time: Callable[[], float],
        exam: Optional[Exam] = None,
    ) -> None:
        self._websocket = websocket
        self._transport = transport
        self._client = client
        self._cameras = cameras
        self._hubs = hubs
        self._max_size = max_size
        self._preview_rate = preview_rate
        self._exam = exam
        self._backlog = Backlog(transport, send_buffer)
        self._uplink = Uplink(line, sim_time)
        self._held = None if line is None else HeldPictures(line, sim_time)
        self._viewers: Dict[Feed, Viewer] = {}
        self._views: List[WantedView] = []
        self._feeds: Dict[str, Feed] = {}
        self._told: Optional[List[Dict[str, str]]] = None
        self._is_full = asyncio.Event()
        self._patience = Patience()
        self._complaints: Set[asyncio.Future[None]] = set()
        self._numbers = itertools.count(1)

    async def serve(self) -> None:
        """Serve until the client goes."""
        sender = asyncio.ensure_future(self._send_when_empty())
        try:
            await self.cameras_changed()
            async for message in self._websocket:
                if not await self._receive(message):
                    return
        except ConnectionError:
            return
        finally:
            sender.cancel()
            self._uplink.close()
            if self._held is not None:
                self._held.close()
            for name in tuple(self._feeds):
                self._end(name)

    async def cameras_changed(self) -> None:
        """Tell the client which cameras there are, and watch what can be watched now."""
        described = self._cameras.described()
        if described != self._told:
            self._told = described
            await self._say(version=VERSION, cameras=described)
        self._watch()

    def review(self) -> None:
        """End what the client may not see any more, and begin with what it may see again."""
        self._watch()

    def _find(self, name: str) -> Optional[Camera]:
        """Return a camera that the client may see now."""
        camera = self._cameras.find(name)
        hidden = (
            camera is not None
            and self._exam is not None
            and not self._exam.allows("subscribe", camera.topic)
        )
        return None if hidden else camera

    async def dismiss(self) -> None:
        """Close the connection because the server ends."""
        with contextlib.suppress(ConnectionError):
            await self._websocket.close(code=WSCloseCode.GOING_AWAY, message=b"the server ends")

    async def _receive(self, message: WSMessage) -> bool:
        """Take one message; False: the connection is to end."""
        if message.type not in (WSMsgType.TEXT, WSMsgType.BINARY):
            return False  # such as one that is too long, for which aiohttp has closed already
        try:
            if message.type == WSMsgType.BINARY:
                raise ProtocolError("messages must be text; binary ones are not understood")
            parsed = parse(message.data, self._max_size)
            cost = _cost(parsed)
            await self._do(parsed)
        except ProtocolError as error:
            cost = ERROR_COST
            await self._say(error=str(error))
        if self._patience.spend(cost):
            return True
        await self._websocket.close(
            code=WSCloseCode.POLICY_VIOLATION, message=b"too many messages, or too many bad ones"
        )
        return False

    async def _do(self, message: Message) -> None:
        if isinstance(message, Ack):
            self._acknowledge(message)
        elif isinstance(message, Ping):
            await self._answer(message)
        elif self._uplink.passes:
            self._show(message)
        else:
            # Acknowledgements and pings are no part of what is delayed: they tell what is.
            self._uplink.send(Sent(lambda: self._show_late(message)), SHOW_BYTES)

    def _show_late(self, show: Show) -> None:
        """Show what a message that has passed the line asks for."""
        try:
            self._show(show)
        except ProtocolError as error:
            self._complaints.add(asyncio.ensure_future(self._complain(error)))

    async def _complain(self, error: ProtocolError) -> None:
        with contextlib.suppress(ConnectionError):
            await self._say(error=str(error))

    def _acknowledge(self, ack: Ack) -> None:
        names = self._cameras.names
        for camera, number in ack.pictures:
            if camera >= len(names):
                raise ProtocolError(f"ack is for camera {camera}; there are {len(names)}")
            feed = self._feeds.get(names[camera])
            # The picture of a view that has been changed meanwhile is nobody's any more.
            if feed is not None:
                feed.acknowledge(number)

    async def _answer(self, ping: Ping) -> None:
        figures = {name: feed.figures() for name, feed in self._feeds.items()}
        await self._say(pong=ping.token, time=time.time(), views=figures)

    def _show(self, show: Show) -> None:
        for view in show.views:
            if self._find(view.camera) is None:
                known = ", ".join(self._cameras.names) or "none yet"
                raise ProtocolError(
                    f"there is no camera {json.dumps(view.camera[:40])}; known are {known}"
                )
        self._views = list(show.views)
        complaint = self._watch()
        if complaint is not None:
            raise ProtocolError(complaint)

    def _watch(self) -> Optional[str]:
        """Let the feeds be those of the views; return why one of them cannot be had yet."""
        complaint: Optional[str] = None
        wanted = {view.camera: view for view in self._views}
        outdated = {
            name: self._feeds.pop(name)
            for name, feed in tuple(self._feeds.items())
            if wanted.get(name) != feed.view or self._find(name) != feed.camera
        }
        # One by one, so that old and new views together take no more room than there is.
        for name in outdated.keys() - wanted.keys():
            self._leave(outdated.pop(name))
        for view in self._views:
            camera = self._find(view.camera)
            if camera is not None and view.camera not in self._feeds:
                small_enough = view.suits_preview(self._preview_rate)
                preview = camera.preview if small_enough else None
                try:
                    self._begin(camera, view, preview or camera.source)
                except EncoderFullError as error:
                    complaint = str(error)
            # After the new one, so that a topic that goes on being watched stays subscribed.
            if view.camera in outdated:
                self._leave(outdated.pop(view.camera))
        return complaint

    def _begin(self, camera: Camera, view: WantedView, source: PictureTopic) -> None:
        feed = Feed(
            camera,
            view,
            source,
            self._client,
            ready=self._send,
            too_small=self._take_full,
            lost=self._lost,
            next_number=lambda: next(self._numbers) & 0xFFFFFFFF,
        )
        viewer: Viewer = feed
        if self._held is not None:
            viewer = self._held.before(feed, rate=view.rate, takes=feed.takes)
        # Before it is told of, since the newest picture may be offered at once.
        self._feeds[camera.name] = feed
        try:
            self._viewers[feed] = viewer
            self._hubs.join(source, viewer, feed.variant, likely_passes=source == camera.preview)
        except EncoderFullError:
            del self._feeds[camera.name], self._viewers[feed]
            raise

    def _take_full(self, feed: Feed) -> None:
        """Let a view have the full pictures of its camera instead of the previews."""
        if self._feeds.get(feed.camera.name) is feed:
            self._end(feed.camera.name)
            with contextlib.suppress(EncoderFullError):  # it will come as soon as there is room
                self._begin(feed.camera, feed.view, feed.camera.source)

    def _end(self, name: str) -> None:
        self._leave(self._feeds.pop(name))

    def _leave(self, feed: Feed) -> None:
        viewer = self._viewers.pop(feed)
        self._hubs.leave(feed.source, viewer, feed.variant)
        if isinstance(viewer, LateViewer):
            viewer.forget()

    def _lost(self, feed: Feed) -> None:
        """Forget a feed whose camera cannot be watched; the next look at the cameras tries anew."""
        if self._feeds.get(feed.camera.name) is feed:
            self._end(feed.camera.name)

    def _send(self) -> None:
        """Send what is ready, in turns, a picture chosen only when the connection has room."""
        while not (self._transport.is_closing() or self._websocket.closed):
            feed = next((each for each in self._feeds.values() if each.is_sendable), None)
            if feed is None:
                return
            if self._backlog.buffered():
                self._is_full.set()
                return
            self._feeds[feed.camera.name] = self._feeds.pop(feed.camera.name)  # the last in turn
            header, data = feed.take()
            # Past aiohttp, whose way costs a task's turn for every picture; a frame that is
            # written in one go cannot come between the parts of another.
            head = binary_frame_head(len(header) + len(data))
            self._transport.write(b"".join((head, header, data)))

    async def _send_when_empty(self) -> None:
        """Send what has become ready while the connection was full."""
        while True:
            await self._is_full.wait()
            while self._backlog.buffered() and not self._transport.is_closing():
                await asyncio.sleep(BACKLOG_POLL)
            self._is_full.clear()
            self._send()

    async def _say(self, **news: Any) -> None:
        if self._backlog.buffered() > MAX_REPLY_BACKLOG:
            self._transport.abort()
            raise ConnectionResetError("the client does not read")
        await self._websocket.send_str(json.dumps(news))


def _cost(message: Message) -> float:
    if isinstance(message, Ack):
        return ACK_COST * len(message.pictures)
    return PING_COST if isinstance(message, Ping) else SHOW_COST
