"""The report of a person, which is the trainee's own page as well."""

from __future__ import annotations

from html import escape
from typing import Sequence, Tuple

from ...judging.stats import CONFIDENCE, FEWEST_FOR_LEARNING
from ..curriculum_file import Curriculum
from ..skill import ACCEPTABLE, UNACCEPTABLE, Skill, Weakness, decision, skills
from ..standing import LOCKED, OPEN, PROFICIENT, SPENT, WORKING, ModuleStanding, Standing, standing
from ..trial_facts import TrialFacts
from .report_pieces import (
    MARKS,
    NOBODY,
    NONE,
    count,
    day,
    exam_mark,
    figure,
    heading,
    lead,
    number,
    page,
    percent,
    table,
    workload,
)
from .svg_figures import cusum_figure, learning_figure

_MOST_TRIALS = 100


def person_report(
    name: str,
    trials: Sequence[TrialFacts],
    courses: Sequence[Curriculum],
    now: float,
    script: str = "",
) -> str:
    """Make the report of a person, which is the trainee's own page as well.

    Parameters
    ----------
    trials : sequence of TrialFacts
        That person's, the oldest first.
    courses : sequence of Curriculum
        Those that were begun are shown; the first one, if none was.
    now : float
        Wall time (s since the epoch).
    script : str
        Address of a module that the page is to have; empty: it needs nothing beside itself.
    """
    shown = name or NOBODY
    parts = [f"<h1>{escape(shown)}</h1>", lead(trials, now)]
    stands = [standing(course, trials, now) for course in courses]
    for each in [each for each in stands if each.begun] or stands[:1]:
        parts += [f"<h2>{escape(each.curriculum.title)}</h2>", _due(each), _modules(each)]
    for skill in reversed(skills(trials)):
        parts.append(_skill(skill))
    if trials:
        parts += ["<h2>Trials</h2>", _trials(trials)]
    return page(f"Progress of {shown}", parts, script)


def _due(each: Standing) -> str:
    if not each.due:
        done = "Nothing is due: all modules are mastered"
        done += ", the exam is passed" if each.exam else ""
        if each.current_until is not None:
            done += f"; to be shown again by {day(each.current_until)}"
        return f'<p class="ok">{escape(done)}.</p>'
    items = "".join(f"<li>{escape(text)}</li>" for text in each.due)
    return f'<h3>Due</h3><ul class="due">{items}</ul>'


def _modules(each: Standing) -> str:
    rows = []
    for one in each.modules:
        module = one.module
        rows.append(
            [
                f"<span>{MARKS[one.state]}</span> {escape(module.name)}",
                escape(f"{module.exercise}, {module.setting}".rstrip(", ")),
                escape(_state(one)),
                _credit(one),
            ]
        )
    for exam in each.exam:
        part = exam.part
        rows.append(
            [
                f"<span>{exam_mark(each, exam)}</span> exam",
                escape(f"{part.exercise}, {part.setting}".rstrip(", ")),
                f"passed: {escape(exam.passed)}" if exam.passed else "not passed",
                count(exam.tries, "try", "tries")
                + (f", {exam.unsigned} without a valid signature" if exam.unsigned else ""),
            ]
        )
    return table(["module", "exercise", "state", "passed"], rows, text=(1, 2))


def _state(one: ModuleStanding) -> str:
    if one.state == LOCKED:
        return f"after {', '.join(one.module.needs)}"
    if one.state == SPENT:
        return f"not mastered within {one.module.proficient.most} repetitions"
    if one.state == PROFICIENT:
        return f"mastered with {count(one.credit.used, 'repetition')}"
    return {WORKING: "begun", OPEN: "not begun"}[one.state]


def _credit(one: ModuleStanding) -> str:
    rule, own = one.module.proficient, one.credit
    text = f"{own.row} of {rule.consecutive} in a row"
    return text + (f", {own.more} of {rule.more} more" if rule.more else "")


def _skill(skill: Skill) -> str:
    head = heading(skill)
    if not skill.repetitions:
        return f"{head}<p>{count(skill.invalid, 'trial')}, none of them with a valid repetition</p>"
    rows = [
        [
            "repetitions",
            f"n = {len(skill.repetitions)}",
            f"{len(skill.times)} completed, {skill.passed} passed",
        ],
        ["reliability", *_bound(skill)],
        [
            "proficiency",
            percent(skill.proficiency),
            "rate of the last repetitions to the expert's"
            + (" (provisional: a script's)" if skill.provisional else ""),
        ],
        ["best", number(skill.best, "s"), "with penalties"],
        ["tenth next", *_forecast(skill)],
        ["failures", _verdict(skill), _rates()],
    ]
    if skill.workloads:
        rows.append(["workload", workload(skill), "NASA-TLX, unweighted, of 100; median"])
    for place, weak in enumerate(skill.weakest, 1):
        rows.append([f"weakest metric {place}", *_weak(weak)])
    figures = []
    if skill.times:
        with_curve = " and learning curve with its band" if skill.curve else ""
        caption = f"Times{with_curve}, n = {len(skill.times)}"
        figures.append(figure(learning_figure(skill.times, skill.curve, skill.expert), caption))
    figures.append(
        figure(
            cusum_figure(skill.cusum),
            f"CUSUM of failures, n = {len(skill.repetitions)}; down: good",
        )
    )
    shown = table(["", "", ""], rows, text=(2,), head=False)
    drawn = f'<div class="figures">{"".join(figures)}</div>'
    return f'<section class="skill">{head}{shown}{drawn}</section>'


def _bound(skill: Skill) -> Tuple[str, str]:
    faults = count(skill.recent_faults, "fault")
    return (
        f"≥ {percent(skill.reliability)}",
        f"lower bound of the share of completed repetitions, {100 * CONFIDENCE:.0f} % sure; "
        f"last n = {skill.recent} with {faults}",
    )


def _forecast(skill: Skill) -> Tuple[str, str]:
    if skill.curve is None:
        return (
            NONE,
            f"from {FEWEST_FOR_LEARNING} completed repetitions on; there are {len(skill.times)}",
        )
    last = skill.curve[-1]
    return (
        f"{last.expected:.0f} s ({last.low:.0f} to {last.high:.0f} s)",
        f"repetition {last.number} by the learning curve; {100 * CONFIDENCE:.0f} % band",
    )


def _verdict(skill: Skill) -> str:
    found = decision(skill.cusum)
    if not found:
        return "not decided yet"
    kind = "ok" if found == "acceptable" else "bad"
    return f'<span class="{kind}">{found}</span>'


def _rates() -> str:
    return (
        f"CUSUM: at most {100 * ACCEPTABLE:.0f} % are acceptable, "
        f"{100 * UNACCEPTABLE:.0f} % are not"
    )


def _weak(weak: Weakness) -> Tuple[str, str]:
    metric = weak.metric
    sign = "≥" if metric.more_is_better else "≤"
    missed = f"beyond its bound {weak.missed} of {weak.count}"
    if weak.missed:
        missed = f'<span class="bad">{missed}</span>'
    # The text is a node of its own, for what translates the page.
    bound = f"({escape(metric.name)}): {sign} {number(metric.bound, metric.unit)}"
    return missed, f"<span>{escape(metric.text)}</span> {bound}"


def _trials(trials: Sequence[TrialFacts]) -> str:
    rows = []
    for trial in reversed(trials[-_MOST_TRIALS:]):
        verdict = "no verdict" if trial.valid else "invalid"
        if trial.valid and trial.verdict:
            kind = "ok" if trial.passed else "bad"
            verdict = f'<span class="{kind}">{escape(trial.verdict)}</span>'
        rows.append(
            [
                day(trial.began, clock=True),
                escape(trial.title or trial.exercise),
                escape(trial.setting),
                escape(f"{trial.mode}, {trial.flaw}" if trial.flaw else trial.mode),
                str(len(trial.repetitions)),
                str(trial.faults),
                verdict,
                _marked(trial),
                number(trial.raw_workload, ""),
            ]
        )
    heads = ["began", "exercise", "setting", "mode", "n", "faults", "verdict", "mark", "workload"]
    shown = table(heads, rows, text=(7,))
    left = len(trials) - len(rows)
    return shown + (f'<p class="dim">and {left} older ones</p>' if left else "")


def _marked(trial: TrialFacts) -> str:
    """Say how an instructor has marked a trial last, and why."""
    if not trial.marks:
        return NONE
    last = trial.marks[-1]
    return escape(f"{last.verdict}: {last.reason}")
