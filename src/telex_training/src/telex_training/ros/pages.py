"""Answers what the training's pages ask for: sheets, as JSON and CSV, and takes ratings.

The video server mounts this handler and the folder of pages at ``/training/``; it checks tokens,
and says in headers who asks. A sheet is personal: it goes to instructors, and to whoever bears the
name that the trial was done under.
"""

from __future__ import annotations

import asyncio
import contextlib
import threading
import urllib.parse
from pathlib import Path
from typing import Any, Callable, Dict, List, Optional

import rospkg
import rospy
from aiohttp import web

from ..judging.entries import BadEntryError
from ..judging.sheet import sheet_text
from ..judging.workload import workload_of
from ..progress.index import ProgressIndex
from ..recording.sheet_table import sheet_csv
from .brief_pages import BriefPages
from .library import Library
from .progress_pages import ProgressPages

_PREFIX, _PROGRESS = "/training", "/progress"
_ROLE, _NAME = "X-Telex-Role", "X-Telex-Name"
_INSTRUCTOR = "instructor"
_STARTING = 10.0

Rate = Callable[[str, List[float]], None]
"""Adds an operator's ratings of his workload to a trial's recording; raises a RuntimeError."""


class Pages:
    """An HTTP server on 127.0.0.1, in a thread of its own.

    Parameters
    ----------
    library : Library
    folder : Path
        Of the recordings.
    port : int
        0: any free one.
    rate : callable

    Attributes
    ----------
    briefs : BriefPages
    """

    def __init__(self, library: Library, folder: Path, port: int, rate: Rate) -> None:
        self._library = library
        self.briefs = BriefPages(library, folder, _is_for)
        self._progress = ProgressPages(ProgressIndex(folder), _instructs, _name)
        self._port = port
        self._rate = rate
        self._loop = asyncio.new_event_loop()
        self._ready = threading.Event()
        self._address = ""
        self._mounted: List[str] = []
        self._thread = threading.Thread(target=self._run, name="pages", daemon=True)

    def start(self) -> None:
        """Listen.

        Raises
        ------
        RuntimeError
            The port is taken.
        """
        self._thread.start()
        if not self._ready.wait(_STARTING) or not self._address:
            raise RuntimeError(
                f"port is {self._port}; nothing can listen there: another port, or 0, is needed"
            )

    def mount(self, video_server: str) -> None:
        """Have a video server show folder and handler at ``/training/``, progress at its own."""
        package = Path(rospkg.RosPack().get_path("telex_training"))
        # The pages' own files need no token, for nothing in a page gives it to its scripts; what is
        # personal comes from the handler, which nobody reaches without one.
        files = {"folder": str(package / "pages"), "handler": self._address, "access": "all"}
        for place, mount in ((_PREFIX, files), (_PROGRESS, {"handler": self._address})):
            name = rospy.resolve_name(f"{video_server}/mounts{place}")
            rospy.set_param(name, mount)
            self._mounted.append(name)

    def preview_address(self, exercise: Path) -> str:
        """Address of an exercise's picture below the video server's; empty: there is none."""
        name = self.briefs.pictures.shipped(exercise)
        return f"{_PREFIX}/preview/{name}.jpg" if name else ""

    def close(self) -> None:
        """Listen no more, and take the mount back."""
        for name in self._mounted:
            # The master may be gone, or the parameter.
            with contextlib.suppress(KeyError, OSError):
                rospy.delete_param(name)
        self._loop.call_soon_threadsafe(self._loop.stop)

    # --- the thread ------------------------------------------------------------------------------

    def _run(self) -> None:
        asyncio.set_event_loop(self._loop)
        try:
            self._loop.run_until_complete(self._listen())
        except OSError:
            self._ready.set()
            return
        self._ready.set()
        self._loop.run_forever()

    async def _listen(self) -> None:
        app = web.Application(client_max_size=2**16)
        app.router.add_get(f"{_PREFIX}/api/sheets", self._sheets)
        app.router.add_get(f"{_PREFIX}/api/sheet/{{trial}}", self._sheet)
        app.router.add_get(f"{_PREFIX}/api/csv/{{trial}}", self._csv)
        app.router.add_get(f"{_PREFIX}/api/workload/{{trial}}", self._workload)
        app.router.add_post(f"{_PREFIX}/api/workload/{{trial}}", self._take_workload)
        self.briefs.route(app.router, _PREFIX)
        self._progress.route(app.router, _PROGRESS)
        runner = web.AppRunner(app, access_log=None)
        await runner.setup()
        site = web.TCPSite(runner, "127.0.0.1", self._port)
        await site.start()
        host, port = runner.addresses[0][:2]
        self._address = f"http://{host}:{port}"

    async def _sheets(self, request: web.Request) -> web.Response:
        """List a person's sheets, or everybody's for an instructor."""
        sheets = await self._aside(
            self._library.sheets, None if _instructs(request) else _name(request)
        )
        return web.json_response([_row(sheet) for sheet in sheets])

    async def _sheet(self, request: web.Request) -> web.Response:
        sheet = await self._permitted(request)
        return web.Response(text=sheet_text(sheet), content_type="application/json")

    async def _csv(self, request: web.Request) -> web.Response:
        sheet = await self._permitted(request)
        name = f"{sheet['trial']}.csv"
        return web.Response(
            text=sheet_csv(sheet),
            content_type="text/csv",
            headers={"Content-Disposition": f'attachment; filename="{name}"'},
        )

    async def _workload(self, request: web.Request) -> web.Response:
        """Tell the ratings of a trial, or null."""
        await self._permitted(request)
        return web.json_response(
            await self._aside(self._library.workload, request.match_info["trial"])
        )

    async def _take_workload(self, request: web.Request) -> web.Response:
        """Take an operator's ratings of his own trial."""
        sheet = await self._permitted(request)
        if sheet.get("operator") != _name(request):
            raise web.HTTPForbidden(text="The workload is rated by who did the trial.\n")
        # A page of another site cannot send this type without being asked whether it may.
        if request.content_type != "application/json":
            raise web.HTTPUnsupportedMediaType(text="application/json is needed.\n")
        try:
            given = workload_of(await request.json())
        except (BadEntryError, ValueError, RecursionError) as error:
            raise web.HTTPBadRequest(text=f"{error}\n") from error
        try:
            await self._aside(self._rate, request.match_info["trial"], given["ratings"])
        except RuntimeError as error:
            raise web.HTTPConflict(text=f"{error}\n") from error
        return web.json_response(given)

    async def _permitted(self, request: web.Request) -> Dict[str, Any]:
        sheet: Optional[Dict[str, Any]] = await self._aside(
            self._library.sheet, request.match_info["trial"]
        )
        # Whose it is not must not even learn that it is there.
        if sheet is None or not _is_for(request, sheet.get("operator", "")):
            raise web.HTTPNotFound(text="There is no sheet of this trial under your name.\n")
        return sheet

    async def _aside(self, work: Any, *arguments: Any) -> Any:
        """Do what reads files in another thread."""
        return await self._loop.run_in_executor(None, work, *arguments)


def _row(sheet: Dict[str, Any]) -> Dict[str, Any]:
    return {
        key: sheet[key]
        for key in ("trial", "operator", "exercise", "mode", "valid", "verdict", "summary")
    }


def _instructs(request: web.Request) -> bool:
    return request.headers.get(_ROLE) == _INSTRUCTOR


def _is_for(request: web.Request, operator: str) -> bool:
    return _instructs(request) or operator == _name(request)


def _name(request: web.Request) -> str:
    return urllib.parse.unquote(request.headers.get(_NAME, ""))
