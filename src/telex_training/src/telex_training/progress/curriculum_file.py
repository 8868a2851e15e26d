"""Curriculum files: YAML in, checked `Curriculum`s out.

docs/instructor/progress.md describes the keys.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Dict, Mapping, Optional, Tuple

from telex_control.common.file_catalog import FileCatalog
from telex_control.common.params import (
    ConfigError,
    Declared,
    number,
    parameter,
    read_struct,
    read_value,
    require,
    require_names,
    require_text,
    required,
    word,
)
from telex_control.common.text_file import read_text_file
from telex_sim.scene.files.yaml_text import read_yaml
from telex_sim.scene.model import require_name

from ..exercises.model import require_label
from ..exercises.yaml_parts import structs_of

SUFFIX = ".yaml"
MOST_BYTES = 100_000
"""A longer file is refused before it is read."""
PATH_VARIABLE = "TELEX_CURRICULUM_PATH"
"""Environment variable with further folders, separated by colons; they come first."""
KEYS = ("name", "title", "description", "modules", "exam", "currency")


class CurriculumError(ValueError):
    """A curriculum cannot be used; the message names file, key, value and what would be right."""


@dataclass(frozen=True)
class Proficient(Declared):
    """When an exercise is mastered."""

    consecutive: int = number(2, "Repetitions in a row that have to pass.", 1, 1000)
    more: int = number(0, "Further ones that have to pass after those, in a row or not.", 0, 1000)
    most: int = number(
        0, "Repetitions within which all this has to happen; 0: any number.", 0, 100_000
    )

    def check(self) -> None:
        """Check what concerns several of them; see `Declared.check`."""
        least = self.consecutive + self.more
        require(
            self.most == 0 or self.most >= least,
            f"most is {self.most}; consecutive and more ask for {least} repetitions at least, so "
            f"{least} or more, or 0 for any number, is needed",
        )


@dataclass(frozen=True)
class Module:
    """An exercise to be mastered.

    Attributes
    ----------
    setting : str
        Empty: the exercise's first.
    name : str
        Of the module; by default the exercise's.
    needs : tuple of str
        Names of the modules that come before it.
    """

    exercise: str
    setting: str = ""
    name: str = ""
    needs: Tuple[str, ...] = ()
    proficient: Proficient = field(default_factory=Proficient)

    def __post_init__(self) -> None:
        require_text(self, "exercise")
        if self.needs:
            require_names(self, "needs")


@dataclass(frozen=True)
class ExamPart(Declared):
    """A trial in exam mode that has to be passed."""

    exercise: str = word(required, "Its name.")
    setting: str = parameter("", "Empty: the exercise's first.")
    repetitions: int = number(1, "That the trial has at least.", 1, 1000)
    faults: int = number(0, "Of them, those with a fault at most.", 0, 1000)

    def check(self) -> None:
        """Check what concerns several of them; see `Declared.check`."""
        require(
            self.faults < self.repetitions,
            f"faults is {self.faults}; of {self.repetitions} repetitions, fewer than that can be "
            "allowed to fail",
        )


@dataclass(frozen=True)
class Currency(Declared):
    """A skill that is lost without practice."""

    days: float = number(
        required, "For which a passed repetition counts.", maximum=36500.0, above=0.0
    )
    exercise: str = word(required, "In which it has to be.")
    setting: str = parameter("", "Of the exercise; empty: its first.")


@dataclass(frozen=True)
class Curriculum:
    """What is learned, in which order, and when it is mastered.

    Attributes
    ----------
    modules : tuple of Module
        In the order in which they are offered.
    """

    path: Path
    name: str
    title: str
    description: str
    modules: Tuple[Module, ...]
    exam: Tuple[ExamPart, ...] = ()
    currency: Optional[Currency] = None


_CATALOG = FileCatalog(
    "curriculum", PATH_VARIABLE, "telex_training", "curricula", SUFFIX, CurriculumError
)
curricula = _CATALOG.files
find_curriculum = _CATALOG.find
"""Raises a `CurriculumError`."""


def load_curriculum(path: Path) -> Curriculum:
    """Read a curriculum file.

    Raises
    ------
    CurriculumError
        ``FILE: where: what``.
    """
    return parse_curriculum(read_text_file(path, MOST_BYTES, CurriculumError), path)


def parse_curriculum(text: str, path: Path) -> Curriculum:
    """Read the text of a curriculum file.

    Parameters
    ----------
    path : Path
        Of the file: for messages, and for the name where it gives none.

    Raises
    ------
    CurriculumError
        ``FILE: where: what``.
    """
    try:
        content = read_yaml(text, MOST_BYTES)
        require(isinstance(content, Mapping), "a struct with the key 'modules' is needed")
        return _curriculum(content, path)
    except ConfigError as error:
        raise CurriculumError(f"{path}: {error}") from error


def _curriculum(content: Mapping[str, Any], path: Path) -> Curriculum:
    for key in content:
        require(key in KEYS, f"{key} is unknown; known are {', '.join(KEYS)}")

    def text(key: str, default: str = "") -> str:
        return " ".join(read_value(str, content.get(key, default), key).split())

    name = text("name", path.stem)
    require_name(name, "name")
    title = text("title", name.replace("_", " "))
    require_label(title, "title")
    require("modules" in content, "modules is missing; one module at least is needed")
    modules = _modules(content)
    currency = content.get("currency")
    return Curriculum(
        path=path,
        name=name,
        title=title,
        description=text("description"),
        modules=modules,
        exam=structs_of(content, "exam", ExamPart),
        currency=None if currency is None else read_struct(Currency, currency, "currency"),
    )


def _modules(content: Mapping[str, Any]) -> Tuple[Module, ...]:
    read = structs_of(content, "modules", Module)
    require(bool(read), "modules is []; one module at least is needed")
    found: Dict[str, Module] = {}
    for i, module in enumerate(read):
        name = module.name or Path(module.exercise).stem
        require_name(name, f"modules[{i}]/name")
        require(
            name not in found,
            f"modules[{i}]/name is '{name}'; another module has it already, so a name of its own "
            "is needed",
        )
        found[name] = Module(module.exercise, module.setting, name, module.needs, module.proficient)
    return tuple(found.values())
