"""Queries in the address of a stream or a snapshot."""

from __future__ import annotations

import dataclasses
from typing import Mapping, Optional

from ..server_config import STREAM_TYPES
from .pictures import JPEG, PNG, Variant

TRANSPORTS = ("raw", "compressed")


class QueryError(ValueError):
    """The query cannot be used; the text is a sentence for whoever typed it."""

    status = 400


class UnknownStreamTypeError(QueryError):
    """The type of stream is not offered (web_video_server answers this with 404, too)."""

    status = 404


@dataclasses.dataclass(frozen=True)
class PictureQuery:
    """A validated query.

    Attributes
    ----------
    topic
        Name of the topic as the client spells it.
    variant
        What is to be done to its pictures.
    raw
        Whether the client wants the uncompressed topic, where there is one.
    """

    topic: str
    variant: Variant
    raw: bool = False


def parse_stream(
    query: Mapping[str, str], max_size: int, default_type: str = "mjpeg"
) -> PictureQuery:
    """Read the query of a stream; parameters of web_video_server's film types are ignored.

    Parameters
    ----------
    max_size
        Largest width and height (pixels) that a client may ask for.
    default_type
        One of `STREAM_TYPES`, for a query without a type.

    Raises
    ------
    QueryError
        The topic is missing, or a value cannot be used.
    """
    stream_type = query.get("type", default_type)
    if stream_type not in STREAM_TYPES:
        raise UnknownStreamTypeError(
            f"There is no stream type {stream_type!r}; known are {', '.join(STREAM_TYPES)}."
        )
    return _parse(query, max_size, stream_type)


def parse_snapshot(query: Mapping[str, str], max_size: int) -> PictureQuery:
    """Read the query of a snapshot: that of a stream, but it is a JPEG unless a PNG is asked for.

    Raises
    ------
    QueryError
        The topic is missing, or a value cannot be used.
    """
    return _parse(query, max_size, "png" if query.get("type") == "png" else "mjpeg")


def _parse(query: Mapping[str, str], max_size: int, stream_type: str) -> PictureQuery:
    topic = query.get("topic", "")
    if not topic:
        raise QueryError("The parameter 'topic' is missing; /streams lists the image topics.")
    transport = query.get("default_transport")
    if transport is not None and transport not in TRANSPORTS:
        raise QueryError(
            f"The parameter 'default_transport' is {transport!r}; it must be "
            f"{' or '.join(TRANSPORTS)}."
        )
    is_png = stream_type == "png"
    unchanged = stream_type == "ros_compressed"
    variant = Variant(
        width=_size(query, "width", max_size),
        height=_size(query, "height", max_size),
        quality=_compression(query) if is_png else _quality(query),
        invert="invert" in query,
        mime=PNG if is_png else JPEG,
        unchanged=unchanged,
    )
    return PictureQuery(topic, variant, transport == "raw" and not unchanged)


def _integer(query: Mapping[str, str], name: str, expected: str) -> Optional[int]:
    text = query.get(name)
    if text is None:
        return None
    # int() alone would also take "1_000", blanks and the digits of every script.
    digits = text[1:] if text.startswith("-") else text
    if not (digits.isascii() and digits.isdigit() and len(digits) <= 9):
        raise QueryError(f"The parameter '{name}' is {text[:40]!r}; it must be {expected}.")
    return int(text)


def _bounded(
    query: Mapping[str, str], name: str, minimum: int, maximum: int, expected: str
) -> Optional[int]:
    value = _integer(query, name, expected)
    if value is not None and not minimum <= value <= maximum:
        raise QueryError(f"The parameter '{name}' is {value}; it must be {expected}.")
    return value


def _size(query: Mapping[str, str], name: str, maximum: int) -> Optional[int]:
    """Read a width or height; -1 and 0 mean the picture's own, as web_video_server has it."""
    expected = f"an integer from 1 to {maximum} (pixels), or -1 for the picture's own size"
    if _integer(query, name, expected) in (-1, 0):
        return None
    return _bounded(query, name, 1, maximum, expected)


def _quality(query: Mapping[str, str]) -> Optional[int]:
    return _bounded(query, "quality", 1, 100, "an integer from 1 (smallest) to 100 (best)")


def _compression(query: Mapping[str, str]) -> Optional[int]:
    expected = "an integer from 0 (fast) to 9 (small), the compression level of PNG"
    return _bounded(query, "quality", 0, 9, expected)
