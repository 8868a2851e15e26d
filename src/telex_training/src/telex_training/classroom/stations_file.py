"""The file of a class's stations: YAML in, checked `ClassStation`s with their tokens out.

docs/instructor/class.md describes the keys.
"""

from __future__ import annotations

import os
import unicodedata
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Mapping, Tuple
from urllib.parse import urlsplit

from telex_control.common.params import ConfigError, require
from telex_control.common.text_file import read_text_file
from telex_sim.scene.files.yaml_text import read_yaml
from telex_teleop.web.token_files import read_token
from telex_teleop.web.tokens import is_loopback

from ..exercises.yaml_parts import structs_of

MOST_BYTES = 100_000
"""A longer file is refused before it is read."""
_MOST_LETTERS = 40
_LETTER, _MARK, _DIGIT = "L", "M", "N"
"""Categories of characters; in some scripts vowels and accents are marks behind a letter."""


class StationsError(ValueError):
    """The file cannot be used; the message names file, key, value and what would be right."""


@dataclass(frozen=True)
class ClassStation:
    """A station of the class.

    Attributes
    ----------
    name : str
        By which the page calls it.
    address : str
        Of its video server.
    token_file : str
        Of the token of its instructors; empty: it asks for none, which only this machine's may.
    token : str
        What the file holds.
    """

    name: str
    address: str
    token_file: str = ""
    token: str = field(default="", repr=False)

    def __post_init__(self) -> None:
        require(
            _is_name(self.name),
            f"name is {self.name[:60]!r}; 1 to {_MOST_LETTERS} letters, digits, spaces and _ . - "
            "are possible, with a letter or digit first and no space at the end",
        )
        require(
            _is_address(self.address),
            f"address is {self.address[:80]!r}; http://HOST:PORT is needed, and nothing after it",
        )


def _is_name(text: str) -> bool:
    kinds = [unicodedata.category(each)[0] for each in text]
    return (
        0 < len(text) <= _MOST_LETTERS
        and kinds[0] in (_LETTER, _DIGIT)
        and not text.endswith(" ")
        and all(
            kind in (_LETTER, _MARK, _DIGIT) or each in " _.-" for each, kind in zip(text, kinds)
        )
    )


def _is_address(text: str) -> bool:
    try:
        parts = urlsplit(text)
        port = parts.port
    except ValueError:
        return False
    bare = text == f"{parts.scheme}://{parts.netloc}" and "@" not in parts.netloc
    return bare and parts.scheme in ("http", "https") and bool(parts.hostname) and bool(port)


@dataclass(frozen=True)
class _Given:
    """A station as the file has it: the token itself never stands there."""

    name: str
    address: str
    token_file: str = ""


def load_stations(path: Path) -> Tuple[ClassStation, ...]:
    """Read a file of stations, and the files of their tokens.

    Parameters
    ----------
    path : Path
        Paths in it that are not absolute begin at its folder.

    Raises
    ------
    StationsError
        ``FILE: where: what``.
    """
    text = read_text_file(path, MOST_BYTES, StationsError)
    try:
        content = read_yaml(text, MOST_BYTES)
        require(isinstance(content, Mapping), "a struct with the key 'stations' is needed")
        return _stations(content, path.resolve().parent)
    except ConfigError as error:
        raise StationsError(f"{path}: {error}") from error


def _stations(content: Mapping[str, Any], folder: Path) -> Tuple[ClassStation, ...]:
    for key in content:
        require(key == "stations", f"{key} is unknown; known is stations")
    given = structs_of(content, "stations", _Given)
    require(bool(given), "stations is []; one station at least is needed")
    made = []
    for i, each in enumerate(given):
        try:
            made.append(_with_token(ClassStation(each.name, each.address, each.token_file), folder))
        except ConfigError as error:
            raise ConfigError(f"stations[{i}]: {error}") from None
    for key in ("name", "address"):
        values = [getattr(each, key) for each in made]
        for i, value in enumerate(values):
            first = values.index(value)
            require(first == i, f"stations[{i}]/{key} is {value!r}; stations[{first}] has it, too")
    return tuple(made)


def _with_token(station: ClassStation, folder: Path) -> ClassStation:
    if not station.token_file:
        host = urlsplit(station.address).hostname or ""
        require(
            is_loopback(host),
            f"token_file is missing; {host} is another machine, which asks instructors for a "
            "token: a copy of its file of instructors' tokens is needed here (mode 0600)",
        )
        return station
    path = os.path.join(folder, os.path.expanduser(station.token_file))
    return with_token_of_file(replace(station, token_file=path))


def with_token_of_file(station: ClassStation) -> ClassStation:
    """Return a station with what its file of a token holds now.

    Raises
    ------
    ConfigError
        The file is not there, others may read it, or it holds no token.
    """
    path = station.token_file
    try:
        return replace(station, token=read_token(path, "token_file"))
    except FileNotFoundError:
        raise ConfigError(
            f"token_file: {path!r} is not there; a copy of the station's file of instructors' "
            "tokens is needed (mode 0600)"
        ) from None
