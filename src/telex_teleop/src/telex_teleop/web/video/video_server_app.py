"""HTTP side of the video server."""

from __future__ import annotations

import asyncio
import time
from pathlib import Path
from random import Random
from typing import (
    Any,
    AsyncIterator,
    Callable,
    Dict,
    Hashable,
    NamedTuple,
    Optional,
    Protocol,
    Tuple,
    TypeVar,
)
from urllib.parse import urlsplit, urlunsplit

from aiohttp import web

from ...actions.abilities import Abilities, abilities_of
from ...actions.drawing import drawing_of
from ..exam.exam_list import Exam
from ..line.line import Line
from ..map_documents import add_maps
from ..rights import ExamRights
from ..server_config import VideoServerConfig
from ..tokens import INSTRUCTOR, ForbiddenError
from ..workers import OrderedWorker
from . import mjpeg, pages, query
from .gate import Gate
from .handlers import Handlers, MountError
from .hub import EncoderFullError, Encoders, PictureHubs, PictureSource
from .late.held_pictures import HeldPictures
from .mounts import Mounts, find_file
from .pictures import EncodedPicture, UnusablePictureError, encode
from .topics import PictureTopic, Topics, base_topics, find_cameras, find_topic
from .viewers import SnapshotViewer, StreamViewer, client_of
from .websocket.sockets import VideoSockets

CHECK_PERIOD = 1.0
"""Time (s) between two looks at whether viewers still read."""

FOR_LONG = 3600.0
"""Time (s) to sleep when there is nothing to do but to be cancelled."""

# The console speaks to the bridge on another port, and its pictures may be blobs; nothing else is
# foreign.
_PAGE_HEADERS = {
    "Cache-Control": "no-cache",
    "Content-Security-Policy": (
        "default-src 'self'; connect-src 'self' ws: wss:; img-src 'self' blob: data:; "
        "frame-ancestors 'self'; base-uri 'none'; form-action 'none'"
    ),
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}

_FULL = "/image_raw"
"""End of a camera's topic with pictures of full size."""

_PAGES = {"": "index.html", "instructor": "instructor.html"}

Result = TypeVar("Result")


class Graph(PictureSource, Protocol):
    """The pictures and what else the server asks of ROS; all methods may block."""

    def topics(self) -> Topics:
        """Return the published topics and their types."""

    def sim_time(self) -> float:
        """Return the present ROS time (s), finer than it is published; on one thread."""

    def parameter(self, name: str) -> object:
        """Return a parameter, or None if it is not set."""


class Log(Protocol):
    """Where the server reports what an administrator should know."""

    def __call__(self, sentence: str) -> None:
        """Report a sentence, throttled."""


class RobotVideo(NamedTuple):
    """What the server has for one robot.

    Attributes
    ----------
    namespace
        With slashes around it.
    prefix
        Of names of its nodes and their parameters; empty: they are in the server's own namespace.
    bridge
        Name of its bridge.
    line
        What passes between it and clients that are no instructors; perfect until somebody says
        otherwise.
    """

    namespace: str
    prefix: str
    bridge: str
    line: Line
    gate: Gate
    sockets: VideoSockets


class VideoServer:
    """Handlers of the video server; make it on the loop's thread.

    Parameters
    ----------
    graph
        Pictures, topics and parameters.
    namespace
        The node's namespace, with slashes around it.
    console
        Directory of the console's static files.
    warn
        Called, in any thread, with what an administrator should know.

    Attributes
    ----------
    robots
        What is shown of each robot, by its name: of the one in whose namespace the node is, first,
        and of the further ones that the parameters name.
    """

    def __init__(
        self, config: VideoServerConfig, graph: Graph, namespace: str, console: Path, warn: Log
    ) -> None:
        self._config = config
        self._graph = graph
        self._namespace = namespace
        self._console = console.resolve()
        self._warn = warn
        self._worker = OrderedWorker("picture subscriptions")
        self.hubs = PictureHubs(
            graph,
            self._worker,
            Encoders(config.max_encoded),
            lambda picture, variant: encode(picture, variant, config.quality),
            on_unusable=self._report_unusable,
            on_failure=lambda topic, error: warn(f"cannot subscribe to {topic}: {error}"),
        )
        self._first = self._show(namespace, "")
        self.robots = {namespace.strip("/"): self._first}
        for name in config.robots:
            self.robots[name] = self._show(f"/{name}/", f"/{name}/")
        self._streams: Dict[StreamViewer, str] = {}  # of operators, and their topics
        self._handlers = Handlers(config.max_upload, config.handler_timeout, warn)
        self._mounts = Mounts(self._first.gate, self._handlers, self._parameter, warn)

    @property
    def line(self) -> Line:
        """The line of the first robot."""
        return self._first.line

    @property
    def sockets(self) -> VideoSockets:
        """The clients of the first robot's cameras."""
        return self._first.sockets

    def _show(self, namespace: str, prefix: str) -> RobotVideo:
        line, config = Line(Random()), self._config
        bridge = f"{prefix}{config.rosbridge}"
        exam = Exam(_exam_rights(config, self._graph, bridge), namespace)
        exam.changed = self._review
        sockets = VideoSockets(
            config,
            namespace,
            self.hubs,
            lambda: self._ask(self._graph.topics),
            line=line,
            sim_time=self._graph.sim_time,
            exam=exam,
        )
        gate = Gate(config, namespace, self._parameter, exam, bridge)
        return RobotVideo(namespace, prefix, bridge, line, gate, sockets)

    def _robot_of(self, topic: str) -> RobotVideo:
        """Return the robot to which a topic belongs; what is of none counts as the first's."""
        found = [each for each in self.robots.values() if topic.startswith(each.namespace)]
        return max(found, key=lambda each: len(each.namespace)) if found else self._first

    def _asked_robot(self, request: web.Request) -> RobotVideo:
        """Return the robot that a client's address names.

        Raises
        ------
        _NoSuchRobotError
            There is none of this name.
        """
        name = request.query.get("robot")
        if name is None:
            return self._first
        if name not in self.robots:
            known = ", ".join(self.robots)
            raise _NoSuchRobotError(f"There is no robot '{name[:100]}' here; there are: {known}.")
        return self.robots[name]

    def hear_of_exam(self, trial: str) -> None:
        """Hear from the first robot's bridge for which trial the exam's list holds, if any."""
        self._first.gate.hear_of_exam(trial)

    def _review(self) -> None:
        """End what operators watch, and may not see any more."""
        for viewer, topic in tuple(self._streams.items()):
            if not self._robot_of(topic).gate.exam.allows("subscribe", topic):
                viewer.close()
        for robot in self.robots.values():
            robot.sockets.review()

    def make_app(self) -> web.Application:
        """Return the application with all routes."""
        app = web.Application(middlewares=[self._answer_errors])
        # HEAD would start a stream only to throw it away.
        for path, handler in (
            ("/stream", self.stream),
            ("/snapshot", self.snapshot),
            ("/video", self.video),
        ):
            app.router.add_get(path, handler, allow_head=False)
            app.router.add_head(path, _refuse_head)
        app.router.add_get("/stream_viewer", self.stream_viewer)
        app.router.add_get("/streams", self.streams)
        app.router.add_get("/config.json", self.console_config)
        app.router.add_get("/robot.json", self.robot)
        app.router.add_get("/robot.urdf", self.urdf)
        add_maps(app, self._config.actions, self._config.joy_map, self._abilities)
        app.router.add_get("/{path:.*}", self.console_file)
        app.router.add_post("/{path:.*}", self._mounts.answer)
        app.on_response_prepare.append(_add_page_headers)
        app.on_shutdown.append(self._dismiss)
        app.cleanup_ctx.append(self._look_after)
        app.cleanup_ctx.append(self._handlers.run)
        return app

    async def stream(self, request: web.Request) -> web.StreamResponse:
        """Send an MJPEG stream until the client goes."""
        wish = self._stream_query(request)
        topic, instructor = await self._find(request, wish)
        robot = self._robot_of(topic.name)
        if request.transport is None:
            raise ConnectionResetError
        viewer = StreamViewer(
            request.transport,
            client_of(request),
            send_buffer=self._config.send_buffer,
            max_in_flight=self._config.max_in_flight,
            stall_timeout=self._config.stall_timeout,
        )
        # While there is still time for an error's head.
        self.hubs.require_room(topic, viewer.client, wish.variant)
        viewer.start()
        held = self._hold(robot, instructor)
        watching = viewer if held is None else held.before(viewer)
        self.hubs.join(topic, watching, wish.variant)
        if not instructor:
            self._streams[viewer] = topic.name
        try:
            # The server cancels a handler when its connection is lost: the only way out of here.
            while True:
                await self._repeat(viewer)
        finally:
            self._streams.pop(viewer, None)
            self.hubs.leave(topic, watching, wish.variant)
            if held is not None:
                held.close()

    def _hold(self, robot: RobotVideo, instructor: bool) -> Optional[HeldPictures]:
        """Return what holds back a robot's pictures for one client, None for instructors."""
        return None if instructor else HeldPictures(robot.line, self._graph.sim_time)

    async def _repeat(self, viewer: StreamViewer) -> None:
        """Wait, and send the last picture again if none has come and that is asked for."""
        if self._config.publish_rate <= 0.0:
            await asyncio.sleep(FOR_LONG)
            return
        period = 1.0 / self._config.publish_rate
        await asyncio.sleep(period)
        viewer.repeat(period)

    async def snapshot(self, request: web.Request) -> web.StreamResponse:
        """Send the next picture of a topic."""
        wish = query.parse_snapshot(request.query, self._config.max_size)
        robot = self._robot_of(self._spelled(wish.topic))
        instructor = await robot.gate.admit(request)
        held = self._hold(robot, instructor)
        picture: Optional[EncodedPicture]
        if "watched" in request.query and (held is None or held.passes):
            picture = self._watched(wish, instructor=instructor)
        else:
            topic = await self._topic(wish, instructor=instructor)
            limit = self._config.snapshot_timeout
            if held is not None:
                limit += robot.line.fields.delay
            picture = await self._next_picture(topic, wish, client_of(request), held, limit)
            # An exam may have begun meanwhile.
            robot.gate.require_visible(topic.name, instructor=instructor)
            if picture is None:
                text = f"No picture came on {topic.name} within {limit:g} s."
                return _page(pages.error_page(504, text), 504)
        headers = dict(mjpeg.SERVER_HEADERS)
        headers["X-Timestamp"] = mjpeg.timestamp(picture.stamp)
        headers["Access-Control-Allow-Origin"] = "*"
        return web.Response(body=picture.data, content_type=picture.mime, headers=headers)

    def _watched(self, wish: query.PictureQuery, *, instructor: bool) -> EncodedPicture:
        """Return the last picture that somebody watches, its preview first: none is made for it."""
        name, watched = wish.topic, self.hubs.topics
        for spelling in (f"{name[: -len(_FULL)]}/preview" if name.endswith(_FULL) else name, name):
            topic = find_topic(spelling, watched, self._namespace)
            if topic is not None:
                self._robot_of(topic.name).gate.require_visible(topic.name, instructor=instructor)
                picture = self.hubs.last(topic, wish.variant)
                if picture is not None:
                    return picture
        raise _NoSuchTopicError(f"Nobody watches '{name}' now; without 'watched' one is made.")

    async def _next_picture(
        self,
        topic: PictureTopic,
        wish: query.PictureQuery,
        client: Hashable,
        held: Optional[HeldPictures],
        limit: float,
    ) -> Optional[EncodedPicture]:
        viewer = SnapshotViewer(client)
        watching = viewer if held is None else held.before(viewer, takes=viewer.wants)
        hub = self.hubs.join(topic, watching, wish.variant, show_newest=False)
        try:
            return await asyncio.wait_for(viewer.picture, limit)
        except asyncio.TimeoutError:
            if held is not None and not held.passes:
                return None  # it would show what has not passed the line
            return hub.newest(wish.variant)  # a latched topic has no next picture
        finally:
            self.hubs.leave(topic, watching, wish.variant)
            if held is not None:
                held.close()

    async def stream_viewer(self, request: web.Request) -> web.Response:
        """Show a page with one stream."""
        wish = self._stream_query(request)
        await self._find(request, wish)
        return _page(pages.viewer_page(wish.topic, request.query))

    async def video(self, request: web.Request) -> web.StreamResponse:
        """Serve a client of all cameras over one WebSocket."""
        robot = self._asked_robot(request)
        return await robot.sockets.accept(request, instructor=await robot.gate.admit(request))

    async def streams(self, request: web.Request) -> web.Response:
        """List the image topics."""
        gate = self._asked_robot(request).gate
        instructor = await gate.admit(request)
        topics = await self._ask(self._graph.topics)
        shown = [
            topic
            for topic in gate.visible(base_topics(topics), instructor=instructor)
            if self._robot_of(topic).gate is gate
        ]
        access = {name: request.query[name] for name in ("token", "role") if name in request.query}
        return _page(pages.index_page(shown, topics, access))

    async def console_config(self, request: web.Request) -> web.Response:
        """Tell the console where everything is."""
        robot = self._asked_robot(request)
        topics = await self._ask(self._graph.topics)
        hidden = self._config.hidden_cameras
        for_instructor = request.query.get("role") == INSTRUCTOR
        config: Dict[str, Any] = {
            "namespace": robot.namespace.rstrip("/"),
            "rosbridge": await self._bridge_of(request, robot),
            "cameras": [
                {"name": name, "topic": topic}
                for name, topic in find_cameras(topics, robot.namespace).items()
                if for_instructor or name not in hidden
            ],
            "hidden_cameras": list(hidden),
            "main_camera": self._config.main_camera,
            "main_rate": self._config.main_rate,
            "thumbnail_rate": self._config.thumbnail_rate,
            "thumbnail_width": self._config.thumbnail_width,
        }
        if len(self.robots) > 1:
            config["robots"] = [
                {"name": name, "rosbridge": await self._bridge_of(request, each)}
                for name, each in self.robots.items()
            ]
            config["simulator"] = self._namespace.rstrip("/")
        # As /snapshot: a page of one's own, from wherever it came, asks here for the rest.
        return web.json_response(config, headers={"Access-Control-Allow-Origin": "*"})

    async def _bridge_of(self, request: web.Request, robot: RobotVideo) -> Optional[str]:
        url = await self._parameter(f"{robot.bridge}/url")
        return _seen_from(request, url) if isinstance(url, str) else None

    async def robot(self, request: web.Request) -> web.Response:
        """Tell pages what a robot has: its cameras and how far each zooms, its equipment.

        A zoom of null: not at all. What the robot lacks may have a training aid in its place.
        Where its nodes' parameters say it, also what of it moves.
        """
        prefix = self._asked_robot(request).prefix
        cameras = await self._parameter(f"{prefix}cameras/cameras")
        abilities = await self._abilities(request)
        told = {
            str(name): {"zoom_max": each.get("zoom_max") if isinstance(each, dict) else None}
            for name, each in (cameras.items() if isinstance(cameras, dict) else ())
            if name not in self._config.hidden_cameras
            and (abilities is None or name in abilities.cameras)
        }
        robot: Dict[str, Any] = {"cameras": told}
        for part in ("equipment", "training_aids"):
            found = await self._parameter(f"{prefix}{part}")
            robot[part] = found if isinstance(found, dict) else {}
        robot.update(await self._ask(lambda: drawing_of(self._graph.parameter, prefix, self._warn)))
        if abilities is not None:
            robot.update(abilities.as_json())
        return web.json_response(robot, headers={"Access-Control-Allow-Origin": "*"})

    async def urdf(self, request: web.Request) -> web.Response:
        """Send a robot's description, also while an exam closes the parameters; none: 204."""
        robot = self._asked_robot(request)
        await robot.gate.admit(request)
        described = await self._parameter(f"{robot.prefix}robot_description")
        if not isinstance(described, str):
            return web.Response(status=204)
        return web.Response(text=described, content_type="application/xml")

    async def _abilities(self, request: web.Request) -> Optional[Abilities]:
        """Return what can be done with the robot that a client's address names, if that is said."""
        prefix = self._asked_robot(request).prefix
        return await self._ask(lambda: abilities_of(self._graph.parameter, prefix, self._warn))

    async def console_file(self, request: web.Request) -> web.StreamResponse:
        """Send a file of the console, or what another process has mounted."""
        name = request.match_info["path"]
        if name in _PAGES:
            self._asked_robot(request)  # rather than a page that waits for it for ever
        path = find_file(self._console, _PAGES.get(name, name))
        return await self._mounts.answer(request) if path is None else web.FileResponse(path)

    def _stream_query(self, request: web.Request) -> query.PictureQuery:
        config = self._config
        return query.parse_stream(request.query, config.max_size, config.default_stream_type)

    async def _find(
        self, request: web.Request, wish: query.PictureQuery
    ) -> Tuple[PictureTopic, bool]:
        """Return the topic that a client asks for, and whether it is an instructor."""
        gate = self._robot_of(self._spelled(wish.topic)).gate
        instructor = await gate.admit(request)
        return await self._topic(wish, instructor=instructor), instructor

    def _spelled(self, topic: str) -> str:
        """Return the global name of a topic as a client spells it, who may leave the slash out."""
        return topic if topic.startswith("/") else f"/{topic}"

    async def _topic(self, wish: query.PictureQuery, *, instructor: bool) -> PictureTopic:
        topic = await self._ask(lambda: self._graph.find(wish.topic, raw=wish.raw))
        if topic is None:
            raise _NoSuchTopicError(
                f"No image topic '{wish.topic}' is published; /streams lists those that are."
            )
        self._robot_of(topic.name).gate.require_visible(topic.name, instructor=instructor)
        return topic

    async def _parameter(self, name: str) -> object:
        return await self._ask(lambda: self._graph.parameter(name))

    async def _ask(self, call: Callable[[], Result]) -> Result:
        """Run a call to the ROS master off the loop's thread."""
        try:
            return await self._worker.submit(call)
        except (OSError, RuntimeError) as error:
            raise _NoMasterError(f"The ROS master does not answer: {error}") from error

    def _report_unusable(self, topic: str, error: UnusablePictureError) -> None:
        self._warn(f"dropped a picture of {topic}: it {error}")

    @web.middleware
    async def _answer_errors(self, request: web.Request, handler: Any) -> web.StreamResponse:
        """Answer errors with a page that says what is wrong."""
        try:
            return await handler(request)
        except (
            query.QueryError,
            ForbiddenError,
            EncoderFullError,
            MountError,
            _NoSuchTopicError,
            _NoSuchRobotError,
            _NoMasterError,
        ) as error:
            return _page(pages.error_page(error.status, str(error)), error.status)
        except web.HTTPNotFound:
            return _page(pages.error_page(404), 404)

    async def _dismiss(self, _app: web.Application) -> None:
        self.hubs.close()
        for robot in self.robots.values():
            await robot.sockets.dismiss()

    async def _look_after(self, _app: web.Application) -> AsyncIterator[None]:
        async def check_regularly() -> None:
            while True:
                await asyncio.sleep(CHECK_PERIOD)
                self.hubs.check(time.monotonic())

        tasks = [
            asyncio.ensure_future(check_regularly()),
            *(asyncio.ensure_future(r.sockets.follow_cameras()) for r in self.robots.values()),
        ]
        yield
        for task in tasks:
            task.cancel()


def _exam_rights(config: VideoServerConfig, graph: Graph, bridge: str) -> ExamRights:
    """Read the exam's list that the parameter of a robot's bridge names."""
    path = graph.parameter(f"{bridge}/exam_rights")
    return ExamRights.read(path if isinstance(path, str) else "").hiding(config.hidden_cameras)


class _NoSuchTopicError(LookupError):
    status = 404


class _NoSuchRobotError(LookupError):
    status = 404


class _NoMasterError(OSError):
    status = 503


async def _refuse_head(request: web.Request) -> web.StreamResponse:
    raise web.HTTPMethodNotAllowed(request.method, ["GET"])


def _page(text: str, status: int = 200) -> web.Response:
    return web.Response(text=text, content_type="text/html", status=status)


async def _add_page_headers(_request: web.Request, response: web.StreamResponse) -> None:
    for name, value in _PAGE_HEADERS.items():
        response.headers.setdefault(name, value)


def _seen_from(request: web.Request, url: str) -> str:
    """Return the bridge's address as the client can reach it.

    The bridge announces itself with a loopback address; for a client that came over the network
    it is on this server's host.
    """
    parts = urlsplit(url)
    asked = request.url.host
    loopback = ("127.0.0.1", "::1", "localhost")
    if asked is None or asked in loopback or parts.hostname not in loopback:
        return url
    host = f"[{asked}]" if ":" in asked else asked
    return urlunsplit(parts._replace(netloc=f"{host}:{parts.port}"))
