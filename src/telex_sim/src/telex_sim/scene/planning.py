"""Scenes and objects from text to assemblies: everything that can be wrong is found here.

Nothing of this touches the world, so a scene that is refused has changed nothing, and a running
loop is not kept waiting.
"""

from __future__ import annotations

import logging
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Collection, List, Mapping, Optional, Tuple

from telex_control.common.params import ConfigError, require

from .assets import Assets
from .catalog import find_scene
from .files.scene_file import SceneError, build_entry, free_name, load_scene, parse_scene
from .files.yaml_text import read_yaml
from .model import Scene, SceneObject
from .objects.assembly import Assembly, assemble

_log = logging.getLogger("rosout")

DEFAULT_STEP = 0.002
"""Step of the physics (s) that a scene is checked for where no simulator runs."""
MOST_ENTRY_BYTES = 100_000
"""A longer entry is refused: a parser of YAML hardly lets the loop's thread in between."""
TEXT = Path("text")
"""Name in messages of a scene that is given by its text, and the scene's where it says none."""
_PERIOD = 0.5


class Progress:
    """Tells the log how far the loading of a scene is, twice a second at most."""

    def __init__(self, scene: str, what: str) -> None:
        self._scene = scene
        self._what = what
        self._said = time.monotonic()

    def __call__(self, done: int, count: int) -> None:
        """Hear that `done` of `count` objects are done."""
        now = time.monotonic()
        if now - self._said >= _PERIOD:
            self._said = now
            _log.info("scene %s: %d of %d objects %s", self._scene, done, count, self._what)


@dataclass(frozen=True)
class PlannedScene:
    """A scene that can be loaded.

    Attributes
    ----------
    assemblies : tuple of Assembly
        Of the scene's objects, in their order.
    """

    path: Path
    scene: Scene
    assemblies: Tuple[Assembly, ...]


def plan_world(world: str, assets: Assets, step_size: float = DEFAULT_STEP) -> PlannedScene:
    """Read and check a scene that is given by its name, its file, or its text.

    Parameters
    ----------
    world : str
        A name, a path, or the text of a scene: whatever has a line break. A text has no folder, so
        that it can name no file by a relative address.

    Raises
    ------
    SceneError
    """
    if "\n" in world:
        return plan_scene(TEXT, assets, step_size, world)
    return plan_scene(find_scene(world), assets, step_size)


def plan_scene(
    path: Path, assets: Assets, step_size: float = DEFAULT_STEP, text: Optional[str] = None
) -> PlannedScene:
    """Read and check a scene file with all that it names.

    Parameters
    ----------
    text : str, optional
        In place of what stands in the file.

    Raises
    ------
    SceneError
        ``FILE: objects[3] (crate 'box_2'): mass is -1; it must be above 0``.
    """
    assemblies: List[Assembly] = []
    progress = Progress(path.stem, "read")

    def check(item: SceneObject, number: int, count: int) -> None:
        assemblies.append(assemble(item, assets, step_size))
        progress(number, count)

    scene = load_scene(path, check) if text is None else parse_scene(text, path, check, Path())
    try:
        assets.check_texture(scene.floor.surface.texture)
    except ConfigError as error:
        raise SceneError(f"{path}: floor/surface: {error}") from error
    return PlannedScene(path, scene, tuple(assemblies))


def plan_entry(
    text: str,
    name: str,
    folder: str,
    taken: Collection[str],
    assets: Assets,
    step_size: float = DEFAULT_STEP,
) -> List[Assembly]:
    """Read and check one entry, as ``sim/spawn`` gets it.

    Parameters
    ----------
    text : str
        YAML of an entry of ``objects``.
    name : str
        Of the entry; empty: the text's own, or else its type and a number.
    folder : str
        That relative addresses start from; empty allows none.
    taken : collection of str
        Names of the objects that there are, and of their entries.

    Raises
    ------
    ConfigError
    """
    entry = read_yaml(text, MOST_ENTRY_BYTES)
    require(isinstance(entry, Mapping), "object: a struct with the key 'type' is needed")
    require(
        not folder or Path(folder).is_absolute(),
        f"folder is '{folder}'; an absolute path is needed, or none",
    )
    if name:
        entry = {**entry, "name": name}
    default = free_name(str(entry.get("type", "object")), set(taken), {})
    return [assemble(item, assets, step_size) for item in build_entry(entry, Path(folder), default)]
