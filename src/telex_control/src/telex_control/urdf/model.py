"""Robot descriptions as objects of urdf_parser_py: ``robot.joint_map``, ``link.visuals`` and so on.

The classes are those of `urdf_parser_py.urdf`, with its names, declared anew on its reflection of
XML. By its own declarations it raises where published robots leave something out (a limit's effort,
a moment of inertia), where they have what PyBullet knows besides (capsules), and for the whole
robot where one transmission or one frame that nobody needs is odd; it takes NaN for a number, 0
for a limit that is not given, and writes to stderr of what it does not know. Here

- nothing is required: what is not given is None, a name or a link that is not given is empty,
- numbers are finite floats, and what is none stays the text that it is: `elements.number` and its
  kin refuse it, by name, where the number is needed,
- the first of an element counts that may stand only once, and what URDF does not know is left to
  those who do: the simulation reads its own extensions.

What is refused, and what is said then, is decided in `elements`, `checks`, `joints` and
`transmission_parser`.
"""

from __future__ import annotations

import math
from collections import deque
from typing import Any, Deque, Dict, List, Optional, Set, Union
from xml.etree import ElementTree

from urdf_parser_py import urdf
from urdf_parser_py.xml_reflection import core

_MOST_CHARACTERS = 1_000_000
"""A robot_description that is longer is refused: nothing else runs while it is parsed."""
_MOST_ELEMENTS = 50_000
"""The same of one with more elements, which may be so short that many fit in."""


class UrdfError(ValueError):
    """The robot description cannot be used; the message says what is wrong with which element."""


def as_numbers(text: str, count: int) -> Optional[List[float]]:
    """Return the numbers of an attribute's text, None unless it is so many finite ones."""
    try:
        values = [float(word) for word in text.split()]
    except ValueError:
        return None
    return values if len(values) == count and all(map(math.isfinite, values)) else None


class _Unread:
    """What of an element is still to be read, as the reflection of urdf_parser_py asks for it.

    Of a child that may stand only once, it has the first; what is not known, it does not have.
    """

    def __init__(self, node: ElementTree.Element, known: Dict[str, core.Element]) -> None:
        self.attributes = list(node.attrib)
        # A deque: each child is taken off the front as it is read.
        self.children: Deque[ElementTree.Element] = deque()
        seen: Set[str] = set()
        for child in node:
            element = known.get(child.tag)
            if element is not None and (element.is_aggregate or child.tag not in seen):
                seen.add(child.tag)
                self.children.append(child)


class _Described:
    """An object that reads its element without complaints to stderr."""

    XML_REFL: Any

    def read_xml(self, node: ElementTree.Element, path: core.Path) -> None:
        """Set the attributes from an element."""
        # Given what is to be read, the reflection does not complain of what is left of it.
        self.XML_REFL.set_from_xml(self, node, path, _Unread(node, self.XML_REFL.element_map))


class _Numbers(core.ValueType):
    """Finite numbers with blanks between them: a float, or a list; else the text itself."""

    def __init__(self, count: int) -> None:
        self._count = count

    def from_string(self, text: str) -> Union[str, float, List[float]]:
        values = as_numbers(text, self._count)
        if values is None:
            return text
        return values[0] if self._count == 1 else values


class _AttributeOf(core.ValueType):
    """The one attribute that counts of an element, such as ``<parent link="...">``."""

    def __init__(self, attribute: str, kind: core.ValueType, default: Optional[str] = None) -> None:
        self._attribute, self._kind, self._default = attribute, kind, default

    def from_xml(self, node: ElementTree.Element, path: core.Path) -> Any:
        text = node.get(self._attribute)
        return self._default if text is None else self._kind.from_string(text)


class _Text(core.ValueType):
    """The text of an element, without the blanks around it."""

    def from_xml(self, node: ElementTree.Element, path: core.Path) -> str:
        return (node.text or "").strip()


class _Shape(core.ValueType):
    """The first shape of a ``<geometry>``; None where there is none."""

    def from_xml(self, node: ElementTree.Element, path: core.Path) -> Any:
        child = next(iter(node), None)
        if child is None:
            return None
        kind = _SHAPES.get(child.tag)
        if kind is None:
            return UnknownShape(child.tag)
        return core.get_type(kind).from_xml(child, path)


_NUMBER, _VECTOR3, _VECTOR4 = _Numbers(1), _Numbers(3), _Numbers(4)
_TEXT = _Text()


def _attribute(name: str, kind: Any = _NUMBER, default: Optional[str] = None) -> core.Attribute:
    return core.Attribute(name, kind, required=False, default=default)


def _element(name: str, kind: Any, default: Optional[str] = None) -> core.Element:
    return core.Element(name, kind, required=False, default=default)


_NAME = _attribute("name", str, "")


class Pose(_Described, urdf.Pose):
    """``<origin>``."""


core.reflect(Pose, tag="origin", params=[_attribute("xyz", _VECTOR3), _attribute("rpy", _VECTOR3)])
_ORIGIN = _element("origin", Pose)


class Color(_Described, urdf.Color):
    """``<color>``."""


core.reflect(Color, tag="color", params=[_attribute("rgba", _VECTOR4)])


class Texture(_Described, urdf.Texture):
    """``<texture>``."""


core.reflect(Texture, tag="texture", params=[_attribute("filename", str, "")])


class Material(_Described, urdf.Material):
    """``<material>``, of a robot or of a visual."""


core.reflect(
    Material,
    tag="material",
    params=[_NAME, _element("color", Color), _element("texture", Texture)],
)


class Box(_Described, urdf.Box):
    """``<box>``."""


core.reflect(Box, tag="box", params=[_attribute("size", _VECTOR3)])


class Cylinder(_Described, urdf.Cylinder):
    """``<cylinder>``."""


core.reflect(Cylinder, tag="cylinder", params=[_attribute("radius"), _attribute("length")])


class Capsule(_Described, urdf.Cylinder):
    """``<capsule>``, which PyBullet knows."""


core.reflect(Capsule, tag="capsule", params=[_attribute("radius"), _attribute("length")])


class Sphere(_Described, urdf.Sphere):
    """``<sphere>``."""


core.reflect(Sphere, tag="sphere", params=[_attribute("radius")])


class Mesh(_Described, urdf.Mesh):
    """``<mesh>``."""


core.reflect(
    Mesh, tag="mesh", params=[_attribute("filename", str, ""), _attribute("scale", _VECTOR3)]
)

_SHAPES = {shape.XML_REFL.tag: shape for shape in (Box, Cylinder, Capsule, Sphere, Mesh)}


class UnknownShape:
    """What stands in a ``<geometry>`` and is no shape of URDF."""

    def __init__(self, tag: str) -> None:
        self.tag = tag


class Collision(_Described, urdf.Collision):
    """``<collision>``."""


core.reflect(Collision, tag="collision", params=[_NAME, _ORIGIN, _element("geometry", _Shape())])


class Visual(_Described, urdf.Visual):
    """``<visual>``."""


core.reflect(
    Visual,
    tag="visual",
    params=[_NAME, _ORIGIN, _element("geometry", _Shape()), _element("material", Material)],
)


class Inertia(_Described, urdf.Inertia):
    """``<inertia>``."""


core.reflect(Inertia, tag="inertia", params=[_attribute(key) for key in urdf.Inertia.KEYS])


class Inertial(_Described, urdf.Inertial):
    """``<inertial>``."""

    XML_NAMES = {"mass": ("mass", "value")}
    """Tag and attribute of what is the only number of an element of its own."""


core.reflect(
    Inertial,
    tag="inertial",
    params=[
        _ORIGIN,
        _element("mass", _AttributeOf("value", _NUMBER)),
        _element("inertia", Inertia),
    ],
)


class Link(_Described, urdf.Link):
    """``<link>``; `contact` is PyBullet's element of this name, as XML, or None."""


core.reflect(
    Link,
    tag="link",
    params=[
        _NAME,
        core.AggregateElement("visual", Visual),
        core.AggregateElement("collision", Collision),
        _element("inertial", Inertial),
        _element("contact", core.RawType()),
    ],
)


class JointDynamics(_Described, urdf.JointDynamics):
    """``<dynamics>``."""


core.reflect(JointDynamics, tag="dynamics", params=[_attribute("damping"), _attribute("friction")])


class JointLimit(_Described, urdf.JointLimit):
    """``<limit>``."""


core.reflect(
    JointLimit,
    tag="limit",
    params=[_attribute(key) for key in ("effort", "lower", "upper", "velocity")],
)


class JointMimic(_Described, urdf.JointMimic):
    """``<mimic>``."""


core.reflect(
    JointMimic,
    tag="mimic",
    params=[_attribute("joint", str, ""), _attribute("multiplier"), _attribute("offset")],
)


class SafetyController(_Described, urdf.SafetyController):
    """``<safety_controller>``."""


core.reflect(
    SafetyController,
    tag="safety_controller",
    params=[
        _attribute(key)
        for key in ("k_velocity", "k_position", "soft_lower_limit", "soft_upper_limit")
    ],
)


class Joint(_Described, urdf.Joint):
    """``<joint>``; `parent` and `child` are the links' names, empty where there is none."""

    XML_NAMES = {"axis": ("axis", "xyz")}


_LINK = _AttributeOf("link", core.get_type(str), "")
core.reflect(
    Joint,
    tag="joint",
    params=[
        _NAME,
        _attribute("type", str, ""),
        _ORIGIN,
        _element("axis", _AttributeOf("xyz", _VECTOR3)),
        _element("parent", _LINK, ""),
        _element("child", _LINK, ""),
        _element("limit", JointLimit),
        _element("dynamics", JointDynamics),
        _element("safety_controller", SafetyController),
        _element("mimic", JointMimic),
    ],
)


class TransmissionJoint(_Described, urdf.TransmissionJoint):
    """``<joint>`` of a transmission."""


core.reflect(
    TransmissionJoint,
    tag="joint",
    params=[_NAME, core.AggregateElement("hardwareInterface", _TEXT)],
)


class Actuator(_Described, urdf.Actuator):
    """``<actuator>``; older descriptions have the joints' `hardwareInterfaces` here."""

    def __init__(self) -> None:
        super().__init__()
        self.aggregate_init()
        self.hardwareInterfaces: List[str] = []


core.reflect(
    Actuator, tag="actuator", params=[_NAME, core.AggregateElement("hardwareInterface", _TEXT)]
)


class Transmission(_Described, urdf.Transmission):
    """``<transmission>``.

    Attributes
    ----------
    type : str or None
        Text of its ``<type>``.
    style : str
        Its attribute ``type``, which those in pr2's style have instead.
    named : set of str
        Names of all elements in it: in pr2's style, those of joints are among them.
    """

    def read_xml(self, node: ElementTree.Element, path: core.Path) -> None:
        """Set the attributes from an element."""
        super().read_xml(node, path)
        self.named = {child.get("name", "") for child in node}


core.reflect(
    Transmission,
    tag="transmission",
    params=[
        _NAME,
        core.Attribute("type", str, required=False, default="", var="style"),
        _element("type", _TEXT),
        core.AggregateElement("joint", TransmissionJoint),
        core.AggregateElement("actuator", Actuator),
    ],
)


class Robot(_Described, urdf.Robot):
    """``<robot>``; `gazebos` are XML elements."""


core.reflect(
    Robot,
    tag="robot",
    params=[
        _attribute("name", str),
        core.AggregateElement("link", Link),
        core.AggregateElement("joint", Joint),
        core.AggregateElement("gazebo", core.RawType()),
        core.AggregateElement("transmission", Transmission),
        core.AggregateElement("material", Material),
    ],
)


def read_xml(text: str) -> ElementTree.Element:
    """Return the ``<robot>`` element of a URDF text, for those who change and write it.

    A default namespace (``<robot xmlns="...">``) is taken off, as other readers of URDF ignore it.

    Raises
    ------
    UrdfError
        Too long, not XML, or no robot.
    """
    if len(text) > _MOST_CHARACTERS:
        raise UrdfError(
            f"robot_description has {len(text)} characters; at most {_MOST_CHARACTERS} are read"
        )
    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise UrdfError(f"robot_description is no XML: {error}") from None
    namespace, brace, _ = root.tag.rpartition("}")
    if brace:
        for element in root.iter():
            if element.tag.startswith(namespace + brace):
                element.tag = element.tag[len(namespace + brace) :]
    if root.tag != "robot":
        raise UrdfError(f"robot_description has the root element <{root.tag}>; <robot> is needed")
    count = sum(1 for _ in root.iter())
    if count > _MOST_ELEMENTS:
        raise UrdfError(
            f"robot_description has {count} elements; at most {_MOST_ELEMENTS} are read"
        )
    return root


def robot_of(root: ElementTree.Element) -> Robot:
    """Return the robot of a ``<robot>`` element, which stays as it is."""
    return core.get_type(Robot).from_xml(root, core.Path("robot"))


def read_robot(text: str) -> Robot:
    """Return the robot of a URDF text.

    Raises
    ------
    UrdfError
        Too long, not XML, or no robot.
    """
    return robot_of(read_xml(text))
