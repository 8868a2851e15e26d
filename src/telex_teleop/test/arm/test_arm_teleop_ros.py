"""arm_teleop on a ROS master of its own, with Telex's own arm whose joints follow references."""

from __future__ import annotations

import math
import re
import subprocess
import sys
import time

import numpy as np
import pytest
import yaml
from fake_robot import PACKAGE, TICK, FakeRobot, held_until, holding, wait_until_told
from own_ros import NodeProcess, Topics, wait_until_connected
from waiting import wait_until

from telex_control.kinematics import Chain, quaternion_of
from telex_teleop.motion.rigid_motion import advanced, pose_error
from telex_teleop.motion.teleop_core import NEEDS_NEW_PRESS

pytestmark = [pytest.mark.ros, pytest.mark.waiting]

NAMESPACE = "/telex"
DESCRIPTION = PACKAGE.parent / "telex_description"
POSES = yaml.safe_load((DESCRIPTION / "config" / "poses.yaml").read_text())["poses"]
READY = POSES["ready"]
SPEED = 0.05  # m/s, far below every joint's limits
YAW = 0.7  # of the base in the world (rad)
FRAMES = ("base_link", "tool_link", "world")


class World:
    """Publishes where the base is, and what is near, with each joint state."""

    def __init__(self, topics, robot, chain):
        from geometry_msgs.msg import PoseStamped
        from telex_msgs.msg import Proximity

        self._robot, self._chain = robot, chain
        self.x = 0.0
        self.speed = 0.0
        self.floor = None  # height in the base's frame (m)
        self._base = topics.publisher("sim/base_pose", PoseStamped, queue_size=1)
        self._near = topics.publisher("sim/proximity", Proximity, queue_size=1)
        robot.each = self.publish

    def pose(self):
        made = advanced(np.eye(4), np.array([0, 0, 0, 0, 0, YAW]))
        made[:3, 3] = self.x * math.cos(YAW), self.x * math.sin(YAW), 0.2
        return made

    def publish(self, stamp):
        from geometry_msgs.msg import PoseStamped
        from telex_msgs.msg import Proximity, ProximityPair

        from telex_control.ros.pose_messages import fill_pose

        self.x += self.speed * TICK
        message = PoseStamped()
        message.header.stamp = stamp
        message.header.frame_id = "world"
        fill_pose(message.pose, self.pose())
        self._base.publish(message)
        near = Proximity(joints=self._chain.joint_names)
        near.header.stamp = stamp
        near.positions = [self._robot.positions[joint] for joint in near.joints]
        if self.floor is not None:
            height = self._chain.forward(near.positions)[2, 3]
            floor = ProximityPair(link="gripper_link", other="floor", distance=height - self.floor)
            floor.gradient = self._chain.jacobian(near.positions)[2].tolist()
            floor.normal.z = 1.0
            near.pairs = [floor]
        self._near.publish(near)


class ToolOperator:
    """Leads the tool of a robot by arm_teleop."""

    def __init__(self, topics, robot, world, chain):
        from geometry_msgs.msg import PoseStamped, TwistStamped
        from std_msgs.msg import Bool, Float64, String
        from std_srvs.srv import SetBool
        from telex_msgs.msg import CartesianTeleopStatus, JointTeleopStatus
        from telex_msgs.srv import ComputeFK, ComputeIK, SetMode

        self.robot, self.world, self.chain = robot, world, chain
        self.twists = topics.publisher("arm_teleop/delta_twist_cmds", TwistStamped)
        self.poses = topics.publisher("arm_teleop/pose_cmds", PoseStamped)
        self.names = topics.publisher("arm_teleop/named_pose_cmds", String)
        self.speed = topics.publisher("arm_teleop/speed_scale", Float64)
        self.e_stop = topics.publisher("e_stop", Bool)
        self.exam = topics.publisher("bridge/exam", String)
        self.status = topics.heard("arm_teleop/status", JointTeleopStatus)
        self.cartesian = topics.heard("arm_teleop/cartesian_status", CartesianTeleopStatus)
        self.set_mode = topics.calls("arm_teleop/set_mode", SetMode)
        self.hold_tool = topics.calls("arm_teleop/hold_tool", SetBool)
        self.set_guard = topics.calls("arm_teleop/set_proximity_guard", SetBool)
        self.compute_fk = topics.calls("arm_teleop/compute_fk", ComputeFK)
        self.compute_ik = topics.calls("arm_teleop/compute_ik", ComputeIK)

    def wait_until_ready(self):
        wait_until_connected(self.twists, self.poses, self.names, self.speed, self.e_stop)
        wait_until(lambda: self.cartesian[-1].ready, "the kinematics", 60.0)
        wait_until(lambda: self.status[-1].message == "", "arm_teleop to listen", 60.0)

    @property
    def q(self):
        return [self.robot.positions[joint] for joint in self.chain.joint_names]

    @property
    def tool(self):
        return self.chain.forward(self.q)

    def reset(self):
        """Let the arm stand in its pose ready, as if somebody had put it there, with all as set."""
        from std_msgs.msg import Bool, Float64

        self.world.floor, self.world.speed = None, 0.0
        self.e_stop.publish(Bool(False))
        self.speed.publish(Float64(1.0))
        assert self.set_mode("CARTESIAN").success
        assert self.hold_tool(False).success
        assert self.set_guard(True).success
        self.robot.rest()
        self.robot.put({joint: READY[joint] for joint in self.chain.joint_names}, self.status)

        def ready():
            status = self.status[-1]
            # what it said of an earlier command stays in its status for a while
            deaf = status.message.startswith(("the e-stop", "no joint", "just started"))
            return (status.mode, status.speed_scale) == ("CARTESIAN", 1.0) and not deaf

        wait_until(ready, lambda: f"arm_teleop to be ready (its status: {self.status[-1:]})")

    def leading(self, message, least=1e-3):
        """Lead the tool by a twist; gives it once the tool has moved so far (m, rad)."""
        start = self.tool
        return held_until(
            lambda: np.abs(pose_error(self.tool, start)).max() > least,
            "motion",
            self.twists,
            message,
            self.status,
        )

    def sink(self, message):
        """Lead the tool down by a twist, for 0.03 m."""
        high = float(self.tool[2, 3])
        what = "the tool to go through the floor"

        def sunk():
            return high - self.tool[2, 3] > 0.03

        with held_until(sunk, what, self.twists, message, self.status):
            pass

    def moved(self, act, seconds=0.0):
        """How far the tool moves (m, rad) while something is done, and some time (s) after it."""
        start = self.tool
        act()
        time.sleep(seconds)
        return float(np.abs(pose_error(self.tool, start)).max())

    def moved_within(self, seconds):
        return self.moved(lambda: None, seconds)

    def last(self):
        """A status that is new, and no older than what was done before."""
        count = len(self.status) + 2
        wait_until(lambda: len(self.status) >= count, "a status")
        return self.status[-1]

    def step(self, frame, axis, rate):
        """Lead the tool a little; its step along the axes of a frame."""
        start = self.tool
        with self.leading(twist(frame, axis, rate), least=0.3 * rate):
            pass
        self.robot.rest()
        step = pose_error(self.tool, start)
        turn = {
            "base_link": np.eye(3),
            "tool_link": start[:3, :3].T,
            "world": self.world.pose()[:3, :3],
        }[frame]
        return np.array([*(turn @ step[:3]), *(turn @ step[3:])])


@pytest.fixture(scope="module")
def started(master):
    import rospy

    script = DESCRIPTION / "scripts" / "robot_description"
    urdf = subprocess.run(
        [sys.executable, str(script)], capture_output=True, text=True, check=True
    ).stdout
    rospy.set_param("/use_sim_time", True)
    rospy.set_param(f"{NAMESPACE}/robot_description", urdf)
    for file in (PACKAGE / "config" / "arm_teleop.yaml", DESCRIPTION / "config" / "poses.yaml"):
        for name, value in yaml.safe_load(file.read_text()).items():
            rospy.set_param(f"{NAMESPACE}/arm_teleop/{name}", value)
    joints = rospy.get_param(f"{NAMESPACE}/arm_teleop/joints")
    chain = Chain.from_urdf(urdf, "base_link", "tool_link")
    with Topics(NAMESPACE) as topics:
        robot = FakeRobot(topics, joints)
        robot.positions.update({joint: READY[joint] for joint in joints})
        world = World(topics, robot, chain)
        operator = ToolOperator(topics, robot, world, chain)
        environment = dict(master, ROS_NAMESPACE=NAMESPACE)
        with robot, NodeProcess([PACKAGE / "nodes" / "arm_teleop"], environment):
            operator.wait_until_ready()
            yield operator


@pytest.fixture
def arm(started):
    started.reset()
    return started


class TestTwist:
    @pytest.mark.parametrize("frame", FRAMES)
    def test_moves_the_tool_along_the_axis_of_its_frame(self, arm, frame):
        # all axes of all frames: test_arm_tool_motion.py
        axis = FRAMES.index(frame)
        step = arm.step(frame, axis, SPEED)
        assert step[axis] > 0.01
        assert np.abs(np.delete(step, axis)).max() < 1e-3

    def test_turns_about_the_tool_centre_point_and_stops_with_the_stream(self, arm):
        step = arm.step("tool_link", 4, 0.2)
        assert step[4] > 0.05
        assert np.abs(np.delete(step, 4)).max() < 1e-3
        assert arm.moved_within(0.2) == 0.0

    def test_is_refused_in_joint_mode(self, arm):
        assert arm.set_mode("JOINT").success
        with holding(arm.twists, twist()):
            assert arm.moved_within(0.5) == 0.0
            assert "set CARTESIAN" in arm.last().message

    @pytest.mark.parametrize(
        ("bad", "said"),
        [
            ({"frame": "camera_link"}, "camera_link"),
            ({"rate": math.nan}, "nan"),
            ({"rate": math.inf}, "inf"),
        ],
    )
    def test_bad_ones_move_nothing_and_are_explained(self, arm, bad, said):
        with holding(arm.twists, twist(**bad)):
            assert arm.moved_within(0.1) == 0.0
            assert said in arm.last().message

    def test_e_stop_ends_it_and_latches(self, arm):
        from std_msgs.msg import Bool

        with arm.leading(twist(rate=0.5 * SPEED)):
            arm.e_stop.publish(Bool(True))
            wait_until_told(arm.status, "the e-stop is active")
            arm.robot.rest(10 * TICK)
            assert arm.moved_within(0.2) == 0.0
            arm.e_stop.publish(Bool(False))
            wait_until_told(arm.status, NEEDS_NEW_PRESS)
            assert arm.moved_within(0.4) == 0.0
        wait_until_told(arm.status, "")
        with arm.leading(twist()):
            pass


class TestPose:
    def test_goes_along_a_straight_line_at_the_set_speed_and_stops_with_the_stream(self, arm):
        from std_msgs.msg import Float64

        arm.speed.publish(Float64(0.4))
        goal = advanced(arm.tool, np.array([0.08, 0.06, 0.05, 0.0, 0.1, 0.1]))
        start = line = begin = None

        def set_out():
            nonlocal start, line, begin
            start, begin = arm.tool, len(arm.robot.history)
            line = goal[:3, 3] - start[:3, 3]

        def share_of_the_way():
            return (arm.tool - start)[:3, 3] @ line / (line @ line)

        def moves_on():
            (_, before), *_, (_, now) = arm.robot.history[-5:]
            return share_of_the_way() > 0.35 and now != before

        set_out()
        with held_until(
            moves_on, "the tool to move", arm.poses, pose_message(goal), arm.status, set_out
        ):
            pass
        halfway = arm.tool
        arm.robot.rest()
        rest = arm.tool
        assert 0.0 < np.linalg.norm(rest[:3, 3] - halfway[:3, 3]) < 0.2
        # at rest on the way, for the fake robot's joints move one after the other; exactly, and at
        # every tick: test_arm_tool_motion.py
        share = share_of_the_way()
        assert 0.2 < share < 0.8
        assert np.linalg.norm((rest - start)[:3, 3] - share * line) < 2e-3
        places = np.array(
            [
                arm.chain.forward([each[joint] for joint in arm.chain.joint_names])[:3, 3]
                for _, each in arm.robot.history[begin:]
            ]
        )
        # over a tenth of a second, for references may come late by a joint state
        speeds = np.linalg.norm(places[10:] - places[:-10], axis=1) / 0.1
        assert np.percentile(speeds, 90) == pytest.approx(0.15 * 0.4, rel=0.1)

    def test_arrives(self, arm):
        goal = advanced(arm.tool, np.array([0.04, 0.03, 0.025, 0.0, 0.05, 0.05]))

        def arrived():
            return np.abs(pose_error(arm.tool, goal)).max() < 1e-4

        with held_until(arrived, "the pose", arm.poses, pose_message(goal), arm.status):
            pass

    def test_quaternion_that_is_not_normalised_moves_nothing(self, arm):
        askew = pose_message(arm.tool)
        askew.pose.orientation.w += 0.2
        with holding(arm.poses, askew):
            assert arm.moved_within(0.1) == 0.0
            assert "norm" in arm.last().message


class TestModesAndOptions:
    def test_modes(self, arm):
        for mode in ("JOINT", "CARTESIAN"):
            answer = arm.set_mode(mode)
            assert (answer.success, answer.message) == (True, "")
            assert arm.last().mode == mode
        assert arm.set_mode("FLY").success is False
        assert arm.last().mode == "CARTESIAN"

    def test_tool_keeps_its_place_while_the_base_drives(self, arm):
        answer = arm.hold_tool(True)
        assert (answer.success, answer.message) == (True, "")
        time.sleep(0.2)
        place = (arm.world.pose() @ arm.tool)[:3, 3]
        begin = arm.world.x
        arm.world.speed = 0.05
        wait_until(lambda: arm.world.x - begin > 0.06, "the base to drive")
        arm.world.speed = 0.0
        arm.robot.rest()
        assert arm.world.x - begin > 0.05
        assert np.linalg.norm((arm.world.pose() @ arm.tool)[:3, 3] - place) < 0.005

    def test_named_pose(self, arm):
        from std_msgs.msg import String

        arm.robot.positions[arm.chain.joint_names[0]] += 0.2
        arm.robot.rest()

        def arrived():
            return "in pose ready" in arm.status[-1].notice

        with held_until(arrived, "pose ready", arm.names, String("ready"), arm.status):
            pass
        # of the telescope, which rests at its limit: references keep a margin of 0.5 mm to it
        assert max(abs(arm.robot.positions[j] - READY[j]) for j in arm.chain.joint_names) < 5.1e-4

    def test_unknown_named_pose_is_told_with_the_known_ones(self, arm):
        from std_msgs.msg import String

        with holding(arm.names, String("moon")):
            message = arm.last().message
        known = ", ".join(POSES)
        assert message.split(": ", 1)[1] == f"pose 'moon' is unknown; known are {known}"

    def test_what_is_near_stops_the_tool(self, arm):
        arm.world.floor = float(arm.tool[2, 3]) - 0.005
        time.sleep(0.2)
        down = twist("base_link", 2, -SPEED)
        pressed = time.monotonic()

        def stopped():
            notice = arm.status[-1].notice
            told = re.match("stopped: gripper_link is [45] mm from floor", notice)
            return told and time.monotonic() - pressed > 0.7

        def lead():
            with held_until(stopped, "the tool to stop", arm.twists, down, arm.status):
                pass

        assert arm.moved(lead) < 0.01
        time.sleep(0.4)
        answer = arm.set_guard(False)
        assert (answer.success, answer.message) == (True, "")
        arm.sink(down)

    def test_in_an_exam_it_feels_what_stands_around_it_only_with_sensors_for_that(self, arm):
        import rospy
        from std_msgs.msg import String

        wait_until_connected(arm.exam)
        arm.world.floor = float(arm.tool[2, 3]) - 0.005
        down = twist("base_link", 2, -SPEED)
        try:
            rospy.set_param(f"{NAMESPACE}/equipment", {"proximity": {"topic": "sim/proximity"}})
            arm.exam.publish(String("of a robot with sensors"))
            time.sleep(0.2)
            with holding(arm.twists, down):
                assert arm.moved_within(0.6) < 0.01
            time.sleep(0.4)
            rospy.set_param(f"{NAMESPACE}/equipment", {"pads": {}})
            arm.exam.publish(String("of one without"))
            time.sleep(0.2)
            arm.sink(down)
        finally:
            arm.exam.publish(String(""))
            rospy.delete_param(f"{NAMESPACE}/equipment")

    def test_status_of_the_tool(self, arm):
        wait_until(lambda: arm.cartesian[-1].ready, "the kinematics")
        count = len(arm.cartesian) + 2
        wait_until(lambda: len(arm.cartesian) >= count, "a status of the tool")
        status = arm.cartesian[-1]
        assert sorted(status.frames) == sorted(FRAMES)
        assert abs(status.tool.position.x - arm.tool[0, 3]) < 1e-6


class TestServices:
    Q = (0.3, -1.0, 0.1, 1.5, 0.4, 0.6, -0.8)

    @pytest.fixture
    def target(self, started):
        return started.chain.forward(list(self.Q))

    def test_forward_kinematics(self, started, target):
        state = {"joint_names": list(started.chain.joint_names), "positions": list(self.Q)}
        (found,) = started.compute_fk(**state).poses
        assert off_by(found, target) < 1e-9
        assert found.header.frame_id == "base_link"
        (found,) = started.compute_fk(frame_id="world", **state).poses
        assert off_by(found, started.world.pose() @ target) < 1e-6

    def test_inverse_kinematics_of_forward_kinematics(self, started, target):
        found = started.compute_ik(pose=pose_message(target))
        assert found.status == "CONVERGED"
        reached = started.chain.forward(list(found.positions))
        assert np.abs(pose_error(reached, target)).max() < 2e-5

    def test_pose_out_of_reach_has_the_nearest_solution(self, started, target):
        target[0, 3] += 3.0
        far = started.compute_ik(pose=pose_message(target))
        assert (far.success, far.status, len(far.positions)) == (False, "BEST_EFFORT", 7)
        assert "out of reach" in far.message
        assert far.position_error > 1.0

    @pytest.mark.parametrize(
        ("request_of", "says"),
        [
            (
                {"joint_names": ["knee"], "positions": [0.0]},
                "joint 'knee' does not carry the tool; these do: turret_joint",
            ),
            ({"link_names": ["no_link"]}, "no_link"),
            ({"frame_id": "moon"}, "header.frame_id is 'moon'"),
            (
                {"joint_names": ["turret_joint"], "positions": [math.nan]},
                "position of turret_joint is nan",
            ),
            (
                {"joint_names": ["turret_joint"] * 2, "positions": [0.0, 1.0]},
                "joint_names: turret_joint stands there twice",
            ),
        ],
    )
    def test_bad_requests_for_a_pose_are_refused_with_the_reason(self, started, request_of, says):
        answer = started.compute_fk(**request_of)
        assert answer.success is False
        assert says in answer.message

    @pytest.mark.parametrize(
        ("askew", "values", "says"),
        [
            (0.1, {}, "norm"),
            (0.0, {"free_axis": "w"}, "free_axis is 'w'"),
            (0.0, {"position_tolerance": -1.0}, "position_tolerance is -1.0"),
            (0.0, {"orientation_tolerance": 1e-15}, "must be at least 1e-12, or 0"),
            (0.0, {"seed_names": ["turret_joint"], "seed": [1e5]}, "of at most 10000"),
        ],
    )
    def test_bad_requests_for_joints_are_refused_with_the_reason(
        self, started, target, askew, values, says
    ):
        pose = pose_message(target)
        pose.pose.orientation.w += askew
        answer = started.compute_ik(pose=pose, **values)
        assert answer.success is False
        assert says in answer.message


def off_by(message, pose):
    """Largest difference of position (m) or quaternion."""
    position, turned = message.pose.position, message.pose.orientation
    given = [position.x, position.y, position.z, turned.x, turned.y, turned.z, turned.w]
    return float(np.abs(np.array(given) - [*pose[:3, 3], *quaternion_of(pose)]).max())


def twist(frame="base_link", axis=0, rate=SPEED):
    from geometry_msgs.msg import TwistStamped

    message = TwistStamped()
    message.header.frame_id = frame
    part = message.twist.linear if axis < 3 else message.twist.angular
    setattr(part, "xyz"[axis % 3], rate)
    return message


def pose_message(pose, frame="base_link"):
    from geometry_msgs.msg import PoseStamped

    from telex_control.ros.pose_messages import fill_pose

    message = PoseStamped()
    message.header.frame_id = frame
    fill_pose(message.pose, pose)
    return message
