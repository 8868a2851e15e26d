"""Parameters of the equipment that a variant may have; its URDF says what of it is there."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Collection, Tuple

from telex_control.common.params import (
    Declared,
    checked,
    number,
    number_or_zero,
    parameter,
    require,
)

_FINEST = 1e-6
"""Resolution of a range finder (m); of much finer ones there are too many to count."""
_TOPIC = re.compile(r"[A-Za-z][A-Za-z0-9_]*(/[A-Za-z0-9_]+)*")


def _check_topic(config: object, name: str) -> None:
    value = getattr(config, name)
    require(
        _TOPIC.fullmatch(value) is not None,
        f"{name} is {value!r}; a name within the robot's namespace is needed, as range_finder",
    )


@dataclass(frozen=True)
class RangeFinderConfig(Declared):
    """A laser range finder that looks along its frame's x axis."""

    link: str = parameter("", "In whose origin it sits; a robot without that link has none.")
    training_link: str = parameter(
        "", "From where a training aid measures in its place, without errors, on a robot without."
    )
    topic: str = checked("range_finder", "Its topic, in the robot's namespace.", _check_topic)
    rate: float = number(
        20.0, "How often it measures while somebody listens (Hz of sim time).", 0.1, 200.0
    )
    min: float = number(0.05, "What is nearer reads as minus infinity (m).", 0.0, 100.0)
    max: float = number(
        10.0,
        "What is further away reads as infinity (m).",
        maximum=1000.0,
        above=lambda own: own.min,
    )
    field_of_view: float = number(0.002, "Angle of its beam, which it tells (rad).", 0.0, 3.14)
    noise: float = number(0.002, "Standard deviation of a reading (m),", 0.0, 10.0)
    noise_share: float = number(0.001, "and what comes to it for each metre of distance.", 0.0, 1.0)
    resolution: float = number_or_zero(
        0.001, "Readings are multiples of it (m); 0: they are not.", "for none", _FINEST, 1.0
    )
    seed: int = number(1, "The same seed gives the same errors.", 0)


@dataclass(frozen=True)
class LaserDotsConfig(Declared):
    """Lasers whose parallel beams go along their frames' x axes and make dots of light."""

    links: Tuple[str, ...] = parameter(
        (), "From whose origins the beams go; a robot without one of them has none."
    )
    max: float = number(8.0, "Distance up to which a dot can be seen (m).", 0.1, 1000.0)


@dataclass(frozen=True)
class ProximityEquipmentConfig(Declared):
    """Sensors that feel what the arm is near to; their range is ``proximity/range``."""

    link: str = parameter("", "Where its electronics sit; a robot without that link has none.")
    noise: float = number(0.002, "Standard deviation of a told distance (m).", 0.0, 1.0)
    seed: int = number(1, "The same seed gives the same errors.", 0)


@dataclass(frozen=True)
class MicrophoneConfig(Declared):
    """A microphone; what it hears is made where it is played."""

    link: str = parameter("", "Where it sits; a robot without that link has none.")
    noise: float = number(34.0, "Its own noise, as sound pressure (dB).", 0.0, 120.0)
    max: float = number(
        110.0,
        "Sound pressure beyond which it clips (dB).",
        maximum=200.0,
        above=lambda own: own.noise,
    )


@dataclass(frozen=True)
class PadsConfig(Declared):
    """Pads that feel with what force they press; see ``gripper_contact``."""

    links: Tuple[str, ...] = parameter(
        (), "Middles of their surfaces; a robot without one of them has none that feel."
    )
    noise: float = number(0.3, "Standard deviation of a told force (N).", 0.0, 1000.0)
    max: float = number(400.0, "Force beyond which a pad tells no more (N).", above=0.0)
    seed: int = number(1, "The same seed gives the same errors.", 0)


@dataclass(frozen=True)
class EquipmentConfig(Declared):
    """Figures of all equipment; a robot has of it what its URDF has the links of."""

    range_finder: RangeFinderConfig = field(default_factory=RangeFinderConfig)
    laser_dots: LaserDotsConfig = field(default_factory=LaserDotsConfig)
    proximity: ProximityEquipmentConfig = field(default_factory=ProximityEquipmentConfig)
    microphone: MicrophoneConfig = field(default_factory=MicrophoneConfig)
    pads: PadsConfig = field(default_factory=PadsConfig)

    def present(self, links: Collection[str]) -> Tuple[str, ...]:
        """Names of what a robot with these links has."""
        needed = {
            "range_finder": (self.range_finder.link,),
            "laser_dots": self.laser_dots.links,
            "proximity": (self.proximity.link,),
            "microphone": (self.microphone.link,),
            "pads": self.pads.links,
        }
        return tuple(
            name
            for name, own in needed.items()
            if own and all(link and link in links for link in own)
        )
