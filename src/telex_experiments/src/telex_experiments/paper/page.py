"""The report: one page that needs nothing beside it, neither files nor a network."""

from __future__ import annotations

import base64
import math
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import List, Sequence
from urllib.parse import quote

from .experiment import Cell, Figure, ReportPicture, ReportTable, Result
from .schedule import ExperimentOutcome

STYLE = Path(__file__).with_name("page.css")

SHOWN_ROWS = 25
"""A longer table is folded up on screen."""

_TYPES = {".jpg": "image/jpeg", ".png": "image/png", ".svg": "image/svg+xml"}


@dataclass(frozen=True)
class ReportRun:
    """What the report says of the whole run.

    Attributes
    ----------
    machine : str
        Processor, cores, Python.
    version : str
        Of the simulator: commit, or empty.
    seconds : float
        Of wall time.
    """

    when: str
    machine: str
    version: str
    quick: bool
    seed: int
    seconds: float


def page(run: ReportRun, outcomes: Sequence[ExperimentOutcome], folder: Path) -> str:
    """Return the report as HTML.

    Parameters
    ----------
    folder : Path
        Of the results: pictures are taken from the experiments' folders in it, and links are
        relative to it.
    """
    parts = [_head(run, outcomes), _summary(outcomes)]
    parts += [_experiment(outcome, folder) for outcome in outcomes]
    style = STYLE.read_text(encoding="utf-8")
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        '<meta name="color-scheme" content="light dark">\n'
        # Without one, browsers ask a server for it.
        '<link rel="icon" href="data:,">\n'
        f"<title>Telex: the paper's results</title>\n<style>\n{style}</style>\n</head>\n<body>\n"
        + "\n".join(parts)
        + "\n</body>\n</html>\n"
    )


def number(value: Cell) -> str:
    """Return a cell of a table as text: numbers with four digits."""
    if value is None:
        return "\u2013"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        text = f"{value:.4g}" if math.isfinite(value) else "none"
        return text.replace("-", "\u2212", 1) if text.startswith("-") else text
    return str(value)


def _head(run: ReportRun, outcomes: Sequence[ExperimentOutcome]) -> str:
    met = sum(outcome.result.ok for outcome in outcomes)
    good = met == len(outcomes)
    verdict = f"{met} of {len(outcomes)} results reproduced"
    facts = [run.when, run.machine, run.version, f"seed {run.seed}"]
    facts.append(f"{run.seconds / 60.0:.1f} minutes")
    if run.quick:
        facts.append("a quick, coarse run")
    return (
        "<header>\n<p class='kicker'>A Training Simulator for Teleoperated Robots Deployed at CERN"
        "</p>\n<h1>The paper's results, reproduced</h1>\n"
        f"<p class='verdict {_class(good)}'>{verdict}</p>\n"
        "<p>Each row is a result of the paper. The simulator was started as a user starts it, and "
        "the robot driven through its ROS interface; where something is computed without it, its "
        "section says so. Every bar was set before the run.</p>\n"
        f"<p class='facts'>{' · '.join(escape(fact) for fact in facts if fact)}</p>\n</header>"
    )


def _summary(outcomes: Sequence[ExperimentOutcome]) -> str:
    rows = []
    for outcome in outcomes:
        experiment, result = outcome.experiment, outcome.result
        rows.append(
            f"<tr><td>{escape(experiment.paper)}</td>"
            f"<td><a href='#{experiment.name}'>{escape(experiment.title)}</a></td>"
            f"<td>{escape(experiment.bar)}</td>"
            f"<td>{_measured(result)}</td>"
            f"<td>{_badge(result.ok)}</td></tr>"
        )
    return (
        "<section class='summary'>\n<div class='scroll'><table>\n<thead><tr><th>Paper</th>"
        "<th>Result</th><th>Bar</th><th>Measured</th><th>Verdict</th></tr></thead>\n<tbody>\n"
        + "\n".join(rows)
        + "\n</tbody></table></div>\n</section>"
    )


def _measured(result: Result) -> str:
    """What the summary says: why it was missed, or the figures nearest to their bars."""
    if result.error:
        return escape(result.error.splitlines()[0][:160])
    missed = result.missed
    if missed:
        return "; ".join(_said(figure) for figure in missed[:4])
    required = sorted((f for f in result.figures if f.required), key=_nearness, reverse=True)
    more = len(required) - 2
    text = "; ".join(_said(figure) for figure in required[:2])
    return f"{text}{f'; {more} more' if more > 0 else ''}" or "no figure has a bar"


def _said(figure: Figure) -> str:
    return f"{escape(figure.name)} {number(figure.value)} {escape(figure.unit)}".rstrip()


def _nearness(figure: Figure) -> float:
    """How much of its margin a figure uses up: 1 is at its bar."""
    if figure.at_most:
        return figure.value / figure.at_most
    if figure.at_least:
        return figure.at_least / figure.value if figure.value else math.inf
    return 0.0


def _experiment(outcome: ExperimentOutcome, folder: Path) -> str:
    experiment, result = outcome.experiment, outcome.result
    parts = [
        f"<section class='experiment' id='{experiment.name}'>",
        f"<h2>{escape(experiment.title)} {_badge(result.ok)}</h2>",
        f"<p class='facts'>{escape(experiment.paper)} · {outcome.seconds:.0f} s</p>",
        "<div class='pair'>",
        f"<div><h3>The paper</h3><p>{escape(experiment.claim)}</p></div>",
        f"<div><h3>Here</h3><p>{escape(experiment.method)}</p>"
        f"<p><b>Bar:</b> {escape(experiment.bar)}</p></div>",
        "</div>",
    ]
    if result.error:
        parts.append(f"<pre class='error'>{escape(result.error)}</pre>")
    if result.pictures:
        shown = [_picture(picture, folder / experiment.name) for picture in result.pictures]
        parts.append(f"<div class='pictures'>{''.join(shown)}</div>")
    if result.figures:
        parts.append(_figures(result.figures))
    parts += [_table(table, experiment.name) for table in result.tables]
    if result.notes:
        notes = "".join(f"<li>{escape(note)}</li>" for note in result.notes)
        parts.append(f"<ul class='notes'>{notes}</ul>")
    parts.append(_links(experiment.name, result, folder))
    parts.append("</section>")
    return "\n".join(part for part in parts if part)


def _picture(picture: ReportPicture, folder: Path) -> str:
    file = folder / picture.file
    if not file.exists():
        return f"<figure><p class='error'>{escape(picture.file)} is missing</p></figure>"
    data = base64.b64encode(file.read_bytes()).decode("ascii")
    caption = f"<b>{escape(picture.title)}</b> {escape(picture.caption)}".strip()
    return (
        f"<figure{' class=wide' if picture.wide else ''}>"
        f"<img alt='{escape(picture.title, quote=True)}' "
        f"src='data:{_TYPES[file.suffix]};base64,{data}'>"
        f"<figcaption>{caption}</figcaption></figure>"
    )


def _figures(figures: Sequence[Figure]) -> str:
    rows = []
    for figure in figures:
        verdict = _badge(figure.ok) if figure.required else ""
        missed = "" if figure.ok else " class='missed'"
        required = figure.required.replace(">=", "\u2265").replace("<=", "\u2264")
        rows.append(
            f"<tr{missed}><td>{escape(figure.name)}</td><td class='number'>{number(figure.value)}"
            f"</td><td>{escape(figure.unit)}</td><td class='number'>{escape(required)}</td>"
            f"<td>{verdict}</td></tr>"
        )
    head = (
        "<th>Figure</th><th class=number>Measured</th><th></th><th class=number>Required</th>"
        "<th></th>"
    )
    return _folded("Measured figures", _rows(head, rows), len(rows), any(not f.ok for f in figures))


def _table(table: ReportTable, name: str) -> str:
    numeric = [
        bool(table.rows) and all(_is_number(row[i]) for row in table.rows)
        for i in range(len(table.head))
    ]
    head = "".join(
        f"<th{' class=number' if is_number else ''}>{escape(cell)}</th>"
        for cell, is_number in zip(table.head, numeric)
    )
    rows = []
    for row in table.rows:
        cells = [
            f"<td{' class=number' if is_number else ''}>{escape(number(cell))}</td>"
            for cell, is_number in zip(row, numeric)
        ]
        rows.append(f"<tr>{''.join(cells)}</tr>")
    note = f"<p class='facts'>{escape(table.note)}</p>" if table.note else ""
    link = _link(name, table.file)
    return _folded(table.title, _rows(head, rows) + note, len(rows), False, link)


def _is_number(cell: Cell) -> bool:
    """Whether it may stand in a column of numbers: yes and no are words."""
    return cell is None or (isinstance(cell, (int, float)) and not isinstance(cell, bool))


def _rows(head: str, rows: Sequence[str]) -> str:
    return (
        f"<div class='scroll'><table>\n<thead><tr>{head}</tr></thead>\n<tbody>\n"
        + "\n".join(rows)
        + "\n</tbody></table></div>"
    )


def _folded(title: str, content: str, rows: int, show: bool, link: str = "") -> str:
    state = " open" if show or rows <= SHOWN_ROWS else ""
    count = f" <span class='facts'>{rows} rows</span>" if rows > SHOWN_ROWS else ""
    return (
        f"<details{state}><summary><h3>{escape(title)}</h3>{count} {link}</summary>\n"
        f"{content}</details>"
    )


def _links(name: str, result: Result, folder: Path) -> str:
    files: List[str] = [*result.bags]
    for picture in result.pictures:
        files.append(picture.file)
        other = Path(picture.file).with_suffix(".png")
        if picture.file.endswith(".svg") and (folder / name / other).exists():
            files.append(str(other))
    files = list(dict.fromkeys(files))
    if not files:
        return ""
    links = " · ".join(_link(name, file) for file in files)
    replay = ""
    if result.bags:
        replay = (
            "<p class='facts'>To see a recorded run again: "
            "<code>roslaunch telex_sim replay.launch bag:=/path/to/the.bag</code></p>"
        )
    return f"<p class='links'>Files: {links}</p>{replay}"


def _link(name: str, file: str) -> str:
    return f"<a href='{quote(f'{name}/{file}')}'>{escape(file)}</a>"


def _class(good: bool) -> str:
    return "met" if good else "missed"


def _badge(good: bool) -> str:
    return f"<span class='badge {_class(good)}'>{'met' if good else 'missed'}</span>"
