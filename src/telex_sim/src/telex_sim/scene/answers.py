"""Right answers of charts, pipes and leaks, for whoever judges an operator."""

from __future__ import annotations

from typing import Any, Dict, Mapping, Tuple

from telex_control.common.params import ConfigError, read_struct

from .library.accelerator.vacuum import FlangeLine
from .library.building.signs import Chart
from .library.tasks.panels import InspectionPipes
from .textures.optotypes import chart_rows

DIRECTIONS: Dict[int, str] = {
    0: "right",
    45: "up right",
    90: "up",
    135: "up left",
    180: "left",
    225: "down left",
    270: "down",
    315: "down right",
}
"""Words for where a character opens, by the angle anticlockwise from the right (degrees)."""


def answers(entry: Mapping[str, Any]) -> Tuple[Tuple[str, ...], ...]:
    """What is to be read on an object: where its characters open, as one sees them.

    Parameters
    ----------
    entry : mapping
        Of a scene file's ``objects``: a ``chart``, ``inspection_pipes`` or a ``flange_line``.

    Returns
    -------
    tuple of tuple of str
        Of a chart: its rows from above, each from left to right. Of pipes: one row, in the order in
        which they are built: of a star the middle one first. Of a line of flanges: the number of
        that which leaks, 0 where none does.

    Raises
    ------
    ConfigError
        It is another type, or a parameter is wrong.
    """
    kind = str(entry.get("type", ""))
    placing = ("type", "name", "position", "yaw", "rpy")
    values = {key: value for key, value in entry.items() if key not in placing}
    if kind == "chart":
        chart = read_struct(Chart, values)
        rows = chart_rows(chart.kind, chart.drawn_from(), chart.rows)
        return tuple(tuple(DIRECTIONS[angle] for angle in row.angles) for row in rows)
    if kind == "inspection_pipes":
        return (tuple(DIRECTIONS[angle] for angle in read_struct(InspectionPipes, values).gaps()),)
    if kind == "flange_line":
        return ((str(read_struct(FlangeLine, values).leaking()),),)
    raise ConfigError(f"type is '{kind}'; chart, inspection_pipes or flange_line can be read")
