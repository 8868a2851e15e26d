"""Files by name: the shipped ones, and those in folders that an environment variable names.

And the folders of ROS packages, in which the shipped ones stand, and other files there.
"""

from __future__ import annotations

import copy
import difflib
import os
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, Dict, List

import rospkg
import yaml


def package_path(package: str) -> str:
    """Return the folder of a ROS package.

    rospkg goes through all packages of the machine to find one; here that is done once in a
    process, and again for a package that was not there then.

    Raises
    ------
    rospkg.ResourceNotFound
    """
    where = os.environ.get("ROS_PACKAGE_PATH", "")
    try:
        return str(_packages(where).get_path(package))
    except rospkg.ResourceNotFound:
        _packages.cache_clear()
        return str(_packages(where).get_path(package))


@lru_cache(maxsize=1)
def _packages(where: str) -> rospkg.RosPack:
    return rospkg.RosPack()


def package_file(package: str, *parts: str) -> Path:
    """Path of a file of a ROS package."""
    return Path(package_path(package)).joinpath(*parts)


def package_yaml(package: str, *parts: str) -> Any:
    """Return what is in a YAML file of a ROS package; it is the caller's own."""
    # To parse a file takes much longer than to copy what is in it.
    return copy.deepcopy(_parsed(package_file(package, *parts).read_text(encoding="utf-8")))


@lru_cache(maxsize=16)
def _parsed(text: str) -> Any:
    return yaml.safe_load(text)


@dataclass(frozen=True)
class FileCatalog:
    """Files of one kind, by their names without the suffix.

    Attributes
    ----------
    kind : str
        What a file is, in messages.
    variable : str
        Environment variable with further folders, separated by colons; they come first.
    package, folder : str
        ROS package, and the folder in it that has the shipped ones.
    error : type
        Of the exception that is raised.
    """

    kind: str
    variable: str
    package: str
    folder: str
    suffix: str
    error: type

    def folders(self) -> List[Path]:
        """Folders in which files are looked up by name, in this order."""
        given = [Path(part) for part in os.environ.get(self.variable, "").split(os.pathsep) if part]
        return [*given, Path(package_path(self.package), self.folder)]

    def files(self) -> Dict[str, Path]:
        """All that have a name, and their files."""
        found: Dict[str, Path] = {}
        for folder in self.folders():
            for path in sorted(folder.glob(f"*{self.suffix}")):
                found.setdefault(path.stem, path)
        return found

    def find(self, name: str) -> Path:
        """Find a file.

        Parameters
        ----------
        name : str
            Its name, or a path: what has a slash or ends in the suffix.

        Raises
        ------
        Exception
            `error`: there is none, or nobody may look; the message says which there are, or why.
        """
        if "/" in name or name.endswith(self.suffix):
            try:
                path = Path(name).expanduser()
                found = path.is_file()
            except OSError as error:
                raise self.error(f"{name}: the file cannot be read: {error.strerror}") from error
            except RuntimeError as error:
                raise self.error(f"{name}: there is no such home directory") from error
            if not found:
                start = "" if path.is_absolute() else f" (a relative path starts from {Path.cwd()})"
                raise self.error(f"{path}: there is no such file{start}")
            return path
        return self._known(name, "; or give a file's path")

    def find_by_name(self, name: str) -> Path:
        """Find a file by its name alone: what looks like a path is no name.

        Raises
        ------
        Exception
            `error`: there is none; the message says which there are.
        """
        return self._known(name, "")

    def _known(self, name: str, otherwise: str) -> Path:
        known = self.files()
        if name not in known:
            near = difflib.get_close_matches(name, known, n=3, cutoff=0.5)
            names = near + [other for other in known if other not in near]
            raise self.error(
                f"there is no {self.kind} '{name}'; there are: {', '.join(names)}{otherwise}"
            )
        return known[name]
