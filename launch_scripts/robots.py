#!/usr/bin/env python3
"""Reads what `run.sh robots:=...` says, and prints what roslaunch is to be told.

    robots.py NUMBER_OR_LIST NAMESPACE VARIANT

A number makes so many robots of VARIANT, NAMESPACE the first of them. A list names them, with
commas between: NAME, NAME=VARIANT, VARIANT or NAMESPACE_VARIANT. The lines that come out are launch
arguments; then, for run.sh, the names.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import List, Tuple

import rospkg
import yaml

MOST = 4
"""Robots in one scene: what the launch files have places for."""

_IN_SCENE = "telex"
"""What the first robot is called in the scene, whatever its namespace."""

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")


class RobotsError(Exception):
    """What was given cannot be used; the message says why."""


def variants() -> List[str]:
    """Names of the variants that are shipped."""
    file = Path(rospkg.RosPack().get_path("telex_description")) / "config" / "variants.yaml"
    return list(yaml.safe_load(file.read_text())["variants"])


def robots(text: str, first: str, variant: str) -> List[Tuple[str, str]]:
    """Name and variant of each robot.

    Parameters
    ----------
    text
        What was given.
    first
        Namespace that a robot has by default.
    variant
        Of robots of which nothing else is said.
    """
    if re.fullmatch(r"[+-]?[0-9]+", text):
        count = int(text)
        if not 1 <= count <= MOST:
            raise RobotsError(f"1 to {MOST} robots are possible")
        return [
            (first, variant),
            *((f"{first}_{letter}", variant) for letter in "bcd"[: count - 1]),
        ]
    entries = [entry.strip() for entry in text.split(",")]
    if not all(entries):
        raise RobotsError("a number, or names with one comma between two of them, are needed")
    if len(entries) > MOST:
        raise RobotsError(f"it names {len(entries)} robots; at most {MOST} are possible")
    found = [_robot(entry, first, variant) for entry in entries]
    names = [name for name, _ in found]
    for name in names:
        if names.count(name) > 1:
            raise RobotsError(f"'{name}' stands there twice; NAME=VARIANT gives each its own name")
    if _IN_SCENE in names[1:]:
        raise RobotsError(f"'{_IN_SCENE}' can only be the first: that is called so in the scene")
    return found


def _robot(entry: str, first: str, variant: str) -> Tuple[str, str]:
    known = variants()
    name, equals, wanted = entry.partition("=")
    if not equals:
        of_variant = entry[len(first) + 1 :] if entry.startswith(f"{first}_") else entry
        wanted = of_variant if of_variant in known else variant
        name = f"{first}_{entry}" if entry in known else entry
    if not _NAME.fullmatch(name) or name in ("true", "false"):
        raise RobotsError(f"'{name}' is no name of a robot: a letter, then letters, digits and _")
    return name, _kind(wanted) if equals else wanted


def _kind(variant: str) -> str:
    """Return a variant's name, or its file's absolute path."""
    if not variant.endswith((".yaml", ".yml")):
        known = variants()
        if variant not in known:
            raise RobotsError(
                f"'{variant}' is no variant; there are {', '.join(known)}, or a .yaml file"
            )
        return variant
    file = Path(variant).expanduser().resolve()
    if not file.is_file():
        raise RobotsError(f"there is no file {file}")
    if "," in str(file) or "=" in str(file):
        raise RobotsError(f"{file}: its path must have neither , nor =")
    return str(file)


def main() -> None:
    """Print launch arguments and names, or why not."""
    text, first, variant = sys.argv[1:]
    try:
        if not _NAME.fullmatch(first):
            raise RobotsError(f"with it, ns:={first} must be a letter, then letters, digits and _")
        found = robots(text, first, _kind(variant))
    except RobotsError as error:
        sys.exit(
            f"run.sh: robots:={text}: {error}. Two robots: robots:=2, robots:=telex,six_axis, or "
            "robots:=ann=standard,bob=six_axis"
        )
    (name, own), *others = found
    print(f"ns:={name}")
    print(f"variant:={own}")
    print("others:=" + ",".join(f"{other}={kind}" for other, kind in others))
    print(" ".join(name for name, _ in found))


if __name__ == "__main__":
    main()
