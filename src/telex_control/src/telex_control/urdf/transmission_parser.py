"""The ``<transmission>`` elements of a URDF, after ros_control's transmission_parser.

As upstream, a transmission that cannot be read is left out with an error in the log: a robot with
one bad element keeps its other joints. Reductions, offsets and roles are not read: a simulation
drives joints, not actuators, as Gazebo does.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass
from typing import Dict, List, Tuple, Type, Union

from ..hardware.hardware_interface import (
    EffortJointInterface,
    JointCommandInterface,
    PositionJointInterface,
    VelocityJointInterface,
)
from . import model
from .model import Robot, UrdfError

SIMULATED: Dict[str, Type[JointCommandInterface]] = {
    "EffortJointInterface": EffortJointInterface,
    "VelocityJointInterface": VelocityJointInterface,
    "PositionJointInterface": PositionJointInterface,
}
"""Interfaces through which a simulation's joints are commanded; the first is the usual one."""
_PREFIX = "hardware_interface/"
_STATE = ("JointStateInterface", _PREFIX + "JointStateInterface")
"""What every joint has, and needs not be asked for; one with nothing else is not driven."""

_log = logging.getLogger("rosout")


class TransmissionError(ValueError):
    """A transmission cannot be read; the message names what is wrong."""


@dataclass(frozen=True)
class JointInterfaces:
    """A joint of a transmission, as the URDF describes it.

    Attributes
    ----------
    hardware_interfaces : tuple of str
        Through which it is commanded, as written.
    """

    name: str
    hardware_interfaces: Tuple[str, ...]


@dataclass(frozen=True)
class TransmissionInfo:
    """One ``<transmission>``."""

    name: str
    joints: Tuple[JointInterfaces, ...]


@dataclass(frozen=True)
class DrivenJoint:
    """A joint that a transmission drives, in joint space.

    Attributes
    ----------
    hardware_interface : str
        Without the prefix ``hardware_interface/``.
    """

    joint: str
    transmission: str
    hardware_interface: str


def transmissions(robot: Robot) -> List[TransmissionInfo]:
    """Return the transmissions of a robot, in the order of the file.

    Without those in the style of pr2, which are no transmissions of ros_control.
    """
    found, complaints = _read(robot)
    for level, complaint in complaints:
        _log.log(level, complaint)
    return found


def interfaces(robot: Robot) -> Dict[str, str]:
    """Return through which interface each joint is driven, of those that are.

    As `driven_joints`, but nothing is logged, and what that refuses is left out.
    """
    found: Dict[str, str] = {}
    for transmission in _read(robot)[0]:
        for joint in transmission.joints:
            for interface in filter(_is_simulated, joint.hardware_interfaces):
                found.setdefault(joint.name, _bare(interface))
    return found


def _read(robot: Robot) -> Tuple[List[TransmissionInfo], List[Tuple[int, str]]]:
    """Transmissions, and what is to be logged of them, with its level."""
    found: List[TransmissionInfo] = []
    complaints: List[Tuple[int, str]] = []
    for element in robot.transmissions:
        if _is_old(element):
            continue
        try:
            found.append(_transmission(element, complaints))
        except TransmissionError as error:
            name = element.name
            complaints.append((logging.ERROR, f"transmission '{name}' is left out: {error}"))
    return found, complaints


def _is_old(element: model.Transmission) -> bool:
    """Whether it is in the style of pr2."""
    return bool(element.style) and not element.type


def _transmission(
    element: model.Transmission, complaints: List[Tuple[int, str]]
) -> TransmissionInfo:
    name = element.name
    if not name:
        raise TransmissionError("it has no name")
    if not element.type:
        raise TransmissionError("it has no <type>")
    actuators = element.actuators
    if not all(each.name for each in actuators):
        raise TransmissionError("an <actuator> has no name")
    # Older descriptions name the interface at the actuator.
    fallback = next(filter(None, map(_interfaces, actuators)), ())
    joints = tuple(_joint(each, fallback, complaints) for each in element.joints)
    if not joints:
        raise TransmissionError("it has no <joint>")
    if not actuators:
        raise TransmissionError("it has no <actuator>")
    return TransmissionInfo(name, joints)


def _joint(
    element: model.TransmissionJoint, fallback: Tuple[str, ...], complaints: List[Tuple[int, str]]
) -> JointInterfaces:
    name = element.name
    if not name:
        raise TransmissionError("a <joint> has no name")
    own = _interfaces(element)
    if not own and fallback:
        complaints.append(
            (
                logging.WARNING,
                f"joint '{name}': its <hardwareInterface> stands in the <actuator>; it belongs "
                "into the <joint> of the transmission",
            )
        )
        own = fallback
    if not own:
        raise TransmissionError(f"joint '{name}' has no <hardwareInterface>")
    return JointInterfaces(name, own)


def _interfaces(element: Union[model.TransmissionJoint, model.Actuator]) -> Tuple[str, ...]:
    return tuple(filter(None, element.hardwareInterfaces))


def _is_simulated(interface: str) -> bool:
    return _bare(interface) in SIMULATED


def driven_joints(robot: Robot) -> List[DrivenJoint]:
    """Return the joints of a robot that transmissions drive, each once.

    This is how a simulation sees them, which drives joints and not actuators: of each joint the
    first interface counts through which it can be commanded here, whatever the reduction. One
    without its prefix ``hardware_interface/`` is taken, with a warning.

    Raises
    ------
    UrdfError
        A transmission drives a joint that the robot does not have, or a joint has transmissions
        with interfaces by which it is commanded, and none of them is simulated.
    """
    return driven_and_watched(robot)[0]


def driven_and_watched(robot: Robot) -> Tuple[List[DrivenJoint], List[str]]:
    """Return `driven_joints`, and the joints of which transmissions want the state alone."""
    driven, watched = [], []
    fixed = {joint.name for joint in robot.joints if joint.type == "fixed"}
    for joint, offered in _offers(robot).items():
        if all(interface in _STATE for _, interface in offered):
            watched.append(joint)
        elif joint in fixed and not any(_is_simulated(interface) for _, interface in offered):
            # As the flange of franka's model: nothing is lost.
            _log.warning("transmission '%s': '%s' is not simulated", *offered[0])
        else:
            driven.append(_driven(joint, offered))
    return driven, watched


def _offers(robot: Robot) -> Dict[str, List[Tuple[str, str]]]:
    """Pairs of transmission and interface, by joint."""
    known = set(robot.joint_map)
    offers: Dict[str, List[Tuple[str, str]]] = {}
    for transmission in transmissions(robot):
        for joint in transmission.joints:
            if joint.name not in known:
                raise UrdfError(
                    f"transmission '{transmission.name}' names the joint '{joint.name}', "
                    "which is not there"
                )
            offered = [(transmission.name, each) for each in joint.hardware_interfaces]
            offers.setdefault(joint.name, []).extend(offered)
    for element in filter(_is_old, robot.transmissions):
        # Its joints are elements of several names, and have no interface.
        name, kind = element.name, element.style
        joints = sorted(known & element.named)
        if all(joint in offers for joint in joints):
            _log.error("transmission '%s' is left out: its style is pr2's, type='%s'", name, kind)
        offers.update((joint, [(name, kind)]) for joint in joints if joint not in offers)
    return offers


def _driven(joint: str, offered: List[Tuple[str, str]]) -> DrivenJoint:
    """Choose from the pairs of transmission and interface that a joint is offered."""
    found = [(name, each) for name, each in offered if _is_simulated(each)]
    other = [pair for pair in offered if pair not in found and pair[1] not in _STATE]
    if not found:
        name, interface = other[0]
        raise UrdfError(
            f"transmission '{name}' has '{interface}' for joint '{joint}'; simulated are "
            f'{", ".join(SIMULATED)}: write <transmission name="{name}">'
            "<type>transmission_interface/SimpleTransmission</type>"
            f'<joint name="{joint}"><hardwareInterface>{_PREFIX}{next(iter(SIMULATED))}'
            f'</hardwareInterface></joint><actuator name="{joint}_motor"/></transmission>'
        )
    transmission, interface = found[0]
    for name, each in other:
        _log.warning(
            "transmission '%s': '%s' is not simulated; joint '%s' is driven through '%s'",
            name,
            each,
            joint,
            interface,
        )
    more = next((name for name, _ in found if name != transmission), None)
    if more is not None:
        _log.warning(
            "joint '%s' has the transmissions '%s' and '%s'; the first one counts",
            joint,
            transmission,
            more,
        )
    if sum(name == transmission for name, _ in found) > 1:
        _log.warning(
            "joint '%s' of transmission '%s' has several hardware interfaces; the first one "
            "counts, '%s'",
            joint,
            transmission,
            interface,
        )
    if not interface.startswith(_PREFIX):
        _log.warning(
            "transmission '%s': the hardware interface '%s' is deprecated; write "
            "'hardware_interface/%s'",
            transmission,
            interface,
            interface,
        )
    return DrivenJoint(joint, transmission, _bare(interface))


def _bare(interface: str) -> str:
    return interface[len(_PREFIX) :] if interface.startswith(_PREFIX) else interface
