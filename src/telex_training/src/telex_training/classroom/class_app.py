"""The page of a class and what it asks for, as an aiohttp application.

Browsers talk to it alone: tokens of stations stay here, but for the one link that opens a station's
own page.
"""

from __future__ import annotations

import asyncio
import time
from pathlib import Path
from typing import Any, AsyncIterator, Dict, Iterator, List, Optional, Sequence, Tuple

from aiohttp import web
from yarl import URL

from telex_control.common.params import ConfigError, read_struct, require
from telex_teleop.web.origins import origin_allowed
from telex_teleop.web.tokens import MAX_NAME, ForbiddenError, Tokens, is_instructor

from ..briefing.texts import merged_texts
from ..exercises.catalog import exercises
from ..exercises.exercise_file import ExerciseError, ExerciseFile, load_exercise
from ..serving import aside, posted_object
from .answers import merged
from .order import Order
from .poller import BusyError, StationPoller
from .station_client import StationError
from .stations_file import ClassStation

PREFIX = "/class"
_LOOKS = 10.0
"""For which pictures are fetched after a page has asked for them last (s)."""
_LARGEST_UPLOAD = 2**16
_FILES = (
    "class/class.css",
    "class/class.js",
    "class/cards.js",
    "elements.js",
    "replay/language.js",
)
_OF_CONSOLE = ("buttons.js", "language.js", "storage.js")
_HEADERS = {
    "Cache-Control": "no-store",
    "Content-Security-Policy": (
        "default-src 'self'; img-src 'self' data:; frame-ancestors 'self'; base-uri 'none'; "
        "form-action 'none'"
    ),
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}


class ClassApp:
    """Watches stations, and shows them to whoever has the class's token.

    Parameters
    ----------
    token : str
        Empty: nobody is asked for one.
    pages : Path
        Folder of the package's pages.
    console : Path
        Folder of the console's modules, whose language the pages speak.
    """

    def __init__(
        self, stations: Sequence[ClassStation], token: str, pages: Path, console: Path
    ) -> None:
        # One of the two alone would leave the other role without a question.
        self._tokens = Tokens(token, token)
        self._pages, self._console = pages, console
        self._looked = -_LOOKS
        self._pollers = {
            station.name: StationPoller(station, self._pictures_wanted) for station in stations
        }

    def make_app(self) -> web.Application:
        """Return the application with all routes; it watches while it runs."""
        app = web.Application(client_max_size=_LARGEST_UPLOAD, middlewares=[self._check])
        router = app.router
        router.add_get("/", _to_page)
        router.add_get(PREFIX, _to_page)
        router.add_get(f"{PREFIX}/", self._file("class/class.html"))
        for name in _FILES:
            router.add_get(f"/{name}", self._file(name))
        for name in _OF_CONSOLE:
            router.add_get(f"/js/{name}", self._file(name, self._console))
        router.add_static("/js/language/", self._console / "language")
        router.add_get(f"{PREFIX}/api/state", self._state)
        router.add_get(f"{PREFIX}/api/picture/{{station}}", self._picture)
        router.add_get(f"{PREFIX}/api/exercises", self._exercises)
        router.add_get(f"{PREFIX}/api/texts", self._texts)
        router.add_get(f"{PREFIX}/api/progress", self._progress)
        router.add_post(f"{PREFIX}/api/open", self._open)
        router.add_post(f"{PREFIX}/api/help/{{station}}", self._end_help)
        router.add_get(f"{PREFIX}/station/{{station}}", self._station_page)
        app.on_response_prepare.append(_add_headers)
        app.cleanup_ctx.append(self._watch)
        return app

    def _pictures_wanted(self) -> bool:
        return time.monotonic() - self._looked < _LOOKS

    async def _watch(self, _app: web.Application) -> AsyncIterator[None]:
        tasks = [asyncio.ensure_future(each.run()) for each in self._pollers.values()]
        yield
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)

    @web.middleware
    async def _check(self, request: web.Request, handler: Any) -> web.StreamResponse:
        """Let in who may; files need no token, for nothing in them is anybody's."""
        if not request.path.startswith((f"{PREFIX}/api/", f"{PREFIX}/station/")):
            return await handler(request)
        try:
            is_instructor(request, self._tokens)
            changes = request.method == "POST"
            if changes and not self._tokens.client and not origin_allowed(request):
                raise ForbiddenError(403, "This page's origin may not change anything here.")
        except ForbiddenError as error:
            return web.Response(text=f"{error}\n", status=error.status)
        return await handler(request)

    def _file(self, name: str, folder: Optional[Path] = None) -> Any:
        async def answer(_request: web.Request) -> web.FileResponse:
            return web.FileResponse((folder or self._pages) / name)

        return answer

    def _poller(self, request: web.Request) -> StationPoller:
        poller = self._pollers.get(request.match_info["station"])
        if poller is None:
            raise web.HTTPNotFound(text="There is no station of this name.\n")
        return poller

    async def _state(self, request: web.Request) -> web.Response:
        now = time.monotonic()
        if "pictures" in request.query:
            self._looked = now
        shown = [poller.watch.shown(now) for poller in self._pollers.values()]
        return web.json_response({"stations": shown})

    async def _picture(self, request: web.Request) -> web.Response:
        picture = self._poller(request).watch.picture
        if picture is None:
            raise web.HTTPNotFound(text="There is no picture of this station yet.\n")
        return web.Response(body=picture.data, content_type=picture.kind)

    async def _exercises(self, _request: web.Request) -> web.Response:
        return web.json_response(await aside(_offered))

    async def _texts(self, _request: web.Request) -> web.Response:
        return web.json_response(await aside(_own_texts))

    async def _progress(self, _request: web.Request) -> web.Response:
        """Ask all stations at once where people stand; who does not answer is named."""
        pollers = list(self._pollers.values())
        answers = await asyncio.gather(
            *(each.courses() for each in pollers), return_exceptions=True
        )
        found, missing = [], {}
        for poller, answer in zip(pollers, answers):
            if isinstance(answer, StationError):
                missing[poller.station.name] = str(answer)
            elif isinstance(answer, BaseException):
                raise answer
            else:
                found.append(answer)
        courses = [
            {
                "title": each.title,
                "modules": list(each.modules),
                "people": {name: list(states) for name, states in each.people.items()},
            }
            for each in merged(found)
        ]
        return web.json_response({"courses": courses, "missing": missing})

    async def _open(self, request: web.Request) -> web.Response:
        """Open an exercise on several stations; each one's outcome is part of its state."""
        content = await posted_object(request)
        try:
            order = read_struct(Order, content)
            for name in order.stations:
                known = ", ".join(self._pollers)
                require(name in self._pollers, f"stations/{name[:60]} is unknown; known: {known}")
        except ConfigError as error:
            raise web.HTTPBadRequest(text=f"{error}\n") from error
        busy: Dict[str, str] = {}
        for name in order.stations:
            try:
                self._pollers[name].order(order.words, "/training/api/open", order.content(name))
            except BusyError as error:
                busy[name] = str(error)
        return web.json_response({"busy": busy}, status=202)

    async def _end_help(self, request: web.Request) -> web.Response:
        poller = self._poller(request)
        await posted_object(request)
        try:
            poller.order("help was given", "/training/api/help", {"help": False})
        except BusyError as error:
            raise web.HTTPConflict(text=f"{error}\n") from error
        return web.json_response({}, status=202)

    async def _station_page(self, request: web.Request) -> web.Response:
        """Lead to a station's own page for instructors, with the token that it asks for."""
        station = self._poller(request).station
        query = {"role": "instructor"}
        name = request.query.get("name", "")[:MAX_NAME]
        if name.isprintable() and name:
            query["name"] = name
        if station.token:
            query["token"] = station.token
        raise web.HTTPFound(URL(f"{station.address}/instructor").with_query(query))


def _exercise_files() -> Iterator[Tuple[str, ExerciseFile]]:
    """Exercises of this machine, with their names."""
    for name, path in exercises().items():
        try:
            yield name, load_exercise(path)
        except ExerciseError:
            continue  # it could be opened nowhere


def _offered() -> List[Dict[str, Any]]:
    """Exercises of this machine; a station that lacks one says so."""
    return [
        {
            "name": name,
            "title": file.first.title,
            "settings": list(file.settings),
            "modes": list(file.first.modes),
        }
        for name, file in _exercise_files()
    ]


def _own_texts() -> Dict[str, Dict[str, str]]:
    """What exercises of this machine say in other languages by their own files."""
    return merged_texts(file.texts for _, file in _exercise_files())


async def _to_page(request: web.Request) -> web.Response:
    query = request.rel_url.raw_query_string
    raise web.HTTPFound(URL(f"{PREFIX}/?{query}" if query else f"{PREFIX}/", encoded=True))


async def _add_headers(_request: web.Request, response: web.StreamResponse) -> None:
    for name, value in _HEADERS.items():
        response.headers.setdefault(name, value)
