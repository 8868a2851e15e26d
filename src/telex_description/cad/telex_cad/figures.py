"""The robot's dimensions, as config/robot.xacro has them: one source for URDF and solids."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Dict

import xacro

# Coordinates (m) and pitch downwards (rad) by name
Place = Dict[str, float]


@dataclass(frozen=True)
class Figures:
    """Properties of the same names in the xacro file (m, kg, rad), where comments explain them."""

    flipper: Dict[str, float]
    hull: Dict[str, float]
    turret_x: float
    front_camera: Place
    rear_camera: Place
    mast_camera: Place
    front_lamp: Place
    rear_lamp: Place
    shoulder_x: float
    shoulder_y: float
    shoulder_z: float
    telescope_x: float
    elbow_x: float
    elbow_y: float
    forearm_roll_x: float
    wrist_pitch_x: float
    gripper_roll_x: float
    tool_x: float
    finger: Dict[str, float]
    pan_x: float
    pan_y: float
    pan_z: float
    tilt_z: float
    turret_camera_x: float
    turret_lamp: Place
    arm_camera: Place
    gripper_camera: Place
    gripper_lamp: Place
    probe_x: float
    flange_x: float


def read_figures(path: Path) -> Figures:
    """Read the figures of a robot.

    Raises
    ------
    ValueError
        When the file lacks a property or xacro cannot read it.
    """
    symbols = xacro.Table(xacro.create_global_symbols())
    xacro.init_stacks(str(path))
    try:
        document = xacro.parse(None, str(path))
        xacro.eval_all(document.documentElement, xacro.Table(), symbols)
        values = {field.name: _property(symbols, field.name, path) for field in fields(Figures)}
    except xacro.XacroException as error:
        raise ValueError(f"{path}: {error}") from error
    return Figures(**values)


def _property(symbols: xacro.Table, name: str, path: Path) -> Any:
    if name not in symbols:
        raise ValueError(f"{path}: no xacro:property named '{name}'")
    return symbols[name]
