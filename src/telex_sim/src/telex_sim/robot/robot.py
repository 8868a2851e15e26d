"""One robot in a simulation: its body, hardware, controllers and tracks, without ROS.

One thread, the simulation's, owns a `Robot`; only `request_e_stop` may be called from others.
"""

from __future__ import annotations

import logging
from typing import Any, Callable, Dict, Mapping, Optional, Sequence, Tuple

import pybullet

from telex_control.common.params import ConfigError
from telex_control.common.stateful import Stateful
from telex_control.manager.controller_manager import ControllerManager
from telex_control.ros.node_handle import NodeHandle
from telex_control.urdf.checks import check_bodies, check_links
from telex_control.urdf.joints import CONTINUOUS, joints
from telex_control.urdf.model import Robot as DescribedRobot
from telex_control.urdf.model import read_xml, robot_of

from ..engine.simulator_config import RobotConfig
from ..engine.world import Body, World
from ..malfunctions.malfunctions import Malfunctions
from ..proximity.monitor import ProximityMonitor
from ..scene.model import Start
from ..tracks.tracks import Tracks, surface_under
from ..truth.ledger import ContactLedger
from .body import RobotBody
from .drives import DriveMode
from .gripper.contact import GripperContacts
from .robot_hw_sim import RobotHWSim
from .urdf.masses import complete_masses

_log = logging.getLogger("rosout")


class Robot:
    """A robot that can be placed in a world.

    What can be wrong with it is found here, before a world is touched.

    Parameters
    ----------
    node : NodeHandle
        Its namespace, for the hardware and the controllers.
    resolve : callable
        Turns a mesh address (``package://…``) into a path.
    step_size : float
        Sim time of one step (s).
    asked_pose : str
        Named pose that the scene asks for; empty for none.

    Attributes
    ----------
    namespace : str
        Full name, without a slash at its end.
    figure : RobotBody
        What of it becomes a body.
    links : tuple of str
        Names of those of its description.
    equipment : tuple of str
        Names of what of `EquipmentConfig` it has.
    has_pads : bool
        Whether it has a gripper whose contacts are told.
    body : Body
        Once it is placed.
    proximity : ProximityMonitor
        Once it is placed.
    gripper_contacts : GripperContacts, optional
        Once it is placed; None without gripper.
    ledger : ContactLedger, optional
        Sums its contacts; None: nobody wants them.
    held : tuple of int
        Bodies of what its gripper holds, for the ledger.
    malfunctions : Malfunctions
        What of it does not work.
    tracks : Tracks
        Once it is placed.
    watchers : tuple of Stateful
        What looks at it from outside, and remembers what it saw.
    starts : int
        How often it was put where it begins.

    Raises
    ------
    ConfigError, UrdfError
        With a message for a person.
    """

    body: Body
    proximity: ProximityMonitor
    tracks: Tracks
    gripper_contacts: Optional[GripperContacts]
    ledger: Optional[ContactLedger] = None
    held: Tuple[int, ...] = ()
    watchers: Tuple[Stateful, ...] = ()
    starts: int = 0

    def __init__(
        self,
        config: RobotConfig,
        urdf: str,
        node: NodeHandle,
        resolve: Callable[[str], str],
        step_size: float,
        asked_pose: str = "",
    ) -> None:
        self.config = config
        self.namespace = node.namespace
        self._node = node
        self.figure = RobotBody.of(urdf, config, node.namespace)
        self._resolve = resolve
        self._step_size = step_size
        try:
            self._make(urdf, node, asked_pose)
        except Exception:
            node.shutdown()
            raise

    @property
    def model(self) -> str:
        """Name in the scene; its frames are ``<model>/<link>``."""
        return self.figure.model

    @property
    def urdf(self) -> str:
        """Its description."""
        return self.figure.urdf

    def _make(self, urdf: str, node: NodeHandle, asked_pose: str) -> None:
        config = self.config
        root = read_xml(urdf)
        robot = robot_of(root)
        check_links(robot)
        check_bodies(robot)
        for remark in complete_masses(root, config.fixed_base).remarks:
            _log.warning("%s: %s", self.model, remark)
        self.hw = RobotHWSim(robot, config.hardware, config.tracks.belts)
        self.hw.init(node, node)
        self.controllers = ControllerManager(self.hw, node)
        self._check_belts(robot)
        self._positions = self.figure.start_positions(asked_pose)
        config.proximity.check_joints(list(joints(robot)), config.hardware.optional_joints)
        links = list(robot.link_map)
        config.self_collision.check_links(links)
        self.equipment = config.equipment.present(links)
        self.links = tuple(links)
        self._rolling = [each.child for each in robot.joints if each.type == CONTINUOUS]
        self.has_pads = config.gripper_contact.present(links, config.hardware.optional_links)
        self._check_pads(robot)
        # What was asked for last, and how often a stop was: each one is obeyed for a cycle at
        # least, even if its release follows at once.
        self._e_stop_wanted = False
        self._e_stop_presses = 0
        self._e_stop_obeyed = 0
        self._begins_anew = False
        self.malfunctions = Malfunctions(self)

    def _check_pads(self, robot: DescribedRobot) -> None:
        for name in self.config.gripper_contact.pads:
            if name in robot.link_map and not robot.link_map[name].collisions:
                raise ConfigError(
                    f"gripper_contact/pads: the link '{name}' has no <collision>; a pad needs one "
                    "to touch anything"
                )

    def _check_belts(self, robot: DescribedRobot) -> None:
        carriers = {name: joint.parent for name, joint in robot.joint_map.items()}
        solid = {name for name, link in robot.link_map.items() if link.collisions}
        for joint in self.config.tracks.belts:
            if not self.hw.has_joint(joint):
                raise ConfigError(f"tracks/belts/{joint}: the robot has no driven joint '{joint}'")
            mode = self.hw.drive(joint).mode
            if mode in (DriveMode.POSITION, DriveMode.POSITION_PID):
                raise ConfigError(
                    f"tracks/belts/{joint}: its transmission has PositionJointInterface; a belt "
                    "needs VelocityJointInterface or EffortJointInterface"
                )
            if carriers[joint] not in solid:
                raise ConfigError(
                    f"tracks/belts/{joint}: the link '{carriers[joint]}', around which it runs, "
                    "has no <collision>; a belt needs one to touch the ground"
                )
        self._check_carriers(carriers)

    def _check_carriers(self, carriers: Mapping[str, str]) -> None:
        """Refuse belts of several drives around one link: contacts could not tell them apart."""
        known: Dict[str, Tuple[str, ...]] = {}
        for belts in self.config.tracks.groups():
            for joint in belts:
                link = carriers[joint]
                others = known.setdefault(link, tuple(belts))
                if joint not in others:
                    raise ConfigError(
                        f"tracks/belts/{joint}: it runs around the link '{link}', as "
                        f"{others[0]} does, and has another drive; a link of its own is needed"
                    )

    def place(
        self, world: World, scene_start: Start, material_of: Callable[[int, int], str]
    ) -> None:
        """Put the robot into `world`, where its configuration or else the scene says.

        Parameters
        ----------
        material_of : callable
            Material of a link (PyBullet's numbers of body and link), for the grip of its tracks.

        Raises
        ------
        WorldError
            PyBullet refuses the URDF.
        """
        config = self.config
        self.malfunctions.forget()
        self.body = self.figure.load(world, scene_start, self._positions, self._resolve)
        self.proximity = ProximityMonitor(self.body, config.proximity, config.self_collision)
        self.hw.attach(self.body)
        self._material_of = material_of
        self._begin()

    def put_back(self) -> None:
        """Begin anew where it was placed; its body is there already."""
        self.malfunctions.forget()
        for joint in self.body.wheels:
            self.body.wheels[joint] = 0.0
        self.hw.restart()
        self.held = ()
        if self.ledger is not None:
            self.ledger.forget()
        self._begin()

    def _begin(self) -> None:
        config = self.config
        self.starts += 1
        self.gripper_contacts = (
            GripperContacts(self.body, config.gripper_contact) if self.has_pads else None
        )
        drives = {joint: self.hw.drive(joint) for joint in config.tracks.belts}
        self.tracks = Tracks(self.body, config.tracks, drives, self._step_size, self._material_of)

    def start_from(self, positions: Dict[str, float]) -> None:
        """Have the joints start from other positions the next time that it is placed."""
        self._positions = positions

    def surface(self) -> str:
        """What its belts run on, without belts what turns without an end; see `surface_under`."""
        body = self.body
        if self.config.tracks.belts:
            return self.tracks.surface()
        links = {body.links[name] for name in self._rolling if name in body.links}
        contacts = pybullet.getContactPoints(body.uid, physicsClientId=body.client)
        under = (each for each in contacts if each[3] in links and each[2] != body.uid)
        return surface_under(under, self._material_of)

    def apply_traction(self) -> None:
        """Apply the forces of its tracks for the next step."""
        contacts = self.tracks.step()
        if self.ledger is not None:
            self._note(self.ledger, contacts)

    def _note(self, ledger: ContactLedger, own: Optional[Sequence[Tuple]]) -> None:
        """Let the ledger sum the contacts of the last step; the tracks have read them already."""
        body = self.body
        if own is None:
            own = pybullet.getContactPoints(body.uid, physicsClientId=body.client)
        held = [
            contact
            for uid in self.held
            for contact in pybullet.getContactPoints(uid, physicsClientId=body.client)
        ]
        ledger.note(own, held, self.held)

    def save_state(self) -> Any:
        """Return the state of all that is its own, but for its body."""
        return (
            self.controllers.save_state(),
            [None if part is None else part.save_state() for part in self._parts()],
            {watcher: watcher.save_state() for watcher in self._watchers()},
        )

    def restore_state(self, saved: Any, time: float, elapsed: float) -> None:
        """Take a state up again; the body is where it was.

        An emergency stop that is set stays so. Where it was set then, and is not now, controllers
        begin anew, and hold the joints where they are.

        Parameters
        ----------
        saved : object
            What `save_state` returned.
        time, elapsed : float
            Sim time of now, and since then (s).
        """
        controllers, parts, watchers = saved
        self.controllers.restore_running(controllers, time)
        for part, state in zip(self._parts(), parts):
            if part is not None:
                part.restore_state(state, elapsed)
        self.controllers.restore_state(controllers, time, elapsed)
        if self.hw.was_stopped(parts[1]) and not self.hw.e_stop:
            self.controllers.restart_running(time)
        for watcher in self._watchers():
            if watcher in watchers:
                watcher.restore_state(watchers[watcher], elapsed)
            elif watcher is self.ledger:
                self.ledger.forget()

    def _parts(self) -> Tuple[Optional[Stateful], ...]:
        """Whatever has a state, beside controllers and watchers, in the order of restoring."""
        return self.malfunctions, self.hw, self.tracks, self.gripper_contacts

    def _watchers(self) -> Tuple[Stateful, ...]:
        return self.watchers if self.ledger is None else (*self.watchers, self.ledger)

    def forget_surfaces(self) -> None:
        """Look at every surface anew, after bodies have come or gone."""
        self.tracks.forget_surfaces()

    @property
    def e_stop_wanted(self) -> bool:
        """Whether the last request was to set the emergency stop."""
        return self._e_stop_wanted

    def request_e_stop(self, active: bool) -> None:
        """Set or release the emergency stop with the next cycle. From any thread."""
        self._e_stop_wanted = active
        if active:
            self._e_stop_presses += 1

    def finger_joints(self) -> Tuple[str, ...]:
        """Driven joints of the gripper's fingers."""
        fingers = self.config.proximity.fingers
        return tuple(joint for joints in fingers for joint in joints if self.hw.has_joint(joint))

    def flippers(self) -> Tuple[str, ...]:
        """Driven joints that lift a belt."""
        lifted = set(self.tracks.carriers())
        indices = self.body.joints
        return tuple(name for name in self.hw.moved_joints() if indices.get(name) in lifted)

    def begin_anew(self) -> None:
        """Let running controllers begin anew with the next cycle: they hold what is measured."""
        self._begins_anew = True

    def obey_e_stop(self) -> bool:
        """Carry out a request; returns whether controllers shall begin anew: it was released."""
        anew, self._begins_anew = self._begins_anew, False
        presses, self._e_stop_obeyed = self._e_stop_obeyed, self._e_stop_presses
        wanted = self._e_stop_wanted or presses != self._e_stop_obeyed
        if wanted == self.hw.e_stop:
            return anew
        self.hw.set_e_stop(wanted)
        return anew or not wanted

    def idle(self, time: float) -> None:
        """What goes on while paused: controllers are switched, and an emergency stop is set."""
        if self.obey_e_stop():
            # Without a cycle of their own, the controllers drop what they were told meanwhile.
            self.controllers.restart_running(time)
        self.controllers.apply_switch(time)

    def close(self) -> None:
        """Let whoever waits for its controllers return, and end what its hardware offers."""
        self.controllers.close()
        self._node.shutdown()
