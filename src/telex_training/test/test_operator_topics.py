"""An operator's port by topics: what messages tell, and which messages commands become."""

from __future__ import annotations

import math

import numpy as np
import pytest
import rospy
from control_msgs.msg import JointJog
from geometry_msgs.msg import PoseStamped, Twist, TwistStamped
from sensor_msgs.msg import CameraInfo, CompressedImage, JointState
from std_msgs.msg import String
from telex_msgs.msg import (
    FlipperPresetHold,
    GripperContact,
    JointTeleopStatus,
    SceneDescription,
    ScenePoses,
    TrackTeleopStatus,
)

from telex_control.ros.local_node_handle import LocalNodeHandle
from telex_training.operators.handling import aimed
from telex_training.operators.port import (
    Drive,
    FlipperPreset,
    Grip,
    Jog,
    JointTargets,
    NamedPose,
    Notice,
    Observation,
    Placement,
    ToolPose,
    ToolTwist,
)
from telex_training.ros.camera import CameraTopics
from telex_training.ros.commands import message_of
from telex_training.ros.object_poses import ObjectPoses
from telex_training.ros.observer import Observer


@pytest.fixture
def node() -> LocalNodeHandle:
    return LocalNodeHandle()


def publish_robot(node: LocalNodeHandle, joints_at: float, base_at: float) -> None:
    joints = JointState(name=["a_joint", "b_joint"], position=[0.1, 0.2], velocity=[1.0, 2.0])
    joints.header.stamp = rospy.Time.from_sec(joints_at)
    node.advertise("joint_states", JointState).publish(joints)
    base = PoseStamped()
    base.header.stamp = rospy.Time.from_sec(base_at)
    base.pose.position.x, base.pose.orientation.w = 3.0, 1.0
    node.advertise("sim/base_pose", PoseStamped).publish(base)


class TestObserver:
    def test_nothing_is_known_at_first(self, node: LocalNodeHandle) -> None:
        assert Observer(node).observation() == Observation()

    def test_joints_and_base_are_seen_at_the_older_time(self, node: LocalNodeHandle) -> None:
        observer = Observer(node)
        publish_robot(node, 4.02, 4.0)
        seen = observer.observation()
        assert seen.time == observer.time == 4.0
        assert seen.positions == {"a_joint": 0.1, "b_joint": 0.2}
        assert seen.velocities == {"a_joint": 1.0, "b_joint": 2.0}
        assert seen.base == Placement((3.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))

    def test_nodes_and_gripper_are_heard(self, node: LocalNodeHandle) -> None:
        observer = Observer(node)
        arm = node.advertise("arm_teleop/status", JointTeleopStatus)
        arm.publish(JointTeleopStatus(notice="in pose ready"))
        arm.publish(JointTeleopStatus(message="the e-stop is active", notice="in pose ready"))
        tracks = node.advertise("track_teleop/status", TrackTeleopStatus)
        tracks.publish(TrackTeleopStatus())
        contact = node.advertise("sim/gripper_contact", GripperContact)
        contact.publish(GripperContact(object="case", force=40.0))
        seen = observer.observation()
        assert seen.notices == {
            "arm_teleop": Notice(2, "the e-stop is active"),
            "track_teleop": Notice(1, ""),
        }
        assert seen.grip == Grip("case", 40.0)


class TestCommands:
    def test_keys_become_messages_of_the_nodes(self) -> None:
        topic, twist = message_of(Drive(0.5, -0.2))
        assert (topic, type(twist)) == ("track_teleop/cmd_vel", Twist)
        assert (twist.linear.x, twist.angular.z) == (0.5, -0.2)
        topic, jog = message_of(Jog("gripper_teleop", {"gripper": -0.1}))
        assert topic == "gripper_teleop/delta_joint_cmds"
        assert jog == JointJog(joint_names=["gripper"], velocities=[-0.1])
        assert message_of(FlipperPreset("climb")) == (
            "flipper_teleop/preset_cmds",
            FlipperPresetHold(preset="climb"),
        )
        assert message_of(NamedPose("ready")) == ("arm_teleop/named_pose_cmds", String("ready"))

    def test_the_tool_is_led_in_a_frame(self) -> None:
        topic, pose = message_of(ToolPose(aimed(0.9, 0.1, 0.4, yaw=0.5 * math.pi), "world"))
        assert (topic, pose.header.frame_id) == ("arm_teleop/pose_cmds", "world")
        assert (pose.pose.position.x, pose.pose.position.z) == (0.9, 0.4)
        assert abs(pose.pose.orientation.z) == pytest.approx(math.sqrt(0.5))
        topic, twist = message_of(ToolTwist(linear=(0.1, 0.0, -0.1)))
        assert (topic, type(twist)) == ("arm_teleop/delta_twist_cmds", TwistStamped)
        assert (twist.header.frame_id, twist.twist.linear.z) == ("tool_link", -0.1)

    def test_references_are_for_controllers_alone(self) -> None:
        with pytest.raises(TypeError, match="JointTargets"):
            message_of(JointTargets({"a_joint": 0.1}))


class TestSights:
    def test_objects_are_where_scene_and_poses_agree(self, node: LocalNodeHandle) -> None:
        objects = ObjectPoses(node)
        scene = node.advertise("sim/scene", SceneDescription)
        poses = node.advertise("sim/poses", ScenePoses)
        numbers = [float(number) for number in range(14)]
        numbers[10:] = [0.0, 0.0, 0.0, 1.0]
        poses.publish(ScenePoses(revision=2, poses=numbers))
        assert not objects.known
        scene.publish(SceneDescription(revision=2, frames=["robot/base", "case/body"]))
        assert objects.known
        found = objects.find("case")
        assert found is not None
        assert found[:3, 3].tolist() == [7.0, 8.0, 9.0]
        assert objects.find("cas") is None
        scene.publish(SceneDescription(revision=3, frames=["robot/base"]))
        assert not objects.known
        assert objects.find("case") is None

    def test_a_picture_comes_with_its_camera(self, node: LocalNodeHandle) -> None:
        view = CameraTopics(node)
        picture = CompressedImage(data=b"jpeg")
        picture.header.stamp = rospy.Time.from_sec(2.5)
        node.advertise("image_raw/compressed", CompressedImage).publish(picture)
        assert view.picture() is None
        info = CameraInfo(K=[float(number) for number in range(9)], D=[0.1] * 5)
        node.advertise("camera_info", CameraInfo).publish(info)
        seen = view.picture()
        assert seen is not None
        assert (seen.time, seen.data) == (2.5, b"jpeg")
        assert np.array_equal(seen.matrix, np.arange(9.0).reshape(3, 3))
        view.close()
