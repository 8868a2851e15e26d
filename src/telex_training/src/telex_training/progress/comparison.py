"""Two groups of people in one exercise: difference of medians, and of those who passed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Dict, List, Mapping, Optional, Sequence, Tuple

from ..judging.sheet import PASSED
from ..judging.stats import median
from .inference import Difference, difference_of_medians, fisher
from .trial_facts import TrialFacts

TIME = "time"


class ComparisonError(ValueError):
    """Two groups cannot be compared; the message says why and what would be right."""


@dataclass(frozen=True)
class GroupFigures:
    """A group in an exercise. A person counts once, for repetitions of one person are alike.

    Attributes
    ----------
    medians : dict of str to float
        By person: the median over the completed repetitions.
    repetitions : int
        Completed ones, of all of them.
    passed, failed : int
        People, by the verdict of their last valid trial that has one.
    without : tuple of str
        People of whom there is no completed repetition.
    """

    name: str
    medians: Dict[str, float]
    repetitions: int
    passed: int
    failed: int
    without: Tuple[str, ...]

    @property
    def median(self) -> Optional[float]:
        """Median of the people's medians."""
        return median(list(self.medians.values())) if self.medians else None


@dataclass(frozen=True)
class Comparison:
    """Two groups.

    Attributes
    ----------
    groups : tuple of GroupFigures
        The first and the second.
    difference : Difference or None
        Of the medians; None where a group has fewer than two people with figures.
    chance : float
        Of Fisher's exact test on who passed.
    """

    exercise: str
    setting: str
    metric: str
    unit: str
    groups: Tuple[GroupFigures, GroupFigures]
    difference: Optional[Difference]
    chance: float


def compare(
    trials: Sequence[TrialFacts],
    groups: Mapping[str, Sequence[str]],
    exercise: str,
    setting: str = "",
    metric: str = TIME,
    mode: str = "",
) -> Comparison:
    """Compare two groups of people.

    Parameters
    ----------
    trials : sequence of TrialFacts
        Of anybody, the oldest first.
    groups : mapping of str to sequence of str
        Two names, each with its people.
    exercise, setting : str
        An empty setting is the only one in which there are trials.
    metric : str
        Name of a metric of repetitions.
    mode : str
        Only trials in this mode; empty: all.

    Raises
    ------
    ComparisonError
    """
    if len(groups) != 2:
        raise ComparisonError(
            f"there are {len(groups)} groups; two with different names are needed"
        )
    first, second = groups
    both = sorted(set(groups[first]) & set(groups[second]))
    if both:
        raise ComparisonError(f"{', '.join(both)}: in both groups; one is needed")
    known = {trial.operator for trial in trials}
    for name, people in groups.items():
        missing = [person for person in people if person not in known]
        if missing or not people:
            raise ComparisonError(
                f"group {name} is {', '.join(missing) or 'empty'}; there are trials of: "
                f"{', '.join(sorted(known - {''})) or 'nobody'}"
            )
    found = [
        trial
        for trial in trials
        if trial.valid and trial.exercise == exercise and mode in ("", trial.mode)
    ]
    setting = _setting(found, exercise, setting)
    found = [trial for trial in found if trial.setting == setting]
    unit = _unit(found, metric)
    made = [_figures(name, people, found, metric) for name, people in groups.items()]
    one, other = made
    return Comparison(
        exercise,
        setting,
        metric,
        unit,
        (one, other),
        difference_of_medians(list(one.medians.values()), list(other.medians.values())),
        fisher((one.passed, other.passed), (one.failed, other.failed)),
    )


def _setting(found: Sequence[TrialFacts], exercise: str, setting: str) -> str:
    settings = sorted({trial.setting for trial in found})
    if not settings:
        raise ComparisonError(f"exercise is '{exercise}'; there is no valid trial of it")
    if not setting and len(settings) == 1:
        return settings[0]
    if setting not in settings:
        raise ComparisonError(f"setting is '{setting}'; there are trials in: {', '.join(settings)}")
    return setting


def _unit(found: Sequence[TrialFacts], metric: str) -> str:
    if metric == TIME:
        return "s"
    names: List[str] = []
    for trial in reversed(found):
        for each in trial.metrics:
            if each.name == metric and not each.of_trial:
                return each.unit
        for repetition in trial.repetitions:
            if metric in repetition.metrics:
                return ""
            names += [name for name in repetition.metrics if name not in names]
    raise ComparisonError(f"metric is '{metric}'; there are: {', '.join(sorted({TIME, *names}))}")


def _figures(
    name: str, people: Sequence[str], found: Sequence[TrialFacts], metric: str
) -> GroupFigures:
    medians: Dict[str, float] = {}
    count = 0
    last: Dict[str, str] = {}
    for person in people:
        own = [trial for trial in found if trial.operator == person]
        values = [
            each.time if metric == TIME else each.metrics.get(metric)
            for trial in own
            for each in trial.repetitions
            if each.completed
        ]
        measured = [value for value in values if value is not None]
        if measured:
            medians[person] = median(measured)
            count += len(measured)
        for trial in own:
            if trial.verdict:
                last[person] = trial.verdict
    passed = sum(verdict == PASSED for verdict in last.values())
    without = tuple(person for person in people if person not in medians)
    return GroupFigures(name, medians, count, passed, len(last) - passed, without)
