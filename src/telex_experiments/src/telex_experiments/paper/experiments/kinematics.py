"""Figure 3 and section 3.1: the arm's frames, and four accounts of where its tool is."""

from __future__ import annotations

import importlib.util
import math
import tempfile
from pathlib import Path
from types import ModuleType
from typing import Dict, List, Set, Tuple

import numpy as np
import pybullet
import rospy
from pybullet_utils.bullet_client import BulletClient
from sensor_msgs.msg import JointState
from telex_msgs.msg import ScenePoses
from telex_msgs.srv import ComputeFK
from tf2_msgs.msg import TFMessage
from tf2_py import BufferCore

from telex_control.common.file_catalog import package_path
from telex_control.common.geometry.matrices import inverse, pose_matrices
from telex_control.kinematics import Chain, DHChain, dh_chain, make_pose
from telex_control.ros.pose_messages import pose_in, quaternion_in, vector_in
from telex_control.urdf.joints import parse_urdf

from ...rigs.chromium import BrowserError, Chromium
from ...workspace import ROOT
from ..driving import Jogger
from ..experiment import Experiment, Figure, ReportPicture, ReportTable, Result
from ..recorder import FEW_PICTURES
from ..session import PaperSession

BASE, TOOL = "base_link", "tool_link"
EXACT, SINGLE = 1e-9, 1e-6
"""m and rad; PyBullet tells places in single precision."""
DRAWING = ROOT / "docs" / "draw_kinematics.py"

Apart = Tuple[float, float]
"""Distance (m) and angle (rad)."""


def farthest(poses: np.ndarray, others: np.ndarray) -> Apart:
    """Return the largest distance (m) and angle (rad) between poses, both of shape (n, 4, 4)."""
    places = np.linalg.norm(poses[:, :3, 3] - others[:, :3, 3], axis=1)
    # The Frobenius distance of two rotation matrices is sqrt(8) sin(angle / 2).
    turns = np.linalg.norm(poses[:, :3, :3] - others[:, :3, :3], axis=(1, 2))
    angles = 2.0 * np.arcsin(np.minimum(turns / math.sqrt(8.0), 1.0))
    return float(places.max()), float(angles.max())


def by_service(session: PaperSession, chain: Chain, positions: np.ndarray) -> np.ndarray:
    """Poses of the tool by KDL, as the running ``arm_teleop/compute_fk`` answers."""
    service = rospy.ServiceProxy(
        f"{session.namespace}/arm_teleop/compute_fk", ComputeFK, persistent=True
    )
    service.wait_for_service(20.0)
    poses = []
    for each in positions:
        answer = service(BASE, [TOOL], list(chain.joint_names), list(each))
        if not answer.success:
            raise RuntimeError(f"compute_fk: {answer.message}")
        poses.append(make_pose(*pose_in(answer.poses[0].pose)))
    service.close()
    return np.array(poses)


def by_pybullet(urdf: str, chain: Chain, positions: np.ndarray) -> np.ndarray:
    """Poses of the tool by PyBullet, from the robot description of the running system."""
    package = package_path("telex_description")
    bullet = BulletClient(pybullet.DIRECT)
    try:
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "robot.urdf"
            file.write_text(urdf.replace("package://telex_description", package), encoding="utf-8")
            body = bullet.loadURDF(str(file))
        infos = [bullet.getJointInfo(body, index) for index in range(bullet.getNumJoints(body))]
        indices = {info[1].decode(): info[0] for info in infos}
        tool = next(info[0] for info in infos if info[12].decode() == TOOL)
        # PyBullet places a base by its centre of mass.
        bullet.resetBasePositionAndOrientation(body, *bullet.getDynamicsInfo(body, -1)[3:5])
        poses = []
        for each in positions:
            for name, position in zip(chain.joint_names, each):
                bullet.resetJointState(body, indices[name], position)
            state = bullet.getLinkState(body, tool, computeForwardKinematics=True)
            poses.append(make_pose(state[4], state[5]))
        return np.array(poses)
    finally:
        bullet.disconnect()


class _Watch:
    """Notes joint states, frames and true poses of the running robot, by their stamps."""

    def __init__(self, namespace: str, chain: Chain) -> None:
        self._names = chain.joint_names
        # The frame that the arm's last joint moves.
        self._last = next(joint.child for joint in chain.path[::-1] if joint.kind != "fixed")
        self.positions: Dict[int, np.ndarray] = {}
        self.truth: Dict[int, List[float]] = {}
        self.told: Set[int] = set()
        self.tree = BufferCore(rospy.Duration(600.0))
        subscribe = rospy.Subscriber
        self._subscribers = [
            subscribe(f"{namespace}/joint_states", JointState, self._on_joint_states),
            subscribe(f"{namespace}/sim/poses", ScenePoses, self._on_poses),
            subscribe("/tf_static", TFMessage, self._on_frames, True),
            subscribe("/tf", TFMessage, self._on_frames, False),
        ]

    def close(self) -> None:
        for subscriber in self._subscribers:
            subscriber.unregister()

    def _on_joint_states(self, message: JointState) -> None:
        measured = dict(zip(message.name, message.position))
        self.positions[message.header.stamp.to_nsec()] = np.array(
            [measured[name] for name in self._names]
        )

    def _on_poses(self, message: ScenePoses) -> None:
        self.truth[message.header.stamp.to_nsec()] = message.poses

    def _on_frames(self, message: TFMessage, static: bool) -> None:
        for transform in message.transforms:
            if static:
                self.tree.set_transform_static(transform, "paper")
            else:
                self.tree.set_transform(transform, "paper")
                if transform.child_frame_id == self._last:
                    self.told.add(transform.header.stamp.to_nsec())


def while_moving(
    session: PaperSession, chain: Chain, parameters: DHChain
) -> Tuple[Tuple[Apart, int], Tuple[Apart, int]]:
    """Move the arm; compare the DH product of the joint states with /tf and with the physics.

    Returns
    -------
    two pairs of Apart and int
        Of /tf and of ``sim/poses``: the largest differences, and of how many moments.
    """
    description = session.scene()
    base, tool = (description.frames.index(f"telex/{link}") for link in (BASE, TOOL))
    watch = _Watch(session.namespace, chain)
    jogger = Jogger(session.namespace)
    signs = session.rng("moving").choice((-1.0, 1.0), len(chain.joint_names))
    for sign in (1.0, -1.0):
        speeds = {
            joint.name: float(sign * way * 0.4 * joint.velocity)
            for joint, way in zip(chain.joints, signs)
        }
        jogger.move(speeds, 3.0)
    watch.close()
    frames, product, truth, same = [], [], [], []
    for stamp, positions in sorted(watch.positions.items()):
        by_rows = parameters.forward(positions)
        # Between its messages tf interpolates, which is no kinematics.
        if stamp in watch.told:
            found = watch.tree.lookup_transform_core(BASE, TOOL, rospy.Time(0, stamp)).transform
            place, turn = vector_in(found.translation), quaternion_in(found.rotation)
            frames.append(make_pose(place, turn))
            product.append(by_rows)
        if stamp in watch.truth:
            flat = np.array(watch.truth[stamp]).reshape(-1, 7)
            of_base, of_tool = pose_matrices(flat[[base, tool]])
            truth.append(inverse(of_base) @ of_tool)
            same.append(by_rows)
    if not frames or not truth:
        raise RuntimeError("no frames, or no true poses, at the stamps of joint states")
    return (
        (farthest(np.array(frames), np.array(product)), len(frames)),
        (farthest(np.array(truth), np.array(same)), len(truth)),
    )


def _drawing_tool() -> ModuleType:
    spec = importlib.util.spec_from_file_location("draw_kinematics", DRAWING)
    if spec is None or spec.loader is None:
        raise RuntimeError(f"{DRAWING} cannot be read")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def _agreement(name: str, apart: Apart, bar: float) -> List[Figure]:
    return [
        Figure(f"{name}: place", apart[0], "m", at_most=bar),
        Figure(f"{name}: orientation", apart[1], "rad", at_most=bar),
    ]


def run(session: PaperSession) -> Result:
    """Draw the arm, list its parameters, compare the accounts of where its tool is."""
    count = 200 if session.quick else 1000
    with session.simulator(console=False, pose="ready"):
        urdf = rospy.get_param(f"{session.namespace}/robot_description")
        chain = Chain(parse_urdf(urdf), BASE, TOOL)
        parameters = dh_chain(chain)
        lower = [joint.lower for joint in chain.joints]
        upper = [joint.upper for joint in chain.joints]
        positions = session.rng("positions").uniform(lower, upper, (count, len(lower)))
        product = np.array([parameters.forward(each) for each in positions])
        session.say(f"asking compute_fk for {count} configurations")
        kdl = farthest(product, by_service(session, chain, positions))
        session.say("moving the arm, and comparing /tf and the physics with the joint states")
        with session.record("moving", cameras=("front",), rate=FEW_PICTURES):
            (frames, moments), (truth, instants) = while_moving(session, chain, parameters)
    bullet = farthest(product, by_pybullet(urdf, chain, positions))
    drawing = session.folder / "kinematics.svg"
    drawing.write_text(_drawing_tool().draw(chain, parameters), encoding="utf-8")
    notes = [
        "The drawing and the table are derived from the robot description that the running system "
        "holds, not copied from a file.",
        "KDL's poses are the answers of the running service arm_teleop/compute_fk. PyBullet's are "
        "of the same robot description in a client of its own, because a simulated arm cannot "
        "stand in a thousand random configurations, most of which pass through the robot or the "
        "floor. The physics of the running simulator is compared while the arm moves: sim/poses "
        "against the product at the joint states of the same instant.",
    ]
    try:
        with Chromium(drawing.as_uri(), size=_drawing_tool().SIZE, exact=True) as browser:
            drawing.with_suffix(".png").write_bytes(browser.screenshot())
    except BrowserError as error:
        notes.append(f"No PNG of the drawing: {error}")
    rows = [
        [
            index,
            row.joint,
            math.degrees(row.alpha),
            row.a,
            row.d,
            math.degrees(row.theta),
            "d" if row.prismatic else "theta",
        ]
        for index, row in enumerate(parameters.rows, start=1)
    ]
    head = ("i", "joint", "alpha(i-1) deg", "a(i-1) m", "d(i) m", "theta(i) deg", "variable")
    return Result(
        figures=[
            Figure("configurations", count, ""),
            *_agreement("DH and KDL", kdl, EXACT),
            *_agreement("DH and PyBullet", bullet, SINGLE),
            *_agreement("DH and /tf, arm moving", frames, EXACT),
            Figure("moments compared with /tf", moments, ""),
            *_agreement("DH and the running physics, arm moving", truth, SINGLE),
            Figure("moments compared with the physics", instants, ""),
        ],
        pictures=[
            ReportPicture(
                "The arm's joints, frames and Denavit-Hartenberg parameters.",
                drawing.name,
                "As the paper's figure 3; all joints stand at 0.",
            )
        ],
        tables=[ReportTable("Denavit-Hartenberg parameters (modified)", "dh.csv", head, rows)],
        notes=notes,
    )


EXPERIMENTS = (
    Experiment(
        name="fig3_kinematics",
        paper="Figure 3, section 3.1",
        title="The arm's kinematics",
        claim="The arm was sketched accurately with all of its joints and frames. The "
        "Denavit-Hartenberg convention gave the transform of each link, their product that from "
        "the base to the end-effector; KDL computes it in real time.",
        method="The frames are drawn and the parameters derived from the running system's robot "
        "description. For random configurations within the limits, the product of the "
        "Denavit-Hartenberg transforms is compared with KDL and PyBullet, and, while the arm "
        "moves, with /tf and with the physics.",
        bar="1e-9 m and rad between DH, KDL and /tf; 1e-6 with PyBullet",
        run=run,
        seconds=30.0,
        quick_seconds=25.0,
        groups=("fig3",),
    ),
)
