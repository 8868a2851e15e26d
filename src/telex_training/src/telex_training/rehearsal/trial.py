"""A trial in one process with the simulation: what a scripted expert does, and its score sheet."""

from __future__ import annotations

import io
import json
import tempfile
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from random import Random
from typing import Any, Dict, Iterator, List, Optional, Tuple

import genpy
from nav_msgs.msg import Odometry
from std_msgs.msg import String
from telex_msgs.msg import SimStatus

from telex_sim.engine.exposure import Exposure, Readings
from telex_sim.malfunctions.described import shipped_equipment
from telex_sim.malfunctions.messages import malfunctions_message
from telex_sim.offline.robot import OfflineRobot
from telex_sim.offline.simulation import OfflineSimulation
from telex_sim.radiation.messages import doses_message
from telex_sim.scene.robot_in_scene import robot_description
from telex_sim.stability.monitor import StabilityMonitor
from telex_sim.truth.messages import names_message, sample_message
from telex_sim.truth.sampler import TruthSampler

from ..exercises.model import PRACTICE, Exercise, Failure
from ..exercises.questions import named_entries, right_answers
from ..exercises.seeds import scene_text
from ..judging.entries import (
    DOSES,
    INPUTS,
    MALFUNCTIONS,
    NAMES,
    ODOMETRY,
    ODOMETRY_PERIOD,
    STATUS,
    TRUTH,
    Entry,
)
from ..judging.judge import Judge
from ..judging.records.other_robot import channel_of
from ..judging.trial_record import ENDED
from ..operators.experts.brief import Brief, Expert
from ..operators.handling import Hand
from ..operators.port import Command, NotManagedError
from ..operators.station import Station
from ..ros.commands import message_of
from .line_port import PATIENCE, LineTeleop, line_setting
from .together import Together

_SETTLING = 0.2
"""Between the inputs and the expert, and for how long the robot stands before (s)."""
_PATIENCE = 5.0
"""How long the judge may need after the expert has done (s)."""


class _EndedError(Exception):
    """The judge has ended the trial: what an expert still does is of no use."""


def rehearse(exercise: Exercise, expert: Expert, seed: Optional[int] = None) -> Dict[str, Any]:
    """Let an expert do one repetition of an exercise.

    Parameters
    ----------
    exercise : Exercise
        In one of its settings.
    expert : callable
    seed : int, optional
        That of practice by default.

    Returns
    -------
    dict
        The score sheet of a trial of this one repetition.

    Raises
    ------
    telex_training.operators.port.NotManagedError
        The expert gave up; the message says what was tried, and where.
    """
    if seed is None:
        seed = practice_seed(exercise)
    return rehearsed(exercise, expert, seed).judge.sheet()


def practice_seed(exercise: Exercise) -> int:
    """Seed with which an exercise is practised."""
    return exercise.seeds.of(PRACTICE) or 0


def rehearsed(exercise: Exercise, expert: Expert, seed: int) -> RehearsedTrial:
    """Let an expert do one repetition of an exercise; returns the trial, which has ended.

    Raises
    ------
    telex_training.operators.port.NotManagedError
    """
    with rehearsed_trial(exercise, seed) as trial:
        trial.begin()
        trial.perform(expert)
    return trial


def rehearse_to_end(
    exercise: Exercise, expert: Expert, seed: int, line: str = ""
) -> Tuple[RehearsedTrial, str]:
    """Let an expert do one repetition of an exercise; who gives up has failed.

    Parameters
    ----------
    exercise : Exercise
        In one of its settings.
    expert : callable
    line : str
        See `line_setting`.

    Returns
    -------
    tuple of RehearsedTrial and str
        The trial, which has ended, and why the expert gave up; empty: he did not.
    """
    problem = ""
    with rehearsed_trial(exercise, seed, line) as trial:
        trial.begin()
        try:
            trial.perform(expert)
        except NotManagedError as error:
            problem = str(error) or type(error).__name__
        trial.abort()
    return trial, problem


def single(exercise: Exercise) -> Exercise:
    """Return an exercise of one repetition."""
    return replace(exercise, repetitions=replace(exercise.repetitions, most=1, least=1))


@contextmanager
def rehearsed_trial(exercise: Exercise, seed: int, line: str = "") -> Iterator[RehearsedTrial]:
    """Make a trial of one repetition, whose simulation ends with the context."""
    with tempfile.TemporaryDirectory() as folder:
        trial = RehearsedTrial(single(exercise), seed, Path(folder), line)
        try:
            yield trial
        finally:
            trial.close()


class RehearsedTrial:
    """An exercise's scene in the simulation, whose truth and commands a judge is fed with.

    Parameters
    ----------
    exercise : Exercise
        In one of its settings.
    folder : Path
        For the scene's file.
    line : str
        Profile of the line between operator and robot, see `line_setting`.
    patience : float
        As of `LineTeleop`.

    Attributes
    ----------
    entries : list of Entry
        All that it was fed with.
    scene, urdf : str
        Texts of the scene as it was loaded, and of the robot.
    urdfs : dict of str to str
        Texts of further robots, by the exercise's names.
    step_size : float
        Of the simulation (s).
    readings : Readings, optional
        What the first robot has received; None where nothing is told.
    ports : dict of str to TeleopPort
        To each robot, by the exercise's names, the first one's "" ; what is sent through them, the
        judge hears.
    port : TeleopPort
        To the first robot.
    """

    def __init__(
        self,
        exercise: Exercise,
        seed: int,
        folder: Path,
        line: str = "",
        patience: float = PATIENCE,
    ) -> None:
        self._exercise, self._seed = exercise, seed
        self.scene = text = scene_text(exercise, seed)
        path = folder / f"{exercise.name}.yaml"
        path.write_text(text, encoding="utf-8")
        self.urdf = urdf = robot_description(exercise.variant)
        self._answers = right_answers(exercise, text)
        entries = named_entries(text)
        known = {each.name: each.answer for each in exercise.questions if each.answer}
        self._brief = Brief(exercise.setting, entries, {**known, **self._answers})
        self.entries: List[Entry] = []
        offline = OfflineSimulation(urdf, world=str(path))
        self.simulation = offline.simulation
        robot = self.simulation.robots[0]
        self.urdfs = {
            each.name: robot_description(each.variant or exercise.variant)
            for each in exercise.robots
        }
        self.judge = Judge(exercise, text, urdf, self.urdfs)
        robots = {"": OfflineRobot(offline)}
        for name, description in self.urdfs.items():
            # Whatever the exercise calls it, nothing else in the scene may be called so.
            node = offline.add_robot(f"{robot.model}_{name}", description)
            robots[name] = OfflineRobot(offline, node)
        self.readings: Optional[Readings] = None
        self._robots = [_Robot(name, each) for name, each in robots.items()]
        self._number = self._sequence = 0
        publish, step = self.simulation.config.publish, self.simulation.config.timing.step_size
        self._truth_every = round(1.0 / (publish.truth_rate * step))
        self._stability_every = round(1.0 / (publish.stability_rate * step))
        self._doses_every = round(1.0 / (robot.config.dosimetry.rate * step))
        self.step_size = step
        self._together = Together(self._step)
        for each in self._robots:
            self._feed(NAMES, names_message(each.sampler.names, 1), each.name)
        self._odometry_due = 0.0
        if exercise.survey is not None:
            offline.node.subscribe(ODOMETRY, Odometry, self._hear_odometry)
        self.ports = {
            name: LineTeleop(
                each,
                self.advance,
                self.answer,
                partial(self.hear, robot=name),
                line_setting(exercise, line),
                Random(seed),
                patience,
            )
            for name, each in robots.items()
        }
        self.port = self.ports[""]

    @property
    def steps(self) -> int:
        """How many steps the simulation has made."""
        return int(self.simulation.steps)

    def begin(self) -> None:
        """Open and start the trial, until the judge waits for the first repetition's begin."""
        self._input(
            "open",
            operator="script",
            mode=PRACTICE,
            setting=self._exercise.setting,
            seed=self._seed,
        )
        self._input("start")
        self._input("drawn", answers=self._answers)
        self._input("ready")
        self.advance(_SETTLING)

    def perform(self, expert: Expert) -> None:
        """Let an expert work until the judge has seen enough, or for some seconds longer.

        Where there are several robots, there is one expert for each, all at once.

        Raises
        ------
        NotManagedError
        """
        try:
            if len(self.ports) == 1:
                self._operate(expert, "")
            else:
                self._together.run([partial(self._operate, expert, name) for name in self.ports])
        except _EndedError:
            return

    def _operate(self, expert: Expert, robot: str) -> None:
        station = Station(self.ports[robot])
        expert(Hand(station), replace(self._brief, robot=robot))
        station.release()
        station.wait(_PATIENCE)

    def abort(self) -> None:
        """End the trial where the judge has not."""
        if self.judge.phase != ENDED:
            self._input("abort")

    def advance(self, seconds: float) -> None:
        """Let so much sim time (s) pass.

        Raises
        ------
        _EndedError
            The trial has ended.
        """
        self._together.wait(round(seconds / self.step_size))

    def _step(self, steps: int) -> None:
        if self.judge.phase == ENDED:
            raise _EndedError
        for _ in range(steps):
            self.simulation.step()
            steps = self.simulation.steps
            if steps % self._stability_every == 0:
                self._watch()
            if steps % self._truth_every == 0:
                self._sample()
            if steps % self._doses_every == 0:
                self._expose()

    def answer(self, question: str, answer: str) -> None:
        """Tell the judge what the operator answers."""
        self._input("answer", question=question, answer=answer)

    def hear(self, command: Command, robot: str = "") -> None:
        """Tell the judge what an operator commands, of the first robot where none is named."""
        topic, message = message_of(command)
        self._feed(topic, message, robot)

    def _watch(self) -> None:
        time = self.simulation.time
        for each in self._robots:
            each.monitor.observe(time)
            each.monitor.margin(time)
            if each.monitor.stuck != each.stuck:
                each.stuck = each.monitor.stuck
                self._feed(STATUS, SimStatus(stuck=each.stuck), each.name)

    def _sample(self) -> None:
        time = self.simulation.time
        self._sequence += 1
        for each in self._robots:
            message = sample_message(each.sampler.sample())
            message.sequence, message.steps = self._sequence, self.simulation.steps
            message.revision, message.wall_time = 1, time
            message.margin = each.monitor.warning.margin
            message.header.stamp = genpy.Time.from_sec(time)
            self._feed(TRUTH, message, each.name)

    def _hear_odometry(self, message: Odometry) -> None:
        time = self.simulation.time
        if time >= self._odometry_due:
            self._odometry_due = time + ODOMETRY_PERIOD
            self._feed(ODOMETRY, message)

    def _expose(self) -> None:
        for each in self._robots:
            readings = each.exposure.observe(self.simulation)
            if readings is not None:
                self._feed(DOSES, doses_message(readings.components), each.name)
            if not each.name:
                self.readings = readings

    def _input(self, kind: str, **fields: Any) -> None:
        self._feed(INPUTS, String(data=json.dumps({"input": kind, **fields})))

    def _feed(self, channel: str, message: Any, robot: str = "") -> None:
        self._number += 1
        buffer = io.BytesIO()
        message.serialize(buffer)
        time, data = self.simulation.time, buffer.getvalue()
        entry = Entry(self._number, time, channel_of(robot, channel), message._type, data)
        self.entries.append(entry)
        self.judge.feed(entry)
        for failure in self.judge.take_due():
            self._fail(failure)

    def _fail(self, failure: Failure) -> None:
        """Let something of a robot fail, and tell the judge as the simulator would."""
        malfunctions = next(
            each.malfunctions for each in self._robots if each.name == failure.robot
        )
        malfunctions.begin(
            failure.what, failure.kind, failure.value, failure.announced, self.simulation.time
        )
        self._feed(MALFUNCTIONS, malfunctions_message(malfunctions), failure.robot)

    def close(self) -> None:
        """End the simulation."""
        for each in self._robots:
            each.sampler.close()
        self.simulation.close()


class _Robot:
    """What is watched of one of the robots; the first has no name."""

    def __init__(self, name: str, watched: OfflineRobot) -> None:
        self.name = name
        self.sampler = TruthSampler(watched.simulation, watched.robot)
        self.monitor = StabilityMonitor(watched.robot)
        self.exposure = Exposure(watched.robot, lambda: shipped_equipment()[0])
        self.malfunctions = watched.robot.malfunctions
        self.malfunctions.equip(*shipped_equipment())
        self.stuck = False
