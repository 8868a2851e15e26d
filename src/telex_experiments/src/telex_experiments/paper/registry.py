"""List of the experiments, in the order of the paper."""

from __future__ import annotations

import importlib
from typing import List, Sequence, Tuple

from .experiment import Experiment

MODULES: Tuple[str, ...] = (
    "telex_experiments.paper.experiments.accuracy",
    "telex_experiments.paper.experiments.kinematics",
    "telex_experiments.paper.experiments.model",
    "telex_experiments.paper.experiments.step_response",
    "telex_experiments.paper.experiments.lockstep",
    "telex_experiments.paper.experiments.trajectory",
    "telex_experiments.paper.tasks",
    "telex_experiments.paper.experiments.views",
    "telex_experiments.paper.experiments.outlook",
)
"""Each has its EXPERIMENTS."""


class UnknownExperimentError(ValueError):
    """There is none of that name; the message says which there are."""


def experiments() -> List[Experiment]:
    """Return all experiments.

    Raises
    ------
    ValueError
        Two have one name.
    """
    found = [each for name in MODULES for each in importlib.import_module(name).EXPERIMENTS]
    names = [each.name for each in found]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise ValueError(f"several experiments are called {', '.join(twice)}")
    return found


def by_name(name: str) -> Experiment:
    """Return the experiment of a name."""
    return next(each for each in experiments() if each.name == name)


def select(names: Sequence[str]) -> List[Experiment]:
    """Return the experiments, in their order, that names or names of groups mean; all for none.

    Raises
    ------
    UnknownExperimentError
    """
    found = experiments()
    for name in names:
        if not any(each.called(name) for each in found):
            groups = sorted({group for each in found for group in each.groups})
            known = ", ".join([*(each.name for each in found), *groups])
            raise UnknownExperimentError(f"there is no experiment '{name}'; there are {known}")
    return [each for each in found if not names or any(each.called(name) for name in names)]
