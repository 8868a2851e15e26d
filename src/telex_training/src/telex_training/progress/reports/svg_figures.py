"""Figures of reports as SVG: learning curve, CUSUM chart, times of several people."""

from __future__ import annotations

import math
from html import escape
from typing import List, Optional, Sequence, Tuple

from ...judging.stats import Cusum, median
from ..inference import CurvePoint

_WIDTH, _HEIGHT = 420.0, 220.0
_LEFT, _RIGHT, _TOP, _BOTTOM = 46.0, 12.0, 22.0, 34.0
_ROW = 26.0
_NAMES = 130.0


def nice_step(span: float, most: int) -> float:
    """Step of an axis's marks: 1, 2 or 5 times a power of ten, for at most so many of them."""
    if not span > 0.0:
        return 1.0
    rough = span / most
    power = 10.0 ** math.floor(math.log10(rough))
    return next(power * each for each in (1.0, 2.0, 5.0, 10.0) if power * each >= rough * 0.999999)


class _Plot:
    """A rectangle with two axes; x and y grow to the right and upwards."""

    def __init__(
        self, x: Tuple[float, float], y: Tuple[float, float], height: float = _HEIGHT
    ) -> None:
        self._x, self._y = x, y
        self._left = _LEFT
        self.height = height
        self.parts: List[str] = []

    def names_left(self) -> None:
        """Leave room for names in place of the marks of y."""
        self._left = _NAMES

    def x(self, value: float) -> float:
        low, high = self._x
        return self._left + (value - low) / (high - low) * (_WIDTH - self._left - _RIGHT)

    def y(self, value: float) -> float:
        low, high = self._y
        return self.height - _BOTTOM - (value - low) / (high - low) * (self.height - _TOP - _BOTTOM)

    def text(self, x: float, y: float, text: str, anchor: str = "middle", kind: str = "") -> None:
        kind = f' class="{kind}"' if kind else ""
        self.parts.append(
            f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}"{kind}>{escape(text)}</text>'
        )

    def line(self, x1: float, y1: float, x2: float, y2: float, kind: str) -> None:
        self.parts.append(
            f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" class="{kind}"/>'
        )

    def path(self, points: Sequence[Tuple[float, float]], kind: str, closed: bool = False) -> None:
        way = "L".join(f"{self.x(x):.1f} {self.y(y):.1f}" for x, y in points)
        self.parts.append(f'<path d="M{way}{"Z" if closed else ""}" class="{kind}"/>')

    def dot(self, x: float, y: float, kind: str, radius: float = 3.0) -> None:
        self.parts.append(
            f'<circle cx="{self.x(x):.1f}" cy="{self.y(y):.1f}" r="{radius:g}" class="{kind}"/>'
        )

    def x_axis(self, label: str, whole: bool = False) -> None:
        bottom = self.height - _BOTTOM
        self.line(self._left, bottom, _WIDTH - _RIGHT, bottom, "axis")
        low, high = self._x
        step = max(nice_step(high - low, 8), 1.0 if whole else 0.0)
        for i in range(math.ceil(low / step), math.floor(high / step) + 1):
            self.line(self.x(i * step), bottom, self.x(i * step), bottom + 4.0, "axis")
            self.text(self.x(i * step), bottom + 15.0, f"{i * step:g}")
        self.text((self._left + _WIDTH - _RIGHT) / 2, self.height - 5.0, label)

    def y_axis(self, label: str) -> None:
        low, high = self._y
        self.line(self._left, _TOP, self._left, self.height - _BOTTOM, "axis")
        step = nice_step(high - low, 5)
        for i in range(math.ceil(low / step), math.floor(high / step) + 1):
            y = self.y(i * step)
            self.line(self._left, y, _WIDTH - _RIGHT, y, "grid")
            self.text(self._left - 6.0, y + 4.0, f"{i * step:g}", "end")
        self.text(4.0, 10.0, label, "start")

    def svg(self, title: str) -> str:
        size = (
            f'viewBox="0 0 {_WIDTH:g} {self.height:g}" width="{_WIDTH:g}" height="{self.height:g}"'
        )
        return (
            f'<svg xmlns="http://www.w3.org/2000/svg" role="img" {size}>'
            f"<title>{escape(title)}</title>{''.join(self.parts)}</svg>"
        )


def learning_figure(
    times: Sequence[float], curve: Optional[Sequence[CurvePoint]], expert: Optional[float] = None
) -> str:
    """Draw the times of repetitions, their learning curve and its band.

    Parameters
    ----------
    times : sequence of float
        Of the completed repetitions, not empty (s).
    expert : float, optional
        The expert's time (s).
    """
    # A band that is wide at its beginning must not press the times down.
    highest = max([*times, expert or 0.0, *([curve[-1].high] if curve else [])]) or 1.0
    last = curve[-1].number if curve else len(times)
    plot = _Plot((0.5, last + 0.5), (0.0, 1.08 * highest))
    plot.y_axis("s")
    if expert:
        plot.line(plot.x(0.5), plot.y(expert), plot.x(last + 0.5), plot.y(expert), "expert")
        plot.text(plot.x(last + 0.5), plot.y(expert) - 4.0, "expert", "end", "note")
    if curve:
        top = 1.08 * highest
        band = [(each.number, min(each.high, top)) for each in curve]
        band += [(each.number, min(each.low, top)) for each in reversed(curve)]
        plot.path(band, "band", closed=True)
        known = [(each.number, min(each.expected, top)) for each in curve]
        plot.path(known[: len(times)], "fit")
        plot.path(known[len(times) - 1 :], "ahead")
        plot.dot(curve[-1].number, curve[-1].expected, "goal", 4.0)
    for number, time in enumerate(times, 1):
        plot.dot(number, time, "point")
    plot.x_axis("completed repetition", whole=True)
    return plot.svg("times of the completed repetitions, with learning curve")


def cusum_figure(chart: Cusum) -> str:
    """Draw a CUSUM chart that is not empty; grid lines are one decision apart."""
    limit = chart.limit
    low = min(-1, math.floor(min(chart.sums) / limit))
    high = max(1, math.ceil(max(chart.sums) / limit))
    plot = _Plot((0.0, float(len(chart.sums))), (low * limit, high * limit))
    every = max(1, math.ceil((high - low) / 8))
    for i in range(low, high + 1):
        if i % every == 0:
            y = plot.y(i * limit)
            plot.line(plot.x(0.0), y, plot.x(len(chart.sums)), y, "grid" if i else "axis")
            plot.text(plot.x(0.0) - 6.0, y + 4.0, f"{i:+d}" if i else "0", "end")
    plot.text(4.0, 10.0, "decisions", "start")
    plot.path([(0.0, 0.0), *enumerate(chart.sums, 1)], "fit")
    for i, value in enumerate(chart.sums):
        before = chart.sums[i - 1] if i else 0.0
        plot.dot(i + 1, value, "fault" if value > before else "point", 2.5)
    plot.x_axis("repetition", whole=True)
    return plot.svg("CUSUM of failures: falls with success, rises with failure")


def strip_figure(
    rows: Sequence[Tuple[str, Sequence[float]]], unit: str, expert: Optional[float] = None
) -> str:
    """Draw figures of several people, a row for each: every figure a dot, their median a bar.

    Parameters
    ----------
    rows : sequence of (str, sequence of float)
        At least one with a figure.
    """
    values = [value for _, row in rows for value in row] + ([expert] if expert else [])
    low, high = min(0.0, *values), max(0.0, *values)
    height = _TOP + _BOTTOM + _ROW * len(rows)
    plot = _Plot((low, low + 1.05 * ((high - low) or 1.0)), (0.0, float(len(rows))), height)
    plot.names_left()
    if expert:
        plot.line(plot.x(expert), _TOP, plot.x(expert), height - _BOTTOM, "expert")
        plot.text(plot.x(expert), _TOP - 3.0, "expert", "middle", "note")
    for i, (name, row) in enumerate(rows):
        at = len(rows) - i - 0.5
        shown = name if len(name) <= 18 else f"{name[:17]}…"
        plot.text(_NAMES - 8.0, plot.y(at) + 4.0, shown, "end")
        for value in row:
            plot.dot(value, at, "point")
        if row:
            middle = plot.x(median(row))
            plot.line(middle, plot.y(at) - 8.0, middle, plot.y(at) + 8.0, "median")
    plot.x_axis(unit)
    return plot.svg("figures by person; bars are medians")
