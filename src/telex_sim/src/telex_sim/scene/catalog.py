"""Catalogue of scenes: the shipped ones, and the folders of ``TELEX_SCENE_PATH``."""

from __future__ import annotations

from telex_control.common.file_catalog import FileCatalog

from .files.scene_file import SUFFIX, SceneError

PATH_VARIABLE = "TELEX_SCENE_PATH"
"""Environment variable with further folders, separated by colons; they come first."""

_CATALOG = FileCatalog("scene", PATH_VARIABLE, "telex_sim", "scenes", SUFFIX, SceneError)
scene_folders = _CATALOG.folders
scenes = _CATALOG.files
find_scene = _CATALOG.find
"""Raises a `SceneError`."""
