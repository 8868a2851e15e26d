"""Efforts that hold a robot's joints against gravity, computed with KDL from the URDF.

One `GravityModel` serves all controllers of a robot: the first that asks has it computed, the
others read.
"""

from __future__ import annotations

import math
import weakref
from typing import Any, Dict, List, NamedTuple, Optional, Sequence, Set, Tuple, TypeVar

import PyKDL

from ..common.stateful import Stateful
from ..hardware.hardware_interface import (
    HardwareInterface,
    ImuSensorHandle,
    ImuSensorInterface,
    JointStateHandle,
    JointStateInterface,
    NamedHandle,
    RobotHW,
)
from ..kinematics import KinematicsError, UrdfTree, kdl_tree
from ..ros.node_handle import NodeHandle
from ..urdf.joints import MOVABLE, UrdfError, parse_urdf

GRAVITY = 9.81
"""Acceleration of gravity (m/s^2)."""
TURN = 1e-2
"""Change of gravity's direction in the root frame (m/s^2) that is taken up; less is a thousandth of
the efforts, and a new direction doubles the cost of a cycle."""

HOLD = 0.01
"""Time (s) for which efforts are held. At its full speed, a joint's effort changes by a few
thousandths of its limit meanwhile; computing it in every cycle of 2 ms would double the cost of
a cycle of the arm's controllers."""

Handle = TypeVar("Handle", bound=NamedHandle)


class GravityError(ValueError):
    """Gravity cannot be compensated; the message says why."""


class _Path(NamedTuple):
    """A chain from the root out to a last moving joint, one segment a moving joint.

    Paths of one robot share joints near the root. Each body has its inertia in one of them only,
    so that the efforts of all paths add up to those of the tree.
    """

    chain: PyKDL.Chain
    states: Tuple[Optional[JointStateHandle], ...]
    outputs: Tuple[Tuple[int, str], ...]  # index in the chain, joint


class _Solvers:
    """KDL's solvers for some paths, and the arrays between them and here."""

    def __init__(self, paths: Tuple[_Path, ...], gravity: PyKDL.Vector) -> None:
        self.paths = paths
        self._positions = [PyKDL.JntArray(len(path.states)) for path in paths]
        self._results = [PyKDL.JntArray(len(path.states)) for path in paths]
        self._joints = [name for path in paths for _, name in path.outputs]
        self.turn(gravity)

    def turn(self, gravity: PyKDL.Vector) -> None:
        """Take another direction of gravity, which KDL does only when a solver is made."""
        self._solvers = [PyKDL.ChainDynParam(path.chain, gravity) for path in self.paths]

    def solve(self) -> Dict[str, float]:
        """Return the efforts at the measured positions, by joint."""
        efforts = dict.fromkeys(self._joints, 0.0)
        for path, solver, positions, result in zip(
            self.paths, self._solvers, self._positions, self._results
        ):
            for index, state in enumerate(path.states):
                if state is not None:
                    positions[index] = state.position
            solver.JntToGravity(positions, result)
            for index, name in path.outputs:
                efforts[name] += result[index]
        return efforts


class JointGravity(Stateful):
    """The gravity effort of one joint."""

    __slots__ = ("_model", "_name")
    SAVED_PARTS = ("_model",)

    def __init__(self, model: GravityModel, name: str) -> None:
        self._model = model
        self._name = name

    def effort(self, time: float) -> float:
        """Return the effort (Nm, N) that holds the joint at `time` (s); at most `HOLD` old."""
        return self._model.efforts(time)[self._name]


class GravityModel(Stateful):
    """Gravity efforts of the joints of one robot.

    Parameters
    ----------
    states : dict of str to JointStateHandle
        Measured joints; others are taken to be at 0.
    imus : sequence of ImuSensorHandle
        The first that is fixed to the root link tells how the robot stands. Without one, or while
        it measures no orientation, the robot is taken to stand level.

    Raises
    ------
    GravityError
        The URDF cannot be used.
    """

    SAVED = ("_efforts", "_gravity", "_orientation")
    SAVED_TIMES = ("_until",)

    def __init__(
        self,
        urdf: str,
        states: Dict[str, JointStateHandle],
        imus: Sequence[ImuSensorHandle] = (),
    ) -> None:
        try:
            self._tree = UrdfTree(parse_urdf(urdf))
        except (KinematicsError, UrdfError) as error:
            raise GravityError(f"gravity compensation: {error}") from error
        self._kdl = kdl_tree(self._tree)
        self._links = {joint.name: joint.child for joint in self._tree.joints()}
        self._moving = {each.name for each in self._tree.joints() if each.kind in MOVABLE}
        self._states = states
        self._imu, self._root_from_imu = self._fixed_imu(imus)
        self._orientation: Optional[Tuple[float, ...]] = None
        self._gravity = PyKDL.Vector(0.0, 0.0, -GRAVITY)
        self._wanted: Set[str] = set()
        # Replaced as a whole when a controller is loaded; the loop reads it once a cycle.
        self._paths: Tuple[_Path, ...] = ()
        self._solvers = _Solvers((), self._gravity)
        self._until = -math.inf  # the efforts are as of `HOLD` before
        self._efforts: Dict[str, float] = {}

    def joint(self, name: str) -> JointGravity:
        """Return the gravity effort of the joint `name`. Not in the control loop.

        Raises
        ------
        GravityError
            The robot has no such joint.
        """
        if name not in self._moving:
            raise GravityError(f"gravity compensation: the robot has no movable joint '{name}'")
        self._wanted.add(name)
        self._paths = self._decompose()
        return JointGravity(self, name)

    def efforts(self, time: float) -> Dict[str, float]:
        """Return the efforts (Nm, N) at `time` (s), by joint; at most `HOLD` old."""
        paths = self._paths
        if self._until - HOLD <= time < self._until and paths is self._solvers.paths:
            return self._efforts
        turned = self._read_orientation()
        if paths is not self._solvers.paths:
            self._solvers = _Solvers(paths, self._gravity)
        elif turned:
            self._solvers.turn(self._gravity)
        # Half a microsecond less: sums of periods are not exact.
        self._until = time + HOLD - 5e-7
        self._efforts = self._solvers.solve()
        return self._efforts

    def restore_state(self, saved: Any, elapsed: float) -> None:
        """Take a state up again; see `Stateful.restore_state`."""
        before = self._gravity
        super().restore_state(saved, elapsed)
        if self._gravity != before:
            self._solvers.turn(self._gravity)

    def _read_orientation(self) -> bool:
        """Turn gravity into the root frame; tell whether its direction has changed."""
        orientation = None if self._imu is None else self._imu.orientation
        if orientation is None or orientation == self._orientation:
            return False
        self._orientation = orientation
        world_from_imu = PyKDL.Rotation.Quaternion(*orientation)
        down = PyKDL.Vector(0.0, 0.0, -GRAVITY)
        exact = self._root_from_imu * (world_from_imu.Inverse() * down)
        # On a grid, not by what has changed: the same orientation gives the same efforts always.
        gravity = PyKDL.Vector(*(round(each / TURN) * TURN for each in exact))
        if gravity == self._gravity:
            return False
        self._gravity = gravity
        return True

    def _fixed_imu(
        self, imus: Sequence[ImuSensorHandle]
    ) -> Tuple[Optional[ImuSensorHandle], PyKDL.Rotation]:
        for imu in imus:
            if imu.frame_id not in self._tree.inertials:
                continue
            rotation = PyKDL.Rotation()
            segments = self._segments(imu.frame_id)
            if any(segment.getJoint().getName() in self._moving for segment in segments):
                continue
            for segment in segments:
                rotation = rotation * segment.pose(0.0).M
            return imu, rotation
        return None, PyKDL.Rotation()

    def _segments(self, link: str) -> List[PyKDL.Segment]:
        if link == self._tree.root:
            return []
        chain = self._kdl.getChain(self._tree.root, link)
        return [chain.getSegment(index) for index in range(chain.getNrOfSegments())]

    def _decompose(self) -> Tuple[_Path, ...]:
        """Cover all bodies that the wanted joints carry by paths from the root."""
        bodies = self._bodies()
        above: Dict[str, List[str]] = {}
        for joint, link in self._links.items():
            if joint in self._moving:
                names = [each.name for each in self._tree.path(self._tree.root, link)]
                above[joint] = [name for name in names if name in self._moving]
        carrying = {name for path in above.values() for name in path[:-1]}
        ends = sorted(set(above) - carrying, key=lambda joint: (-len(above[joint]), joint))
        return tuple(
            self._path(joint, bodies) for joint in ends if self._wanted.intersection(above[joint])
        )

    def _bodies(self) -> Dict[str, PyKDL.RigidBodyInertia]:
        """Return, by moving joint, the inertia of all that is rigidly fixed to its child link.

        In the frame of the child link. One segment a joint makes solving three times as fast as
        one a link.
        """
        bodies: Dict[str, PyKDL.RigidBodyInertia] = {}
        for link in self._tree.inertials:
            carrier = None
            frame = PyKDL.Frame()
            inertia = PyKDL.RigidBodyInertia()
            for segment in self._segments(link):
                name = segment.getJoint().getName()
                if name in self._moving:
                    carrier, frame = name, PyKDL.Frame()
                else:
                    frame = frame * segment.pose(0.0)
                inertia = segment.getInertia()
            if carrier is not None:
                bodies[carrier] = bodies.get(carrier, PyKDL.RigidBodyInertia()) + frame * inertia
        return bodies

    def _path(self, last: str, bodies: Dict[str, PyKDL.RigidBodyInertia]) -> _Path:
        """Make the path out to the joint `last`, and take its bodies out of `bodies`."""
        chain = PyKDL.Chain()
        names = []
        offset = PyKDL.Frame()  # from the last moving link to the present one
        for segment in self._segments(self._links[last]):
            joint = segment.getJoint()
            name = joint.getName()
            frame = offset * segment.pose(0.0)
            if name not in self._moving:
                offset = frame
                continue
            placed = PyKDL.Joint(
                name, offset * joint.JointOrigin(), offset.M * joint.JointAxis(), joint.getType()
            )
            inertia = bodies.pop(name, PyKDL.RigidBodyInertia())
            chain.addSegment(PyKDL.Segment(segment.getName(), placed, frame, inertia))
            names.append(name)
            offset = PyKDL.Frame()
        return _Path(
            chain,
            tuple(self._states.get(name) for name in names),
            tuple((index, name) for index, name in enumerate(names) if name in self._wanted),
        )


_models: weakref.WeakKeyDictionary[RobotHW, Tuple[str, GravityModel]] = weakref.WeakKeyDictionary()


def gravity_of(hw: RobotHW, root: NodeHandle) -> GravityModel:
    """Return the gravity model of a robot, the same for all of its controllers.

    Parameters
    ----------
    hw : RobotHW
        Its joint states and inertial sensors.
    root : NodeHandle
        The robot's namespace, for ``robot_description``.

    Raises
    ------
    GravityError, ConfigError
    """
    urdf = root.param("robot_description", str)
    known = _models.get(hw)
    if known is not None and known[0] == urdf:
        return known[1]
    imus: List[ImuSensorHandle] = []
    for interface in hw.interfaces():
        if isinstance(interface, ImuSensorInterface):
            imus = _handles(interface)
    model = GravityModel(urdf, joint_states(hw), imus)
    _models[hw] = (urdf, model)
    return model


def joint_states(hw: RobotHW) -> Dict[str, JointStateHandle]:
    """Return the measured joints of a robot by name.

    Looked through without `RobotHW.get`, which would count them among what the controller uses.
    """
    for interface in hw.interfaces():
        if isinstance(interface, JointStateInterface):
            return {handle.name: handle for handle in _handles(interface)}
    return {}


def _handles(interface: HardwareInterface[Handle]) -> List[Handle]:
    return [interface.get_handle(name) for name in interface.names()]
