"""Facts that pages draw their aids by: where a robot stands on tracks or wheels, and its tool."""

from __future__ import annotations

import math
from typing import Any, Callable, Dict, List, Optional

from telex_control.urdf.joints import UrdfError, parse_urdf
from telex_control.urdf.wheel_geometry import wheel_radius, wheel_separation
from telex_teleop.arm.arm_settings import FrameSettings
from telex_teleop.tracks.track_drive import TrackSettings

from .abilities import Parameters


def drawing_of(parameter: Parameters, prefix: str, warn: Callable[[str], None]) -> Dict[str, Any]:
    """Return what ``/robot.json`` says for drawing; what nothing tells is left out.

    That is ``tracks``, with ``axles`` (joints that turn them), ``radius`` and ``half_width`` over
    both sides (m), and ``tool``, a link.

    Parameters
    ----------
    parameter
        Parameters of the robot.
    prefix
        Of their names.
    warn
        Told why tracks or wheels are left out.
    """
    told: Dict[str, Any] = {}
    base = _struct(parameter(f"{prefix}track_teleop"))
    name = base.get("controller", TrackSettings.controller)
    controller = _struct(parameter(f"{prefix}{name}"))
    left, right = (_names(controller.get(f"{side}_wheel")) for side in ("left", "right"))
    if left and right:
        radius, apart = (_length(controller.get(f"wheel_{of}")) for of in ("radius", "separation"))
        half = _length(_struct(controller.get("braking")).get("half_width"))
        try:
            if radius is None or (half is None and apart is None):
                robot = parse_urdf(str(parameter(f"{prefix}robot_description")))
                radius = radius or wheel_radius(robot, left[0])
                apart = apart or wheel_separation(robot, left[0], right[0])
            width = {"radius": radius, "half_width": half or 0.5 * (apart or 0.0)}
            told["tracks"] = {"axles": [*left, *right], **width}
        except UrdfError as error:
            warn(f"no guide lines: {error}")
    arm = _struct(parameter(f"{prefix}arm_teleop"))
    if arm:
        tool = _struct(arm.get("frames")).get("tool", FrameSettings.tool)
        told.update({"tool": tool} if isinstance(tool, str) else {})
    return told


def _struct(told: object) -> Dict[str, Any]:
    return told if isinstance(told, dict) else {}


def _names(told: object) -> List[str]:
    names = told if isinstance(told, list) else [told]
    return [name for name in names if isinstance(name, str)]


def _length(told: object) -> Optional[float]:
    """Return a length that is one (m)."""
    if isinstance(told, (int, float)) and math.isfinite(told) and told > 0.0:
        return float(told)
    return None
