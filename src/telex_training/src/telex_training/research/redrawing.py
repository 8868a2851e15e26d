"""Pictures of a recording's moments, drawn again by the cameras that the robot had."""

from __future__ import annotations

from typing import Dict, Iterator, Optional, Sequence, Tuple

import numpy as np

from telex_control.common.params import read_config
from telex_sim.cameras.cameras_config import CamerasConfig
from telex_sim.cameras.preview.still_cameras import StillCameras

from ..replay.cameras import replay_config
from ..replay.replay import Replay
from ..replay.scenery import base_of
from ..replay.timeline import Moment


def replay_cameras(replay: Replay) -> CamerasConfig:
    """Return the cameras of a recording as its replay has them."""
    robot = replay.timeline.parts[0].robot
    return read_config(CamerasConfig, replay_config(replay.cameras, robot, 0), str(replay.path))


def redrawn(
    replay: Replay, moments: Sequence[Moment], names: Sequence[str], width: Optional[int]
) -> Iterator[Dict[str, np.ndarray]]:
    """Draw moments of a recording, with lamps and zoom as they were.

    Parameters
    ----------
    names : sequence of str
        Cameras.
    width : int, optional
        Of the pictures (pixels); None: as the cameras have it.

    Yields
    ------
    dict of str to ndarray, shape (height, width, 3), uint8
        RGB, by camera.

    Raises
    ------
    ConfigError
        There is no such camera.
    NoContextError
        There is no way to render on this machine.
    """
    if not names:
        yield from ({} for _ in moments)
        return
    cameras = StillCameras(replay_cameras(replay), names, width)
    try:
        shown: Optional[Tuple[str, Tuple[str, ...]]] = None
        for moment in moments:
            part = moment.part
            if shown != (part.robot, part.names.objects):
                shown = (part.robot, part.names.objects)
                cameras.show(replay.scenery.description(moment, 1))
            switches = replay.switches(moment)
            levels = {
                topic.split("/")[1]: level
                for topic, level in switches.items()
                if topic.startswith("lamps/")
            }
            poses = replay.scenery.poses(moment, 1, moment.stamp, base_of(moment))
            cameras.place(poses, levels)
            yield {
                name: cameras.picture(name, switches.get(f"cameras/{name}/zoom", 1.0))
                for name in names
            }
    finally:
        cameras.release()
