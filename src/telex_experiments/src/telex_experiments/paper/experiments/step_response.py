"""Figure 7: step response and effort of each joint of the arm."""

from __future__ import annotations

import json
import math
from typing import Any, Dict, List

import yaml

from telex_control.common.file_catalog import package_file
from telex_control.urdf.joints import short_name

from ..experiment import Cell, Experiment, Figure, ReportPicture, ReportTable, Result
from ..recorder import ARM_COMMANDS, FEW_PICTURES
from ..session import PaperSession
from ..tool import rosrun

OVERSHOOT, SETTLING = 5.0, 1.5  # %, s
ERROR_ANGLE, ERROR_LENGTH = 0.05, 0.2  # deg, mm
OSCILLATION_ANGLE, OSCILLATION_LENGTH = 0.01, 0.05  # deg, mm
TELESCOPE = "telescope_joint"
SPEED = 2.0
"""Sim time per wall time: the tool keeps to sim time, and nobody watches."""
MOVE_SPEED = 0.9
"""Between steps and postures, as a share of the joints' velocity limits."""


def hurried() -> str:
    """Return the tool's own plan, with quicker ways between the steps: these take most of it."""
    with open(package_file("telex_control", "config", "step_response.yaml")) as file:
        plan = yaml.safe_load(file)
    return str(yaml.safe_dump({**plan, "speed": MOVE_SPEED}))


def bars(row: Dict[str, Any]) -> List[Figure]:
    """Return the figures of one step, in the units in which they are required.

    Parameters
    ----------
    row : dict
        A record of the tool's ``steps.json``, in SI units.
    """
    slides = row["joint"] == TELESCOPE
    factor, unit = (1e3, "mm") if slides else (math.degrees(1.0), "deg")
    settling = row["settling_time"]
    name = f"{short_name(row['joint'])}, {row['posture']}"
    return [
        Figure(f"{name}: overshoot", row["overshoot"], "%", at_most=OVERSHOOT),
        Figure(
            f"{name}: settling time",
            math.inf if settling is None else settling,
            "s",
            at_most=SETTLING,
        ),
        Figure(
            f"{name}: steady-state error",
            abs(row["steady_state_error"]) * factor,
            unit,
            at_most=ERROR_LENGTH if slides else ERROR_ANGLE,
        ),
        Figure(
            f"{name}: oscillation at rest",
            row["oscillation"] * factor,
            unit,
            at_most=OSCILLATION_LENGTH if slides else OSCILLATION_ANGLE,
        ),
        Figure(
            f"{name}: peak effort",
            row["peak_effort"],
            "N" if slides else "Nm",
            at_most=row["effort_limit"] * (1.0 + 1e-9),
        ),
    ]


def table_row(row: Dict[str, Any]) -> List[Cell]:
    """Return a row of the report's table."""
    factor = 1e3 if row["joint"] == TELESCOPE else math.degrees(1.0)
    return [
        short_name(row["joint"]),
        row["posture"],
        row["reference"],
        (row["target"] - row["start"]) * factor,
        row["rise_time"],
        row["overshoot"],
        row["settling_time"],
        abs(row["steady_state_error"]) * factor,
        row["peak_effort"],
        100.0 * row["peak_effort"] / row["effort_limit"],
    ]


def run(session: PaperSession) -> Result:
    """Step each joint of the arm on the running system, by the tool that ships with it."""
    postures = ["stretched"] if session.quick else ["folded", "stretched"]
    plan = session.folder / "plan.yaml"
    plan.write_text(hurried(), encoding="utf-8")
    arguments = ["arm", "--pose", *postures, "--plan", str(plan), "--out", str(session.folder)]
    with session.simulator(console=False, pose="ready", real_time_factor=SPEED), session.record(
        "steps", ("front",), ARM_COMMANDS, FEW_PICTURES
    ):
        rosrun("telex_control", "step_response", *arguments, say=session.say)
    rows = json.loads((session.folder / "steps.json").read_text(encoding="utf-8"))
    figures = [figure for row in rows if row["reference"] == "shaped" for figure in bars(row)]
    head = (
        *("joint", "posture", "reference", "step deg, mm", "rise s", "overshoot %", "settling s"),
        *("error deg, mm", "peak effort Nm, N", "of its limit %"),
    )
    return Result(
        figures=figures,
        pictures=[
            ReportPicture(
                f"Step response and effort of each joint, arm {posture}.",
                f"arm_{posture}.svg",
                "Dashed: the reference; blue: as the shipped controllers lead the joint; orange: "
                "raw, the PID alone, as the paper's figure 7 steps it. Below each: the effort.",
                wide=True,
            )
            for posture in postures
        ],
        tables=[
            ReportTable(
                "Steps",
                "step_table.csv",
                head,
                [table_row(row) for row in rows],
                "The bars are for the shaped steps: that is how the robot moves. steps.csv, "
                "beside it, holds the same in SI units.",
            )
        ],
        bags=["steps.bag"],
        notes=[
            "The tool steps the joints' references on the controllers' own topics, and records "
            "the joint states, with an empty gripper. benchmarks/step_response adds 5 kg, and "
            "fingers and flippers."
        ],
    )


EXPERIMENTS = (
    Experiment(
        name="fig7_step_response",
        paper="Figure 7, section 5",
        title="Step response and effort of each joint",
        claim="The step response of each joint was analysed in order to tune its PID for a "
        "non-oscillatory, accurate but fast response; figure 7 shows the responses and the "
        "efforts of the arm's joints.",
        method="rosrun telex_control step_response steps all seven joints by 15\u00b0 (telescope "
        "50 mm), the arm folded and stretched out, as shipped and raw.",
        bar="overshoot \u2264 5 %, settled within 1.5 s, error \u2264 0.05\u00b0 (0.2 mm), "
        "oscillation \u2264 0.01\u00b0 (0.05 mm), effort within its limit",
        run=run,
        seconds=170.0,
        quick_seconds=60.0,
        groups=("fig7",),
    ),
)
