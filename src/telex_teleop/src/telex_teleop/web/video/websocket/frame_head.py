"""The head of a WebSocket frame, RFC 6455 section 5.2."""

from __future__ import annotations

import struct

_WHOLE_BINARY = 0x82
"""First byte: the last fragment of a message, binary."""

_UP_TO_16_BITS = 126
_UP_TO_64_BITS = 127
"""What stands in the second byte for a length that follows it in two, or in eight bytes."""


def binary_frame_head(length: int) -> bytes:
    """Return what goes before a server's binary message of so many bytes, sent as one frame."""
    if length < _UP_TO_16_BITS:
        return struct.pack("!BB", _WHOLE_BINARY, length)
    if length < 2**16:
        return struct.pack("!BBH", _WHOLE_BINARY, _UP_TO_16_BITS, length)
    return struct.pack("!BBQ", _WHOLE_BINARY, _UP_TO_64_BITS, length)
