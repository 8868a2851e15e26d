"""A person's standing in a curriculum, and what is due."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Dict, List, Optional, Sequence, Tuple

from ..exercises.catalog import find_exercise
from ..exercises.exercise_file import ExerciseError, load_exercise
from ..exercises.model import EXAM
from .curriculum_file import Currency, Curriculum, ExamPart, Module, Proficient
from .trial_facts import RepetitionFacts, TrialFacts

PROFICIENT, WORKING, OPEN, LOCKED, SPENT = "proficient", "working", "open", "locked", "spent"
"""Of a module: mastered; begun; not begun; behind others that are not mastered; the most
repetitions are done without."""
DAY = 86400.0


@dataclass(frozen=True)
class Credit:
    """What repetitions count for, see `Proficient`.

    Attributes
    ----------
    row : int
        Passed in a row, now; as many as are asked for, once they were reached.
    more : int
        Passed since then.
    used : int
        Repetitions, up to the one with which it was mastered.
    """

    row: int
    more: int
    used: int
    mastered: bool


def credit(passed: Sequence[bool], rule: Proficient) -> Credit:
    """Count passed repetitions by a rule.

    Parameters
    ----------
    passed : sequence of bool
        Of each repetition, the oldest first.
    """
    row = more = used = 0
    for each in passed[: rule.most or None]:
        used += 1
        if row >= rule.consecutive:
            more += each
        else:
            row = row + 1 if each else 0
        if row >= rule.consecutive and more >= rule.more:
            return Credit(row, more, used, True)
    return Credit(row, more, used, False)


@dataclass(frozen=True)
class ModuleStanding:
    """A person in a module.

    Attributes
    ----------
    state : str
        See `PROFICIENT`.
    """

    module: Module
    state: str
    credit: Credit


@dataclass(frozen=True)
class ExamStanding:
    """A person in a part of an exam.

    Attributes
    ----------
    tries : int
        Exams that are valid.
    passed : str
        The trial that passed it; empty: none yet.
    unsigned : int
        Trials in exam mode without a signature that counts.
    """

    part: ExamPart
    tries: int
    passed: str
    unsigned: int


@dataclass(frozen=True)
class Standing:
    """A person in a curriculum.

    Attributes
    ----------
    begun : bool
        Whether there is any trial of its exercises.
    current_until : float or None
        Wall time up to which the skill of ``currency`` counts (s since the epoch); None: there is
        no such skill, or it was never shown.
    due : tuple of str
        What comes next, for people.
    """

    curriculum: Curriculum
    begun: bool
    modules: Tuple[ModuleStanding, ...]
    exam: Tuple[ExamStanding, ...]
    current_until: Optional[float]
    due: Tuple[str, ...]


def standing(curriculum: Curriculum, trials: Sequence[TrialFacts], now: float) -> Standing:
    """Say where somebody stands in a curriculum.

    Only valid trials count, in practice and exam alike; an exam's parts want one in exam mode, with
    a signature of a known station.

    Parameters
    ----------
    trials : sequence of TrialFacts
        One person's, the oldest first.
    now : float
        Wall time (s since the epoch).
    """
    valid = [trial for trial in trials if trial.valid]
    modules = _modules(curriculum, valid)
    exam = tuple(_exam(part, valid) for part in curriculum.exam)
    until = None if curriculum.currency is None else _current_until(curriculum.currency, valid)
    named = [(each.exercise, each.setting) for each in curriculum.modules]
    named += [(each.exercise, each.setting) for each in curriculum.exam]
    begun = any(_of(valid, exercise, setting) for exercise, setting in named)
    return Standing(
        curriculum,
        begun,
        modules,
        exam,
        until,
        tuple(_due(curriculum, modules, exam, until, now)),
    )


def _modules(curriculum: Curriculum, valid: Sequence[TrialFacts]) -> Tuple[ModuleStanding, ...]:
    earned: Dict[str, Credit] = {}
    done: Dict[str, int] = {}
    for module in curriculum.modules:
        passed = [each.passed for each in _repetitions(valid, module.exercise, module.setting)]
        earned[module.name] = credit(passed, module.proficient)
        done[module.name] = len(passed)
    made = []
    for module in curriculum.modules:
        own, most = earned[module.name], module.proficient.most
        needed = [earned[need].mastered for need in module.needs if need in earned]
        if own.mastered:
            state = PROFICIENT
        elif len(needed) < len(module.needs) or not all(needed):
            state = LOCKED
        elif most and own.used >= most:
            state = SPENT
        else:
            state = WORKING if done[module.name] else OPEN
        made.append(ModuleStanding(module, state, own))
    return tuple(made)


def _exam(part: ExamPart, valid: Sequence[TrialFacts]) -> ExamStanding:
    done = [trial for trial in _of(valid, part.exercise, part.setting) if trial.mode == EXAM]
    tries = [trial for trial in done if trial.in_exam]
    passed = next(
        (
            trial.trial
            for trial in tries
            if trial.passed
            and len(trial.repetitions) >= part.repetitions
            and trial.faults <= part.faults
        ),
        "",
    )
    return ExamStanding(part, len(tries), passed, len(done) - len(tries))


def _current_until(currency: Currency, valid: Sequence[TrialFacts]) -> Optional[float]:
    shown = [
        trial.began
        for trial in _of(valid, currency.exercise, currency.setting)
        if any(each.passed for each in trial.repetitions)
    ]
    return shown[-1] + currency.days * DAY if shown else None


def _due(
    curriculum: Curriculum,
    modules: Sequence[ModuleStanding],
    exam: Sequence[ExamStanding],
    until: Optional[float],
    now: float,
) -> List[str]:
    due = []
    currency = curriculum.currency
    if currency is not None and until is not None and now > until:
        days = int((now - until) / DAY) + 1
        due.append(
            f"{_called(currency.exercise, currency.setting)}: again, a passed repetition; the "
            f"last one counted for {currency.days:g} days, which ended {_days(days)} ago"
        )
    for each in modules:
        if each.state in (OPEN, WORKING):
            due.append(f"{_called(each.module.exercise, each.module.setting)}: {_left(each)}")
        elif each.state == SPENT:
            due.append(
                f"{_called(each.module.exercise, each.module.setting)}: talk to the instructor; "
                f"{each.credit.used} repetitions are done, and not more count"
            )
    if all(each.state == PROFICIENT for each in modules):
        due += [
            f"exam in {_called(each.part.exercise, each.part.setting)}: "
            f"{each.part.repetitions} repetitions, of them at most {each.part.faults} with a fault"
            for each in exam
            if not each.passed
        ]
    return due


def _left(each: ModuleStanding) -> str:
    """What is missing to a module."""
    rule, own = each.module.proficient, each.credit
    parts = []
    if own.row < rule.consecutive:
        parts.append(f"{rule.consecutive - own.row} passed in a row")
        if own.row:
            parts[0] = f"{rule.consecutive - own.row} more passed in a row, after {own.row}"
    if rule.more > own.more:
        parts.append(f"{rule.more - own.more} more passed")
    text = ", then ".join(parts)
    if rule.most:
        text += f"; {rule.most - own.used} of {rule.most} repetitions are left"
    return text


def _days(days: int) -> str:
    return f"{days} day{'' if days == 1 else 's'}"


def _called(exercise: str, setting: str) -> str:
    return f"{exercise}, {setting}" if setting else exercise


def _of(trials: Sequence[TrialFacts], exercise: str, setting: str) -> List[TrialFacts]:
    wanted = setting or _first_setting(exercise)
    return [trial for trial in trials if trial.exercise == exercise and trial.setting == wanted]


def _repetitions(
    trials: Sequence[TrialFacts], exercise: str, setting: str
) -> List[RepetitionFacts]:
    return [each for trial in _of(trials, exercise, setting) for each in trial.repetitions]


def _first_setting(exercise: str) -> str:
    """Setting that counts where none is named; empty: there is no such exercise."""
    try:
        return load_exercise(find_exercise(exercise)).first.setting
    except ExerciseError:
        return ""
