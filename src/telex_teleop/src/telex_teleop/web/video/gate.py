"""Admission to pictures, and to those of hidden cameras."""

from __future__ import annotations

import secrets
from typing import Awaitable, Callable, Iterable, List, Optional

from aiohttp import web

from telex_control.common.params import ConfigError

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
    """Lets clients in as the bridge does, by the same tokens, so that one opens both.

    Tokens of which no file was given are the bridge's, whose own parameters name its files.

    Parameters
    ----------
    config
        The node's parameters.
    namespace
        The node's namespace, with slashes around it.
    ask
        Returns a parameter's value, or None if it is not set.

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
    ) -> None:
        self._config = config
        self._hidden = config.hidden_cameras
        self._ask = ask
        self._is_local = is_loopback(config.address)
        given = {name: getattr(config, name) for name in FILES if getattr(config, name)}
        self._own = read_tokens(given, f"{namespace}video_server")

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
        return is_instructor(request, tokens)

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
        parameter = f"{self._config.rosbridge}/{name}"
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
        camera = None if instructor else self._hidden_camera(topic)
        if camera is not None:
            raise ForbiddenError(
                403,
                f"The camera '{camera}' is for instructors: add role=instructor to the address, "
                "and the instructor's token where one is asked for.",
            )

    def visible(self, topics: Iterable[str], *, instructor: bool) -> List[str]:
        """Return those topics that the client may see."""
        return [topic for topic in topics if instructor or not self._hidden_camera(topic)]

    def _hidden_camera(self, topic: str) -> Optional[str]:
        """Return the hidden camera to which a topic belongs, of whatever robot of the master."""
        return next((name for name in self._hidden if belongs_to(topic, name)), None)
