"""Figures of a scripted expert, the mean and the spread of several runs, and where a file has them.

Every ``expert: [mean, sd]`` under an exercise's metrics is measured anew; for a new one, write
``expert: [0, 0]`` where it is to stand.
"""

from __future__ import annotations

import statistics
from dataclasses import dataclass, replace
from typing import Any, Callable, Dict, Iterable, Iterator, List, Mapping, Optional, Sequence, Tuple

import yaml

from ..exercises.conditions import ROBOT
from ..exercises.exercise_file import ExerciseFile
from ..exercises.model import Exercise, Vary
from ..judging.sheet import PASSED, why_not_passed
from ..operators.experts.brief import Expert
from ..operators.port import NotManagedError
from .trial import rehearse

Figure = Tuple[float, float]
"""Mean and standard deviation."""

LEAST_RUNS = 2
"""From which on there is a standard deviation."""
DIGITS = 4
"""Of a mean."""
PLACED = Vary(ROBOT, (0.02, 0.02, 0.0), 0.02)
"""How well people put a robot to its start (m, rad): what differs from run to run where a seed
moves nothing else."""


class FiguresError(Exception):
    """No figures can be made; the message says why."""


@dataclass(frozen=True)
class Place:
    """Where a figure stands in an exercise's file.

    Attributes
    ----------
    setting : str
        In which it is measured.
    begin, end : int
        Of its list, in the text.
    """

    setting: str
    metric: str
    begin: int
    end: int


def spread(exercise: Exercise) -> Exercise:
    """Return an exercise in which runs of different seeds differ."""
    return exercise if exercise.vary else replace(exercise, vary=(PLACED,))


def measured(
    exercise: Exercise,
    expert: Expert,
    seeds: Sequence[int],
    done: Callable[[Dict[str, Any]], None] = lambda sheet: None,
) -> Dict[str, Figure]:
    """Let an expert do one repetition for each seed.

    Parameters
    ----------
    exercise : Exercise
        In one of its settings.
    expert : callable
    seeds : sequence of int
        At least two.
    done : callable, optional
        Told the sheet of each run.

    Returns
    -------
    dict
        Mean and sample standard deviation, by the metrics' names; of those that every run has.

    Raises
    ------
    FiguresError
        The seeds are too few, or the expert did not pass with one of them.
    """
    if len(seeds) < LEAST_RUNS:
        raise FiguresError(f"{len(seeds)} runs; at least {LEAST_RUNS} have a standard deviation")
    values: Dict[str, List[float]] = {}
    for seed in seeds:
        where = f"{exercise.name}, setting {exercise.setting!r}, seed {seed}"
        try:
            sheet = rehearse(spread(exercise), expert, seed)
        except NotManagedError as error:
            raise FiguresError(f"{where}: the expert gave up: {error}") from error
        if sheet["verdict"] != PASSED:
            raise FiguresError(f"{where}: the expert did not pass: {why_not_passed(sheet)}")
        done(sheet)
        for metric in sheet["metrics"]:
            if metric["value"] is not None:
                values.setdefault(metric["name"], []).append(metric["value"])
    return {
        name: (statistics.mean(each), statistics.stdev(each))
        for name, each in values.items()
        if len(each) == len(seeds)
    }


def places(file: ExerciseFile) -> List[Place]:
    """Find the figures in an exercise's text.

    One that stands above the settings is measured in the first that has none of its own.
    """
    root = yaml.compose(file.text, Loader=yaml.SafeLoader)
    found: List[Place] = []
    own = set()
    names = list(file.settings)
    settings = _child(root, "settings")
    for name, node in zip(names, [] if settings is None else settings.value):
        for metric, figure in _figures(node):
            own.add((name, metric))
            found.append(Place(name, metric, figure.start_mark.index, figure.end_mark.index))
    for metric, figure in _figures(root):
        for name in names:
            if (name, metric) not in own:
                found.append(Place(name, metric, figure.start_mark.index, figure.end_mark.index))
                break
    return found


def _child(node: Optional[yaml.Node], key: str) -> Optional[yaml.Node]:
    if not isinstance(node, yaml.MappingNode):
        return None
    return next((value for name, value in node.value if name.value == key), None)


def _figures(node: yaml.Node) -> Iterator[Tuple[str, yaml.Node]]:
    metrics = _child(node, "metrics")
    if isinstance(metrics, yaml.MappingNode):
        for name, content in metrics.value:
            figure = _child(content, "expert")
            if isinstance(figure, yaml.SequenceNode):
                yield name.value, figure


def with_figures(
    text: str, where: Iterable[Place], figures: Mapping[str, Mapping[str, Figure]], runs: int
) -> str:
    """Put figures into an exercise's text, and of how many runs they are.

    Parameters
    ----------
    figures : mapping
        By setting and metric.

    Raises
    ------
    FiguresError
        A figure has no value, or the text does not say how many repetitions they are of.
    """
    changes: List[Tuple[int, int, str]] = []
    for place in where:
        figure = figures[place.setting].get(place.metric)
        if figure is None:
            raise FiguresError(f"{place.metric} has no value in setting {place.setting!r}")
        changes.append((place.begin, place.end, _written(figure)))
    count = _child(_child(yaml.compose(text, Loader=yaml.SafeLoader), "expert"), "repetitions")
    if count is None:
        raise FiguresError("expert/repetitions is missing: nothing says of how many runs they are")
    changes.append((count.start_mark.index, count.end_mark.index, str(runs)))
    for begin, end, put in sorted(changes, reverse=True):
        text = text[:begin] + put + text[end:]
    return text


def _written(figure: Figure) -> str:
    mean, deviation = figure
    return f"[{float(f'{mean:.{DIGITS}g}')}, {float(f'{deviation:.2g}')}]"
