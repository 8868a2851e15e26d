"""Scripted operators drive the robot over obstacles; benchmarks/mobility measures all of them."""

from __future__ import annotations

import math
from typing import Dict, List, Tuple
from xml.etree import ElementTree

import numpy as np
import pybullet
import pytest

from telex_experiments.mobility import flat, hold, novice, random_commands
from telex_experiments.mobility.balance import bearing, quasi_static, wheeled
from telex_experiments.mobility.balance.falls import FallWatch, slow_falls
from telex_experiments.mobility.offline import OfflineTrial
from telex_experiments.mobility.suite import Obstacle, all_obstacles, attempt
from telex_experiments.mobility.watch import RunWatch
from telex_training.operators import by_presets
from telex_training.operators.port import NotManagedError
from telex_training.operators.scripted_operator import FRONT_FLIPPERS, REAR_FLIPPERS, Operator
from telex_training.operators.terrain import footing, rough, stairs
from telex_training.operators.terrain.stairs import Stairs
from telex_training.operators.terrain.step import Step

pytestmark = pytest.mark.slow

OBSTACLES: Dict[str, Obstacle] = {obstacle.name: obstacle for obstacle in all_obstacles()}


def state(trial: OfflineTrial) -> Tuple[float, ...]:
    linear, angular = trial.velocity()
    return (*trial.simulation.link_poses(), *linear, *angular)


def test_loose_pallets_are_climbed_with_a_load() -> None:
    obstacle = OBSTACLES["4 loose pallets, 50 cm, 10 kg forward"]
    with obstacle.trial() as trial:
        outcome = attempt(obstacle, trial.operator)
    assert outcome.passed, outcome.message


def test_a_step_is_climbed_by_presets_alone() -> None:
    block = Step(friction=0.8)
    with OBSTACLES["step 50 cm, mu 0.8"].trial() as trial:
        user = novice.Novice(trial)
        by_presets.climb_step(user, block)
        assert trial.position()[0] - 0.39 > block.edge
        assert user.operator.time < 20.0


@pytest.mark.parametrize("step_size", [0.002, 0.001])
def test_a_turn_in_place_with_a_load_ahead_is_what_statics_say(step_size: float) -> None:
    start = bearing.STARTS[2]
    with bearing.Standing("ahead", 2.0, bearing.FLAT, start=start, step_size=step_size) as standing:
        by_contacts, by_places = standing.at_rest()
        turn = standing.quarter_turn(0.6)
    for found in (by_contacts, by_places, turn.bearing):
        assert found.error < 0.05
        assert found.total_error < 0.01
    assert turn.turned > 1.5
    assert turn.error < 0.08


@pytest.mark.parametrize("ground", ["plane", "edge"])
@pytest.mark.parametrize("kind", wheeled.ROBOTS)
def test_wheels_bear_what_statics_say(kind: str, ground: str) -> None:
    with wheeled.Wheeled(wheeled.ROBOTS[kind], ground) as robot:
        rest = robot.at_rest()
    assert rest.error < 0.05
    assert rest.total_error < 0.01


def test_a_robot_on_swivel_casters_turns_in_place() -> None:
    with wheeled.Wheeled(wheeled.CASTERS) as robot:
        turn = robot.turn(0.8, 4.0)
    assert turn.turned == pytest.approx(turn.theory, rel=0.05)
    assert turn.farthest < 0.05


def test_statics_know_what_tips_over() -> None:
    corners = np.array([[x, y, 0.0] for x in (0.3, -0.3) for y in (0.2, -0.2)])
    even = quasi_static.spring_loads(corners, 1e4, 400.0, (0.0, 0.0, 0.5))
    assert list(even) == pytest.approx([100.0] * 4)
    with pytest.raises(ValueError, match="tips over"):
        quasi_static.spring_loads(corners, 1e4, 400.0, (0.0, 0.21, 0.5))


def test_flippers_lie_flat_on_level_ground() -> None:
    angles = footing.settings(lambda x, y: 0.0, 1.0, 0.0, clearance=0.02)
    assert set(angles) == {*FRONT_FLIPPERS, *REAR_FLIPPERS}
    assert list(angles.values()) == pytest.approx([0.0] * 4, abs=0.05)


def test_each_flipper_goes_to_the_ground_under_it() -> None:
    def block_at_the_front_left(x: float, y: float) -> float:
        return 0.1 if x > 0.5 and y > 0.0 else 0.0

    angles = footing.settings(block_at_the_front_left, 0.0, 0.0, clearance=0.02)
    raised = angles.pop("front_left_flipper")
    # The run lies on the block's edge, 0.22 m before the pivot and 0.01 m under it.
    assert 0.22 * math.sin(raised) + 0.01 * math.cos(raised) == pytest.approx(0.11, abs=0.02)
    assert list(angles.values()) == pytest.approx([0.0] * 3, abs=0.05)


def test_a_tip_keeps_clear_of_what_its_round_side_would_meet() -> None:
    edge, height = 0.77, 0.2
    angles = footing.settings(lambda x, y: height if x > edge else 0.0, 0.0, 0.0, clearance=0.02)
    line = angles["front_left_flipper"] - math.asin(0.04 / 0.44)
    x, z = 0.28 + 0.44 * math.cos(line), 0.11 + 0.44 * math.sin(line)
    assert math.hypot(x - edge, z - height) == pytest.approx(0.07, abs=0.02)


def test_flippers_reach_down_where_something_lies_under_the_belly() -> None:
    angles = footing.settings(lambda x, y: 0.2 if abs(x) < 0.1 else 0.0, 0.0, 0.0, clearance=0.0)
    # Belly 0.2 m up, so pivots 0.245 m up.
    down = math.asin((0.07 - 0.245) / 0.44) + math.asin(0.04 / 0.44)
    assert list(angles.values()) == pytest.approx([down] * 4, abs=0.05)


def test_the_high_side_of_a_hull_that_rolls_is_let_down() -> None:
    angles = dict(zip((*FRONT_FLIPPERS, *REAR_FLIPPERS), (-0.5, -0.1, 0.2, 0.3)))
    assert list(footing.let_down(angles, "left").values()) == [-0.1, -0.1, 0.3, 0.3]
    assert list(footing.let_down(angles, "right").values()) == [-0.5, -0.1, 0.2, 0.3]


def test_the_operator_sees_the_ramps_as_they_stand() -> None:
    ramps = rough.CrossingRamps()
    ridge = 1.2 * math.tan(math.radians(15.0))
    for x, right, left in (
        (0.9, 0.0, 0.0),
        (2.2, ridge, 0.0),
        (2.8, 0.5 * ridge, 0.5 * ridge),
        (3.4, 0.0, ridge),
        (5.8, 0.0, ridge),
        (7.1, 0.0, 0.0),
    ):
        assert ramps.height(x, -0.3) == pytest.approx(right, abs=1e-6)
        assert ramps.height(x, 0.3) == pytest.approx(left, abs=1e-6)


def test_gains_shrink_with_a_longer_control_period(caplog: pytest.LogCaptureFixture) -> None:
    def damping(step_size: float) -> List[float]:
        caplog.clear()
        with OfflineTrial(step_size=step_size) as trial:
            flipper = trial.node.params()["front_left_flipper_position_controller"]
            return [flipper["pid"]["d"], _brake(trial.urdf)]

    shipped = damping(0.002)
    assert "tuned for" not in caplog.text
    assert damping(0.004) == pytest.approx([0.5 * value for value in shipped])
    assert "control_period is 0.004 s: the shipped gains are tuned for 0.002 s" in caplog.text


def _brake(urdf: str) -> float:
    robot = ElementTree.fromstring(urdf)
    joint = robot.find("joint[@name='front_left_flipper_joint']/safety_controller")
    assert joint is not None
    return float(joint.attrib["k_velocity"])


def test_stairs_are_climbed_and_the_robot_stands_whole_on_the_landing() -> None:
    flight = Stairs(0.20, 0.20, steps=4, friction=1.1)
    with OfflineTrial(flight.objects(), {"x": flight.foot - 0.9}, flight.friction) as trial:
        watch = FallWatch(trial)
        stairs.climb(trial.operator, flight)
        assert watch.warned == 0.0
        assert trial.position()[0] - 0.39 > flight.crest
        assert trial.position()[2] == pytest.approx(flight.height + 0.110, abs=0.02)


def test_flat_stairs_are_descended_without_a_drop() -> None:
    flight = Stairs(0.15, 0.30, steps=3, landing=1.2)
    pitches: List[float] = []
    with OfflineTrial(flight.objects(), {"x": -3.0}) as trial:
        trial.place((flight.edge - 0.85, 0.0, flight.height + 0.111), (0.0, 0.0, 0.0, 1.0))
        trial.each_step.append(lambda: pitches.append(-trial.operator.pose.rise))
        stairs.descend(trial.operator, flight)
        assert trial.position()[2] < 0.15
    assert max(pitches) < flight.slope + math.radians(6.0)


def test_the_same_script_leads_to_the_same_state_to_the_last_bit() -> None:
    obstacle = OBSTACLES["hurdle 25 cm, 20 cm long"]
    states = []
    for _ in range(2):
        with obstacle.trial() as trial:
            assert attempt(obstacle, trial.operator).passed
            states.append(state(trial))
    assert states[0] == states[1]


def test_the_robot_drives_as_fast_as_it_is_told() -> None:
    with OfflineTrial() as trial:
        assert flat.straight(trial, 0.5, seconds=1.0).speed == pytest.approx(0.5, rel=0.01)


def test_the_robot_turns_in_place_as_fast_as_it_is_told() -> None:
    with OfflineTrial() as trial:
        found = flat.turn(trial, 1.0, seconds=3.0)
    assert found.rate == pytest.approx(1.0, rel=0.02)
    assert found.drift < 0.05


@pytest.mark.parametrize("heading", [0.0, 0.5 * math.pi])
def test_the_robot_stands_on_a_slope(heading: float) -> None:
    assert hold.on_slope(math.radians(30.0), heading, 1.0, seconds=1.0) < 1e-4


def test_the_robot_slides_where_friction_does_not_hold_it() -> None:
    assert hold.on_slope(math.radians(40.0), 0.0, 0.8, seconds=1.0) > 0.02


def test_statics_say_what_the_front_must_bear_on_a_step() -> None:
    """By the centres of mass, arm folded and forward; docs/operator/mobility.md has the figures."""
    folded, forward = (0.013, 0.0, 0.136), (0.068, 0.0, 0.152)
    needed = [quasi_static.share_needed_at_edge(height, 1.0) for height in (0.50, 0.55)]
    assert needed == pytest.approx([0.41, 0.65], abs=0.01)
    have = [quasi_static.share_at_edge(0.55, center) for center in (folded, forward)]
    assert have == pytest.approx([0.33, 0.44], abs=0.01)
    assert quasi_static.share_at_edge(0.50, folded) == pytest.approx(0.35, abs=0.01)


def test_a_step_that_is_too_high_is_not_managed() -> None:
    obstacle = OBSTACLES["step 50 cm, mu 1.0"]
    wall = [{**obstacle.objects[0], "height": 1.5}]
    with OfflineTrial(wall, {"x": -0.8}) as trial, pytest.raises(
        NotManagedError, match=r"x -0\.\d+"
    ):
        obstacle.script(trial.operator)


def test_a_robot_on_its_side_is_noticed() -> None:
    with OfflineTrial() as trial:
        trial.place((0.0, 0.0, 0.4), (math.sin(0.8), 0.0, 0.0, math.cos(0.8)))
        with pytest.raises(NotManagedError, match="tipped over"):
            trial.operator.wait(2.0)


@pytest.mark.parametrize(
    "name", ["on four tips, 30 kg to the right", "uphill 30 deg, 20 kg to the rear"]
)
def test_a_slow_fall_is_warned_of(name: str) -> None:
    fall = slow_falls()[name].run()
    assert fall is not None
    assert fall.warning >= 0.5


def test_random_commands_are_watched_at_every_step() -> None:
    found = random_commands.run(seed=1, seconds=4.0)
    assert found.finite
    assert found.jump < 0.001
    assert 0.0 < found.gain < found.rated
    assert found.deepest < 0.02


def test_the_watch_sees_what_cannot_have_happened() -> None:
    with OfflineTrial(pose="look_front") as trial:
        watch, rated = RunWatch(trial), random_commands.rated_power(trial) * trial.step_size
        trial.operator.wait(0.4)
        assert watch.gain < rated
        x, y, z = trial.position()
        trial.place((x + 0.01, y, z), (0.0, 0.0, 0.0, 1.0))
        trial.operator.wait(0.04)
        assert watch.jump == pytest.approx(0.01, rel=0.1)
        body = trial.simulation.body
        pybullet.resetBaseVelocity(body.uid, (0.7, 0, 0), (0, 0, 0), physicsClientId=body.client)
        trial.operator.wait(0.04)
        assert watch.gain > rated
        joint = body.joints["left_finger_tip_joint"]
        pybullet.resetJointState(body.uid, joint, math.nan, physicsClientId=body.client)
        watch.look()
        assert not watch.finite


def test_an_operator_keeps_its_lane() -> None:
    def far_from(operator: Operator) -> float:
        return abs(operator.pose.y - 0.3)

    with OfflineTrial() as trial:
        operator = trial.operator
        operator.keep_lane(0.5, (0.0, 0.3))
        operator.wait(5.0)
        assert far_from(operator) < 0.05
        assert abs(operator.pose.yaw) < 0.1
