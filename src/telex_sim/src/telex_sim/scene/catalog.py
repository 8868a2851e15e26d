"""Catalogue of scenes: the shipped ones, and the folders of ``TELEX_SCENE_PATH``."""

from __future__ import annotations

from pathlib import Path

from telex_control.common.file_catalog import FileCatalog

from .files.scene_file import SUFFIX, SceneError

PATH_VARIABLE = "TELEX_SCENE_PATH"
"""Environment variable with further folders, separated by colons; they come first."""

_CATALOG = FileCatalog("scene", PATH_VARIABLE, "telex_sim", "scenes", SUFFIX, SceneError)
scene_folders = _CATALOG.folders
scenes = _CATALOG.files
find_scene = _CATALOG.find
"""Raises a `SceneError`."""

MOST_PREVIEW = 60_000
"""Bytes of a picture in the list of scenes."""


def preview_of(scene: Path) -> Path:
    """Path of the picture that lists show of a scene file, whether there is one or not."""
    return scene.parent / "previews" / f"{scene.stem}.jpg"
