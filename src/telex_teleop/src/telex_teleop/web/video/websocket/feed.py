"""One camera for one client of `/video`: the newest picture, as often as the client can use it."""

from __future__ import annotations

import collections
import statistics
import time
from typing import Callable, Deque, Dict, Hashable, List, Optional, Tuple

from ..cameras import Camera
from ..late.pacer import Pacer
from ..pictures import EncodedPicture, Variant
from ..topics import PictureTopic
from .messages import WantedView, picture_header

REMEMBERED = 50
"""Acknowledgements over which the figures of a feed are taken."""

STALLED_AFTER = 0.5
"""Time (s) without an acknowledgement after which nothing is encoded for a client any more."""


class _Sent:
    """A picture under way: its number, the picture, when it went out (s, monotonic)."""

    __slots__ = ("arrived", "captured", "number", "sent")

    def __init__(self, number: int, picture: EncodedPicture, sent: float) -> None:
        self.number = number
        self.captured = picture.captured
        self.arrived = picture.arrived
        self.sent = sent


class Feed:
    """Holds the newest picture of a camera until the client has used the ones before.

    Parameters
    ----------
    camera, view
        Which, and how the client wants it.
    source
        The topic that the pictures come from: the camera's preview or its full one.
    client
        Whose share of the encoder's time they take.
    ready
        Called when there is something to send.
    too_small
        Called when the preview turns out to be smaller than what the client wants.
    lost
        Called when no more pictures will come.
    next_number
        Returns the number of the client's next picture.
    """

    def __init__(
        self,
        camera: Camera,
        view: WantedView,
        source: PictureTopic,
        client: Hashable,
        *,
        ready: Callable[[], None],
        too_small: Callable[[Feed], None],
        lost: Callable[[Feed], None],
        next_number: Callable[[], int],
    ) -> None:
        self.camera = camera
        self.view = view
        self.source = source
        self.client = client
        self.variant = variant_of(view)
        self._ready = ready
        self._too_small = too_small
        self._lost = lost
        self._next_number = next_number
        self._pacer = Pacer(view.rate)
        self._newest: Optional[EncodedPicture] = None
        self._under_way: Deque[_Sent] = collections.deque()
        self._acks: Deque[Tuple[float, float, float, float]] = collections.deque(maxlen=REMEMBERED)

    def wants(self) -> bool:
        """Tell whether a picture is due, for a client that uses those that it gets."""
        return self.takes() and self._pacer.is_due(time.monotonic())

    def takes(self) -> bool:
        """Tell whether the client uses the pictures that it gets."""
        under_way = self._under_way
        return not under_way or time.monotonic() - under_way[0].sent <= STALLED_AFTER

    def offer(self, picture: EncodedPicture) -> None:
        """Keep a picture that is due until it can be sent, or a newer one comes."""
        if self.source == self.camera.preview and not self.view.is_filled_by(picture.size):
            self._too_small(self)
        elif self._pacer.is_due(time.monotonic()):
            self._newest = picture
            self._ready()

    def check(self, now: float) -> None:
        """Nothing to do: whoever does not acknowledge costs nothing."""

    def close(self) -> None:
        """No more pictures will come."""
        self._lost(self)

    @property
    def is_sendable(self) -> bool:
        """Whether there is a picture, and credit for it."""
        return self._newest is not None and len(self._under_way) < self.view.credits

    def take(self) -> Tuple[bytes, bytes]:
        """Return the newest picture as the two parts of a message, and count it as sent."""
        picture, self._newest = self._newest, None
        assert picture is not None
        now = time.monotonic()
        self._pacer.sent(now)
        number = self._next_number()
        self._under_way.append(_Sent(number, picture, now))
        return picture_header(self.camera.index, number, picture.captured), picture.data

    def acknowledge(self, number: int) -> bool:
        """Give back the credit of a picture and of those before it; False: it was not sent."""
        if all(sent.number != number for sent in self._under_way):
            return False
        now, wall = time.monotonic(), time.time()
        while True:
            sent = self._under_way.popleft()
            made = sent.arrived - sent.captured
            self._acks.append((now, wall - sent.captured, now - sent.sent, made))
            if sent.number == number:
                break
        if self.is_sendable:
            self._ready()
        return True

    def figures(self) -> Dict[str, float]:
        """Return what the client's acknowledgements tell.

        Returns
        -------
        figures
            `rate` (1/s) of the acknowledged pictures; `age` (s) of their scene, and `round_trip`
            (s) since they were sent, when the acknowledgement came, and `made`, the age (s) at
            which they reached the server, all as median. Empty before two have come.
        """
        if len(self._acks) < 2:
            return {}
        times: List[float] = [ack[0] for ack in self._acks]
        span = max(time.monotonic() - times[0], 1e-3)
        return {
            "rate": round((len(times) - 1) / span, 2),
            "age": round(statistics.median(ack[1] for ack in self._acks), 5),
            "round_trip": round(statistics.median(ack[2] for ack in self._acks), 5),
            "made": round(statistics.median(ack[3] for ack in self._acks), 5),
        }


def variant_of(view: WantedView) -> Variant:
    """Return the variant of a camera's pictures that a view asks for."""
    if (view.width, view.height, view.quality) == (None, None, None):
        # The client gets what the camera publishes, be it JPEG or PNG.
        return Variant(unchanged=True)
    return Variant(width=view.width, height=view.height, quality=view.quality, fit=True)
