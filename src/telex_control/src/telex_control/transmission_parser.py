"""The ``<transmission>`` elements of a URDF, after ros_control's transmission_parser and loaders.

As upstream, a transmission that cannot be read is left out with an error in the log: a robot with
one bad element keeps its other joints.
"""

from __future__ import annotations

import logging
import math
from dataclasses import dataclass
from typing import Dict, List, Optional, Tuple
from xml.etree import ElementTree

from .transmission_interface import (
    DifferentialTransmission,
    SimpleTransmission,
    Transmission,
    TransmissionError,
)
from .urdf_joints import UrdfError

SIMPLE = "transmission_interface/SimpleTransmission"
DIFFERENTIAL = "transmission_interface/DifferentialTransmission"
_PREFIX = "hardware_interface/"

_log = logging.getLogger("rosout")


@dataclass(frozen=True)
class TransmissionJoint:
    """A joint of a transmission, as the URDF describes it.

    Attributes
    ----------
    hardware_interfaces : tuple of str
        Through which it is commanded, as written.
    role : str
        Which of several joints it is (``joint1``, ``joint2``).
    mechanical_reduction, offset : float or None
        (rad, m)
    """

    name: str
    hardware_interfaces: Tuple[str, ...]
    role: str = ""
    mechanical_reduction: Optional[float] = None
    offset: Optional[float] = None


@dataclass(frozen=True)
class TransmissionActuator:
    """An actuator of a transmission, as the URDF describes it."""

    name: str
    hardware_interfaces: Tuple[str, ...] = ()
    role: str = ""
    mechanical_reduction: Optional[float] = None


@dataclass(frozen=True)
class TransmissionInfo:
    """One ``<transmission>``."""

    name: str
    type: str
    joints: Tuple[TransmissionJoint, ...]
    actuators: Tuple[TransmissionActuator, ...]


@dataclass(frozen=True)
class DrivenJoint:
    """A joint that a transmission drives, in joint space.

    Attributes
    ----------
    joint, transmission : str
    hardware_interface : str
        Without the prefix ``hardware_interface/``.
    """

    joint: str
    transmission: str
    hardware_interface: str


def transmissions(robot: ElementTree.Element) -> List[TransmissionInfo]:
    """Return the transmissions of a ``<robot>`` element, in the order of the file."""
    found = []
    for element in robot.findall("transmission"):
        try:
            found.append(_transmission(element))
        except TransmissionError as error:
            _log.error("transmission '%s' is left out: %s", element.get("name", ""), error)
    return found


def _transmission(element: ElementTree.Element) -> TransmissionInfo:
    name = element.get("name", "")
    if not name:
        raise TransmissionError("it has no name")
    type_name = _text(element, "type")
    if not type_name:
        raise TransmissionError("it has no <type>")
    actuators = tuple(_actuator(each) for each in element.findall("actuator"))
    # Older descriptions name the interface at the actuator.
    fallback = next((a.hardware_interfaces for a in actuators if a.hardware_interfaces), ())
    joints = tuple(_joint(each, fallback) for each in element.findall("joint"))
    if not joints:
        raise TransmissionError("it has no <joint>")
    if not actuators:
        raise TransmissionError("it has no <actuator>")
    return TransmissionInfo(name, type_name, joints, actuators)


def _joint(element: ElementTree.Element, fallback: Tuple[str, ...]) -> TransmissionJoint:
    name = element.get("name", "")
    if not name:
        raise TransmissionError("a <joint> has no name")
    interfaces = _interfaces(element)
    if not interfaces and fallback:
        _log.warning(
            "joint '%s': its <hardwareInterface> stands in the <actuator>; it belongs into the "
            "<joint> of the transmission",
            name,
        )
        interfaces = fallback
    if not interfaces:
        raise TransmissionError(f"joint '{name}' has no <hardwareInterface>")
    return TransmissionJoint(
        name,
        interfaces,
        _text(element, "role"),
        _number(element, "mechanicalReduction", name),
        _number(element, "offset", name),
    )


def _actuator(element: ElementTree.Element) -> TransmissionActuator:
    name = element.get("name", "")
    if not name:
        raise TransmissionError("an <actuator> has no name")
    return TransmissionActuator(
        name,
        _interfaces(element),
        _text(element, "role"),
        _number(element, "mechanicalReduction", name),
    )


def _text(element: ElementTree.Element, tag: str) -> str:
    return (element.findtext(tag) or "").strip()


def _interfaces(element: ElementTree.Element) -> Tuple[str, ...]:
    texts = ((each.text or "").strip() for each in element.findall("hardwareInterface"))
    return tuple(text for text in texts if text)


def _number(element: ElementTree.Element, tag: str, owner: str) -> Optional[float]:
    text = _text(element, tag)
    if not text:
        return None
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise TransmissionError(f"'{owner}': <{tag}>{text}</{tag}> is no finite number")
    return value


def driven_joints(robot: ElementTree.Element) -> List[DrivenJoint]:
    """Return the joints of a ``<robot>`` element that transmissions drive, each once.

    This is how a simulation sees them, which drives joints and not actuators: of each joint its
    first transmission counts, and of that its first interface, whatever the reduction. An interface
    without its prefix ``hardware_interface/`` is taken, with a warning.

    Raises
    ------
    UrdfError
        A transmission drives a joint that the robot does not have.
    """
    known = {element.get("name") for element in robot.findall("joint")}
    found: Dict[str, DrivenJoint] = {}
    for transmission in transmissions(robot):
        for joint in transmission.joints:
            if joint.name not in known:
                raise UrdfError(
                    f"transmission '{transmission.name}' names the joint '{joint.name}', "
                    "which is not there"
                )
            if joint.name in found:
                _log.warning(
                    "joint '%s' has the transmissions '%s' and '%s'; the first one counts",
                    joint.name,
                    found[joint.name].transmission,
                    transmission.name,
                )
                continue
            if len(joint.hardware_interfaces) > 1:
                _log.warning(
                    "joint '%s' of transmission '%s' has several hardware interfaces; the first "
                    "one counts, '%s'",
                    joint.name,
                    transmission.name,
                    joint.hardware_interfaces[0],
                )
            interface = joint.hardware_interfaces[0]
            if interface.startswith(_PREFIX):
                interface = interface[len(_PREFIX) :]
            else:
                _log.warning(
                    "transmission '%s': the hardware interface '%s' is deprecated; write "
                    "'hardware_interface/%s'",
                    transmission.name,
                    interface,
                    interface,
                )
            found[joint.name] = DrivenJoint(joint.name, transmission.name, interface)
    return list(found.values())


def load_transmission(info: TransmissionInfo) -> Transmission:
    """Make the transmission that `info` describes.

    Raises
    ------
    TransmissionError
        Its type is unknown, or its joints, actuators or reductions do not fit the type.
    """
    try:
        if info.type == SIMPLE:
            return _load_simple(info)
        if info.type == DIFFERENTIAL:
            return _load_differential(info)
        raise TransmissionError(
            f"type '{info.type}' is unknown; known are {SIMPLE}, {DIFFERENTIAL}"
        )
    except TransmissionError as error:
        raise TransmissionError(f"transmission '{info.name}': {error}") from None


def _load_simple(info: TransmissionInfo) -> SimpleTransmission:
    _count(info, 1)
    (joint,), (actuator,) = info.joints, info.actuators
    return SimpleTransmission(
        _required(actuator.mechanical_reduction, actuator.name), joint.offset or 0.0
    )


def _load_differential(info: TransmissionInfo) -> DifferentialTransmission:
    _count(info, 2)
    joints = {joint.role: joint for joint in info.joints}
    actuators = {actuator.role: actuator for actuator in info.actuators}
    if set(joints) != {"joint1", "joint2"} or set(actuators) != {"actuator1", "actuator2"}:
        raise TransmissionError(
            f"the roles are {sorted(joints)} and {sorted(actuators)}; joint1, joint2, actuator1 "
            "and actuator2 are needed, as <role> of each <joint> and <actuator>"
        )
    j1, j2 = joints["joint1"], joints["joint2"]
    a1, a2 = actuators["actuator1"], actuators["actuator2"]
    return DifferentialTransmission(
        [_required(each.mechanical_reduction, each.name) for each in (a1, a2)],
        [_required(each.mechanical_reduction, each.name) for each in (j1, j2)],
        [each.offset or 0.0 for each in (j1, j2)],
    )


def _count(info: TransmissionInfo, count: int) -> None:
    if (len(info.joints), len(info.actuators)) != (count, count):
        raise TransmissionError(
            f"it has {len(info.joints)} joints and {len(info.actuators)} actuators; "
            f"{info.type} has {count} of each"
        )


def _required(value: Optional[float], owner: str) -> float:
    if value is None:
        raise TransmissionError(f"'{owner}' has no <mechanicalReduction>")
    return value
