"""The PyBullet world and the robots' bodies in it.

Only one thread may use a `World`: PyBullet is not safe with more.
"""

from __future__ import annotations

import math
import os
import tempfile
from pathlib import Path
from typing import Callable, Collection, Dict, List, Mapping, Optional, Sequence, Tuple
from xml.etree import ElementTree

import pybullet

from telex_control.common.geometry.quaternions import Quaternion
from telex_control.urdf.model import read_xml

from ..robot.urdf.elements import vector
from ..robot.urdf.frames import Frame, take_out_frames, take_out_wheels
from ..robot.urdf.masses import complete_masses
from ..scene.meshes.mesh_files import rewritten
from .overlaps import neighbours

GRAVITY = 9.81
_UNIT = 1.0e-9
"""By how much the length of an axis may miss 1 that is left as it is written."""
Vector = Tuple[float, float, float]


class WorldError(RuntimeError):
    """The world cannot be made; the message says why."""


class Body:
    """A robot in the world, by the names of its URDF.

    PyBullet knows nothing of the links that `urdf_frames` takes out: mere frames, and the wheels of
    belts.

    Parameters
    ----------
    client, uid : int
        PyBullet's identifiers.
    frames : mapping of str to Frame
        The links that PyBullet does not have.

    Attributes
    ----------
    joints, links : dict of str to int
        Indices by name; a joint has the index of its child link, the base link is -1. Those that
        PyBullet has.
    parents : dict of str to str
        Parent link of each joint, those of wheels too.
    wheels : dict of str to float
        Angle (rad) of each wheel that PyBullet does not have, by its joint; whoever drives it
        keeps it.
    """

    def __init__(self, client: int, uid: int, frames: Mapping[str, Frame]) -> None:
        self.client = client
        self.uid = uid
        base, _ = pybullet.getBodyInfo(uid, physicsClientId=client)
        self.base_link = base.decode()
        self.links: Dict[str, int] = {self.base_link: -1}
        self.joints: Dict[str, int] = {}
        names = {-1: self.base_link}
        parents = {}
        for index in range(pybullet.getNumJoints(uid, physicsClientId=client)):
            info = pybullet.getJointInfo(uid, index, physicsClientId=client)
            joint, link = info[1].decode(), info[12].decode()
            self.joints[joint] = index
            self.links[link] = index
            names[index] = link
            parents[joint] = info[16]
        self.parents = {joint: names[parent] for joint, parent in parents.items()}
        self._indices = list(range(len(self.joints)))
        self._places: Dict[str, Tuple[int, Vector, Quaternion]] = {}
        for link, index in self.links.items():
            inertial = pybullet.getDynamicsInfo(uid, index, physicsClientId=client)[3:5]
            self._places[link] = (index, *pybullet.invertTransform(*inertial))
        self.wheels: Dict[str, float] = {}
        for name, frame in frames.items():
            index, *own = self._places[frame.link]
            offset = (frame.position, frame.orientation)
            self._places[name] = (index, *pybullet.multiplyTransforms(*own, *offset))
            if frame.joint:
                self.parents[frame.joint] = frame.link
                self.wheels[frame.joint] = 0.0
        self._frames = frames

    def link_names(self) -> List[str]:
        """Names of all links: the base, then the rest in PyBullet's order, then what it lacks."""
        return list(self._places)

    def place(self, link: str) -> Tuple[int, Vector, Quaternion]:
        """Where a link's frame is in PyBullet's body.

        Returns
        -------
        index : int
            Of the link in PyBullet that it is, or is a part of.
        position, orientation : Vector, Quaternion
            In that one's inertial frame, which is the one that PyBullet places and holds it by; of
            a wheel, at angle 0.
        """
        return self._places[link]

    def pose(self, link: str) -> Tuple[Vector, Quaternion]:
        """Pose of a link's frame in the world; of a wheel, at angle 0."""
        index, *place = self._places[link]
        if index < 0:
            state = pybullet.getBasePositionAndOrientation(self.uid, physicsClientId=self.client)
        else:
            state = pybullet.getLinkState(
                self.uid, index, computeForwardKinematics=1, physicsClientId=self.client
            )
        return pybullet.multiplyTransforms(*state[:2], *place)

    def base_pose(self) -> Tuple[Vector, Quaternion]:
        """Pose of the base link's frame in the world."""
        return self.pose(self.base_link)

    def link_poses(self) -> List[float]:
        """Poses of all links in the order of `link_names`: 7 numbers each (m, quaternion xyzw)."""
        client = self.client
        base = pybullet.getBasePositionAndOrientation(self.uid, physicsClientId=client)
        position, orientation = self.base_pose()
        poses = [*position, *orientation]
        states: Sequence[Tuple] = ()
        if self._indices:
            states = pybullet.getLinkStates(
                self.uid, self._indices, computeForwardKinematics=1, physicsClientId=client
            )
        for state in states:
            poses.extend(state[4])
            poses.extend(state[5])
        for name, frame in self._frames.items():
            index, *place = self._places[name]
            carrier = base if index < 0 else states[index][:2]
            position, orientation = pybullet.multiplyTransforms(*carrier, *place)
            if frame.joint:
                turned = pybullet.getQuaternionFromAxisAngle(frame.axis, self.wheels[frame.joint])
                orientation = pybullet.multiplyTransforms(
                    position, orientation, (0.0, 0.0, 0.0), turned
                )[1]
            poses.extend(position)
            poses.extend(orientation)
        return poses


class World:
    """A PyBullet client with gravity, and the robots in it.

    Parameters
    ----------
    step_size : float
        Sim time of one step (s).
    gui : bool
        Open PyBullet's window; needs a display.

    Raises
    ------
    WorldError
        The window cannot be opened.
    """

    def __init__(self, step_size: float, solver_iterations: int, gui: bool = False) -> None:
        self._step_size = step_size
        self._iterations = solver_iterations
        self._gui = gui
        if gui and not os.environ.get("DISPLAY"):
            raise WorldError("gui is true, but there is no display (DISPLAY is not set)")
        try:
            self.client = pybullet.connect(pybullet.GUI if gui else pybullet.DIRECT)
        except pybullet.error as error:
            raise WorldError(f"PyBullet's window cannot be opened: {error}") from error
        if self.client < 0:
            raise WorldError("PyBullet's window cannot be opened")
        if gui:
            self._arrange_window()
        self.clear()

    def _arrange_window(self) -> None:
        """Show the robot instead of PyBullet's panels."""
        pybullet.configureDebugVisualizer(pybullet.COV_ENABLE_GUI, 0, physicsClientId=self.client)
        pybullet.resetDebugVisualizerCamera(
            cameraDistance=2.2,
            cameraYaw=40.0,
            cameraPitch=-22.0,
            cameraTargetPosition=(0.2, 0.0, 0.3),
            physicsClientId=self.client,
        )

    def close(self) -> None:
        """Disconnect."""
        pybullet.disconnect(self.client)

    def clear(self) -> None:
        """Remove everything."""
        client = self.client
        pybullet.resetSimulation(physicsClientId=client)
        pybullet.setGravity(0.0, 0.0, -GRAVITY, physicsClientId=client)
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=self._step_size,
            numSolverIterations=self._iterations,
            numSubSteps=0,
            deterministicOverlappingPairs=1,
            physicsClientId=client,
        )

    def load_robot(
        self,
        urdf: str,
        resolve: Callable[[str], str],
        position: Sequence[float],
        yaw: float,
        joint_positions: Dict[str, float],
        fixed_base: bool = False,
        self_collision: bool = True,
        wheels: Collection[str] = (),
    ) -> Body:
        """Put a robot into the world.

        Parameters
        ----------
        resolve : callable
            Turns a mesh address (``package://…``) into a path.
        position : sequence of 3 floats
            Of the base link's frame (m).
        yaw : float
            Heading (rad).
        joint_positions : dict
            By joint name (rad, m); 0 for the rest.
        fixed_base : bool
            Fix the root link to the world; see `complete_masses` for which always is.
        self_collision : bool
            Whether its links can touch each other.
        wheels : collection of str
            Joints whose wheels only show how something runs, see `urdf_frames.take_out_wheels`.

        Raises
        ------
        WorldError
            PyBullet refuses the URDF, there is no room for its temporary file, or a joint of
            `joint_positions` does not exist.
        """
        client = self.client
        root = read_xml(urdf)
        _normalise_axes(root)
        frames = {**take_out_wheels(root, wheels), **take_out_frames(root)}
        masses = complete_masses(root, fixed_base)
        if not self._gui:
            # Nothing looks at them there, and reading them is most of the time that loading takes.
            _drop_visuals(root)
        flags = pybullet.URDF_USE_INERTIA_FROM_FILE
        if self_collision:
            flags |= pybullet.URDF_USE_SELF_COLLISION
        try:
            with tempfile.TemporaryDirectory() as folder:
                _use_local_meshes(root, resolve, Path(folder))
                file = Path(folder, "robot.urdf")
                file.write_text(ElementTree.tostring(root, encoding="unicode"), encoding="utf-8")
                uid = pybullet.loadURDF(
                    str(file),
                    useFixedBase=masses.fixed,
                    flags=flags,
                    physicsClientId=client,
                )
        except (pybullet.error, OSError) as error:
            raise WorldError(f"PyBullet cannot load robot_description: {error}") from error
        body = Body(client, uid, frames)
        for index in range(-1, len(body.joints)):
            # Bullet's damping defaults would brake the robot on slopes and in the air.
            pybullet.changeDynamics(
                uid,
                index,
                linearDamping=0.0,
                angularDamping=0.0,
                jointDamping=0.0,
                rollingFriction=0.0,
                spinningFriction=0.0,
                physicsClientId=client,
            )
        for name, value in joint_positions.items():
            if name not in body.joints:
                raise WorldError(f"start pose: the robot has no joint '{name}'")
            pybullet.resetJointState(uid, body.joints[name], value, physicsClientId=client)
        inertial = pybullet.getDynamicsInfo(uid, -1, physicsClientId=client)[3:5]
        base = pybullet.multiplyTransforms(
            position, pybullet.getQuaternionFromEuler((0.0, 0.0, yaw)), *inertial
        )
        pybullet.resetBasePositionAndOrientation(uid, *base, physicsClientId=client)
        return body

    def remove(self, body: Body) -> None:
        """Take a robot out of the world."""
        pybullet.removeBody(body.uid, physicsClientId=self.client)

    def bodies(self) -> List[int]:
        """PyBullet's numbers of all bodies."""
        client = self.client
        count = pybullet.getNumBodies(physicsClientId=client)
        return [pybullet.getBodyUniqueId(index, physicsClientId=client) for index in range(count)]

    def remove_others(self, kept: Collection[int]) -> None:
        """Take everything out of the world but the bodies `kept`."""
        for uid in self.bodies():
            if uid not in kept:
                pybullet.removeBody(uid, physicsClientId=self.client)

    def overlap(self, body: Body, tolerance: float) -> Optional[int]:
        """PyBullet's number of another body in which `body` stands, deeper than `tolerance` (m)."""
        for other in sorted(neighbours(self.client, body.uid) - {body.uid}):
            points = pybullet.getClosestPoints(body.uid, other, 0.0, physicsClientId=self.client)
            if any(point[8] < -tolerance for point in points):
                return other
        return None

    def step(self) -> None:
        """Advance by one step."""
        pybullet.stepSimulation(physicsClientId=self.client)


def _normalise_axes(root: ElementTree.Element) -> None:
    """Make the joints' axes unit vectors: PyBullet would move a joint by the length of its axis."""
    for joint in root.findall("joint"):
        axis = joint.find("axis")
        if axis is None or joint.get("type") == "fixed":
            continue
        values = vector(axis, "xyz", f"joint '{joint.get('name')}'", (1.0, 0.0, 0.0))
        length = math.sqrt(sum(value * value for value in values))
        if length and abs(length - 1.0) > _UNIT:
            axis.set("xyz", " ".join(repr(value / length) for value in values))


def _use_local_meshes(
    root: ElementTree.Element, resolve: Callable[[str], str], folder: Path
) -> None:
    """Name the meshes by paths, of copies in `folder` where PyBullet would read another shape."""
    try:
        for mesh in root.iter("mesh"):
            mesh.set("filename", resolve(mesh.get("filename", "")))
        for number, mesh in enumerate(root.iterfind("link/collision/geometry/mesh")):
            content = rewritten(Path(mesh.get("filename", "")))
            if content is not None:
                copy = folder / f"{number}.stl"
                copy.write_bytes(content)
                mesh.set("filename", str(copy))
    except ValueError as error:
        raise WorldError(f"robot_description: {error}") from error


def _drop_visuals(root: ElementTree.Element) -> None:
    for link in root.findall("link"):
        for visual in link.findall("visual"):
            link.remove(visual)
