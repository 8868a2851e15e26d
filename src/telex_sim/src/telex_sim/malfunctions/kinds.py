"""Ways in which parts of a robot can fail: their names, units and ranges."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Dict, Iterator, NamedTuple, Tuple

from telex_control.common.params import ConfigError

JOINT, BELT, GRIPPER, IMU = "joint", "belt", "gripper", "imu"
LAMP, CAMERA, KEY, BATTERY = "lamp", "camera", "key", "battery"


class Kind(NamedTuple):
    """A way to fail.

    Attributes
    ----------
    text : str
        What it is, for people.
    unit : str
        Of its severity; empty: it has none, and `default`, `least` and `most` are 0.
    default, least, most : float
        Of its severity; 0 stands for the default.
    """

    name: str
    text: str
    unit: str = ""
    default: float = 0.0
    least: float = 0.0
    most: float = 0.0

    def severity(self, value: float) -> float:
        """Return a value, or the default for 0.

        Raises
        ------
        ConfigError
            It is not within the range.
        """
        if value == 0.0:
            return self.default
        # Also true for NaN.
        if not self.least <= value <= self.most:
            if not self.unit:
                raise ConfigError(f"value is {value:g}; '{self.name}' has none, 0 is needed")
            raise ConfigError(
                f"value is {value:g}; {self.least:g} to {self.most:g} ({self.unit}) is possible for"
                f" '{self.name}', and 0 for its default, {self.default:g}"
            )
        return value


_SHARE = "share that is left"
WEAK = Kind("weak", "gives only a part of its effort", _SHARE, 0.3, 0.02, 0.95)
STUCK = Kind("stuck", "is jammed where it is")
LIMP = Kind("limp", "gives no effort, and its brake does not hold")
SLIPPING = Kind("slipping", "its clutch slips", "N m that it bears", 30.0, 1.0, 300.0)
THROWN = Kind("thrown", "the belt is off its wheels")
LOST = Kind("lost", "loses force", "share that is lost", 1.0, 0.05, 1.0)
BIAS = Kind("bias", "its gyroscope drifts about the vertical", "rad/s", 0.05, -0.5, 0.5)
DEAD = Kind("dead", "does not burn")
FROZEN = Kind("frozen", "goes on sending its last picture")
DARK = Kind("dark", "its pictures are dark", "share of the light that is lost", 1.0, 0.05, 1.0)
NOISY = Kind("noisy", "its pictures are noisy", "grey levels of 255", 40.0, 2.0, 120.0)
DIRTY = Kind("dirty", "its window is dirty", "share of it", 0.35, 0.02, 0.95)
BLURRED = Kind("blurred", "is out of focus", "share of the picture's width", 0.01, 0.001, 0.05)
LOW = Kind("low", "runs down from this charge", "share of a full charge", 0.1, 0.0001, 1.0)
KEY_STUCK = Kind(STUCK.name, "goes on commanding when it is released")

_PLAIN: Dict[str, Tuple[Kind, ...]] = {
    BELT: (WEAK, STUCK, LIMP, THROWN),
    GRIPPER: (LOST,),
    IMU: (BIAS,),
    LAMP: (DEAD,),
    CAMERA: (FROZEN, DARK, NOISY, DIRTY, BLURRED),
    KEY: (KEY_STUCK,),
    BATTERY: (LOW,),
}
"""Kinds of each group but joints, which differ."""


JOINT_KINDS = (WEAK, STUCK, LIMP)
"""Of every joint; flippers can slip as well."""


def names_of_kinds() -> Tuple[str, ...]:
    """Names of all kinds, whatever they are of."""
    plain = (kind for kinds in _PLAIN.values() for kind in kinds)
    return tuple(dict.fromkeys(kind.name for kind in (*JOINT_KINDS, SLIPPING, *plain)))


def text_of(group: str, kind: str) -> str:
    """Words for a kind of a group; its name where it is not known."""
    known = (*JOINT_KINDS, SLIPPING) if group == JOINT else _PLAIN.get(group, ())
    return next((each.text for each in known if each.name == kind), kind)


@dataclass(frozen=True)
class Parts:
    """Names of what a robot has that can fail, beside its key.

    Attributes
    ----------
    joints : tuple of str
        Driven ones, without those of belts.
    flippers : tuple of str
        Those of the joints that lift a belt.
    belts : tuple of str
        By their drives, as ``left_belt``.
    """

    joints: Tuple[str, ...] = ()
    flippers: Tuple[str, ...] = ()
    belts: Tuple[str, ...] = ()
    gripper: bool = False
    imus: Tuple[str, ...] = ()
    lamps: Tuple[str, ...] = ()
    cameras: Tuple[str, ...] = ()
    battery: bool = False

    def _groups(self) -> Iterator[Tuple[str, Tuple[str, ...]]]:
        yield BELT, self.belts
        yield GRIPPER, (GRIPPER,) if self.gripper else ()
        yield IMU, self.imus
        yield LAMP, self.lamps
        yield CAMERA, self.cameras
        yield KEY, (KEY,)
        yield BATTERY, (BATTERY,) if self.battery else ()

    def possible(self) -> Iterator[Possible]:
        """Yield all that can fail, a part after the other."""
        for joint in self.joints:
            for kind in (*JOINT_KINDS, *((SLIPPING,) if joint in self.flippers else ())):
                yield Possible(joint, JOINT, kind)
        for group, names in self._groups():
            for name in names:
                for kind in _PLAIN[group]:
                    yield Possible(name, group, kind)

    def find(self, what: str, kind: str) -> Possible:
        """Find a way to fail; a joint may be named without its ``_joint``.

        Raises
        ------
        ConfigError
            It is not there; the message lists what is.
        """
        there = list(self.possible())
        names = list(dict.fromkeys(each.what for each in there))
        full = what if what in names else f"{what}_joint"
        if full not in names:
            raise ConfigError(f"what is '{what[:80]}'; there are: {', '.join(names)}")
        fitting = {each.kind.name: each for each in there if each.what == full}
        if kind not in fitting:
            raise ConfigError(f"kind is '{kind[:80]}'; {full} can be: {', '.join(fitting)}")
        return fitting[kind]


class Possible(NamedTuple):
    """A part, and a way in which it can fail; only both together tell it from others."""

    what: str
    group: str
    kind: Kind


def require_finite(value: float) -> None:
    """Raise a `ConfigError` for a severity that is no number."""
    if not math.isfinite(value):
        raise ConfigError(f"value is {value}; a finite number is needed")
