from __future__ import annotations

import math

import genpy
import pytest
from control_msgs.msg import (
    FollowJointTrajectoryGoal,
    JointTolerance,
    JointTrajectoryControllerState,
)
from control_msgs.srv import QueryTrajectoryStateRequest
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from telex_control.controllers import joint_trajectory_controller
from telex_control.hardware.hardware_interface import (
    EffortJointInterface,
    PositionJointInterface,
    VelocityJointInterface,
)
from telex_control.ros.node_handle import ServiceError
from telex_control.trajectory import spline
from telex_control.trajectory.waypoints import read_tracks

NAMES = ("elbow", "slide", "wheel")
TIMEOUT = 20.0


def trajectory(*points, names=NAMES, stamp=0.0):
    """Each point is (time, positions[, velocities[, accelerations]])."""
    message = JointTrajectory(joint_names=list(names))
    message.header.stamp = genpy.Time.from_sec(stamp)
    for time, positions, *derivatives in points:
        velocities, accelerations = (*derivatives, [], [])[:2]
        message.points.append(
            JointTrajectoryPoint(
                positions=positions,
                velocities=velocities,
                accelerations=accelerations,
                time_from_start=genpy.Duration.from_sec(time),
            )
        )
    return message


class Run:
    """A running controller on joints that follow position commands, unless they are `stuck`."""

    def __init__(self, bench, kind="position_controllers", start=True, **params):
        # A straight line ends at full speed: nothing stops within its last cycle.
        constraints = {"goal_time": 0.05, **params.pop("constraints", {})}
        own = {
            "type": f"{kind}/JointTrajectoryController",
            "joints": list(NAMES),
            "constraints": constraints,
            **params,
        }
        self.bench = bench({"c": own})
        self.hw = self.bench.hw
        self.node = self.bench.node
        self.commands = self.node.advertise("c/command", JointTrajectory)
        self.stuck = set()
        interface = {
            "position_controllers": PositionJointInterface,
            "velocity_controllers": VelocityJointInterface,
            "effort_controllers": EffortJointInterface,
        }[kind]
        assert self.bench.manager.load_controller("c")
        self.controller = self.bench.manager.controller("c")
        handles = self.hw.get(interface)
        self.joints = {name: handles.get_handle(name) for name in NAMES}
        self.moves = kind == "position_controllers"
        if start:
            assert self.bench.switch(start=["c"])

    @property
    def time(self):
        return self.bench.time

    def run(self, seconds):
        for _ in range(round(seconds / self.bench.period)):
            self.bench.cycle()
            for name, joint in self.joints.items():
                before = joint.state.position
                if self.moves and name not in self.stuck:
                    joint.state.position = joint.command
                joint.state.velocity = (joint.state.position - before) / self.bench.period

    def positions(self):
        return [self.joints[name].state.position for name in NAMES]

    def send(self, message, path=(), goal=(), late=0.0):
        return self.node.send_goal(
            "c/follow_joint_trajectory",
            FollowJointTrajectoryGoal(
                trajectory=message,
                path_tolerance=list(path),
                goal_tolerance=list(goal),
                goal_time_tolerance=genpy.Duration.from_sec(late),
            ),
        )

    def states(self):
        received = []
        self.node.subscribe("c/state", JointTrajectoryControllerState, received.append)
        return received


@pytest.fixture
def start(bench):
    return lambda *args, **params: Run(bench, *args, **params)


def test_a_started_controller_holds_what_it_finds(start):
    tested = start(start=False)
    tested.hw.states["elbow"].position = 0.7
    assert tested.bench.switch(start=["c"])
    tested.run(0.1)
    assert tested.positions() == [0.7, 0.0, 0.0]


def test_a_goal_is_reached(start):
    tested = start()
    goal = tested.send(trajectory((0.5, [0.5, 0.1, 1.0]), (1.0, [1.0, 0.2, 2.0])))
    assert goal.status == "active"
    tested.run(0.5)
    assert goal.status == "active"
    assert tested.positions() == pytest.approx([0.5, 0.1, 1.0], abs=0.005)
    tested.run(0.51)
    assert tested.positions() == pytest.approx([1.0, 0.2, 2.0])
    assert goal.status == "succeeded"
    assert (goal.result.error_code, goal.result.error_string) == (0, "")
    assert len(goal.feedback) == pytest.approx(20, abs=1)
    assert goal.feedback[5].joint_names == list(NAMES)
    assert goal.feedback[5].desired.positions[0] == pytest.approx(0.25, abs=0.02)


def test_joints_may_come_in_another_order(start):
    tested = start()
    tested.commands.publish(trajectory((0.1, [1.0, 0.2, 0.5]), names=("wheel", "slide", "elbow")))
    tested.run(0.2)
    assert tested.positions() == pytest.approx([0.5, 0.2, 1.0])


def test_velocities_are_met(start):
    tested = start()
    states = tested.states()
    tested.commands.publish(
        trajectory((0.4, [0.2, 0, 0], [0.8, 0, 0]), (0.8, [0.4, 0, 0], [0, 0, 0]))
    )
    tested.run(0.9)
    speeds = {round(m.header.stamp.to_sec(), 3): m.desired.velocities[0] for m in states}
    begun = min(speeds)
    nearest = min(speeds, key=lambda time: abs(time - begun - 0.4))
    assert speeds[nearest] == pytest.approx(0.8, abs=0.12)
    assert tested.positions()[0] == pytest.approx(0.4)


@pytest.mark.parametrize(
    ("message", "code", "text"),
    [
        (trajectory((1.0, [1.0]), names=["elbow"]), -2, "'slide' is missing"),
        (trajectory((1.0, [1.0] * 4), names=[*NAMES, "nose"]), -2, "'nose' is unknown"),
        (trajectory((1.0, [1.0] * 2)), -1, "2 positions"),
        (trajectory((1.0, [0.0] * 3), (1.0, [0.0] * 3)), -1, "point 1"),
        (trajectory((1.0, [math.nan, 0.0, 0.0])), -1, "nan"),
        (trajectory((1.0, [0.0, 0.0, 0.0], [0.0, math.inf, 0.0])), -1, "inf"),
        (trajectory((0.0, [0.0] * 3)), -3, "past"),
    ],
)
def test_wrong_goals_are_rejected_and_what_runs_goes_on(start, message, code, text, caplog):
    tested = start()
    running = tested.send(trajectory((1.0, [1.0, 0.2, 0.0])))
    tested.run(0.5)
    goal = tested.send(message)
    assert goal.status == "rejected"
    assert goal.result.error_code == code
    assert text in goal.result.error_string
    tested.commands.publish(message)
    assert text in caplog.text
    tested.run(0.6)
    assert running.status == "succeeded"


def test_tolerances_that_are_no_number_reject_the_goal(start):
    tested = start()
    goal = tested.send(
        trajectory((1.0, [0.0] * 3)), path=[JointTolerance("elbow", math.nan, 0.0, 0.0)]
    )
    assert (goal.status, goal.result.error_code) == ("rejected", -1)


def test_a_controller_that_does_not_run_takes_nothing(start, caplog):
    tested = start(start=False)
    goal = tested.send(trajectory((1.0, [1.0, 0.2, 0.0])))
    assert (goal.status, goal.result.error_code) == ("rejected", -1)
    assert "not running" in goal.result.error_string
    tested.commands.publish(trajectory((0.1, [1.0, 0.2, 0.0])))
    assert "not running" in caplog.text
    assert tested.bench.switch(start=["c"])
    tested.run(0.3)
    assert tested.positions() == [0.0, 0.0, 0.0]
    assert tested.bench.switch(stop=["c"])
    with pytest.raises(ServiceError, match="not running"):
        tested.node.call_service("c/query_state", QueryTrajectoryStateRequest(genpy.Time(1)))


def test_cancelling_holds_where_the_joints_are(start):
    tested = start()
    goal = tested.send(trajectory((1.0, [1.0, 0.2, 0.0])))
    tested.run(0.4)
    goal.cancel_requested = True
    tested.run(0.1)
    assert goal.status == "cancelled"
    assert tested.positions() == pytest.approx([0.4, 0.08, 0.0], abs=0.005)
    tested.run(1.0)
    assert tested.positions() == pytest.approx([0.4, 0.08, 0.0], abs=0.005)


def test_with_a_stop_duration_it_slows_down(start):
    tested = start(stop_trajectory_duration=0.2)
    goal = tested.send(trajectory((1.0, [1.0, 0.0, 0.0])))
    tested.run(0.5)
    goal.cancel_requested = True
    speeds = []
    for _ in range(150):
        tested.run(0.002)
        speeds.append(tested.joints["elbow"].state.velocity)
    # from 1 rad/s to rest within 0.2 s: 5 rad/s2
    assert max(abs(a - b) for a, b in zip(speeds[1:], speeds[2:])) == pytest.approx(0.01, rel=0.02)
    assert speeds[-1] == 0.0
    assert tested.positions()[0] == pytest.approx(0.5 + 0.1, abs=0.003)


def test_a_newer_goal_takes_over_without_a_jump(start):
    tested = start()
    first = tested.send(trajectory((1.0, [1.0, 0.2, 0.0])))
    tested.run(0.5)
    second = tested.send(trajectory((0.5, [0.0, 0.0, 0.5])))
    tested.run(0.002)
    assert first.status == "cancelled"
    assert "newer" in first.text
    assert tested.positions()[0] == pytest.approx(0.5, abs=0.005)
    tested.run(0.52)
    assert second.status == "succeeded"
    assert tested.positions() == pytest.approx([0.0, 0.0, 0.5])


def test_goals_that_come_within_one_cycle_all_end(start):
    tested = start()
    goals = [tested.send(trajectory((0.1, [0.1 * k, 0.0, 0.0]))) for k in range(1, 4)]
    tested.run(0.2)
    assert [goal.status for goal in goals] == ["cancelled", "cancelled", "succeeded"]


def test_a_topic_command_preempts_the_action(start):
    tested = start()
    goal = tested.send(trajectory((1.0, [1.0, 0.2, 0.0])))
    tested.run(0.2)
    tested.commands.publish(trajectory((0.3, [0.0, 0.0, 0.0])))
    tested.run(0.4)
    assert goal.status == "cancelled"
    assert tested.positions() == pytest.approx([0.0, 0.0, 0.0])


def test_an_action_preempts_a_topic_command(start):
    tested = start()
    tested.commands.publish(trajectory((1.0, [1.0, 0.2, 0.0])))
    tested.run(0.2)
    goal = tested.send(trajectory((0.3, [0.0, 0.0, 0.0])))
    tested.run(0.4)
    assert goal.status == "succeeded"
    assert tested.positions() == pytest.approx([0.0, 0.0, 0.0])


def test_a_trajectory_without_points_stops(start):
    tested = start()
    tested.commands.publish(trajectory((1.0, [1.0, 0.2, 0.0])))
    tested.run(0.3)
    tested.commands.publish(trajectory())
    tested.run(1.0)
    assert tested.positions() == pytest.approx([0.3, 0.06, 0.0], abs=0.005)


def test_a_goal_without_points_stops_and_succeeds(start):
    tested = start()
    running = tested.send(trajectory((1.0, [1.0, 0.2, 0.0])))
    tested.run(0.3)
    goal = tested.send(trajectory(), goal=[JointTolerance(name, 0.0, -1.0, 0.0) for name in NAMES])
    tested.run(0.01)
    assert running.status == "cancelled"
    assert goal.status == "succeeded"
    assert tested.positions()[0] == pytest.approx(0.3, abs=0.005)


@pytest.mark.parametrize("partial", [False, True])
def test_a_goal_without_joints_is_rejected(start, partial):
    tested = start(allow_partial_joints_goal=partial)
    running = tested.send(trajectory((1.0, [1.0, 0.2, 0.0])))
    tested.run(0.3)
    goal = tested.send(trajectory(names=[]))
    assert (goal.status, goal.result.error_code) == ("rejected", -2)
    tested.run(0.8)
    assert running.status == "succeeded"


def test_a_first_point_slightly_before_the_start_is_taken_for_the_present(start, caplog):
    tested = start()
    goal = tested.send(trajectory((-1e-6, [0.0, 0.0, 0.0]), (0.2, [0.2, 0.0, 0.0])))
    tested.run(0.1)
    assert tested.positions()[0] == pytest.approx(0.1, abs=0.01)
    tested.run(0.15)
    assert goal.status == "succeeded"
    assert "dropped" not in caplog.text


def test_a_trajectory_that_starts_later_lets_the_running_one_go_on(start):
    tested = start()
    tested.commands.publish(trajectory((1.0, [1.0, 0.0, 0.0])))
    tested.run(0.2)
    begun = tested.time
    tested.commands.publish(trajectory((0.5, [0.0, 0.0, 0.0]), stamp=begun + 0.4))
    tested.run(0.4)
    assert tested.positions()[0] == pytest.approx(0.6, abs=0.005)
    tested.run(0.25)
    assert tested.positions()[0] == pytest.approx(0.3, abs=0.01)
    tested.run(0.3)
    assert tested.positions()[0] == pytest.approx(0.0)


def test_points_in_the_past_are_dropped(start, caplog):
    tested = start()
    tested.run(1.0)
    message = trajectory(
        (0.1, [9.0, 9.0, 9.0]),
        (0.2, [-9.0, 9.0, 9.0]),
        (0.8, [0.5, 0.1, 0.0]),
        stamp=tested.time - 0.5,
    )
    tested.commands.publish(message)
    tested.run(0.15)
    assert "first 2 of 3" in caplog.text
    assert tested.positions()[0] == pytest.approx(0.25, abs=0.01)
    tested.run(0.2)
    assert tested.positions() == pytest.approx([0.5, 0.1, 0.0])


def test_a_first_point_at_the_start_is_dropped_silently(start, caplog):
    tested = start()
    goal = tested.send(trajectory((0.0, [0.0, 0.0, 0.0]), (0.2, [0.2, 0.0, 0.0])))
    tested.run(0.25)
    assert goal.status == "succeeded"
    assert "dropped" not in caplog.text


@pytest.mark.parametrize("early", [-3.0, -0.4, -1e-9])
def test_a_point_before_a_start_to_come_is_dropped(start, early):
    tested = start()
    tested.run(0.2)
    goal = tested.send(
        trajectory(
            (early, [9.0, 9.0, 9.0]),
            (0.2, [0.2, 0.1, 0.0]),
            (0.4, [0.4, 0.1, 0.0]),
            stamp=tested.time + 0.5,
        )
    )
    tested.run(0.45)
    assert tested.positions() == [0.0, 0.0, 0.0]
    tested.run(0.25)
    assert tested.positions() == pytest.approx([0.2, 0.1, 0.0], abs=0.02)
    tested.run(0.3)
    assert goal.status == "succeeded"
    assert tested.positions() == pytest.approx([0.4, 0.1, 0.0])


def test_a_trajectory_that_ends_before_its_start_is_rejected_and_what_runs_goes_on(start):
    tested = start()
    running = tested.send(trajectory((0.5, [0.5, 0.1, 0.0])))
    tested.run(0.2)
    points = ((-2.0, [9.0, 9.0, 9.0]), (-1.5, [0.0, 0.0, 0.0]))
    goal = tested.send(trajectory(*points, stamp=tested.time + 5.0))
    assert (goal.status, goal.result.error_code) == ("rejected", -3)
    assert "the last one by 1.500 s" in goal.result.error_string
    tested.run(0.4)
    assert running.status == "succeeded"


def test_a_trajectory_that_lies_in_the_past_is_rejected(start):
    tested = start()
    tested.run(2.0)
    goal = tested.send(trajectory((0.5, [0.5, 0.0, 0.0]), stamp=tested.time - 1.0))
    assert (goal.status, goal.result.error_code) == ("rejected", -3)
    assert "0.4" in goal.result.error_string or "0.5" in goal.result.error_string


def test_a_goal_that_is_over_before_the_loop_sees_it_is_aborted(start):
    tested = start()
    tested.run(1.0)
    goal = tested.send(trajectory((0.5, [0.5, 0.0, 0.0]), stamp=tested.time - 0.5 + 0.001))
    assert goal.status == "active"
    tested.bench.time += 0.05
    tested.run(0.01)
    assert (goal.status, goal.result.error_code) == ("aborted", -3)
    assert tested.positions() == [0.0, 0.0, 0.0]


def test_a_trajectory_that_is_over_before_the_loop_sees_it_ends_nothing_else(start, caplog):
    tested = start()
    running = tested.send(trajectory((1.0, [1.0, 0.2, 0.0])))
    tested.run(0.5)
    late = trajectory((0.5, [0.0, 0.0, 0.0]), stamp=tested.time - 0.5 + 0.001)
    goal = tested.send(late)
    tested.commands.publish(late)
    tested.bench.time += 0.05
    tested.run(0.01)
    assert (goal.status, goal.result.error_code) == ("aborted", -3)
    assert "c/command: all points lie in the past; the trajectory is dropped" in caplog.text
    assert running.status == "active"
    tested.run(0.5)
    assert running.status == "succeeded"
    assert tested.positions() == pytest.approx([1.0, 0.2, 0.0])


def test_continuous_joints_take_the_nearest_turn(start):
    tested = start(start=False)
    tested.hw.states["wheel"].position = 4.0 * math.pi + 3.0
    assert tested.bench.switch(start=["c"])
    goal = tested.send(trajectory((0.5, [0.0, 0.0, -3.0]), (1.0, [0.0, 0.0, -2.0])))
    tested.run(0.55)
    assert tested.positions()[2] == pytest.approx(6.0 * math.pi - 3.0, abs=0.2)
    tested.run(0.5)
    assert tested.positions()[2] == pytest.approx(6.0 * math.pi - 2.0)
    assert goal.status == "succeeded"


def test_prismatic_errors_are_lengths_not_angles(start):
    tested = start()
    states = tested.states()
    tested.stuck.add("slide")
    tested.commands.publish(trajectory((0.1, [0.0, 4.0, 0.0])))
    tested.run(0.2)
    assert states[-1].error.positions[1] == pytest.approx(4.0)


def test_parts_of_the_joints_when_allowed(start):
    tested = start(allow_partial_joints_goal=True)
    tested.commands.publish(trajectory((1.0, [1.0, 0.2, 0.5])))
    tested.run(0.5)
    goal = tested.send(trajectory((0.2, [0.0]), names=["elbow"]))
    tested.run(0.25)
    assert goal.status == "succeeded"
    assert tested.positions()[0] == pytest.approx(0.0)
    tested.run(0.3)
    assert tested.positions() == pytest.approx([0.0, 0.2, 0.5])  # the others went on


def test_a_path_tolerance_that_is_violated_aborts_and_holds(start):
    tested = start(constraints={"elbow": {"trajectory": 0.1}})
    tested.stuck.add("elbow")
    goal = tested.send(trajectory((1.0, [1.0, 0.2, 0.0])))
    tested.run(0.5)
    assert (goal.status, goal.result.error_code) == ("aborted", -4)
    assert goal.result.error_string.startswith("elbow path error 0.10")
    assert goal.result.error_string.endswith(": position, tolerance 0.1")
    tested.run(1.0)
    # it held, it did not go on to the end
    assert tested.positions() == pytest.approx([0.0, 0.02, 0.0], abs=0.001)
    assert tested.joints["elbow"].command == 0.0


def test_a_goal_tolerance_has_time_to_be_met(start):
    tested = start(constraints={"goal_time": 0.5, "elbow": {"goal": 0.05}})
    tested.stuck.add("elbow")
    goal = tested.send(trajectory((0.2, [0.3, 0.0, 0.0])))
    tested.run(0.5)
    assert goal.status == "active"
    tested.stuck.clear()
    tested.run(0.1)
    assert goal.status == "succeeded"


def test_a_goal_tolerance_that_is_not_met_aborts(start):
    tested = start(constraints={"goal_time": 0.2, "elbow": {"goal": 0.05}})
    tested.stuck.add("elbow")
    goal = tested.send(trajectory((0.2, [0.3, 0.0, 0.0])))
    tested.run(0.39)
    assert goal.status == "active"
    tested.run(0.05)
    assert (goal.status, goal.result.error_code) == ("aborted", -5)
    assert goal.result.error_string == "elbow goal error 0.300000: position, tolerance 0.05"


def test_the_goal_message_overrides_the_parameters(start):
    tested = start(constraints={"elbow": {"trajectory": 0.1, "goal": 0.1}})
    tested.stuck.add("elbow")
    goal = tested.send(
        trajectory((0.2, [0.3, 0.0, 0.0])),
        path=[JointTolerance("elbow", -1.0, 0.0, 0.0)],
        goal=[JointTolerance("elbow", 0.5, 0.0, 0.0)],
    )
    tested.run(0.3)
    assert goal.status == "succeeded"
    goal = tested.send(
        trajectory((0.2, [0.3, 0.0, 0.0])), path=[JointTolerance("elbow", 0.01, 0.0, 0.0)]
    )
    tested.run(0.3)
    assert (goal.status, goal.result.error_code) == ("aborted", -4)


def test_a_joint_that_still_moves_has_not_reached_its_goal(start):
    tested = start(constraints={"goal_time": 0.3, "stopped_velocity_tolerance": 0.01})
    tested.moves = False
    goal = tested.send(trajectory((0.1, [0.0, 0.0, 0.0])))
    for _ in range(100):
        tested.joints["elbow"].state.position += 0.001
        tested.bench.cycle()
        tested.joints["elbow"].state.velocity = 0.5
    assert goal.status == "active"
    tested.joints["elbow"].state.velocity = 0.0
    tested.bench.cycle()
    assert goal.status == "succeeded"


def test_a_joint_that_never_rests_aborts_by_its_velocity(start):
    tested = start(constraints={"goal_time": 0.1, "stopped_velocity_tolerance": 0.01})
    tested.moves = False
    goal = tested.send(trajectory((0.1, [0.0, 0.0, 0.0])))
    for _ in range(300):
        tested.joints["elbow"].state.velocity = 0.5
        tested.bench.cycle()
    assert (goal.status, goal.result.error_code) == ("aborted", -5)
    assert goal.result.error_string == "elbow goal error -0.500000: velocity, tolerance 0.01"


def test_until_a_later_start_its_tolerances_do_not_count(start):
    tested = start()
    tested.commands.publish(trajectory((1.0, [1.0, 0.0, 0.0])))
    tested.run(0.1)
    tested.stuck.add("elbow")
    goal = tested.send(
        trajectory((0.3, [0.1, 0.0, 0.0]), stamp=tested.time + 0.3),
        path=[JointTolerance("elbow", 0.15, 0.0, 0.0)],
    )
    tested.run(0.29)
    assert goal.status == "active"
    tested.run(0.1)
    assert goal.status == "aborted"


def test_stopping_cancels_the_goal(start):
    tested = start()
    goal = tested.send(trajectory((1.0, [1.0, 0.0, 0.0])))
    tested.run(0.2)
    waiting = tested.send(trajectory((2.0, [1.0, 0.0, 0.0])))
    assert tested.bench.switch(stop=["c"])
    assert goal.status == "cancelled"
    assert waiting.status == "cancelled"


def test_a_restart_holds_and_cancels(start):
    tested = start()
    goal = tested.send(trajectory((1.0, [1.0, 0.0, 0.0])))
    tested.run(0.5)
    tested.bench.cycle(reset_controllers=True)
    assert goal.status == "cancelled"
    tested.run(0.5)
    assert tested.positions()[0] == pytest.approx(0.5, abs=0.005)


def test_the_state_can_be_queried(start):
    tested = start()
    begun = tested.time
    tested.commands.publish(trajectory((1.0, [1.0, 0.2, 0.0])))
    tested.run(0.1)
    answer = tested.node.call_service(
        "c/query_state", QueryTrajectoryStateRequest(genpy.Time.from_sec(begun + 0.5))
    )
    assert answer.name == list(NAMES)
    assert answer.position == pytest.approx([0.5, 0.1, 0.0])
    assert answer.velocity == pytest.approx([1.0, 0.2, 0.0])


def test_the_state_before_the_trajectory_is_not_known(start):
    tested = start()
    tested.run(1.0)
    tested.hw.states["elbow"].position = 0.7
    begun = tested.time
    tested.bench.cycle(reset_controllers=True)

    def position(time):
        request = QueryTrajectoryStateRequest(genpy.Time.from_sec(time))
        return tested.node.call_service("c/query_state", request).position[0]

    # Nothing was commanded yet: it holds since it was started. `from_sec` rounds down.
    assert position(begun) == position(begun + 9.0) == 0.7
    for time in (0.0, begun - 0.01):
        with pytest.raises(ServiceError, match=rf"time is {time:.3f} s; .* starts at {begun:.3f}"):
            position(time)
    tested.run(0.5)
    tested.commands.publish(trajectory((1.0, [0.0, 0.2, 0.0])))
    tested.run(0.5)
    assert position(tested.time) == pytest.approx(0.35, abs=0.01)
    with pytest.raises(ServiceError, match="from then on is needed"):
        position(begun - 0.01)


def test_the_state_is_published_at_its_rate(start):
    tested = start(state_publish_rate=25.0)
    states = tested.states()
    tested.commands.publish(trajectory((1.0, [1.0, 0.2, 0.0])))
    tested.run(1.0)
    assert len(states) in (25, 26)
    middle = states[12]
    assert middle.joint_names == list(NAMES)
    assert middle.desired.positions[0] == pytest.approx(0.5, abs=0.05)
    assert middle.actual.positions[0] == pytest.approx(middle.desired.positions[0], abs=0.005)
    assert len(middle.error.positions) == 3


def test_effort_is_made_of_errors_velocity_and_feed_forward(start):
    gains = {name: {"p": 10.0, "d": 2.0} for name in NAMES}
    tested = start("effort_controllers", gains=gains, velocity_ff={"elbow": 3.0})
    tested.commands.publish(trajectory((1.0, [1.0, 0.2, 0.0])))
    tested.run(0.502)
    # 0.5 rad behind, at 1 rad/s: p 0.5 + d 1 + ff 1
    assert tested.joints["elbow"].command == pytest.approx(5.0 + 2.0 + 3.0, rel=0.01)
    assert tested.joints["slide"].command == pytest.approx(1.0 + 0.4, rel=0.01)
    assert tested.bench.switch(stop=["c"])
    assert tested.joints["elbow"].command == 0.0


def test_velocities_are_commanded_from_gains(start):
    gains = {name: {"p": 4.0} for name in NAMES}
    ones = {name: 1.0 for name in NAMES}
    tested = start("velocity_controllers", gains=gains, velocity_ff=ones)
    tested.commands.publish(trajectory((1.0, [1.0, 0.2, 0.0])))
    tested.run(0.252)
    assert tested.joints["elbow"].command == pytest.approx(4.0 * 0.25 + 1.0, rel=0.01)


def test_gains_of_a_trajectory_controller_change_at_run_time(start):
    gains = {name: {"p": 10.0} for name in NAMES}
    tested = start("effort_controllers", gains=gains)
    tested.commands.publish(trajectory((0.1, [0.5, 0.0, 0.0])))
    tested.run(0.2)
    assert tested.joints["elbow"].command == pytest.approx(5.0)
    tested.node.reconfigure("c/gains/elbow", p=20.0)
    tested.run(0.002)
    assert tested.joints["elbow"].command == pytest.approx(10.0)


@pytest.mark.parametrize(
    ("kind", "change", "logged"),
    [
        ("position", {"joints": []}, "joints is []"),
        ("position", {"joints": ["elbow", "elbow"]}, "distinct names"),
        ("position", {"joints": ["nose"]}, "'nose'"),
        ("position", {"state_publish_rate": 0.0}, "state_publish_rate is 0.0"),
        ("position", {"stop_trajectory_duration": -1.0}, "stop_trajectory_duration is -1.0"),
        ("position", {"constraints": {"goal_time": -1.0}}, "constraints/goal_time is -1.0"),
        ("position", {"constraints": {"nose": {"goal": 1.0}}}, "constraints/nose is unknown"),
        ("effort", {}, "gains/elbow is missing"),
        ("effort", {"gains": {"elbow": {"i": 1.0}}}, "gains/elbow/p is missing"),
    ],
)
def test_wrong_parameters_are_named(bench, caplog, kind, change, logged):
    own = {
        "type": f"{kind}_controllers/JointTrajectoryController",
        "joints": list(NAMES),
        **change,
    }
    assert not bench({"c": own}).manager.load_controller("c")
    assert logged in caplog.text


def _counting(function, calls):
    return lambda *arguments: calls.append(1) or function(*arguments)


def test_a_long_trajectory_is_taken_over_within_a_cycle(start, monkeypatch):
    tested = start()
    points = [(0.01 * (k + 1), [0.001 * k, 0.0, 0.0], [0.1, 0.0, 0.0]) for k in range(5000)]
    goal = tested.send(trajectory(*points))
    made = []
    monkeypatch.setattr(spline, "_coefficients", _counting(spline._coefficients, made))
    tested.run(0.002)
    assert len(made) == len(NAMES)  # the bridges; the splines between points come later
    tested.run(0.5)
    assert goal.status == "active"
    assert tested.positions()[0] == pytest.approx(0.049, abs=0.001)


def test_a_goal_whose_controller_stops_while_it_is_read_is_cancelled(start, monkeypatch):
    tested = start()

    def stopped_meanwhile(*arguments):
        tracks = read_tracks(*arguments)
        assert tested.bench.switch(stop=["c"])
        return tracks

    monkeypatch.setattr(joint_trajectory_controller, "read_tracks", stopped_meanwhile)
    goal = tested.send(trajectory((1.0, [0.5, 0.1, 0.2])))
    assert goal.status == "cancelled"
    assert tested.bench.switch(start=["c"])
    tested.run(1.5)
    assert tested.positions() == [0.0, 0.0, 0.0]


def test_a_state_that_is_restored_goes_on_along_its_trajectory_without_a_goal(start):
    tested = start()
    first = tested.send(trajectory((1.0, [1.0, 0.2, 2.0])))
    tested.run(0.5)
    saved, began = tested.bench.manager.save_state(), tested.bench.time
    tested.run(1.0)
    assert first.status == "succeeded"
    second = tested.send(trajectory((2.0, [0.0, 0.0, 0.0])))
    tested.run(0.1)
    now = tested.bench.time
    tested.bench.manager.restore_state(saved, now, now - began)
    assert second.status == "cancelled"
    assert "bookmark" in second.text
    tested.run(0.25)
    assert tested.positions() == pytest.approx([0.75, 0.15, 1.5], abs=0.02)
    tested.run(0.5)
    assert tested.positions() == pytest.approx([1.0, 0.2, 2.0])
