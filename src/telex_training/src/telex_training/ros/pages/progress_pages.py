"""The page of progress, for the pages' handler: a person's own, or a class's for an instructor."""

from __future__ import annotations

import time
from typing import Any, Callable, Dict, List, Set

import rospy
from aiohttp import web

from ...progress.curriculum_file import Curriculum, CurriculumError, curricula, load_curriculum
from ...progress.index import ProgressIndex, ProgressIndexError
from ...progress.reports.class_report import class_report
from ...progress.reports.person_report import person_report
from ...progress.standing import standing
from ...progress.trial_facts import TrialFacts
from ...serving import aside
from .page_server import instructs, is_for, name_of, require_instructor

_HEADERS = {
    "Cache-Control": "no-store",
    # The report is one file with its style and its figures in it, but for its language.
    "Content-Security-Policy": (
        "default-src 'none'; style-src 'unsafe-inline'; script-src 'self'; base-uri 'none'; "
        "form-action 'none'; frame-ancestors 'self'"
    ),
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}

_LANGUAGE = "/js/language/report.js"
"""Of the video server's console, which shows the pages."""


class ProgressPages:
    """Answers requests for progress."""

    def __init__(self, index: ProgressIndex) -> None:
        self._index = index
        self._told: Set[str] = set()

    def route(self, router: web.UrlDispatcher, prefix: str) -> None:
        """Answer at the address `prefix`."""
        router.add_get(f"{prefix}/", self._progress)
        router.add_get(f"{prefix}/api/standing", self._standing)

    async def _progress(self, request: web.Request) -> web.Response:
        """Show the progress of ``?person=``, or of whoever asks; to an instructor the class's."""
        person = request.query.get("person", "")
        if not person and not instructs(request):
            person = name_of(request)
            if not person:
                raise web.HTTPNotFound(text="Progress is shown by name: ?name=YOUR-NAME\n")
        if not is_for(request, person):
            raise web.HTTPNotFound(text="There is no progress of this person under your name.\n")
        text = await _aside(self._page, person)
        return web.Response(text=text, content_type="text/html", headers=_HEADERS)

    async def _standing(self, request: web.Request) -> web.Response:
        """Tell an instructor where everybody stands in the curricula that were begun."""
        require_instructor(request)
        return web.json_response(await _aside(self._standings))

    def _standings(self) -> List[Dict[str, Any]]:
        courses, now = self._courses(), time.time()
        people = self._people()
        made = []
        for course in courses:
            stands = {name: standing(course, own, now) for name, own in people.items()}
            states = {
                name: [module.state for module in each.modules]
                for name, each in stands.items()
                if each.begun
            }
            if states:
                modules = [module.name for module in course.modules]
                about = {"name": course.name, "title": course.title}
                made.append({**about, "modules": modules, "people": states})
        return made

    def _page(self, person: str) -> str:
        """Make the page of a person's progress; of everybody's where the name is empty."""
        courses, now = self._courses(), time.time()
        if person:
            return person_report(person, self._index.trials(person), courses, now, _LANGUAGE)
        return class_report(self._people(), courses, now, script=_LANGUAGE)

    def _people(self) -> Dict[str, List[TrialFacts]]:
        """Trials of everybody, the oldest first."""
        people: Dict[str, List[TrialFacts]] = {}
        for trial in self._index.trials():
            people.setdefault(trial.operator, []).append(trial)
        return people

    def _courses(self) -> List[Curriculum]:
        """Bring the index up to date, and read the curricula."""
        for problem in self._index.refresh():
            self._warn(problem)
        courses = []
        for path in curricula().values():
            try:
                courses.append(load_curriculum(path))
            except CurriculumError as error:
                self._warn(str(error))
        return courses

    def _warn(self, problem: str) -> None:
        """Say once in the log what is left out."""
        if problem not in self._told:
            self._told.add(problem)
            rospy.logwarn("progress: left out: %s", problem)


async def _aside(work: Callable[..., Any], *arguments: Any) -> Any:
    """Do what reads the index in another thread."""
    try:
        return await aside(work, *arguments)
    except ProgressIndexError as error:
        raise web.HTTPServiceUnavailable(text=f"{error}\n") from error
