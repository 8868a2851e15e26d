"""Pictures of a recording's moments, drawn again by the cameras that the robot had."""

from __future__ import annotations

from typing import Dict, Iterator, Optional, Sequence, Tuple

import numpy as np

from telex_control.common.params import read_config
from telex_sim.cameras.cameras_config import CamerasConfig
from telex_sim.cameras.optics.flaws import SOUND
from telex_sim.cameras.preview.still_cameras import StillCameras
from telex_sim.cameras.ros.failures import Broken, broken_of

from ..replay.cameras import replay_config
from ..replay.replay import Replay, SilentCameraError
from ..replay.scenery import base_of
from ..replay.timeline import Moment


def replay_cameras(replay: Replay) -> CamerasConfig:
    """Return the cameras of a recording as its replay has them."""
    robot = replay.timeline.parts[0].robot
    return read_config(CamerasConfig, replay_config(replay.cameras, robot, 0), str(replay.path))


def redrawn(
    replay: Replay, moments: Sequence[Moment], names: Sequence[str], width: Optional[int]
) -> Iterator[Dict[str, np.ndarray]]:
    """Draw moments of a recording, with light, lamps, zoom and all that failed as they were.

    A camera that sent nothing has its last picture, or a black one where it had sent none.

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
        eye = _Eye(replay, cameras)
        for moment in moments:
            yield eye.look(moment)
    finally:
        cameras.release()


class _Eye:
    """Sees a recording through cameras, moment after moment."""

    def __init__(self, replay: Replay, cameras: StillCameras) -> None:
        self._replay, self._cameras = replay, cameras
        self._shown: Optional[Tuple[str, Tuple[str, ...], Tuple[float, float]]] = None
        self._placed = -1
        self._switches: Dict[str, float] = {}
        self._broken = Broken()
        self._exposed: Dict[str, Tuple[float, float]] = {}
        self._sent: Dict[str, Tuple[int, np.ndarray]] = {
            name: (-1, np.zeros((camera.height, camera.width, 3), np.uint8))
            for name, camera in cameras.cameras.items()
        }

    def look(self, moment: Moment) -> Dict[str, np.ndarray]:
        """Return what the operator was sent at a moment."""
        due: Dict[str, Moment] = {}
        for name, (number, _) in self._sent.items():
            try:
                sent = self._replay.sent_by(name, moment)
            except SilentCameraError:
                continue
            if sent.number != number:
                due[name] = sent
        # Cameras take what moves from two moments in their order; a frozen one's is earlier.
        for name, sent in sorted(due.items(), key=lambda item: item[1].number):
            self._place(sent)
            zoom = self._switches.get(f"cameras/{name}/zoom", 1.0)
            exposed = self._exposed.get(name, (0.0, 0.0))
            flaws = self._broken.flaws.get(name, SOUND)
            picture = self._cameras.picture(name, zoom, exposed, flaws)
            self._sent[name] = (sent.number, picture)
        return {name: picture for name, (_, picture) in self._sent.items()}

    def _place(self, moment: Moment) -> None:
        """Have everything as it was at a moment."""
        if moment.number == self._placed:
            return
        self._placed = moment.number
        replay, part, light = self._replay, moment.part, self._replay.light(moment)
        if self._shown != (part.robot, part.names.objects, light):
            self._shown = (part.robot, part.names.objects, light)
            self._cameras.show(replay.scenery.description(moment, 1, light=light))
        radiation, malfunctions = replay.condition(moment)
        self._broken = broken_of(malfunctions)
        told = zip(radiation.names, radiation.dose_rate, radiation.dose)
        self._exposed = {name: (rate, dose) for name, rate, dose in told}
        self._switches = replay.switches(moment)
        lamps = {
            topic.split("/")[1]: level
            for topic, level in self._switches.items()
            if topic.startswith("lamps/")
        }
        levels = {name: level * self._broken.burns(name) for name, level in lamps.items()}
        poses = replay.scenery.poses(moment, 1, moment.stamp, base_of(moment))
        self._cameras.place(poses, levels)
