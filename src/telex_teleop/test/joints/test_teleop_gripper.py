"""Coupled finger joints: the group, the single joints, and the way from one to the other."""

import pytest

from telex_teleop.joints.coupled_teleop import CoupledTeleop, Coupling
from telex_teleop.motion.axis import AxisSettings
from telex_teleop.motion.joint_jog import InvalidCommand, JogCommand
from telex_teleop.motion.reference import MotionLimits
from telex_teleop.motion.speed import SpeedScale

DT = 0.01
RATIOS = {
    f"{side}_{part}": ratio
    for side in ("left", "right")
    for part, ratio in (("base", 1.0), ("middle", 1.0), ("tip", -2.0))
}
COUPLING = Coupling("gripper", RATIOS, ("left_base", "right_base"), 0.05, 0.2)


class Gripper:
    def __init__(self):
        joint = AxisSettings(MotionLimits(-1.2, 1.2, 0.6, 2.0, 0.2, 0.2), 0.5)
        group = AxisSettings(MotionLimits(-0.04, 0.55, 0.16, 0.6, 0.05, 0.05), 0.5)
        self.core = CoupledTeleop(
            dict.fromkeys(RATIOS, joint), group, COUPLING, 0.28, 0.5, SpeedScale()
        )
        self.time = 0.0
        self.positions = dict.fromkeys(RATIOS, 0.0)
        self.blocked = set()
        self.history = []
        self.run(0.6)  # a new node is deaf for a while
        self.history.clear()

    def step(self):
        self.time += DT
        references = self.core.update(self.time, self.time, self.positions)
        self.history.append(references)
        for joint, reference in references.items():
            if joint not in self.blocked:
                self.positions[joint] = reference
        return references

    def hold(self, duration, **rates):
        for _ in range(round(duration / DT)):
            self.core.receive(JogCommand(rates, {}, None), self.time)
            self.step()

    def run(self, duration):
        for _ in range(round(duration / DT)):
            self.step()

    def steps(self, joint):
        values = [references[joint] for references in self.history if joint in references]
        return [b - a for a, b in zip(values, values[1:])]


@pytest.fixture
def gripper():
    return Gripper()


def test_group_moves_all_joints_in_their_ratio(gripper):
    gripper.hold(0.5, gripper=0.1)
    start = gripper.positions["left_base"]
    gripper.hold(1.0, gripper=0.1)
    opened = gripper.positions["left_base"]
    assert opened - start == pytest.approx(0.1, rel=1e-6)
    assert gripper.positions == pytest.approx({j: r * opened for j, r in RATIOS.items()})


def test_group_holds_when_the_stream_ends(gripper):
    gripper.hold(0.5, gripper=0.1)
    gripper.run(0.6)
    assert gripper.history[-1] == {}


def test_group_waits_for_fingers_that_hold_something(gripper):
    gripper.hold(2.0, gripper=0.1)
    gripper.blocked = set(RATIOS)
    held = gripper.positions["left_base"]
    gripper.hold(2.0, gripper=-0.16)
    pressed = gripper.history[-1]["left_base"]
    assert held - pressed == pytest.approx(0.05, abs=1e-6)
    # letting the key go and pressing it again does not let go
    gripper.run(1.0)
    gripper.hold(0.02, gripper=-0.16)
    assert gripper.history[-1]["left_base"] == pytest.approx(pressed, abs=1e-6)


def test_group_stays_within_its_limits(gripper):
    gripper.hold(6.0, gripper=1.0)
    assert gripper.positions["left_base"] == pytest.approx(0.55, abs=1e-6)
    gripper.hold(8.0, gripper=-1.0)
    assert gripper.positions["right_tip"] == pytest.approx(0.08, abs=1e-6)


def test_single_joint_moves_alone(gripper):
    gripper.hold(1.0, left_tip=-0.2)
    assert gripper.positions["left_tip"] < -0.1
    assert all(p == 0.0 for joint, p in gripper.positions.items() if joint != "left_tip")


def test_group_brings_joints_back_to_their_ratio_without_a_step(gripper):
    gripper.hold(2.0, left_tip=-0.2)
    gripper.run(0.6)
    gripper.history.clear()
    gripper.hold(10.0, gripper=0.04)
    s = gripper.positions["right_base"]
    assert gripper.positions["left_tip"] == pytest.approx(-2.0 * s, abs=1e-6)
    assert max(abs(step) for step in gripper.steps("left_tip")) <= (2 * 0.04 + 0.05) * DT + 1e-9


def test_alignment_stops_with_the_key(gripper):
    gripper.hold(2.0, left_tip=-0.2)
    gripper.run(0.6)
    gripper.hold(0.5, gripper=0.04)
    gripper.run(0.8)
    held = dict(gripper.positions)
    gripper.run(1.0)
    assert gripper.positions == held


def test_newest_of_group_and_single_wins_after_the_other_has_come_to_rest(gripper):
    gripper.hold(1.0, gripper=0.16)
    gripper.hold(1.0, left_base=-0.2)
    assert gripper.core.axes["gripper"].generator.velocity == 0.0
    assert gripper.positions["left_base"] < gripper.positions["right_base"]
    assert max(abs(step) for step in gripper.steps("left_base")) <= 0.2 * DT + 1e-9
    gripper.hold(1.0, gripper=0.16)
    assert gripper.core.axes["left_base"].generator.velocity == 0.0
    assert max(abs(step) for step in gripper.steps("left_base")) <= 0.21 * DT + 1e-9


def test_group_and_single_in_one_message_are_refused(gripper):
    with pytest.raises(InvalidCommand, match="send it without left_tip"):
        gripper.core.receive(JogCommand({"gripper": 0.1, "left_tip": 0.1}, {}, None), 0.0)


def test_group_displacement(gripper):
    gripper.core.receive(JogCommand({}, {"gripper": 0.2}, None), gripper.time)
    gripper.run(3.0)
    assert gripper.positions["right_tip"] == pytest.approx(-0.4, abs=1e-6)


def test_e_stop_drops_the_group(gripper):
    gripper.hold(0.5, gripper=0.1)
    gripper.core.set_e_stop(True)
    assert gripper.step() == {}
    gripper.core.set_e_stop(False)
    gripper.hold(0.5, gripper=0.1)
    assert gripper.history[-1] == {}


def test_old_stream_of_the_group_does_not_hold_up_a_finger(gripper):
    gripper.hold(0.3, gripper=0.1)
    gripper.core.set_e_stop(True)
    gripper.hold(0.3, gripper=0.1)
    gripper.core.set_e_stop(False)
    for _ in range(200):
        gripper.core.receive(JogCommand({"left_tip": -0.2}, {}, None), gripper.time)
        gripper.core.receive(JogCommand({"gripper": 0.1}, {}, None), gripper.time)
        gripper.step()
    assert gripper.positions["left_tip"] < -0.2


def test_reset_leaves_all_fingers_where_they_were_put(gripper):
    gripper.hold(0.5, gripper=0.1)
    gripper.core.restart(gripper.time)
    gripper.positions = dict.fromkeys(RATIOS, 0.001)
    assert gripper.step() == gripper.positions
    gripper.hold(0.5, gripper=0.1)
    assert gripper.positions == dict.fromkeys(RATIOS, 0.001)


def test_state_shows_the_group_first(gripper):
    gripper.hold(0.5, gripper=0.1)
    state = gripper.core.state(gripper.time)
    assert [axis.name for axis in state.axes] == ["gripper", *RATIOS]
    assert state.active
    assert state.axes[0].reference == pytest.approx(gripper.positions["left_base"])
    assert state.axes[3].reference == pytest.approx(gripper.positions["left_tip"])
