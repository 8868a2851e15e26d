"""The bytes of an MJPEG stream, the way web_video_server frames it.

Clients written for web_video_server may search for these very headers, and some cannot read
HTTP/1.1's chunked coding, which is why the head says HTTP/1.0 and is written by hand.
"""

from __future__ import annotations

from typing import Tuple

BOUNDARY = "boundarydonotcross"

_NEXT_PART = f"\r\n--{BOUNDARY}\r\n".encode()

CACHE_CONTROL = "no-cache, no-store, must-revalidate, pre-check=0, post-check=0, max-age=0"

CORS_HEADERS = (
    ("Access-Control-Allow-Origin", "*"),
    ("Access-Control-Allow-Methods", "GET,POST,PUT,DELETE,HEAD,OPTIONS"),
    ("Access-Control-Allow-Headers", "Origin, Authorization, Accept, Content-Type"),
    ("Access-Control-Max-Age", "3600"),
)

SERVER_HEADERS = (
    ("Connection", "close"),
    ("Server", "web_video_server"),
    ("Cache-Control", CACHE_CONTROL),
    ("Pragma", "no-cache"),
)


def _block(*headers: Tuple[str, str]) -> bytes:
    return "".join(f"{name}: {value}\r\n" for name, value in headers).encode("ascii") + b"\r\n"


STREAM_HEAD = (
    b"HTTP/1.0 200 OK\r\n"
    + _block(
        *SERVER_HEADERS,
        ("Content-type", f"multipart/x-mixed-replace;boundary={BOUNDARY}"),
        *CORS_HEADERS,
    )
    + f"--{BOUNDARY}\r\n".encode()
)
"""Status line, headers and first boundary of a stream."""


def timestamp(stamp: float) -> str:
    """Return a stamp (s) as the X-Timestamp header has it."""
    return f"{stamp:.6f}"


def part(data: bytes, stamp: float, mime: str) -> bytes:
    """Return one picture as a part of a stream, the following boundary included.

    The boundary that opens the next part goes with this one: a browser shows a picture only when
    it has seen it.

    Parameters
    ----------
    stamp
        Time of the picture (s).
    mime
        Its content type.
    """
    headers = _block(
        ("Content-type", mime),
        ("X-Timestamp", timestamp(stamp)),
        *CORS_HEADERS,
        ("Content-Length", str(len(data))),
    )
    return headers + data + _NEXT_PART
