"""A stuck key: a command that goes on though its client has let go of it."""

from __future__ import annotations

import asyncio
from functools import partial
from typing import Any, Callable, NamedTuple, Optional, Protocol, Tuple

import genpy
from std_msgs.msg import Bool
from telex_msgs.msg import Malfunctions

from ...workers import OrderedWorker
from ..protocol.operations import OperationError
from ..ros import Ros
from .commands import kind_of

PERIOD = 0.02
"""Time (s) between two repetitions."""

LET_GO = 0.06
"""Time (s) of silence after which a key counts as released, if no stop says so before."""

_STREAMS = (
    "control_msgs/JointJog",
    "geometry_msgs/Twist",
    "geometry_msgs/TwistStamped",
    "telex_msgs/FlipperPresetHold",
)
"""Types of what a held key commands."""

_GROUP = "key"


class Stream(Protocol):
    """What a client publishes on one topic."""

    def repeat(self, message: genpy.Message) -> None:
        """Publish a message once more."""

    def end_motion(self) -> None:
        """End what was commanded last."""


class _Held(NamedTuple):
    """A command that goes on: its stream, its message and axes, and when it came last (s)."""

    stream: Stream
    message: genpy.Message
    axes: Tuple[str, ...]
    heard: float


class StuckKey:
    """Repeats the first axis that is commanded once a key is stuck, when its client lets go of it.

    It sticks until the emergency stop is set, its client loses control or goes, or the malfunction
    ends; then not again before the next malfunction. One for all clients, on the loop's thread.

    Parameters
    ----------
    ros
        For the topics that tell of malfunctions and of the emergency stop.
    e_stop_topic
        Name of the emergency stop's topic.
    clock
        Monotonic time (s); the loop's by default.
    """

    def __init__(
        self,
        ros: Ros,
        worker: OrderedWorker,
        e_stop_topic: str,
        clock: Optional[Callable[[], float]] = None,
    ) -> None:
        self._ros = ros
        self._worker = worker
        self._topics = (ros.resolve("sim/malfunctions"), ros.resolve(e_stop_topic))
        self._clock = clock or asyncio.get_running_loop().time
        # Since when the malfunction is there, by its message; None: it is not.
        self._since: Optional[genpy.Time] = None
        self._armed = False
        self._held: Optional[_Held] = None
        self._changed = asyncio.Event()

    async def run(self) -> None:
        """Follow the malfunctions and repeat stuck commands, until cancelled."""
        loop = asyncio.get_running_loop()
        malfunctions, e_stop = self._topics

        def hear(take: Callable[[Any], None]) -> Callable[[genpy.Message, Optional[str]], None]:
            return lambda message, _: _call(loop, take, message)

        heard = (
            partial(self._ros.subscribe, malfunctions, Malfunctions, hear(self._take_malfunctions)),
            partial(self._ros.subscribe, e_stop, Bool, hear(self._take_e_stop)),
        )
        ends = [await self._worker.submit(subscribe) for subscribe in heard]
        try:
            while True:
                await self._changed.wait()
                self._changed.clear()
                while self._armed:
                    self.tick()
                    await asyncio.sleep(PERIOD)
        finally:
            for end in ends:
                self._worker.submit(end)

    def _take_malfunctions(self, message: Malfunctions) -> None:
        since = next((each.since for each in message.active if each.group == _GROUP), None)
        if since is None:
            self._since = None
            self._release()
        elif since != self._since:
            self._since = since
            self._armed = True
            self._changed.set()

    def _take_e_stop(self, message: Bool) -> None:
        if message.data and self._held is not None:
            self._release()

    def swallows(self, stream: Stream, message: genpy.Message) -> bool:
        """Note a command that is obeyed; returns whether it is a stop that the stuck key hides."""
        if not self._armed or message._type not in _STREAMS:
            return False
        kind, held, axes = kind_of(message), self._held, _axes(message)
        own = held is None or (held.stream is stream and held.axes == axes)
        if kind is None or not own:
            return False
        if kind.moves(message):
            self._held = _Held(stream, message, axes, self._clock())
            return False
        return held is not None

    def tick(self) -> None:
        """Repeat the stuck command once its client has released it."""
        held = self._held
        if held is None or self._clock() - held.heard < LET_GO:
            return
        try:
            held.stream.repeat(held.message)
        except OperationError:
            self._release()

    def leave(self, stream: Stream) -> None:
        """Let go of what sticks, if it is of a stream that ends or may not command any more."""
        if self._held is not None and self._held.stream is stream:
            self._held, self._armed = None, False

    def _release(self) -> None:
        held, self._held = self._held, None
        self._armed = False
        # A key that is really held goes on.
        if held is not None and self._clock() - held.heard >= LET_GO:
            held.stream.end_motion()


def _axes(message: genpy.Message) -> Tuple[str, ...]:
    """Joints that a command moves; of other types all that there is."""
    return tuple(getattr(message, "joint_names", ()))


def _call(
    loop: asyncio.AbstractEventLoop, take: Callable[[Any], None], message: genpy.Message
) -> None:
    if not loop.is_closed():
        loop.call_soon_threadsafe(take, message)
