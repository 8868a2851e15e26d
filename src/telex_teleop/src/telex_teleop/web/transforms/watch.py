"""Transforms that a client watches, and the times at which it is told of them."""

from __future__ import annotations

import dataclasses
import math
import time
from typing import Any, Callable, Dict, List, Optional, Protocol, Sequence

from geometry_msgs.msg import Transform, TransformStamped

from telex_control.common.geometry.quaternions import angle_between
from telex_control.common.params import Declared, number, word
from telex_control.ros.pose_messages import quaternion_in

MAX_FRAMES = 200
"""Frames that one client may watch."""

MAX_RATE = 100.0
"""Highest rate (Hz) at which transforms are looked at."""

MIN_RATE = 0.01
"""Lowest one."""


class WishError(ValueError):
    """A wish that cannot be met; the text says what would be right."""


class Wishes(Protocol):
    """What a goal of TFSubscription and a request of RepublishTFs have in common."""

    source_frames: Sequence[str]
    target_frame: str
    angular_thres: float
    trans_thres: float
    rate: float


Lookup = Callable[[str, str], Optional[Transform]]
"""Returns the newest transform from a source frame (second) into a target frame (first), if any."""


def _checked(wishes: Any, name: str, low: float, high: float) -> float:
    value = float(getattr(wishes, name))
    if not low <= value <= high:
        raise WishError(f"{name} is {value:g}; it must be from {low:g} to {high:g}")
    return value


def _frame(name: str) -> str:
    """Return a frame's name as tf2 has it, without the slash of its predecessor."""
    return name[1:] if name.startswith("/") else name


class TransformWatch:
    """The transforms of some frames into one, each told when it has changed by enough.

    Parameters
    ----------
    wishes
        Frames, thresholds (m, rad) and rate (Hz). A threshold of 0 tells of every change.

    Raises
    ------
    WishError
        A value cannot be used.
    """

    def __init__(self, wishes: Wishes) -> None:
        if not 1 <= len(wishes.source_frames) <= MAX_FRAMES:
            raise WishError(
                f"source_frames has {len(wishes.source_frames)} names; it must have 1 to "
                f"{MAX_FRAMES}"
            )
        self._sources = [_frame(name) for name in wishes.source_frames]
        self._target = _frame(wishes.target_frame)
        if not all([self._target, *self._sources]):
            raise WishError("the name of a frame is empty")
        self._angular = _checked(wishes, "angular_thres", 0.0, math.inf)
        self._linear = _checked(wishes, "trans_thres", 0.0, math.inf)
        self.period = 1.0 / _checked(wishes, "rate", MIN_RATE, MAX_RATE)
        self._told: Dict[str, Transform] = {}

    def news(self, lookup: Lookup, stamp: Any) -> List[TransformStamped]:
        """Return the transforms that have changed by enough since they were told last.

        Parameters
        ----------
        stamp
            Present time, for their headers.
        """
        changed = []
        for source in self._sources:
            transform = lookup(self._target, source)
            if transform is None or not self._is_news(self._told.get(source), transform):
                continue
            self._told[source] = transform
            stamped = TransformStamped(child_frame_id=source, transform=transform)
            stamped.header.stamp, stamped.header.frame_id = stamp, self._target
            changed.append(stamped)
        return changed

    def _is_news(self, told: Optional[Transform], now: Transform) -> bool:
        if told is None:
            return True
        moved, turned = distance(told, now), angle(told, now)
        return moved > self._linear or turned > self._angular


class Audience:
    """Whether there is anybody for whom it is worth going on.

    Parameters
    ----------
    count
        Returns how many listen.
    timeout
        Time (s) for which there may be nobody.
    clock
        Monotonic time (s).
    """

    def __init__(
        self, count: Callable[[], int], timeout: float, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._count = count
        self._timeout = timeout
        self._clock = clock
        self._seen = clock()

    def is_there(self) -> bool:
        """Tell whether somebody listens, or did so lately; ask about once a second."""
        if self._count():
            self._seen = self._clock()
        return self._clock() - self._seen < self._timeout


def distance(first: Transform, second: Transform) -> float:
    """Return how far apart (m) two transforms are."""
    a, b = first.translation, second.translation
    return math.sqrt((a.x - b.x) ** 2 + (a.y - b.y) ** 2 + (a.z - b.z) ** 2)


def angle(first: Transform, second: Transform) -> float:
    """Return the angle (rad) by which two transforms are turned against each other."""
    return angle_between(quaternion_in(first.rotation), quaternion_in(second.rotation))


@dataclasses.dataclass(frozen=True)
class TransformsConfig(Declared):
    """Parameters of the node that tells web clients of transforms."""

    action: str = word(
        "/tf2_web_republisher", "Global name; roslibjs's TFClient looks for this one."
    )
    service: str = word("/republish_tfs", "The same.")
    max_watches: int = number(100, "Clients that it serves at a time.", 1, 1000)
