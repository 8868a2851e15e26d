from __future__ import annotations

import math

import pytest
from control_msgs.msg import GripperCommandGoal

from telex_control.common.params import ConfigError
from telex_control.controllers.parallel_gripper_controller import FingerGeometry
from telex_control.hardware.hardware_interface import (
    EffortJointInterface,
    JointHandle,
    JointStateHandle,
    JointStateInterface,
    PositionJointInterface,
    RobotHW,
)
from telex_control.manager.controller_manager import ControllerManager
from telex_control.ros.local_node_handle import LocalGoal


def send(tested, position, max_effort=0.0):
    goal = GripperCommandGoal()
    goal.command.position, goal.command.max_effort = position, max_effort
    return tested.node.send_goal("g/gripper_cmd", goal)


# --- a single joint ----------------------------------------------------------------------------


class Jaw:
    """A gripper of one sliding joint, 0 to 0.3 m, that meets something at `obstacle`."""

    def __init__(self, bench, kind, **params):
        own = {"type": f"{kind}_controllers/GripperActionController", "joint": "slide", **params}
        if kind == "effort":
            own["gains"] = {"slide": {"p": 400.0, "d": 40.0}}
        self.bench = bench({"g": own})
        self.node = self.bench.node
        self.bench.load_and_start("g")
        interface = EffortJointInterface if kind == "effort" else PositionJointInterface
        self.joint = self.bench.hw.get(interface).get_handle("slide")
        self.kind = kind
        self.obstacle = 9.0
        self.efforts = []

    def run(self, seconds):
        period, state = self.bench.period, self.joint.state
        for _ in range(round(seconds / period)):
            self.bench.cycle()
            command, before = self.joint.command, state.position
            if self.kind == "effort":
                self.efforts.append(command)
                state.velocity += command * period  # 1 kg
                target = before + state.velocity * period
            else:
                step = 0.1 * period  # 0.1 m/s
                target = before + min(max(command - before, -step), step)
            state.position = min(target, self.obstacle)
            state.velocity = (state.position - before) / period


@pytest.fixture(params=["position", "effort"])
def jaw(bench, request):
    return lambda **params: Jaw(bench, request.param, **params)


def test_a_position_is_reached(jaw):
    tested = jaw()
    goal = send(tested, 0.2, 100.0)
    assert goal.status == "active"
    tested.run(4.0)
    assert goal.status == "succeeded"
    assert (goal.result.reached_goal, goal.result.stalled) == (True, False)
    assert goal.result.position == pytest.approx(0.2, abs=0.011)
    assert goal.feedback
    tested.run(1.0)
    assert tested.joint.state.position == pytest.approx(0.2, abs=1e-3)  # and is kept


def test_a_goal_whose_controller_stops_as_it_comes_is_cancelled(jaw, monkeypatch):
    tested = jaw()
    (loaded,) = tested.bench.manager._controllers
    accept = LocalGoal.accept

    def stopped_meanwhile(goal):
        accept(goal)
        assert tested.bench.switch(stop=["g"])

    monkeypatch.setattr(LocalGoal, "accept", stopped_meanwhile)
    assert send(tested, 0.2).status == "cancelled"


def test_a_goal_that_waits_for_the_loop_is_not_carried_out_after_a_restore(jaw):
    tested = jaw()
    first = send(tested, 0.1, 100.0)
    tested.run(3.0)
    assert first.status == "succeeded"
    saved, began = tested.bench.manager.save_state(), tested.bench.time
    waiting = send(tested, 0.3, 100.0)
    now = tested.bench.time
    tested.bench.manager.restore_state(saved, now, now - began)
    assert waiting.status == "cancelled"
    assert "bookmark" in waiting.text
    tested.run(1.0)
    assert tested.joint.state.position == pytest.approx(0.1, abs=0.011)


def test_a_stall_aborts_as_upstream_has_it(jaw):
    tested = jaw()
    tested.obstacle = 0.1
    goal = send(tested, 0.2, 100.0)
    tested.run(4.0)
    assert goal.status == "aborted"
    assert (goal.result.reached_goal, goal.result.stalled) == (False, True)
    assert "stalled at 0.1" in goal.text


def test_a_stall_may_be_a_success(jaw):
    tested = jaw(allow_stalling=True, stall_timeout=0.3)
    tested.obstacle = 0.1
    goal = send(tested, 0.2, 100.0)
    tested.run(3.0)
    assert goal.status == "succeeded"
    assert (goal.result.reached_goal, goal.result.stalled) == (False, True)


def test_positions_are_bounded_to_the_joint(jaw):
    tested = jaw()
    goal = send(tested, 9.0, 100.0)
    tested.run(5.0)
    assert goal.status == "succeeded"
    assert tested.joint.state.position == pytest.approx(0.3, abs=0.01)


@pytest.mark.parametrize("bad", [(math.nan, 1.0), (0.1, math.nan), (math.inf, 1.0), (-1e308, 1.0)])
def test_goals_that_are_no_numbers_are_rejected(jaw, bad):
    tested = jaw()
    goal = send(tested, *bad)
    assert goal.status == "rejected"
    assert "dropped" in goal.text


def test_cancelling_holds(jaw):
    tested = jaw()
    goal = send(tested, 0.25, 100.0)
    tested.run(0.1)
    goal.cancel_requested = True
    tested.run(0.01)
    stopped = tested.joint.state.position
    assert goal.status == "cancelled"
    assert goal.result.position == pytest.approx(stopped, abs=0.02)
    tested.run(2.0)
    assert tested.joint.state.position == pytest.approx(stopped, abs=0.03)


def test_a_newer_goal_replaces_the_old_one(jaw):
    tested = jaw()
    first = send(tested, 0.25, 100.0)
    tested.run(0.2)
    second, third = send(tested, 0.1, 100.0), send(tested, 0.05, 100.0)
    tested.run(3.0)
    assert [first.status, second.status, third.status] == ["cancelled", "cancelled", "succeeded"]


def test_a_stopped_gripper_takes_no_goals(jaw):
    tested = jaw()
    goal = send(tested, 0.25, 100.0)
    tested.run(0.2)
    late = send(tested, 0.1)
    assert tested.bench.switch(stop=["g"])
    assert goal.status == late.status == "cancelled"
    assert send(tested, 0.1).status == "rejected"
    assert tested.bench.switch(start=["g"])
    before = tested.joint.state.position
    tested.run(0.5)
    assert tested.joint.state.position == pytest.approx(before, abs=0.01)


@pytest.mark.parametrize(("default", "asked", "bound"), [(0, 5, 5), (3, 0, 3), (3, 9, 3)])
def test_effort_is_limited(bench, default, asked, bound):
    tested = Jaw(bench, "effort", max_effort=default)
    send(tested, 0.3, asked)
    tested.run(0.5)
    assert max(tested.efforts) == pytest.approx(bound)


@pytest.mark.parametrize(
    ("change", "logged"),
    [
        ({"joint": "nose"}, "'nose'"),
        ({"goal_tolerance": 0.0}, "goal_tolerance is 0.0"),
        ({"stall_timeout": -1.0}, "stall_timeout is -1.0"),
        ({"max_effort": -1.0}, "max_effort is -1.0"),
        ({"allow_stalling": 1}, "allow_stalling is 1"),
    ],
)
def test_wrong_parameters_are_named(bench, caplog, change, logged):
    own = {"type": "position_controllers/GripperActionController", "joint": "slide", **change}
    assert not bench({"g": own}).manager.load_controller("g")
    assert logged in caplog.text


# --- two fingers of three joints ---------------------------------------------------------------

GEOMETRY = {"base": 0.045, "middle": 0.075, "lean": 0.4363323, "pad": 0.022, "max_angle": 0.55}
SIDES = {
    side: [f"{side}_{part}" for part in ("base", "middle", "tip")] for side in ("left", "right")
}
FINGERS = [*SIDES["left"], *SIDES["right"]]
INERTIA = 0.05
URDF = "<robot name='hand'>{}</robot>".format(
    "".join(
        f"<joint name='{name}' type='revolute'><limit lower='-2' upper='2' velocity='2' "
        "effort='99'/></joint>"
        for name in FINGERS
    )
)


class Hand:
    """Fingers of free bodies, between which a spring stands for an object."""

    def __init__(self, bench, **params):
        own = {
            "type": "telex_controllers/ParallelGripperController",
            "left_joints": SIDES["left"],
            "right_joints": SIDES["right"],
            "geometry": GEOMETRY,
            "drive": {
                "base": {"p": 600.0, "d": 5.0},
                "middle": {"p": 600.0, "d": 5.0},
                "tip": {"p": 300.0, "d": 3.5},
            },
            "max_effort": 80.0,
            **params,
        }
        own = {key: value for key, value in own.items() if value is not None}
        self.bench = bench({"robot_description": URDF, "g": own})
        self.node = self.bench.node
        hw = RobotHW()
        states, efforts = JointStateInterface(), EffortJointInterface()
        self.joints = [JointHandle(JointStateHandle(name)) for name in FINGERS]
        for joint in self.joints:
            states.register_handle(joint.state)
            efforts.register_handle(joint)
        hw.register_interface(states)
        hw.register_interface(efforts)
        self.bench.manager = ControllerManager(hw, self.node)
        self.loaded = self.bench.manager.load_controller("g")
        self.geometry = FingerGeometry(**GEOMETRY)
        self.object_width = 0.0
        self.force = 0.0

    @property
    def angle(self):
        return 0.5 * (self.joints[0].state.position + self.joints[3].state.position)

    @property
    def opening(self):
        return self.geometry.opening(self.angle)

    def place(self, angle):
        for joint, ratio in zip(self.joints, (1, 1, -2) * 2):
            joint.state.position = ratio * angle
            joint.state.velocity = 0.0
        return self

    def start(self):
        assert self.loaded
        assert self.bench.switch(start=["g"])
        return self

    def run(self, seconds):
        period = self.bench.period
        for _ in range(round(seconds / period)):
            self.bench.cycle()
            gap = self.opening - self.object_width
            self.force = max(0.0, -gap) * 2e4
            levers = self.geometry.levers(self.angle)
            for joint, lever in zip(self.joints, levers * 2):
                state = joint.state
                torque = joint.command + self.force * lever
                state.velocity += torque / INERTIA * period
                state.position += state.velocity * period


@pytest.fixture
def hand(bench):
    return lambda angle=0.2, **params: Hand(bench, **params).place(angle).start()


def test_geometry_of_the_fingers():
    geometry = FingerGeometry(**GEOMETRY)
    assert geometry.opening(0.0) == 0.0
    for angle in (0.05, 0.2, 0.4, 0.55):
        step = 1e-6
        rate = (geometry.opening(angle + step) - geometry.opening(angle - step)) / (2 * step)
        assert geometry.opening_rate(angle) == pytest.approx(rate)
        assert geometry.angle(geometry.opening(angle)) == pytest.approx(angle)
        # virtual work: what the levers make of a force is the opening's share of each joint
        base, middle, tip = geometry.levers(angle)
        assert 2.0 * (base + middle - 2.0 * tip) == pytest.approx(rate)


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"base": 0.0}, "base is 0.0"),
        ({"lean": 2.0}, "lean is 2.0"),
        ({"max_angle": 1.1}, "max_angle is 1.1"),
    ],
)
def test_impossible_fingers_are_refused(change, text):
    with pytest.raises(ConfigError, match=text):
        FingerGeometry(**{**GEOMETRY, **change})


@pytest.mark.parametrize("opening", [0.0, 0.03, 0.1])
def test_an_opening_is_reached_with_parallel_pads(hand, opening):
    tested = hand()
    goal = send(tested, opening)
    tested.run(3.0)
    assert goal.status == "succeeded"
    assert goal.result.reached_goal
    assert tested.opening == pytest.approx(opening, abs=3e-4)
    left, right = tested.joints[:3], tested.joints[3:]
    for finger in (left, right):
        positions = [joint.state.position for joint in finger]
        assert positions[2] == pytest.approx(-positions[0] - positions[1], abs=1e-4)


def test_it_opens_and_closes_at_its_speed(hand):
    tested = hand(0.0, drive={**_drive(), "velocity": 0.04})
    send(tested, 0.1)
    tested.run(0.5)
    before = tested.opening
    tested.run(0.5)
    assert (tested.opening - before) / 0.5 == pytest.approx(0.04, rel=0.02)


def _drive():
    gains = {"base": (600.0, 5.0), "middle": (600.0, 5.0), "tip": (300.0, 3.5)}
    return {name: {"p": p, "d": d} for name, (p, d) in gains.items()}


@pytest.mark.parametrize("force", [10.0, 40.0, 80.0])
def test_an_object_is_gripped_with_the_force_asked_for(hand, force):
    tested = hand()
    tested.object_width = 0.05
    goal = send(tested, 0.0, force)
    tested.run(4.0)
    assert goal.status == "succeeded"  # a grasp is no failure
    assert (goal.result.reached_goal, goal.result.stalled) == (False, True)
    assert goal.result.effort == pytest.approx(force)
    assert tested.force == pytest.approx(force, rel=0.02)
    tested.run(5.0)
    assert tested.force == pytest.approx(force, rel=0.02)  # it goes on pressing


def test_no_goal_grips_harder_than_the_parameter_allows(hand):
    tested = hand()
    tested.object_width = 0.05
    goal = send(tested, 0.0, 1000.0)
    tested.run(4.0)
    assert goal.result.effort == pytest.approx(80.0)
    assert tested.force == pytest.approx(80.0, rel=0.02)


def test_fingers_that_are_freed_do_not_snap_shut(hand):
    tested = hand()
    tested.object_width = 0.05
    send(tested, 0.0, 40.0)
    tested.run(4.0)
    tested.object_width = 0.0
    fastest = 0.0
    for _ in range(500):
        tested.run(0.002)
        fastest = max(fastest, abs(tested.joints[0].state.velocity))
    # 0.08 m/s are 0.4 rad/s; 40 N alone would make it 1 rad/s within 0.01 s
    assert fastest < 1.0
    assert tested.opening == pytest.approx(0.0, abs=1e-3)


def test_it_holds_what_it_finds(hand):
    tested = hand(0.3)
    tested.run(1.0)
    assert tested.angle == pytest.approx(0.3, abs=1e-3)


def test_joints_out_of_line_return_slowly(bench):
    tested = Hand(bench).place(0.2)
    tested.joints[2].state.position += 0.2
    tested.start()
    tested.run(1.0)
    assert tested.joints[2].state.position == pytest.approx(-0.4 + 0.15, abs=0.01)
    assert abs(tested.joints[2].command) < 2.0
    tested.run(4.0)
    assert tested.joints[2].state.position == pytest.approx(-0.4, abs=2e-3)


def test_a_cancelled_goal_keeps_the_opening(hand):
    tested = hand(0.4)
    goal = send(tested, 0.0)
    tested.run(0.6)
    goal.cancel_requested = True
    tested.run(0.002)
    assert goal.status == "cancelled"
    stopped = tested.opening
    tested.run(1.0)
    assert tested.opening == pytest.approx(stopped, abs=5e-3)


def test_a_stopped_gripper_leaves_no_effort(hand):
    tested = hand()
    send(tested, 0.0)
    tested.run(0.2)
    assert tested.bench.switch(stop=["g"])
    assert [joint.command for joint in tested.joints] == [0.0] * 6


def test_it_claims_six_joints(hand):
    info, _ = hand().bench.manager.list_controllers()[0]
    (claim,) = info.claimed_resources
    assert set(claim.resources) == set(FINGERS)


def test_it_shares_the_fingers_with_their_own_controllers_by_turns(bench):
    own = {"type": "effort_controllers/JointPositionController", "pid": {"p": 1.0}}
    tested = Hand(bench)
    tested.node._params.update({name: {**own, "joint": name} for name in FINGERS})
    tested.start()
    assert all(map(tested.bench.manager.load_controller, FINGERS))
    assert not tested.bench.switch(start=FINGERS)
    assert not tested.bench.switch(start=FINGERS[:1])
    assert tested.bench.switch(start=FINGERS, stop=["g"])
    assert not tested.bench.switch(start=["g"])
    assert tested.bench.switch(start=["g"], stop=FINGERS)


@pytest.mark.parametrize(
    ("change", "logged"),
    [
        ({"max_effort": None}, "max_effort is missing or 0"),
        ({"left_joints": ["left_base"]}, "names 1 joints"),
        ({"right_joints": ["right_base", "right_middle", "nose"]}, "'nose'"),
        ({"geometry": {**GEOMETRY, "middle": -1.0}}, "middle is -1.0"),
        ({"geometry": {"base": 1.0}}, "g/geometry/middle is missing"),
        ({"drive": {**_drive(), "speed": 1.0}}, "g/drive/speed is unknown"),
        ({"drive": {**_drive(), "tip": {"p": 0.0, "d": 1.0}}}, "p is 0.0"),
    ],
)
def test_wrong_gripper_parameters_are_named(bench, caplog, change, logged):
    assert not Hand(bench, **change).loaded
    assert logged in caplog.text
