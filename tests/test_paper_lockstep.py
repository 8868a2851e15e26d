"""Figure 8 in lockstep: the same joint states, whoever else has the processors."""

from __future__ import annotations

from dataclasses import replace

import pytest

from telex_control.follow_trajectory.analysis import TrackingFigures
from telex_experiments.paper.experiments.lockstep import Led, bars, follow, hogs
from telex_experiments.paper.experiments.trajectory import LARGEST, RMS, ToolPath

pytestmark = pytest.mark.slow

PIECE = ToolPath("circle", "A piece", ("--circle", "--here", "--radius", "0.05", "--turns", "0.2"))
NONE = (0.0, 0.0, 0.0)
GOOD = Led(TrackingFigures(5e-4, 2e-3, NONE, NONE, 0.0, 1.0, 20.0), "a")


def test_runs_are_equal_beside_what_keeps_all_processors_busy(tmp_path):
    alone = follow(PIECE, tmp_path)
    assert 1e3 * alone.figures.rms <= RMS
    assert 1e3 * alone.figures.largest <= LARGEST
    assert (tmp_path / "circle.svg").is_file()
    with hogs():
        assert follow(PIECE, tmp_path) == alone


@pytest.mark.parametrize(
    ("second", "met"),
    [
        (GOOD, True),
        (replace(GOOD, digest="b"), False),
        (replace(GOOD, figures=replace(GOOD.figures, largest=4e-3)), False),
    ],
)
def test_the_worst_run_counts_and_all_have_to_be_equal(second, met):
    assert all(figure.ok for figure in bars({"Circle": [GOOD, second]})) == met
