"""Answers what the page of a class asks of this station, for the pages' handler."""

from __future__ import annotations

from typing import Any, Callable, Mapping

from aiohttp import web

from telex_control.common.params import ConfigError, read_value

from ...serving import aside, posted_object
from .page_server import require_instructor

_TOLD = (
    "phase trial exercise title setting mode operator valid repetition repetitions results elapsed "
    "penalty trial_elapsed trial_limit steps steps_done faults hint message verdict help holder "
    "view"
).split()
"""What is told of a trial; the rest is for who does it."""
_TEXTS = ("exercise", "setting", "mode", "operator")

Tell = Callable[[], Mapping[str, Any]]
"""Tells the trial as it stands, from any thread."""
Open = Callable[[str, str, str, str, bool], str]
"""Opens exercise, setting and mode for an operator, and starts it if that is wanted; returns the
trial, or raises a RuntimeError or a ValueError with a message for a person."""
Help = Callable[[bool], None]
"""Asks for the instructor, or says that he has come; raises a RuntimeError."""


class ClassPages:
    """Answers instructors alone.

    Parameters
    ----------
    tell, open_exercise, help_wanted : callable
        See `Tell`, `Open` and `Help`.
    """

    def __init__(self, tell: Tell, open_exercise: Open, help_wanted: Help) -> None:
        self._tell, self._open, self._help = tell, open_exercise, help_wanted

    def route(self, router: web.UrlDispatcher, prefix: str) -> None:
        """Answer under the addresses below `prefix`."""
        router.add_get(f"{prefix}/api/state", self._state)
        router.add_post(f"{prefix}/api/open", self._take_open)
        router.add_post(f"{prefix}/api/help", self._take_help)

    async def _state(self, request: web.Request) -> web.Response:
        require_instructor(request)
        told = self._tell()
        return web.json_response({key: told[key] for key in _TOLD if key in told})

    async def _take_open(self, request: web.Request) -> web.Response:
        require_instructor(request)
        content = await posted_object(request, *_TEXTS, "start")
        try:
            texts = [read_value(str, content.get(key, ""), key) for key in _TEXTS]
            start = read_value(bool, content.get("start", False), "start")
        except ConfigError as error:
            raise web.HTTPBadRequest(text=f"{error}\n") from error
        return web.json_response({"trial": await _done(self._open, *texts, start)})

    async def _take_help(self, request: web.Request) -> web.Response:
        require_instructor(request)
        content = await posted_object(request, "help")
        try:
            wanted = read_value(bool, content.get("help"), "help")
        except ConfigError as error:
            raise web.HTTPBadRequest(text=f"{error}\n") from error
        await _done(self._help, wanted)
        return web.json_response({})


async def _done(act: Callable[..., Any], *arguments: Any) -> Any:
    """Do it in another thread; what is refused is told as a conflict."""
    try:
        return await aside(act, *arguments)
    except (RuntimeError, ValueError) as error:
        raise web.HTTPConflict(text=f"{error}\n") from error
