"""Who may see the pictures, and whose those of hidden cameras are."""

from __future__ import annotations

import secrets
from typing import Awaitable, Callable, FrozenSet, Iterable, List

from aiohttp import web

from ..config import VideoServerConfig
from ..tokens import ForbiddenError, Tokens, is_instructor, is_loopback
from .topics import camera_of


class Gate:
    """Lets clients in as the bridge does, by the same tokens, so that one opens both.

    Tokens that were not given are the bridge's, which holds them, given or made up, as its own
    parameters.

    Parameters
    ----------
    config
        The node's parameters.
    namespace
        The node's namespace, with slashes around it.
    ask
        Returns a parameter's value, or None if it is not set.
    """

    def __init__(
        self,
        config: VideoServerConfig,
        namespace: str,
        ask: Callable[[str], Awaitable[object]],
    ) -> None:
        self._config = config
        self._namespace = namespace
        self._hidden: FrozenSet[str] = frozenset(config.hidden_cameras)
        self._ask = ask
        self._is_local = is_loopback(config.address)

    async def admit(self, request: web.Request) -> bool:
        """Return whether a client that may see pictures is an instructor.

        Raises
        ------
        ForbiddenError
            It may not see any; the text says why.
        """
        return is_instructor(request, await self._tokens())

    async def _tokens(self) -> Tokens:
        config = self._config
        client = config.token or await self._of_bridge("token")
        instructor = config.instructor_token or await self._of_bridge("instructor_token")
        if not client and not self._is_local:
            raise ForbiddenError(
                401,
                "This server listens to more than its own machine and knows no token that it could "
                "ask for: set its parameter ~token, or start the bridge, which makes one up.",
            )
        if client and not instructor:
            instructor = secrets.token_urlsafe()  # an empty one would make everybody an instructor
        return Tokens(client, instructor)

    async def _of_bridge(self, name: str) -> str:
        value = await self._ask(f"{self._config.rosbridge}/{name}")
        return value if isinstance(value, str) else ""

    def require_visible(self, topic: str, *, instructor: bool) -> None:
        """Raise a ForbiddenError if a topic is of a camera that the client may not see."""
        if not instructor and self._is_hidden(topic):
            camera = camera_of(topic, self._namespace)
            raise ForbiddenError(
                403,
                f"The camera '{camera}' is for instructors: add role=instructor to the address, "
                "and the instructor's token where one is asked for.",
            )

    def visible(self, topics: Iterable[str], *, instructor: bool) -> List[str]:
        """Return those topics that the client may see."""
        return [topic for topic in topics if instructor or not self._is_hidden(topic)]

    def _is_hidden(self, topic: str) -> bool:
        return camera_of(topic, self._namespace) in self._hidden
