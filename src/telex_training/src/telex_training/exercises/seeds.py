"""The scene of an exercise: its base, the exercise's changes, and what a seed varies.

The result is the text of a scene, for ``sim/load_scene`` and for the recording: it says by itself
what stood where. The same exercise and seed make the same text, on any machine.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, Callable, Dict, List, Mapping, Optional, Sequence, Tuple

import numpy as np
import yaml

from telex_control.common.params import ConfigError, require
from telex_sim.scene.addresses import absolute
from telex_sim.scene.catalog import find_scene
from telex_sim.scene.files.scene_file import SceneError, parse_scene
from telex_sim.scene.files.yaml_text import MOST_BYTES, read_yaml
from telex_sim.scene.model import Scene

from .conditions import ROBOT
from .exercise_file import ExerciseError, merged
from .model import Exercise, Radiation, Vary

_ADDRESSES = ("mesh", "texture")
Change = Tuple[float, float, float, float]


def drawn_changes(vary: Sequence[Vary], seed: int) -> List[Change]:
    """Draw by how much each entry is moved.

    PCG64 seeded with `seed` gives four numbers an entry, in the order of the entries: for x, y, z
    and yaw, also where the span is 0, so that a change of one span changes nothing else. Only the
    generator's raw output is used, which numpy keeps the same in all of its versions.

    Parameters
    ----------
    seed : int
        0 or more.

    Returns
    -------
    list of tuple of 4 floats
        dx, dy, dz (m) and the turn (rad), even within the spans, to 0.1 mm and 0.1 mrad.
    """
    generator = np.random.PCG64(seed)
    made = []
    for entry in vary:
        raw = generator.random_raw(4)
        shares = [2.0 * (int(number) >> 11) * 2.0**-53 - 1.0 for number in raw]
        spans = (*entry.position, entry.yaw)
        dx, dy, dz, turn = (round(share * span, 4) for share, span in zip(shares, spans))
        made.append((dx, dy, dz, turn))
    return made


def scene_text(
    exercise: Exercise,
    seed: int,
    sealed: Optional[Mapping[str, str]] = None,
    find: Callable[[str], Path] = find_scene,
) -> str:
    """Make the text of an exercise's scene.

    Parameters
    ----------
    sealed : mapping of str to str, optional
        Tokens (`telex_sim.scene.sealed`) by the objects that are to be drawn anew.
    find : callable
        Finds the file of a scene by its name or path.

    Returns
    -------
    str
        YAML, several lines; no address in it is relative.

    Raises
    ------
    ExerciseError
        There is no such scene, or the exercise changes what is not in it.
    """
    try:
        content = _base(exercise, find)
        _lay_over(content, exercise.scene.changes)
        if exercise.robots:
            content["robots"] = [robot.start() for robot in exercise.robots]
        _irradiate(content, exercise.radiation)
        for i, (entry, change) in enumerate(zip(exercise.vary, drawn_changes(exercise.vary, seed))):
            _move(content, exercise, entry.object, change, f"vary[{i}]/object")
        for name, token in (sealed or {}).items():
            index = _entry(content, name, f"questions/of: '{name}'")
            rest = {k: v for k, v in content["objects"][index].items() if k != "seed"}
            content["objects"][index] = {**rest, "sealed": token}
    except (ConfigError, SceneError) as error:
        raise ExerciseError(f"{exercise.path}: {error}") from error
    return yaml.safe_dump(
        content, sort_keys=False, default_flow_style=None, width=1_000_000, allow_unicode=True
    )


def scene_of(exercise: Exercise, text: str) -> Scene:
    """Read the text of an exercise's scene.

    Raises
    ------
    ExerciseError
    """
    try:
        return parse_scene(text, exercise.path)
    except SceneError as error:
        rest = str(error).split(": ", 1)[1]
        raise ExerciseError(f"{exercise.path}: scene: {rest}") from error


def _base(exercise: Exercise, find: Callable[[str], Path]) -> Dict[str, Any]:
    base, folder = exercise.scene.base, exercise.scene.folder
    if isinstance(base, str):
        try:
            near = folder / Path(base).expanduser()
            path = near if near.is_file() else find(base)
            text = path.read_text(encoding="utf-8")
        except (ConfigError, SceneError):
            raise
        # RuntimeError: there is no such home; ValueError: no text, or no path.
        except (OSError, RuntimeError, ValueError) as error:
            raise ConfigError(f"scene is '{base[:200]}'; it cannot be read: {error}") from error
        try:
            base = read_yaml(text, MOST_BYTES)
        except ConfigError as error:
            raise ConfigError(f"scene is '{base}'; {path}: {error}") from error
        require(isinstance(base, Mapping), f"scene is '{exercise.scene.base}'; it is no scene")
        folder = path.absolute().parent
        base = {"name": path.stem, **base}
    made = _with_addresses({"name": exercise.name, **base}, folder)
    objects = made.get("objects")
    require(objects is None or isinstance(objects, list), "scene/objects: a list is needed")
    made["objects"] = list(objects or [])
    return made


def _with_addresses(value: Any, folder: Path, key: str = "") -> Any:
    """Copy plain values; relative addresses in them become absolute."""
    if isinstance(value, Mapping):
        return {name: _with_addresses(item, folder, str(name)) for name, item in value.items()}
    if isinstance(value, list):
        return [_with_addresses(item, folder) for item in value]
    if key in _ADDRESSES and isinstance(value, str):
        return absolute(value, folder)
    return value


def _lay_over(content: Dict[str, Any], changes: Mapping[str, Any]) -> None:
    for key, change in changes.items():
        if key != "objects":
            content[key] = merged(content.get(key) or {}, change)
            continue
        for name, values in change.items():
            index = _entry(content, name, f"objects/{name}")
            content["objects"][index] = merged(content["objects"][index], values)


def _irradiate(content: Dict[str, Any], radiation: Radiation) -> None:
    for i, source in enumerate(radiation.sources):
        index = _entry(content, source.object, f"sources[{i}]/object")
        given = {"nuclide": source.nuclide, "activity": source.activity}
        content["objects"][index] = {**content["objects"][index], "source": given}
    if radiation.history:
        content["history"] = merged(content.get("history") or {}, radiation.history)


def _entry(content: Mapping[str, Any], name: str, where: str) -> int:
    entries = content["objects"]
    names = [entry.get("name") for entry in entries if isinstance(entry, Mapping)]
    for index, entry in enumerate(entries):
        if isinstance(entry, Mapping) and entry.get("name") == name:
            return index
    known = ", ".join(sorted(given for given in names if isinstance(given, str))) or "none"
    raise ConfigError(f"{where}: the scene has no entry of the name '{name}'; there are: {known}")


def _move(
    content: Dict[str, Any], exercise: Exercise, name: str, change: Change, where: str
) -> None:
    dx, dy, dz, turn = change
    if name == ROBOT:
        content["start"] = _moved_start(content.get("start") or {}, change, "start")
        return
    further = [robot.name for robot in exercise.robots]
    if name in further:
        number = further.index(name)
        starts = content["robots"]
        starts[number] = _moved_start(starts[number], change, f"robots[{number}]")
        return
    index = _entry(content, name, where)
    entry = dict(content["objects"][index])
    position = entry.get("position", [0.0, 0.0, 0.0])
    require(
        isinstance(position, list) and len(position) == 3, f"{where}: its position is {position}"
    )
    entry["position"] = [
        round(_number(number, f"{where}: its position") + by, 6)
        for number, by in zip(position, (dx, dy, dz))
    ]
    if entry.get("rpy") is not None:
        rpy = entry["rpy"]
        require(isinstance(rpy, list) and len(rpy) == 3, f"{where}: its rpy is {rpy}")
        entry["rpy"] = [*rpy[:2], round(_number(rpy[2], f"{where}: its rpy") + turn, 6)]
    elif turn:
        entry["yaw"] = round(_number(entry.get("yaw") or 0.0, f"{where}: its yaw") + turn, 6)
    content["objects"][index] = entry


def _moved_start(given: Any, change: Change, where: str) -> Dict[str, Any]:
    require(isinstance(given, Mapping), f"{where} is {str(given)[:60]!r}; a struct is needed")
    start = dict(given)
    for key, by in zip(("x", "y", "ground", "yaw"), change):
        start[key] = round(_number(start.get(key, 0.0), f"{where}/{key}") + by, 6)
    return start


def _number(value: Any, where: str) -> float:
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    require(number and abs(value) < 1e6, f"{where} is {str(value)[:60]!r}; a number is needed")
    return float(value)
