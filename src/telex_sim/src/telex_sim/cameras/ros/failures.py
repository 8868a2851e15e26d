"""Radiation and malfunctions of the cameras and lamps, as ROS tells of them."""

from __future__ import annotations

import math
from typing import Any, Dict, FrozenSet, NamedTuple

import rospy
from telex_msgs.msg import CameraRadiation, Malfunctions

from telex_control.common.params import ConfigError

from ...malfunctions import battery, kinds
from ..optics.flaws import SOUND, Flaws


class Received(NamedTuple):
    """Of one camera: dose rate (Gy/h), dose (Gy), and whether it has died of it."""

    dose_rate: float = 0.0
    dose: float = 0.0
    failed: bool = False


_NOTHING = Received()


class ReceivedDose:
    """Hears on ``cameras/radiation`` what each camera has received.

    Parameters
    ----------
    prefix
        Of its topic.
    """

    def __init__(self, prefix: str = "") -> None:
        # Replaced as a whole by a thread of ROS, which needs no lock.
        self._received: Dict[str, Received] = {}
        self._subscriber = rospy.Subscriber(
            f"{prefix}cameras/radiation",
            CameraRadiation,
            self._take,
            queue_size=1,
            tcp_nodelay=True,
        )

    def of(self, camera: str) -> Received:
        """What a camera has received; nothing where nobody tells of it."""
        return self._received.get(camera, _NOTHING)

    def _take(self, message: CameraRadiation) -> None:
        columns = (message.names, message.dose_rate, message.dose, message.failed)
        numbers = [*message.dose_rate, *message.dose]
        if len({len(column) for column in columns}) > 1 or not all(
            math.isfinite(number) and number >= 0.0 for number in numbers
        ):
            rospy.logwarn_throttle(
                10.0,
                "cameras/radiation: it has %s names, rates, doses and failures, the numbers %s; as "
                "many of each are needed, and numbers from 0 up; it is not heeded",
                [len(column) for column in columns],
                numbers,
            )
            return
        self._received = {name: Received(*values) for name, *values in zip(*columns)}


class Broken(NamedTuple):
    """What of cameras and lamps does not work.

    Attributes
    ----------
    flaws : dict of str to Flaws
        By camera.
    unpowered : frozenset of str
        What has no power, as telex_msgs/Malfunctions names it.
    """

    flaws: Dict[str, Flaws] = {}
    lamps: FrozenSet[str] = frozenset()
    unpowered: FrozenSet[str] = frozenset()

    @property
    def cameras_work(self) -> bool:
        """Whether the cameras have power."""
        return battery.CAMERAS not in self.unpowered

    def burns(self, lamp: str) -> bool:
        """Whether a lamp burns when it is switched on."""
        return lamp not in self.lamps and battery.LAMPS not in self.unpowered


def broken_of(message: Malfunctions) -> Broken:
    """Read what does not work; what makes no sense is said in the log."""
    flaws: Dict[str, Flaws] = {}
    lamps = set()
    for each in message.active:
        if each.group == kinds.LAMP:
            lamps.add(each.what)
        elif each.group == kinds.CAMERA:
            try:
                flaws[each.what] = _with(flaws.get(each.what, SOUND), each)
            except ConfigError as error:
                rospy.logwarn_throttle(10.0, "sim/malfunctions: %s: %s", each.what, error)
    return Broken(flaws, frozenset(lamps), frozenset(message.unpowered))


class HeardMalfunctions:
    """Hears on ``sim/malfunctions`` what does not work of cameras and lamps.

    Parameters
    ----------
    prefix
        Of its topic.
    """

    def __init__(self, prefix: str = "") -> None:
        # Replaced as a whole by a thread of ROS, which needs no lock.
        self._broken = Broken()
        self._freezes: Dict[str, int] = {}
        self._subscriber = rospy.Subscriber(
            f"{prefix}sim/malfunctions", Malfunctions, self._take, queue_size=1, tcp_nodelay=True
        )

    def flaws(self, camera: str) -> Flaws:
        """Return what is wrong with a camera."""
        return self._broken.flaws.get(camera, SOUND)

    def freezes(self, camera: str) -> int:
        """How often a camera has frozen."""
        return self._freezes.get(camera, 0)

    @property
    def cameras_work(self) -> bool:
        """See `Broken.cameras_work`."""
        return self._broken.cameras_work

    def burns(self, lamp: str) -> bool:
        """See `Broken.burns`."""
        return self._broken.burns(lamp)

    def _take(self, message: Malfunctions) -> None:
        broken = broken_of(message)
        for camera, flaws in broken.flaws.items():
            if flaws.frozen and not self.flaws(camera).frozen:
                self._freezes[camera] = self.freezes(camera) + 1
        self._broken = broken


def _with(flaws: Flaws, each: Any) -> Flaws:
    """Return flaws with one more.

    Raises
    ------
    ConfigError
        There is none of this kind, or not of this severity.
    """
    possible = kinds.Parts(cameras=(each.what,))
    kind = possible.find(each.what, each.kind).kind
    if kind is kinds.FROZEN:
        return flaws._replace(frozen=True)
    changes: Dict[str, Any] = {kind.name: kind.severity(each.value)}
    return flaws._replace(**changes)
