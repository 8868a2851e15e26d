"""One picture topic and everybody who watches it."""

from __future__ import annotations

import asyncio
import contextlib
import dataclasses
import functools
import threading
from typing import Callable, Collection, Dict, Hashable, KeysView, Optional, Protocol, Set, Tuple

from ..workers import NewestWorker, OrderedWorker
from .pictures import JPEG, PNG, EncodedPicture, Picture, UnusablePictureError, Variant, kept
from .topics import COMPRESSED_TYPE, RAW_TYPE, PictureTopic, Topics
from .viewers import Viewer


class Encode(Protocol):
    """Makes a variant of a picture; may raise UnusablePictureError."""

    def __call__(self, picture: Picture, variant: Variant) -> EncodedPicture:
        """Return the picture ready for a client."""


class PictureSource(Protocol):
    """Where pictures come from; all methods may block and are called off the loop's thread."""

    def find(self, topic: str, *, raw: bool = False) -> Optional[PictureTopic]:
        """Return the topic to subscribe to for a name as clients spell it, or None.

        Parameters
        ----------
        topic
            The name.
        raw
            Take the uncompressed topic, where there is one.
        """

    def subscribe(
        self, topic: PictureTopic, receive: Callable[[Picture], None]
    ) -> Callable[[], None]:
        """Call `receive`, in any thread, with every picture; return a function that ends this."""


@dataclasses.dataclass(frozen=True)
class _Newest:
    """The last picture of a variant, and its number among those of the topic."""

    number: int
    picture: EncodedPicture


class PictureHub:
    """Offers the pictures of a topic to all who watch it, each encoded once per variant.

    Pictures that go out as they came are offered at once; those that have to be encoded are made
    in an encoder's thread, and only while a viewer would take them, so that encoding delays
    nobody else. Viewers come and go on the loop's thread.

    Parameters
    ----------
    encode
        Makes a variant of a picture; called in the encoder's thread.
    on_unusable
        Called, in any thread, for a picture that cannot be used.
    """

    def __init__(
        self,
        encode: Encode,
        encoders: Encoders,
        on_unusable: Callable[[UnusablePictureError], None],
    ) -> None:
        self._loop = asyncio.get_running_loop()
        self._encode = encode
        self._encoders = encoders
        self._on_unusable = on_unusable
        self._viewers: Dict[Variant, Set[Viewer]] = {}
        self._newest: Dict[Variant, _Newest] = {}
        self._last: Optional[Picture] = None
        self._count = 0
        self._mailbox = _Mailbox(self._loop, self._arrive)

    @property
    def variants(self) -> KeysView[Variant]:
        """What is being watched."""
        return self._viewers.keys()

    @property
    def viewers(self) -> Set[Viewer]:
        """All viewers, of any variant."""
        return set().union(*self._viewers.values()) if self._viewers else set()

    def clients(self, variant: Variant) -> Set[Hashable]:
        """Return whose pictures those of a variant are."""
        return {viewer.client for viewer in self._viewers.get(variant, ())}

    def newest(self, variant: Variant) -> Optional[EncodedPicture]:
        """Return the last picture in a variant that is being watched."""
        entry = self._newest.get(variant)
        return entry.picture if entry else None

    def passes(self, variant: Variant, *, likely: bool) -> bool:
        """Tell whether the last picture needs no encoding; `likely` is what to say without one."""
        if self._last is None:
            return likely
        try:
            return kept(self._last, variant) is not None
        except UnusablePictureError:
            return False

    def last(self, variant: Variant) -> Optional[EncodedPicture]:
        """Return the last picture in a variant, where it need not be encoded for that."""
        if self._last is None:
            return None
        try:
            return kept(self._last, variant) or self.newest(variant)
        except UnusablePictureError:
            return None

    def add(
        self, viewer: Viewer, variant: Variant, *, show_newest: bool, likely_passes: bool
    ) -> None:
        """Let a viewer watch a variant.

        Parameters
        ----------
        show_newest
            Offer the last picture at once; otherwise the viewer begins with the next one.
        likely_passes
            Until the first picture shows more, it counts as one that needs no encoding.

        Raises
        ------
        EncoderFullError
            The variant has to be encoded, and too many others are already.
        """
        if not (variant in self._viewers or self.passes(variant, likely=likely_passes)):
            self._encoders.take_place((self, variant), {viewer.client})
        self._viewers.setdefault(variant, set()).add(viewer)
        if not show_newest or self._last is None:
            return
        entry = self._newest.get(variant)
        if entry is not None and entry.number == self._count:
            viewer.offer(entry.picture)
        else:
            # A topic may be slow or latched: its last picture is not yet made in this variant.
            self._make(self._count, self._last, variant)

    def remove(self, viewer: Viewer, variant: Variant) -> None:
        """Let a viewer go; a variant that nobody watches any more is forgotten."""
        watching = self._viewers.get(variant, set())
        watching.discard(viewer)
        if not watching:
            self._viewers.pop(variant, None)
            self._newest.pop(variant, None)
            self._encoders.leave_place((self, variant))
            self._encoders.of(variant).cancel((self, variant))

    def receive(self, picture: Picture) -> None:
        """Take a new picture; the subscriber's thread calls this."""
        self._mailbox.put(picture)

    def _arrive(self, picture: Picture) -> None:
        """Take a new picture on the loop's thread."""
        self._count += 1
        self._last = picture
        for variant in tuple(self._viewers):
            self._make(self._count, picture, variant)

    def _make(self, number: int, picture: Picture, variant: Variant) -> None:
        """Offer a picture in a variant, now if its bytes stay, else once it is encoded."""
        try:
            as_it_is = kept(picture, variant)
        except UnusablePictureError as error:
            self._on_unusable(error)
            return
        if as_it_is is not None:
            self._encoders.leave_place((self, variant))
            self._put(number, as_it_is, variant)
            return
        clients = {viewer.client for viewer in self._viewers[variant] if viewer.wants()}
        if clients:
            try:
                self._encoders.take_place((self, variant), clients)
            except EncoderFullError:  # it comes as soon as there is room
                return
            work = functools.partial(self._encode_and_post, number, picture, variant)
            self._encoders.of(variant).submit((self, variant), work, clients)

    def _encode_and_post(self, number: int, picture: Picture, variant: Variant) -> None:
        """Encode a picture in the encoder's thread and hand it to the loop."""
        try:
            encoded = self._encode(picture, variant)
        except UnusablePictureError as error:
            self._on_unusable(error)
            return
        _post(self._loop, self._put, number, encoded, variant)

    def _put(self, number: int, picture: EncodedPicture, variant: Variant) -> None:
        """Offer a picture to the viewers of its variant, unless a newer one was faster."""
        known = self._newest.get(variant)
        if variant not in self._viewers or (known is not None and known.number >= number):
            return
        self._newest[variant] = _Newest(number, picture)
        for viewer in tuple(self._viewers[variant]):
            viewer.offer(picture)

    def check(self, now: float) -> None:
        """Let every viewer look after itself; `now` is the monotonic time (s)."""
        for viewer in self.viewers:
            viewer.check(now)

    def close(self) -> None:
        """Send every viewer away."""
        for viewer in self.viewers:
            viewer.close()


class _Mailbox:
    """Hands the newest picture of a thread to the loop; those that are overtaken are forgotten."""

    def __init__(self, loop: asyncio.AbstractEventLoop, take: Callable[[Picture], None]) -> None:
        self._loop = loop
        self._take = take
        self._lock = threading.Lock()
        self._picture: Optional[Picture] = None

    def put(self, picture: Picture) -> None:
        with self._lock:
            is_first, self._picture = self._picture is None, picture
        if is_first:
            _post(self._loop, self._empty)

    def _empty(self) -> None:
        with self._lock:
            picture, self._picture = self._picture, None
        if picture is not None:
            self._take(picture)


def _post(loop: asyncio.AbstractEventLoop, call: Callable[..., None], *arguments: object) -> None:
    """Run a call on the loop's thread, unless the loop has ended."""
    with contextlib.suppress(RuntimeError):
        loop.call_soon_threadsafe(call, *arguments)


_Place = Tuple[PictureHub, Variant]
"""What is made of the pictures of a topic."""


class EncoderFullError(Exception):
    """The limit of pictures that are encoded at a time is reached; the text says so."""

    status = 503


class Encoders:
    """The threads that encode, and how many different pictures they may have to make.

    Clients share their time, whatever each of them asks for (`viewers.client_of`). PNG has a thread
    of its own, which steps back behind the other: it takes ten times as long.

    Parameters
    ----------
    most
        Different pictures, by topic and variant, that may be made at a time; at most half of them
        PNG. What passes unchanged, or would be made in any case, is not counted. A client gets no
        more of these places than it leaves free, so that there is one for whoever comes next.
    """

    def __init__(self, most: int) -> None:
        self._most = most
        self._made: Set[_Place] = set()
        self._workers = {
            JPEG: NewestWorker("JPEG encoder"),
            PNG: NewestWorker("PNG encoder", niceness=10),
        }

    def of(self, variant: Variant) -> NewestWorker:
        """Return the thread that makes a variant."""
        return self._workers[variant.mime]

    @property
    def backlog(self) -> int:
        """How many pictures wait to be encoded."""
        return sum(worker.backlog for worker in self._workers.values())

    def require_room(self, variant: Variant, clients: Collection[Hashable]) -> None:
        """Raise EncoderFullError unless one more variant may be made for one of some clients."""
        if not variant.has_wishes:
            return
        _require_room("pictures", self._made, self._most, clients)
        if variant.mime == PNG:
            pngs = [place for place in self._made if place[1].mime == PNG]
            _require_room("PNGs", pngs, self._most // 2, clients)

    def take_place(self, place: _Place, clients: Collection[Hashable]) -> None:
        """Count a hub's variant among those that are made; see `require_room`."""
        if place[1].has_wishes and place not in self._made:
            self.require_room(place[1], clients)
            self._made.add(place)

    def leave_place(self, place: _Place) -> None:
        """Count a hub's variant no longer."""
        self._made.discard(place)


def _require_room(
    what: str, made: Collection[_Place], most: int, clients: Collection[Hashable]
) -> None:
    if len(made) >= most:
        raise EncoderFullError(f"{len(made)} different {what} are made already, {_ASK}")
    watched = [hub.clients(variant) for hub, variant in made]
    own = min(sum(client in each for each in watched) for client in clients)
    if own >= most - len(made):
        raise EncoderFullError(f"{own} different {what} are made for this client already, {_ASK}")


_ASK = (
    "which is as many as may be (the parameter ~max_encoded); ask for a size, quality and format "
    "that another client has, or for the pictures as they are published."
)


class PictureHubs:
    """A hub for each topic that somebody watches, subscribed from the first viewer to the last.

    Parameters
    ----------
    worker
        Thread in which subscriptions begin and end, in order.
    encoders, encode, on_unusable
        See `PictureHub`; `on_unusable` also gets the topic's name.
    on_failure
        Called with a topic's name and the error when it cannot be subscribed to.
    """

    def __init__(
        self,
        source: PictureSource,
        worker: OrderedWorker,
        encoders: Encoders,
        encode: Encode,
        *,
        on_unusable: Callable[[str, UnusablePictureError], None],
        on_failure: Callable[[str, Exception], None],
    ) -> None:
        self._source = source
        self._worker = worker
        self._encoders = encoders
        self._encode = encode
        self._on_unusable = on_unusable
        self._on_failure = on_failure
        self._hubs: Dict[PictureTopic, PictureHub] = {}
        self._subscriptions: Dict[PictureTopic, _Subscription] = {}

    def __len__(self) -> int:
        return len(self._hubs)

    @property
    def topics(self) -> Topics:
        """What is watched, and its types."""
        return {
            topic.name: COMPRESSED_TYPE if topic.compressed else RAW_TYPE for topic in self._hubs
        }

    def last(self, topic: PictureTopic, variant: Variant) -> Optional[EncodedPicture]:
        """Return the last picture of a topic that is watched, where it need not be encoded."""
        hub = self._hubs.get(topic)
        return None if hub is None else hub.last(variant)

    def join(
        self,
        topic: PictureTopic,
        viewer: Viewer,
        variant: Variant,
        *,
        show_newest: bool = True,
        likely_passes: bool = False,
    ) -> PictureHub:
        """Let a viewer watch a topic and return its hub; `PictureHub.add` tells of the rest.

        Raises
        ------
        EncoderFullError
            The variant would have to be encoded, and too many others are already.
        """
        self.require_room(topic, viewer.client, variant, likely_passes=likely_passes)
        hub = self._hubs.get(topic)
        if hub is None:
            hub = PictureHub(
                self._encode, self._encoders, functools.partial(self._on_unusable, topic.name)
            )
            self._hubs[topic] = hub
            self._open(topic, hub)
        hub.add(viewer, variant, show_newest=show_newest, likely_passes=likely_passes)
        return hub

    def require_room(
        self,
        topic: PictureTopic,
        client: Hashable,
        variant: Variant,
        *,
        likely_passes: bool = False,
    ) -> None:
        """Raise EncoderFullError if `join` would."""
        hub = self._hubs.get(topic)
        if hub is not None and variant in hub.variants:
            return
        if not (likely_passes if hub is None else hub.passes(variant, likely=likely_passes)):
            self._encoders.require_room(variant, {client})

    def leave(self, topic: PictureTopic, viewer: Viewer, variant: Variant) -> None:
        """Let a viewer go; with the last one the subscription ends."""
        hub = self._hubs.get(topic)
        if hub is None:
            return
        hub.remove(viewer, variant)
        if not hub.viewers:
            del self._hubs[topic]
            self._worker.submit(self._subscriptions.pop(topic).end)

    @property
    def backlog(self) -> int:
        """How many pictures wait to be encoded."""
        return self._encoders.backlog

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
