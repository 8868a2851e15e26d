"""Catalogue of scenes: the shipped ones, and the folders of ``TELEX_SCENE_PATH``."""

from __future__ import annotations

from pathlib import Path

from telex_control.common.file_catalog import FileCatalog, package_path

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
_JPEG = b"\xff\xd8\xff"


def preview_of(scene: Path) -> Path:
    """Path of the picture that lists show of a scene file, whether there is one or not."""
    return scene.parent / "previews" / f"{scene.stem}.jpg"


def preview_of_type(name: str) -> Path:
    """Path of the picture that lists show of a type of object."""
    return Path(package_path("telex_sim"), "scenes", "previews", "objects", f"{name}.jpg")


def small_jpeg(path: Path) -> bytes:
    """Return a JPEG file's content; nothing where it is none, or is too large for a list."""
    try:
        with path.open("rb") as file:
            content = file.read(MOST_PREVIEW + 1)
    except OSError:
        return b""
    return content if content.startswith(_JPEG) and len(content) <= MOST_PREVIEW else b""
