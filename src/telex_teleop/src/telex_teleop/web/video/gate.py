"""Admission to the pictures of each robot, and to those of hidden cameras."""

from __future__ import annotations

import secrets
from typing import Awaitable, Callable, Iterable, List, Optional

from aiohttp import web

from telex_control.common.params import ConfigError

from ..exam.exam_list import PARAMETER, Exam
from ..origins import origin_allowed
from ..server_config import VideoServerConfig
from ..token_files import read_token
from ..tokens import (
    CLIENT_FILE,
    FILES,
    INSTRUCTOR_FILE,
    ForbiddenError,
    Tokens,
    is_instructor,
    is_loopback,
    read_tokens,
)
from .topics import belongs_to


class Gate:
    """Admits clients as the bridge does, by the same tokens, so that one token is good for both.

    Tokens of which no file was given are the bridge's, whose own parameters name its files.

    Parameters
    ----------
    namespace
        The robot's namespace, with slashes around it.
    ask
        Returns a parameter's value, or None if it is not set.
    exam
        What operators may see while an exam runs.
    bridge
        Name of the robot's bridge.

    Raises
    ------
    telex_control.common.params.ConfigError
        A file that was given cannot be used.
    """

    def __init__(
        self,
        config: VideoServerConfig,
        namespace: str,
        ask: Callable[[str], Awaitable[object]],
        exam: Exam,
        bridge: str,
    ) -> None:
        self.exam = exam
        self._heard_of_exams = False
        self._hidden = config.hidden_cameras
        self._ask = ask
        self._is_local = is_loopback(config.address)
        given = {name: getattr(config, name) for name in FILES if getattr(config, name)}
        self._own = read_tokens(given, f"{namespace}video_server")
        self._bridge = bridge

    async def admit(self, request: web.Request) -> bool:
        """Return whether a client that may see pictures is an instructor.

        Raises
        ------
        ForbiddenError
            It may not see any, or it is a foreign web page that would change something where no
            token is asked for; the text says why.
        """
        tokens = await self._tokens()
        changes = request.method not in ("GET", "HEAD")
        if changes and not tokens.client and not origin_allowed(request):
            raise ForbiddenError(403, "This page's origin may not change anything here.")
        await self._learn_of_exam()
        # Without a token whoever says so is an instructor, which is not enough during an exam.
        return is_instructor(request, tokens) and (bool(tokens.instructor) or not self.exam.trial)

    def hear_of_exam(self, trial: str) -> None:
        """Hear from the bridge for which trial the exam's list holds; empty: for none."""
        self._heard_of_exams = True
        self.exam.set(trial)

    async def _learn_of_exam(self) -> None:
        """Ask for the exam that began before this server, until the bridge's topic is heard."""
        if self._heard_of_exams:
            return
        trial = await self._ask(f"{self._bridge}/{PARAMETER}")
        if not self._heard_of_exams:
            self.exam.set(trial)

    async def _tokens(self) -> Tokens:
        client = self._own.client or await self._of_bridge(CLIENT_FILE)
        instructor = self._own.instructor or await self._of_bridge(INSTRUCTOR_FILE)
        if not client and not self._is_local:
            raise ForbiddenError(
                401,
                "This server listens to more than its own machine and knows no token that it could "
                "ask for: set its parameter ~token_file, or start the bridge, which makes one.",
            )
        if client and not instructor:
            instructor = secrets.token_urlsafe()  # an empty one would make everybody an instructor
        return Tokens(client, instructor)

    async def _of_bridge(self, name: str) -> str:
        parameter = f"{self._bridge}/{name}"
        path = await self._ask(parameter)
        if not isinstance(path, str) or not path:
            return ""
        try:
            return read_token(path, parameter)
        except FileNotFoundError:
            reason = "is not there"
        except ConfigError:
            reason = "cannot be used; the bridge says why"
        raise ForbiddenError(
            401, f"The bridge's {name}, which would say whose the pictures are, {reason}."
        )

    def require_visible(self, topic: str, *, instructor: bool) -> None:
        """Raise a ForbiddenError if a topic is of a camera that the client may not see."""
        if not instructor and not self.exam.allows("subscribe", topic):
            raise ForbiddenError(403, f"{self.exam.refusal('subscribe', topic)}.")
        camera = None if instructor else self._hidden_camera(topic)
        if camera is not None:
            raise ForbiddenError(
                403,
                f"The camera '{camera}' is for instructors: add role=instructor to the address, "
                "and the instructor's token where one is asked for.",
            )

    def visible(self, topics: Iterable[str], *, instructor: bool) -> List[str]:
        """Return those topics that the client may see."""
        return [topic for topic in topics if instructor or self._is_open(topic)]

    def require_page(self, path: str, *, instructor: bool) -> None:
        """Raise a ForbiddenError if an address of another process is closed to the client now."""
        if not instructor and not self.exam.allows("pages", path):
            raise ForbiddenError(403, f"{self.exam.refusal('pages', path)}.")

    def _is_open(self, topic: str) -> bool:
        return not self._hidden_camera(topic) and self.exam.allows("subscribe", topic)

    def _hidden_camera(self, topic: str) -> Optional[str]:
        """Return the hidden camera to which a topic belongs, of whatever robot of the master."""
        return next((name for name in self._hidden if belongs_to(topic, name)), None)
