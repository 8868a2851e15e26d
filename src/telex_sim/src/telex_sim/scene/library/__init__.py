"""The objects that scene files name by their type.

Every module in a room of this package that has a dict ``TYPES`` adds to them; nothing else needs to
know of a new module::

    @dataclass(frozen=True)
    class Crate(ObjectType):
        \"\"\"A wooden crate.

        ... and what `size` and `mass` are, in the section Attributes ...
        \"\"\"

        size: Vector3 = (0.4, 0.3, 0.3)
        mass: float = 8.0

        def __post_init__(self) -> None:
            require_range(self, "mass", above=0.0)

        def build(self, folder: Path) -> Tuple[SceneObject, ...]: ...


    TYPES = {"crate": Crate}

Rules:

* A key of ``TYPES`` is the type's name in scene files: lower case, words joined by underscores.
* Fields may be of the types that `telex_control.common.params` reads: float, int, str, bool,
  tuple, dict, Optional, and frozen dataclasses of these. None may have a name that every entry has
  already: `RESERVED`. A field without a default must be given.
* The first line of the docstring and its section ``Attributes`` are what ``scene types`` prints;
  say the unit there.
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

RESERVED = ("type", "name", "position", "yaw", "rpy")
"""Keys that every entry of a scene file may have, whatever its type."""


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
