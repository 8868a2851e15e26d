"""Scripted operators drive the robot over obstacles; benchmarks/mobility measures all of them."""

from __future__ import annotations

import math
from typing import Dict, Tuple

import pytest
from mobility import flat, hold, stairs
from mobility.obstacles import Obstacle, all_obstacles, attempt
from mobility.offline import Trial
from mobility.scripted_operator import NotManagedError, Operator
from mobility.stairs import Stairs

OBSTACLES: Dict[str, Obstacle] = {obstacle.name: obstacle for obstacle in all_obstacles()}


def state(trial: Trial) -> Tuple[float, ...]:
    linear, angular = trial.velocity()
    return (*trial.simulation.link_poses(), *linear, *angular)


@pytest.mark.parametrize(
    "name", ["step 50 cm, mu 0.8", "4 loose pallets, 50 cm, 10 kg forward", "hurdle 30 cm"]
)
def test_an_obstacle_is_passed(name: str) -> None:
    obstacle = OBSTACLES[name]
    with obstacle.trial() as trial:
        outcome = attempt(obstacle, trial.operator)
    assert outcome.passed, outcome.message


def test_stairs_are_climbed_and_the_robot_stands_whole_on_the_landing() -> None:
    flight = Stairs(0.20, 0.20, steps=4, friction=1.1)
    with Trial(flight.objects(), {"x": flight.foot - 0.9}, flight.friction) as trial:
        stairs.climb(trial.operator, flight)
        assert trial.position()[0] - 0.39 > flight.crest
        assert trial.position()[2] == pytest.approx(flight.height + 0.110, abs=0.02)


def test_the_same_script_leads_to_the_same_state_to_the_last_bit() -> None:
    obstacle = OBSTACLES["hurdle 10 cm"]
    states = []
    for _ in range(2):
        with obstacle.trial() as trial:
            assert attempt(obstacle, trial.operator).passed
            states.append(state(trial))
    assert states[0] == states[1]


def test_the_robot_drives_as_fast_as_it_is_told() -> None:
    with Trial() as trial:
        assert flat.straight(trial, 0.5, seconds=1.0).speed == pytest.approx(0.5, rel=0.01)


def test_the_robot_turns_as_fast_as_it_is_told() -> None:
    with Trial() as trial:
        assert flat.turn(trial, 0.5, seconds=3.0).rate == pytest.approx(0.5, rel=0.02)


@pytest.mark.parametrize("heading", [0.0, 0.5 * math.pi])
def test_the_robot_stands_on_a_slope(heading: float) -> None:
    assert hold.on_slope(math.radians(30.0), heading, 1.0, seconds=1.0) < 1e-4


def test_the_robot_slides_where_friction_does_not_hold_it() -> None:
    assert hold.on_slope(math.radians(40.0), 0.0, 0.8, seconds=1.0) > 0.02


def test_a_step_that_is_too_high_is_not_managed() -> None:
    obstacle = OBSTACLES["step 50 cm, mu 1.0"]
    wall = [{**obstacle.objects[0], "height": 1.5}]
    with Trial(wall, {"x": -0.8}) as trial, pytest.raises(NotManagedError, match=r"x -0\.\d+"):
        obstacle.script(trial.operator)


def test_a_robot_on_its_side_is_noticed() -> None:
    with Trial() as trial:
        trial.place((0.0, 0.0, 0.4), (math.sin(0.8), 0.0, 0.0, math.cos(0.8)))
        with pytest.raises(NotManagedError, match="tipped over"):
            trial.operator.wait(2.0)


def test_an_operator_keeps_its_lane() -> None:
    def far_from(operator: Operator) -> float:
        return abs(operator.pose.y - 0.3)

    with Trial() as trial:
        operator = trial.operator
        operator.keep_lane(0.5, (0.0, 0.3))
        operator.wait(5.0)
        assert far_from(operator) < 0.05
        assert abs(operator.pose.yaw) < 0.1
