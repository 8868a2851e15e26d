"""The PyBullet world and the robot's body in it.

Only one thread may use a `World`: PyBullet is not safe with more.
"""

from __future__ import annotations

import os
import tempfile
from typing import Callable, Dict, List, Sequence, Tuple
from xml.etree import ElementTree

import pybullet

GRAVITY = 9.81
Vector = Tuple[float, float, float]
Quaternion = Tuple[float, float, float, float]


class WorldError(RuntimeError):
    """The world cannot be made; the message says why."""


class Body:
    """A robot in the world, by the names of its URDF.

    Attributes
    ----------
    client, uid : int
        PyBullet's identifiers.
    joints, links : dict of str to int
        Indices by name; a joint has the index of its child link, the base link is -1.
    parents : dict of str to str
        Parent link of each joint.
    """

    def __init__(self, client: int, uid: int) -> None:
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
        self._link_indices = list(range(len(self.joints)))
        inertial = pybullet.getDynamicsInfo(uid, -1, physicsClientId=client)[3:5]
        # PyBullet places the base by its centre of mass; the URDF by its link frame.
        self._base_from_inertial = pybullet.invertTransform(*inertial)

    def link_names(self) -> List[str]:
        """Names of all links: the base, then the rest in PyBullet's order."""
        return list(self.links)

    def base_pose(self) -> Tuple[Vector, Quaternion]:
        """Pose of the base link's frame in the world."""
        position, orientation = pybullet.getBasePositionAndOrientation(
            self.uid, physicsClientId=self.client
        )
        return pybullet.multiplyTransforms(position, orientation, *self._base_from_inertial)

    def link_poses(self) -> List[float]:
        """Poses of all links in the order of `link_names`: 7 numbers each (m, quaternion xyzw)."""
        position, orientation = self.base_pose()
        poses = [*position, *orientation]
        states = pybullet.getLinkStates(
            self.uid, self._link_indices, computeForwardKinematics=1, physicsClientId=self.client
        )
        for state in states:
            poses.extend(state[4])
            poses.extend(state[5])
        return poses


class World:
    """A PyBullet client with gravity, and the robot in it.

    Parameters
    ----------
    step_size : float
        Sim time of one step (s).
    solver_iterations : int
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
    ) -> Body:
        """Put a robot into the world.

        Parameters
        ----------
        urdf : str
        resolve : callable
            Turns a mesh address (``package://…``) into a path.
        position : sequence of 3 floats
            Of the base link's frame (m).
        yaw : float
            Heading (rad).
        joint_positions : dict
            By joint name (rad, m); 0 for the rest.

        Raises
        ------
        WorldError
            PyBullet refuses the URDF, or a joint of `joint_positions` does not exist.
        """
        client = self.client
        handle, path = tempfile.mkstemp(suffix=".urdf", text=True)
        try:
            with os.fdopen(handle, "w") as file:
                file.write(_with_local_meshes(urdf, resolve))
            uid = pybullet.loadURDF(
                path,
                flags=pybullet.URDF_USE_INERTIA_FROM_FILE | pybullet.URDF_USE_SELF_COLLISION,
                physicsClientId=client,
            )
        except pybullet.error as error:
            raise WorldError(f"PyBullet cannot load robot_description: {error}") from error
        finally:
            os.unlink(path)
        body = Body(client, uid)
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

    def step(self) -> None:
        """Advance by one step."""
        pybullet.stepSimulation(physicsClientId=self.client)


def _with_local_meshes(urdf: str, resolve: Callable[[str], str]) -> str:
    root = ElementTree.fromstring(urdf)
    for mesh in root.iter("mesh"):
        try:
            mesh.set("filename", resolve(mesh.get("filename", "")))
        except ValueError as error:
            raise WorldError(f"robot_description: {error}") from error
    return ElementTree.tostring(root, encoding="unicode")
