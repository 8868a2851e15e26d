"""Exercises as environments of Gymnasium: one repetition of a rehearsed trial is an episode."""

from __future__ import annotations

import math
import tempfile
from pathlib import Path
from typing import Any, Dict, Mapping, Optional, Sequence, Tuple, Union

import gymnasium
import numpy as np
from gymnasium import logger
from gymnasium.error import ResetNeeded
from gymnasium.spaces import Box
from gymnasium.spaces import Dict as DictSpace

from telex_control.kinematics import quaternion_of
from telex_sim.cameras.cameras_config import shipped_cameras
from telex_sim.cameras.preview.still_cameras import sized
from telex_sim.offline.simulation import shipped_config
from telex_sim.scene.robot_in_scene import robot_description

from ..exercises.catalog import find_exercise
from ..exercises.exercise_file import load_exercise
from ..judging.trial_record import ENDED, RUNNING
from ..rehearsal.figures import spread
from ..rehearsal.line_port import line_setting
from ..rehearsal.trial import RehearsedTrial, single
from .command_vector import USUAL, CommandVector, checked, pose_names, state_names
from .reward import Reward, require_terms
from .views import EpisodeViews

Observed = Union[np.ndarray, Dict[str, np.ndarray]]

STATE = "state"
"""Name of the numbers among pictures."""
RATES = (1.0, 100.0)
"""Of actions (1/s of sim time)."""
_REPEATED = 0.1
"""Time after which a command that is held is sent again (s), as a console does."""


class ExerciseEnv(gymnasium.Env):
    """An exercise, operated through the cores of the teleoperation nodes and judged by the judge.

    See docs/engineer/research.md for what actions, observations and rewards are.

    Parameters
    ----------
    exercise : str
        Name, or a file's path.
    setting : str
        Empty: the first.
    line : str
        Profile of the line between operator and robot; empty: what the exercise asks for.
    parts : sequence of str
        What the action moves, see `CommandVector`.
    objects : sequence of str
        Objects, or links of them ("object/link"), whose true poses are part of the state.
    cameras : sequence of str
        Cameras whose pictures are observed.
    width : int
        Of the pictures (pixels); the height follows.
    rate : float
        Of actions (1/s of sim time).
    lamps : float, optional
        Level of all lamps, 0 to 1; None: as each begins.
    weights : mapping of str to float, optional
        Of the terms of the reward, see `Reward`.
    render_mode : str, optional
        ``rgb_array``: `render` returns the first camera's picture, or the front one's.

    Attributes
    ----------
    state_names, action_names : tuple of str

    Raises
    ------
    ValueError
        An argument is wrong; ExerciseError and ConfigError are such errors.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 10}

    def __init__(
        self,
        exercise: str,
        setting: str = "",
        line: str = "",
        parts: Sequence[str] = USUAL,
        objects: Sequence[str] = (),
        cameras: Sequence[str] = (),
        width: int = 160,
        rate: float = 10.0,
        lamps: Optional[float] = None,
        weights: Optional[Mapping[str, float]] = None,
        render_mode: Optional[str] = None,
    ) -> None:
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise ValueError(f"render_mode is {render_mode!r}; rgb_array is possible")
        if lamps is not None and not 0.0 <= lamps <= 1.0:
            raise ValueError(f"lamps is {lamps}; 0 to 1 is possible")
        self.render_mode = render_mode
        self.metadata = {**self.metadata, "render_fps": rate}
        self._exercise = single(spread(load_exercise(find_exercise(exercise)).setting(setting)))
        if self._exercise.robots:
            count = 1 + len(self._exercise.robots)
            raise ValueError(f"exercise is '{exercise}', which needs {count} robots; one acts here")
        self._line = line
        line_setting(self._exercise, line)
        self._steps = _steps(rate)
        self._weights = dict(weights or {})
        require_terms(self._weights)
        urdf = robot_description(self._exercise.variant)
        self._commands = CommandVector(urdf, parts)
        self._objects, self._cameras = tuple(objects), tuple(cameras)
        self.action_names = self._commands.names
        self.state_names = state_names(self._commands.joints)
        for name in self._objects:
            self.state_names += pose_names(name)
        self._config = shipped_cameras()
        self._levels = {
            name: lamp.level if lamps is None else float(lamps)
            for name, lamp in self._config.lamps.items()
        }
        self._drawn = self._cameras or (("front",) if render_mode else ())
        self._width = width
        most = self._commands.most.astype(np.float32)
        self.action_space = Box(-most, most, dtype=np.float32)
        self.observation_space = self._space(sized(self._config, self._drawn, width))
        self._folder: Optional[tempfile.TemporaryDirectory[str]] = None
        self._trial: Optional[RehearsedTrial] = None
        self._views: Optional[EpisodeViews] = None
        self._pictures: Dict[str, np.ndarray] = {}
        self._moving: Tuple[str, ...] = ()
        self._over = True

    def _space(self, cameras: Mapping[str, Any]) -> gymnasium.Space:
        state = Box(-np.inf, np.inf, (len(self.state_names),), np.float32)
        if not self._cameras:
            return state
        pictures = {
            name: Box(0, 255, (cameras[name].height, cameras[name].width, 3), np.uint8)
            for name in self._cameras
        }
        return DictSpace({STATE: state, **pictures})

    # --- an episode ------------------------------------------------------------------------------

    def reset(
        self, *, seed: Optional[int] = None, options: Optional[Dict[str, Any]] = None
    ) -> Tuple[Observed, Dict[str, Any]]:
        """Begin an episode.

        Parameters
        ----------
        seed : int, optional
            Of the trial, as in a rehearsal; None: one is drawn.
        options : dict, optional
            Nothing is possible.

        Raises
        ------
        ValueError
            There are options, or an object that is to be seen is not there.
        """
        if options:
            raise ValueError(f"options has {', '.join(map(str, options))}; none are known")
        super().reset(seed=seed)
        number = int(self.np_random.integers(1, 2**31)) if seed is None else seed
        self._end()
        self._folder = tempfile.TemporaryDirectory()
        folder = Path(self._folder.name)
        # Who learns may wait for as long as the episode lasts.
        trial = RehearsedTrial(self._exercise, number, folder, self._line, math.inf)
        self._trial = trial
        if self._commands.tool:
            trial.port.set_mode("CARTESIAN")
        trial.begin()
        for name in self._objects:
            if trial.port.object_pose(name) is None:
                known = ", ".join(trial.simulation.objects.frames())
                raise ValueError(f"objects has '{name}', which does not move here; {known} do")
        self._reward = Reward(self._exercise, trial.judge.state(), self._weights)
        self._moving, self._over = (), False
        if self._drawn:
            if self._views is None:
                self._views = EpisodeViews(self._config, self._drawn, self._width, self._levels)
            problems = self._views.begin(trial)
            if problems:
                logger.warn(f"not all of the scene is shown: {'; '.join(problems)}")
        return self._observe(trial), {"seed": number, **self._facts(trial)}

    def step(self, action: Any) -> Tuple[Observed, float, bool, bool, Dict[str, Any]]:
        """Hold an action's commands for a period.

        Raises
        ------
        ValueError
            The action is wrong; nothing was done.
        gymnasium.error.ResetNeeded
            The episode is over.
        """
        trial = self._running()
        values = checked(action, self.action_names)
        values = np.clip(values, -self._commands.most, self._commands.most)
        done = 0
        while done < self._steps and trial.judge.phase != ENDED:
            for command in self._commands.commands(values, self._moving):
                trial.port.send(command)
            self._moving = self._commands.moving(values)
            now = min(self._steps - done, max(1, round(_REPEATED / trial.step_size)))
            trial.port.advance(now * trial.step_size)
            done += now
        terms = self._reward.terms(trial.judge.state())
        terminated = self._reward.ended
        truncated = trial.judge.phase == ENDED and not terminated
        self._over = terminated or truncated
        facts = {**self._facts(trial), "reward_terms": terms}
        if self._over:
            facts["passed"] = terminated and trial.judge.sheet()["repetitions"][0]["passed"]
        return self._observe(trial), math.fsum(terms.values()), terminated, truncated, facts

    def _observe(self, trial: RehearsedTrial) -> Observed:
        seen, poses = trial.port.look()
        assert seen.base is not None
        numbers = [*seen.base.position, *seen.base.orientation]
        numbers += [seen.positions[joint] for joint in self._commands.joints]
        for name in self._objects:
            pose = trial.port.object_pose(name)
            assert pose is not None
            numbers += [*pose[:3, 3].tolist(), *quaternion_of(pose).tolist()]
        state = np.array(numbers, dtype=np.float32)
        self._pictures = self._views.look(poses) if self._views is not None else {}
        if not self._cameras:
            return state
        return {STATE: state, **self._pictures}

    def _facts(self, trial: RehearsedTrial) -> Dict[str, Any]:
        """Return what the judge says that is no part of an observation."""
        state = trial.judge.state()
        failed = self._reward.ended and not self._reward.succeeded
        return {
            "phase": state["phase"],
            "elapsed": float(state["elapsed"]),
            "penalty": float(state["penalty"]),
            "steps_done": int(sum(state["steps_done"])),
            "is_success": self._reward.succeeded,
            "fault": state["results"][-1] if failed else "",
        }

    # --- beside actions --------------------------------------------------------------------------

    def answer(self, question: str, answer: str) -> None:
        """Answer a question of the exercise, as the console does.

        Raises
        ------
        ValueError
            There is no such question, or the repetition has not begun.
        gymnasium.error.ResetNeeded
            The episode is over.
        NotManagedError
            Nothing has come by the line for a minute.
        """
        names = [each.name for each in self._exercise.questions]
        if question not in names:
            raise ValueError(f"question is {question!r}; there are: {', '.join(names) or 'none'}")
        trial = self._running()
        if trial.judge.phase != RUNNING:
            raise ValueError(f"question {question!r}: the repetition has not begun")
        trial.port.answer(question, answer)

    def sheet(self) -> str:
        """Return the score sheet of the episode, as a recording has it; empty: there is none."""
        return "" if self._trial is None else self._trial.judge.text()

    def render(self) -> Optional[np.ndarray]:
        """Return the first camera's picture, or the front one's; shape (height, width, 3)."""
        return self._pictures.get(self._drawn[0]) if self.render_mode else None

    def close(self) -> None:
        """End the simulation, and free what draws."""
        self._end()
        if self._views is not None:
            self._views.close()
            self._views = None

    def _running(self) -> RehearsedTrial:
        if self._trial is None or self._over:
            raise ResetNeeded("the episode is over; reset begins another one")
        return self._trial

    def _end(self) -> None:
        self._over = True
        if self._trial is not None:
            self._trial.close()
            self._trial = None
        if self._folder is not None:
            self._folder.cleanup()
            self._folder = None


def _steps(rate: float) -> int:
    """Return how many steps of the simulation a period takes.

    Raises
    ------
    ValueError
    """
    step = shipped_config().timing.step_size
    if not RATES[0] <= rate <= RATES[1]:
        raise ValueError(f"rate is {rate}; {RATES[0]:g} to {RATES[1]:g} 1/s is possible")
    count = round(1.0 / (rate * step))
    if abs(count * rate * step - 1.0) > 1e-6:
        raise ValueError(f"rate is {rate} 1/s; its period must be a multiple of {step:g} s")
    return count
