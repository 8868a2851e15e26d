"""Passing requests on to HTTP handlers of other processes on this machine."""

from __future__ import annotations

import asyncio
import urllib.parse
from typing import AsyncIterator, Callable, Optional

import aiohttp
from aiohttp import hdrs, web
from multidict import CIMultiDict, CIMultiDictProxy
from yarl import URL

from ..tokens import INSTRUCTOR, OPERATOR, client_name

ROLE, NAME = "X-Telex-Role", "X-Telex-Name"
"""Headers that tell a handler who asks."""

MAX_REQUESTS = 256
"""Requests that may be under way to handlers at a time."""

_OWN = "x-telex-"
_DOTS = (".", "..")

# Between two neighbours only (RFC 9110, 7.6.1).
_HOP_BY_HOP = {
    "connection",
    "keep-alive",
    "proxy-authenticate",
    "proxy-authorization",
    "proxy-connection",
    "te",
    "trailer",
    "transfer-encoding",
    "upgrade",
}
# The token has been checked here, and is nothing for other logs; a referrer may hold it as well.
_KEPT_BACK = {"host", "expect", "authorization", "referer"}
_LEFT_TO_CLIENTS = (hdrs.ACCEPT, hdrs.ACCEPT_ENCODING, hdrs.CONTENT_TYPE, hdrs.USER_AGENT)


class MountError(Exception):
    """What is mounted cannot answer; the text says why, `status` is that of the HTTP reply."""

    def __init__(self, status: int, sentence: str) -> None:
        super().__init__(sentence)
        self.status = status


class Handlers:
    """Passes requests on to handlers and their answers back, as streams.

    Parameters
    ----------
    max_upload
        Bytes that a client may send in one request.
    timeout
        Time (s) after which a request or an answer that does not move is given up.
    warn
        Called with what an administrator should know.
    """

    def __init__(self, max_upload: int, timeout: float, warn: Callable[[str], None]) -> None:
        self._max_upload = max_upload
        self._timeout = timeout
        self._warn = warn
        self._under_way = 0
        self._session: Optional[aiohttp.ClientSession] = None

    async def run(self, _app: web.Application) -> AsyncIterator[None]:
        """Hold what connections need while an application runs; for its `cleanup_ctx`."""
        self._session = aiohttp.ClientSession(
            # A connection that is kept would fail when the handler has been started again.
            connector=aiohttp.TCPConnector(limit=0, force_close=True),
            cookie_jar=aiohttp.DummyCookieJar(),  # cookies are the clients' own
            timeout=aiohttp.ClientTimeout(total=None),  # see _ask
            auto_decompress=False,
        )
        yield
        await self._session.close()

    async def answer(
        self, request: web.Request, handler: str, *, instructor: bool
    ) -> web.StreamResponse:
        """Let a handler answer a request, of which it gets the whole path.

        Parameters
        ----------
        handler
            Address of the handler's server, without a path.
        instructor
            Whether the client is an instructor.

        Raises
        ------
        MountError
            The request is too large or not one to pass on, or the handler does not answer.
        """
        if self._under_way >= MAX_REQUESTS:
            raise MountError(503, f"{MAX_REQUESTS} requests are under way already.")
        self._under_way += 1
        try:
            reply = await self._forward(request, handler, instructor=instructor)
            async with reply:
                return await self._pass_back(request, reply)
        finally:
            self._under_way -= 1

    async def _forward(
        self, request: web.Request, handler: str, *, instructor: bool
    ) -> aiohttp.ClientResponse:
        """Ask the handler and return its answer, of which the body may still be to come."""
        url = URL(handler + _target(request), encoded=True)
        headers = _request_headers(request, instructor=instructor)
        upload = _Upload(request, self._max_upload)
        try:
            return await self._ask(request.method, url, headers, upload)
        except aiohttp.ClientError as error:
            if upload.too_large:
                raise self._too_large() from None
            self._warn(f"the handler at {handler} does not answer {request.path[:200]}: {error}")
            raise MountError(
                502,
                f"The program that answers here, at {handler}, cannot be reached: it has ended, or "
                "has not started yet.",
            ) from None
        except ValueError:
            raise MountError(400, "The request's head holds what cannot be passed on.") from None

    def _too_large(self) -> MountError:
        return MountError(413, f"A request may hold {self._max_upload} bytes at most.")

    async def _ask(
        self, method: str, url: URL, headers: CIMultiDict[str], upload: _Upload
    ) -> aiohttp.ClientResponse:
        """Send a request and return the answer as soon as its head has come."""
        if upload.announced > self._max_upload:
            raise self._too_large()
        assert self._session is not None
        asking = asyncio.ensure_future(
            self._session.request(
                method,
                url,
                headers=headers,
                data=upload.chunks() if upload.holds_any else None,
                allow_redirects=False,
                skip_auto_headers=_LEFT_TO_CLIENTS,
            )
        )
        loop = asyncio.get_running_loop()
        try:
            while not asking.done():
                left = upload.moved + self._timeout - loop.time()
                if left <= 0.0:
                    raise MountError(
                        504, f"Nothing has moved for {self._timeout:g} s: no answer has come."
                    )
                await asyncio.wait({asking}, timeout=left)
            return asking.result()
        finally:
            asking.cancel()

    async def _pass_back(
        self, request: web.Request, reply: aiohttp.ClientResponse
    ) -> web.StreamResponse:
        response = web.StreamResponse(
            status=reply.status, reason=reply.reason, headers=_end_to_end(reply.headers)
        )
        await response.prepare(request)
        while True:
            try:
                chunk = await asyncio.wait_for(reply.content.readany(), self._timeout)
            except (aiohttp.ClientError, asyncio.TimeoutError) as error:
                self._warn(f"an answer to {request.path[:200]} has broken off: {error!r}")
                raise _broken_off(request) from None
            if not chunk:
                break
            try:
                await asyncio.wait_for(response.write(chunk), self._timeout)
            except asyncio.TimeoutError:
                raise _broken_off(request) from None
        await response.write_eof()
        return response


def _broken_off(request: web.Request) -> Exception:
    """End the connection, as the only way to tell a client that has got the head, and say so."""
    if request.transport is not None:
        request.transport.abort()
    return ConnectionResetError("half an answer is none")


class _Upload:
    """The body of a request on its way to a handler.

    Attributes
    ----------
    announced
        Bytes that the client says it will send.
    moved
        Time (s, of the loop) when a part of it went on last.
    too_large
        More has come than may.
    """

    def __init__(self, request: web.Request, most: int) -> None:
        self._content = request.content
        self._most = most
        self._loop = asyncio.get_running_loop()
        self.holds_any = request.can_read_body
        self.announced = request.content_length or 0
        self.moved = self._loop.time()
        self.too_large = False

    async def chunks(self) -> AsyncIterator[bytes]:
        size = 0
        async for chunk in self._content.iter_any():
            size += len(chunk)
            if size > self._most:
                self.too_large = True
                raise aiohttp.ClientPayloadError("the request is too large")
            self.moved = self._loop.time()
            yield chunk
        self.moved = self._loop.time()


def _target(request: web.Request) -> str:
    """Return path and query of a request as they came, but for the token.

    Raises
    ------
    MountError
        The path would lead out of the mount.
    """
    path = request.rel_url.raw_path
    if any(part in _DOTS for part in urllib.parse.unquote(path).replace("\\", "/").split("/")):
        raise MountError(404, "A path must not hold . or .. for a part.")
    parts = request.rel_url.raw_query_string.split("&")
    query = "&".join(part for part in parts if _key(part) != "token")
    return f"{path}?{query}" if query else path


def _key(part: str) -> str:
    return urllib.parse.unquote_plus(part.partition("=")[0])


def _end_to_end(headers: CIMultiDictProxy[str]) -> CIMultiDict[str]:
    """Return those headers of a message that are not between two neighbours only."""
    named = {name.strip().lower() for name in headers.get(hdrs.CONNECTION, "").split(",")}
    dropped = _HOP_BY_HOP | named
    return CIMultiDict((key, value) for key, value in headers.items() if key.lower() not in dropped)


def _request_headers(request: web.Request, *, instructor: bool) -> CIMultiDict[str]:
    headers = _end_to_end(request.headers)
    if any(key.lower().startswith(_OWN) for key in headers):
        # A handler believes them. Besides, this server may be its own handler by mistake.
        raise MountError(400, f"Headers that begin with {_OWN} are this server's own.")
    for key in _KEPT_BACK:
        headers.popall(key, None)
    if hdrs.CONTENT_ENCODING in request.headers:  # the body has been decoded as it came
        headers.popall(hdrs.CONTENT_ENCODING, None)
        headers.popall(hdrs.CONTENT_LENGTH, None)
    headers[ROLE] = INSTRUCTOR if instructor else OPERATOR
    headers[NAME] = urllib.parse.quote(client_name(request))
    return headers
