"""Files that ROS packages ship."""

from __future__ import annotations

import copy
from functools import lru_cache
from pathlib import Path
from typing import Any

import yaml

from .file_catalog import package_path


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
