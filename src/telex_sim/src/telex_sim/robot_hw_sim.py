"""The simulated robot behind `hardware_interface.RobotHW`.

Drives are simulated in joint space, as Gazebo's default hardware does: effort joints by torque,
velocity joints by a velocity motor as strong as the URDF's effort limit. Beyond that, every drive
has the dry and the viscous friction of the URDF (``<dynamics>``), and a brake. The brake holds
whatever no running controller has claimed, so that the arm does not fall before its controllers
start or after they end; an emergency stop sets all brakes, whatever the controllers ask for.
"""

from __future__ import annotations

import dataclasses
import math
from typing import Dict, List, Optional, Set
from xml.etree import ElementTree

import pybullet

from telex_control.hardware_interface import (
    ControllerInfo,
    EffortJointInterface,
    JointHandle,
    JointStateHandle,
    JointStateInterface,
    RobotHW,
    VelocityJointInterface,
)
from telex_control.joint_limits import joint_limits
from telex_control.joint_limits_interface import (
    EffortJointSaturationHandle,
    JointLimitsHandle,
    VelocityJointSaturationHandle,
)
from telex_control.transmission_parser import driven_joints
from telex_control.urdf_joints import PRISMATIC, UrdfError, UrdfJoint, joints

from .config import HardwareConfig
from .world import Body

_EFFORT = "EffortJointInterface"
_VELOCITY = "VelocityJointInterface"
_BRAKE_POSITION_GAIN = 0.2
_BRAKE_VELOCITY_GAIN = 1.0
_STANDSTILL = 1.0e-6
"""Speed below which a joint rests (rad/s, m/s); PyBullet's solver leaves some noise."""


class _Joint:
    """A driven joint: its description, its handles and its place in PyBullet."""

    __slots__ = ("braked", "description", "handle", "index", "limits", "state", "takes_effort")

    def __init__(self, description: UrdfJoint, takes_effort: bool, tolerance: float) -> None:
        self.description = description
        self.takes_effort = takes_effort
        self.braked = True
        self.state = JointStateHandle(description.name)
        self.handle = JointHandle(self.state)
        self.index = -1
        self.limits: JointLimitsHandle
        limits, _ = joint_limits(description)
        if takes_effort:
            limits = dataclasses.replace(limits, max_velocity=limits.max_velocity * tolerance)
            self.limits = EffortJointSaturationHandle(self.handle, limits)
        else:
            self.limits = VelocityJointSaturationHandle(self.handle, limits)


class RobotHWSim(RobotHW):
    """The joints of a robot in a PyBullet world.

    Parameters
    ----------
    robot : Element
        ``<robot>`` of the URDF; joints with a transmission are driven.
    config : HardwareConfig

    Raises
    ------
    UrdfError
        A transmission names an interface that is not simulated, or a limit is missing.
    """

    def __init__(self, robot: ElementTree.Element, config: HardwareConfig) -> None:
        super().__init__()
        self._config = config
        descriptions = joints(robot)
        self._joints: Dict[str, _Joint] = {}
        states, efforts, velocities = (
            JointStateInterface(),
            EffortJointInterface(),
            VelocityJointInterface(),
        )
        for driven in driven_joints(robot):
            name = driven.joint
            if driven.hardware_interface not in (_EFFORT, _VELOCITY):
                raise UrdfError(
                    f"transmission '{driven.transmission}' asks for "
                    f"'{driven.hardware_interface}'; simulated are {_EFFORT} and {_VELOCITY}"
                )
            if name not in descriptions:
                raise UrdfError(f"transmission '{driven.transmission}': joint '{name}' cannot move")
            takes_effort = driven.hardware_interface == _EFFORT
            try:
                joint = _Joint(descriptions[name], takes_effort, config.velocity_tolerance)
            except ValueError as error:
                raise UrdfError(str(error)) from error
            self._joints[name] = joint
            states.register_handle(joint.state)
            (efforts if takes_effort else velocities).register_handle(joint.handle)
        unknown = sorted(set(config.joints) - set(self._joints) - set(config.optional_joints))
        if unknown:
            raise UrdfError(
                f"parameter hardware/joints/{unknown[0]}: the robot has no driven joint of this "
                "name"
            )
        for interface in (states, efforts, velocities):
            self.register_interface(interface)
        self._all = list(self._joints.values())
        # By controller, so that one that ends takes nothing from the next that has its joint.
        self._claims: Dict[str, Set[str]] = {}
        self._e_stop = False
        self._body: Optional[Body] = None
        self._indices: List[int] = []
        self._driven_by_effort: List[_Joint] = []
        self._driven_by_velocity: List[_Joint] = []

    @property
    def e_stop(self) -> bool:
        """Whether the emergency stop holds all joints."""
        return self._e_stop

    def has_joint(self, name: str) -> bool:
        """Whether the robot has a driven joint of this name."""
        return name in self._joints

    def joint_state(self, name: str) -> JointStateHandle:
        """State handle of a driven joint.

        Raises
        ------
        KeyError
            No such joint.
        """
        return self._joints[name].state

    def joint_positions(self) -> Dict[str, float]:
        """Measured position of every driven joint (rad, m)."""
        return {name: joint.state.position for name, joint in self._joints.items()}

    def attach(self, body: Body) -> None:
        """Take over the joints of `body`, which stands for this robot in a new world."""
        self._body = body
        missing = sorted(set(self._joints) - set(body.joints))
        if missing:
            raise UrdfError(f"joint '{missing[0]}' has a transmission but is not in the world")
        for name, joint in self._joints.items():
            joint.index = body.joints[name]
            joint.handle.command = 0.0
            joint.limits.reset()
            self._add_armature(joint)
        self._indices = [joint.index for joint in self._all]
        self.read(0.0, 0.0)
        self._set_brakes()

    def _add_armature(self, joint: _Joint) -> None:
        """Add the drive's inertia to its link.

        Isotropic, because PyBullet drops an inertia that no mass distribution can have; the small
        excess about the other axes is carried by the neighbours' structure.
        """
        hardware = self._config.joints.get(joint.description.name)
        assert self._body is not None
        if hardware is None or not hardware.armature or joint.description.kind == PRISMATIC:
            return
        uid, client = self._body.uid, self._body.client
        inertia = pybullet.getDynamicsInfo(uid, joint.index, physicsClientId=client)[2]
        pybullet.changeDynamics(
            uid,
            joint.index,
            localInertiaDiagonal=[value + hardware.armature for value in inertia],
            physicsClientId=client,
        )

    # --- RobotHW -----------------------------------------------------------------------------

    def read(self, time: float, period: float) -> None:
        """Fill the state handles.

        The effort is what was last applied: to a joint driven by effort its limited command, to
        one that a velocity motor or the brake moves that motor's force.
        """
        body = self._body
        assert body is not None
        states = pybullet.getJointStates(body.uid, self._indices, physicsClientId=body.client)
        for joint, state in zip(self._all, states):
            handle = joint.state
            handle.position = state[0]
            handle.velocity = state[1]
            applied = joint.takes_effort and not joint.braked
            handle.effort = joint.handle.command if applied else state[3]

    def write(self, time: float, period: float) -> None:
        """Limit the commands and give them to PyBullet; its torques act for one step only."""
        body = self._body
        assert body is not None
        efforts = self._driven_by_effort
        if efforts:
            for joint in efforts:
                joint.limits.enforce(period)
            pybullet.setJointMotorControlArray(
                body.uid,
                self._effort_indices,
                pybullet.TORQUE_CONTROL,
                forces=[joint.handle.command for joint in efforts],
                physicsClientId=body.client,
            )
            self._resist(efforts)
        velocities = self._driven_by_velocity
        if velocities:
            for joint in velocities:
                joint.limits.enforce(period)
            pybullet.setJointMotorControlArray(
                body.uid,
                self._velocity_indices,
                pybullet.TORQUE_CONTROL,
                forces=[_drag(joint) for joint in velocities],
                physicsClientId=body.client,
            )
            pybullet.setJointMotorControlArray(
                body.uid,
                self._velocity_indices,
                pybullet.VELOCITY_CONTROL,
                targetVelocities=[joint.handle.command for joint in velocities],
                forces=self._velocity_forces,
                physicsClientId=body.client,
            )

    def do_switch(self, start: List[ControllerInfo], stop: List[ControllerInfo]) -> None:
        """Set the brakes of joints that lose their controller, release those that get one."""
        for controller in stop:
            self._claims.pop(controller.name, None)
        for controller in start:
            self._claims[controller.name] = {
                resource for claim in controller.claimed_resources for resource in claim.resources
            }
        self._set_brakes()

    def set_e_stop(self, active: bool) -> None:
        """Set all brakes, or give the joints back to their controllers."""
        if active != self._e_stop:
            self._e_stop = active
            self._set_brakes()

    def _set_brakes(self) -> None:
        if self._body is None:
            return
        claimed: Set[str] = set().union(*self._claims.values())
        for joint in self._all:
            braked = self._e_stop or joint.description.name not in claimed
            if braked and not joint.braked:
                joint.handle.command = 0.0
            joint.braked = braked
        driven = [joint for joint in self._all if not joint.braked]
        self._driven_by_effort = [joint for joint in driven if joint.takes_effort]
        self._driven_by_velocity = [joint for joint in driven if not joint.takes_effort]
        # What `write` needs in every step, made once.
        self._effort_indices = [joint.index for joint in self._driven_by_effort]
        self._velocity_indices = [joint.index for joint in self._driven_by_velocity]
        self._standstill = [0.0] * len(self._driven_by_effort)
        self._velocity_forces = [_finite(j.description.effort) for j in self._driven_by_velocity]
        self._hold([joint for joint in self._all if joint.braked])

    def _resist(self, joints: List[_Joint]) -> None:
        """Let the friction of effort drives act, as a motor that wants standstill.

        A motor is part of the constraint solver: it never turns a joint back, whatever its force.
        As a torque, or as PyBullet's own joint damping, a large friction would be unstable.
        """
        assert self._body is not None
        pybullet.setJointMotorControlArray(
            self._body.uid,
            self._effort_indices,
            pybullet.VELOCITY_CONTROL,
            targetVelocities=self._standstill,
            forces=[_resistance(joint) for joint in joints],
            physicsClientId=self._body.client,
        )

    def _hold(self, held: List[_Joint]) -> None:
        if not held:
            return
        assert self._body is not None
        pybullet.setJointMotorControlArray(
            self._body.uid,
            [joint.index for joint in held],
            pybullet.POSITION_CONTROL,
            targetPositions=[joint.state.position for joint in held],
            forces=[_finite(joint.description.effort) for joint in held],
            positionGains=[_BRAKE_POSITION_GAIN] * len(held),
            velocityGains=[_BRAKE_VELOCITY_GAIN] * len(held),
            physicsClientId=self._body.client,
        )


def _resistance(joint: _Joint) -> float:
    """Amount of dry and viscous friction in the joint's drive (Nm, N)."""
    return joint.description.friction + joint.description.damping * abs(joint.state.velocity)


def _drag(joint: _Joint) -> float:
    """Friction in the drive of a joint that moves, against its motion (Nm, N)."""
    velocity = joint.state.velocity
    if abs(velocity) < _STANDSTILL:
        return 0.0
    return -math.copysign(_resistance(joint), velocity)


def _finite(effort: float) -> float:
    """A motor's largest force; PyBullet takes no infinity."""
    return effort if math.isfinite(effort) else 1.0e6
