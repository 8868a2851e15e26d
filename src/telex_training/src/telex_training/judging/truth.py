"""The truth stream: samples decoded, the world as they tell it, and doses."""

from __future__ import annotations

import math
import struct
from functools import lru_cache
from typing import Any, Dict, List, Mapping, NamedTuple, Optional, Sequence, Tuple

from telex_control.common.geometry.quaternions import Pose, compose
from telex_control.kinematics.chain import Chain
from telex_control.kinematics.urdf_tree import UrdfTree
from telex_sim.scene.model import Scene, Vector3

from ..exercises.conditions import FLOOR, ROBOT, TOOL
from .entries import BadEntryError

TOOL_LINK = "tool_link"
ANOTHER_ROBOT = "another robot"
_FLOOR_INDEX, _ROBOT_INDEX, _NOTHING = -1, -2, -1
_NOWHERE = (math.inf, math.inf, math.inf)
_HEADER = struct.Struct("<IIII")
_FIXED = struct.Struct("<QQIId13f")
_COUNT = struct.Struct("<I")
_TAIL = struct.Struct("<fhfI")
_CONTACT = struct.Struct("<BhffI3f")
_MOST = 100_000
_ROUNDING = 1e-3
"""Difference of a quaternion's norm from 1 that float32 and PyBullet leave, with room to spare."""


class Contact(NamedTuple):
    """A telex_msgs/TruthContact: indices into the names, N, N s, physics steps, m."""

    group: int
    object: int
    peak: float
    impulse: float
    steps: int
    point: Vector3


class Sample(NamedTuple):
    """A telex_msgs/TruthSample; poses of moved bodies by the bodies' indices."""

    time: float
    sequence: int
    steps: int
    revision: int
    resets: int
    wall_time: float
    base: Pose
    twist: Tuple[float, ...]
    joints: Tuple[float, ...]
    mechanisms: Tuple[float, ...]
    latched: Tuple[bool, ...]
    moved: Tuple[Tuple[int, Pose], ...]
    margin: float
    held: int
    grip: float
    contacts: Tuple[Contact, ...]


@lru_cache(maxsize=256)
def _array(count: int, letter: str) -> struct.Struct:
    return struct.Struct(f"<{count}{letter}")


def read_sample(data: bytes) -> Sample:
    """Decode a telex_msgs/TruthSample.

    genpy's own decoder takes several times as long for its contacts.

    Raises
    ------
    BadEntryError
        It is cut off or too long, a number is not finite, or a pose has no orientation.
    """
    try:
        return _read(data)
    except struct.error:
        raise BadEntryError("the truth sample is cut off") from None


def _read(data: bytes) -> Sample:
    _, secs, nsecs, length = _HEADER.unpack_from(data)
    at = _HEADER.size + length
    fixed = _FIXED.unpack_from(data, at)
    at += _FIXED.size
    arrays: List[Tuple[Any, ...]] = []
    for letter, size in (("f", 4), ("f", 4), ("?", 1)):
        (count,) = _COUNT.unpack_from(data, at)
        at += 4
        arrays.append(_array(_bounded(count), letter).unpack_from(data, at))
        at += size * count
    joints, mechanisms, latched = arrays
    at += 1  # whole: bodies that did not move keep their poses
    (count,) = _COUNT.unpack_from(data, at)
    indices = _array(_bounded(count), "H").unpack_from(data, at + 4)
    at += 4 + 2 * count
    (numbers,) = _COUNT.unpack_from(data, at)
    if numbers != 7 * count:
        raise BadEntryError(f"the truth sample has {numbers} numbers of {count} poses")
    poses = _array(numbers, "f").unpack_from(data, at + 4)
    at += 4 + 4 * numbers
    margin, held, grip, count = _TAIL.unpack_from(data, at)
    at += _TAIL.size
    if len(data) != at + _bounded(count) * _CONTACT.size:
        raise BadEntryError(
            f"the truth sample has {len(data)} bytes, which do not fit {count} contacts"
        )
    contacts = []
    total = margin + grip
    for _ in range(count):
        group, thing, peak, impulse, steps, x, y, z = _CONTACT.unpack_from(data, at)
        contacts.append(Contact(group, thing, peak, impulse, steps, (x, y, z)))
        total += peak + impulse + x + y + z
        at += _CONTACT.size
    total += sum(fixed) + sum(joints) + sum(mechanisms) + sum(poses)
    if not math.isfinite(total):
        raise BadEntryError("the truth sample has a number that is not finite")
    sequence, steps, revision, resets, wall = fixed[:5]
    moved = tuple((index, _pose(poses[7 * i : 7 * i + 7])) for i, index in enumerate(indices))
    return Sample(
        secs + 1e-9 * nsecs,
        sequence,
        steps,
        revision,
        resets,
        wall,
        _pose(fixed[5:12]),
        fixed[12:18],
        joints,
        mechanisms,
        latched,
        moved,
        margin,
        held,
        grip,
        tuple(contacts),
    )


def _bounded(count: int) -> int:
    if count > _MOST:
        raise BadEntryError(f"the truth sample has a list of {count}; at most {_MOST} are possible")
    return count


def _pose(numbers: Sequence[float]) -> Pose:
    x, y, z, a, b, c, d = numbers
    norm = a * a + b * b + c * c + d * d
    if abs(norm - 1.0) > _ROUNDING:
        raise BadEntryError("the truth sample has a pose without an orientation")
    return (x, y, z), (a, b, c, d)


class Names:
    """What the numbers of samples are of; made of a telex_msgs/TruthNames.

    Raises
    ------
    BadEntryError
    """

    def __init__(self, message: Any) -> None:
        self.revision = int(message.revision)
        self.groups: Tuple[str, ...] = tuple(message.groups)
        self.objects: Tuple[str, ...] = tuple(message.objects)
        self.bodies: Tuple[str, ...] = tuple(message.bodies)
        self.joints: Dict[str, int] = {name: i for i, name in enumerate(message.joints)}
        self.mechanisms: Dict[str, int] = {name: i for i, name in enumerate(message.mechanisms)}
        self.latches: Dict[str, int] = {name: i for i, name in enumerate(message.latches)}
        self.first_body: Dict[str, int] = {}
        for i, body in enumerate(self.bodies):
            self.first_body.setdefault(body.partition("/")[0], i)
        self.body: Dict[str, int] = {name: i for i, name in enumerate(self.bodies)}

    def thing(self, index: int) -> str:
        """Name of what a contact is with.

        Raises
        ------
        BadEntryError
        """
        if index == _FLOOR_INDEX:
            return FLOOR
        if index == _ROBOT_INDEX:
            return ANOTHER_ROBOT
        if not 0 <= index < len(self.objects):
            raise BadEntryError(f"the truth names {len(self.objects)} objects, not number {index}")
        return self.objects[index]


class Tool:
    """Forward kinematics from the robot's root link to its tool.

    Parameters
    ----------
    urdf : str
        Empty, or of a robot without a tool: it is nowhere.

    Raises
    ------
    telex_control.urdf.joints.UrdfError
    """

    def __init__(self, urdf: str) -> None:
        self._chain: Optional[Chain] = None
        self._order: Optional[Tuple[int, ...]] = None
        if not urdf:
            return
        tree = UrdfTree.from_urdf(urdf)
        if TOOL_LINK in tree.inertials:
            self._chain = Chain.from_urdf(urdf, tree.root, TOOL_LINK)

    def name_joints(self, joints: Dict[str, int]) -> None:
        """Hear where in a sample each joint stands."""
        self._order = None
        if self._chain is not None and set(self._chain.joint_names) <= set(joints):
            self._order = tuple(joints[name] for name in self._chain.joint_names)

    def in_base(self, joints: Tuple[float, ...]) -> Optional[Any]:
        """Return the pose of the tool in the root link, shape (4, 4); None where it is not known.

        Parameters
        ----------
        joints : tuple of float
            As in a sample (rad, m).
        """
        if self._chain is None or self._order is None:
            return None
        return self._chain.forward([joints[i] for i in self._order])


class DoseRecord:
    """What has been received since a repetition began."""

    def __init__(self) -> None:
        self._now: Dict[str, float] = {}
        self._before: Dict[str, float] = {}

    def begin(self) -> None:
        """Count from now on."""
        self._before = dict(self._now)

    def take(self, doses: Mapping[str, float]) -> None:
        """Take what components have received by now (Gy).

        One that is new counts from here on, and so does one that a reset has set back.
        """
        self._now = dict(doses)
        for component, dose in doses.items():
            self._before[component] = min(self._before.get(component, dose), dose)

    def received(self, component: str) -> Optional[float]:
        """Dose of a component since the begin (Gy); None: nobody tells."""
        if component not in self._now:
            return None
        return self._now[component] - self._before[component]


class World:
    """What is where, by the newest sample, and what the robot has received.

    Parameters
    ----------
    scene : Scene, optional
        For where that stands which does not move by itself.

    Attributes
    ----------
    sample : Sample, optional
        None until there is one whose names are known.
    tool_in_base : ndarray, shape (4, 4), optional
    tool : tuple of 3 floats, optional
        Where the tool is in the world (m).
    """

    def __init__(self, scene: Optional[Scene] = None, urdf: str = "") -> None:
        self.names: Optional[Names] = None
        self.sample: Optional[Sample] = None
        self.doses = DoseRecord()
        self.tool_in_base: Any = None
        self.tool: Optional[Vector3] = None
        self._forward = Tool(urdf)
        self._bodies: List[Optional[Pose]] = []
        self._static: Dict[str, Pose] = {}
        self._roots: Dict[str, str] = {}
        for item in scene.objects if scene is not None else ():
            root = item.model.links[0].name
            self._roots[item.name] = f"{item.name}/{root}"
            if item.model.static:
                for name in (item.name, f"{item.name}/{root}"):
                    self._static[name] = (item.position, item.orientation)

    def name(self, names: Names) -> None:
        """Take the names of what comes from now on."""
        self.names = names
        self._bodies = [None] * len(names.bodies)
        self._forward.name_joints(names.joints)

    def knows(self, sample: Sample) -> bool:
        """Whether the sample is of the names that there are."""
        return self.names is not None and self.names.revision == sample.revision

    def take(self, sample: Sample) -> None:
        """Take a sample whose names are known.

        Raises
        ------
        BadEntryError
            It has more or fewer numbers than there are names, or an index out of range.
        """
        names = self.names
        assert names is not None
        for what, count, wanted in (
            ("joints", len(sample.joints), len(names.joints)),
            ("mechanisms", len(sample.mechanisms), len(names.mechanisms)),
            ("latches", len(sample.latched), len(names.latches)),
        ):
            if count != wanted:
                raise BadEntryError(f"the truth sample has {count} {what}; {wanted} have names")
        bodies = self._bodies
        for index, _ in sample.moved:
            if index >= len(bodies):
                raise BadEntryError(f"the truth names {len(bodies)} bodies, not number {index}")
        for contact in sample.contacts:
            if contact.group >= len(names.groups):
                raise BadEntryError(
                    f"the truth names {len(names.groups)} groups, not number {contact.group}"
                )
            names.thing(contact.object)
        if sample.held != _NOTHING:
            names.thing(sample.held)
        for index, pose in sample.moved:
            bodies[index] = pose
        self.sample = sample
        self.tool_in_base = matrix = self._forward.in_base(sample.joints)
        if matrix is not None:
            x, y, z = matrix[:3, 3].tolist()
            self.tool = compose(sample.base, ((x, y, z), (0.0, 0.0, 0.0, 1.0)))[0]

    @property
    def held(self) -> str:
        """Name of what the gripper holds; empty: nothing."""
        if self.sample is None or self.names is None or self.sample.held == _NOTHING:
            return ""
        return self.names.thing(self.sample.held)

    @property
    def carried(self) -> str:
        """Name of what of it moves along with the gripper.

        Of an object that stands fast, that is the loose piece ("object/link") next to the tool.
        """
        held = self.held
        if held not in self._static or self.names is None:
            return held
        pieces = [body for body in self.names.bodies if body.partition("/")[0] == held]
        tool = self.tool
        if not pieces or tool is None:
            return pieces[0] if pieces else held
        return min(pieces, key=lambda piece: math.dist(self.position(piece) or _NOWHERE, tool))

    def pose(self, what: str) -> Optional[Pose]:
        """Pose of the robot, an object or an object's link ("object/link"); None: not known."""
        sample, names = self.sample, self.names
        if sample is None or names is None:
            return None
        if what == ROBOT:
            return sample.base
        if what in self._static:
            return self._static[what]
        index = names.body.get(self._roots.get(what, what), names.first_body.get(what, -1))
        return self._bodies[index] if index >= 0 else None

    def position(self, what: str) -> Optional[Vector3]:
        """Where the robot, its tool, an object or an object's link is (m); None: not known."""
        if what == TOOL:
            return self.tool
        pose = self.pose(what)
        return None if pose is None else pose[0]

    def places(self) -> Dict[str, Vector3]:
        """Where everything is that can be (m)."""
        names = self.names
        things = [ROBOT, TOOL]
        if names is not None:
            things += [*names.first_body, *names.bodies]
        found = {what: self.position(what) for what in things}
        return {what: place for what, place in found.items() if place is not None}
