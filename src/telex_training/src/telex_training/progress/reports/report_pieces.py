"""Pieces of reports, which are HTML pages that need nothing beside themselves."""

from __future__ import annotations

import time
from html import escape
from pathlib import Path
from typing import Optional, Sequence, Tuple

from telex_control.common.file_catalog import package_path

from ...judging import stats
from ..skill import Skill
from ..standing import LOCKED, OPEN, PROFICIENT, SPENT, WORKING, ExamStanding, Standing
from ..trial_facts import TrialFacts

NONE = "-"
NOBODY = "no name"
MARKS = {PROFICIENT: "●", WORKING: "◐", OPEN: "○", LOCKED: NONE, SPENT: "!"}
_STYLE = ("pages", "report.css")


def page(title: str, parts: Sequence[str], script: str = "") -> str:
    """Put parts into an HTML page with its style, and where it has one the address of a script."""
    style = Path(package_path("telex_training"), *_STYLE).read_text(encoding="utf-8")
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{escape(title)}</title>\n<style>\n{style}</style>\n"
        + (f'<script type="module" src="{escape(script)}"></script>\n' if script else "")
        + "</head>\n<body>\n<main>\n"
        + "\n".join(parts)
        + "\n</main>\n</body>\n</html>\n"
    )


def lead(trials: Sequence[TrialFacts], now: float, people: Optional[int] = None) -> str:
    """Say of whom and of when a report is."""
    words = [] if people is None else [count(people, "person", "people")]
    words.append(count(len(trials), "trial"))
    if trials:
        words[-1] += f" from {day(trials[0].began)} to {day(trials[-1].began)}"
    words.append(f"as of {day(now)}")
    return f'<p class="dim">{escape(", ".join(words))}</p>'


def exam_mark(each: Standing, exam: ExamStanding) -> str:
    """Mark of a part of an exam, which comes after all modules."""
    if exam.passed:
        return MARKS[PROFICIENT]
    ready = all(one.state == PROFICIENT for one in each.modules)
    return MARKS[OPEN if ready else LOCKED]


def table(
    heads: Sequence[str],
    rows: Sequence[Sequence[str]],
    text: Tuple[int, ...] = (),
    mark: Tuple[int, ...] = (),
    head: bool = True,
) -> str:
    """Make a table of cells that are HTML already."""

    def cell(kind: str, place: int, content: str) -> str:
        name = "text" if place in text else "mark" if place in mark else ""
        given = f' class="{name}"' if name else ""
        kind = kind if content else "td"  # what has no text is no head of anything
        return f"<{kind}{given}>{content}</{kind}>"

    def row(kind: str, cells: Sequence[str]) -> str:
        return f"<tr>{''.join(cell(kind, i, each) for i, each in enumerate(cells))}</tr>"

    top = f"<thead>{row('th', heads)}</thead>" if head else ""
    return f"<table>{top}<tbody>{''.join(row('td', each) for each in rows)}</tbody></table>"


def figure(svg: str, caption: str) -> str:
    """Put a caption under an SVG."""
    return f"<figure>{svg}<figcaption>{escape(caption)}</figcaption></figure>"


def number(value: Optional[float], unit: str) -> str:
    """Write a figure with its unit."""
    return NONE if value is None else escape(f"{value:.4g} {unit}".rstrip())


def heading(skill: Skill) -> str:
    """Write exercise and setting over what is said of them; each is translated by itself."""
    return f"<h2><span>{escape(skill.title)}</span>, <span>{escape(skill.setting)}</span></h2>"


def percent(share: Optional[float]) -> str:
    """Write a share in per cent."""
    return NONE if share is None else f"{100 * share:.0f} %"


def workload(skill: Skill) -> str:
    """Write the median of the workloads that somebody has rated, with their number."""
    if not skill.workloads:
        return NONE
    return f"{stats.median(skill.workloads):.0f} (n = {len(skill.workloads)})"


def count(count: int, one: str, several: str = "") -> str:
    """Write a number of things."""
    return f"{count} {one if count == 1 else several or one + 's'}"


def day(wall: float, clock: bool = False) -> str:
    """Write a wall time (s since the epoch) as a local date, with the time of day or without."""
    return time.strftime("%Y-%m-%d %H:%M" if clock else "%Y-%m-%d", time.localtime(wall))
