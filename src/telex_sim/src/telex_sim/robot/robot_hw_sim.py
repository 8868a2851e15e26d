"""The simulated robot behind `hardware_interface.RobotHW`.

Drives are simulated in joint space, as Gazebo's default hardware does; see `drives` for the modes.
Beyond that, every drive has the dry and the viscous friction of the URDF (``<dynamics>``), and a
brake. The brake holds whatever no running controller has claimed, so that an arm does not fall
before its controllers start or after they end; an emergency stop sets all brakes, whatever the
controllers ask for. The drives of belts are simulated in `telex_sim.tracks`.
"""

from __future__ import annotations

import logging
import math
from typing import Any, Collection, Dict, FrozenSet, List, Mapping, Optional, Sequence, Set, Type

import pybullet

from telex_control.common.params import ConfigError
from telex_control.common.stateful import Stateful
from telex_control.hardware.hardware_interface import (
    ControllerInfo,
    EffortJointInterface,
    ImuSensorInterface,
    JointCommandInterface,
    JointStateHandle,
    JointStateInterface,
    RobotHW,
)
from telex_control.hardware.joint_limits import JointLimitsError, joint_limits
from telex_control.laws.pid import Pid
from telex_control.laws.pid_reconfigure import PidSet
from telex_control.ros.node_handle import NodeHandle
from telex_control.urdf.joints import CONTINUOUS, PRISMATIC, UrdfError, UrdfJoint, joints
from telex_control.urdf.model import Robot
from telex_control.urdf.transmission_parser import SIMULATED, DrivenJoint, driven_and_watched

from ..engine.simulator_config import HardwareConfig, JointHardware
from ..engine.world import Body
from .drives import WHOLE, DriveMode, Impairment, JointDrive, resistance
from .imu import Imu
from .link_surfaces import LinkSurfaces
from .urdf.masses import massless_joints

PID_GAINS = ("pid_gains", "gazebo_ros_control/pid_gains")
"""Where the gains of position and velocity joints stand in the robot's namespace; the first counts.
"""
_LIMITS = "joint_limits"
_BRAKE_POSITION_GAIN = 0.2
_BRAKE_VELOCITY_GAIN = 1.0
_GEAR_ERP = 0.2
"""Share of a follower's error that is corrected in a step."""
_NO_RATIO = 1.0e-9
"""Of a follower that stands still: PyBullet takes 0 for 1."""
_GEAR_FORCE = 1.0e5
"""N, N m; more than any drive has: what gives way is the drive."""

_log = logging.getLogger("rosout")


class RobotHWSim(RobotHW, Stateful):
    """The joints and sensors of a robot in a PyBullet world.

    Parameters
    ----------
    robot : Robot
        As `telex_control.urdf.joints.parse_urdf` reads it; joints with a transmission are driven.
    belts : collection of str
        Driven joints that the tracks move, and whose states they fill.
    """

    SAVED_PARTS = ("_all", "_followers", "imus")

    def __init__(self, robot: Robot, config: HardwareConfig, belts: Collection[str] = ()) -> None:
        super().__init__()
        self._config = config
        self._belts = frozenset(belts)
        self._robot = robot
        self._joints: Dict[str, JointDrive] = {}
        self._all: List[JointDrive] = []
        # Without the belts: what PyBullet's motors move.
        self._moved: List[JointDrive] = []
        # Movable joints that nothing drives; they have friction.
        self._passive: List[UrdfJoint] = []
        # Of those, the ones whose states are told: they follow others, or a transmission asks it.
        self._watched: Dict[str, JointStateHandle] = {}
        # Of those that nothing drives, the ones with damping, by PyBullet's index.
        self._damped: Dict[int, UrdfJoint] = {}
        self.imus: List[Imu] = []
        # By controller, so that one that ends takes nothing from the next that has its joint.
        self._claims: Dict[str, Set[str]] = {}
        self._e_stop = False
        self._powered = True
        self._dead: FrozenSet[str] = frozenset()
        self._body: Optional[Body] = None
        self._indices: List[int] = []
        # Of a state that was restored: what PyBullet has until the next step is of another.
        self._efforts: Optional[List[float]] = None
        self._choose_driven()

    def init(self, root: NodeHandle, hw: NodeHandle) -> None:
        """Make the joints and sensors.

        Parameters
        ----------
        root : NodeHandle
            The robot's namespace, with the optional parameters ``joint_limits/<joint>`` and
            ``pid_gains/<joint>``; the latter turn a position or velocity joint's motor into a
            PID loop. Without them there is nothing to complain about.
        hw : NodeHandle
            Not used.

        Raises
        ------
        UrdfError
            A joint has transmissions and none that is simulated, or a limit is wrong.
        ConfigError
            A parameter is wrong, or names what the robot does not have.
        """
        described = joints(self._robot)
        self._pids = PidSet(root)
        limits = root.find_param(_LIMITS, {})
        if not isinstance(limits, Mapping):
            raise ConfigError(
                f"parameter {root.resolve(_LIMITS)} is {limits!r}; a struct is needed"
            )
        driven, watched = driven_and_watched(self._robot)
        for each in driven:
            self._joints[each.joint] = self._drive(each, described, limits, root)
        self._warn_of_massless(described)
        self._passive = [joint for name, joint in described.items() if name not in self._joints]
        self._couple(described)
        self._watch([name for name in watched if name in described])
        self._surfaces = LinkSurfaces(self._robot, self._config)
        self.imus = [
            Imu(name, link, self._config.imu_noise.get(name), root.namespace)
            for name, link in self._config.imus.items()
        ]
        self._check_names(described, limits, root)
        self._all = list(self._joints.values())
        self._moved = [drive for name, drive in self._joints.items() if name not in self._belts]
        if not self._all:
            _log.warning("the robot has no <transmission>: there is no joint to control")
        self._register()

    def _drive(
        self,
        driven: DrivenJoint,
        described: Dict[str, UrdfJoint],
        params: Mapping[str, Any],
        root: NodeHandle,
    ) -> JointDrive:
        interface = SIMULATED[driven.hardware_interface]
        if driven.joint not in described:
            raise UrdfError(
                f"transmission '{driven.transmission}': joint '{driven.joint}' cannot move"
            )
        joint = described[driven.joint]
        try:
            limits, soft = joint_limits(joint, params, root.resolve(_LIMITS))
            pid = None if interface is EffortJointInterface else self._pid(joint.name, root)
            tolerance = self._config.velocity_tolerance
            overtravel = self._hardware(joint.name).overtravel
            return JointDrive(joint, interface, limits, soft, tolerance, pid, overtravel)
        except JointLimitsError as error:
            raise UrdfError(str(error)) from error

    def _couple(self, described: Dict[str, UrdfJoint]) -> None:
        for name, joint in described.items():
            if joint.mimic is None:
                continue
            if joint.mimic.joint in self._belts:
                raise UrdfError(f"joint '{name}' mimics '{joint.mimic.joint}', which drives a belt")
            if not joint.mimic_limits:
                _log.warning(
                    "joint '%s' mimics '%s', to which its own <limit> leaves no room: it does not "
                    "count",
                    name,
                    joint.mimic.joint,
                )
            self._watched[name] = JointStateHandle(name)

    def _watch(self, names: List[str]) -> None:
        free = [name for name in names if name not in self._watched]
        self._watched.update((name, JointStateHandle(name)) for name in free)
        if free:
            _log.warning(
                "nothing drives %s: the transmissions have the JointStateInterface alone; the "
                "joints move freely",
                ", ".join(f"'{name}'" for name in free),
            )

    def _warn_of_massless(self, described: Dict[str, UrdfJoint]) -> None:
        """Warn of joints whose first command would be infinitely fast, or nearly."""
        massless = massless_joints(self._robot)
        followed = {
            joint.mimic.joint
            for name, joint in described.items()
            if joint.mimic and name not in massless
        }
        for name in massless:
            if name in followed:
                continue
            drive = self._joints.get(name)
            if drive and drive.takes_effort and not self._hardware(name).armature:
                _log.warning(
                    "joint '%s' is driven by effort, and nothing that it moves has a mass: any "
                    "effort throws it from one limit to the other; give its link an <inertial>, "
                    "or the joint a hardware/joints/%s/armature",
                    name,
                    name,
                )

    def _hardware(self, joint: str) -> JointHardware:
        return self._config.joints.get(joint, JointHardware())

    def _pid(self, joint: str, root: NodeHandle) -> Optional[Pid]:
        for place in PID_GAINS:
            name = f"{place}/{joint}"
            if root.find_param(name, None) is not None:
                return self._pids.open(name)
        return None

    def _check_names(
        self, described: Dict[str, UrdfJoint], limits: Mapping[str, Any], root: NodeHandle
    ) -> None:
        config = self._config
        unknown = sorted(set(config.joints) - set(self._joints) - set(config.optional_joints))
        if unknown:
            raise UrdfError(
                f"parameter hardware/joints/{unknown[0]}: the robot has no driven joint of this "
                "name"
            )
        links = self._robot.link_map
        for name, link in config.imus.items():
            if link not in links:
                raise ConfigError(f"hardware/imus/{name} is '{link}'; the robot has no such link")
        for link in config.contacts:
            if link not in links and link not in config.optional_links:
                raise ConfigError(
                    f"hardware/contacts/{link}: the robot has no such link; one that only some "
                    "variants have belongs into hardware/optional_links"
                )
        useless = sorted(set(limits) - set(described) - set(config.optional_joints))
        if useless:
            _log.warning(
                "parameter %s/%s: the robot has no movable joint of this name",
                root.resolve(_LIMITS),
                useless[0],
            )

    def _register(self) -> None:
        states, imus = JointStateInterface(), ImuSensorInterface()
        commands: Dict[Type[JointCommandInterface], JointCommandInterface] = {
            kind: kind() for kind in SIMULATED.values()
        }
        for drive in self._all:
            states.register_handle(drive.state)
            commands[drive.interface].register_handle(drive.handle)
        for state in self._watched.values():
            states.register_handle(state)
        for imu in self.imus:
            imus.register_handle(imu.handle)
        self.register_interface(states)
        for interface in commands.values():
            self.register_interface(interface)
        self.register_interface(imus)

    @property
    def e_stop(self) -> bool:
        """Whether the emergency stop holds all joints."""
        return self._e_stop

    def drive(self, name: str) -> JointDrive:
        """Drive of a joint.

        Raises
        ------
        KeyError
            No such joint.
        """
        return self._joints[name]

    def drives(self) -> List[JointDrive]:
        """All drives."""
        return self._all

    def moved_joints(self) -> List[str]:
        """Driven joints, without those of belts."""
        return [drive.description.name for drive in self._moved]

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
        return {name: drive.state.position for name, drive in self._joints.items()}

    def attach(self, body: Body) -> None:
        """Take over the joints of `body`, which stands for this robot in a new world."""
        self._body = body
        missing = sorted(set(self._joints) - set(body.joints) - set(body.wheels))
        if missing:
            raise UrdfError(f"joint '{missing[0]}' has a transmission but is not in the world")
        for name, drive in self._joints.items():
            if name in body.wheels:
                continue
            drive.index = body.joints[name]
            self._add_armature(drive)
            self._place_stops(drive)
        self._surfaces.apply(body)
        self._indices = [drive.index for drive in self._moved]
        self._indices += [body.joints[name] for name in self._watched]
        self._damped = {
            body.joints[joint.name]: joint for joint in self._passive if joint.damping > 0.0
        }
        self.restart()
        self._loosen(body)
        self._gear(body)

    def restart(self) -> None:
        """Begin anew, at rest where the body is; claims and the emergency stop stay."""
        body = self._body
        assert body is not None
        for imu in self.imus:
            imu.attach(body)
        for belt in self._belts:
            state = self._joints[belt].state
            state.position, state.velocity, state.effort = 0.0, 0.0, 0.0
        # Until the next step PyBullet tells forces of before.
        still = [0.0] * len(self._read_handles())
        self._efforts = still
        self.read(0.0, 0.0)
        self._efforts = still
        for drive in self._all:
            drive.reset()
        self._set_brakes()

    def _add_armature(self, drive: JointDrive) -> None:
        """Add the drive's inertia to its link.

        Isotropic, because PyBullet drops an inertia that no mass distribution can have; the small
        excess about the other axes is carried by the neighbours' structure.
        """
        armature = self._hardware(drive.description.name).armature
        assert self._body is not None
        if not armature or drive.description.kind == PRISMATIC:
            return
        uid, client = self._body.uid, self._body.client
        inertia = pybullet.getDynamicsInfo(uid, drive.index, physicsClientId=client)[2]
        pybullet.changeDynamics(
            uid,
            drive.index,
            localInertiaDiagonal=[value + armature for value in inertia],
            physicsClientId=client,
        )

    def _place_stops(self, drive: JointDrive) -> None:
        """Let the joint move as far beyond the URDF's limits as its end stops lie."""
        description = drive.description
        overtravel = self._hardware(description.name).overtravel
        assert self._body is not None
        if overtravel and description.kind != CONTINUOUS:
            pybullet.changeDynamics(
                self._body.uid,
                drive.index,
                jointLowerLimit=description.lower - overtravel,
                jointUpperLimit=description.upper + overtravel,
                physicsClientId=self._body.client,
            )

    def _loosen(self, body: Body) -> None:
        """Let joints without a drive move: PyBullet gives each a motor that brakes it."""
        for joint in self._passive:
            pybullet.setJointMotorControl2(
                body.uid,
                body.joints[joint.name],
                pybullet.VELOCITY_CONTROL,
                targetVelocity=0.0,
                force=joint.friction,
                physicsClientId=body.client,
            )

    def _gear(self, body: Body) -> None:
        """Let joints follow others, by a gear: what holds one of them holds both."""
        client = body.client
        for joint in self._passive:
            mimic = joint.mimic
            if mimic is None:
                continue
            index = body.joints[joint.name]
            gear = pybullet.createConstraint(
                body.uid,
                index,
                body.uid,
                body.joints[mimic.joint],
                pybullet.JOINT_GEAR,
                (0.0, 0.0, 1.0),
                (0.0, 0.0, 0.0),
                (0.0, 0.0, 0.0),
                physicsClientId=client,
            )
            pybullet.changeConstraint(
                gear,
                gearRatio=-(mimic.multiplier or _NO_RATIO),
                relativePositionTarget=mimic.offset,
                erp=_GEAR_ERP,
                maxForce=_GEAR_FORCE,
                physicsClientId=client,
            )
            if math.isfinite(joint.upper - joint.lower):
                overtravel = abs(mimic.multiplier) * self._hardware(mimic.joint).overtravel
                pybullet.changeDynamics(
                    body.uid,
                    index,
                    jointLowerLimit=joint.lower - overtravel,
                    jointUpperLimit=joint.upper + overtravel,
                    physicsClientId=client,
                )

    # --- RobotHW -----------------------------------------------------------------------------

    def read(self, time: float, period: float) -> None:
        """Fill the state handles, those of watched joints that nothing drives too.

        The effort is what was last applied: to a joint driven by effort its limited command, to
        one that a motor or the brake moves that motor's force. Positions of joints that turn
        without end grow from turn to turn. Those of belts the tracks have filled.
        """
        body = self._body
        assert body is not None
        states: Sequence[Any] = ()
        if self._indices:  # of none, PyBullet returns None
            states = pybullet.getJointStates(body.uid, self._indices, physicsClientId=body.client)
        for drive, state in zip(self._moved, states):
            handle = drive.state
            handle.position = state[0]
            handle.velocity = state[1]
            handle.effort = drive.force if drive.takes_effort and not drive.braked else state[3]
        for handle, state in zip(self._watched.values(), states[len(self._moved) :]):
            handle.position, handle.velocity, handle.effort = state[0], state[1], state[3]
        if self._efforts is not None:
            for handle, effort in zip(self._read_handles(), self._efforts):
                handle.effort = effort
            self._efforts = None
        for imu in self.imus:
            imu.read(period)

    def write(self, time: float, period: float) -> None:
        """Limit the commands and give them to PyBullet; its torques act for one step only."""
        for handle in self._limits:
            handle.enforce(period)
        for drive in self._unmoved_by_effort:
            drive.effort(period)
        if self._by_effort:
            self._write_efforts(period)
        if self._by_effort or self._unmoved_by_effort:
            self._pids.publish(time)
        if self._by_motor:
            self._control(
                self._motor_indices,
                pybullet.TORQUE_CONTROL,
                forces=[drive.drag() for drive in self._by_motor],
            )
        if self._by_velocity:
            self._control(
                self._velocity_indices,
                pybullet.VELOCITY_CONTROL,
                targetVelocities=[drive.handle.command for drive in self._by_velocity],
                forces=self._velocity_forces,
            )
        if self._by_position:
            self._write_positions(period)
        if self._damped:
            self._write_damping()

    def _write_efforts(self, period: float) -> None:
        """Apply efforts, and let the friction of their drives act as motors that want standstill.

        A motor is part of the constraint solver: it never turns a joint back, whatever its force.
        As a torque, or as PyBullet's own joint damping, a large friction would be unstable.
        """
        drives, indices = self._by_effort, self._effort_indices
        self._control(
            indices, pybullet.TORQUE_CONTROL, forces=[drive.effort(period) for drive in drives]
        )
        self._control(
            indices,
            pybullet.VELOCITY_CONTROL,
            targetVelocities=self._standstill,
            forces=[drive.resistance() for drive in drives],
        )

    def _write_damping(self) -> None:
        """Let the motors that brake joints without a drive grow with their velocities."""
        body = self._body
        assert body is not None
        indices = list(self._damped)
        states = pybullet.getJointStates(body.uid, indices, physicsClientId=body.client)
        self._control(
            indices,
            pybullet.VELOCITY_CONTROL,
            targetVelocities=[0.0] * len(indices),
            forces=[
                resistance(joint, state[1]) for joint, state in zip(self._damped.values(), states)
            ],
        )

    def _write_positions(self, period: float) -> None:
        """Move position motors, which look at the joint in every step, whenever it is read."""
        body = self._body
        assert body is not None
        for drive in self._by_position:
            # One by one, because the call for many does not bound the velocity.
            pybullet.setJointMotorControl2(
                body.uid,
                drive.index,
                pybullet.POSITION_CONTROL,
                targetPosition=drive.handle.command,
                targetVelocity=drive.reference_velocity(period),
                force=drive.motor_force,
                positionGain=self._config.position_gain,
                velocityGain=1.0,
                maxVelocity=drive.motor_velocity,
                physicsClientId=body.client,
            )

    def _control(self, indices: List[int], mode: int, **values: List[float]) -> None:
        body = self._body
        assert body is not None
        pybullet.setJointMotorControlArray(
            body.uid, indices, mode, physicsClientId=body.client, **values
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

    def set_dead(self, joints: Collection[str]) -> None:
        """Say which drives are dead: their brakes hold them, whatever is commanded.

        Parameters
        ----------
        joints : collection of str
            Names; those that the robot does not drive are left out.
        """
        dead = frozenset(joints)
        if dead != self._dead:
            self._dead = dead
            self._set_brakes()

    def set_e_stop(self, active: bool) -> None:
        """Set all brakes, or give the joints back to their controllers."""
        if active != self._e_stop:
            self._e_stop = active
            self._set_brakes()

    def set_power(self, on: bool) -> None:
        """Feed the drives, or let their brakes hold: these set by themselves without power."""
        if on != self._powered:
            self._powered = on
            self._set_brakes()

    def impair(self, joint: str, impairment: Impairment) -> None:
        """Let the drive of a joint work as far as an impairment allows.

        Raises
        ------
        KeyError
            There is no such joint.
        """
        self._joints[joint].impair(impairment)
        self._set_brakes()

    def mend(self) -> None:
        """Let all work, before the robot is put into a world."""
        self._powered = True
        for drive in self._all:
            drive.impair(WHOLE)
        for imu in self.imus:
            imu.bias = 0.0

    def _choose_driven(self) -> None:
        """Gather what `write` needs in every step."""
        driven = [drive for drive in self._all if not drive.braked]
        self._limits = [handle for drive in driven for handle in drive.enforced]
        # Belts, which the tracks move, and jammed joints, which nothing does.
        unmoved = [drive for drive in driven if drive.stands or self._is_belt(drive)]
        self._unmoved_by_effort = [drive for drive in unmoved if drive.takes_effort]
        driven = [drive for drive in driven if drive not in unmoved]
        self._by_effort = [drive for drive in driven if drive.takes_effort]
        self._by_motor = [drive for drive in driven if not drive.takes_effort]
        self._by_velocity = [drive for drive in driven if drive.mode is DriveMode.VELOCITY]
        self._by_position = [drive for drive in driven if drive.mode is DriveMode.POSITION]
        self._effort_indices = [drive.index for drive in self._by_effort]
        self._motor_indices = [drive.index for drive in self._by_motor]
        self._velocity_indices = [drive.index for drive in self._by_velocity]
        self._standstill = [0.0] * len(self._by_effort)
        self._velocity_forces = [drive.motor_force for drive in self._by_velocity]

    def _is_belt(self, drive: JointDrive) -> bool:
        return drive.description.name in self._belts

    @property
    def _followers(self) -> List[JointStateHandle]:
        return list(self._watched.values())

    def _read_handles(self) -> List[JointStateHandle]:
        """Handles that `read` fills, but for those of belts."""
        return [*(drive.state for drive in self._moved), *self._watched.values()]

    def save_state(self) -> Any:
        """Return the present state; see `Stateful.save_state`."""
        return self._e_stop, super().save_state()

    def restore_state(self, saved: Any, elapsed: float) -> None:
        """Take a state up again; see `Stateful.restore_state`.

        What is claimed and the emergency stop stay as they are now, and brakes with them. The body
        is where it was.
        """
        _, state = saved
        super().restore_state(state, elapsed)
        changed = self._brake_unclaimed()
        for drive in changed:
            drive.held = drive.state.position
        self._choose_driven()
        self._hold([drive for drive in self._moved if drive.stands])
        self._efforts = [handle.effort for handle in self._read_handles()]

    def was_stopped(self, saved: Any) -> bool:
        """Whether the emergency stop was set in a state."""
        stopped: bool = saved[0]
        return stopped

    def _set_brakes(self) -> None:
        if self._body is None:
            return
        self._brake_unclaimed()
        self._choose_driven()
        standing = [drive for drive in self._moved if drive.stands]
        for drive in standing:
            drive.held = drive.state.position
        self._hold(standing)

    def _brake_unclaimed(self) -> List[JointDrive]:
        """Set and release brakes; returns the drives whose brakes that has changed."""
        claimed: Set[str] = set().union(*self._claims.values())
        changed = []
        for drive in self._all:
            name = drive.description.name
            dead = not self._powered or name in self._dead
            braked = (self._e_stop or dead or name not in claimed) and not drive.impairment.limp
            if braked != drive.braked:
                drive.reset()
                changed.append(drive)
            drive.braked = braked
        return changed

    def _hold(self, held: List[JointDrive]) -> None:
        slipping = [drive for drive in held if math.isfinite(drive.impairment.slip)]
        held = [drive for drive in held if drive not in slipping]
        if held:
            self._control(
                [drive.index for drive in held],
                pybullet.POSITION_CONTROL,
                targetPositions=[drive.held for drive in held],
                forces=[drive.holding_force for drive in held],
                positionGains=[_BRAKE_POSITION_GAIN] * len(held),
                velocityGains=[_BRAKE_VELOCITY_GAIN] * len(held),
            )
        if slipping:
            # A clutch that has slipped does not come back.
            self._control(
                [drive.index for drive in slipping],
                pybullet.VELOCITY_CONTROL,
                targetVelocities=[0.0] * len(slipping),
                forces=[drive.holding_force for drive in slipping],
            )
