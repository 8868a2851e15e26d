"""Scene files: YAML in, a checked `Scene` out. docs/instructor/scenes.md describes the schema."""

from __future__ import annotations

import difflib
import os
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Callable, Dict, List, Mapping, Optional, Sequence, Set, Tuple

from telex_control.common.geometry.quaternions import compose, quaternion_from_rpy
from telex_control.common.params import ConfigError, read_struct, require
from telex_control.common.text_file import read_text_file

from ..addresses import absolute
from ..library import RESERVED, object_types
from ..model import (
    MOST_OBJECTS,
    ORIGIN,
    Floor,
    Form,
    Lights,
    ObjectModel,
    Quaternion,
    Scene,
    SceneObject,
    Source,
    Start,
    Vector3,
    Viewpoint,
    require_name,
)
from .yaml_text import MOST_BYTES, read_yaml

SUFFIX = ".yaml"
_MOST_LAMPS = 64
_MOST_TEXT = 2000


class SceneError(ValueError):
    """A scene cannot be used; the message names file, entry, key, value and what would be right."""


@dataclass(frozen=True)
class _Header:
    """A scene file without its objects."""

    name: str = ""
    description: str = ""
    floor: Floor = field(default_factory=Floor)
    lights: Lights = field(default_factory=Lights)
    start: Start = field(default_factory=Start)
    views: Tuple[Viewpoint, ...] = ()
    history: Dict[str, float] = field(default_factory=dict)
    antenna: Optional[Vector3] = None
    robots: Tuple[Start, ...] = ()
    hidden: bool = False

    def __post_init__(self) -> None:
        require(
            len(self.description) <= _MOST_TEXT,
            f"description has {len(self.description)} characters; at most {_MOST_TEXT} fit",
        )
        require(
            len(self.lights.lamps) <= _MOST_LAMPS,
            f"lights/lamps has {len(self.lights.lamps)} lamps; at most {_MOST_LAMPS} are possible",
        )


@dataclass(frozen=True)
class _Emitter:
    """A source that an entry carries; without a position, in its first part's middle."""

    nuclide: str
    activity: float
    position: Optional[Vector3] = None


@dataclass(frozen=True)
class _Placement:
    """Where an entry stands, what it is called, how it attenuates radiation and what it emits."""

    type: str
    name: str = ""
    position: Vector3 = ORIGIN
    yaw: Optional[float] = None
    rpy: Optional[Vector3] = None
    shield: str = ""
    source: Optional[_Emitter] = None

    def orientation(self) -> Quaternion:
        return quaternion_from_rpy(self.rpy or (0.0, 0.0, self.yaw or 0.0))

    def __post_init__(self) -> None:
        require(self.yaw is None or self.rpy is None, "yaw and rpy are both given; one is needed")
        for angle in self.rpy or (self.yaw or 0.0,):
            require(abs(angle) <= 100.0, f"an angle is {angle}; rad, at most 100, are needed")


Check = Callable[[SceneObject, int, int], None]
"""Looks at an object, raises a `ConfigError`; also gets the number of its entry, of how many."""


def load_scene(path: Path, check: Optional[Check] = None) -> Scene:
    """Read a scene file.

    Parameters
    ----------
    check : callable, optional
        Looks further, for example into the files that an object names.

    Raises
    ------
    SceneError
        ``FILE: where: what``.
    """
    return parse_scene(read_text_file(path, MOST_BYTES, SceneError), path, check)


def read_description(path: Path) -> Tuple[str, bool]:
    """Read what a scene file says of itself, without a look at its objects.

    Returns
    -------
    description : str
    hidden : bool
        Whether lists of lessons leave it out, for it is for measurements.

    Raises
    ------
    SceneError
        ``FILE: where: what``.
    """
    try:
        content = _content(read_text_file(path, MOST_BYTES, SceneError))
        header = _header(_without_objects(content))
        return " ".join(header.description.split()), header.hidden
    except ConfigError as error:
        raise SceneError(f"{path}: {error}") from error


def _content(text: str) -> Mapping[str, Any]:
    content = read_yaml(text)
    require(isinstance(content, Mapping), "a struct with the key 'objects' is needed")
    return content


def _without_objects(content: Mapping[str, Any]) -> Dict[str, Any]:
    return {key: value for key, value in content.items() if key != "objects"}


def parse_scene(
    text: str, path: Path, check: Optional[Check] = None, folder: Optional[Path] = None
) -> Scene:
    """Read the text of a scene file.

    Parameters
    ----------
    path : Path
        Of the file, for messages, and for the scene's name when it gives none.
    check : callable, optional
        As in `load_scene`.
    folder : Path, optional
        That relative addresses start from; a relative one allows none. By default that of `path`.

    Raises
    ------
    SceneError
    """
    if folder is None:
        folder = Path(os.path.abspath(path)).parent
    try:
        content = _content(text)
        entries = content.get("objects") or []
        require(isinstance(entries, list), "objects: a list is needed")
        header = _header(_without_objects(content))
        name = header.name or path.stem
        require_name(name, "name")
        surface = replace(
            header.floor.surface, texture=absolute(header.floor.surface.texture, folder)
        )
        return Scene(
            name,
            " ".join(header.description.split()),
            replace(header.floor, surface=surface),
            header.lights,
            _objects(entries, folder, check),
            header.start,
            header.views,
            header.history,
            header.antenna,
            header.robots,
        )
    except ConfigError as error:
        raise SceneError(f"{path}: {error}") from error


def _header(content: Mapping[str, Any]) -> _Header:
    try:
        return read_struct(_Header, content)
    except ConfigError as error:
        text = str(error)
        if "is unknown; known are " in text and "/" not in text.split(" is unknown")[0]:
            text += ", objects"
        raise ConfigError(text) from None


def _objects(
    entries: Sequence[Any], folder: Path, check: Optional[Check]
) -> Tuple[SceneObject, ...]:
    # Each makes one object at least; nobody waits for thousands to be made and then refused.
    require(
        len(entries) <= MOST_OBJECTS,
        f"objects: there are more than {MOST_OBJECTS} objects; that many are possible",
    )
    objects: List[SceneObject] = []
    taken: Dict[str, int] = {}
    counts: Dict[str, int] = {}
    names = [entry.get("name") for entry in entries if isinstance(entry, Mapping)]
    given = {name for name in names if isinstance(name, str)}
    for index, entry in enumerate(entries):
        kind = entry.get("type", "?") if isinstance(entry, Mapping) else "?"
        called = entry.get("name") if isinstance(entry, Mapping) else None
        called = called if isinstance(called, str) else None
        where = f"objects[{index}] ({kind}" + (f" '{called}')" if called else ")")
        try:
            default = ""
            if not called and isinstance(kind, str):
                default = free_name(kind, given, counts)
            made = build_entry(entry, folder, default)
            for item in made:
                require(
                    item.name not in taken,
                    f"name is '{item.name}'; objects[{taken.get(item.name)}] has it already",
                )
                taken[item.name] = index
            objects += made
            require(
                len(objects) <= MOST_OBJECTS,
                f"there are more than {MOST_OBJECTS} objects; that many are possible",
            )
            if check is not None:
                for item in made:
                    check(item, index + 1, len(entries))
        except ConfigError as error:
            raise ConfigError(f"{where}: {error}") from None
    return tuple(objects)


def free_name(kind: str, taken: Set[Any], counts: Dict[str, int]) -> str:
    """A name for an entry without one: its type and a number.

    Parameters
    ----------
    kind : str
        Its type.
    taken : set
        Names that it may not get.
    counts : dict of str to int
        The last number by type; it is counted on.
    """
    while True:
        counts[kind] = counts.get(kind, 0) + 1
        name = f"{kind}_{counts[kind]}"
        if name not in taken:
            return name


def build_entry(entry: Any, folder: Path, default_name: str) -> Tuple[SceneObject, ...]:
    """Make the objects of one entry of ``objects``.

    Parameters
    ----------
    entry : mapping
        As it stands in the file.
    folder : Path
        That relative addresses start from; one that is itself relative allows none.
    default_name : str
        Of an entry that has no name.

    Raises
    ------
    ConfigError
    """
    require(isinstance(entry, Mapping), f"it is {str(entry)[:60]!r}; a struct with type is needed")
    placement = read_struct(
        _Placement, {key: value for key, value in entry.items() if key in RESERVED}
    )
    types = object_types()
    if placement.type not in types:
        raise ConfigError(f"type is '{placement.type}'; {_known_types(placement.type)}")
    params = {key: value for key, value in entry.items() if key not in RESERVED}
    name = placement.name or default_name
    require_name(name, "name")
    made = read_struct(types[placement.type], params).build(folder)
    names = {item.name for item in made}
    require(bool(made) and len(names) == len(made), "it makes no object, or two of the same name")
    origin = (placement.position, placement.orientation())
    if placement.source is not None:
        made = (replace(made[0], model=_emitting(made[0].model, placement.source)), *made[1:])
    objects = []
    for item in made:
        position, orientation = compose(origin, (item.position, item.orientation))
        full = f"{name}_{item.name}" if item.name else name
        require_name(full, "name")
        shield, model = placement.shield, item.model
        objects.append(
            replace(
                item,
                name=full,
                model=_shielding(model, shield) if shield else model,
                position=position,
                orientation=orientation,
                entry=name,
            )
        )
    return tuple(objects)


def _emitting(model: ObjectModel, given: _Emitter) -> ObjectModel:
    """The same object with a source in its first link, in place of one that is there."""
    first = model.links[0]
    position = given.position
    if position is None:
        solid = [part.position for part in first.parts if part.solid] or [ORIGIN]
        position = solid[0] if first.source is None else first.source.position
    try:
        source = Source(given.nuclide, given.activity, position)
    except ConfigError as error:
        raise ConfigError(f"source: {error}") from None
    return replace(model, links=(replace(first, source=source), *model.links[1:]))


def _shielding(model: ObjectModel, material: str) -> ObjectModel:
    """The same object with all its solid parts made of a material that attenuates radiation."""
    for link in model.links:
        for part in link.parts:
            require(
                not part.solid or part.geometry.form is not Form.MESH,
                f"shield is '{material}'; the object has a solid mesh, and only boxes, cylinders "
                "and spheres can shield",
            )
    links = tuple(
        replace(
            link,
            parts=tuple(
                replace(part, shield=material) if part.solid else part for part in link.parts
            ),
        )
        for link in model.links
    )
    return replace(model, links=links)


def _known_types(wanted: str) -> str:
    types = list(object_types())
    near = difflib.get_close_matches(wanted, types, n=3, cutoff=0.5)
    rest = [name for name in types if name not in near]
    return f"there are: {', '.join(near + rest)}"
