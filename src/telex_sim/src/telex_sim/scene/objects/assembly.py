"""From an object's description to the bodies that PyBullet can make of it.

All that takes time or can fail happens here, without PyBullet, so that it can be done beside the
simulation's loop; `telex_sim.scene.objects.bodies` then only creates what an `Assembly` lists.

PyBullet keeps at most 16 shapes of a body's link and silently drops the rest, so a link of more is
split over several that are fixed to it, each with its share of the mass. A latch does not become a
joint of a body: what it holds is a body of its own.
"""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass, replace
from typing import Dict, Hashable, List, Optional, Sequence, Tuple

import numpy as np

from telex_control.common.geometry.matrices import rotation_matrix
from telex_control.common.geometry.quaternions import IDENTITY, Pose, about, compose, rotate
from telex_control.common.params import ConfigError, require

from ..assets import Assets
from ..meshes import mass_properties
from ..meshes.mass_properties import MassProperties
from ..model import Form, Joint, Link, Motion, ObjectModel, Part, Quaternion, SceneObject, Vector3

MOST_SHAPES = 16
"""PyBullet's MAX_COMPOUND_COLLISION_SHAPES."""
MOST_AT_ONCE = 4096
"""Triangles of a static mesh that become one body: PyBullet reads a million in a second."""
_MOST_SEGMENTS = 127
_STIFFEST = 0.25
_LEAST_INERTIA = 1.0e-9
"""kg m2, kg; less cannot be told from nothing."""
_FARTHEST = 0.05
"""rad, m that a closer's preload may move its joint within one step."""


@dataclass(frozen=True)
class SegmentShape:
    """One collision shape of a segment.

    Attributes
    ----------
    size : tuple of 3 floats
        As in `Geometry`; unused for a mesh.
    vertices : numpy.ndarray, optional
        Of a mesh, shape (V, 3) (m).
    triangles : numpy.ndarray, optional
        Of a mesh that collides exactly, shape (T, 3); without them its convex hull does.
    digest : bytes
        Tells meshes apart.
    """

    form: Form
    size: Vector3
    pose: Pose
    vertices: Optional[np.ndarray] = None
    triangles: Optional[np.ndarray] = None

    digest: bytes = b""

    def key(self) -> Hashable:
        """Something that is equal for equal shapes."""
        return (self.form, self.size, self.pose, self.digest)


@dataclass(frozen=True)
class Segment:
    """A link of a PyBullet body: a link of the object, or a share of one.

    Attributes
    ----------
    link : str
        Name of the object's link; empty for further shares of one.
    parent : int
        Index of the segment that it hangs on; -1 for the body's first.
    pose : Pose
        Of its frame in the parent's, with the joint at 0; of the first in the object's frame.
    joint : Joint, optional
        HINGE or SLIDE; None where it is fixed to its parent.
    mass : float
        kg; 0 where it is static.
    center : tuple of 3 floats
        Centre of mass in its frame.
    moments, axes : tuple of float
        Principal moments of inertia (kg m2), and their orientation in its frame.
    """

    link: str
    parent: int
    pose: Pose
    joint: Optional[Joint]
    shapes: Tuple[SegmentShape, ...]
    mass: float
    center: Vector3
    moments: Vector3
    axes: Quaternion
    friction: float
    rolling_friction: float


@dataclass(frozen=True)
class BodyPlan:
    """What becomes one body of PyBullet.

    Attributes
    ----------
    segments : tuple of Segment
        Parents before children; the first is the base.
    static : bool
        Whether the base stands fast.
    inertias : dict of str to float
        Of each joint, by its name: what moves with it (kg m2, kg), less where the rest of the body
        can give way.
    """

    segments: Tuple[Segment, ...]
    static: bool
    inertias: Dict[str, float]

    def moving_segments(self) -> List[int]:
        """Indices of the segments that can move."""
        moving: List[int] = []
        for index, segment in enumerate(self.segments):
            base = index == 0 and not self.static
            if base or segment.joint is not None or segment.parent in moving:
                moving.append(index)
        return moving

    def segment_of(self, link: str) -> int:
        """Index of the segment that carries a link's frame; -1 where it is not in this body."""
        for index, segment in enumerate(self.segments):
            if segment.link == link:
                return index
        return -1


@dataclass(frozen=True)
class LatchPlan:
    """A latch between two bodies of an assembly, by their indices.

    Attributes
    ----------
    parent_shares : tuple of int
        Further bodies of a parent that stands fast.
    """

    joint: Joint
    parent_body: int
    parent_segment: int
    child_body: int
    parent_shares: Tuple[int, ...]


@dataclass(frozen=True)
class Assembly:
    """All bodies of one object; the first carries its root."""

    source: SceneObject
    bodies: Tuple[BodyPlan, ...]
    latches: Tuple[LatchPlan, ...]


def assemble(item: SceneObject, assets: Assets, step_size: float) -> Assembly:
    """Plan the bodies of an object.

    Parameters
    ----------
    step_size : float
        Of the physics (s): it bounds how stiff a closer can be.

    Raises
    ------
    ConfigError
        A mesh or a texture cannot be used, there are too many shapes, or a closer is too stiff.
    """
    model = item.model
    for link in model.links:
        for part in link.parts:
            if part.surface is not None:
                assets.check_texture(part.surface.texture)
            if part.geometry.form is Form.MESH:
                assets.surface(part.geometry.mesh, part.geometry.size)
    joints = {joint.child: joint for joint in model.joints}
    poses = _start_poses(model)
    roots = [model.links[0].name]
    roots += [joint.child for joint in model.joints if joint.motion is Motion.LATCH]
    groups = {root: _links_of(root, model) for root in roots}
    bodies: List[BodyPlan] = []
    home: Dict[str, int] = {}
    for root, links in groups.items():
        static = model.static and root == roots[0]
        for plan in _plan_bodies(links, static, poses[root], joints, assets):
            home.update({s.link: len(bodies) for s in plan.segments if s.link})
            bodies.append(plan)
    # Only what stands fast without joints, the root, consists of several.
    shares = tuple(number for number, plan in enumerate(bodies) if not plan.segments[0].link)
    latches = tuple(
        LatchPlan(
            joint,
            home[joint.parent],
            bodies[home[joint.parent]].segment_of(joint.parent),
            home[joint.child],
            shares if home[joint.parent] == 0 else (),
        )
        for joint in model.joints
        if joint.motion is Motion.LATCH
    )
    for plan in bodies:
        _check_closers(plan, step_size)
    return Assembly(item, tuple(bodies), latches)


def joint_pose(joint: Joint, position: float) -> Pose:
    """Pose of a joint's child in its parent, with the joint at `position` (rad, m)."""
    if joint.motion is Motion.HINGE:
        moved: Pose = ((0.0, 0.0, 0.0), about(joint.axis, position))
    else:
        x, y, z = joint.axis
        moved = ((x * position, y * position, z * position), (0.0, 0.0, 0.0, 1.0))
    return compose((joint.position, joint.orientation), moved)


def _start_poses(model: ObjectModel) -> Dict[str, Pose]:
    """Pose of every link in the object's frame, with all joints where they start."""
    poses: Dict[str, Pose] = {model.links[0].name: IDENTITY}
    waiting = list(model.joints)
    while waiting:
        joint = waiting.pop(0)
        if joint.parent not in poses:
            waiting.append(joint)
            continue
        start = 0.0 if joint.motion is Motion.LATCH else joint.start
        poses[joint.child] = compose(poses[joint.parent], joint_pose(joint, start))
    return poses


def _links_of(root: str, model: ObjectModel) -> List[Link]:
    """The links that hang on `root` by hinges and slides, parents before children."""
    links = {link.name: link for link in model.links}
    found = [root]
    for name in found:
        found += [
            joint.child
            for joint in model.joints
            if joint.parent == name and joint.motion is not Motion.LATCH
        ]
    return [links[name] for name in found]


def _plan_bodies(
    links: Sequence[Link], static: bool, pose: Pose, joints: Dict[str, Joint], assets: Assets
) -> List[BodyPlan]:
    """One body; of something static without joints several, which cost less than fixed links."""
    root = links[0]
    if static and len(links) == 1:
        shares = _tiled(_shares(root, True, assets)) or [((), None)]
        return [
            BodyPlan((_segment(root, bool(i), -1, pose, None, share, True),), True, {})
            for i, share in enumerate(shares)
        ]
    segments: List[Segment] = []
    of_link: Dict[str, int] = {}
    for link in links:
        fast = static and link is root
        joint = None if link is root else joints[link.name]
        parent = -1 if joint is None else of_link[joint.parent]
        frame = pose if joint is None else (joint.position, joint.orientation)
        shares = _shares(link, fast, assets) or [((), None)]
        of_link[link.name] = own = len(segments)
        segments.append(_segment(link, False, parent, frame, joint, shares[0], fast))
        segments += [_segment(link, True, own, IDENTITY, None, share, fast) for share in shares[1:]]
    require(
        len(segments) <= _MOST_SEGMENTS,
        f"it has too many solid parts: {_MOST_SEGMENTS} groups of a mesh or {MOST_SHAPES} "
        f"primitives are possible, {len(segments)} are needed",
    )
    return [BodyPlan(tuple(segments), static, _inertias(segments, static))]


_Share = Tuple[Tuple[SegmentShape, ...], Optional[MassProperties]]


def _shares(link: Link, static: bool, assets: Assets) -> List[_Share]:
    """The solid parts of a link in portions that PyBullet takes, each with its share of mass."""
    primitives: List[Tuple[SegmentShape, Optional[MassProperties]]] = []
    portions: List[List[Tuple[SegmentShape, Optional[MassProperties]]]] = []
    for part in link.parts:
        if not part.solid:
            continue
        shaped = _shape(part, static, assets)
        if part.geometry.form is Form.MESH:
            portions.append([shaped])
        else:
            primitives.append(shaped)
    portions = [
        primitives[begin : begin + MOST_SHAPES] for begin in range(0, len(primitives), MOST_SHAPES)
    ] + portions
    volume = sum(props.mass for portion in portions for _, props in portion if props)
    shares: List[_Share] = []
    for portion in portions:
        shapes = tuple(shape for shape, _ in portion)
        solids = [props for _, props in portion if props]
        if static:
            shares.append((shapes, None))
            continue
        whole = mass_properties.combined(solids)
        shares.append((shapes, whole.scaled(link.mass * whole.mass / volume)))
    return shares


def _tiled(shares: List[_Share]) -> List[_Share]:
    """Make several shares of each mesh that PyBullet takes long to read: one at a time can come."""
    tiled: List[_Share] = []
    for shapes, props in shares:
        first = shapes[0]
        if first.triangles is None or len(first.triangles) <= MOST_AT_ONCE:
            tiled.append((shapes, props))
            continue
        assert first.vertices is not None
        for part in _tiles(first.vertices, first.triangles):
            used, triangles = np.unique(part, return_inverse=True)
            vertices, triangles = first.vertices[used], triangles.reshape(-1, 3)
            digest = _digest(vertices, triangles)
            tile = replace(first, vertices=vertices, triangles=triangles, digest=digest)
            tiled.append(((tile,), props))
    return tiled


def _tiles(vertices: np.ndarray, triangles: np.ndarray) -> List[np.ndarray]:
    """Halve triangles across their longest extent until each part has few."""
    if len(triangles) <= MOST_AT_ONCE:
        return [triangles]
    centers = vertices[triangles].mean(axis=1)
    order = np.argsort(centers[:, np.argmax(np.ptp(centers, axis=0))], kind="stable")
    half = len(order) // 2
    return [
        tile for part in (order[:half], order[half:]) for tile in _tiles(vertices, triangles[part])
    ]


def _shape(
    part: Part, static: bool, assets: Assets
) -> Tuple[SegmentShape, Optional[MassProperties]]:
    geometry, pose = part.geometry, (part.position, part.orientation)
    if geometry.form is Form.MESH and static:
        vertices, triangles = assets.surface(geometry.mesh, geometry.size)
        digest = _digest(vertices, triangles)
        return SegmentShape(geometry.form, geometry.size, pose, vertices, triangles, digest), None
    if geometry.form is Form.MESH:
        hull = assets.hull(geometry.mesh, geometry.size)
        vertices = np.unique(hull.reshape(-1, 3), axis=0)
        solid = mass_properties.closed_surface(hull)
        shape = SegmentShape(geometry.form, geometry.size, pose, vertices, None, _digest(vertices))
        return shape, solid.placed(pose)
    if geometry.form is Form.BOX:
        solid = mass_properties.box(geometry.size)
    elif geometry.form is Form.SPHERE:
        solid = mass_properties.sphere(geometry.size[0])
    else:
        solid = mass_properties.cylinder(geometry.size[0], geometry.size[2])
    return SegmentShape(geometry.form, geometry.size, pose), solid.placed(pose)


def _digest(*arrays: np.ndarray) -> bytes:
    digest = hashlib.sha256()
    for array in arrays:
        digest.update(np.ascontiguousarray(array).data)
    return digest.digest()


def _segment(
    link: Link,
    further: bool,
    parent: int,
    pose: Pose,
    joint: Optional[Joint],
    share: _Share,
    static: bool,
) -> Segment:
    shapes, props = share
    center: Vector3 = (0.0, 0.0, 0.0)
    moments: Vector3 = (0.0, 0.0, 0.0)
    axes: Quaternion = (0.0, 0.0, 0.0, 1.0)
    mass = 0.0
    if props is not None and not static:
        mass = props.mass
        center = (float(props.center[0]), float(props.center[1]), float(props.center[2]))
        moments, axes = props.principal()
    return Segment(
        "" if further else link.name,
        parent,
        pose,
        joint,
        shapes,
        mass,
        center,
        moments,
        axes,
        link.friction,
        link.rolling_friction,
    )


def _inertias(segments: Sequence[Segment], static: bool) -> Dict[str, float]:
    """Inertia that each joint moves, with all joints where they start."""
    frames: List[Pose] = []
    bodies: List[Optional[MassProperties]] = []
    for segment in segments:
        joint = segment.joint
        pose = joint_pose(joint, joint.start) if joint else segment.pose
        frames.append(pose if segment.parent < 0 else compose(frames[segment.parent], pose))
        bodies.append(_properties(segment, frames[-1]))
    inertias: Dict[str, float] = {}
    for index, segment in enumerate(segments):
        if segment.joint is None:
            continue
        outside = {index}
        for number in range(index + 1, len(segments)):
            if segments[number].parent in outside:
                outside.add(number)
        axis = np.array(rotate(frames[index][1], segment.joint.axis))
        point = np.array(frames[index][0])
        moved = [body for number, body in enumerate(bodies) if body and number in outside]
        rest = [body for number, body in enumerate(bodies) if body and number not in outside]
        inertia = _about(segment.joint, moved, point, axis)
        if not static and rest:
            other = _about(segment.joint, rest, mass_properties.combined(rest).center, axis)
            inertia = inertia * other / (inertia + other)
        inertias[segment.joint.name] = inertia
    return inertias


def _properties(segment: Segment, frame: Pose) -> Optional[MassProperties]:
    if segment.mass <= 0.0:
        return None
    turn = rotation_matrix(segment.axes)
    inertia = turn @ np.diag(segment.moments) @ turn.T
    return MassProperties(segment.mass, np.array(segment.center), inertia).placed(frame)


def _about(
    joint: Joint, bodies: Sequence[MassProperties], point: np.ndarray, axis: np.ndarray
) -> float:
    if joint.motion is Motion.SLIDE:
        return sum(body.mass for body in bodies)
    return sum(body.about_axis(point, axis) for body in bodies)


def _check_closers(plan: BodyPlan, step_size: float) -> None:
    """Refuse a spring that would swing within few steps: it cannot be simulated."""
    for segment in plan.segments:
        joint = segment.joint
        if joint is None or joint.motion is Motion.LATCH:
            continue
        inertia = plan.inertias.get(joint.name, 0.0)
        if not _LEAST_INERTIA <= inertia < math.inf:
            raise ConfigError(
                f"joint '{joint.name}': the inertia of what it moves is {inertia:.3g} (kg m2, kg); "
                f"at least {_LEAST_INERTIA:g} can be simulated"
            )
        if joint.closer is None:
            continue
        strongest = _FARTHEST * inertia / step_size**2
        if joint.closer.preload > strongest:
            raise ConfigError(
                f"joint '{joint.name}': closer/preload is {joint.closer.preload:g}; for what it "
                f"moves, at most {strongest:.3g} can be simulated"
            )
        stiffest = _STIFFEST * plan.inertias[joint.name] / step_size**2
        if joint.closer.stiffness > stiffest:
            raise ConfigError(
                f"joint '{joint.name}': closer/stiffness is {joint.closer.stiffness:g}; for what "
                f"it moves, at most {stiffest:.3g} can be simulated"
            )
