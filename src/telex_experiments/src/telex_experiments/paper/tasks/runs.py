"""Tasks of figure 9 run after run, and the course of figure 10, in a session."""

from __future__ import annotations

import contextlib
from typing import TYPE_CHECKING, Any, Callable, Dict, List, Optional, Sequence, Tuple

import yaml
from std_srvs.srv import Empty
from telex_msgs.srv import Delete, Spawn

from telex_training.operators.handling import Hand
from telex_training.operators.port import NotManagedError
from telex_training.operators.station import Station
from telex_training.operators.tasks.course import SECTIONS, WORLD, Section
from telex_training.operators.tasks.task import OperatorTask, Verdict
from telex_training.ros.live_robot import LiveRobot

from ...workspace import SCENES
from ..experiment import Cell, Figure, ReportPicture, ReportTable, Result
from ..recorder import FEW_PICTURES, PICTURES
from .film import Film

if TYPE_CHECKING:
    from ..session import PaperSession

RUNS, QUICK_RUNS = 10, 2
ENOUGH = 9
"""Of ten runs; of fewer, all."""

_SETTLING = 1.0
"""How long (s) all keys are let go of after a reset, so that the nodes obey again."""
_FILM: Dict[str, Any] = {"rate": 4.0, "priority": 2, "width": 640, "height": 360}
"""How the film's camera draws: little, and before the others where there is time for some only."""
_STRIP, _COLUMNS = 8, 4


class TaskRuns:
    """Runs of a task on one simulator.

    Parameters
    ----------
    make : callable
        Makes the task.
    cameras : sequence of str
        Those whose pictures are recorded; fewer of them after the first run, but where an operator
        looks through them.
    real_time_factor : float
        Sim time per wall time, at most; where the machine cannot, it is slower.
    looks : bool
        Whether the operator looks through the cameras.
    """

    def __init__(
        self,
        session: PaperSession,
        make: Callable[[], OperatorTask],
        cameras: Sequence[str],
        real_time_factor: float,
        looks: bool = False,
    ) -> None:
        self._session = session
        self._make = make
        self._cameras = tuple(cameras)
        self._factor = real_time_factor
        self._later = PICTURES if looks else FEW_PICTURES
        self._rows: List[List[Cell]] = []
        self._names: List[str] = []

    def carry_out(self) -> Result:
        """Carry out all runs."""
        session = self._session
        runs = QUICK_RUNS if session.quick else RUNS
        with session.simulator(
            world=str(SCENES / "paper_grasping.yaml"),
            pose="ready",
            real_time_factor=self._factor,
            console=False,
        ), contextlib.closing(LiveRobot(session.namespace)) as robot:
            hand = Hand(Station(robot))
            session.configure_camera("overview", **_FILM)
            for number in range(1, runs + 1):
                self._run(number, runs, robot, hand)
        return self._result(runs)

    def _run(self, number: int, runs: int, robot: LiveRobot, hand: Hand) -> None:
        session, task, station = self._session, self._make(), hand.station
        things = task.lay_out(session.rng("run", number))
        first = number == 1
        bag, rate = f"run_{number:02d}", PICTURES if first else self._later
        with contextlib.ExitStack() as stack:
            try:
                self._prepare(robot, station, things, task.subject)
            except NotManagedError as error:
                self._note(number, things, task, Verdict(False, 0.0, "not begun"), 0.0, str(error))
                return
            film: Optional[Film] = None
            if first:
                film = stack.enter_context(contextlib.closing(Film(station, robot.node)))
            stack.enter_context(session.record(bag, cameras=self._cameras, rate=rate))
            if film is not None:
                film.look_from(*task.view)
                with contextlib.suppress(NotManagedError):
                    film.wait()
            task.begin(station)
            began, said = station.time, "done"
            try:
                station.mode("CARTESIAN")
                task.act(hand)
            except NotManagedError as error:
                said = f"given up: {error}"
            taken = station.time - began
            with contextlib.suppress(NotManagedError):
                station.rest()
            verdict = task.judge(station)
            if film is not None:
                with contextlib.suppress(NotManagedError):
                    film.strip(session.folder / "film.jpg", _STRIP, _COLUMNS)
        self._note(number, things, task, verdict, taken, said)
        session.say(
            f"run {number} of {runs}: {'done' if verdict.done else 'MISSED'}, {verdict.text}, "
            f"{taken:.0f} s of sim time; the operator says: {said}"
        )

    def _prepare(
        self,
        robot: LiveRobot,
        station: Station,
        things: Dict[str, Dict[str, Any]],
        subject: str,
    ) -> None:
        """Clear away what the last run left, put the robot back, and lay out the new things."""
        station.release()
        station.stop()
        for name in self._names:
            _ask(robot, "sim/delete", Delete, name=name)
        self._names = []
        robot.call("sim/reset", Empty)
        station.wait(_SETTLING)
        for name, entry in things.items():
            _ask(robot, "sim/spawn", Spawn, name=name, object=yaml.safe_dump(entry), folder="")
            self._names.append(name)
        # What cannot move, as a table, has no pose of its own.
        station.until(
            lambda: robot.object_pose(subject) is not None, 10.0, f"the pose of {subject}"
        )

    def _note(
        self,
        number: int,
        things: Dict[str, Dict[str, Any]],
        task: OperatorTask,
        verdict: Verdict,
        taken: float,
        said: str,
    ) -> None:
        entry = things[task.subject]
        x, y = entry["position"][:2]
        row: List[Cell] = [number, x, y, entry["yaw"], verdict.done, verdict.measure, taken]
        self._rows.append([*row, verdict.text, said])
        self._measure = task.measure

    def _result(self, runs: int) -> Result:
        done = sum(bool(row[4]) for row in self._rows)
        head = ["run", "x (m)", "y (m)", "yaw (rad)", "done", self._measure, "sim time (s)"]
        head += ["ground truth", "operator"]
        bar = ENOUGH if runs == RUNS else runs
        result = Result(
            figures=[Figure("done", done, f"of {runs} runs", at_least=bar)],
            tables=[ReportTable("The runs", "runs.csv", head, self._rows)],
            bags=[f"run_{row[0]:02d}.bag" for row in self._rows],
        )
        folder = self._session.folder
        result.bags = [bag for bag in result.bags if (folder / bag).exists()]
        if (folder / "film.jpg").exists():
            caption = "Run 1 as the instructor's camera sees it; sim time."
            result.pictures.append(ReportPicture("Run 1", "film.jpg", caption))
        return result


def drive_course(session: PaperSession) -> Result:
    """Drive the course of figure 10, its sections in one go."""
    result = Result()
    rows: List[List[Cell]] = []
    with session.simulator(
        world=str(SCENES / WORLD), pose="drive", real_time_factor=1.5, console=False
    ), contextlib.closing(LiveRobot(session.namespace)) as robot, contextlib.ExitStack() as stack:
        station = Station(robot)
        film = stack.enter_context(contextlib.closing(Film(station, robot.node)))
        session.configure_camera("overview", **_FILM)
        with session.record("course", cameras=("front",)):
            failed = ""
            for section in SECTIONS:
                done, taken, said = False, 0.0, f"not begun: {failed} was not done"
                if not failed:
                    done, taken, said = _drive(section, station, film, session, result)
                if not done and not failed:
                    failed = section.name
                session.say(f"{section.title}: {said}, {taken:.0f} s of sim time")
                rows.append([section.title, done, taken, said])
                result.figures.append(Figure(section.title, float(done), "done", at_least=1.0))
    strips = len(result.pictures)
    result.figures.append(Figure("filmstrips", strips, "", at_least=len(SECTIONS)))
    head = ["section", "done", "sim time (s)", "operator"]
    result.tables.append(ReportTable("The sections", "sections.csv", head, rows))
    result.bags.append("course.bag")
    return result


def _drive(
    section: Section, station: Station, film: Film, session: PaperSession, result: Result
) -> Tuple[bool, float, str]:
    """Drive a section; return whether it was done, how long it took (s), and what was said."""
    film.look_from(*section.view)
    station.wait(1.0)
    film.cut()
    with contextlib.suppress(NotManagedError):
        film.wait()
    began, done, said = station.time, True, "done"
    try:
        section.drive(station)
    except NotManagedError as error:
        done, said = False, f"given up: {error}"
    taken = station.time - began
    station.rest()
    name = f"{section.name}.jpg"
    try:
        film.strip(session.folder / name, section.pictures, _COLUMNS)
        result.pictures.append(
            ReportPicture(section.title, name, "The instructor's camera; sim time.")
        )
    except NotManagedError as error:
        said = f"{said}; but there is no filmstrip: {error}"
    return done, taken, said


def _ask(robot: LiveRobot, service: str, kind: Any, **request: Any) -> None:
    answer = robot.call(service, kind, **request)
    if not answer.success:
        raise NotManagedError(f"{service}: {answer.message}")
