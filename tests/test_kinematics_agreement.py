"""One robot, four accounts of where its tool is: Denavit-Hartenberg, KDL, PyBullet and tf.

Run as a program (`python test_kinematics_agreement.py POSITIONS.npy POSES.npy`) this file moves
robot_state_publisher through positions and notes the poses that tf gives; it has a process of its
own because rospy can be initialised only once per process.
"""

from __future__ import annotations

import importlib.util
import math
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pybullet
import pytest
import rospkg
import rospy
from pybullet_utils.bullet_client import BulletClient
from sensor_msgs.msg import JointState
from tf2_msgs.msg import TFMessage
from tf2_py import BufferCore

from telex_control.kinematics import Chain, UrdfTree, dh_chain
from telex_control.ros.rospy_fixes.connecting import miss_nothing
from telex_control.urdf.joints import joints, parse_urdf
from telex_experiments.rigs.private_master import PrivateMaster
from telex_sim.offline.simulation import robot_description

pytestmark = pytest.mark.waiting

BASE, TOOL = "base_link", "tool_link"
POSES = 1000
EXACT = 1e-9  # m, rad
PYBULLET = 1e-6
ARM = (
    "turret_joint",
    "shoulder_joint",
    "telescope_joint",
    "elbow_joint",
    "forearm_roll_joint",
    "wrist_pitch_joint",
    "gripper_roll_joint",
)
# joint: alpha (deg) and a (m) of the link before it, theta (deg) and d (m) at position 0
TABLE = {
    "turret_joint": (0, 0.0, 0, 0.325),
    "shoulder_joint": (-90, 0.040, -90, -0.088),
    "telescope_joint": (-90, 0.0, 0, 0.500),
    "elbow_joint": (90, 0.0, 0, 0.088),
    "forearm_roll_joint": (-90, 0.0, 0, 0.460),
    "wrist_pitch_joint": (90, 0.0, 0, 0.0),
    "gripper_roll_joint": (-90, 0.0, 0, 0.295),
}


@pytest.fixture(scope="module")
def urdf():
    return robot_description()


@pytest.fixture(scope="module")
def chain(urdf):
    return Chain(parse_urdf(urdf), BASE, TOOL)


@pytest.fixture(scope="module")
def positions(chain):
    generator = np.random.default_rng(3)
    lower = [joint.lower for joint in chain.joints]
    upper = [joint.upper for joint in chain.joints]
    return generator.uniform(lower, upper, (POSES, len(lower)))


@pytest.fixture(scope="module")
def product(chain, positions):
    """Poses by the product of the Denavit-Hartenberg transforms."""
    parameters = dh_chain(chain)
    return np.array([parameters.forward(each) for each in positions])


def assert_agree(poses, others, tolerance):
    """Compare places, and orientations by the angle between them."""
    assert poses.shape == others.shape
    assert np.linalg.norm(poses[:, :3, 3] - others[:, :3, 3], axis=1).max() < tolerance
    # the distance of two rotation matrices is sqrt(8) sin(angle / 2)
    apart = np.linalg.norm(poses[:, :3, :3] - others[:, :3, :3], axis=(1, 2))
    assert (2.0 * np.arcsin(apart / math.sqrt(8.0))).max() < tolerance


def test_the_arm_has_the_documented_parameters(chain):
    rows = dh_chain(chain).rows
    assert [row.joint for row in rows] == list(TABLE)
    for row in rows:
        alpha, a, theta, d = TABLE[row.joint]
        figures = (math.degrees(row.alpha), row.a, math.degrees(row.theta), row.d)
        assert figures == pytest.approx((alpha, a, theta, d), abs=1e-9), row.joint
        assert row.prismatic == (row.joint == "telescope_joint")


def test_kdl_agrees(chain, positions, product):
    assert_agree(product, np.array([chain.forward(each) for each in positions]), EXACT)


def test_pybullet_agrees(urdf, positions, product, tmp_path):
    package = rospkg.RosPack().get_path("telex_description")
    file = tmp_path / "telex.urdf"
    file.write_text(urdf.replace("package://telex_description", package), encoding="utf-8")
    bullet = BulletClient(pybullet.DIRECT)
    try:
        body = bullet.loadURDF(str(file))
        infos = [bullet.getJointInfo(body, i) for i in range(bullet.getNumJoints(body))]
        indices = {info[1].decode(): info[0] for info in infos}
        links = {info[12].decode(): info[0] for info in infos}
        # PyBullet places the base by its centre of mass.
        inertial = bullet.getDynamicsInfo(body, -1)[3:5]
        bullet.resetBasePositionAndOrientation(body, *inertial)
        found = []
        for each in positions:
            for name, position in zip(ARM, each):
                bullet.resetJointState(body, indices[name], position)
            state = bullet.getLinkState(body, links[TOOL], computeForwardKinematics=True)
            pose = np.eye(4)
            pose[:3, :3] = np.reshape(bullet.getMatrixFromQuaternion(state[5]), (3, 3))
            pose[:3, 3] = state[4]
            found.append(pose)
    finally:
        bullet.disconnect()
    assert_agree(product, np.array(found), PYBULLET)


def test_the_drawing_is_that_of_the_model(chain):
    docs = Path(__file__).parents[1] / "docs"
    spec = importlib.util.spec_from_file_location("draw_kinematics", docs / "draw_kinematics.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    drawn = module.draw(chain, dh_chain(chain))
    committed = (docs / "images" / "kinematics.svg").read_text(encoding="utf-8")
    assert drawn == committed, "run python docs/draw_kinematics.py --png"


def test_the_documented_joints_are_those_of_the_model(urdf):
    robot = parse_urdf(urdf)
    limits, above = joints(robot), {j.name: j for j in UrdfTree(robot).joint_above.values()}
    page = (Path(__file__).parents[1] / "docs" / "engineer" / "kinematics.md").read_text(
        encoding="utf-8"
    )
    rows = [line.split("|")[1:-1] for line in page.splitlines() if "_joint` |" in line]
    assert len(rows) == 15
    for cells in rows:
        name, parent, origin, axis, lower, upper, *figures = (cell.strip(" `") for cell in cells)
        joint, tree = limits[name], above[name]
        assert tree.parent == parent
        assert [float(word) for word in origin.split()] == pytest.approx(tree.origin.xyz, abs=5e-4)
        sign = -1.0 if axis.startswith("-") else 1.0
        assert tree.axis == pytest.approx([sign * (letter == axis[-1]) for letter in "xyz"])
        for text, limit in ((lower, joint.lower), (upper, joint.upper)):
            if text.endswith("°"):
                assert float(text[:-1]) == pytest.approx(math.degrees(limit), abs=0.06), name
            elif text:
                assert float(text.split()[0]) == limit
            else:
                assert math.isinf(limit)
        described = (joint.velocity, joint.effort, joint.friction, joint.damping)
        assert tuple(map(float, figures)) == described, name


@pytest.mark.ros
def test_tf_agrees(urdf, positions, product, tmp_path):
    asked, answered = tmp_path / "positions.npy", tmp_path / "poses.npy"
    np.save(asked, positions)
    description = tmp_path / "telex.urdf"
    description.write_text(urdf, encoding="utf-8")
    with PrivateMaster() as master:
        environment = master.environment()
        subprocess.run(
            ["rosparam", "set", "-t", str(description), "robot_description"],
            env=environment,
            check=True,
            timeout=30.0,
        )
        publisher = subprocess.Popen(
            ["rosrun", "robot_state_publisher", "robot_state_publisher"], env=environment
        )
        try:
            subprocess.run(
                [sys.executable, __file__, str(asked), str(answered)],
                env=environment,
                check=True,
                timeout=600.0,  # walk() says sooner which pose does not come
            )
        finally:
            publisher.terminate()
            publisher.wait(10.0)
    assert_agree(product, np.load(answered), EXACT)


# ---------------------------------------------------------------- the program


def walk(positions):
    """Publish joint states one by one, each after tf has the frames of the one before."""
    buffer = BufferCore(rospy.Duration(2.0 * POSES))
    fixed, moved = threading.Event(), threading.Event()
    stamp = rospy.Time(0)

    def on_fixed(message):
        for transform in message.transforms:
            buffer.set_transform_static(transform, "tf")
        fixed.set()

    def on_moved(message):
        for transform in message.transforms:
            buffer.set_transform(transform, "tf")
        if message.transforms[0].header.stamp == stamp:
            moved.set()

    miss_nothing()
    rospy.init_node("walk", disable_signals=True)
    rospy.Subscriber("/tf_static", TFMessage, on_fixed)
    rospy.Subscriber("/tf", TFMessage, on_moved, tcp_nodelay=True)
    states = rospy.Publisher("joint_states", JointState, queue_size=1, tcp_nodelay=True)
    assert fixed.wait(60.0), "no /tf_static"
    found = []
    for index, each in enumerate(positions):
        moved.clear()
        stamp = rospy.Time(index + 1)
        message = JointState(name=list(ARM), position=list(each))
        message.header.stamp = stamp
        for _ in range(200):
            # again and again, for its subscriber may come late
            states.publish(message)
            if moved.wait(0.1):
                break
        assert moved.is_set(), f"no /tf of pose {index}"
        found.append(pose_of(buffer.lookup_transform_core(BASE, TOOL, stamp).transform))
    return np.array(found)


def pose_of(transform):
    x, y, z, w = (getattr(transform.rotation, axis) for axis in "xyzw")
    place = transform.translation
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), place.x],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w), place.y],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y), place.z],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )


if __name__ == "__main__":
    np.save(sys.argv[2], walk(np.load(sys.argv[1])))
