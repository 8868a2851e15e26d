"""Base class of the library's types."""

from __future__ import annotations

from pathlib import Path
from typing import Tuple

from ..model import ObjectModel, SceneObject
from .parameters import Declared


class ObjectType(Declared):
    """Base of the library's types.

    A type is a frozen dataclass; its fields, declared by the functions of
    `telex_sim.scene.library.parameters`, are the parameters that a scene file may set. What
    concerns several of them is checked in `check`.
    """

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make the objects of one entry of a scene file.

        Parameters
        ----------
        folder : Path
            That relative addresses start from: the scene file's.

        Returns
        -------
        tuple of SceneObject
            Poses are relative to the entry's. Names are appended to the entry's with an
            underscore; the only object of an entry has the empty name.

        Raises
        ------
        ConfigError
            A parameter makes no sense; the message names it.
        """
        raise NotImplementedError


def single(model: ObjectModel) -> Tuple[SceneObject, ...]:
    """The answer of a type that makes one object."""
    return (SceneObject("", model),)
