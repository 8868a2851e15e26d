"""Catalogue of scenes: the shipped ones, and the folders of ``TELEX_SCENE_PATH``."""

from __future__ import annotations

import difflib
import os
from pathlib import Path
from typing import Dict, List

import rospkg

from .files.scene_file import SUFFIX, SceneError

PATH_VARIABLE = "TELEX_SCENE_PATH"
"""Environment variable with further folders, separated by colons; they come first."""


def scene_folders() -> List[Path]:
    """Folders in which scenes are looked up by name, first come, first served."""
    given = [Path(part) for part in os.environ.get(PATH_VARIABLE, "").split(os.pathsep) if part]
    shipped = Path(rospkg.RosPack().get_path("telex_sim"), "scenes")
    return [*given, shipped]


def scenes() -> Dict[str, Path]:
    """All scenes that have a name, and their files."""
    found: Dict[str, Path] = {}
    for folder in scene_folders():
        for path in sorted(folder.glob(f"*{SUFFIX}")):
            found.setdefault(path.stem, path)
    return found


def find_scene(world: str) -> Path:
    """Find the file of a scene.

    Parameters
    ----------
    world : str
        Its name, or a path: what has a slash or ends in ``.yaml``.

    Raises
    ------
    SceneError
        There is none; the message says which there are.
    """
    if "/" in world or world.endswith(SUFFIX):
        path = Path(world).expanduser()
        if not path.is_file():
            start = "" if path.is_absolute() else f" (a relative path starts from {Path.cwd()})"
            raise SceneError(f"{path}: there is no such file{start}")
        return path
    known = scenes()
    if world not in known:
        near = difflib.get_close_matches(world, known, n=3, cutoff=0.5)
        names = near + [name for name in known if name not in near]
        raise SceneError(
            f"there is no scene '{world}'; there are: {', '.join(names)}; or give a file's path"
        )
    return known[world]
