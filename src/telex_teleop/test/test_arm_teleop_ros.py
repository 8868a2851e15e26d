"""arm_teleop on a ROS master of its own, with Telex's own arm whose joints follow their references.

As in test_teleop_ros.py, one run of this file as a program plays the drill and prints what it
measured as JSON; the tests judge that.
"""

from __future__ import annotations

import json
import math
import re
import subprocess
import sys
import time

import numpy as np
import pytest
import yaml
from teleop_drill import PACKAGE, FakeRobot, Held, Node, repeat, wait_for

from telex_control.kinematics import Chain, quaternion_of
from telex_control.ros.rospy_fixes.connecting import miss_nothing
from telex_experiments.rigs.private_master import PrivateMaster
from telex_teleop.motion.rigid_motion import advanced, pose_error

DESCRIPTION = PACKAGE.parent / "telex_description"
READY = yaml.safe_load((DESCRIPTION / "config" / "poses.yaml").read_text())["poses"]["ready"]
SPEED = 0.05  # m/s, far below every joint's limits
YAW = 0.7  # of the base in the world (rad)
FRAMES = ("base_link", "tool_link", "world")


@pytest.fixture(scope="module")
def drill():
    """What the drill measured."""
    with PrivateMaster() as master:
        done = subprocess.run(
            [sys.executable, __file__],
            env=dict(master.environment(), ROS_NAMESPACE="/telex"),
            capture_output=True,
            text=True,
            timeout=200.0,
            check=False,
        )
    assert done.returncode == 0, done.stdout[-4000:] + done.stderr[-4000:]
    return json.loads(done.stdout.splitlines()[-1])


@pytest.mark.ros
class TestTwist:
    @pytest.mark.parametrize("frame", FRAMES)
    def test_moves_the_tool_along_the_axis_of_its_frame(self, drill, frame):
        # all axes of all frames: test_arm_tool_motion.py
        axis = FRAMES.index(frame)
        step = np.array(drill["twists"][frame])
        assert step[axis] > 0.01
        assert np.abs(np.delete(step, axis)).max() < 1e-3

    def test_turns_about_the_tool_centre_point(self, drill):
        step = np.array(drill["turn"])
        assert step[4] > 0.05
        assert np.abs(np.delete(step, 4)).max() < 1e-3

    def test_stops_when_the_stream_stops(self, drill):
        assert drill["after_silence_speed"] == 0.0

    def test_is_refused_in_joint_mode(self, drill):
        assert drill["joint_mode_moved"] == 0.0
        assert "set CARTESIAN" in drill["joint_mode_message"]

    @pytest.mark.parametrize("bad", ["frame", "nan", "infinity"])
    def test_bad_ones_move_nothing_and_are_explained(self, drill, bad):
        assert drill["bad"][bad]["moved"] == 0.0
        said = {"frame": "camera_link", "nan": "nan", "infinity": "inf"}[bad]
        assert said in drill["bad"][bad]["message"]

    def test_e_stop_ends_it_and_latches(self, drill):
        assert drill["e_stop_moved"] < 2e-3
        assert drill["e_stop_held_moved"] == 0.0
        assert drill["e_stop_after_moved"] > 1e-3


@pytest.mark.ros
class TestPose:
    def test_goes_along_a_straight_line_and_arrives(self, drill):
        assert drill["pose"]["left"] < 1e-4
        # at rest on the way, for the fake robot's joints move one after the other; exactly, and at
        # every tick: test_arm_tool_motion.py
        assert 0.2 < drill["pose"]["share"] < 0.8
        assert drill["pose"]["away"] < 2e-3

    def test_runs_at_the_set_speed(self, drill):
        assert drill["pose"]["speed"] == pytest.approx(0.15 * 0.4, rel=0.1)

    def test_stops_when_the_stream_stops(self, drill):
        assert 0.0 < drill["pose"]["stopped_after"] < 0.2

    def test_quaternion_that_is_not_normalised_moves_nothing(self, drill):
        assert drill["bad"]["quaternion"]["moved"] == 0.0
        assert "norm" in drill["bad"]["quaternion"]["message"]


@pytest.mark.ros
class TestModesAndOptions:
    def test_modes(self, drill):
        assert drill["modes"]["CARTESIAN"] == [True, ""]
        assert drill["modes"]["JOINT"] == [True, ""]
        assert drill["modes"]["FLY"][0] is False
        assert drill["status_modes"] == ["JOINT", "CARTESIAN"]

    def test_tool_keeps_its_place_while_the_base_drives(self, drill):
        assert drill["hold"]["answer"] == [True, ""]
        assert drill["hold"]["travelled"] > 0.05
        assert drill["hold"]["off"] < 0.005

    def test_named_pose(self, drill):
        # of the telescope, which rests at its limit: references keep a margin of 0.5 mm to it
        assert drill["named"]["left"] < 5.1e-4
        assert drill["named"]["message"] == "pose 'moon' is unknown; known are " + ", ".join(
            yaml.safe_load((DESCRIPTION / "config" / "poses.yaml").read_text())["poses"]
        )

    def test_what_is_near_stops_the_tool(self, drill):
        assert drill["guard"]["moved"] < 0.01
        assert re.match("stopped: gripper_link is [45] mm from floor", drill["guard"]["notice"])
        assert drill["guard"]["off"] == [True, ""]
        assert drill["guard"]["moved_when_off"] > 0.02

    def test_status_of_the_tool(self, drill):
        status = drill["cartesian_status"]
        assert status["ready"] is True
        assert sorted(status["frames"]) == sorted(FRAMES)
        assert status["off"] < 1e-6


@pytest.mark.ros
class TestServices:
    def test_forward_kinematics(self, drill):
        assert drill["fk"]["off"] < 1e-9
        assert drill["fk"]["frame"] == "base_link"
        assert drill["fk"]["world_off"] < 1e-6

    def test_inverse_kinematics_of_forward_kinematics(self, drill):
        assert drill["ik"]["status"] == "CONVERGED"
        assert drill["ik"]["off"] < 2e-5

    def test_pose_out_of_reach_has_the_nearest_solution(self, drill):
        far = drill["ik_far"]
        assert (far["success"], far["status"], far["count"]) == (False, "BEST_EFFORT", 7)
        assert "out of reach" in far["message"]
        assert far["error"] > 1.0

    @pytest.mark.parametrize(
        ("name", "says"),
        [
            ("fk_joint", "joint 'knee' does not carry the tool; these do: turret_joint"),
            ("fk_link", "no_link"),
            ("fk_frame", "header.frame_id is 'moon'"),
            ("fk_nan", "position of turret_joint is nan"),
            ("ik_quaternion", "norm"),
            ("ik_axis", "free_axis is 'w'"),
            ("ik_tolerance", "position_tolerance is -1.0"),
        ],
    )
    def test_bad_requests_are_refused_with_the_reason(self, drill, name, says):
        assert drill["refusals"][name][0] is False
        assert says in drill["refusals"][name][1]


# ---------------------------------------------------------------- the drill


class World:
    """Publishes where the base is, and what is near, at 50 Hz."""

    def __init__(self, robot, chain):
        import rospy
        from geometry_msgs.msg import PoseStamped
        from telex_msgs.msg import Proximity

        self._robot, self._chain = robot, chain
        self.x = 0.0
        self.speed = 0.0
        self.floor = None  # height in the base's frame (m)
        self._base = rospy.Publisher("sim/base_pose", PoseStamped, queue_size=1)
        self._near = rospy.Publisher("sim/proximity", Proximity, queue_size=1)
        robot.each = self.publish

    def pose(self):
        made = advanced(np.eye(4), np.array([0, 0, 0, 0, 0, YAW]))
        made[:3, 3] = self.x * math.cos(YAW), self.x * math.sin(YAW), 0.2
        return made

    def publish(self, stamp):
        from geometry_msgs.msg import PoseStamped
        from telex_msgs.msg import Proximity, ProximityPair

        from telex_control.ros.pose_messages import fill_pose

        self.x += self.speed * 0.01
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


class Drill:
    def __init__(self, robot, world, chain):
        import rospy
        from geometry_msgs.msg import PoseStamped, TwistStamped
        from std_msgs.msg import Bool, Float64, String
        from std_srvs.srv import SetBool
        from telex_msgs.msg import CartesianTeleopStatus, JointTeleopStatus
        from telex_msgs.srv import ComputeFK, ComputeIK, SetMode

        self.robot, self.world, self.chain = robot, world, chain
        self.twists = rospy.Publisher("arm_teleop/delta_twist_cmds", TwistStamped, queue_size=10)
        self.poses = rospy.Publisher("arm_teleop/pose_cmds", PoseStamped, queue_size=10)
        self.names = rospy.Publisher("arm_teleop/named_pose_cmds", String, queue_size=10)
        self.speed = rospy.Publisher("arm_teleop/speed_scale", Float64, queue_size=10)
        self.e_stop = rospy.Publisher("e_stop", Bool, queue_size=10)
        self.status, self.cartesian = [], []
        rospy.Subscriber("arm_teleop/status", JointTeleopStatus, self.status.append)
        rospy.Subscriber(
            "arm_teleop/cartesian_status", CartesianTeleopStatus, self.cartesian.append
        )
        self.set_mode = rospy.ServiceProxy("arm_teleop/set_mode", SetMode)
        self.hold_tool = rospy.ServiceProxy("arm_teleop/hold_tool", SetBool)
        self.set_guard = rospy.ServiceProxy("arm_teleop/set_proximity_guard", SetBool)
        self.compute_fk = rospy.ServiceProxy("arm_teleop/compute_fk", ComputeFK)
        self.compute_ik = rospy.ServiceProxy("arm_teleop/compute_ik", ComputeIK)
        wait_for(lambda: self.cartesian and self.cartesian[-1].ready, "the kinematics", 60.0)
        wait_for(lambda: self.status[-1].message == "", "arm_teleop to listen")

    @property
    def q(self):
        return [self.robot.positions[joint] for joint in self.chain.joint_names]

    @property
    def tool(self):
        return self.chain.forward(self.q)

    def reset(self):
        """Let the arm stand in its pose ready again, as if somebody had put it there."""
        self.robot.positions.update({joint: READY[joint] for joint in self.chain.joint_names})
        time.sleep(0.3)

    def rest(self):
        """Wait until the joints have stood still for longer than a command lives."""
        history = self.robot.history
        wait_for(lambda: history[-1][1] == history[-30][1], "the arm to come to rest", 10.0)

    def moved(self, act, settle=None):
        """Return how far the tool moves (m, rad) until it rests, or within some time (s)."""
        start = self.tool
        act()
        if settle is None:
            self.rest()
        else:
            time.sleep(settle)
        return float(np.abs(pose_error(self.tool, start)).max())

    def last(self):
        """Return a status that is new, and no older than what was done before."""
        count = len(self.status) + 2
        wait_for(lambda: len(self.status) >= count, "a status")
        return self.status[-1]

    def run(self):
        found = {"modes": {}}
        found["joint_mode_moved"] = self.moved(lambda: repeat(self.twists, twist(), 0.5), 0.0)
        found["joint_mode_message"] = self.last().message
        modes = [self.status[-1].mode]
        for mode in ("FLY", "JOINT", "CARTESIAN"):
            answer = self.set_mode(mode)
            found["modes"][mode] = [answer.success, answer.message]
        modes.append(self.last().mode)
        found["status_modes"] = modes
        found.update(self.measure_twists())
        found["bad"] = self.measure_bad()
        found.update(self.measure_e_stop())
        found["pose"] = self.measure_pose()
        found["hold"] = self.measure_hold()
        found["guard"] = self.measure_guard()
        found["named"] = self.measure_named()
        found.update(self.measure_services())
        self.reset()
        status = self.cartesian[-1]
        found["cartesian_status"] = {
            "ready": status.ready,
            "frames": list(status.frames),
            "off": abs(status.tool.position.x - float(self.tool[0, 3])),
        }
        return found

    def measure_twists(self):
        steps = {}
        for axis, frame in enumerate(FRAMES):
            self.reset()
            steps[frame] = self.step(frame, axis, SPEED)
        self.reset()
        turn = self.step("tool_link", 4, 0.2)
        before = self.tool
        time.sleep(0.2)
        rest = float(np.abs(pose_error(self.tool, before)).max())
        return {"twists": steps, "turn": turn, "after_silence_speed": rest}

    def step(self, frame, axis, rate):
        """Step of the tool along the axes of a frame."""
        start = self.tool
        with Held(self.twists, twist(frame, axis, rate)):
            wait_for(lambda: np.abs(pose_error(self.tool, start)).max() > 0.3 * rate, "motion")
        self.rest()
        step = pose_error(self.tool, start)
        turn = {
            "base_link": np.eye(3),
            "tool_link": start[:3, :3].T,
            "world": self.world.pose()[:3, :3],
        }[frame]
        return [*(turn @ step[:3]).tolist(), *(turn @ step[3:]).tolist()]

    def measure_bad(self):
        bad = {
            "frame": (self.twists, twist("camera_link")),
            "nan": (self.twists, twist(rate=math.nan)),
            "infinity": (self.twists, twist(rate=math.inf)),
        }
        askew = pose_message(self.tool)
        askew.pose.orientation.w += 0.2
        bad["quaternion"] = (self.poses, askew)
        found = {}
        for name, (publisher, message) in bad.items():
            with Held(publisher, message):
                moved = self.moved(lambda: None, 0.1)
                found[name] = {"moved": moved, "message": self.last().message}
        return found

    def measure_e_stop(self):
        from std_msgs.msg import Bool

        self.reset()
        with Held(self.twists, twist(rate=0.5 * SPEED)):
            time.sleep(0.4)
            self.e_stop.publish(Bool(True))
            moved = self.moved(lambda: None, 0.2)
            self.e_stop.publish(Bool(False))
            held = self.moved(lambda: None, 0.4)
        time.sleep(0.4)
        after = self.moved(lambda: repeat(self.twists, twist(), 0.4), 0.0)
        return {"e_stop_moved": moved, "e_stop_held_moved": held, "e_stop_after_moved": after}

    def measure_pose(self):
        from std_msgs.msg import Float64

        self.reset()
        self.speed.publish(Float64(0.4))
        start = self.tool
        goal = advanced(start, np.array([0.08, 0.06, 0.05, 0.0, 0.1, 0.1]))
        begin = len(self.robot.history)
        repeat(self.poses, pose_message(goal), 0.8)
        halfway = self.tool
        self.rest()
        rest = self.tool
        stopped = float(np.linalg.norm(rest[:3, 3] - halfway[:3, 3]))
        history = self.robot.history[begin:]
        with Held(self.poses, pose_message(goal)):
            wait_for(lambda: np.abs(pose_error(self.tool, goal)).max() < 1e-4, "the pose", 6.0)
        line = goal[:3, 3] - start[:3, 3]
        share = float((rest - start)[:3, 3] @ line / (line @ line))
        away = (rest - start)[:3, 3] - share * line
        places = np.array(
            [
                self.chain.forward([each[joint] for joint in self.chain.joint_names])[:3, 3]
                for _, each in history
            ]
        )
        # over a tenth of a second, for references may come late by a joint state
        speeds = np.linalg.norm(places[10:] - places[:-10], axis=1) / 0.1
        self.speed.publish(Float64(1.0))
        return {
            "left": float(np.abs(pose_error(self.tool, goal)).max()),
            "share": share,
            "away": float(np.linalg.norm(away)),
            "speed": float(np.percentile(speeds, 90)),
            "stopped_after": stopped,
        }

    def measure_hold(self):
        self.reset()
        answer = self.hold_tool(True)
        time.sleep(0.2)
        place = (self.world.pose() @ self.tool)[:3, 3]
        begin = self.world.x
        self.world.speed = 0.05
        wait_for(lambda: self.world.x - begin > 0.06, "the base to drive")
        self.world.speed = 0.0
        self.rest()
        off = float(np.linalg.norm((self.world.pose() @ self.tool)[:3, 3] - place))
        travelled = self.world.x - begin
        self.hold_tool(False)
        return {
            "answer": [answer.success, answer.message],
            "off": off,
            "travelled": travelled,
        }

    def measure_guard(self):
        self.reset()
        self.world.floor = float(self.tool[2, 3]) - 0.005
        time.sleep(0.2)
        down = twist("base_link", 2, -SPEED)
        with Held(self.twists, down):
            moved = self.moved(lambda: None, 0.6)
            notice = self.last().notice
        time.sleep(0.4)
        answer = self.set_guard(False)
        low = float(self.tool[2, 3])
        with Held(self.twists, down):
            wait_for(lambda: low - self.tool[2, 3] > 0.03, "the tool to go through the floor")
        moved_when_off = low - float(self.tool[2, 3])
        self.set_guard(True)
        self.world.floor = None
        return {
            "moved": moved,
            "notice": notice,
            "off": [answer.success, answer.message],
            "moved_when_off": moved_when_off,
        }

    def measure_named(self):
        from std_msgs.msg import String

        with Held(self.names, String("moon")):
            message = self.last().message
        with Held(self.names, String("ready")):
            wait_for(lambda: "in pose ready" in self.status[-1].notice, "pose ready", 8.0)
        left = max(abs(self.robot.positions[j] - READY[j]) for j in self.chain.joint_names)
        return {"left": left, "message": message.split(": ", 1)[1]}

    def measure_services(self):
        from telex_msgs.srv import ComputeFKRequest, ComputeIKRequest

        names = list(self.chain.joint_names)
        q = [0.3, -1.0, 0.1, 1.5, 0.4, 0.6, -0.8]
        target = self.chain.forward(q)
        fk = self.compute_fk(joint_names=names, positions=q)
        world = self.compute_fk(frame_id="world", joint_names=names, positions=q)
        ik = self.compute_ik(pose=pose_message(target))
        far = target.copy()
        far[0, 3] += 3.0
        ik_far = self.compute_ik(pose=pose_message(far))
        askew = pose_message(target)
        askew.pose.orientation.w += 0.1
        right = pose_message(target)
        refusals = {
            "fk_joint": self.compute_fk(ComputeFKRequest(joint_names=["knee"], positions=[0.0])),
            "fk_link": self.compute_fk(ComputeFKRequest(link_names=["no_link"])),
            "fk_frame": self.compute_fk(ComputeFKRequest(frame_id="moon")),
            "fk_nan": self.compute_fk(
                ComputeFKRequest(joint_names=names[:1], positions=[math.nan])
            ),
            "ik_quaternion": self.compute_ik(ComputeIKRequest(pose=askew)),
            "ik_axis": self.compute_ik(ComputeIKRequest(pose=right, free_axis="w")),
            "ik_tolerance": self.compute_ik(ComputeIKRequest(pose=right, position_tolerance=-1.0)),
        }
        return {
            "fk": {
                "off": off_by(fk.poses[0], target),
                "frame": fk.poses[0].header.frame_id,
                "world_off": off_by(world.poses[0], self.world.pose() @ target),
            },
            "ik": {
                "status": ik.status,
                "off": float(
                    np.abs(pose_error(self.chain.forward(list(ik.positions)), target)).max()
                ),
            },
            "ik_far": {
                "success": ik_far.success,
                "status": ik_far.status,
                "count": len(ik_far.positions),
                "message": ik_far.message,
                "error": ik_far.position_error,
            },
            "refusals": {
                name: [answer.success, answer.message] for name, answer in refusals.items()
            },
        }


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


def play():
    import rospy

    script = DESCRIPTION / "scripts" / "robot_description"
    urdf = subprocess.run(
        [sys.executable, str(script)], capture_output=True, text=True, check=True
    ).stdout
    rospy.set_param("/use_sim_time", True)
    miss_nothing()
    rospy.init_node("drill", disable_signals=True)
    rospy.set_param("robot_description", urdf)
    for file in (PACKAGE / "config" / "arm_teleop.yaml", DESCRIPTION / "config" / "poses.yaml"):
        for name, value in yaml.safe_load(file.read_text()).items():
            rospy.set_param(f"arm_teleop/{name}", value)
    joints = rospy.get_param("arm_teleop/joints")
    robot = FakeRobot(joints)
    robot.positions.update({joint: READY[joint] for joint in joints})
    chain = Chain.from_urdf(urdf, "base_link", "tool_link")
    world = World(robot, chain)
    node = Node("arm_teleop")
    try:
        found = Drill(robot, world, chain).run()
    finally:
        node.end()
        robot.end()
    print(json.dumps(found))


if __name__ == "__main__":
    play()
