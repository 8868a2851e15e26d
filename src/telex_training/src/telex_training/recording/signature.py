"""The signature of an exam: that its recording is what the station has closed it as.

It stands in an attachment of its own, over all other attachments, the sheet with the log's hash
among them, and over number, times, channel, type and bytes of each entry.
"""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass
from typing import Any, Dict, Mapping, Optional

from ..plain_data import require_text
from .digest import EntriesDigest
from .reader import Recording
from .station_keys import StationKey, StationKeyError, is_signed, known_keys, station_key
from .writer import Attachment, Seal

SIGNATURE = "signature.json"
FORMAT = 1
VALID, NONE, CHANGED, OTHER = "valid", "no signature", "changed", "another key"
"""What a signature is found to be: of a known key, over just this content; not there; of other
content; of this content, but by a key that is not known."""
_MOST_BYTES = 2**20


@dataclass(frozen=True)
class Signature:
    """What the signature of a recording is found to be.

    Attributes
    ----------
    state : str
        See `VALID`.
    key : str
        Public key whose signature is over just this content; empty: there is none.
    station : str
        Whose key it is, where that is known.
    reason : str
        What has changed.
    """

    state: str
    key: str = ""
    station: str = ""
    reason: str = ""

    def __str__(self) -> str:
        if self.state == VALID:
            return f"valid, signed by {self.station}"
        if self.state == OTHER:
            return f"another key: signed with {self.key}, which is not known here"
        return f"{self.state}: {self.reason}" if self.reason else self.state


def sealing(key: StationKey) -> Seal:
    """Return what signs a recording as it is closed."""

    def seal(
        entries: Mapping[str, Any], attached: Mapping[str, Attachment]
    ) -> Dict[str, Attachment]:
        signed = {"format": FORMAT, "entries": dict(entries), "attachments": _hashes(attached)}
        signature = key.sign(_canonical(signed)).hex()
        content = {"signed": signed, "key": key.public, "signature": signature}
        text = json.dumps(content, sort_keys=True, indent=1) + "\n"
        return {SIGNATURE: Attachment("application/json", text.encode())}

    return seal


def sealing_again(recording: Recording) -> Optional[Seal]:
    """Return what signs a recording again after an addition to what it was.

    None where it has no valid signature.
    """
    if verified(recording, known_keys()).state != VALID:
        return None
    try:
        return sealing(station_key())
    except StationKeyError:
        return None  # it is no exam any more, which is better than one that nobody vouches for


def verified(recording: Recording, keys: Mapping[str, str]) -> Signature:
    """Check the signature of a recording.

    Parameters
    ----------
    keys : mapping of str to str
        Names of stations by the public keys that count.
    """
    found = recording.attachments.get(SIGNATURE)
    if found is None:
        return Signature(NONE, reason="" if recording.whole else "the recording is cut off")
    try:
        content: Any = json.loads(found.data[:_MOST_BYTES])
        require_text(content)
        signed, key = content["signed"], str(content["key"])
        signature = bytes.fromhex(content["signature"])
        entries, hashes = signed["entries"], signed["attachments"]
        known = signed["format"] == FORMAT and isinstance(hashes, dict)
    except (ValueError, TypeError, KeyError, RecursionError):
        return Signature(CHANGED, reason=f"its {SIGNATURE} is no signature")
    if not known or not is_signed(_canonical(signed), signature, key):
        return Signature(CHANGED, reason=f"its {SIGNATURE} is not signed by its key")
    reason = _difference(recording, entries, hashes)
    if reason:
        return Signature(CHANGED, reason=reason)
    if key not in keys:
        return Signature(OTHER, key)
    return Signature(VALID, key, keys[key])


def _difference(recording: Recording, entries: Any, hashes: Mapping[str, Any]) -> str:
    """Say what of a recording is not what was signed; empty: nothing."""
    if recording.repeated:
        return f"'{recording.repeated[0]}' is there twice"
    attached = _hashes(recording.attachments)
    for name in sorted({*attached, *hashes} - {SIGNATURE}):
        if name not in attached:
            return f"'{name}' is missing"
        if attached[name] != hashes.get(name):
            return f"'{name}' is another" if name in hashes else f"'{name}' has been added"
    digest = EntriesDigest()
    for entry, wall in zip(recording.entries, recording.walls):
        digest.add(entry, wall)
    return "" if digest.state() == entries else "its entries are others"


def _hashes(attached: Mapping[str, Attachment]) -> Dict[str, str]:
    return {
        name: hashlib.sha256(each.media_type.encode() + b"\0" + each.data).hexdigest()
        for name, each in attached.items()
        if name != SIGNATURE
    }


def _canonical(signed: Any) -> bytes:
    return json.dumps(signed, sort_keys=True, separators=(",", ":")).encode()
