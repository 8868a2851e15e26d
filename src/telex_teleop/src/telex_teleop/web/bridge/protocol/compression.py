"""Messages of topics as clients ask for them: JSON, or by rosbridge's compressions."""

from __future__ import annotations

import base64
import io
import json
import math
import struct
import zlib
from typing import Any, Callable, Dict, Optional, Tuple, Union

import cbor2
import genpy

from .ros_messages import MessageCodec, split_array

Encoded = Union[str, bytes]
"""A text message, or a binary one, of the WebSocket."""

PLAIN = "none"
COMPRESSIONS = (PLAIN, "png", "cbor", "cbor-raw")
"""What a client may ask for; of several wishes for a topic the last one here holds."""

MAX_PNG = 65536
"""Characters of the longest text that is sent as PNG; packing a longer one would hold up others."""

_TYPED_ARRAYS = {
    "uint16": (69, "H"),
    "uint32": (70, "I"),
    "uint64": (71, "Q"),
    "int8": (72, "b"),
    "byte": (72, "b"),
    "int16": (77, "h"),
    "int32": (78, "i"),
    "int64": (79, "q"),
    "float32": (85, "f"),
    "float64": (86, "d"),
}
"""CBOR's tags of little-endian arrays (RFC 8746), and the format of an element."""


def to_png(text: str) -> str:
    """Return the operation `png` that holds another one: the bytes of its JSON are the pixels."""
    data = text.encode()
    width = max(1, math.isqrt(len(data) // 3))
    height = math.ceil(len(data) / (3 * width))
    data = data.ljust(3 * width * height, b"\n")
    # Each row begins with the number of its filter; 0 is none.
    rows = b"".join(
        b"\0" + data[start : start + 3 * width] for start in range(0, len(data), 3 * width)
    )
    png = b"\x89PNG\r\n\x1a\n" + b"".join(
        (
            _chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)),
            _chunk(b"IDAT", zlib.compress(rows, 1)),  # quickly
            _chunk(b"IEND", b""),
        )
    )
    return json.dumps({"op": "png", "data": base64.b64encode(png).decode()})


def _chunk(kind: bytes, data: bytes) -> bytes:
    body = kind + data
    return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body))


def to_cbor(topic: str, message: genpy.Message) -> bytes:
    """Return the publish operation of a message as CBOR, with arrays of numbers as their bytes."""
    return bytes(cbor2.dumps({"op": "publish", "topic": topic, "msg": _values(message)}))


def to_cbor_raw(topic: str, message: genpy.Message) -> bytes:
    """Return the publish operation of a message as CBOR, the message as ROS would send it."""
    serialized = io.BytesIO()
    message.serialize(serialized)
    stamp = message.header.stamp if message._has_header else genpy.Time()
    body = {"secs": stamp.secs, "nsecs": stamp.nsecs, "bytes": serialized.getvalue()}
    return bytes(cbor2.dumps({"op": "publish", "topic": topic, "msg": body}))


def _values(message: genpy.Message) -> Dict[str, Any]:
    slots = zip(message.__slots__, message._slot_types)
    return {name: _value(kind, getattr(message, name)) for name, kind in slots}


def _value(slot_type: str, value: Any) -> Any:
    element, _, is_array = split_array(slot_type)
    if not is_array:
        return _scalar(value)
    if element in ("uint8", "char"):
        return bytes(value)
    if element in _TYPED_ARRAYS:
        tag, letter = _TYPED_ARRAYS[element]
        return cbor2.CBORTag(tag, struct.pack(f"<{len(value)}{letter}", *value))
    return [_scalar(part) for part in value]


def _scalar(value: Any) -> Any:
    if isinstance(value, genpy.rostime.TVal):
        return {"secs": value.secs, "nsecs": value.nsecs}
    return _values(value) if isinstance(value, genpy.Message) else value


ENCODERS: Dict[str, Callable[[str, genpy.Message], Encoded]] = {
    "cbor": to_cbor,
    "cbor-raw": to_cbor_raw,
}
"""How a message of a topic, as its client spells it, is encoded where that is no JSON."""


class TopicMessage:
    """One message of a topic, encoded when the first client needs it in some way."""

    def __init__(self, codec: MessageCodec, message: genpy.Message) -> None:
        self.message = message
        self._codec = codec
        self._body: Optional[str] = None
        self._encoded: Dict[Tuple[str, str], Encoded] = {}

    def encoded(self, topic: str, compression: str = PLAIN) -> Encoded:
        """Return the publish operation for a client that spells the topic this way."""
        key = (topic, compression)
        encoded = self._encoded.get(key)
        if encoded is None:
            encode = ENCODERS.get(compression)
            encoded = encode(topic, self.message) if encode else self._text(topic, compression)
            self._encoded[key] = encoded
        return encoded

    def _text(self, topic: str, compression: str) -> str:
        if self._body is None:
            self._body = json.dumps(self._codec.to_json(self.message), separators=(",", ":"))
        text = f'{{"op":"publish","topic":{json.dumps(topic)},"msg":{self._body}}}'
        return text if compression == PLAIN or len(text) > MAX_PNG else to_png(text)
