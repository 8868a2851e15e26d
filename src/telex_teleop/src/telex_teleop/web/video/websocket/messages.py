"""The messages of `/video`, all cameras over one WebSocket; see docs/engineer/video.md."""

from __future__ import annotations

import dataclasses
import json
import math
import struct
from typing import Any, Callable, Dict, List, Mapping, Optional, Tuple, Union

VERSION = 1

MAX_RATE = 1000.0
"""Highest rate (1/s) that a client may ask for."""

MAX_CREDITS = 8
"""Most pictures of one camera that may be under way to a client."""

_HEADER = struct.Struct("<BBHId")
_SHOWN = 40
_VIEW_KEYS = ("camera", "rate", "width", "height", "quality", "credits")


class ProtocolError(ValueError):
    """A client's message cannot be used; the text is a sentence for whoever wrote the client."""


@dataclasses.dataclass(frozen=True)
class WantedView:
    """What a client wants of one camera.

    Attributes
    ----------
    rate
        Most pictures per second; None: every one.
    width, height
        Most that is wanted (pixels): larger pictures are scaled down, keeping their aspect.
    quality
        JPEG quality (1 to 100); None: as published.
    credits
        Pictures that may be under way without having been acknowledged.
    """

    camera: str
    rate: Optional[float] = None
    width: Optional[int] = None
    height: Optional[int] = None
    quality: Optional[int] = None
    credits: int = 1

    def suits_preview(self, rate: float) -> bool:
        """Tell whether a camera's preview may be enough, if it comes at a rate (1/s)."""
        asks_size = self.width is not None or self.height is not None
        return asks_size and self.quality is None and self.rate is not None and self.rate <= rate

    def is_filled_by(self, size: Tuple[int, int]) -> bool:
        """Tell whether a picture (width, height, in pixels) is as large as the view wants it."""
        limits = (self.width, self.height)
        return limits == (None, None) or any(
            limit is not None and own >= limit for own, limit in zip(size, limits)
        )


@dataclasses.dataclass(frozen=True)
class Show:
    """Send these views from now on, and no others."""

    views: Tuple[WantedView, ...]


@dataclasses.dataclass(frozen=True)
class Ack:
    """Pictures (camera's index, number) have been used, and all that were sent before them."""

    pictures: Tuple[Tuple[int, int], ...]


@dataclasses.dataclass(frozen=True)
class Ping:
    """Answer at once with this number (any finite one), for the client to compare clocks."""

    token: float


Message = Union[Show, Ack, Ping]


def picture_header(camera: int, number: int, captured: float) -> bytes:
    """Return the 16 bytes that go before the encoded picture in a message.

    Parameters
    ----------
    camera
        Index of the camera, 0 to 255.
    number
        Of the picture, among all that this client gets, 0 to 2^32 - 1.
    captured
        Wall time (s since 1970, server's clock) of what the picture shows.
    """
    return _HEADER.pack(VERSION, camera, 0, number, captured)


def parse(text: str, max_size: int) -> Message:
    """Read a client's message.

    Parameters
    ----------
    text
        One JSON object with one key: show, ack or ping.
    max_size
        Largest width and height (pixels) that a client may ask for.

    Raises
    ------
    ProtocolError
        It is something else.
    """
    try:
        message = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise ProtocolError(f"the message is no JSON: {str(error)[:80]}") from None
    if not isinstance(message, dict) or len(message) != 1:
        raise ProtocolError(
            f"the message is {_shown(message)}; it must be an object with one key: show, ack or "
            "ping"
        )
    ((kind, content),) = message.items()
    if kind == "show":
        return _parse_show(content, max_size)
    if kind == "ack":
        return _parse_ack(content)
    if kind == "ping":
        return Ping(_number(content, "ping", -math.inf, math.inf, "any finite number"))
    raise ProtocolError(f"there is no message {_shown(kind)}; known are show, ack, ping")


def _parse_show(content: Any, max_size: int) -> Show:
    if not isinstance(content, list):
        raise ProtocolError(f"show is {_shown(content)}; it must be a list of views")
    views: List[WantedView] = []
    for index, item in enumerate(content):
        view = _parse_view(item, f"show[{index}]", max_size)
        if any(other.camera == view.camera for other in views):
            raise ProtocolError(f"show has the camera {_shown(view.camera)} twice")
        views.append(view)
    return Show(tuple(views))


def _parse_view(item: Any, where: str, max_size: int) -> WantedView:
    if not isinstance(item, dict) or not isinstance(item.get("camera"), str):
        raise ProtocolError(
            f"{where} is {_shown(item)}; it must be an object with the name of a camera, such as "
            '{"camera": "front"}'
        )
    for key in item:
        if key not in _VIEW_KEYS:
            raise ProtocolError(f"{where} has {_shown(key)}; known are {', '.join(_VIEW_KEYS)}")
    values: Dict[str, Any] = {"camera": item["camera"]}
    readers: Mapping[str, Tuple[Callable[..., float], float, float, str]] = {
        "rate": (_number, 0.01, MAX_RATE, f"pictures per second, 0.01 to {MAX_RATE:g}"),
        "width": (_integer, 1, max_size, f"an integer from 1 to {max_size} (pixels)"),
        "height": (_integer, 1, max_size, f"an integer from 1 to {max_size} (pixels)"),
        "quality": (_integer, 1, 100, "an integer from 1 (smallest) to 100 (best)"),
        "credits": (_integer, 1, MAX_CREDITS, f"an integer from 1 to {MAX_CREDITS}"),
    }
    for key, (read, lowest, highest, expected) in readers.items():
        if item.get(key) is not None:
            values[key] = read(item[key], f"{where}.{key}", lowest, highest, expected)
    return WantedView(**values)


def _parse_ack(content: Any) -> Ack:
    if isinstance(content, list) and content and isinstance(content[0], list):
        return Ack(tuple(_parse_pair(pair, f"ack[{n}]") for n, pair in enumerate(content)))
    return Ack((_parse_pair(content, "ack"),))


def _parse_pair(content: Any, where: str) -> Tuple[int, int]:
    if not isinstance(content, list) or len(content) != 2:
        raise ProtocolError(
            f"{where} is {_shown(content)}; it must be a list of a camera's index and the number "
            "of its picture, both out of the picture's header, or ack a list of such lists"
        )
    camera = _integer(content[0], f"{where}[0]", 0, 255, "a camera's index")
    number = _integer(content[1], f"{where}[1]", 0, 0xFFFFFFFF, "the number of a picture")
    return int(camera), int(number)


def _number(value: Any, name: str, lowest: float, highest: float, expected: str) -> float:
    usable = isinstance(value, (int, float)) and not isinstance(value, bool)
    # An integer may be too large for a float.
    if not usable or not abs(value) < 1e300 or not lowest <= value <= highest:
        raise ProtocolError(f"{name} is {_shown(value)}; it must be {expected}")
    return float(value)


def _integer(value: Any, name: str, lowest: float, highest: float, expected: str) -> int:
    usable = isinstance(value, int) and not isinstance(value, bool)
    if not usable or not lowest <= value <= highest:
        raise ProtocolError(f"{name} is {_shown(value)}; it must be {expected}")
    return int(value)


def _shown(value: Any) -> str:
    """Show a client's value in a message, shortened."""
    try:
        text = json.dumps(value)
    except (ValueError, RecursionError):  # an integer with thousands of digits; a deep nest
        return "something unreadable"
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]}..."
