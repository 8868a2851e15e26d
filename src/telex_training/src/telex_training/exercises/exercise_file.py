"""Exercise files: YAML in, checked `Exercise`s out. docs/instructor/exercises.md has the schema."""

from __future__ import annotations

import difflib
import hashlib
import os
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Callable, Dict, List, Mapping, Optional, Tuple, TypeVar

from telex_control.common.params import ConfigError, read_struct, read_value, require
from telex_control.common.text_file import read_text_file
from telex_sim.scene.files.yaml_text import read_yaml
from telex_sim.scene.model import MOST_FURTHER, require_name

from .conditions import Condition, read_condition
from .metric_kinds import KINDS
from .model import (
    CONTROLS,
    LINK_FIELDS,
    MODES,
    MOST_TEXT,
    PRACTICE,
    Contacts,
    Exercise,
    Expert,
    Failure,
    Fault,
    FurtherRobot,
    Hint,
    LineLink,
    Malfunction,
    Metric,
    Penalty,
    PutBack,
    Question,
    RadiatingObject,
    Radiation,
    Repetitions,
    SceneSource,
    Seeds,
    Step,
    Survey,
    Vary,
    Zone,
    require_label,
)
from .yaml_parts import MOST, list_of, struct_of, structs_of

SUFFIX = ".yaml"
STANDARD = "standard"
"""Name of the one setting of an exercise that gives none."""
MOST_TEXTS = 300
"""Of an exercise in another language."""
MOST_BYTES = 200_000
"""A longer file is refused before it is read."""
_DRAWN = "drawn"
_LARGEST_SEED = 2**63 - 1
_CONDITIONS = ("begin", "until", "when")
_SCENE_CHANGES = ("floor", "lights", "start", "objects")
KEYS = (
    "name",
    "title",
    "description",
    "scene",
    *_SCENE_CHANGES,
    "variant",
    "mode",
    "seed",
    "vary",
    "settings",
    "zones",
    "begin",
    "steps",
    "any_order",
    "repetitions",
    "put_back",
    "faults",
    "penalties",
    "contacts",
    "questions",
    "metrics",
    "expert",
    "hints",
    "controls",
    "link",
    "malfunctions",
    "sources",
    "limits",
    "history",
    "survey",
    "robots",
    "texts",
)
"""What an exercise file may have on its top level."""

Made = TypeVar("Made")


class ExerciseError(ValueError):
    """An exercise cannot be used; the message names file, key, value and what would be right."""


@dataclass(frozen=True)
class ExerciseFile:
    """An exercise in all of its settings.

    Attributes
    ----------
    text : str
        As it stands in the file.
    settings : dict of str to Exercise
        In the order of the file, which is that of difficulty.
    texts : dict of str to dict of str to str
        What it says in other languages, by their codes and the English texts.
    """

    path: Path
    text: str
    settings: Dict[str, Exercise]
    texts: Dict[str, Dict[str, str]]

    @property
    def first(self) -> Exercise:
        """The exercise in its first setting."""
        return next(iter(self.settings.values()))

    def setting(self, name: str) -> Exercise:
        """Return the exercise in one of its settings; empty: the first.

        Raises
        ------
        ExerciseError
        """
        if not name:
            return self.first
        if name not in self.settings:
            raise ExerciseError(
                f"{self.path}: setting is '{name}'; there are: {', '.join(self.settings)}"
            )
        return self.settings[name]


def load_exercise(path: Path) -> ExerciseFile:
    """Read an exercise file.

    Raises
    ------
    ExerciseError
        ``FILE: where: what``.
    """
    return parse_exercise(read_text_file(path, MOST_BYTES, ExerciseError), path)


def parse_exercise(text: str, path: Path) -> ExerciseFile:
    """Read the text of an exercise file.

    Parameters
    ----------
    path : Path
        Of the file: for messages, for relative paths, and for the name where it gives none.

    Raises
    ------
    ExerciseError
        ``FILE: where: what``.
    """
    try:
        content = read_yaml(text, MOST_BYTES)
        require(isinstance(content, Mapping), "a struct with the key 'steps' is needed")
        digest = hashlib.sha256(text.encode("utf-8")).hexdigest()
        return ExerciseFile(path, text, _settings(content, path, digest), _texts(content))
    except ConfigError as error:
        raise ExerciseError(f"{path}: {error}") from error


def merged(base: Any, change: Any, key: str = "") -> Any:
    """Lay a setting's values over those of the exercise.

    Structs are joined key by key, a null takes a key away; lists, and conditions as wholes, take
    the place of what was there.
    """
    replaces = key in _CONDITIONS or not isinstance(base, Mapping)
    if replaces or not isinstance(change, Mapping):
        return change
    made = dict(base)
    for name, value in change.items():
        if value is None:
            made.pop(name, None)
        else:
            made[name] = merged(made[name], value, name) if name in made else value
    return made


def _settings(content: Mapping[str, Any], path: Path, digest: str) -> Dict[str, Exercise]:
    _known_keys(content, "")
    base = {key: value for key, value in content.items() if key not in ("settings", "texts")}
    changes = content.get("settings")
    if changes is None:
        return {STANDARD: _exercise(base, path, digest, (STANDARD,), STANDARD)}
    require(isinstance(changes, list) and bool(changes), "settings: a list of structs is needed")
    require(len(changes) <= MOST, f"settings has {len(changes)} entries; at most {MOST} fit")
    names: List[str] = []
    for i, change in enumerate(changes):
        require(isinstance(change, Mapping), f"settings[{i}]: a struct with a name is needed")
        name = read_value(str, change.get("name"), f"settings[{i}]/name")
        require_name(name, f"settings[{i}]/name")
        require(name not in names, f"settings[{i}]/name is '{name}'; another one has it already")
        names.append(name)
    try:
        _exercise(base, path, digest, tuple(names), names[0])
        wrong = ""
    except ConfigError as error:
        wrong = str(error)
    made = {}
    for i, (name, change) in enumerate(zip(names, changes)):
        rest = {key: value for key, value in change.items() if key != "name"}
        where = f"settings[{i}] ({name})"
        try:
            _known_keys(rest, "")
            for key in ("settings", "texts"):
                require(key not in rest, f"{key}: a setting has none of its own")
            made[name] = _exercise(merged(base, rest), path, digest, tuple(names), name)
        except ConfigError as error:
            # What is wrong without the setting is not the setting's.
            raise ConfigError(str(error) if str(error) == wrong else f"{where}: {error}") from None
    return made


def _texts(content: Mapping[str, Any]) -> Dict[str, Dict[str, str]]:
    made: Dict[str, Dict[str, str]] = {}
    for language, table in struct_of(content, "texts").items():
        where = f"texts/{language}"
        require(
            re.fullmatch("[a-z]{2}", language) is not None,
            f"{where}: a language's code of two letters is needed, such as de",
        )
        require(isinstance(table, Mapping), f"{where}: a struct of texts by English ones is needed")
        require(len(table) <= MOST_TEXTS, f"{where} has {len(table)} texts; {MOST_TEXTS} fit")
        made[language] = {}
        for english, text in table.items():
            said = read_value(str, text, f"{where}/{str(english)[:60]}").strip()
            require(
                0 < len(said) <= MOST_TEXT,
                f"{where}/{str(english)[:60]} has {len(said)} characters; 1 to {MOST_TEXT} fit",
            )
            made[language][" ".join(str(english).split())] = said
    return made


def _known_keys(content: Mapping[str, Any], where: str) -> None:
    for key in content:
        if key not in KEYS:
            near = difflib.get_close_matches(str(key), KEYS, n=1, cutoff=0.6)
            rest = [name for name in KEYS if name not in near]
            raise ConfigError(f"{where}{key} is unknown; known are {', '.join(near + rest)}")


def _exercise(
    content: Mapping[str, Any], path: Path, digest: str, names: Tuple[str, ...], setting: str
) -> Exercise:
    def text(key: str, default: str = "") -> str:
        return " ".join(read_value(str, content.get(key, default), key).split())

    name = text("name", path.stem)
    require_name(name, "name")
    title = text("title", name.replace("_", " "))
    require_label(title, "title")
    description = text("description")
    require(len(description) <= 2000, f"description has {len(description)} characters; 2000 fit")
    require("scene" in content, "scene is missing; a name, a path or the content is needed")
    require("steps" in content, "steps is missing; one step at least is needed")
    variant = text("variant", "standard")
    require(bool(variant), "variant is ''; a variant of the robot is needed")
    steps = _named(content, "steps", _step)
    require(bool(steps), "steps is []; one step at least is needed")
    zones = {
        zone: read_struct(Zone, given, f"zones/{zone}")
        for zone, given in struct_of(content, "zones").items()
    }
    for zone in zones:
        require_name(zone, "name of a zone")
    folder = Path(os.path.abspath(path)).parent
    radiation, robots = _radiation(content), _robots(content)
    limits = radiation.faults([robot.name for robot in robots])
    made = Exercise(
        path=path,
        sha256=digest,
        name=name,
        title=title,
        description=description,
        variant=variant,
        modes=_modes(content),
        settings=names,
        setting=setting,
        scene=SceneSource(_base(content), folder, _changes(content)),
        seeds=_seeds(content),
        vary=structs_of(content, "vary", Vary),
        zones=zones,
        begin=read_condition(content.get("begin", {"event": {"name": "command"}}), "begin"),
        steps=steps,
        any_order=read_value(bool, content.get("any_order", False), "any_order"),
        repetitions=read_struct(Repetitions, struct_of(content, "repetitions"), "repetitions"),
        put_back=read_struct(PutBack, struct_of(content, "put_back"), "put_back"),
        faults=_distinct((*_named(content, "faults", _fault), *limits), "faults"),
        penalties=_named(content, "penalties", _penalty),
        contacts=read_struct(Contacts, struct_of(content, "contacts"), "contacts"),
        questions=_distinct(structs_of(content, "questions", Question), "questions"),
        metrics=_metrics(content),
        expert=read_struct(Expert, struct_of(content, "expert"), "expert"),
        hints=_hints(content),
        controls=_controls(content),
        malfunctions=_malfunctions(content),
        radiation=radiation,
        survey=_survey(content),
        link=_link(content),
        robots=robots,
    )
    _require_robots(made)
    _require_zones(made)
    return made


def _named(
    content: Mapping[str, Any], key: str, make: Callable[[Mapping[str, Any], str], Made]
) -> Tuple[Made, ...]:
    """Entries of a list that have a name and a condition; their names differ."""
    made = []
    for i, given in enumerate(list_of(content, key)):
        name = given.get("name") if isinstance(given, Mapping) else None
        where = f"{key}[{i}] ({name})" if isinstance(name, str) else f"{key}[{i}]"
        require(isinstance(given, Mapping), f"{where}: a struct with a name is needed")
        require_label(read_value(str, name, f"{where}/name"), f"{where}/name")
        made.append(make(given, where))
    return _distinct(tuple(made), key)


def _distinct(items: Tuple[Made, ...], key: str) -> Tuple[Made, ...]:
    names = [item.name for item in items]  # type: ignore[attr-defined]
    for i, name in enumerate(names):
        require(name not in names[:i], f"{key}[{i}]/name is '{name}'; another one has it already")
    return items


def _fields(given: Mapping[str, Any], where: str, condition: str, *more: str) -> Condition:
    known = ("name", condition, *more)
    for field in given:
        require(field in known, f"{where}/{field} is unknown; known are {', '.join(known)}")
    for field in known:
        require(field in given, f"{where}/{field} is missing")
    return read_condition(given[condition], f"{where}/{condition}")


def _step(given: Mapping[str, Any], where: str) -> Step:
    return Step(given["name"], _fields(given, where, "until"))


def _fault(given: Mapping[str, Any], where: str) -> Fault:
    return Fault(given["name"], _fields(given, where, "when"))


def _penalty(given: Mapping[str, Any], where: str) -> Penalty:
    when = _fields(given, where, "when", "seconds")
    seconds = read_value(float, given["seconds"], f"{where}/seconds")
    require(0.0 < seconds <= 3600.0, f"{where}/seconds is {seconds}; above 0, to 3600, is needed")
    return Penalty(given["name"], when, seconds)


def _modes(content: Mapping[str, Any]) -> Tuple[str, ...]:
    given = content.get("mode", list(MODES))
    modes = read_value(Tuple[str, ...], [given] if isinstance(given, str) else given, "mode")
    require(
        bool(modes) and len(set(modes)) == len(modes) and set(modes) <= set(MODES),
        f"mode is {list(modes)}; {' and '.join(MODES)}, or one of them, are possible",
    )
    return modes


def _controls(content: Mapping[str, Any]) -> Tuple[str, ...]:
    given = read_value(Tuple[str, ...], list_of(content, "controls"), "controls")
    require(
        set(given) <= set(CONTROLS) and len(set(given)) == len(given),
        f"controls is {list(given)}; {', '.join(CONTROLS)} are possible, each once",
    )
    return given


def _seeds(content: Mapping[str, Any]) -> Seeds:
    given = struct_of(content, "seed")
    made: Dict[str, Optional[int]] = {}
    for mode, seed in given.items():
        require(mode in MODES, f"seed/{mode} is unknown; known are {', '.join(MODES)}")
        if seed == _DRAWN:
            made[mode] = None
            continue
        whole = isinstance(seed, int) and not isinstance(seed, bool)
        require(
            whole and 0 <= seed <= _LARGEST_SEED,
            f"seed/{mode} is {str(seed)[:60]!r}; a whole number from 0, or {_DRAWN}, is needed",
        )
        made[mode] = seed
    require(
        made.get(PRACTICE, 1) is not None,
        f"seed/{PRACTICE} is {_DRAWN}; practice has a fixed one",
    )
    return Seeds(**made)


def _base(content: Mapping[str, Any]) -> Any:
    base = content["scene"]
    fits = (isinstance(base, str) and bool(base)) or isinstance(base, Mapping)
    require(
        fits, f"scene is {str(base)[:60]!r}; a name, a path or the content of a scene is needed"
    )
    return base


def _changes(content: Mapping[str, Any]) -> Dict[str, Any]:
    made = {key: struct_of(content, key) for key in _SCENE_CHANGES if key in content}
    for name, change in made.get("objects", {}).items():
        require(isinstance(change, Mapping), f"objects/{name}: a struct is needed")
        require(
            not {"name", "type"} & set(change), f"objects/{name}: name and type cannot be changed"
        )
    return made


def _hints(content: Mapping[str, Any]) -> Tuple[Hint, ...]:
    """Read the hints; YAML 1.1 takes a bare ``on``, also as a key, for true."""
    made = []
    for i, given in enumerate(list_of(content, "hints")):
        named = given
        if isinstance(given, Mapping):
            named = {("on" if key is True else key): value for key, value in given.items()}
        made.append(read_struct(Hint, named, f"hints[{i}]"))
    return tuple(made)


def _metrics(content: Mapping[str, Any]) -> Tuple[Metric, ...]:
    made = []
    for name, given in struct_of(content, "metrics").items():
        where = f"metrics/{name}"
        require_name(name, "name of a metric")
        require(isinstance(given, Mapping), f"{where} is {str(given)[:60]!r}; a struct is needed")
        for key in ("name", "bound"):
            require(key not in given, f"{where}/{key} is unknown; known are {_METRIC_KEYS}")
        fields = {("bound" if key == "pass" else key): value for key, value in given.items()}
        kind = fields.setdefault("kind", name)
        require(
            isinstance(kind, str) and kind in KINDS,
            f"{where}/kind is {str(kind)[:60]!r}; {', '.join(KINDS)} are possible",
        )
        try:
            made.append(read_struct(Metric, {**fields, "name": name}, where))
        except ConfigError as error:
            text = str(error).replace(f"{where}/bound", f"{where}/pass")
            if " is unknown" in text:
                text = text.split(";")[0] + f"; known are {_METRIC_KEYS}"
            raise ConfigError(text) from None
    return tuple(made)


_METRIC_KEYS = "expert, height, kind, length, object, over, pass, robot"


def _link(content: Mapping[str, Any]) -> Optional[LineLink]:
    """Read `link`: a profile, a delay in ms, or figures, which may name a profile as well."""
    given = content.get("link")
    if given is None:
        return None
    if isinstance(given, str):
        require(bool(given), "link is ''; the name of a profile, such as perfect, is needed")
        return LineLink(given)
    if not isinstance(given, Mapping):
        delay = read_value(float, given, "link")
        require(delay >= 0.0, f"link is {delay:g}; a delay (ms) of 0 or more is needed")
        return LineLink(fields={"delay": delay / 1000.0})
    profile = read_value(str, given.get("profile", "perfect"), "link/profile")
    fields = {}
    for key, value in given.items():
        if key != "profile":
            known = ", ".join(("profile", *LINK_FIELDS))
            require(key in LINK_FIELDS, f"link/{key} is unknown; known are {known}")
            fields[key] = read_value(float, value, f"link/{key}")
            require(fields[key] >= 0.0, f"link/{key} is {value!r}; 0 or more is needed")
    return LineLink(profile, fields)


def _radiation(content: Mapping[str, Any]) -> Radiation:
    limits: Dict[str, float] = {}
    for key, given in struct_of(content, "limits").items():
        require(key == "dose", f"limits/{key} is unknown; known is dose")
        limits = read_value(Dict[str, float], given, "limits/dose")
    return Radiation(
        structs_of(content, "sources", RadiatingObject),
        limits,
        read_value(Dict[str, float], struct_of(content, "history"), "history"),
    )


def _robots(content: Mapping[str, Any]) -> Tuple[FurtherRobot, ...]:
    robots = _distinct(structs_of(content, "robots", FurtherRobot), "robots")
    require(
        len(robots) <= MOST_FURTHER,
        f"robots has {len(robots)} entries; at most {MOST_FURTHER} beside the first are possible",
    )
    return robots


def _require_robots(exercise: Exercise) -> None:
    """Refuse a condition, a metric or a malfunction of a robot that there is not."""
    known = [robot.name for robot in exercise.robots]
    asked = [
        (f"{where}/{part.kind}/robot", part.robot)
        for where, condition in exercise.conditions()
        for part in condition.walk()
    ]
    asked += [(f"metrics/{metric.name}/robot", metric.robot) for metric in exercise.metrics]
    asked += [
        (f"malfunctions[{i}]/robot", each.failure.robot)
        for i, each in enumerate(exercise.malfunctions)
    ]
    for where, name in asked:
        require(
            name in ("", *known),
            f"{where} is '{name}'; beside the first robot there are: {', '.join(known) or 'none'}",
        )


def _require_zones(exercise: Exercise) -> None:
    """Refuse a condition or a survey in a zone that there is not."""
    asked = [
        (f"{where}/{part.kind}", zone)
        for where, condition in exercise.conditions()
        for part in condition.walk()
        for zone in part.zones()
    ]
    if exercise.survey is not None:
        asked += [("survey/points", zone) for zone in exercise.survey.points]
    known = ", ".join(exercise.zones) or "none"
    for where, zone in asked:
        require(zone in exercise.zones, f"{where}: zone is '{zone}'; there are: {known}")


def _survey(content: Mapping[str, Any]) -> Optional[Survey]:
    given = content.get("survey")
    return None if given is None else read_struct(Survey, given, "survey")


def _malfunctions(content: Mapping[str, Any]) -> Tuple[Malfunction, ...]:
    made = []
    for i, given in enumerate(list_of(content, "malfunctions")):
        where = f"malfunctions[{i}]"
        require(isinstance(given, Mapping), f"{where} is {str(given)[:60]!r}; a struct is needed")
        require("when" in given, f"{where}/when is missing")
        when = read_condition(given["when"], f"{where}/when")
        rest = {key: value for key, value in given.items() if key != "when"}
        made.append(Malfunction(when, read_struct(Failure, rest, where)))
    return tuple(made)
