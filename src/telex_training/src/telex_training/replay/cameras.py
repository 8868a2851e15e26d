"""Configuration of the cameras' node for a replay, of what a recording says of its cameras."""

from __future__ import annotations

from typing import Any, Dict, List, Mapping, Sequence

from .scenery import OUTSIDE_FRAME

OUTSIDE = "outside"
"""Name of the camera that can be turned freely."""
CLEAR = "_clear"
"""Ends the names of cameras that show what the robot's would without noise and zoom."""
_RATE = 120.0
_REPEAT_RATE = 0.05
_OUTSIDE: Dict[str, Any] = {
    "frame": OUTSIDE_FRAME,
    "width": 640,
    "height": 480,
    "horizontal_fov": 1.05,
    "near": 0.05,
    "far": 150.0,
    "jpeg_quality": 85,
}


def replay_config(recorded: Mapping[str, Any], model: str, niceness: int) -> Dict[str, Any]:
    """Parameters of a cameras' node that draws a recording again.

    Each camera of the robot is there twice: as it was, and clear. Pictures are drawn of single
    moments: none waits for its turn, and none is drawn twice.

    Parameters
    ----------
    recorded : mapping
        Parameters of the cameras' node when the trial began.
    model : str
        Name of the robot in the scene.
    niceness : int
        See `telex_sim.cameras.cameras_config.CamerasConfig`.
    """
    cameras: Dict[str, Any] = {OUTSIDE: {**_OUTSIDE, "rate": _RATE}}
    for name, given in _cameras(recorded).items():
        exposure = given.get("exposure")
        seen = {**given, "rate": _RATE}
        if isinstance(exposure, Mapping):
            # Between two moments that are looked at, any time may have passed.
            seen["exposure"] = {**exposure, "time_constant": 0.0}
        cameras[name] = seen
        clear = {key: value for key, value in seen.items() if key not in ("radiation", "zoom_max")}
        cameras[name + CLEAR] = {**clear, "noise": 0.0}
    kept = ("egl_device", "lamps", "quality", "renderer", "seed", "shadow_radius")
    return {
        **{key: recorded[key] for key in (*kept, "software_threads") if key in recorded},
        "cameras": cameras,
        "model": model,
        "niceness": niceness,
        "repeat_rate": _REPEAT_RATE,
        "max_pose_age": 0.0,
        "shadow_period": 0.0,
        "smallest": 1.0,
    }


def camera_names(recorded: Mapping[str, Any], links: Sequence[str]) -> List[str]:
    """Names of the robot's cameras that it has a frame for, in order."""
    return [
        name for name, given in sorted(_cameras(recorded).items()) if given.get("frame") in links
    ]


def lamp_levels(recorded: Mapping[str, Any]) -> Dict[str, float]:
    """Level with which each lamp begins, by the topic that dims it."""
    lamps = recorded.get("lamps")
    found: Dict[str, float] = {}
    for name, given in lamps.items() if isinstance(lamps, Mapping) else ():
        level = given.get("level", 0.0) if isinstance(given, Mapping) else 0.0
        found[f"lamps/{name}/command"] = float(level) if isinstance(level, (int, float)) else 0.0
    return found


def _cameras(recorded: Mapping[str, Any]) -> Dict[str, Dict[str, Any]]:
    cameras = recorded.get("cameras")
    return {
        str(name): dict(given)
        for name, given in (cameras.items() if isinstance(cameras, Mapping) else ())
        if isinstance(given, Mapping)
    }
