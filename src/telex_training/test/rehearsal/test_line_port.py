"""A rehearsed robot behind a line: delay of commands and of what is seen, losses, stops."""

from __future__ import annotations

from pathlib import Path
from random import Random
from typing import Any, Iterator, List

import pytest

from telex_control.common.params import ConfigError
from telex_sim.offline.robot import OfflineRobot
from telex_sim.offline.simulation import OfflineSimulation, robot_description
from telex_teleop.web.line.profiles import Profiles
from telex_training.exercises.exercise_file import parse_exercise
from telex_training.operators.port import Command, Drive, NotManagedError
from telex_training.rehearsal.line_port import LineTeleop, line_setting

pytestmark = pytest.mark.slow

EXERCISE = """
scene: floor
description: Drive a metre.
steps: [{name: a metre, until: {moved: {what: robot, distance: 1}}}]
"""


class Far:
    """A robot behind a line, and what of its commands has arrived when (s)."""

    def __init__(self, profile: str, fields: str = "", world: str = "floor") -> None:
        self.offline = OfflineSimulation(robot_description(), world=world)
        self.robot = OfflineRobot(self.offline)
        self.arrived: List[Any] = []
        self.port = LineTeleop(
            self.robot,
            self.offline.run,
            lambda name, answer: self.arrived.append((self.time, answer)),
            self.hear,
            Profiles.read().choose(profile, fields),
            Random(1),
        )

    @property
    def time(self) -> float:
        return self.offline.simulation.time

    def hear(self, command: Command) -> None:
        self.arrived.append((self.time, command))


@pytest.fixture
def far() -> Iterator[Any]:
    made: List[Far] = []

    def make(*line: str, **options: str) -> Far:
        made.append(Far(*line, **options))
        return made[-1]

    yield make
    for each in made:
        each.offline.simulation.close()


def test_commands_arrive_after_the_delay_in_their_order(far: Any) -> None:
    there = far("300")
    sent = there.time
    there.port.send(Drive(0.2, 0.0))
    there.port.send(Drive())
    there.port.advance(0.28)
    assert there.arrived == []
    there.port.advance(0.04)
    assert [command for _, command in there.arrived] == [Drive(0.2, 0.0), Drive()]
    assert there.arrived[0][0] - sent == pytest.approx(0.3, abs=0.011)


def test_the_robot_is_seen_as_it_was(far: Any) -> None:
    there = far("300")
    for _ in range(60):
        seen = there.port.observe()
        there.port.advance(0.02)
    assert there.time - seen.time == pytest.approx(0.3, abs=0.041)


@pytest.mark.parametrize(("profile", "delay"), [("150", 0.15), ("300", 0.3)])
def test_who_looks_seldom_sees_no_older(far: Any, profile: str, delay: float) -> None:
    there = far(profile)
    there.port.keep_beside(lambda: there.time)
    for _ in range(3):
        there.port.advance(0.5)
        seen, beside = there.port.look()
        assert there.time - seen.time == pytest.approx(delay, abs=0.021)
        assert beside == seen.time


def test_what_is_seen_stands_during_an_outage(far: Any) -> None:
    there = far("150", "{outage_every: 2, outage_for: 1}")
    ages = []
    for _ in range(40):
        there.port.advance(0.1)
        ages.append(there.time - there.port.observe().time)
    assert min(ages) == pytest.approx(0.15, abs=0.021)
    assert max(ages) == pytest.approx(1.15, abs=0.121)
    assert len(there.port._seen) < 20  # of what no look will show, nothing is kept


def test_without_impairment_all_is_at_once(far: Any) -> None:
    there = far("perfect")
    there.port.send(Drive(0.2, 0.0))
    assert [command for _, command in there.arrived] == [Drive(0.2, 0.0)]
    assert there.port.observe().time == there.time


def test_motion_may_be_lost_and_a_stop_may_not(far: Any) -> None:
    there = far("perfect", "{loss: 0.9}")
    for _ in range(30):
        there.port.send(Drive(0.2, 0.0))
    there.port.send(Drive())
    there.port.advance(1.2)
    heard = [command for _, command in there.arrived]
    assert heard[-1] == Drive()
    assert len(heard) < 15


def test_an_answer_waits_for_its_way(far: Any) -> None:
    there = far("300")
    asked = there.time
    there.port.answer("label", "left")
    assert there.arrived[0][1] == "left"
    assert there.arrived[0][0] - asked == pytest.approx(0.3, abs=0.011)


def test_the_exercises_own_line_is_taken_unless_one_is_named() -> None:
    def exercise(more: str) -> Any:
        return parse_exercise(EXERCISE + more, Path("/exercises/drill.yaml")).first

    assert line_setting(exercise("")).is_perfect
    assert line_setting(exercise("link: 150\n")).fields.delay == 0.15
    assert line_setting(exercise("link: 150\n"), "1000").fields.delay == 1.0
    assert line_setting(exercise("link: 150\n"), "perfect").is_perfect
    with pytest.raises(ConfigError, match="known are perfect"):
        line_setting(exercise(""), "string")
    assert line_setting(exercise("link: by_distance\n")).by_signal is not None


def test_by_distance_the_line_is_as_the_robot_stands_from_the_antenna(
    far: Any, tmp_path: Path
) -> None:
    delays = []
    for distance in (1.0, 50.0):
        scene = tmp_path / f"at_{distance:g}.yaml"
        scene.write_text(f"antenna: [{distance}, 0, 1.5]\nobjects: []\n")
        there = far("by_distance", "{loss: 0, jitter: 0}", world=str(scene))
        there.port.advance(0.5)
        sent = there.time
        there.port.send(Drive())
        there.port.advance(1.0)
        ((arrived, _),) = there.arrived
        delays.append(arrived - sent)
    assert delays[0] < 0.05
    assert 0.15 < delays[1] < 0.3


def test_where_nothing_passes_an_operator_gives_up(far: Any, tmp_path: Path) -> None:
    scene = tmp_path / "far.yaml"
    scene.write_text("antenna: [500, 0, 1.5]\nobjects: []\n")
    there = far("by_distance", world=str(scene))
    there.port.send(Drive(0.2, 0.0))
    with pytest.raises(NotManagedError, match="nothing has passed"):
        there.port.answer("label", "left")
    assert there.arrived == []
    with pytest.raises(NotManagedError, match="nothing has come"):
        there.port.observe()
