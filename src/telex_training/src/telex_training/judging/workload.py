"""The operator's own workload: NASA-TLX, unweighted."""

from __future__ import annotations

from typing import Any, Dict

from .entries import BadEntryError, number_field
from .stats import raw_tlx

INPUT = "tlx"
"""Name of the training's own input with the ratings."""
SCALES = ("mental", "physical", "temporal", "performance", "effort", "frustration")
"""What is rated, in this order: three demands come first."""
RATINGS = len(SCALES)


def workload_of(values: Any) -> Dict[str, Any]:
    """Return ``ratings`` and ``raw``, their mean.

    Parameters
    ----------
    values : list of float
        Six ratings from 0 to 100.

    Raises
    ------
    BadEntryError
    """
    if not isinstance(values, list) or len(values) != RATINGS:
        raise BadEntryError(f"values is {str(values)[:40]!r}; six numbers are needed")
    ratings = [number_field({"values": value}, "values") for value in values]
    if not all(0.0 <= rating <= 100.0 for rating in ratings):
        raise BadEntryError(f"values is {str(values)[:60]}; 0 to 100 is possible")
    return {"ratings": ratings, "raw": raw_tlx(ratings)}
