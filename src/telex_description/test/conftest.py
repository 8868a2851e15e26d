"""The model that the tests of this package share."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from urdf_parser_py.urdf import URDF

HERE = Path(__file__).resolve().parent

if TYPE_CHECKING:
    from telex_cad.figures import Figures


@pytest.fixture(scope="module")
def figures() -> Figures:
    """What the generated model is made from."""
    from telex_cad.figures import read_figures

    return read_figures(HERE.parent / "config" / "robot.xacro")


@pytest.fixture(scope="module")
def robot() -> URDF:
    """The robot as it is shipped."""
    from shipped_robot import expanded

    return expanded()
