"""Reports of several people: a class, and two groups."""

from __future__ import annotations

from html import escape
from typing import Dict, List, Mapping, Sequence, Tuple

from ...judging.stats import CONFIDENCE
from ..comparison import TIME, Comparison
from ..curriculum_file import Curriculum
from ..inference import GROUP_CONFIDENCE
from ..skill import Skill, skills
from ..standing import WORKING, ModuleStanding, Standing, standing
from ..trial_facts import TrialFacts
from .report_pieces import (
    MARKS,
    NOBODY,
    NONE,
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
from .svg_figures import strip_figure


def class_report(
    people: Mapping[str, Sequence[TrialFacts]],
    courses: Sequence[Curriculum],
    now: float,
    title: str = "Class",
    script: str = "",
) -> str:
    """Make the report of several people.

    Parameters
    ----------
    people : mapping of str to sequence of TrialFacts
        By name, each the oldest first.
    courses : sequence of Curriculum
        Those that somebody has begun are shown.
    now : float
        Wall time (s since the epoch).
    script : str
        Address of a module that the page is to have; empty: it needs nothing beside itself.
    """
    every = sorted((each for own in people.values() for each in own), key=lambda each: each.began)
    parts = [f"<h1>{escape(title)}</h1>", lead(every, now, len(people))]
    for course in courses:
        stands = {name: standing(course, own, now) for name, own in people.items()}
        if any(each.begun for each in stands.values()):
            parts.append(_course(course, stands))
    found: Dict[Tuple[str, str], List[Skill]] = {}
    for own in people.values():
        for skill in skills(own):
            found.setdefault((skill.exercise, skill.setting), []).append(skill)
    for key in sorted(found):
        parts.append(_exercise(found[key]))
    return page(title, parts, script)


def comparison_report(made: Comparison) -> str:
    """Make the report of two groups."""
    metric = "time of a repetition" if made.metric == TIME else made.metric
    rows = [
        [
            escape(group.name),
            str(len(group.medians)),
            str(group.repetitions),
            number(group.median, made.unit),
            f"{group.passed} of {group.passed + group.failed}",
        ]
        for group in made.groups
    ]
    heads = ["group", "n people", "n repetitions", "median", "passed"]
    parts = [
        f"<h1>{escape(' and '.join(group.name for group in made.groups))}</h1>",
        f'<p class="dim">{escape(made.exercise)}, {escape(made.setting)}: {escape(metric)}</p>',
        table(heads, rows),
        *(f"<p>{escape(line)}</p>" for line in comparison_lines(made)),
    ]
    for group in made.groups:
        if group.medians:
            rows_of = [(name, [value]) for name, value in sorted(group.medians.items())]
            caption = f"{group.name}: median of each person, n = {len(rows_of)}"
            parts.append(figure(strip_figure(rows_of, made.unit or metric), caption))
    return page("Two groups", parts)


def comparison_lines(made: Comparison) -> List[str]:
    """Say in words what a comparison found, with n beside each figure."""
    first, second = made.groups
    numbers = f"n = {len(first.medians)} and {len(second.medians)} people"
    lines = []
    if made.difference is None:
        lines.append(f"Difference of the medians: none; two people a group are needed ({numbers}).")
    else:
        found, unit = made.difference, f" {made.unit}" if made.unit else ""
        lines.append(
            f"Difference of the medians, {second.name} less {first.name}: "
            f"{found.value:+.3g}{unit}; "
            f"{100 * GROUP_CONFIDENCE:.0f} % interval {found.low:+.3g} to {found.high:+.3g}{unit} "
            f"(bootstrap; {numbers})."
        )
    tested = (first.passed + first.failed, second.passed + second.failed)
    if min(tested) == 0:
        lines.append(
            f"Passed: no test; both groups need verdicts (n = {tested[0]} and {tested[1]} people)."
        )
    else:
        lines.append(
            f"Passed: {first.passed} of {tested[0]} and {second.passed} of {tested[1]} people; "
            f"Fisher's exact test, two-sided: p = {made.chance:.3g} "
            f"(n = {tested[0]} and {tested[1]})."
        )
    for group in made.groups:
        if group.without:
            lines.append(
                f"{group.name}: no completed repetition of {', '.join(sorted(group.without))}."
            )
    return lines


def _course(course: Curriculum, stands: Dict[str, Standing]) -> str:
    heads = ["", *(escape(module.name) for module in course.modules)]
    heads += [f"exam {i}" for i, _ in enumerate(course.exam, 1)]
    rows = []
    for name, each in stands.items():
        cells = [_mark(one) for one in each.modules]
        cells += [exam_mark(each, exam) for exam in each.exam]
        rows.append([escape(name or NOBODY), *cells])
    legend = (
        "● mastered · ◐ begun, with passed repetitions · ○ open · - after others · "
        "! too many repetitions"
    )
    return (
        f"<h2>{escape(course.title)}</h2>"
        + table(heads, rows, mark=tuple(range(1, len(heads))))
        + f'<p class="dim">{legend}</p>'
    )


def _mark(one: ModuleStanding) -> str:
    text = MARKS[one.state]
    if one.state == WORKING:
        rule = one.module.proficient
        text += f" {one.credit.row + one.credit.more}/{rule.consecutive + rule.more}"
    return text


def _exercise(found: Sequence[Skill]) -> str:
    first = found[0]
    rows = []
    for skill in found:
        weak = skill.weakest[0] if skill.weakest else None
        missed = NONE if weak is None else f"{weak.metric.name} ({weak.missed} of {weak.count})"
        rows.append(
            [
                escape(skill.operator or NOBODY),
                str(len(skill.repetitions)),
                str(skill.passed),
                NONE
                if skill.reliability is None
                else f"≥ {percent(skill.reliability)} (n = {skill.recent})",
                percent(skill.proficiency),
                number(skill.best, "s"),
                escape(missed),
                workload(skill),
            ]
        )
    heads = ["", "n", "passed", "reliability", "proficiency", "best", "weakest metric", "workload"]
    parts = [
        heading(first),
        table(heads, rows),
    ]
    times = [(skill.operator or NOBODY, skill.times) for skill in found]
    if any(skill.times for skill in found):
        total = sum(len(skill.times) for skill in found)
        caption = f"Times of completed repetitions, n = {total}; bars: medians"
        parts.append(figure(strip_figure(times, "s", first.expert), caption))
    note = f"Reliability: lower bound, {100 * CONFIDENCE:.0f} % sure, of the last repetitions."
    if any(skill.provisional for skill in found):
        note += " Proficiency: to a script's rate, provisional."
    return f'<section class="skill">{"".join(parts)}<p class="dim">{note}</p></section>'
