"""Lists that are piped into ``head`` end as its reader does."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from telex_control.common.quiet_end import SIGPIPE_STATUS

SOURCES = Path(__file__).resolve().parents[1] / "src"
COMMANDS = (
    "controller_manager/scripts/controller_group",
    "controller_manager/scripts/controller_manager",
    "telex_control/nodes/controller_group",
    "telex_control/nodes/controller_manager",
    "telex_control/nodes/follow_trajectory",
    "telex_control/nodes/step_response",
    "telex_sim/nodes/robot_model",
    "telex_sim/nodes/scene",
    "telex_training/nodes/exercise",
    "telex_training/nodes/expert",
    "telex_training/nodes/export",
    "telex_training/nodes/score",
)


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_line_ends_quietly(command: str) -> None:
    assert "ending_quietly(" in (SOURCES / command).read_text()


@pytest.mark.parametrize("command", ["telex_sim/nodes/scene", "telex_training/nodes/exercise"])
def test_a_list_ends_without_a_word_when_its_reader_has_gone(command: str) -> None:
    process = subprocess.Popen(
        [sys.executable, str(SOURCES / command), "list"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout
    process.stdout.close()
    assert process.stderr
    assert process.stderr.read() == ""
    process.stderr.close()
    assert process.wait(timeout=60.0) == SIGPIPE_STATUS
