"""Mounts of other processes on the video server: folders of files, and HTTP handlers.

The parameter `~mounts/NAME` of the video server, which any process of the master may set and delete
at any time, mounts what it names at `/NAME/`.
"""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Awaitable, Callable, Optional

from aiohttp import web
from yarl import URL

from telex_control.common.params import ConfigError, read_struct, require, require_choice

from ..tokens import INSTRUCTOR, ForbiddenError
from .gate import Gate
from .handlers import Handlers, MountError

MOUNTS = "mounts"
"""Private parameter of the video server that holds all mounts."""

ALL, CLIENT = "all", "client"
_READING = ("GET", "HEAD")

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
_HANDLER = re.compile(r"http://127\.0\.0\.1:(?P<port>[1-9][0-9]{0,4})")


@dataclass(frozen=True)
class Mount:
    """What a parameter `~mounts/NAME` says.

    Attributes
    ----------
    folder
        Absolute path of a folder, whose files are served.
    handler
        Address of an HTTP server on this machine, which answers what is no file of the folder.
    access
        Who gets in: `client`, who knows the token of pictures; `instructor`; or `all`, but to the
        files alone.
    """

    folder: str = ""
    handler: str = ""
    access: str = CLIENT

    def __post_init__(self) -> None:
        require(
            bool(self.folder or self.handler),
            "folder and handler are both empty; one of them must be given",
        )
        require(
            not self.folder or os.path.isabs(self.folder),
            f"folder is {self.folder!r}; it must be an absolute path",
        )
        # No other host: whoever sets a parameter must not make this server fetch from anywhere.
        found = _HANDLER.fullmatch(self.handler)
        require(
            not self.handler or (found is not None and int(found["port"]) < 65536),
            f"handler is {self.handler!r}; it must be http://127.0.0.1:PORT, and nothing after it",
        )
        require_choice(self, "access", (ALL, CLIENT, INSTRUCTOR))


class Mounts:
    """Answers requests for what is mounted.

    Parameters
    ----------
    ask
        Returns a parameter's value, or None if it is not set.
    warn
        Called with what an administrator should know.
    """

    def __init__(
        self,
        gate: Gate,
        handlers: Handlers,
        ask: Callable[[str], Awaitable[object]],
        warn: Callable[[str], None],
    ) -> None:
        self._gate = gate
        self._handlers = handlers
        self._ask = ask
        self._warn = warn

    async def answer(self, request: web.Request) -> web.StreamResponse:
        """Answer a GET, HEAD or POST, in whose match `path` is the address without its first slash.

        Raises
        ------
        aiohttp.web.HTTPNotFound, aiohttp.web.HTTPMethodNotAllowed
            Nothing is mounted there.
        ForbiddenError
            The client does not get in.
        MountError
            The mount cannot be used, or its handler does not answer.
        """
        name, slash, path = request.match_info["path"].partition("/")
        reads = request.method != "POST"
        nothing = web.HTTPNotFound() if reads else web.HTTPMethodNotAllowed("POST", _READING)
        mount = await self._find(name)
        if mount is None:
            raise nothing
        if reads and not slash:  # without it the page's own links would lead elsewhere
            query = request.rel_url.raw_query_string
            raise web.HTTPFound(URL(f"/{name}/?{query}" if query else f"/{name}/", encoded=True))
        file = find_file(Path(mount.folder), path) if reads and mount.folder else None
        # Folders that are open to all require no admission; a handler always learns who asks.
        if mount.access != ALL or (file is None and mount.handler):
            instructor = await self._admit(request, name, mount)
            self._gate.require_page(request.path, instructor=instructor)
            if file is None and mount.handler:
                return await self._handlers.answer(request, mount.handler, instructor=instructor)
        if file is None:
            raise nothing
        return web.FileResponse(file)

    async def _admit(self, request: web.Request, name: str, mount: Mount) -> bool:
        """Return whether a client is an instructor; raises a ForbiddenError if it may not enter."""
        instructor = await self._gate.admit(request)
        if mount.access == INSTRUCTOR and not instructor:
            raise ForbiddenError(
                403,
                f"/{name}/ is for instructors: add role=instructor to the address, and the "
                "instructor's token where one is asked for.",
            )
        return instructor

    async def _find(self, name: str) -> Optional[Mount]:
        if not _NAME.fullmatch(name):
            return None
        parameter = f"~{MOUNTS}/{name}"
        value = await self._ask(parameter)
        if value is None:
            return None
        try:
            return read_struct(Mount, value, parameter)
        except ConfigError as error:
            self._warn(str(error))
            raise MountError(
                500, f"The parameter {parameter} cannot be used; the server's log says why."
            ) from None


def find_file(folder: Path, name: str) -> Optional[Path]:
    """Return a file inside a folder, or None if there is none.

    Parameters
    ----------
    folder
        Absolute path.
    name
        Path inside it, from a client. With a slash at its end it stands for the `index.html` there;
        what leads out of the folder, by dots or by links, does not exist.
    """
    folder = folder.resolve()
    if name == "" or name.endswith("/"):
        name += "index.html"
    try:
        path = (folder / name).resolve()
        return path if folder in path.parents and path.is_file() else None
    except (OSError, ValueError):  # the name is too long, or holds a null byte
        return None
