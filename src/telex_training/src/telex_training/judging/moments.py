"""Notes at moments of a trial that has ended: what somebody who watched it again had to say."""

from __future__ import annotations

import contextlib
from typing import Any, Dict, Iterable, List, NamedTuple

from .entries import INPUTS, BadEntryError, Entry, json_of, number_field, text_field

INPUT = "moment"
"""Name of the training's own input with such a note."""
MOST_TEXT, MOST_NAME, MOST_NOTES = 500, 100, 200
"""Letters of a note and of its author's name, and notes of a trial."""


class MomentNote(NamedTuple):
    """A note at a moment.

    Attributes
    ----------
    at : float
        Time since the recording's first sample (s).
    by : str
        Name that whoever wrote it gave himself; empty: none.
    instructor : bool
        Whether an instructor wrote it.
    """

    at: float
    text: str
    by: str
    instructor: bool

    def content(self) -> Dict[str, Any]:
        """Return it as one of the training's own inputs."""
        return {"input": INPUT, **self._asdict()}


def moment_note(content: Dict[str, Any]) -> MomentNote:
    """Read a note from a struct with its fields.

    Raises
    ------
    BadEntryError
    """
    at, text = number_field(content, "at"), text_field(content, "text").strip()
    by, instructor = text_field(content, "by").strip(), content.get("instructor", False)
    if at < 0.0:
        raise BadEntryError(f"at is {at:g}; 0 s or later is needed")
    for key, value, most in (("text", text, MOST_TEXT), ("by", by, MOST_NAME)):
        if len(value) > most:
            raise BadEntryError(f"{key} has {len(value)} letters; at most {most} are possible")
    if not text or not text.isprintable():
        raise BadEntryError(f"text is {text[:40]!r}; one line of text is needed")
    if not by.isprintable():
        raise BadEntryError(f"by is {by[:40]!r}; a name is needed")
    if not isinstance(instructor, bool):
        raise BadEntryError(f"instructor is {str(instructor)[:40]!r}; true or false is needed")
    return MomentNote(at, text, by, instructor)


def moment_notes(entries: Iterable[Entry]) -> List[MomentNote]:
    """Return the notes among a recording's entries, in the order of writing.

    Whatever makes no sense is left out, and so is what is beyond `MOST_NOTES`.
    """
    found: List[MomentNote] = []
    for entry in entries:
        if entry.channel == INPUTS and len(found) < MOST_NOTES:
            with contextlib.suppress(BadEntryError):
                content = json_of(entry)
                if content.get("input") == INPUT:
                    found.append(moment_note(content))
    return found
