"""The arm, led in memory."""

import numpy as np
import pytest

from telex_control.follow_trajectory import FollowTrajectoryError
from telex_control.follow_trajectory.paths import Shape
from telex_sim.offline.arm import OfflineArm, plan_circle

pytestmark = pytest.mark.slow

JOINTS = ("turret_joint", "shoulder_joint")
STEP = 0.002


def turn_by(angle, start, duration):
    """References that lead the turret by an angle (rad), and the shoulder nowhere."""
    return lambda time: {
        "turret_joint": start["turret_joint"] + angle * min(time / duration, 1.0),
        "shoulder_joint": start["shoulder_joint"],
    }


@pytest.mark.parametrize("rate", [0.0, 50.0])
def test_it_streams_references_and_records_each_cycle(robot, rate):
    simulation = robot(start__pose="look_front")
    arm = OfflineArm(simulation.simulation, simulation.node, JOINTS, rate)
    arm.wait(0.5)
    start = {joint: arm.reference(joint) for joint in JOINTS}
    asked, steps = [], []
    lead = turn_by(0.1, start, 0.5)

    def references(time):
        asked.append(time)
        return lead(time)

    arm.each_step.append(steps.append)
    recording = arm.stream(references, 1.0)
    period = 1.0 / rate if rate else STEP
    assert asked == pytest.approx(np.arange(0.0, 1.0 + 1e-9, period))
    assert steps == list(range(501))
    assert recording.times == pytest.approx(np.arange(501) * STEP)
    assert recording.positions.shape == (501, 2)
    assert recording.positions[0] == pytest.approx([start[joint] for joint in JOINTS], abs=0.01)
    assert recording.positions[-1, 0] == pytest.approx(start["turret_joint"] + 0.1, abs=0.01)
    assert arm.position("turret_joint") == pytest.approx(recording.positions[-1, 0], abs=1e-3)
    assert arm.reference("turret_joint") == pytest.approx(start["turret_joint"] + 0.1, abs=1e-3)
    # What is held for 20 ms is old by half of that in the mean.
    filters = OfflineArm(simulation.simulation, simulation.node, JOINTS).lag()
    assert 0.0 < filters < 0.2
    assert arm.lag() - filters == pytest.approx(0.5 * (period - STEP))


def test_a_reference_that_the_controller_does_not_hold_ends_the_stream(robot):
    simulation = robot(start__pose="look_front")
    arm = OfflineArm(simulation.simulation, simulation.node, JOINTS)
    with pytest.raises(FollowTrajectoryError, match="shoulder_joint was sent to 50.0 at 0.004 s"):
        arm.stream(lambda time: {"shoulder_joint": 50.0 if time > 0.003 else 0.0}, 1.0)


def test_a_way_begins_where_the_pose_can_reach_and_keeps_its_orientation():
    shape = Shape(radius=0.15, height=0.1, turns=0.5, centre=(0.85, 0.0, 0.5))
    way = plan_circle(shape, "look_front", 0.05, 0.1)
    first, last = way.chain.forward(way.start), way.chain.forward(way.reference(1e3))
    assert np.linalg.norm(first[:2, 3] - shape.centre[:2]) == pytest.approx(0.15, abs=1e-4)
    assert last[:3, :3] == pytest.approx(first[:3, :3], abs=1e-4)
    assert abs(last[2, 3] - first[2, 3]) == pytest.approx(0.1, abs=1e-3)
