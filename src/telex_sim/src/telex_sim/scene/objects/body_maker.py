"""Bodies of PyBullet, made of what an object was planned to consist of."""

from __future__ import annotations

from typing import Dict, Hashable, List, Optional, Sequence, Tuple

import pybullet

from telex_control.common.geometry.quaternions import Pose, compose

from ..model import Form, Motion
from .assembly import BodyPlan, Segment, SegmentShape

_SLEEP_THRESHOLD = 1e-5
"""Sum of the squared speeds (m2/s2, rad2/s2) below which a body falls asleep after 2 s. PyBullet's
own stops things that creep with centimetres per second."""
_JOINT_TYPES = {Motion.HINGE: pybullet.JOINT_REVOLUTE, Motion.SLIDE: pybullet.JOINT_PRISMATIC}
_GEOMETRY = {
    Form.BOX: pybullet.GEOM_BOX,
    Form.SPHERE: pybullet.GEOM_SPHERE,
    Form.CYLINDER: pybullet.GEOM_CYLINDER,
}


class MeshLists:
    """Vertices and indices of meshes as PyBullet wants them, each mesh once.

    PyBullet keeps the lists that it is given for ever, over a reset of its world and the end of a
    client: new ones for every load would grow without end.
    """

    def __init__(self) -> None:
        self._lists: Dict[Hashable, Tuple[List[Tuple[float, ...]], List[int]]] = {}

    def of(self, shape: SegmentShape, key: Hashable) -> Tuple[List[Tuple[float, ...]], List[int]]:
        """Return vertices and indices, the same objects whenever they are asked for."""
        if key not in self._lists:
            assert shape.vertices is not None
            indices = [] if shape.triangles is None else shape.triangles.reshape(-1).tolist()
            # Tuples: unlike lists of numbers, they cost the garbage collector nothing in the end.
            self._lists[key] = (list(zip(*shape.vertices.T.tolist())), indices)
        return self._lists[key]


class BodyMaker:
    """Makes bodies, each shape once.

    PyBullet never lets go of a shape that a body has had: a scene where the same things come and go
    would grow without end.

    Parameters
    ----------
    client : int
        PyBullet's.
    meshes : MeshLists, optional
        Those of other worlds of this program.
    """

    def __init__(self, client: int, meshes: Optional[MeshLists] = None) -> None:
        self._client = client
        # By what they are made of.
        self._shapes: Dict[Hashable, int] = {}
        self._meshes = meshes or MeshLists()

    def forget(self) -> None:
        """Forget all shapes: the world is empty again."""
        self._shapes.clear()

    def make(self, plan: BodyPlan, origin: Pose) -> int:
        """Make a body; returns its number. PyBullet may refuse it with an error of its own."""
        shapes = [self._shape(segment.shapes) for segment in plan.segments]
        base, *links = plan.segments
        position, orientation = compose(origin, base.pose)
        uid = pybullet.createMultiBody(
            base.mass,
            shapes[0],
            -1,
            basePosition=position,
            baseOrientation=orientation,
            baseInertialFramePosition=base.center,
            baseInertialFrameOrientation=base.axes,
            linkMasses=[link.mass for link in links],
            linkCollisionShapeIndices=list(shapes[1:]),
            linkVisualShapeIndices=[-1] * len(links),
            linkPositions=[link.pose[0] for link in links],
            linkOrientations=[link.pose[1] for link in links],
            linkInertialFramePositions=[link.center for link in links],
            linkInertialFrameOrientations=[link.axes for link in links],
            # PyBullet counts from the base, which is 0 here and -1 everywhere else.
            linkParentIndices=[link.parent for link in links],
            linkJointTypes=[_joint_type(link) for link in links],
            linkJointAxis=[link.joint.axis if link.joint else (0.0, 0.0, 1.0) for link in links],
            physicsClientId=self._client,
        )
        for index, link in enumerate(links):
            if link.joint is not None:
                pybullet.resetJointState(uid, index, link.joint.start, physicsClientId=self._client)
        return uid

    def _shape(self, shapes: Sequence[SegmentShape]) -> int:
        """PyBullet's shape for all shapes of a segment; -1 for none."""
        if not shapes:
            return -1
        key = tuple(shape.key() for shape in shapes)
        if key not in self._shapes:
            self._shapes[key] = self._create_shape(shapes, key)
        return self._shapes[key]

    def _create_shape(self, shapes: Sequence[SegmentShape], key: Hashable) -> int:
        client = self._client
        first = shapes[0]
        if first.vertices is not None:
            vertices, indices = self._meshes.of(first, key)
            exact: Dict[str, object] = {}
            if first.triangles is not None:
                exact["indices"] = indices
                exact["flags"] = pybullet.GEOM_FORCE_CONCAVE_TRIMESH
            return pybullet.createCollisionShape(
                pybullet.GEOM_MESH,
                vertices=vertices,
                collisionFramePosition=first.pose[0],
                collisionFrameOrientation=first.pose[1],
                physicsClientId=client,
                **exact,
            )
        return pybullet.createCollisionShapeArray(
            shapeTypes=[_GEOMETRY[shape.form] for shape in shapes],
            halfExtents=[[edge / 2.0 for edge in shape.size] for shape in shapes],
            radii=[shape.size[0] for shape in shapes],
            lengths=[shape.size[2] for shape in shapes],
            collisionFramePositions=[shape.pose[0] for shape in shapes],
            collisionFrameOrientations=[shape.pose[1] for shape in shapes],
            physicsClientId=client,
        )

    def set_dynamics(self, uid: int, plan: BodyPlan) -> None:
        """Give a body that was made its inertia, friction, limits of joints and sleep."""
        client = self._client
        for index, segment in enumerate(plan.segments, -1):
            pybullet.changeDynamics(
                uid,
                index,
                lateralFriction=segment.friction,
                rollingFriction=segment.rolling_friction,
                spinningFriction=segment.rolling_friction,
                linearDamping=0.0,
                angularDamping=0.0,
                jointDamping=0.0,
                physicsClientId=client,
            )
            if segment.mass > 0.0:
                pybullet.changeDynamics(
                    uid, index, localInertiaDiagonal=segment.moments, physicsClientId=client
                )
            if segment.joint is not None:
                pybullet.changeDynamics(
                    uid,
                    index,
                    jointLowerLimit=segment.joint.lower,
                    jointUpperLimit=segment.joint.upper,
                    physicsClientId=client,
                )
        if not plan.static or plan.inertias:
            pybullet.changeDynamics(
                uid,
                -1,
                activationState=pybullet.ACTIVATION_STATE_ENABLE_SLEEPING,
                sleepThreshold=_SLEEP_THRESHOLD,
                physicsClientId=client,
            )


def _joint_type(segment: Segment) -> int:
    if segment.joint is None:
        return pybullet.JOINT_FIXED
    return _JOINT_TYPES[segment.joint.motion]
