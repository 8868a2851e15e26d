"""One picture topic and everybody who watches it."""

from __future__ import annotations

import asyncio
import functools
from typing import Callable, Dict, Optional, Protocol, Set, Tuple, Union

from ..workers import OrderedWorker, in_own_thread
from .mjpeg import part
from .pictures import CompressedPicture, EncodedPicture, RawPicture, UnusablePictureError, Variant
from .topics import PictureTopic
from .viewers import Viewer

Picture = Union[CompressedPicture, RawPicture]
Encode = Callable[[Picture, Variant], EncodedPicture]


class PictureSource(Protocol):
    """Where pictures come from; all methods may block and are called off the loop's thread."""

    def find(self, topic: str) -> Optional[PictureTopic]:
        """Return the topic to subscribe to for a name as clients spell it, or None."""

    def subscribe(
        self, topic: PictureTopic, receive: Callable[[Picture], None]
    ) -> Callable[[], None]:
        """Call `receive`, in any thread, with every picture; return a function that ends this."""


class PictureHub:
    """Encodes each picture of a topic once per variant and offers it to all who watch that variant.

    Viewers come and go on the loop's thread; pictures come in the subscriber's thread and are
    encoded there.

    Parameters
    ----------
    encode
        Makes a variant of a picture; may raise UnusablePictureError.
    on_unusable
        Called in the subscriber's thread for a picture that cannot be used.
    """

    def __init__(self, encode: Encode, on_unusable: Callable[[UnusablePictureError], None]) -> None:
        self._loop = asyncio.get_running_loop()
        self._encode = encode
        self._on_unusable = on_unusable
        self._viewers: Dict[Variant, Set[Viewer]] = {}
        self._newest: Dict[Variant, Tuple[int, EncodedPicture, bytes]] = {}
        # Shared with the subscriber's thread; each is replaced as a whole.
        self._variants: Tuple[Variant, ...] = ()
        self._last_received: Tuple[int, Optional[Picture]] = (0, None)

    @property
    def viewers(self) -> Set[Viewer]:
        """All who watch, in whatever variant."""
        return set().union(*self._viewers.values()) if self._viewers else set()

    def newest(self, variant: Variant) -> Optional[EncodedPicture]:
        """Return the last picture in a variant that is being watched."""
        entry = self._newest.get(variant)
        return entry[1] if entry else None

    def add(self, viewer: Viewer, variant: Variant, *, show_newest: bool) -> None:
        """Let a viewer watch a variant.

        Parameters
        ----------
        viewer, variant
            Who, and what.
        show_newest
            Offer the last picture at once; otherwise the viewer begins with the next one.
        """
        is_new = variant not in self._viewers
        self._viewers.setdefault(variant, set()).add(viewer)
        self._variants = tuple(self._viewers)
        if variant in self._newest:
            if show_newest:
                viewer.offer(*self._newest[variant][1:])
            return
        number, picture = self._last_received
        if is_new and show_newest and picture is not None:
            # A topic may be slow or latched: its last picture is not yet encoded in this variant.
            in_own_thread(functools.partial(self._deliver, number, picture, (variant,)))

    def remove(self, viewer: Viewer, variant: Variant) -> None:
        """Let a viewer go; a variant that nobody watches any more is forgotten."""
        watching = self._viewers.get(variant, set())
        watching.discard(viewer)
        if not watching:
            self._viewers.pop(variant, None)
            self._newest.pop(variant, None)
            self._variants = tuple(self._viewers)

    def receive(self, picture: Picture) -> None:
        """Take a new picture; the subscriber's thread calls this."""
        number = self._last_received[0] + 1
        self._last_received = (number, picture)
        self._deliver(number, picture, self._variants)

    def _deliver(self, number: int, picture: Picture, variants: Tuple[Variant, ...]) -> None:
        """Encode a picture in some variants and hand them to the loop; runs in any thread."""
        for variant in variants:
            try:
                encoded = self._encode(picture, variant)
            except UnusablePictureError as error:
                self._on_unusable(error)
                return
            framed = part(encoded.data, encoded.stamp, encoded.mime)
            try:
                self._loop.call_soon_threadsafe(self._put, variant, number, encoded, framed)
            except RuntimeError:
                return  # the loop has ended

    def _put(self, variant: Variant, number: int, picture: EncodedPicture, framed: bytes) -> None:
        """Offer a picture to the viewers of its variant, unless a newer one was faster."""
        known = self._newest.get(variant)
        if variant not in self._viewers or (known is not None and known[0] >= number):
            return
        self._newest[variant] = (number, picture, framed)
        for viewer in tuple(self._viewers[variant]):
            viewer.offer(picture, framed)

    def check(self, now: float) -> None:
        """Let every viewer look after itself; `now` is the monotonic time (s)."""
        for viewer in self.viewers:
            viewer.check(now)

    def close(self) -> None:
        """Send every viewer away."""
        for viewer in self.viewers:
            viewer.close()


class PictureHubs:
    """A hub for each topic that somebody watches, subscribed from the first viewer to the last.

    Parameters
    ----------
    source
        Where pictures come from.
    worker
        Thread in which subscriptions begin and end, in order.
    encode, on_unusable
        See `PictureHub`; `on_unusable` also gets the topic's name.
    on_failure
        Called with a topic's name and the error when it cannot be subscribed to.
    """

    def __init__(
        self,
        source: PictureSource,
        worker: OrderedWorker,
        encode: Encode,
        *,
        on_unusable: Callable[[str, UnusablePictureError], None],
        on_failure: Callable[[str, Exception], None],
    ) -> None:
        self._source = source
        self._worker = worker
        self._encode = encode
        self._on_unusable = on_unusable
        self._on_failure = on_failure
        self._hubs: Dict[PictureTopic, PictureHub] = {}
        self._subscriptions: Dict[PictureTopic, _Subscription] = {}

    def __len__(self) -> int:
        return len(self._hubs)

    def join(
        self, topic: PictureTopic, viewer: Viewer, variant: Variant, *, show_newest: bool = True
    ) -> PictureHub:
        """Let a viewer watch a topic and return its hub."""
        hub = self._hubs.get(topic)
        if hub is None:
            hub = PictureHub(self._encode, functools.partial(self._on_unusable, topic.name))
            self._hubs[topic] = hub
            self._open(topic, hub)
        hub.add(viewer, variant, show_newest=show_newest)
        return hub

    def leave(self, topic: PictureTopic, viewer: Viewer, variant: Variant) -> None:
        """Let a viewer go; with the last one the subscription ends."""
        hub = self._hubs.get(topic)
        if hub is None:
            return
        hub.remove(viewer, variant)
        if not hub.viewers:
            del self._hubs[topic]
            self._worker.submit(self._subscriptions.pop(topic).end)

    def check(self, now: float) -> None:
        """Drop viewers that have stopped reading; call about once a second (monotonic time, s)."""
        for hub in tuple(self._hubs.values()):
            hub.check(now)

    def close(self) -> None:
        """Send every viewer away."""
        for hub in tuple(self._hubs.values()):
            hub.close()

    def _open(self, topic: PictureTopic, hub: PictureHub) -> None:
        subscription = _Subscription(self._source, topic, hub.receive)
        self._subscriptions[topic] = subscription

        def begun(done: asyncio.Future[None]) -> None:
            error = done.exception() if not done.cancelled() else None
            if isinstance(error, Exception):
                self._on_failure(topic.name, error)
                hub.close()

        self._worker.submit(subscription.begin).add_done_callback(begun)


class _Subscription:
    """A subscription whose beginning and end run one after the other in the worker's thread."""

    def __init__(
        self, source: PictureSource, topic: PictureTopic, receive: Callable[[Picture], None]
    ) -> None:
        self._source = source
        self._topic = topic
        self._receive = receive
        self._cancel: Optional[Callable[[], None]] = None

    def begin(self) -> None:
        self._cancel = self._source.subscribe(self._topic, self._receive)

    def end(self) -> None:
        if self._cancel is not None:
            self._cancel()
            self._cancel = None
