"""What telex_training may know of the packages below it."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path
from typing import Iterator, List

import pytest

ROOT = Path(__file__).resolve().parents[1] / "src" / "telex_training"
ANYWHERE = (
    "telex_training",
    "telex_sim.scene",
    "telex_sim.malfunctions",
    "telex_control.common",
    "telex_control.kinematics",
)
OF_SERVERS = tuple(
    f"telex_teleop.web.{name}" for name in ("listening", "origins", "token_files", "tokens")
)
"""What servers have in common, with ROS or without."""
FURTHER = {
    "classroom": OF_SERVERS,
    "command_lines": OF_SERVERS,
    "rehearsal": (
        "telex_sim.engine.exposure",
        "telex_sim.engine.radio",
        "telex_sim.offline",
        "telex_sim.radiation.messages",
        "telex_sim.stability",
        "telex_sim.truth",
        "telex_teleop",
    ),
    "replay": (
        "telex_control.urdf",
        "telex_sim.cameras.cameras_config",
        "telex_sim.robot.urdf",
        "telex_sim.ros.scene_messages",
    ),
    "research": (
        "telex_sim.cameras",
        "telex_sim.offline",
        "telex_sim.ros.scene_messages",
        "telex_teleop",
    ),
    "ros": (
        "telex_control.ros",
        "telex_sim.cameras.cameras_config",
        "telex_sim.cameras.ros.overview_rig",
    ),
}
"""What single rooms may import as well."""
DECODING = ("judging", "recording", "rehearsal", "replay", "research", "command_lines")
"""Rooms that know messages, for they read and write them serialised, but no node."""
ROS = ("rospy", "roslib", "rosgraph", "actionlib", "tf2_ros")
WITH_ROS = ("telex_teleop.ros", "telex_teleop.operating", "telex_teleop.web", "telex_teleop.joy")
"""Rooms of telex_teleop that are no cores."""
CORES = ("telex_teleop.web.line",)
"""Cores in them."""

SOURCES = sorted(ROOT.rglob("*.py"))


def imported(path: Path) -> Iterator[str]:
    """Full names of the modules that a file imports, and of what it takes out of them."""
    package = ["telex_training", *path.relative_to(ROOT).parent.parts]
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (each.name for each in node.names)
        elif isinstance(node, ast.ImportFrom):
            above = package[: len(package) + 1 - node.level] if node.level else []
            yield ".".join([*above, *([node.module] if node.module else [])])


def within(module: str, names: List[str]) -> bool:
    return any(module == name or module.startswith(f"{name}.") for name in names)


def is_node(module: str) -> bool:
    return within(module, list(ROS))


def is_message(module: str) -> bool:
    return module.split(".")[0].endswith(("genpy", "_msgs", "_srvs"))


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: str(path.relative_to(ROOT)))
def test_a_module_knows_only_what_its_room_may(path: Path) -> None:
    room = path.relative_to(ROOT).parts[0]
    allowed = [*ANYWHERE, *FURTHER.get(room, ())]
    for module in imported(path):
        if module.startswith("telex_") and not is_message(module):
            assert within(module, allowed), f"{path} imports {module}"
            is_core = within(module, [*OF_SERVERS, *CORES]) or not within(module, list(WITH_ROS))
            assert is_core, f"{path} imports {module}"
        if room != "ros":
            assert not is_node(module), f"{path} imports {module}"
            assert room in DECODING or not is_message(module), f"{path} imports {module}"
        if room == "operators":
            beyond = ["telex_training.ros", "telex_training.rehearsal"]
            assert not within(module, beyond), f"{path} imports {module}"


def test_the_rule_reads_imports() -> None:
    assert {"telex_training.operators.port", "numpy"} <= set(imported(ROOT / "ros" / "camera.py"))
    assert "telex_training.operators" in set(imported(ROOT / "operators" / "tasks" / "cube.py"))
    assert is_message("telex_msgs.msg")
    assert is_node("rospy.core")


def test_operators_import_without_ros() -> None:
    modules = [
        ".".join(path.relative_to(ROOT.parent).with_suffix("").parts)
        for path in SOURCES
        if path.relative_to(ROOT).parts[0] == "operators" and path.name != "__init__.py"
    ]
    script = f"""
import importlib, importlib.abc, sys

class Block(importlib.abc.MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        top = name.split(".")[0]
        if top in {ROS!r} or top.endswith(("genpy", "_msgs", "_srvs")):
            raise ImportError(f"{{name}} is blocked")
        return None

sys.meta_path.insert(0, Block())
try:
    import rospy
except ImportError:
    for name in {modules!r}:
        importlib.import_module(name)
    print("free")
"""
    ran = subprocess.run(
        [sys.executable, "-c", script], stdout=subprocess.PIPE, text=True, check=False
    )
    assert ran.returncode == 0
    assert ran.stdout.strip() == "free"
