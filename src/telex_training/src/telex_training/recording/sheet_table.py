"""A score sheet as a table."""

from __future__ import annotations

import csv
import io
from typing import Any, Dict, List


def sheet_csv(sheet: Dict[str, Any]) -> str:
    """Write a sheet as a table: one row a repetition."""
    names = sorted({name for rep in sheet["repetitions"] for name in rep["metrics"]})
    file = io.StringIO()
    writer = csv.writer(file)
    writer.writerow(["repetition", "began", "seconds", "penalty", "fault", "passed", *names])
    for number, rep in enumerate(sheet["repetitions"], 1):
        row: List[Any] = [
            number,
            *(rep[key] for key in ("began", "seconds", "penalty", "fault", "passed")),
        ]
        writer.writerow([*row, *(rep["metrics"].get(name, "") for name in names)])
    return file.getvalue()
