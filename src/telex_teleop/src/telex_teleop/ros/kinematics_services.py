"""Services of arm_teleop: forward and inverse kinematics for external tools."""

from __future__ import annotations

import math
import threading
from dataclasses import replace
from typing import Any, Dict, List, Optional, Sequence

import numpy as np
import rospy
from geometry_msgs.msg import PoseStamped
from telex_msgs.srv import ComputeFK, ComputeFKResponse, ComputeIK, ComputeIKResponse

from telex_control.common.geometry.matrices import inverse
from telex_control.common.plausible import LARGEST_POSITION
from telex_control.kinematics import Chain, IKSolver, KinematicsError, Tolerance
from telex_control.kinematics.inverse.options import SMALLEST_TOLERANCE
from telex_control.ros.pose_messages import fill_pose, pose_in
from telex_teleop.arm.arm_settings import FrameSettings
from telex_teleop.arm.tool_command import Frame
from telex_teleop.motion.joint_jog import InvalidCommand, require_number, require_once
from telex_teleop.ros.arm_teleop_node import ArmTeleopNode

NO_ARM = "this robot has no arm from {base} to {tool} that arm_teleop could move"


class KinematicsServices:
    """``~compute_fk`` and ``~compute_ik``.

    A solver of its own, for the one that leads the tool is busy a hundred times a second.

    Parameters
    ----------
    node
        Tells where joints and base are.
    chain
        From base to tool; None where the robot has no such arm.
    """

    def __init__(self, node: ArmTeleopNode, chain: Optional[Chain], frames: FrameSettings) -> None:
        self._node = node
        self._chain = chain
        self._frames = frames
        self._lock = threading.Lock()
        self._solver = None if chain is None else IKSolver(chain)
        if self._solver is not None:
            threading.Thread(
                target=self._warm_up, args=(self._solver,), name="kinematics services", daemon=True
            ).start()
        self._services = [
            rospy.Service("~compute_fk", ComputeFK, self._compute_fk),
            rospy.Service("~compute_ik", ComputeIK, self._compute_ik),
        ]

    def _warm_up(self, solver: IKSolver) -> None:
        """Prepare for the first question, which waits where it comes earlier."""
        with self._lock:
            solver.warm_up()

    def _compute_fk(self, request: Any) -> ComputeFKResponse:
        try:
            chain = self._present_chain()
            given = given_positions(
                "joint_names", request.joint_names, request.positions, chain.joint_names
            )
            positions = self._joint_positions(chain, given)
            frame = request.frame_id or self._frames.base
            to_frame = inverse(self._frame_in_base(chain, frame, positions))
            links: List[str] = list(request.link_names) or [self._frames.tool]
            answer = ComputeFKResponse(success=True, link_names=links)
            for link in links:
                pose = PoseStamped()
                pose.header.stamp = rospy.Time.now()
                pose.header.frame_id = frame
                fill_pose(pose.pose, to_frame @ chain.forward(positions.tolist(), link))
                answer.poses.append(pose)
        except (InvalidCommand, KinematicsError) as error:
            return ComputeFKResponse(success=False, message=str(error))
        return answer

    def _compute_ik(self, request: Any) -> ComputeIKResponse:
        try:
            chain = self._present_chain()
            assert self._solver is not None
            pose = request.pose.pose
            command = self._node.frames.pose(request.pose.header.frame_id, *pose_in(pose))
            given = given_positions(
                "seed_names", request.seed_names, request.seed, chain.joint_names
            )
            seed = self._joint_positions(chain, given)
            frame = request.pose.header.frame_id or self._node.frames.default
            target = self._frame_in_base(chain, frame, seed) @ command.pose
            tolerance = _tolerance(request)
            with self._lock:
                result = self._solver.solve(
                    target, np.clip(seed, chain.lower, chain.upper).tolist(), tolerance
                )
        except (InvalidCommand, KinematicsError) as error:
            return ComputeIKResponse(success=False, message=str(error))
        answer = ComputeIKResponse(
            success=result.converged,
            status=result.status.name,
            position_error=result.position_error,
            orientation_error=result.orientation_error,
        )
        if not result.converged:
            answer.message = (
                f"out of reach: the nearest that was found is "
                f"{1000.0 * result.position_error:.3g} mm and "
                f"{math.degrees(result.orientation_error):.3g} deg off"
            )
        answer.joint_names = list(chain.joint_names)
        answer.positions = result.q.tolist()
        return answer

    def _present_chain(self) -> Chain:
        if self._chain is None:
            frames = self._frames
            raise InvalidCommand(NO_ARM.format(base=frames.base, tool=frames.tool))
        return self._chain

    def _joint_positions(self, chain: Chain, given: Dict[str, float]) -> np.ndarray:
        """Return the positions of the chain's joints: those given, else the measured ones."""
        measured = self._node.positions()
        if measured is None:
            missing = [joint for joint in chain.joint_names if joint not in given]
            if missing:
                raise InvalidCommand(f"no position of {', '.join(missing)}: no joint_states yet")
            measured = np.zeros(len(chain.joint_names))
        return np.array(
            [given.get(joint, here) for joint, here in zip(chain.joint_names, measured.tolist())]
        )

    def _frame_in_base(self, chain: Chain, frame_id: str, positions: np.ndarray) -> np.ndarray:
        frame = self._node.frames.find(frame_id)
        if frame is Frame.BASE:
            return np.eye(4)
        if frame is Frame.TOOL:
            return chain.forward(positions.tolist())
        base = self._node.base_pose()
        if base is None:
            raise InvalidCommand("header.frame_id: the pose of the base in the world is not known")
        return inverse(base)


def given_positions(
    field: str, names: Sequence[str], values: Sequence[float], carriers: Sequence[str]
) -> Dict[str, float]:
    """Check joint positions that come with a request.

    Parameters
    ----------
    field : str
        Which one holds the names.
    carriers
        Joints that carry the tool.

    Returns
    -------
    dict
        Joint to position (rad or m).

    Raises
    ------
    InvalidCommand
    """
    if len(values) != len(names):
        raise InvalidCommand(f"{len(values)} positions for {len(names)} joint names")
    for name, value in zip(names, values):
        if name not in carriers:
            raise InvalidCommand(
                f"joint {name!r} does not carry the tool; these do: {', '.join(carriers)}"
            )
        require_number(f"position of {name}", value, LARGEST_POSITION)
    require_once(field, names)
    return dict(zip(names, values))


def _tolerance(request: Any) -> Tolerance:
    for name in ("position_tolerance", "orientation_tolerance"):
        value = getattr(request, name)
        if value != 0.0 and not SMALLEST_TOLERANCE <= value < math.inf:
            raise InvalidCommand(
                f"{name} is {value!r}; must be at least {SMALLEST_TOLERANCE:g},"
                " or 0 for the usual one"
            )
    if request.free_axis not in ("", "x", "y", "z"):
        raise InvalidCommand(f"free_axis is {request.free_axis!r}; must be x, y, z or empty")
    if request.position_only and request.free_axis:
        raise InvalidCommand("position_only leaves all axes free; give it or free_axis")
    tolerance = Tolerance()
    if request.position_only:
        tolerance = Tolerance.position_only()
    elif request.free_axis:
        tolerance = Tolerance.free_roll(request.free_axis)
    return replace(
        tolerance,
        position=request.position_tolerance or tolerance.position,
        rotation=request.orientation_tolerance or tolerance.rotation,
    )
