"""Scripted experts do the exercises of driving, and the judge lets them pass."""

from __future__ import annotations

import pytest
from expert_passes import pass_exercise

from telex_training.operators.experts import driving_exercises
from telex_training.operators.experts.catalog import EXPERTS

pytestmark = pytest.mark.slow

NAMES = sorted(
    name for name, expert in EXPERTS.items() if expert.__module__ == driving_exercises.__name__
)


@pytest.mark.parametrize("name", NAMES)
def test_an_expert_passes_its_exercise(name: str) -> None:
    pass_exercise(name)
