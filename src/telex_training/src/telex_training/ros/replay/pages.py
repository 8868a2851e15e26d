"""Answers what the replay's page asks for: what happened in a trial, and pictures of it."""

from __future__ import annotations

import asyncio
import contextlib
import functools
import math
from pathlib import Path
from typing import Any, Callable, Iterator, Optional

from aiohttp import web

from telex_control.common.params import ConfigError
from telex_sim.cameras.cameras_config import ORBIT, ViewConfig

from ...judging.entries import BadEntryError
from ...judging.moments import moment_note
from ...recording.writer import RecordingError
from ...replay.cameras import CLEAR, OUTSIDE
from ...replay.ghost import Ghost, GhostError
from ...replay.replay import Replay, SilentCameraError
from ...serving import aside, posted
from ..pages.page_server import PageServer, instructs, name_of
from .drawing import Drawing, DrawingError
from .ghosts import Ghosts
from .shelf import NotHereError, Open, Shelf

PREFIX = "/replay"
_BUSY = "A trial is running on this machine; replays wait until it has ended.\n"
_NOT_HERE = "There is no recording of this trial under your name.\n"


class ReplayPages(PageServer):
    """The page ``/replay/<trial>`` and what it asks for.

    Parameters
    ----------
    folder : Path
        Of the page's files.
    port : int
        0: any free one.
    is_busy : callable
        Tells whether a trial runs on the machine.
    busy_period : float
        See `ReplaySettings`.
    """

    def __init__(
        self,
        shelf: Shelf,
        ghosts: Ghosts,
        drawing: Drawing,
        folder: Path,
        port: int,
        is_busy: Callable[[], bool],
        busy_period: float,
    ) -> None:
        super().__init__(port)
        self._shelf, self._ghosts, self._drawing, self._folder = shelf, ghosts, drawing, folder
        self._is_busy, self._busy_period = is_busy, busy_period

    def add_routes(self, router: web.UrlDispatcher) -> None:
        """See `PageServer.add_routes`."""
        self._turn = asyncio.Lock()
        router.add_get(f"{PREFIX}/api/trial/{{trial}}", self._about)
        router.add_get(f"{PREFIX}/api/picture/{{trial}}", self._picture)
        router.add_get(f"{PREFIX}/api/ghosts/{{trial}}", self._offer_ghosts)
        router.add_post(f"{PREFIX}/api/notes/{{trial}}", self._take_note)
        router.add_get(f"{PREFIX}/", self._given)
        router.add_get(f"{PREFIX}/{{trial}}", self._page)

    def show_at(self, video_server: str) -> None:
        """Have a video server show folder and handler at ``/replay/``."""
        self.mount(video_server, "replay", self._folder)

    async def _given(self, request: web.Request) -> web.StreamResponse:
        """Lead to the one recording that the node was given."""
        if not self._shelf.given:
            raise web.HTTPNotFound(text="Add the name of a trial to the address.\n")
        query = f"?{request.query_string}" if request.query_string else ""
        raise web.HTTPFound(f"{PREFIX}/{self._shelf.given}{query}")

    async def _page(self, request: web.Request) -> web.StreamResponse:
        return web.FileResponse(self._folder / "replay.html")

    async def _about(self, request: web.Request) -> web.Response:
        found = await self._permitted(request)
        replay = found.replay
        # What draws needs seconds to start.
        with _readable():
            about, _ = await asyncio.gather(aside(replay.about), aside(self._drawing.start, replay))
        return web.json_response({**about, "problems": found.problems})

    async def _picture(self, request: web.Request) -> web.Response:
        found = await self._permitted(request)
        replay, query = found.replay, request.query
        camera = query.get("camera", OUTSIDE)
        if camera != OUTSIDE and camera not in replay.camera_names:
            raise web.HTTPBadRequest(
                text=f"camera is '{camera[:60]}'; there are {OUTSIDE}, "
                f"{', '.join(replay.camera_names)}\n"
            )
        seen = query.get("seen") == "1"
        try:
            time = _number(query, "time", 0.0)
            view = _view(query) if camera == OUTSIDE else None
        except (ConfigError, ValueError) as error:
            raise web.HTTPBadRequest(text=f"{error}\n") from None
        moment = replay.timeline.moment(replay.seen_at(time) if seen else time)
        ghost = await self._ghost(request, replay)
        headers = {"X-Replay-Time": f"{moment.time:.4f}", "Cache-Control": "no-store"}
        name = camera if seen or camera == OUTSIDE else camera + CLEAR
        drawn = moment
        if name != OUTSIDE and seen:
            try:
                drawn = replay.sent_by(camera, moment)
            except SilentCameraError as error:
                return web.Response(status=204, headers={**headers, "X-Replay-Silent": str(error)})
        spacing = self._busy_period if self._is_busy() else 0.0
        draw = functools.partial(self._drawing.picture, ghost=ghost)
        try:
            # Who waits takes no thread from others, and who has gone is not drawn for.
            async with self._turn:
                if request.transport is None:
                    raise web.HTTPServiceUnavailable(text="Nobody waits for it any more.\n")
                with _readable():
                    data = await aside(draw, replay, drawn, name, view, spacing)
        except DrawingError as error:
            raise web.HTTPGatewayTimeout(text=f"{error}\n") from None
        if ghost is not None:
            headers["X-Replay-Ghost-Ahead"] = f"{ghost.ahead(moment.time):.3f}"
        return web.Response(body=data, content_type="image/jpeg", headers=headers)

    async def _offer_ghosts(self, request: web.Request) -> web.Response:
        """List the runs that can be drawn beside a trial."""
        replay = (await self._permitted(request)).replay
        return web.json_response(
            await aside(self._ghosts.offered, replay, name_of(request), instructs(request))
        )

    async def _ghost(self, request: web.Request, replay: Replay) -> Optional[Ghost]:
        """Run that a picture is to show beside the trial; None: none."""
        ghost = request.query.get("ghost")
        if not ghost:
            return None
        try:
            with _readable():
                found: Ghost = await aside(
                    self._ghosts.open, replay, ghost, name_of(request), instructs(request)
                )
        except NotHereError:
            raise web.HTTPNotFound(text=_NOT_HERE) from None
        except GhostError as error:
            raise web.HTTPBadRequest(text=f"{error}\n") from None
        return found

    async def _take_note(self, request: web.Request) -> web.Response:
        """Add a note at a moment, and tell all marks anew."""
        replay, name = (await self._permitted(request)).replay, name_of(request)
        instructor = instructs(request)
        if not instructor and replay.trial.operator != name:
            raise web.HTTPForbidden(
                text="Notes are written by who did the trial, and by instructors.\n"
            )
        content = await posted(request)
        if not isinstance(content, dict):
            raise web.HTTPBadRequest(text="A struct with at and text is needed.\n")
        try:
            note = moment_note({**content, "by": name, "instructor": instructor})
            if note.at > replay.timeline.duration:
                raise BadEntryError(
                    f"at is {note.at:g}; the recording has {replay.timeline.duration:.3f} s"
                )
        except BadEntryError as error:
            raise web.HTTPBadRequest(text=f"{error}\n") from error
        try:
            await aside(self._shelf.note, replay, note)
        except RecordingError as error:
            raise web.HTTPConflict(text=f"{error}\n") from error
        return web.json_response({"marks": await aside(replay.marks)})

    async def _permitted(self, request: web.Request) -> Open:
        instructor = instructs(request)
        if self._is_busy() and not instructor:
            raise web.HTTPConflict(text=_BUSY)
        trial, name = request.match_info["trial"], name_of(request)
        try:
            with _readable():
                found: Open = await aside(self._shelf.permitted, trial, name, instructor)
        except NotHereError:
            raise web.HTTPNotFound(text=_NOT_HERE) from None
        return found


@contextlib.contextmanager
def _readable() -> Iterator[None]:
    """Answer with what is wrong with a recording, where something is."""
    try:
        yield
    except RecordingError as error:
        raise web.HTTPUnprocessableEntity(text=f"{error}\n") from None


def _view(query: Any) -> ViewConfig:
    """View that an address asks for.

    Raises
    ------
    ConfigError, ValueError
    """
    usual = ViewConfig(mode=ORBIT)
    x, y, z = (_number(query, key, at) for key, at in zip("xyz", (0.0, 0.0, 0.3)))
    return ViewConfig(
        mode=ORBIT,
        azimuth=_number(query, "azimuth", usual.azimuth),
        elevation=_number(query, "elevation", usual.elevation),
        distance=_number(query, "distance", 4.0),
        center=(x, y, z),
    )


def _number(query: Any, key: str, default: float) -> float:
    text = query.get(key)
    if text is None:
        return default
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise ValueError(f"{key} is '{text[:40]}'; a finite number is needed")
    return number
