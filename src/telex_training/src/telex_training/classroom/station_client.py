"""Questions to one station over HTTP: few, short, and of bounded length and time."""

from __future__ import annotations

import asyncio
import os
import socket
import ssl
from typing import Any, Mapping, NamedTuple, Optional, Tuple

import aiohttp
from yarl import URL

from telex_control.common.params import ConfigError

from ..serving import aside
from .answers import MOST_PICTURE, MOST_STATE, BadAnswerError, json_of
from .stations_file import ClassStation, with_token_of_file

TIMEOUT = 4.0
"""For an answer (s)."""
_CONNECTIONS = 4
_WHO = {"role": "instructor", "name": "class"}
_MOST_REASON = 300
_NOT_LET_IN = (401, 403)
_PICTURES = ("image/jpeg", "image/png")


class StationError(RuntimeError):
    """A station does not answer as it should; the message says why.

    `status` is that of its reply; 0: there is none.
    """

    def __init__(self, sentence: str, status: int = 0) -> None:
        super().__init__(sentence)
        self.status = status


class _Question(NamedTuple):
    """What a station is asked: JSON to send, most bytes of the answer, and its time (s)."""

    method: str
    path: str
    query: Mapping[str, str]
    content: Optional[Mapping[str, Any]]
    most: int
    timeout: float


class StationClient:
    """Asks one station. Use it as an asynchronous context manager, on the loop's thread.

    Attributes
    ----------
    station : ClassStation
        With the token that its file held when it was read last: at first, and whenever the station
        does not take it.
    """

    def __init__(self, station: ClassStation) -> None:
        self.station = station
        self._http: Optional[aiohttp.ClientSession] = None

    async def __aenter__(self) -> StationClient:
        self._http = aiohttp.ClientSession(
            connector=aiohttp.TCPConnector(limit=_CONNECTIONS),
            cookie_jar=aiohttp.DummyCookieJar(),
            headers={"Accept-Encoding": "identity"},
            # What unpacks to much more than it seems is never unpacked.
            auto_decompress=False,
        )
        return self

    async def __aexit__(self, *exception: object) -> None:
        assert self._http is not None
        await self._http.close()

    async def get(self, path: str, most: int = MOST_STATE, timeout: Optional[float] = None) -> Any:
        """Ask for JSON, of so many bytes at most, within `TIMEOUT` or another time (s).

        Raises
        ------
        StationError
        """
        _, data = await self._ask(_Question("GET", path, {}, None, most, timeout or TIMEOUT))
        return self._json(data)

    async def post(self, path: str, content: Mapping[str, Any], timeout: float) -> Any:
        """Send JSON, and return what is answered.

        Raises
        ------
        StationError
        """
        _, data = await self._ask(_Question("POST", path, {}, content, MOST_STATE, timeout))
        return self._json(data)

    async def picture(self, topic: str, watched: bool) -> Tuple[str, bytes]:
        """Media type and bytes of a picture; `watched`: only one that is drawn already.

        Raises
        ------
        StationError
            Its status is 404 where nobody watches the topic.
        """
        query = {"topic": topic, **({"watched": "1"} if watched else {})}
        kind, data = await self._ask(
            _Question("GET", "/snapshot", query, None, MOST_PICTURE, 2.0 * TIMEOUT)
        )
        if kind not in _PICTURES:
            raise StationError(f"what came is no picture, but {kind[:40]!r}")
        return kind, data

    def _json(self, data: bytes) -> Any:
        try:
            return json_of(data)
        except BadAnswerError as error:
            raise StationError(f"{self.station.address}: {error}") from error

    async def _ask(self, question: _Question) -> Tuple[str, bytes]:
        station = self.station
        try:
            return await self._ask_once(station, question)
        except StationError as error:
            if error.status not in _NOT_LET_IN or not station.token_file:
                raise
            # It may have another token since the file was read.
            try:
                renewed = await aside(with_token_of_file, station)
            except ConfigError as reason:
                raise StationError(f"{error}; {reason}", error.status) from None
            if renewed.token == station.token:
                raise
        self.station = renewed
        return await self._ask_once(renewed, question)

    async def _ask_once(self, station: ClassStation, question: _Question) -> Tuple[str, bytes]:
        assert self._http is not None
        address = station.address
        headers = {"Authorization": f"Bearer {station.token}"} if station.token else {}
        try:
            async with self._http.request(
                question.method,
                URL(address + question.path).with_query({**_WHO, **question.query}),
                json=question.content,
                headers=headers,
                # It would take the token along to wherever it leads.
                allow_redirects=False,
                timeout=aiohttp.ClientTimeout(total=question.timeout),
            ) as reply:
                data = await _body(reply, question.most)
                if reply.status != 200:
                    raise StationError(self._refusal(reply, data), reply.status)
                return reply.content_type, data
        except asyncio.TimeoutError:
            raise StationError(f"{address}: no answer within {question.timeout:g} s") from None
        except aiohttp.ClientConnectorError as error:
            reason = _reason(error.os_error)
            raise StationError(f"{address}: it cannot be reached: {reason}") from None
        except (aiohttp.ClientError, OSError, ValueError) as error:
            raise StationError(f"{address}: {str(error)[:_MOST_REASON]}") from None

    def _refusal(self, reply: aiohttp.ClientResponse, data: bytes) -> str:
        """Say in a sentence what an answer without an OK means."""
        station, status = self.station, reply.status
        if status in _NOT_LET_IN:
            given = f"the token in {station.token_file}" if station.token_file else "no token"
            return f"{station.address}: it takes {given} for no instructor's ({status})"
        if 300 <= status < 400:
            return f"{station.address}: it leads elsewhere ({status}); that is no station's address"
        if status == 404 and reply.url.path != "/snapshot":
            return f"{station.address}: it has no training node, or one of another version (404)"
        if reply.content_type == "text/plain":
            return data.decode("utf-8", "replace").strip()[:_MOST_REASON] or f"it says {status}"
        return f"{station.address}: it says {status} {str(reply.reason)[:60]}"


def _reason(error: OSError) -> str:
    """Say why there is no connection."""
    if isinstance(error, ssl.SSLError):
        return f"it does not speak https: {error.reason or error}"[:_MOST_REASON]
    if isinstance(error, socket.gaierror):
        return error.strerror or str(error)
    # Of several addresses of a name, the text has them all, and how each failed.
    return os.strerror(error.errno) if error.errno else str(error)[:_MOST_REASON]


async def _body(reply: aiohttp.ClientResponse, most: int) -> bytes:
    """Read an answer; raises a ValueError where it is too long."""
    data = bytearray()
    async for chunk in reply.content.iter_any():
        data += chunk
        if len(data) > most:
            reply.close()
            raise ValueError(f"its answer is longer than {most} bytes")
    return bytes(data)
