"""The page of progress, for the pages' handler: a person's own, or a class's for an instructor."""

from __future__ import annotations

import asyncio
import time
from typing import Callable, Dict, List, Set

import rospy
from aiohttp import web

from ...progress.curriculum_file import CurriculumError, curricula, load_curriculum
from ...progress.index import ProgressIndex, ProgressIndexError
from ...progress.reports.class_report import class_report
from ...progress.reports.person_report import person_report
from ...progress.trial_facts import TrialFacts

_HEADERS = {
    "Cache-Control": "no-store",
    # The report is one file with its style and its figures in it.
    "Content-Security-Policy": (
        "default-src 'none'; style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'; "
        "frame-ancestors 'self'"
    ),
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}


class ProgressPages:
    """Answers requests for progress.

    Parameters
    ----------
    index : ProgressIndex
    instructs : callable
        Whether whoever asks is an instructor.
    name_of : callable
        Name of whoever asks; empty: none.
    """

    def __init__(
        self,
        index: ProgressIndex,
        instructs: Callable[[web.Request], bool],
        name_of: Callable[[web.Request], str],
    ) -> None:
        self._index = index
        self._instructs, self._name_of = instructs, name_of
        self._told: Set[str] = set()

    def route(self, router: web.UrlDispatcher, prefix: str) -> None:
        """Answer at the address `prefix`."""
        router.add_get(f"{prefix}/", self._progress)

    async def _progress(self, request: web.Request) -> web.Response:
        """Show the progress of ``?person=``, or of whoever asks; to an instructor the class's."""
        person = request.query.get("person", "")
        instructs = self._instructs(request)
        if not person and not instructs:
            person = self._name_of(request)
            if not person:
                raise web.HTTPNotFound(text="Progress is shown by name: ?name=YOUR-NAME\n")
        if not instructs and person != self._name_of(request):
            raise web.HTTPNotFound(text="There is no progress of this person under your name.\n")
        loop = asyncio.get_running_loop()
        try:
            text = await loop.run_in_executor(None, self._page, person)
        except ProgressIndexError as error:
            raise web.HTTPServiceUnavailable(text=f"{error}\n") from error
        return web.Response(text=text, content_type="text/html", headers=_HEADERS)

    def _page(self, person: str) -> str:
        """Make the page of a person's progress; of everybody's where the name is empty."""
        for problem in self._index.refresh():
            self._warn(problem)
        courses = []
        for path in curricula().values():
            try:
                courses.append(load_curriculum(path))
            except CurriculumError as error:
                self._warn(str(error))
        now = time.time()
        if person:
            return person_report(person, self._index.trials(person), courses, now)
        people: Dict[str, List[TrialFacts]] = {}
        for trial in self._index.trials():
            people.setdefault(trial.operator, []).append(trial)
        return class_report(people, courses, now)

    def _warn(self, problem: str) -> None:
        """Say once in the log what is left out."""
        if problem not in self._told:
            self._told.add(problem)
            rospy.logwarn("progress: left out: %s", problem)
