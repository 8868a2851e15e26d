"""How the library's types declare their parameters, and what follows from a declaration."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import Optional, Tuple

import pytest

from telex_control.common.params import ConfigError, read_struct, require, required
from telex_sim.scene.library import object_types
from telex_sim.scene.library.object_type import ObjectType
from telex_sim.scene.library.parameters import (
    Declared,
    choice,
    kilograms,
    meaning,
    number,
    numbers,
    parameter,
    rgb,
)
from telex_sim.scene.model import Vector3
from telex_sim.scene.type_texts import parameters


@dataclass(frozen=True)
class Shelf(ObjectType):
    """A shelf."""

    gap: float = number(0.1, "Between boards (m).", 0.05, lambda own: 0.5 * own.height)
    height: float = number(1.0, "m.", 0.2, 3.0)
    boards: int = number(required, "How many.", 1)
    mass: Optional[float] = kilograms(None)
    size: Tuple[float, float] = numbers((1.0, 0.3), "Of a board (m).", 0.1, 2.0)
    color: Optional[Vector3] = rgb(None)
    mounting: str = choice("stand", ("stand", "wall", "rail"))
    label: str = parameter("", "Text on it.")

    def check(self) -> None:
        require(
            self.boards * self.gap <= self.height,
            f"boards is {self.boards}; at most {self.height / self.gap:g} fit",
        )


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({}, "boards is missing"),
        ({"boards": 0}, "boards is 0; it must be at least 1"),
        ({"boards": 11}, "boards is 11; at most 10 fit"),
        ({"boards": 1, "height": 5.0}, "height is 5.0; it must be at least 0.2 and at most 3"),
        ({"boards": 1, "gap": 0.6}, "gap is 0.6; it must be at least 0.05 and at most 0.5"),
        # Of two that are wrong the one that stands alone comes first: the other's limit hangs on it
        ({"boards": 1, "gap": 0.6, "height": 9.0}, "height is 9.0"),
        ({"boards": 1, "mass": 0}, "mass is 0.0; it must be above 0"),
        (
            {"boards": 1, "size": [1.0, 3.0]},
            "size[1] is 3.0; it must be at least 0.1 and at most 2",
        ),
        ({"boards": 1, "color": [0.0, 0.0, 1.5]}, "color[2] is 1.5; it must be at least 0"),
        ({"boards": 1, "mounting": "roof"}, "mounting is 'roof'; stand, wall, rail are possible"),
        ({"boards": 1, "label": 3}, "label is 3; a string is needed"),
    ],
)
def test_a_value_that_is_not_possible_is_refused(given, message):
    with pytest.raises(ConfigError) as refusal:
        read_struct(Shelf, given)
    assert str(refusal.value).startswith(message)


def test_values_that_no_file_can_hold_are_refused_too():
    for wrong in ({"height": math.nan}, {"mass": math.inf}, {"size": (0.5, math.nan)}):
        with pytest.raises(ConfigError, match=next(iter(wrong))):
            Shelf(boards=1, **wrong)


def test_another_default_leaves_the_limits_as_they_are():
    @dataclass(frozen=True)
    class Low(Shelf):
        height: float = 0.5

    assert Low(boards=2).height == 0.5
    for wrong in ({"height": 5.0}, {"gap": 0.6}):
        with pytest.raises(ConfigError, match=next(iter(wrong))):
            Low(boards=1, **wrong)


def test_what_is_left_out_has_its_default():
    shelf = read_struct(Shelf, {"boards": 2})
    assert (shelf.gap, shelf.mass, shelf.color, shelf.mounting) == (0.1, None, None, "stand")


def test_texts_come_from_the_declarations():
    assert parameters(Shelf) == [
        ("gap", "0.1", "float. Between boards (m)."),
        ("height", "1", "float. m."),
        ("boards", "required", "int. How many."),
        ("mass", "none", "float, optional. kg."),
        ("size", "[1, 0.3]", "tuple of 2 floats. Of a board (m)."),
        ("color", "none", "tuple of 3 floats, optional. Red, green, blue, 0 to 1."),
        ("mounting", "stand", "str. stand, wall or rail."),
        ("label", "''", "str. Text on it."),
    ]


@pytest.mark.parametrize("name", sorted(object_types()))
def test_every_type_declares_its_parameters(name):
    kind = object_types()[name]
    assert issubclass(kind, Declared)
    assert "__post_init__" not in vars(kind)
    for field in dataclasses.fields(kind):
        assert meaning(field), field.name
