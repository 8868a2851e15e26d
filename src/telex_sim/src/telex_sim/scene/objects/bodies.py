"""The objects of a scene as PyBullet bodies.

Only the thread that owns the PyBullet client may use what is here.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Callable, Dict, Iterator, List, NamedTuple, Optional, Sequence, Tuple

import pybullet

from telex_control.common.geometry.quaternions import Pose, compose, invert
from telex_control.common.params import ConfigError

from ...engine.overlaps import DEEPEST, MOST_NAMED, overlaps
from ..model import MOST_OBJECTS, Floor, SceneObject
from .assembly import Assembly
from .body_maker import BodyMaker, MeshLists
from .latches import Latch, wake
from .mechanisms import Mechanism

_TOUCH = 1e-3
"""Depth (m) to which a new object may be in the robot."""

Progress = Callable[[int, int], None]
"""Told how many objects of how many are in the world."""


@dataclass(frozen=True)
class _Placed:
    """An object in the world.

    Attributes
    ----------
    bodies : tuple of int
        PyBullet's, in the order of the assembly.
    tracked : tuple
        Links whose poses are told: body, link index and the inverse of the inertial frame.
    """

    assembly: Assembly
    bodies: Tuple[int, ...]
    mechanisms: Tuple[Mechanism, ...]
    latches: Tuple[Latch, ...]
    tracked: Tuple[Tuple[int, int, Pose], ...]
    movable: Tuple[int, ...]


class FreeBody(NamedTuple):
    """A body that no joint leads: ``<object>/<link>``, its number, and its link's inertial frame.

    `from_inertial` is the link's frame in the frame that PyBullet places the body by.
    """

    name: str
    uid: int
    from_inertial: Pose


class SceneJoint(NamedTuple):
    """A hinge or slide of an object: ``<object>/<joint>``, and PyBullet's body and joint."""

    name: str
    uid: int
    joint: int


class SceneLatch(NamedTuple):
    """A latch of an object: ``<object>/<joint>``."""

    name: str
    latch: Latch


class SceneBodies:
    """Whatever stands around the robots.

    Parameters
    ----------
    client : int
        PyBullet's.
    step_size : float
        Time between calls of `apply` (s).
    meshes : MeshLists, optional
        Those of other worlds of this program.
    """

    def __init__(self, client: int, step_size: float, meshes: Optional[MeshLists] = None) -> None:
        self._client = client
        self._step_size = step_size
        self._placed: Dict[str, _Placed] = {}
        self._ground = (-1, "")
        self._active: List[Mechanism] = []
        self._latches: List[Latch] = []
        self._maker = BodyMaker(client, meshes)

    def objects(self) -> List[SceneObject]:
        """All objects, in the order in which they came; may be called from any thread."""
        return [placed.assembly.source for placed in list(self._placed.values())]

    def names(self) -> List[str]:
        """Names that are taken: of all objects, and of entries; may be called from any thread."""
        objects = self.objects()
        return list(dict.fromkeys(name for item in objects for name in (item.name, item.entry)))

    def assemblies(self) -> List[Assembly]:
        """What each of them consists of; may be called from any thread."""
        return [placed.assembly for placed in list(self._placed.values())]

    def load(self, floor: Floor, plans: Sequence[Assembly], progress: Progress) -> None:
        """Fill an empty world."""
        self._placed.clear()
        self._active.clear()
        self._latches.clear()
        self._maker.forget()
        plane = pybullet.createCollisionShape(pybullet.GEOM_PLANE, physicsClientId=self._client)
        ground = pybullet.createMultiBody(0.0, plane, physicsClientId=self._client)
        pybullet.changeDynamics(
            ground, -1, lateralFriction=floor.friction, physicsClientId=self._client
        )
        self._ground = (ground, floor.surface.material)
        for number, plan in enumerate(plans, 1):
            for _ in self._place(plan):
                pass
            progress(number, len(plans))

    def check_room(self, bodies: Optional[Sequence[int]] = None) -> None:
        """Refuse objects that stand in each other, or in the floor, where one of them can move.

        Parameters
        ----------
        bodies : sequence of int, optional
            Bodies of objects that are looked at (PyBullet's numbers); by default all.

        Raises
        ------
        ConfigError
            It names the first ten pairs.
        """
        objects = self.owners()
        owners = {self._ground[0]: "the floor", **objects}
        moving = {
            (uid, index - 1)
            for placed in self._placed.values()
            for uid, plan in zip(placed.bodies, placed.assembly.bodies)
            for index in plan.moving_segments()
        }
        looked_at = list(objects) if bodies is None else bodies

        def matter(a: int, b: int) -> bool:
            # Bodies of one object fit into each other by design.
            return a in owners and b in owners and owners[a] != owners[b]

        found = overlaps(
            self._client, looked_at, matter, lambda uid, link: (uid, link) in moving, MOST_NAMED + 1
        )
        if not found:
            return
        pairs = [
            f"{owners[pair.first]} and {owners[pair.second]} ({1000.0 * pair.depth:.0f} mm)"
            for pair in found[:MOST_NAMED]
        ]
        more = " and more" if len(found) > MOST_NAMED else ""
        raise ConfigError(
            f"objects stand in each other: {', '.join(pairs)}{more}; where one of two can move, "
            f"at most {1000.0 * DEEPEST:.0f} mm are possible"
        )

    def add(self, plans: Sequence[Assembly], robots: Sequence[int]) -> Iterator[None]:
        """Put further objects into the running world, all or none.

        What stands fast comes first, body by body: the world may be stepped, but not changed,
        before the next one. What can move comes in one go, whole and tried before it is stepped.

        Parameters
        ----------
        robots : sequence of int
            Bodies in which no object may stand.

        Raises
        ------
        ConfigError
            A name is taken, an object would stand in a robot or another object, there are too
            many, or PyBullet refuses one.
        """
        names = [plan.source.name for plan in plans]
        for name in names:
            if name in self._placed:
                raise ConfigError(f"name is '{name}'; an object of this name exists already")
        if len(self._placed) + len(plans) > MOST_OBJECTS:
            raise ConfigError(
                f"there are {len(self._placed)} objects; at most {MOST_OBJECTS} are possible"
            )
        try:
            made: List[int] = []
            for plan in sorted(plans, key=_can_move):
                for uid in self._place(plan):
                    if _can_move(plan):
                        made.append(uid)
                    else:
                        self._check_place([uid], robots)
                        yield
            self._check_place(made, robots)
        except ConfigError:
            for name in names:
                if name in self._placed:
                    self._take(name)
            raise

    def remove(self, name: str) -> List[str]:
        """Take an object out of the world, or all that one entry made.

        Returns
        -------
        list of str
            The names of what went; empty when there was nothing of this name.
        """
        names = [
            placed.assembly.source.name
            for placed in self._placed.values()
            if name in (placed.assembly.source.name, placed.assembly.source.entry)
        ]
        for gone in names:
            self._take(gone)
        if names:
            self.wake_all()
        return names

    def move(self, name: str, pose: Pose, robots: Sequence[int]) -> None:
        """Put an object elsewhere, at rest, with what its latches hold; joints stay as they are.

        Parameters
        ----------
        pose : Pose
            Of its root in the world.
        robots : sequence of int
            Bodies in which it must not stand.

        Raises
        ------
        ConfigError
            There is no such object, it stands fast, or it would stand in a robot or another object;
            nothing has changed.
        """
        placed = self._placed.get(name)
        if placed is None:
            raise ConfigError(f"name is '{name}'; there is no such object")
        model = placed.assembly.source.model
        if model.static:
            raise ConfigError(
                f"name is '{name}'; it stands fast and cannot be moved: it can be taken out, and "
                "put in again elsewhere"
            )
        change = compose(pose, invert(self.link_pose(name, model.links[0].name)))
        client = self._client
        moved = _held_together(placed)
        before = [
            (
                pybullet.getBasePositionAndOrientation(uid, physicsClientId=client),
                pybullet.getBaseVelocity(uid, physicsClientId=client),
            )
            for uid in moved
        ]
        for uid, (old, _) in zip(moved, before):
            self._put(uid, compose(change, old))
        try:
            self._check_place(moved, robots)
        except ConfigError:
            for uid, (old, velocity) in zip(moved, before):
                self._put(uid, old)
                pybullet.resetBaseVelocity(uid, *velocity, physicsClientId=client)
            raise
        for uid in moved:
            _rest(client, uid)
        self.wake_all()

    def _put(self, uid: int, pose: Pose) -> None:
        """Place a body; the engine forgets what it touched."""
        pybullet.resetBasePositionAndOrientation(uid, *pose, physicsClientId=self._client)
        for link in range(-1, pybullet.getNumJoints(uid, physicsClientId=self._client)):
            pybullet.setCollisionFilterGroupMask(uid, link, 1, -1, physicsClientId=self._client)

    def wake_all(self) -> None:
        """Wake everything: PyBullet leaves asleep what has lost its support."""
        for placed in self._placed.values():
            for uid in placed.movable:
                wake(self._client, uid)

    def apply(self) -> None:
        """Apply what springs, dampers, notches and latches do in the next step."""
        for mechanism in self._active:
            mechanism.apply()
        for latch in self._latches:
            latch.apply()

    def save_state(self) -> Any:
        """Return the state of all mechanisms and latches."""
        return (
            [mechanism.save_state() for mechanism in self._active],
            [latch.save_state() for latch in self._latches],
        )

    def restore_state(self, saved: Any, elapsed: float) -> None:
        """Let mechanisms and latches take a state up again; the bodies are where they were.

        Parameters
        ----------
        saved : object
            What `save_state` returned, of the same objects.
        elapsed : float
            Sim time since then (s).
        """
        mechanisms, latches = saved
        for mechanism, state in zip(self._active, mechanisms):
            mechanism.restore_state(state, elapsed)
        # All of them, in a fixed order: the engine solves constraints in the order of their coming.
        for latch in self._latches:
            latch.unfix()
        for latch, state in zip(self._latches, latches):
            latch.restore_state(state)

    def frames(self) -> List[str]:
        """Names of the links that can move, ``<object>/<link>``, in the order of `poses`."""
        return [
            f"{placed.assembly.source.name}/{link.name}"
            for placed in self._placed.values()
            for link in placed.assembly.source.model.moving_links()
        ]

    def poses(self) -> List[float]:
        """Poses of these links: 7 numbers each (m, quaternion x y z w)."""
        poses: List[float] = []
        for placed in self._placed.values():
            for tracked in placed.tracked:
                position, orientation = self._pose(*tracked)
                poses.extend(position)
                poses.extend(orientation)
        return poses

    def link_pose(self, name: str, link: str) -> Pose:
        """Where a link of an object is.

        Raises
        ------
        KeyError
            No such object or link.
        """
        placed = self._placed[name]
        source = placed.assembly.source
        if source.model.static and link == source.model.links[0].name:
            return source.position, source.orientation
        for moving, tracked in zip(source.model.moving_links(), placed.tracked):
            if moving.name == link:
                return self._pose(*tracked)
        raise KeyError(link)

    def _pose(self, uid: int, link: int, from_inertial: Pose) -> Pose:
        client = self._client
        if link >= 0:
            state = pybullet.getLinkState(
                uid, link, computeForwardKinematics=1, physicsClientId=client
            )
            return state[4], state[5]
        return pybullet.multiplyTransforms(
            *pybullet.getBasePositionAndOrientation(uid, physicsClientId=client), *from_inertial
        )

    def free_bodies(self) -> List[FreeBody]:
        """Bodies that can move and that no joint leads, in the order of `frames`."""
        return [
            FreeBody(f"{placed.assembly.source.name}/{link.name}", uid, from_inertial)
            for placed in self._placed.values()
            for link, (uid, index, from_inertial) in zip(
                placed.assembly.source.model.moving_links(), placed.tracked
            )
            if index < 0
        ]

    def joints(self) -> List[SceneJoint]:
        """Hinges and slides of all objects."""
        return [
            SceneJoint(f"{name}/{segment.joint.name}", uid, number - 1)
            for name, placed in self._placed.items()
            for uid, plan in zip(placed.bodies, placed.assembly.bodies)
            for number, segment in enumerate(plan.segments)
            if segment.joint is not None
        ]

    def latches(self) -> List[SceneLatch]:
        """Latches of all objects."""
        return [
            SceneLatch(f"{name}/{plan.joint.name}", latch)
            for name, placed in self._placed.items()
            for latch, plan in zip(placed.latches, placed.assembly.latches)
        ]

    def joint_position(self, name: str, joint: str) -> float:
        """Where a joint of an object is (rad, m).

        Raises
        ------
        KeyError
            No such object or joint.
        """
        _, uid, index = {each.name: each for each in self.joints()}[f"{name}/{joint}"]
        return pybullet.getJointState(uid, index, physicsClientId=self._client)[0]

    def latch(self, name: str, joint: str) -> Latch:
        """A latch of an object.

        Raises
        ------
        KeyError
            No such object or latch.
        """
        return {each.name: each.latch for each in self.latches()}[f"{name}/{joint}"]

    def bodies_of(self, name: str) -> Tuple[int, ...]:
        """PyBullet's bodies of an object; the first carries its root.

        Raises
        ------
        KeyError
            No such object.
        """
        return self._placed[name].bodies

    def owners(self) -> Dict[int, str]:
        """Of which object each body is, in words, by PyBullet's number."""
        return {uid: f"'{name}'" for name, placed in self._placed.items() for uid in placed.bodies}

    def material(self, uid: int, link: int) -> str:
        """What a link of PyBullet's body `uid` looks to be made of; empty where nothing says it.

        It is the material of the first part that has one, see `Surface.material`.
        """
        ground, material = self._ground
        if uid == ground:
            return material
        for placed in self._placed.values():
            if uid not in placed.bodies:
                continue
            segments = placed.assembly.bodies[placed.bodies.index(uid)].segments
            segment = segments[link + 1]
            while not segment.link and segment.parent >= 0:
                segment = segments[segment.parent]
            links = placed.assembly.source.model.links
            # Further bodies of one that stands fast are shares of its first link.
            name = segment.link or links[0].name
            for item in links:
                if item.name == name:
                    found = [part.surface.material for part in item.parts if part.surface]
                    return next(filter(None, found), "")
        return ""

    # --- PyBullet ----------------------------------------------------------------------------

    def _place(self, assembly: Assembly) -> Iterator[int]:
        """Make an object; tells each body when it is made."""
        bodies: List[int] = []
        try:
            yield from self._create(assembly, bodies)
        except pybullet.error as error:
            self._placed.pop(assembly.source.name, None)
            for uid in bodies:
                pybullet.removeBody(uid, physicsClientId=self._client)
            raise ConfigError(
                f"object '{assembly.source.name}': PyBullet cannot make it: {error}"
            ) from error

    def _create(self, assembly: Assembly, bodies: List[int]) -> Iterator[int]:
        """Make an object; `bodies` tells what of it is in the world when something fails.

        One that stands fast is known from its first body on, as the world may be stepped then.
        """
        source = assembly.source
        mechanisms: List[Mechanism] = []
        movable: List[int] = []
        of_link: Dict[str, Tuple[int, int, Pose]] = {}
        for plan in assembly.bodies:
            uid = self._maker.make(plan, (source.position, source.orientation))
            bodies.append(uid)
            self._maker.set_dynamics(uid, plan)
            if len(plan.segments) > 1:
                mechanism = Mechanism(self._client, uid, plan, self._step_size)
                if not mechanism.idle:
                    mechanisms.append(mechanism)
            if not plan.static or plan.inertias:
                movable.append(uid)
            base = pybullet.invertTransform(plan.segments[0].center, plan.segments[0].axes)
            of_link.update(
                {s.link: (uid, index - 1, base) for index, s in enumerate(plan.segments) if s.link}
            )
            if not _can_move(assembly):
                self._placed[source.name] = _Placed(assembly, tuple(bodies), (), (), (), ())
            yield uid
        latches = tuple(
            Latch(
                self._client,
                plan.joint,
                (bodies[plan.parent_body], plan.parent_segment - 1),
                bodies[plan.child_body],
                self._step_size,
                [bodies[number] for number in plan.parent_shares],
            )
            for plan in assembly.latches
        )
        self._placed[source.name] = _Placed(
            assembly,
            tuple(bodies),
            tuple(mechanisms),
            latches,
            tuple(of_link[link.name] for link in source.model.moving_links()),
            tuple(movable),
        )
        self._active += mechanisms
        self._latches += latches

    def _take(self, name: str) -> None:
        placed = self._placed.pop(name)
        self._active = [m for m in self._active if m not in placed.mechanisms]
        self._latches = [latch for latch in self._latches if latch not in placed.latches]
        for latch in placed.latches:
            latch.release()
        for uid in placed.bodies:
            pybullet.removeBody(uid, physicsClientId=self._client)

    def _check_place(self, bodies: Sequence[int], robots: Sequence[int]) -> None:
        """Refuse bodies that stand in a robot or in other objects."""
        for uid in bodies:
            if any(
                contact[8] < -_TOUCH
                for robot in robots
                for contact in pybullet.getClosestPoints(
                    robot, uid, 0.0, physicsClientId=self._client
                )
            ):
                owner = self.owners()[uid]
                raise ConfigError(f"{owner} would stand in the robot; it needs another place")
        self.check_room(bodies)


def _can_move(assembly: Assembly) -> bool:
    return bool(assembly.source.model.moving_links())


def _held_together(placed: _Placed) -> List[int]:
    """Bodies of an object that go where its root goes: not what is out of its latch."""
    held, before = {0}, 0
    # A latch may stand before the one that holds its parent.
    while len(held) > before:
        before = len(held)
        for latch, plan in zip(placed.latches, placed.assembly.latches):
            if latch.holds and plan.parent_body in held:
                held.add(plan.child_body)
    return [placed.bodies[number] for number in sorted(held)]


def _rest(client: int, uid: int) -> None:
    """Take all motion from a body."""
    nothing = (0.0, 0.0, 0.0)
    pybullet.resetBaseVelocity(uid, nothing, nothing, physicsClientId=client)
    for joint in range(pybullet.getNumJoints(uid, physicsClientId=client)):
        position = pybullet.getJointState(uid, joint, physicsClientId=client)[0]
        pybullet.resetJointState(uid, joint, position, 0.0, physicsClientId=client)
