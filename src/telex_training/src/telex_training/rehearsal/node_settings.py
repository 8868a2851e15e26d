"""Shipped parameters of the teleoperation nodes, as their launch files load them."""

from __future__ import annotations

from typing import Any, Dict, Mapping, NamedTuple, Optional, Type, TypeVar

from telex_control.common.file_catalog import package_yaml
from telex_control.common.params import read_config
from telex_teleop.arm.arm_settings import ArmTeleopSettings
from telex_teleop.flippers.flipper_settings import FlipperTeleopSettings
from telex_teleop.joints.joint_settings import GripperTeleopSettings
from telex_teleop.tracks.track_drive import TrackSettings

Settings = TypeVar("Settings")

ARM, FLIPPERS, GRIPPER = "arm_teleop", "flipper_teleop", "gripper_teleop"
TRACKS = "track_teleop"


class NodeSettings(NamedTuple):
    """Parameters of each of the nodes."""

    tracks: TrackSettings
    arm: ArmTeleopSettings
    flippers: FlipperTeleopSettings
    gripper: GripperTeleopSettings


def shipped_settings() -> NodeSettings:
    """Read the parameters of all nodes."""
    poses = package_yaml("telex_description", "config", "poses.yaml")
    return NodeSettings(
        _shipped(TrackSettings, TRACKS),
        _shipped(ArmTeleopSettings, ARM, more=poses),
        _shipped(FlipperTeleopSettings, FLIPPERS, "flipper_presets"),
        _shipped(GripperTeleopSettings, GRIPPER),
    )


def _shipped(
    kind: Type[Settings], *files: str, more: Optional[Mapping[str, Any]] = None
) -> Settings:
    values: Dict[str, Any] = {}
    for name in files:
        values.update(package_yaml("telex_teleop", "config", f"{name}.yaml"))
    return read_config(kind, {**values, **(more or {})}, files[0])
