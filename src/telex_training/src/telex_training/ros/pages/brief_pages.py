"""The brief of the exercise that is open, and the picture of its goal, for the pages' handler."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Callable, Dict, NamedTuple, Optional

import rospy
from aiohttp import web

from ...briefing.brief import exercise_brief
from ...briefing.goal import GoalPictures
from ...exercises.exercise_file import ExerciseError
from ...exercises.model import Exercise
from ...serving import aside
from ..library import Library
from .page_server import is_for

_KEPT = ".goals"


class OpenTrial(NamedTuple):
    """The trial that is open.

    Attributes
    ----------
    exercise : Exercise
        In its setting.
    """

    trial: str
    exercise: Exercise
    mode: str
    operator: str


class BriefPages:
    """Answers requests for briefs.

    Parameters
    ----------
    folder : Path
        Of the recordings; pictures that had to be drawn are kept in it.
    """

    def __init__(self, library: Library, folder: Path) -> None:
        self._library = library
        self.pictures = GoalPictures(folder / _KEPT)
        self.opened: Callable[[], Optional[OpenTrial]] = lambda: None
        """Tells which trial is open, from any thread; None: none is."""
        self.texts: Callable[[], Dict[str, Dict[str, str]]] = dict
        """Tells what exercises' files say in other languages, from any thread."""

    def route(self, router: web.UrlDispatcher, prefix: str) -> None:
        """Answer under the addresses below `prefix`."""
        self._prefix = prefix
        router.add_get(f"{prefix}/api/brief/{{trial}}", self._brief)
        router.add_get(f"{prefix}/api/texts", self._texts)
        router.add_get(f"{prefix}/api/goal/{{trial}}.jpg", self._goal)
        router.add_get(f"{prefix}/preview/{{name}}.jpg", self._preview)

    def _opened(self, request: web.Request) -> OpenTrial:
        opened = self.opened()
        if opened is None or opened.trial != request.match_info["trial"]:
            raise web.HTTPNotFound(text="This trial is not open.\n")
        return opened

    async def _brief(self, request: web.Request) -> web.Response:
        opened = self._opened(request)
        brief: Dict[str, Any] = exercise_brief(opened.exercise)
        brief.update(trial=opened.trial, mode=opened.mode, best=None)
        if opened.operator and is_for(request, opened.operator):
            brief["best"] = await aside(self._best, opened)
        brief["picture"] = f"{self._prefix}/api/goal/{opened.trial}.jpg"
        return web.json_response(brief)

    async def _texts(self, _request: web.Request) -> web.Response:
        return web.json_response(await aside(self.texts))

    def _best(self, opened: OpenTrial) -> Optional[float]:
        exercise = opened.exercise
        return self._library.best_in(opened.operator, exercise.name, exercise.setting)

    async def _goal(self, request: web.Request) -> web.StreamResponse:
        opened = self._opened(request)
        try:
            path = await aside(self.pictures.picture, opened.exercise)
        except ExerciseError as error:
            rospy.logwarn("training: no picture of the goal: %s", error)
            raise web.HTTPNotFound(text=f"{error}\n") from error
        return web.FileResponse(path)

    async def _preview(self, request: web.Request) -> web.StreamResponse:
        path = self.pictures.shipped_path(request.match_info["name"])
        if path != self.pictures.shipped_path(path.stem) or not path.is_file():
            raise web.HTTPNotFound
        return web.FileResponse(path)
