"""The objects that scene files name by their type.

Every module in a room of this package that has a dict ``TYPES`` adds to them; nothing else needs to
know of a new module::

    @dataclass(frozen=True)
    class Crate(ObjectType):
        \"\"\"A wooden crate.\"\"\"

        size: Vector3 = numbers((0.4, 0.3, 0.3), "Full extents (m).", 0.05, 5.0)
        mass: float = kilograms(8.0)

        def build(self, folder: Path) -> Tuple[SceneObject, ...]: ...


    TYPES = {"crate": Crate}

Rules:

* A key of ``TYPES`` is the type's name in scene files: lower case, words joined by underscores.
* Fields may be of the types that `telex_control.common.params` reads: float, int, str, bool,
  tuple, dict, Optional, and frozen dataclasses of these. None may have a name that every entry has
  already: `RESERVED`.
* Each is declared by a function of `telex_sim.scene.library.parameters`: its default, or
  `telex_control.common.params.required`, its meaning with the unit, and what is possible.
* What several fields must satisfy together is checked in the method `check`, by
  `telex_control.common.params.require`.
* The first line of the docstring and the meanings of the fields are what ``scene types`` prints.
* A relative address (mesh, texture) goes through `telex_sim.scene.addresses.absolute`, with
  `folder`.
"""

from __future__ import annotations

import dataclasses
import importlib
import pkgutil
from functools import lru_cache
from typing import Dict, Type

from .object_type import ObjectType

RESERVED = ("type", "name", "position", "yaw", "rpy", "shield", "source")
"""Keys that every entry of a scene file may have, whatever its type."""
_NEED_PARAMETERS = ("custom", "mesh")


@lru_cache(maxsize=None)
def object_types() -> Dict[str, Type[ObjectType]]:
    """All types by their name in scene files, in alphabetical order.

    Raises
    ------
    TypeError
        A module breaks the rules above.
    """
    found: Dict[str, Type[ObjectType]] = {}
    for module in pkgutil.walk_packages(__path__, f"{__name__}."):
        offered = getattr(importlib.import_module(module.name), "TYPES", {})
        for name, kind in offered.items():
            if name in found:
                raise TypeError(f"{module.name}: type '{name}' exists already")
            taken = {field.name for field in dataclasses.fields(kind)} & set(RESERVED)
            if taken:
                raise TypeError(f"{module.name}: '{name}' has the reserved field {sorted(taken)}")
            found[name] = kind
    return dict(sorted(found.items()))


def types_by_name() -> Dict[str, Type[ObjectType]]:
    """Types that are something by their name alone, in alphabetical order."""
    return {name: kind for name, kind in object_types().items() if name not in _NEED_PARAMETERS}
