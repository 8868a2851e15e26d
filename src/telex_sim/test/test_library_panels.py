"""Places on the task panels, as their objects tell them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from telex_sim.scene.library.tasks.mounts import PLATE
from telex_sim.scene.library.tasks.panels import InspectionPipes


def test_pipes_of_a_row_open_side_by_side_towards_who_stands_before_them() -> None:
    mouths = InspectionPipes(layout="row", length=0.3, height=0.8).mouths()
    for (place, axis), across in zip(mouths, (-0.24, -0.12, 0.0, 0.12, 0.24)):
        assert place == pytest.approx((-PLATE - 0.3, across, 0.8))
        assert axis == pytest.approx((-1.0, 0.0, 0.0), abs=1e-9)
    assert len(mouths) == 5


def test_pipes_of_a_star_lean_outwards_by_45_degrees_from_the_middle_one() -> None:
    first, *others = InspectionPipes(layout="star", length=0.6, height=0.8).mouths()
    assert first[0] == pytest.approx((-PLATE - 0.06 - 0.6, 0.0, 0.8))
    slant = math.sqrt(0.5)
    for (place, axis), (aside, up) in zip(others, ((0, 1), (1, 0), (0, -1), (-1, 0))):
        assert axis == pytest.approx((-slant, aside * slant, up * slant), abs=1e-9)
        # The mouth lies outwards, as far as the pipe is long.
        from_middle = np.subtract(place, (-PLATE, 0.0, 0.8))
        assert from_middle @ np.array(axis) == pytest.approx(0.6 + 0.08 * slant, abs=1e-9)
