"""Abilities of a robot: what its parameters and its URDF say that an operator can move and see.

They are those of the teleoperation nodes' own settings, read as the nodes read them: what a node
would leave out is left out here.
"""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, field
from functools import lru_cache
from typing import Any, Callable, Dict, Iterable, List, Mapping, Optional, Tuple, Type, TypeVar

import numpy as np

from telex_control.common.geometry.matrices import homogeneous, rotation_from_rpy
from telex_control.common.params import ConfigError, read_config
from telex_control.kinematics.urdf_tree import UrdfTree
from telex_control.urdf.joints import PRISMATIC, UrdfError
from telex_teleop.arm.arm_settings import ArmTeleopSettings, carrier_of
from telex_teleop.flippers.flipper_settings import FlipperTeleopSettings
from telex_teleop.joints.joint_settings import (
    GripperTeleopSettings,
    JointTeleopSettings,
    limits_of_present,
)
from telex_teleop.motion.axis import AxisSettings
from telex_teleop.tracks.track_drive import TrackSettings

Parameters = Callable[[str], object]
"""Returns the parameter of a name, or None where it is not set."""

Settings = TypeVar("Settings")
JointSettings = TypeVar("JointSettings", bound=JointTeleopSettings)

NODES = ("arm", "gripper", "flipper", "track")

_PARAMETERS = (
    "robot_description",
    *(f"{node}_teleop" for node in NODES),
    "gripper_controller/geometry",
    "cameras/cameras",
    "cameras/lamps",
    *(
        f"{place}/{name}"
        for place in ("simulator", "simulation")
        for name in ("model", "proximity/joints", "tracks/belts")
    ),
)

MOST_HEAD_JOINTS = 2
"""Joints of a camera's head, pan and tilt; an arm without a known tool has more."""

_MIDDLE = 1e-3
"""Distance (m) from the robot's middle plane within which a joint is on neither side."""


@dataclass(frozen=True)
class MovedJoint:
    """A joint with all joints at 0, in the frame of the robot's root link (m).

    Attributes
    ----------
    kind
        ``revolute``, ``continuous`` or ``prismatic``.
    axis
        Unit vector.
    place
        Of its origin.
    """

    name: str
    kind: str
    axis: Tuple[float, float, float]
    place: Tuple[float, float, float]


@dataclass(frozen=True)
class GripperFacts:
    """What the page has to know of a gripper.

    Attributes
    ----------
    name
        By which all its joints are moved together.
    measured_by
        Joints whose mean is its measured value.
    geometry
        Of the parallel gripper's controller; None for other grippers.
    """

    name: str
    measured_by: Tuple[str, ...]
    geometry: Optional[Dict[str, float]] = None


@dataclass(frozen=True)
class Abilities:
    """What an operator can do with a robot.

    Attributes
    ----------
    arm
        Joints of the arm.
    head
        Joints that turn a camera or a lamp which is not the arm's.
    fingers
        Joints of the gripper.
    flippers
        Joints of the flippers.
    gripper
        None: there is none.
    odometry
        Topic that tells how the base drives; empty: it cannot drive.
    tool
        Whether the arm can be led by its tool.
    guard
        Whether something tells what the arm is near to.
    attitude
        Whether something tells how the robot stands.
    poses, presets
        Names of the arm's poses and of the flippers' presets.
    lamps
        Their names.
    cameras
        Name to role, which is empty where none was declared.
    zooms
        Whether one of them can zoom.
    lengths
        Joints whose position is a length.
    """

    arm: Tuple[MovedJoint, ...] = ()
    head: Tuple[MovedJoint, ...] = ()
    fingers: Tuple[MovedJoint, ...] = ()
    flippers: Tuple[MovedJoint, ...] = ()
    gripper: Optional[GripperFacts] = None
    odometry: str = ""
    tool: bool = False
    guard: bool = False
    attitude: bool = False
    poses: Tuple[str, ...] = ()
    presets: Tuple[str, ...] = ()
    lamps: Tuple[str, ...] = ()
    cameras: Dict[str, str] = field(default_factory=dict)
    zooms: bool = False
    lengths: Tuple[str, ...] = ()

    @property
    def drives(self) -> bool:
        """Whether it can drive."""
        return bool(self.odometry)

    def sides(self) -> Dict[str, List[str]]:
        """Return which of the flippers and fingers are on the left side, and on the right one."""
        both = (*self.flippers, *self.fingers)
        return {
            "left": [each.name for each in both if each.place[1] > _MIDDLE],
            "right": [each.name for each in both if each.place[1] < -_MIDDLE],
        }

    def as_json(self) -> Dict[str, Any]:
        """Return what ``/robot.json`` has of it beside the cameras."""
        return {
            "moves": {
                "arm": [each.name for each in (*self.arm, *self.head)],
                "gripper": [each.name for each in self.fingers],
                "flipper": [each.name for each in self.flippers],
            },
            "sides": self.sides(),
            "gripper": None if self.gripper is None else asdict(self.gripper),
            "odometry": self.odometry or None,
        }


def abilities_of(
    parameter: Parameters, prefix: str, warn: Callable[[str], None]
) -> Optional[Abilities]:
    """Return what a robot can do; None where nothing says it.

    Parameters
    ----------
    parameter
        Parameters of the robot.
    prefix
        Of their names.
    warn
        Told of a node whose parameters are wrong: it cannot start, and so moves nothing.
    """
    given = {name: parameter(f"{prefix}{name}") for name in _PARAMETERS}
    if not isinstance(given["robot_description"], str):
        return None
    if not any(isinstance(given[f"{node}_teleop"], dict) for node in NODES):
        return None
    abilities, problems = _read(json.dumps(given, default=str))
    for problem in problems:
        warn(problem)
    return abilities


@lru_cache(maxsize=8)
def _read(given: str) -> Tuple[Optional[Abilities], Tuple[str, ...]]:
    """Return what parameters say, and what is wrong with them; a long URDF takes its time."""
    problems: List[str] = []
    try:
        abilities = _Reader(json.loads(given), problems.append).read()
    except UrdfError as error:
        return None, (f"robot_description: {error}",)
    return abilities, tuple(problems)


def _zooms(most: object) -> bool:
    return isinstance(most, (int, float)) and most > 1.0


class _Reader:
    """Reads the parameters of one robot."""

    def __init__(self, given: Mapping[str, Any], warn: Callable[[str], None]) -> None:
        self._given = given
        self._description: str = given["robot_description"]
        self._warn = warn
        self._tree = UrdfTree.from_urdf(self._description)
        self._links = {self._tree.root, *self._tree.joint_above}
        self._above = {joint.name: joint for joint in self._tree.joint_above.values()}

    def read(self) -> Abilities:
        """Return what they say."""
        track = self._settings("track", TrackSettings)
        cameras, lamps = self._present("cameras/cameras"), self._present("cameras/lamps")
        arm = self._arm([*cameras.values(), *lamps.values()])
        flippers, presets = self._flippers()
        fingers, gripper = self._gripper()
        return Abilities(
            **arm,
            fingers=fingers,
            flippers=flippers,
            gripper=gripper,
            odometry="" if track is None else f"{track.controller}/odom",
            guard=bool(arm["arm"]) and self._is_told("proximity/joints"),
            attitude=self._is_told("tracks/belts"),
            presets=presets,
            lamps=tuple(lamps),
            cameras={name: str(each.get("role", "")) for name, each in cameras.items()},
            zooms=any(_zooms(each.get("zoom_max")) for each in cameras.values()),
            lengths=self._lengths(gripper),
        )

    def _settings(self, node: str, kind: Type[Settings]) -> Optional[Settings]:
        given = self._given[f"{node}_teleop"]
        if not isinstance(given, dict):
            return None
        try:
            return read_config(kind, given, f"{node}_teleop")
        except ConfigError as error:
            self._warn(str(error))
            return None

    def _axes(
        self, node: str, kind: Type[JointSettings]
    ) -> Tuple[Optional[JointSettings], Dict[str, AxisSettings]]:
        """Return the settings of a joint node, and the bounds of the joints that there are."""
        settings = self._settings(node, kind)
        if settings is None:
            return None, {}
        try:
            return settings, settings.axes(limits_of_present(settings, self._description)[0])
        except (ConfigError, UrdfError) as error:
            self._warn(f"{node}_teleop: {error}")
            return None, {}

    def _arm(self, turned: Iterable[Mapping[str, Any]]) -> Dict[str, Any]:
        settings, axes = self._axes("arm", ArmTeleopSettings)
        if settings is None or not axes:
            return {"arm": (), "head": ()}
        chain, carrier, _ = carrier_of(settings, self._description, axes)
        carriers = frozenset(() if chain is None else chain.joint_names)
        frames = [str(each.get("frame", "")) for each in turned]
        turning = {name for frame in frames if frame in self._links for name in self._path(frame)}
        head = [name for name in axes if name in turning and name not in carriers]
        if len(head) > MOST_HEAD_JOINTS:
            head = []
        return {
            "arm": self._moved(name for name in axes if name not in head),
            "head": self._moved(head),
            "tool": chain is not None,
            "poses": tuple(carrier.poses),
        }

    def _flippers(self) -> Tuple[Tuple[MovedJoint, ...], Tuple[str, ...]]:
        settings, axes = self._axes("flipper", FlipperTeleopSettings)
        if settings is None:
            return (), ()
        try:
            return self._moved(axes), tuple(settings.preset_table(axes))
        except ConfigError as error:
            self._warn(f"flipper_teleop: {error}")
            return (), ()

    def _gripper(self) -> Tuple[Tuple[MovedJoint, ...], Optional[GripperFacts]]:
        settings, axes = self._axes("gripper", GripperTeleopSettings)
        if settings is None or not axes:
            return (), None
        told = self._given["gripper_controller/geometry"]
        group = settings.coupling
        facts = GripperFacts(
            group.name, group.measured_by, dict(told) if isinstance(told, dict) else None
        )
        return self._moved(axes), facts

    def _lengths(self, gripper: Optional[GripperFacts]) -> Tuple[str, ...]:
        lengths = [name for name, each in self._above.items() if each.kind == PRISMATIC]
        if gripper is not None and set(gripper.measured_by) <= set(lengths):
            lengths.append(gripper.name)
        return tuple(lengths)

    def _is_told(self, needs: str) -> bool:
        """Tell whether the simulator says what needs a parameter; else it comes from elsewhere."""
        for place in ("simulator", "simulation"):
            if self._given[f"{place}/model"] is not None:
                return bool(self._given[f"{place}/{needs}"])
        return True

    def _present(self, name: str) -> Dict[str, Dict[str, Any]]:
        """Return the cameras or lamps whose link the robot has."""
        told = self._given[name]
        return {
            str(each): values
            for each, values in (told.items() if isinstance(told, dict) else ())
            if isinstance(values, dict) and values.get("frame", self._tree.root) in self._links
        }

    def _path(self, link: str) -> List[str]:
        return [joint.name for joint in self._tree.path(self._tree.root, link)]

    def _moved(self, names: Iterable[str]) -> Tuple[MovedJoint, ...]:
        return tuple(self._moved_joint(name) for name in names)

    def _moved_joint(self, name: str) -> MovedJoint:
        joint = self._above[name]
        pose = np.eye(4)
        # Of origins alone: a `Chain` refuses joints below that are of <mimic>, or without limits.
        for each in self._tree.path(self._tree.root, joint.child):
            pose = pose @ homogeneous(rotation_from_rpy(each.origin.rpy), each.origin.xyz)
        x, y, z = (pose[:3, :3] @ np.array(joint.axis)).tolist()
        return MovedJoint(name, joint.kind, (x, y, z), tuple(pose[:3, 3].tolist()))
