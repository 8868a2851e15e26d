"""An HTTP server on this machine that answers what a mount of the video server passes on.

The video server checks tokens, and says in headers who asks.
"""

from __future__ import annotations

import asyncio
import contextlib
import threading
import urllib.parse
from pathlib import Path
from typing import List, Optional

import rospy
from aiohttp import web

_ROLE, _NAME = "X-Telex-Role", "X-Telex-Name"
_INSTRUCTOR = "instructor"
_STARTING = 10.0
_LARGEST_UPLOAD = 2**16


class PageServer:
    """An HTTP server on 127.0.0.1, in a thread of its own; derived classes add what it answers.

    Parameters
    ----------
    port : int
        0: any free one.
    """

    def __init__(self, port: int) -> None:
        self._port = port
        self._loop = asyncio.new_event_loop()
        self._ready = threading.Event()
        self._address = ""
        self._mounted: List[str] = []
        self._thread = threading.Thread(target=self._run, name="pages", daemon=True)

    def add_routes(self, router: web.UrlDispatcher) -> None:
        """Say what is answered."""
        raise NotImplementedError

    def start(self) -> None:
        """Listen.

        Raises
        ------
        RuntimeError
            The port is taken.
        """
        self._thread.start()
        if not self._ready.wait(_STARTING) or not self._address:
            raise RuntimeError(
                f"port is {self._port}; nothing can listen there: another port, or 0, is needed"
            )

    def mount(self, video_server: str, name: str, folder: Optional[Path] = None) -> None:
        """Have a video server show this handler at ``/name/``, and the files of a folder."""
        parameter = rospy.resolve_name(f"{video_server}/mounts/{name}")
        mount = {"handler": self._address}
        if folder is not None:
            # Files need no token, for nothing in a page gives it to its scripts; what is personal
            # comes from the handler, which nobody reaches without one.
            mount.update(folder=str(folder), access="all")
        rospy.set_param(parameter, mount)
        self._mounted.append(parameter)

    def close(self) -> None:
        """Listen no more, and take the mounts back."""
        for parameter in self._mounted:
            # The master may be gone, or the parameter.
            with contextlib.suppress(KeyError, OSError):
                rospy.delete_param(parameter)
        self._loop.call_soon_threadsafe(self._loop.stop)

    # --- the thread ------------------------------------------------------------------------------

    def _run(self) -> None:
        asyncio.set_event_loop(self._loop)
        try:
            self._loop.run_until_complete(self._listen())
        except OSError:
            self._ready.set()
            return
        self._ready.set()
        self._loop.run_forever()

    async def _listen(self) -> None:
        app = web.Application(client_max_size=_LARGEST_UPLOAD)
        self.add_routes(app.router)
        runner = web.AppRunner(app, access_log=None)
        await runner.setup()
        site = web.TCPSite(runner, "127.0.0.1", self._port)
        await site.start()
        host, port = runner.addresses[0][:2]
        self._address = f"http://{host}:{port}"


def instructs(request: web.Request) -> bool:
    """Whether an instructor asks."""
    return request.headers.get(_ROLE) == _INSTRUCTOR


def require_instructor(request: web.Request) -> None:
    """Refuse everybody else.

    Raises
    ------
    aiohttp.web.HTTPForbidden
    """
    if not instructs(request):
        raise web.HTTPForbidden(text="This is for instructors: add role=instructor.\n")


def name_of(request: web.Request) -> str:
    """Name that whoever asks gives himself."""
    return urllib.parse.unquote(request.headers.get(_NAME, ""))


def is_for(request: web.Request, person: str) -> bool:
    """Whether whoever asks may know what a person of this name has done."""
    return instructs(request) or person == name_of(request)
