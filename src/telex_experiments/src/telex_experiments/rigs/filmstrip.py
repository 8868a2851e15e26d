"""Filmstrips of trials: pictures side by side, drawn by the simulator's own renderer."""

from __future__ import annotations

from pathlib import Path
from typing import List, Sequence, Tuple

import cv2
import numpy as np
from genpy import Time

from telex_experiments.mobility.offline import OfflineTrial
from telex_experiments.mobility.suite import Obstacle, attempt
from telex_experiments.rigs.contact_sheet import captioned, sheet
from telex_sim.cameras.optics.pinhole import PinholeCamera
from telex_sim.cameras.preview.scene_preview import Subject, photograph
from telex_sim.cameras.preview.still import looking
from telex_sim.cameras.ros.messages import frames_from_message, scene_from_message
from telex_sim.ros.scene_messages import SceneMessages

SIZE = (420, 300)
_NEAR, _FAR, _FOV = 0.05, 100.0, 0.62


class _Film:
    """Keeps where everything was, at equal intervals of sim time."""

    def __init__(self, trial: OfflineTrial, interval: float) -> None:
        self._trial = trial
        simulation = trial.simulation
        self._messages = SceneMessages(
            simulation.config.model,
            simulation.body.link_names(),
            trial.urdf,
            simulation.scene,
        )
        self._messages.show(simulation.objects.objects())
        self._every = round(interval / trial.step_size)
        self.shots: List[Tuple[float, np.ndarray, np.ndarray]] = []
        trial.each_step.append(self._look)

    def _look(self) -> None:
        simulation = self._trial.simulation
        if simulation.steps % self._every == 0:
            scene_poses = self._messages.poses(Time(), simulation.link_poses())
            frames = frames_from_message(scene_poses, len(scene_poses.poses) // 7)
            self.shots.append((simulation.time, frames, self._trial.position()))

    def subject(self, frames: np.ndarray) -> Subject:
        """Scene with everything where it was."""
        scene, problems = scene_from_message(self._messages.description(Time()))
        if problems:
            raise RuntimeError("; ".join(problems))
        config = self._trial.simulation.config
        return Subject("film", scene, frames, (), config.model)


def filmstrip(
    obstacle: Obstacle,
    times: Sequence[float],
    side: Tuple[float, float, float],
    columns: int,
    path: Path,
) -> None:
    """Draw a trial of an obstacle.

    Parameters
    ----------
    times : sequence of float
        Shares of the way in time, from 0 to 1, one picture each.
    side : tuple of 3 floats
        From the robot to the camera (m).
    path : Path
        Of the PNG.
    """
    with obstacle.trial() as trial:
        film = _Film(trial, 0.1)
        outcome = attempt(obstacle, trial.operator)
        if not outcome.passed:
            raise RuntimeError(f"{obstacle.name}: {outcome.message}")
        last = len(film.shots) - 1
        chosen = [film.shots[round(share * last)] for share in times]
        cells = [_cell(film, *shot, side) for shot in chosen]
    path.parent.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(path), sheet(cells, columns), [cv2.IMWRITE_PNG_COMPRESSION, 9])


def _cell(
    film: _Film, time: float, frames: np.ndarray, place: np.ndarray, side: Sequence[float]
) -> np.ndarray:
    target = np.add(place, (0.0, 0.0, 0.15))
    camera = PinholeCamera(*SIZE, _FOV, _NEAR, _FAR)
    picture = photograph(film.subject(frames), camera, looking(target + side, target))
    return captioned(np.ascontiguousarray(picture[..., ::-1]), f"{time:.1f} s")
