"""Answers what the training's pages ask for: sheets, as JSON and CSV, and takes ratings.

The video server mounts this handler and the folder of pages at ``/training/``; it checks tokens,
and says in headers who asks. A sheet is personal: it goes to instructors, and to whoever bears the
name that the trial was done under.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, Callable, Dict, List, Optional

from aiohttp import web

from telex_control.common.file_catalog import package_path

from ...judging.entries import BadEntryError
from ...judging.sheet import sheet_text
from ...judging.workload import workload_of
from ...progress.index import ProgressIndex
from ...recording.sheet_table import sheet_csv
from ...serving import aside, posted
from ..library import Library
from .brief_pages import BriefPages
from .class_pages import ClassPages
from .page_server import PageServer, instructs, is_for, name_of
from .progress_pages import ProgressPages

_PREFIX, _PROGRESS = "/training", "/progress"

Rate = Callable[[str, List[float]], None]
"""Adds an operator's ratings of his workload to a trial's recording; raises a RuntimeError."""


class TrainingPages(PageServer):
    """Sheets, briefs and pictures of exercises over HTTP.

    Parameters
    ----------
    folder : Path
        Of the recordings.
    port : int
        0: any free one.
    """

    def __init__(
        self, library: Library, folder: Path, port: int, rate: Rate, class_pages: ClassPages
    ) -> None:
        super().__init__(port)
        self._class = class_pages
        self._library = library
        self.briefs = BriefPages(library, folder)
        self._progress = ProgressPages(ProgressIndex(folder))
        self._rate = rate

    def add_routes(self, router: web.UrlDispatcher) -> None:
        """See `PageServer.add_routes`."""
        router.add_get(f"{_PREFIX}/api/sheets", self._sheets)
        router.add_get(f"{_PREFIX}/api/sheet/{{trial}}", self._sheet)
        router.add_get(f"{_PREFIX}/api/csv/{{trial}}", self._csv)
        router.add_get(f"{_PREFIX}/api/signature/{{trial}}", self._signature)
        router.add_get(f"{_PREFIX}/api/workload/{{trial}}", self._workload)
        router.add_post(f"{_PREFIX}/api/workload/{{trial}}", self._take_workload)
        self.briefs.route(router, _PREFIX)
        self._class.route(router, _PREFIX)
        self._progress.route(router, _PROGRESS)

    def show_at(self, video_server: str) -> None:
        """Have a video server show folder and handler at ``/training/``, progress at its own."""
        package = Path(package_path("telex_training"))
        self.mount(video_server, "training", package / "pages")
        self.mount(video_server, "progress")

    def preview_address(self, exercise: Path) -> str:
        """Address of an exercise's picture below the video server's; empty: there is none."""
        name = self.briefs.pictures.shipped(exercise)
        return f"{_PREFIX}/preview/{name}.jpg" if name else ""

    # --- the thread ------------------------------------------------------------------------------

    async def _sheets(self, request: web.Request) -> web.Response:
        """List a person's sheets, or everybody's for an instructor."""
        sheets = await aside(self._library.sheets, None if instructs(request) else name_of(request))
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

    async def _signature(self, request: web.Request) -> web.Response:
        """Tell what the signature of an exam is worth."""
        await self._permitted(request)
        return web.json_response(await aside(self._library.signature, request.match_info["trial"]))

    async def _workload(self, request: web.Request) -> web.Response:
        """Tell the ratings of a trial, or null."""
        await self._permitted(request)
        return web.json_response(await aside(self._library.workload, request.match_info["trial"]))

    async def _take_workload(self, request: web.Request) -> web.Response:
        """Take an operator's ratings of his own trial."""
        sheet, trial = await self._permitted(request), request.match_info["trial"]
        if sheet.get("operator") != name_of(request):
            raise web.HTTPForbidden(text="The workload is rated by who did the trial.\n")
        # A page that was opened twice, or long ago, still has its sliders.
        if await aside(self._library.workload, trial) is not None:
            raise web.HTTPConflict(text="The workload of this trial has been rated already.\n")
        try:
            given = workload_of(await posted(request))
        except BadEntryError as error:
            raise web.HTTPBadRequest(text=f"{error}\n") from error
        try:
            await aside(self._rate, trial, given["ratings"])
        except RuntimeError as error:
            raise web.HTTPConflict(text=f"{error}\n") from error
        return web.json_response(given)

    async def _permitted(self, request: web.Request) -> Dict[str, Any]:
        sheet: Optional[Dict[str, Any]] = await aside(
            self._library.sheet, request.match_info["trial"]
        )
        # Whose it is not must not even learn that it is there.
        if sheet is None or not is_for(request, sheet.get("operator", "")):
            raise web.HTTPNotFound(text="There is no sheet of this trial under your name.\n")
        return sheet


def _row(sheet: Dict[str, Any]) -> Dict[str, Any]:
    return {
        key: sheet[key]
        for key in ("trial", "operator", "exercise", "mode", "valid", "verdict", "summary")
    }
