"""The shipped robot: its description, expanded."""

from __future__ import annotations

import subprocess
from pathlib import Path

from urdf_parser_py.urdf import URDF

PACKAGE = Path(__file__).resolve().parents[1]


def expanded(*arguments: str) -> URDF:
    """Return the robot that xacro makes with such arguments (``name:=value``)."""
    model = PACKAGE / "urdf" / "telex.urdf.xacro"
    return URDF.from_xml_string(subprocess.check_output(["xacro", str(model), *arguments]))
