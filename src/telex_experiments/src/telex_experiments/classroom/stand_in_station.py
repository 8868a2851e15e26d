"""A stand-in for a station, as the page of a class sees it: plays recorded states over HTTP."""

from __future__ import annotations

import asyncio
import contextlib
import threading
import time
from typing import (
    Any,
    AsyncIterator,
    Callable,
    Coroutine,
    Dict,
    Iterator,
    List,
    Mapping,
    Optional,
    Sequence,
)

from aiohttp import web

from telex_sim.scene.robot_in_scene import robot_description
from telex_training.exercises.model import Exercise
from telex_training.exercises.seeds import scene_text
from telex_training.judging.entries import Entry
from telex_training.judging.judge import Judge

_PATIENCE = 30.0

Answer = Any
"""Coroutine function of a request: a response that comes in place of the usual one, or None."""


def recorded_states(
    exercise: Exercise, seed: int, entries: Sequence[Entry], operator: str, period: float = 1.0
) -> List[Dict[str, Any]]:
    """States of a recorded trial at equal times, as a station tells them.

    Parameters
    ----------
    seed : int
        Of the trial.
    entries : sequence of Entry
        What the judge was fed with.
    operator : str
        Whose trial it shall seem to be.
    period : float
        Sim time between two of them (s).
    """
    judge = Judge(exercise, scene_text(exercise, seed), robot_description(exercise.variant))
    more = {"operator": operator, "holder": operator, "help": None, "view": "front"}
    states: List[Dict[str, Any]] = []
    for entry in entries:
        judge.feed(entry)
        if entry.time >= len(states) * period:
            states.append({**judge.state(), **more})
    return states


class StandInStation:
    """Answers what a class asks of a station.

    Parameters
    ----------
    states : sequence of mapping
        As ``/training/api/state`` has them; played again and again.
    picture : bytes
        A JPEG; empty: nobody watches, and none can be drawn.
    token : str
        Of instructors; empty: none is asked for.
    period : float
        Time for which each state stands (s).
    courses : sequence of mapping
        As ``/progress/api/standing`` has them.

    Attributes
    ----------
    port : int
        At which it listens; it keeps it when it goes and comes back.
    asked : list of str
        Paths that were asked for, with what was sent.
    sent : list of mapping
        Bodies of the requests that change something.
    answer : callable or None
        See `Answer`.
    """

    def __init__(
        self,
        states: Sequence[Mapping[str, Any]],
        picture: bytes = b"",
        token: str = "",
        period: float = 1.0,
        courses: Sequence[Mapping[str, Any]] = (),
    ) -> None:
        self.port = 0
        self.asked: List[str] = []
        self.sent: List[Mapping[str, Any]] = []
        self.answer: Optional[Answer] = None
        self.changes: Dict[str, Any] = {}
        self._states, self._period = list(states), period
        self._picture, self._token, self._courses = picture, token, list(courses)
        self._began = time.monotonic()
        self._runner: Optional[web.AppRunner] = None

    @property
    def address(self) -> str:
        """Of its video server."""
        return f"http://127.0.0.1:{self.port}"

    def app(self) -> web.Application:
        """Return the application."""
        app = web.Application(middlewares=[self._check])
        app.router.add_get("/training/api/state", self._state)
        app.router.add_post("/training/api/open", self._open)
        app.router.add_post("/training/api/help", self._help)
        app.router.add_get("/progress/api/standing", self._standing)
        app.router.add_get("/config.json", self._config)
        app.router.add_get("/snapshot", self._snapshot)
        app.router.add_get("/instructor", self._page)
        return app

    @contextlib.asynccontextmanager
    async def served(self) -> AsyncIterator[None]:
        """Be there for a while."""
        runner = self._runner = web.AppRunner(self.app(), access_log=None, shutdown_timeout=0.1)
        await runner.setup()
        try:
            await web.TCPSite(runner, "127.0.0.1", self.port, reuse_address=True).start()
            self.port = runner.addresses[0][1]
            yield
        finally:
            await self.vanish()

    async def vanish(self) -> None:
        """Be there no more."""
        runner, self._runner = self._runner, None
        if runner is not None:
            await runner.cleanup()

    @web.middleware
    async def _check(self, request: web.Request, handler: Any) -> web.StreamResponse:
        self.asked.append(request.path)
        if self.answer is not None:
            other = await self.answer(request)
            if other is not None:
                return other
        given = request.headers.get("Authorization", f"Bearer {request.query.get('token', '')}")
        if self._token and given != f"Bearer {self._token}":
            raise web.HTTPUnauthorized(text="This is not the instructor's token.\n")
        return await handler(request)

    async def _state(self, _request: web.Request) -> web.Response:
        place = int((time.monotonic() - self._began) / self._period) % len(self._states)
        return web.json_response({**self._states[place], **self.changes})

    async def _open(self, request: web.Request) -> web.Response:
        content = await request.json()
        self.sent.append(content)
        self.changes.update({key: content[key] for key in ("exercise", "operator")})
        return web.json_response({"trial": "t1"})

    async def _help(self, request: web.Request) -> web.Response:
        self.sent.append(await request.json())
        self.changes["help"] = None
        return web.json_response({})

    async def _standing(self, _request: web.Request) -> web.Response:
        return web.json_response(self._courses)

    async def _config(self, _request: web.Request) -> web.Response:
        return web.json_response({"main_camera": "front"})

    async def _snapshot(self, _request: web.Request) -> web.Response:
        if not self._picture:
            raise web.HTTPNotFound
        return web.Response(body=self._picture, content_type="image/jpeg")

    async def _page(self, _request: web.Request) -> web.Response:
        return web.Response(text="<title>Telex instructor</title>", content_type="text/html")


@contextlib.contextmanager
def beside(stations: Sequence[StandInStation]) -> Iterator[Callable[[Coroutine], Any]]:
    """Serve stand-ins in a thread of their own; gives what runs a coroutine in it."""
    loop = asyncio.new_event_loop()
    thread = threading.Thread(target=loop.run_forever, name="stand-ins", daemon=True)
    thread.start()
    stack = contextlib.AsyncExitStack()

    async def enter() -> None:
        for station in stations:
            await stack.enter_async_context(station.served())

    def run(coroutine: Coroutine) -> Any:
        return asyncio.run_coroutine_threadsafe(coroutine, loop).result(_PATIENCE)

    try:
        run(enter())
        yield run
    finally:
        run(stack.aclose())
        loop.call_soon_threadsafe(loop.stop)
        thread.join(10.0)
        loop.close()
