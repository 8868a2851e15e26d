"""One client of the bridge: what it asked for, and what has to be undone when it goes."""

from __future__ import annotations

import asyncio
import dataclasses
import functools
import json
from typing import (
    Any,
    Awaitable,
    Callable,
    Coroutine,
    Dict,
    Generic,
    Optional,
    Protocol,
    Set,
    TypeVar,
)

from ..config import RosbridgeConfig
from .feeds import FeedPool
from .operations import Id, Operation, OperationError
from .outbox import Outbox, OutboxFullError
from .publications import Publication
from .publishers import PublisherPool
from .ros import Ros
from .services import ServiceDesk
from .subscriptions import Subscription, Wish

DEFAULT_QUEUE_SIZE = 100
"""Messages that a publisher keeps for a slow subscriber, as in rosbridge."""

_LEVELS = ("none", "error", "warning", "info")


class _Opening(Protocol):
    """A publication or subscription that can be closed before it is open."""

    def close(self) -> None:
        """Give back what it has got so far."""


Opening = TypeVar("Opening", bound=_Opening)


@dataclasses.dataclass
class _Held(Generic[Opening]):
    """A publication or subscription of the client, with the task that opens it."""

    thing: Opening
    opening: asyncio.Task[None]

    def close(self) -> None:
        self.opening.cancel()
        self.thing.close()


class ClientSession:
    """Obeys one client, on the loop's thread; nothing that it sends raises or blocks.

    Parameters
    ----------
    name
        Tells this client from the others of the bridge.
    config
        Limits.
    ros
        Names and time.
    publishers, feeds, services
        Shared by all clients.
    outbox
        What goes to the client.
    drop
        Cuts the connection, with the reason.
    """

    def __init__(
        self,
        name: str,
        config: RosbridgeConfig,
        ros: Ros,
        *,
        publishers: PublisherPool,
        feeds: FeedPool,
        services: ServiceDesk,
        outbox: Outbox,
        drop: Callable[[str], None],
    ) -> None:
        self._name = name
        self._config = config
        self._ros = ros
        self._publishers = publishers
        self._feeds = feeds
        self._services = services
        self._outbox = outbox
        self._drop = drop
        self._level = "error"
        self._publications: Dict[str, _Held[Publication]] = {}
        self._subscriptions: Dict[str, _Held[Subscription]] = {}
        self._tasks: Set[asyncio.Task[None]] = set()
        self._calls = 0
        self._operations: Dict[str, Callable[[Operation], None]] = {
            "advertise": self._advertise,
            "unadvertise": self._unadvertise,
            "publish": self._publish,
            "subscribe": self._subscribe,
            "unsubscribe": self._unsubscribe,
            "call_service": self._call_service,
            "set_level": self._set_level,
            "status": lambda _: None,
        }

    def receive(self, text: str) -> None:
        """Obey one text message of the client."""
        operation: Optional[Operation] = None
        try:
            operation = Operation(text)
            obey = self._operations.get(operation.op)
            if obey is None:
                known = ", ".join(self._operations)
                raise OperationError(
                    f"there is no operation {operation.op[:80]!r}; known are {known}"
                )
            obey(operation)
        except OperationError as error:
            name = f"{operation.op[:80]}: " if operation is not None else ""
            self.report(f"{name}{error}", operation.id if operation is not None else None)

    def report(self, sentence: str, operation_id: Id = None) -> None:
        """Tell the client what went wrong, unless it has asked not to hear that."""
        if self._level == "none":
            return
        status: Dict[str, Any] = {"op": "status", "level": "error", "msg": sentence}
        if operation_id is not None:
            status["id"] = operation_id
        self._reply(status)

    def close(self) -> None:
        """End: stop what the client drove, give back all that it used."""
        while self._publications:
            self._publications.popitem()[1].close()
        while self._subscriptions:
            self._subscriptions.popitem()[1].close()
        for task in tuple(self._tasks):
            task.cancel()

    def _reply(self, reply: Dict[str, Any]) -> None:
        try:
            self._outbox.put_reply(json.dumps(reply, separators=(",", ":")))
        except OutboxFullError as error:
            self._drop(str(error))

    def _set_level(self, operation: Operation) -> None:
        level = operation.text("level")
        if level not in _LEVELS:
            raise OperationError(
                f"there is no level {level[:80]!r}; known are {', '.join(_LEVELS)}"
            )
        self._level = level

    def _start(self, work: Coroutine[Any, Any, None]) -> asyncio.Task[None]:
        task = asyncio.ensure_future(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
        return task

    async def _open(
        self,
        opening: Callable[[], Awaitable[None]],
        operation: Operation,
        forget: Callable[[], Any],
    ) -> None:
        """Open a publication or subscription; if that fails, tell the client and forget it."""
        try:
            await opening()
        except Exception as error:  # whatever ROS raises is an answer to the client
            forget()
            self.report(f"{operation.op}: {error}", operation.id)

    # Publishing

    def _advertise(self, operation: Operation) -> None:
        topic = self._ros.resolve(operation.text("topic"))
        type_name = operation.text("type")
        held = self._publications.get(topic)
        if held is None:
            held = self._begin_publication(topic, type_name, operation)
        held.thing.ids.add(operation.id)

    def _publish(self, operation: Operation) -> None:
        topic = self._ros.resolve(operation.text("topic"))
        held = self._publications.get(topic)
        if held is None:
            held = self._begin_publication(topic, operation.optional_text("type"), operation)
        held.thing.publish(operation.get("msg"), operation.id)

    def _unadvertise(self, operation: Operation) -> None:
        topic = self._ros.resolve(operation.text("topic"))
        held = self._publications.get(topic)
        if held is None:
            raise OperationError(f"{topic} has not been advertised")
        held.thing.ids.discard(operation.id)
        if operation.id is None or not held.thing.ids:
            self._publications.pop(topic).close()

    def _begin_publication(
        self, topic: str, type_name: Optional[str], operation: Operation
    ) -> _Held[Publication]:
        limit = self._config.max_subscriptions
        if len(self._publications) >= limit:
            raise OperationError(f"a client may publish {limit} topics at most")
        publication = Publication(
            topic,
            latch=operation.flag("latch"),
            queue_size=self._depth(operation.count("queue_size", DEFAULT_QUEUE_SIZE)),
            pool=self._publishers,
            ros=self._ros,
            client=self._name,
            report=self.report,
        )
        opening = functools.partial(publication.open, type_name, self._config.connect_timeout)
        forget = functools.partial(self._publications.pop, topic, None)
        held = _Held(publication, self._start(self._open(opening, operation, forget)))
        self._publications[topic] = held
        return held

    # Subscribing

    def _subscribe(self, operation: Operation) -> None:
        spelled = operation.text("topic")
        topic = self._ros.resolve(spelled)
        type_name = operation.optional_text("type")
        wish = Wish(
            throttle=operation.count("throttle_rate", 0) / 1000.0,
            depth=self._depth(operation.count("queue_length", 0)),
        )
        held = self._subscriptions.get(spelled)
        if held is None:
            held = self._begin_subscription(topic, spelled, type_name, operation)
        held.thing.add(operation.id, wish)

    def _begin_subscription(
        self, topic: str, spelled: str, type_name: Optional[str], operation: Operation
    ) -> _Held[Subscription]:
        limit = self._config.max_subscriptions
        if len(self._subscriptions) >= limit:
            raise OperationError(f"a client may subscribe to {limit} topics at most")
        send = self._outbox.put_message
        subscription = Subscription(topic, spelled, feeds=self._feeds, send=send)
        forget = functools.partial(self._subscriptions.pop, spelled, None)
        opening = self._open(functools.partial(subscription.open, type_name), operation, forget)
        held = _Held(subscription, self._start(opening))
        self._subscriptions[spelled] = held
        return held

    def _unsubscribe(self, operation: Operation) -> None:
        spelled = operation.text("topic")
        held = self._subscriptions.get(spelled)
        if held is None:
            raise OperationError(f"{spelled[:200]} has not been subscribed to")
        held.thing.remove(operation.id)
        if operation.id is None or not held.thing.wanted:
            self._subscriptions.pop(spelled).close()

    def _depth(self, length: int) -> int:
        """Return how many messages may wait; rosbridge's 0 means that the client does not mind."""
        limit = self._config.max_queue_length
        return min(length, limit) if length else limit

    # Services

    def _call_service(self, operation: Operation) -> None:
        service = operation.text("service")
        if self._calls >= self._config.max_service_calls:
            answer = f"{self._calls} service calls of this client are under way already"
            self._respond(operation, service, answer, succeeded=False)
            return
        self._calls += 1
        self._start(self._answer(operation, service))

    async def _answer(self, operation: Operation, service: str) -> None:
        respond = functools.partial(self._respond, operation, service)
        try:
            respond(await self._services.call(service, operation.get("args")), succeeded=True)
        except OperationError as error:
            respond(str(error), succeeded=False)
        finally:
            self._calls -= 1

    def _respond(self, operation: Operation, service: str, values: Any, *, succeeded: bool) -> None:
        response: Dict[str, Any] = {"op": "service_response"}
        if operation.id is not None:
            response["id"] = operation.id
        response.update(service=service, values=values, result=succeeded)
        self._reply(response)
