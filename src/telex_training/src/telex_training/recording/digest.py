"""Hash over the entries of a recording, with all that is recorded of each."""

from __future__ import annotations

import hashlib
import struct
from typing import Any, Dict

from ..judging.entries import Entry


class EntriesDigest:
    """Hash over entries, in their order."""

    def __init__(self) -> None:
        self._hash = hashlib.sha256()
        self._count = 0

    def add(self, entry: Entry, wall_ns: int) -> None:
        """Take the next entry, with the wall time of its arrival (ns)."""
        channel, kind = entry.channel.encode(), entry.kind.encode()
        self._hash.update(
            struct.pack(
                "<QQQIIQ",
                entry.number & 0xFFFFFFFFFFFFFFFF,
                round(entry.time * 1e9),
                wall_ns,
                len(channel),
                len(kind),
                len(entry.data),
            )
        )
        self._hash.update(channel)
        self._hash.update(kind)
        self._hash.update(entry.data)
        self._count += 1

    def state(self) -> Dict[str, Any]:
        """Number of the entries and their hash, as they are signed."""
        return {"count": self._count, "sha256": self._hash.hexdigest()}
