"""Takes a person's name out of a recording.

The name stands in the file's name, in the attachments ``trial.json`` and ``sheet.json``, in the
training's own inputs, and among the bridge's clients and what instructors have done. The sheet's
hash is over all messages, so the file gets another one, and with it a sheet that fits; a valid
signature is made anew. The old hash is not kept: whoever had it could try names until one of them
makes it again.
"""

from __future__ import annotations

import contextlib
import json
import re
from dataclasses import dataclass
from html import escape
from io import BytesIO
from pathlib import Path
from typing import Any, Dict, List, Optional

from mcap.records import Attachment as AttachmentRecord
from mcap.stream_reader import StreamReader

from ..judging.actions import interference
from ..judging.entries import (
    ACTIONS,
    CLIENTS,
    INPUTS,
    NAMES,
    TRUTH,
    BadEntryError,
    Entry,
    decode,
    json_of,
)
from ..judging.sheet import sheet_text
from .amending import alone
from .reader import Recording, is_being_written, read_recording
from .signature import SIGNATURE, sealing_again
from .trial_file import (
    NAMELESS,
    SHEET,
    SUFFIX,
    TRIAL,
    judged,
    safe_name,
    serialised_input,
    sheet_attachment,
)
from .writer import Attachment, RecordingError, RecordingWriter, Seal

MARK = "pseudonymised.json"
"""Attachment of a recording out of which a name was taken."""
_PEOPLE, _TEXTS = ("operator", "by"), ("text", "reason")
_REASONS = ("invalid_because", "name")
"""Where a sheet says why a trial is invalid: in its list, and as what an event is called."""
_DRAFTS = ("amended", "repaired", "imported", "pseudonymised")
_STAMP = 17
"""Letters of the date at the beginning of a trial's name."""


@dataclass(frozen=True)
class Renamed:
    """What became of a recording.

    Attributes
    ----------
    path : Path
        Where it stands now.
    own : bool
        Whether it was the person's own trial.
    left : list of str
        Channels and attachments in which the name can still be read.
    """

    path: Path
    own: bool
    left: List[str]


def operator_of(path: Path) -> Optional[str]:
    """Return the operator that a recording names at its beginning; None: it names none.

    Reads no further than that, of files that were cut off, too.
    """
    try:
        with path.open("rb") as file:
            for record in StreamReader(file, emit_chunks=True).records:
                if isinstance(record, AttachmentRecord) and record.name == TRIAL:
                    name = json.loads(record.data)["operator"]
                    return name if isinstance(name, str) else None
    except Exception:  # damaged bytes raise whatever they lead the reader to
        return None
    return None


def rename_person(path: Path, name: str, pseudonym: str) -> Optional[Renamed]:
    """Put a pseudonym in a person's place, in a recording of whomever.

    The file is replaced as a whole. Verdict and figures stay what they were.

    Parameters
    ----------
    name : str
        As it stands in the recording, not empty.
    pseudonym : str
        Letters, digits, _ and -.

    Returns
    -------
    Renamed or None
        None where the recording does not name the person.

    Raises
    ------
    RecordingError
        It cannot be read or written, or is that of a trial that runs.
    """
    try:
        with alone(path.parent):
            if is_being_written(path):
                raise RecordingError(f"{path}: this trial runs; it has to be ended first")
            return _rename(read_recording(path), name, pseudonym)
    except (ValueError, KeyError, TypeError) as error:  # of an attachment
        raise RecordingError(f"{path}: an attachment is wrong: {error}") from error


def _rename(recording: Recording, name: str, pseudonym: str) -> Optional[Renamed]:
    path = recording.path
    renamer = _Renamer(name, pseudonym)
    entries = [renamer.entry(entry) for entry in recording.entries]
    attachments, trial = dict(recording.attachments), path.stem
    own = operator_of(path) == name
    if own:
        trial = _new_name(path.stem, name, pseudonym)
        attachments[TRIAL] = _trial(attachments[TRIAL], pseudonym, trial)
        entries = [_reopened(entry, trial) for entry in entries]
    if not own and entries == recording.entries:
        return None
    attachments[MARK] = Attachment("application/json", b'{"format": 1}\n')
    attachments.pop(SIGNATURE, None)
    changed = Recording(path, entries, recording.walls, attachments, True)
    ending: Dict[str, Attachment] = {}
    old = attachments.pop(SHEET, None)
    if old is not None:
        made = _made_again(recording, old, changed)
        if made is None:
            made = renamer.content(json.loads(old.data))
            made["trial"] = trial if own else made["trial"]
            made["log"]["sha256"] = _hash(changed)
        ending[SHEET] = sheet_attachment(sheet_text(made))
    target = path.with_name(f"{trial}{SUFFIX}")
    _write(path, target, changed, ending, sealing_again(recording))
    return Renamed(target, own, _left(changed, ending, name))


def _made_again(
    recording: Recording, sheet: Attachment, changed: Recording
) -> Optional[Dict[str, Any]]:
    """Make the sheet of a changed recording in which instructors have done something.

    The judge says in words what they did: a name may be one of these words.

    Returns
    -------
    dict or None
        None where nobody did anything, or this version makes another sheet of the old recording.
    """
    if not any(_is_of(ACTIONS, entry) for entry in recording.entries):
        return None
    try:
        if sheet_text(judged(recording).sheet()).encode() == sheet.data:
            return judged(changed).sheet()
    except RecordingError:
        pass
    return None


def _hash(recording: Recording) -> str:
    """Hash of a recording's log; empty where this version cannot judge its exercise any more."""
    try:
        return str(judged(recording).sheet()["log"]["sha256"])
    except RecordingError:
        return ""


class _Renamer:
    """Puts a pseudonym in the place of a name."""

    def __init__(self, name: str, pseudonym: str) -> None:
        self._name, self._pseudonym = name, pseudonym
        self._word = re.compile(rf"(?<!\w){re.escape(name)}(?!\w)")

    def entry(self, entry: Entry) -> Entry:
        """Rename in an entry; what does not name the person stays the same object."""
        try:
            if entry.channel == INPUTS:
                content = json_of(entry)
                changed = self.content(content)
                if changed != content:
                    return entry._replace(data=serialised_input(changed))
            elif _is_of(CLIENTS, entry):
                return self._clients(entry)
            elif _is_of(ACTIONS, entry):
                return self._action(entry)
        except BadEntryError:
            pass
        return entry

    def _clients(self, entry: Entry) -> Entry:
        message = decode(entry, "telex_msgs/BridgeClients")
        named = [client for client in message.clients if client.name.strip() == self._name]
        if not named:
            return entry
        for client in named:
            client.name, client.address = self._pseudonym, ""
        return _with(entry, message)

    def _action(self, entry: Entry) -> Entry:
        message = decode(entry, "telex_msgs/InstructorAction")
        before = message.by, message.request
        if message.by.strip() == self._name:
            message.by = self._pseudonym
        try:
            fields = json.loads(message.request)
        except (ValueError, RecursionError):
            fields = None
        changed = self._words(fields)
        if changed != fields:
            message.request = json.dumps(changed, sort_keys=True)
        return entry if (message.by, message.request) == before else _with(entry, message)

    def _words(self, value: Any) -> Any:
        if isinstance(value, dict):
            return {name: self._words(item) for name, item in value.items()}
        if isinstance(value, list):
            return [self._words(item) for item in value]
        return self._word.sub(self._pseudonym, value) if isinstance(value, str) else value

    def content(self, content: Any) -> Any:
        """Rename in plain data: people as a whole, and words of what people have written."""
        return self._walk(content, "")

    def _walk(self, value: Any, key: str) -> Any:
        if isinstance(value, dict):
            made = {name: self._walk(item, name) for name, item in value.items()}
            # An event of a pause is called by who did it.
            if made.get("event") == "pause" and made.get("name") == self._name:
                made["name"] = self._pseudonym
            return made
        if isinstance(value, list):
            return [self._walk(item, key) for item in value]
        if isinstance(value, str) and key in _PEOPLE and value.strip() == self._name:
            return self._pseudonym
        if key in _REASONS and value == interference(self._name):
            return interference(self._pseudonym)
        if isinstance(value, str) and key in _TEXTS:
            return self._word.sub(self._pseudonym, value)
        return value


def _is_of(channel: str, entry: Entry) -> bool:
    """Whether an entry is of a channel of the first or of a further robot."""
    return entry.channel == channel or entry.channel.endswith(f"/{channel}")


def _with(entry: Entry, message: Any) -> Entry:
    file = BytesIO()
    message.serialize(file)
    return entry._replace(data=file.getvalue())


def _new_name(stem: str, name: str, pseudonym: str) -> str:
    """Name of the trial, with the pseudonym in it."""
    stamp = stem[:_STAMP]
    old = f"{stamp}_{safe_name(name)}_"
    return f"{stamp}_{pseudonym}_{stem[len(old) :] if stem.startswith(old) else 'trial'}"


def _trial(attachment: Attachment, pseudonym: str, trial: str) -> Attachment:
    content = json.loads(attachment.data)
    # A path may have the name of the station's user in it.
    file = Path(str(content["exercise"])).name
    content.update(operator=pseudonym, trial=trial, exercise=file)
    text = json.dumps(content, sort_keys=True, indent=1) + "\n"
    return Attachment(attachment.media_type, text.encode())


def _reopened(entry: Entry, trial: str) -> Entry:
    """Give the trial's new name to the input that opened it."""
    if entry.channel != INPUTS:
        return entry
    try:
        content = json_of(entry)
    except BadEntryError:
        return entry
    if content.get("input") != "open":
        return entry
    return entry._replace(data=serialised_input({**content, "trial": trial}))


def _write(
    path: Path,
    target: Path,
    made: Recording,
    ending: Dict[str, Attachment],
    seal: Optional[Seal],
) -> None:
    if target != path and target.exists():
        raise RecordingError(f"{target}: it exists already; {path.name} is left as it was")
    draft = path.with_name(f".{path.name}.pseudonymised")
    with contextlib.suppress(FileNotFoundError):
        draft.unlink()
    writer = RecordingWriter(draft, made.attachments)
    for entry, wall in zip(made.entries, made.walls):
        writer.put(entry, wall)
    writer.close(ending, seal)
    try:
        draft.replace(target)
        if target != path:
            path.unlink()
    except OSError as error:
        raise RecordingError(f"{path}: {error.strerror}") from error


def _left(made: Recording, ending: Dict[str, Attachment], name: str) -> List[str]:
    """Where the name can still be read: it may stand in what other topics or a scene say."""
    words = b"|".join(re.escape(each.encode()) for each in spellings(name))
    word = re.compile(rb"(?<![A-Za-z0-9_])(?:" + words + rb")(?![A-Za-z0-9_])")
    found = [
        each
        for each, attachment in {**made.attachments, **ending}.items()
        if word.search(attachment.data)
    ]
    # The truth is figures, and names of things; in figures any letters may stand by chance.
    channels = {
        entry.channel
        for entry in made.entries
        if entry.channel not in (TRUTH, NAMES) and word.search(entry.data)
    }
    return [*found, *sorted(channels)]


def spellings(name: str) -> List[str]:
    """How a name may stand in files: as it is, in JSON, HTML, CSV, and in a trial's name."""
    spelt = {name, json.dumps(name)[1:-1], escape(name), name.replace('"', '""')}
    if safe_name(name) != NAMELESS:  # which other names are spelt as, too
        spelt.add(safe_name(name))
    return sorted(spelt)


def traces(folder: Path, trial: str) -> List[Path]:
    """Files beside a recording that were made of it: exports, and drafts that were left."""
    exports = [folder / f"{trial}{suffix}" for suffix in (".bag", ".csv")]
    drafts = [folder / f".{trial}{SUFFIX}.{each}" for each in _DRAFTS]
    return [path for path in (*exports, *drafts) if path.exists()]
