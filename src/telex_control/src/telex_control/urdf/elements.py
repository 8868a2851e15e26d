"""Numbers and links of robot descriptions, as the control layer needs them.

What is read from the XML, and how, stands in `model`; what is refused besides, in `checks`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Dict, List, Optional, Tuple

from .model import Robot, UrdfError, as_numbers

__all__ = [
    "Origin",
    "UrdfError",
    "Vector",
    "number",
    "numbers",
    "origin",
    "read_numbers",
    "root_links",
    "vector",
    "xml_name",
]

Vector = Tuple[float, float, float]


@dataclass(frozen=True)
class Origin:
    """URDF ``<origin>``: position (m), and rotation about the fixed axes x, y, z (rad)."""

    xyz: Vector = (0.0, 0.0, 0.0)
    rpy: Vector = (0.0, 0.0, 0.0)


def root_links(robot: Robot) -> List[str]:
    """Return the links that hang on no joint, in the order of the file."""
    carried = {joint.child for joint in robot.joints}
    return [name for name in robot.link_map if name not in carried]


def number(
    element: Optional[Any], attribute: str, where: str, default: Optional[float] = None
) -> float:
    """Return an attribute that is one number.

    Parameters
    ----------
    element : object of `model`, or None
    where : str
        What the element belongs to, for the message: ``link 'a'``.
    default : float, optional
        Where element or attribute is not there; without it, they must be.

    Raises
    ------
    UrdfError
        It is no finite number.
    """
    if default is not None and (element is None or getattr(element, attribute) is None):
        return default
    return numbers(element, attribute, 1, where)[0]


def vector(
    element: Optional[Any], attribute: str, where: str, default: Vector = (0.0, 0.0, 0.0)
) -> Vector:
    """Return an attribute that is three numbers; `default` where it is not there.

    Raises
    ------
    UrdfError
        They are not three finite numbers.
    """
    if element is None or getattr(element, attribute) is None:
        return default
    x, y, z = numbers(element, attribute, 3, where)
    return x, y, z


def numbers(element: Optional[Any], attribute: str, count: int, where: str) -> List[float]:
    """Return an attribute that is so many numbers.

    Raises
    ------
    UrdfError
        The attribute is not there, or has anything else.
    """
    if element is None:
        raise UrdfError(f"{where}: {attribute} is not given; {_wanted(count)} needed")
    value = getattr(element, attribute)
    if isinstance(value, list):
        return value
    if isinstance(value, float):
        return [value]
    tag, name = xml_name(element, attribute)
    return read_numbers(value or "", count, f"{where}: <{tag} {name}")


def read_numbers(text: str, count: int, where: str) -> List[float]:
    """Return the numbers of an attribute's text.

    Parameters
    ----------
    where : str
        For the message, up to the attribute's name: ``link 'a': <mass value``.

    Raises
    ------
    UrdfError
        They are not so many finite numbers, with blanks between them.
    """
    values = as_numbers(text, count)
    if values is None:
        raise UrdfError(f'{where}="{text}">; {_wanted(count)} needed')
    return values


def xml_name(element: Any, attribute: str) -> Tuple[str, str]:
    """Return tag and attribute by which the file has a number of an element."""
    names: Dict[str, Tuple[str, str]] = getattr(element, "XML_NAMES", {})
    return names.get(attribute, (element.XML_REFL.tag, attribute))


def origin(owner: Optional[Any], where: str) -> Origin:
    """Return the ``<origin>`` of an element; at zero where it has none.

    Raises
    ------
    UrdfError
    """
    place = None if owner is None else owner.origin
    return Origin(vector(place, "xyz", where), vector(place, "rpy", where))


def _wanted(count: int) -> str:
    return "a finite number is" if count == 1 else f"{count} finite numbers are"
