"""Pictures of a rehearsed robot's cameras, as late as everything else is seen."""

from __future__ import annotations

from typing import Dict, Mapping, Sequence

import numpy as np
from genpy import Time
from telex_msgs.msg import ScenePoses

from telex_sim.cameras.cameras_config import CamerasConfig
from telex_sim.cameras.optics.flaws import SOUND
from telex_sim.cameras.preview.still_cameras import StillCameras
from telex_sim.cameras.ros.failures import Broken, broken_of
from telex_sim.malfunctions.messages import malfunctions_message
from telex_sim.ros.scene_messages import SceneMessages

from ..rehearsal.trial import RehearsedTrial


class EpisodeViews:
    """Draws trials, one after the other, with cameras that fail as the robot's do.

    Parameters
    ----------
    names : sequence of str
        Cameras.
    width : int
        Of the pictures (pixels).
    levels : mapping of str to float
        Of the lamps, 0 to 1.

    Raises
    ------
    NoContextError
        There is no way to render on this machine.
    """

    def __init__(
        self, config: CamerasConfig, names: Sequence[str], width: int, levels: Mapping[str, float]
    ) -> None:
        self._names, self._levels = tuple(names), levels
        self._cameras = StillCameras(config, names, width)

    def begin(self, trial: RehearsedTrial) -> Sequence[str]:
        """Show another trial from now on; returns what of its scene cannot be shown, and why."""
        simulation = trial.simulation
        links = simulation.body.link_names()
        self._trial = trial
        self._messages = SceneMessages(simulation.config.model, links, trial.urdf, simulation.scene)
        self._messages.show(simulation.objects.objects())
        trial.port.keep_beside(self._poses)
        return self._cameras.show(self._messages.description(Time()))

    def _poses(self) -> ScenePoses:
        simulation = self._trial.simulation
        return self._messages.poses(Time.from_sec(simulation.time), simulation.link_poses())

    def look(self, poses: ScenePoses) -> Dict[str, np.ndarray]:
        """Take the cameras' pictures, in which everything is where the trial's port saw it.

        Returns
        -------
        dict of str to ndarray, shape (height, width, 3), uint8
            RGB.
        """
        broken = self._broken()
        levels = {name: level * broken.burns(name) for name, level in self._levels.items()}
        self._cameras.place(poses, levels)
        return {name: self._picture(name, broken) for name in self._names}

    def _broken(self) -> Broken:
        malfunctions = self._trial.simulation.robots[0].malfunctions
        if not malfunctions.active and not malfunctions.unpowered:
            return Broken()
        return broken_of(malfunctions_message(malfunctions))

    def _picture(self, name: str, broken: Broken) -> np.ndarray:
        flaws, exposed, works = broken.flaws.get(name, SOUND), (0.0, 0.0), broken.cameras_work
        readings = self._trial.readings
        for each in () if readings is None else readings.cameras:
            if each.name == name:
                exposed, works = (each.dose_rate, each.dose), works and not each.failed
        # What sends no pictures any more leaves its last one standing.
        flaws = flaws if works else flaws._replace(frozen=True)
        return self._cameras.picture(name, exposed=exposed, flaws=flaws)

    def close(self) -> None:
        """Free what draws."""
        self._cameras.release()
