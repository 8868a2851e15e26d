"""Experiments and their results, as plain data."""

from __future__ import annotations

import csv
import io
import json
import math
import re
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Callable, Dict, List, Optional, Sequence, Tuple, Union

from telex_experiments.rigs.report import Figure

if TYPE_CHECKING:
    from .session import PaperSession

__all__ = ["Cell", "Experiment", "Figure", "ReportPicture", "ReportTable", "Result"]

Cell = Union[str, int, float, bool, None]
"""Of a table; None where there is nothing to say."""

PICTURES = (".jpg", ".png", ".svg")
_NAME = re.compile(r"[a-z][a-z0-9_]*")


@dataclass(frozen=True)
class ReportPicture:
    """A picture in the report.

    Attributes
    ----------
    file : str
        JPEG, PNG or SVG, relative to the experiment's folder. Of a plot that is there as PNG and
        SVG, name the SVG: the report embeds it, and links the other.
    caption : str
        What is to be seen, in a sentence.
    wide : bool
        Whether it needs the page's whole width to be read.
    """

    title: str
    file: str
    caption: str = ""
    wide: bool = False

    def __post_init__(self) -> None:
        if Path(self.file).suffix not in PICTURES:
            raise ValueError(f"picture {self.file!r}: is none of {', '.join(PICTURES)}")


@dataclass(frozen=True)
class ReportTable:
    """A table in the report, which is written as CSV as well.

    Attributes
    ----------
    file : str
        Name of the CSV, in the experiment's folder.
    head : sequence of str
        With units.
    rows : sequence of sequences
        As long as the head. Numbers stay numbers: the CSV has all of their digits, the report four.
    note : str
        A sentence below it.
    """

    title: str
    file: str
    head: Sequence[str]
    rows: Sequence[Sequence[Cell]]
    note: str = ""

    def __post_init__(self) -> None:
        for row in self.rows:
            if len(row) != len(self.head):
                raise ValueError(f"table {self.title!r}: row {row!r} does not fit its head")

    def as_csv(self) -> str:
        """Return it comma-separated, with its head."""
        file = io.StringIO()
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(self.head)
        writer.writerows(self.rows)
        return file.getvalue()


@dataclass
class Result:
    """What an experiment has yielded.

    Attributes
    ----------
    figures : list of Figure
        Measured, with what is required: `Figure(name, value, unit, at_least=…, at_most=…)`.
    bags : list of str
        Recorded runs, relative to the experiment's folder.
    notes : list of str
        What a reader has to know to judge it, a sentence or two each.
    error : str
        Why it broke off; empty when it did not.
    """

    figures: List[Figure] = field(default_factory=list)
    pictures: List[ReportPicture] = field(default_factory=list)
    tables: List[ReportTable] = field(default_factory=list)
    bags: List[str] = field(default_factory=list)
    notes: List[str] = field(default_factory=list)
    error: str = ""

    @property
    def ok(self) -> bool:
        """Whether all bars were met. A result that has no bar proves nothing, and is not."""
        required = [figure for figure in self.figures if figure.required]
        return not self.error and bool(required) and all(figure.ok for figure in required)

    @property
    def missed(self) -> List[Figure]:
        """The figures that missed their bar."""
        return [figure for figure in self.figures if not figure.ok]

    def as_json(self) -> str:
        """Return it as JSON, which `from_json` reads; NaN and infinities are words there."""
        return json.dumps(_plain(asdict(self)), indent=2, allow_nan=False)

    @staticmethod
    def from_json(text: str) -> Result:
        """Read what `as_json` wrote."""
        content: Dict[str, Any] = json.loads(text)
        return Result(
            [
                Figure(**{**figure, "value": float(figure["value"])})
                for figure in content["figures"]
            ],
            [ReportPicture(**picture) for picture in content["pictures"]],
            [ReportTable(**table) for table in content["tables"]],
            content["bags"],
            content["notes"],
            content["error"],
        )


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _plain(each) for key, each in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(each) for each in value]
    if hasattr(value, "item"):
        value = value.item()  # of numpy
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    return value


@dataclass(frozen=True)
class Experiment:
    """A result of the paper, and how it is reproduced.

    Attributes
    ----------
    name : str
        As ``--only`` takes it, and as its folder is called: lower case, digits, underscores.
    paper : str
        Where it stands in the paper.
    claim : str
        What the paper says.
    method : str
        What is done here; of a scripted operator, what it sees and what it commands by.
    bar : str
        What is required, in words.
    run : callable
        Carries it out. What it raises ends the experiment as failed, and the others go on;
        a run of several that fails is to be counted, not raised.
    seconds, quick_seconds : float
        Wall time that it is expected to take on two quiet cores, whole and with ``--quick`` (s).
        It is ended as failed after `patience` times that.
    in_wall_time : bool
        Whether it drives a simulator. Such experiments run one after the other; one that computes
        only, without ROS, runs beside them at low priority.
    alone : bool
        Whether what only computes stands still while it runs.
    repeatable : bool
        Whether it has as many runs as ``--repeat`` says.
    groups : tuple of str
        Further names by which ``--only`` finds it, such as "fig9".
    """

    name: str
    paper: str
    title: str
    claim: str
    method: str
    bar: str
    run: Callable[[PaperSession], Result]
    seconds: float
    quick_seconds: float
    in_wall_time: bool = True
    alone: bool = False
    repeatable: bool = False
    groups: Tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not _NAME.fullmatch(self.name):
            raise ValueError(f"experiment {self.name!r}: a name is lower case, digits, underscores")
        for key in ("seconds", "quick_seconds"):
            value = getattr(self, key)
            if not (math.isfinite(value) and value > 0.0):
                raise ValueError(f"experiment {self.name}: {key} is {value}, not above 0")

    def expected(self, quick: bool, repeat: int = 1) -> float:
        """Wall time that it is expected to take (s)."""
        seconds = self.quick_seconds if quick else self.seconds
        return seconds * repeat if self.repeatable else seconds

    def called(self, name: str) -> bool:
        """Whether a name of the command line means it."""
        return name == self.name or name in self.groups


def missing(reason: str, partial: Optional[Result] = None) -> Result:
    """Return a result that says why there is none, with what there is of it."""
    result = partial or Result()
    result.error = reason
    return result
