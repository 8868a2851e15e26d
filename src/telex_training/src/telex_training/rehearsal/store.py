"""Folder of a campaign: an outcome a file, from which an interrupted campaign goes on."""

from __future__ import annotations

import json
import os
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Dict, Iterator, Optional, Tuple

from telex_control.common.params import ConfigError, read_struct

from .jobs import Rehearsed

ABOUT, SUMMARY = "campaign.json", "summary.json"
FORMAT = 1
_SUFFIX = ".json"


class StoreError(ValueError):
    """A campaign's folder cannot be used; the message names it and says what would be right."""


@dataclass(frozen=True)
class About:
    """Of what a campaign is; outcomes of different ones are never mixed.

    Attributes
    ----------
    exercise, sha256 : str
        Name of the exercise, and digest of its file and of what that names, see
        `jobs.exercise_digest`.
    software : str
        Digest of the sources and the operator's module, see `jobs.software_digest`.
    """

    exercise: str
    sha256: str
    operator: str
    software: str


class Store:
    """Outcomes of one campaign in a folder."""

    def __init__(self, folder: Path, about: About) -> None:
        self.folder, self.about = folder, about

    @classmethod
    def begin(cls, folder: Path, about: About) -> Store:
        """Make the folder, or go on in it.

        Raises
        ------
        StoreError
            It is of another exercise, operator or software, has something else in it, or cannot
            be written.
        """
        try:
            folder.mkdir(parents=True, exist_ok=True)
            if (folder / ABOUT).exists():
                _same(folder, cls.open(folder).about, about)
            elif any(folder.iterdir()):
                raise StoreError(f"{folder}: it is neither empty nor of a campaign; name another")
            else:
                text = json.dumps({"format": FORMAT, **asdict(about)}, indent=1, sort_keys=True)
                _write(folder / ABOUT, text + "\n")
        except OSError as error:
            raise StoreError(f"{folder}: {error.strerror}") from error
        return cls(folder, about)

    @classmethod
    def open(cls, folder: Path) -> Store:
        """Open a campaign to read it.

        Raises
        ------
        StoreError
        """
        content = _read(folder / ABOUT)
        if content.pop("format", None) != FORMAT:
            raise StoreError(f"{folder / ABOUT}: no campaign of format {FORMAT}")
        try:
            return cls(folder, read_struct(About, content))
        except ConfigError as error:
            raise StoreError(f"{folder / ABOUT}: {error}") from error

    def get(self, setting: str, line: str, seed: int) -> Optional[Rehearsed]:
        """Return an outcome; None: it is not there yet."""
        path = self._path(setting, line, seed)
        return _outcome(path) if path.exists() else None

    def put(self, setting: str, line: str, seed: int, outcome: Rehearsed) -> None:
        """Keep an outcome; a reader finds all of it or nothing.

        Raises
        ------
        StoreError
        """
        path = self._path(setting, line, seed)
        content = {"gave_up": outcome.gave_up, "sheet": json.loads(outcome.sheet)}
        text = json.dumps(content, indent=1, sort_keys=True, ensure_ascii=False, allow_nan=False)
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            _write(path, text + "\n")
        except OSError as error:
            raise StoreError(f"{path}: {error.strerror}") from error

    def summarise(self, text: str) -> None:
        """Keep the summary.

        Raises
        ------
        StoreError
        """
        try:
            _write(self.folder / SUMMARY, text)
        except OSError as error:
            raise StoreError(f"{self.folder / SUMMARY}: {error.strerror}") from error

    def all(self) -> Iterator[Tuple[str, str, int, Rehearsed]]:
        """Yield setting, line, seed and outcome of all that there is, in order.

        Raises
        ------
        StoreError
        """
        for path in sorted(self.folder.glob(f"*/*/*{_SUFFIX}"), key=_order):
            if path.stem.isdecimal():
                yield path.parent.parent.name, path.parent.name, int(path.stem), _outcome(path)

    def _path(self, setting: str, line: str, seed: int) -> Path:
        return self.folder / setting / line / f"{seed}{_SUFFIX}"


def _order(path: Path) -> Tuple[str, str, int, str]:
    seed = int(path.stem) if path.stem.isdecimal() else -1
    return path.parent.parent.name, path.parent.name, seed, path.stem


def _same(folder: Path, there: About, wanted: About) -> None:
    for key, value in asdict(wanted).items():
        found = asdict(there)[key]
        if found != value:
            shown = (found[:12], value[:12]) if key in ("sha256", "software") else (found, value)
            raise StoreError(
                f"{folder}: it is of another {key} ({shown[0]}, not {shown[1]}); "
                "name another folder, and --compare both"
            )


def _outcome(path: Path) -> Rehearsed:
    content = _read(path)
    sheet, gave_up = content.get("sheet"), content.get("gave_up")
    if not isinstance(sheet, dict) or not isinstance(gave_up, str):
        raise StoreError(f"{path}: no outcome of a rehearsal; delete it to have it made again")
    return Rehearsed(json.dumps(sheet), gave_up)


def _read(path: Path) -> Dict[str, Any]:
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise StoreError(f"{path}: {error.strerror}") from error
    except (ValueError, RecursionError) as error:
        raise StoreError(f"{path}: {error}") from error
    if not isinstance(content, dict):
        raise StoreError(f"{path}: a mapping is needed")
    return content


def _write(path: Path, text: str) -> None:
    draft = path.with_name(f".{path.name}.{os.getpid()}")
    draft.write_text(text, encoding="utf-8")
    draft.replace(path)
