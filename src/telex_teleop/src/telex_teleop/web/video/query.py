"""What a client asks for in the address of a stream or a snapshot."""

from __future__ import annotations

import dataclasses
from typing import Mapping, Optional

from .pictures import Variant

STREAM_TYPES = ("mjpeg", "ros_compressed")


class QueryError(ValueError):
    """The query cannot be used; the text is a sentence for whoever typed it."""

    status = 400


class UnknownStreamTypeError(QueryError):
    """The type of stream is not offered (web_video_server answers this with 404, too)."""

    status = 404


@dataclasses.dataclass(frozen=True)
class PictureQuery:
    """A validated query: the topic as the client spells it, and the variant of its pictures."""

    topic: str
    variant: Variant


def parse(query: Mapping[str, str], max_size: int) -> PictureQuery:
    """Read a query; parameters that web_video_server has for other stream types are ignored.

    Parameters
    ----------
    query
        The decoded query parameters.
    max_size
        Largest width and height (pixels) that a client may ask for.

    Raises
    ------
    QueryError
        The topic is missing, or a value cannot be used.
    """
    topic = query.get("topic", "")
    if not topic:
        raise QueryError("The parameter 'topic' is missing; /streams lists the image topics.")
    stream_type = query.get("type", "mjpeg")
    if stream_type not in STREAM_TYPES:
        raise UnknownStreamTypeError(
            f"There is no stream type {stream_type!r}; known are {' and '.join(STREAM_TYPES)}."
        )
    if stream_type == "ros_compressed":
        return PictureQuery(topic, Variant(unchanged=True))
    variant = Variant(
        width=_size(query, "width", max_size),
        height=_size(query, "height", max_size),
        quality=_quality(query),
        invert="invert" in query,
    )
    return PictureQuery(topic, variant)


def _integer(query: Mapping[str, str], name: str, expected: str) -> Optional[int]:
    text = query.get(name)
    if text is None:
        return None
    # int() alone would also take "1_000", blanks and the digits of every script.
    digits = text[1:] if text.startswith("-") else text
    if not (digits.isascii() and digits.isdigit() and len(digits) <= 9):
        raise QueryError(f"The parameter '{name}' is {text!r}; it must be {expected}.")
    return int(text)


def _size(query: Mapping[str, str], name: str, maximum: int) -> Optional[int]:
    """Read a width or height; -1 and 0 mean the picture's own, as web_video_server has it."""
    expected = f"an integer from 1 to {maximum} (pixels), or -1 for the picture's own size"
    value = _integer(query, name, expected)
    if value is None or value in (-1, 0):
        return None
    if not 1 <= value <= maximum:
        raise QueryError(f"The parameter '{name}' is {value}; it must be {expected}.")
    return value


def _quality(query: Mapping[str, str]) -> Optional[int]:
    expected = "an integer from 1 (smallest) to 100 (best)"
    value = _integer(query, "quality", expected)
    if value is not None and not 1 <= value <= 100:
        raise QueryError(f"The parameter 'quality' is {value}; it must be {expected}.")
    return value
