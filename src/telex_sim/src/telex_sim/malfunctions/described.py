"""Parts that can fail of a robot that is only described: URDF and the shipped configuration."""

from __future__ import annotations

from typing import Any, Mapping, Tuple

from telex_control.common.file_catalog import package_yaml
from telex_control.urdf.joints import parse_urdf
from telex_control.urdf.transmission_parser import driven_and_watched

from ..offline.simulation import shipped_config
from .kinds import Parts


def shipped_equipment() -> Tuple[Mapping[str, Any], Mapping[str, Any]]:
    """Cameras and lamps of the shipped robot, by name, as the node ``cameras`` has them."""
    cameras, lamps = (
        package_yaml("telex_description", "config", f"{key}.yaml")[key]
        for key in ("cameras", "lamps")
    )
    return cameras, lamps


def described_parts(urdf: str) -> Parts:
    """Name what can fail of the robot of a URDF, as `Malfunctions.parts` does of a real one.

    Raises
    ------
    UrdfError
    """
    robot, config = parse_urdf(urdf), shipped_config()
    driven = {each.joint for each in driven_and_watched(robot)[0]}
    tracks = config.tracks
    belts = [belt for belt in tracks.belts if belt in driven]
    lifted = {robot.joint_map[belt].parent for belt in belts}
    moved = tuple(name for name in robot.joint_map if name in driven and name not in tracks.belts)
    fingers = [joint for finger in config.proximity.fingers for joint in finger]
    cameras, lamps = (
        tuple(name for name, each in sorted(given.items()) if each["frame"] in robot.link_map)
        for given in shipped_equipment()
    )
    return Parts(
        joints=moved,
        flippers=tuple(name for name in moved if robot.joint_map[name].child in lifted),
        belts=tuple(f"{name}_belt" for name in tracks.drives) if belts else (),
        gripper=any(joint in driven for joint in fingers),
        imus=tuple(config.hardware.imus),
        lamps=lamps,
        cameras=cameras,
        battery=config.battery is not None,
    )
