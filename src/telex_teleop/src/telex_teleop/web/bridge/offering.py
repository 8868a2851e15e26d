"""Services that one client offers to all of ROS: advertise_service, service_response."""

from __future__ import annotations

import asyncio
import concurrent.futures
import functools
from typing import Any, Callable, Dict, Optional

import genpy

from ..config import RosbridgeConfig
from ..workers import OrderedWorker
from .access import Access
from .link import Held, Link
from .message_json import FieldError, MessageCodec, codec_of
from .message_types import service_class
from .operations import Operation, OperationError
from .ros import Ros

MAX_PENDING = 100
"""Calls of one service that may wait for its client."""


class OfferedService:
    """A service that a client answers.

    Parameters
    ----------
    name
        Global name.
    spelled
        The name as the client gave it, which is how it expects to be called.
    ros
        Where to offer it.
    worker
        Thread for the calls that block.
    timeout
        Time (s) that the client gets to answer.
    link
        The client.
    """

    def __init__(
        self,
        name: str,
        spelled: str,
        *,
        ros: Ros,
        worker: OrderedWorker,
        timeout: float,
        link: Link,
    ) -> None:
        self.name = name
        self._spelled = spelled
        self._ros = ros
        self._worker = worker
        self._timeout = timeout
        self._link = link
        self._loop = asyncio.get_running_loop()
        self._withdraw: Optional[Callable[[], None]] = None
        self._closed = False
        self._calls = 0
        self._pending: Dict[str, concurrent.futures.Future[Any]] = {}
        self._request_codec: Optional[MessageCodec] = None
        self._response_codec: Optional[MessageCodec] = None

    async def open(self, type_name: str) -> None:
        """Offer it; raises OperationError if the type is unknown or somebody else offers it."""
        found = service_class(type_name)
        self._request_codec = codec_of(found._request_class)
        self._response_codec = codec_of(found._response_class)

        def serve() -> None:
            if not self._closed:
                self._withdraw = self._ros.serve(self.name, found, self._answer)

        await self._worker.submit(serve)

    def _answer(self, request: genpy.Message) -> genpy.Message:
        """Let the client answer a call; one of rospy's threads waits here."""
        answer: concurrent.futures.Future[Any] = concurrent.futures.Future()
        self._loop.call_soon_threadsafe(self._ask, request, answer)
        try:
            return answer.result(self._timeout)
        except concurrent.futures.TimeoutError:
            raise OperationError(
                f"the client that offers {self.name} did not answer within {self._timeout:g} s"
            ) from None

    def _ask(self, request: genpy.Message, answer: concurrent.futures.Future[Any]) -> None:
        if self._closed or self._request_codec is None:
            answer.set_exception(OperationError(f"the client that offered {self.name} is gone"))
            return
        if len(self._pending) >= MAX_PENDING:
            answer.set_exception(OperationError(f"{MAX_PENDING} calls of {self.name} wait already"))
            return
        self._calls += 1
        call_id = f"call_service:{self.name}:{self._calls}"
        self._pending[call_id] = answer
        answer.add_done_callback(lambda _: self._forget_soon(call_id))
        self._link.reply(
            {
                "op": "call_service",
                "id": call_id,
                "service": self._spelled,
                "args": self._request_codec.to_json(request),
            }
        )

    def _forget_soon(self, call_id: str) -> None:
        self._loop.call_soon_threadsafe(self._pending.pop, call_id, None)

    def respond(self, call_id: object, values: Any, *, succeeded: bool) -> None:
        """Take the client's answer to a call.

        Clients of rosbridge disagree on what a false result with values means, so values that are
        an object are an answer all the same.

        Raises
        ------
        OperationError
            No call of this id waits, or the values do not fit the service's response.
        """
        answer = self._pending.pop(call_id, None) if isinstance(call_id, str) else None
        if answer is None or answer.done() or self._response_codec is None:
            raise OperationError(f"no call of {self.name} with this id waits for an answer")
        failed = isinstance(values, str) or (values is None and not succeeded)
        if failed:
            reason = values or f"the client that offers {self.name} could not do it"
            answer.set_exception(OperationError(reason))
            return
        try:
            # A stamp that is missing gets the present time, as in messages.
            answer.set_result(self._response_codec.from_json(values or {}, self._ros.now))
        except FieldError as error:
            answer.set_exception(OperationError(f"{self.name} gave a wrong answer: {error}"))
            raise OperationError(str(error)) from None

    def close(self) -> None:
        """Withdraw it; calls that wait fail at once."""
        self._closed = True
        for answer in tuple(self._pending.values()):
            if not answer.done():
                answer.set_exception(OperationError(f"the client that offered {self.name} is gone"))
        self._worker.submit(self._end)

    def _end(self) -> None:
        if self._withdraw is not None:
            self._withdraw()


class Offering:
    """All services that one client offers.

    Parameters
    ----------
    config
        Limits.
    ros, worker
        Where to offer them.
    access
        Which names are open to clients.
    link
        The client.
    """

    def __init__(
        self, config: RosbridgeConfig, ros: Ros, worker: OrderedWorker, access: Access, link: Link
    ) -> None:
        self._config = config
        self._ros = ros
        self._worker = worker
        self._access = access
        self._link = link
        self._services: Dict[str, Held[OfferedService]] = {}

    def advertise(self, operation: Operation) -> None:
        """Offer a service; one of the same name that the client offers already is replaced."""
        spelled = operation.text("service")
        name = self._ros.resolve(spelled)
        type_name = operation.text("type")
        self._access.check("serve", name)
        before = self._services.pop(name, None)
        if before is not None:
            before.close()
        limit = self._config.max_services
        if len(self._services) >= limit:
            raise OperationError(f"a client may offer {limit} services at most")
        service = OfferedService(
            name,
            spelled,
            ros=self._ros,
            worker=self._worker,
            timeout=self._config.service_timeout,
            link=self._link,
        )
        forget = functools.partial(self._forget, name, service)
        task = self._link.start(
            self._link.open(functools.partial(service.open, type_name), operation, forget)
        )
        self._services[name] = Held(service, task)

    def _forget(self, name: str, service: OfferedService) -> None:
        held = self._services.get(name)
        if held is not None and held.thing is service:
            del self._services[name]

    def unadvertise(self, operation: Operation) -> None:
        """Offer a service no more."""
        name = self._ros.resolve(operation.text("service"))
        held = self._services.pop(name, None)
        if held is None:
            raise OperationError(f"{name} has not been advertised")
        held.close()

    def respond(self, operation: Operation) -> None:
        """Take the answer to a call."""
        name = self._ros.resolve(operation.text("service"))
        held = self._services.get(name)
        if held is None:
            raise OperationError(f"{name} has not been advertised")
        succeeded = operation.get("result") is not False
        held.thing.respond(operation.id, operation.get("values"), succeeded=succeeded)

    def close(self) -> None:
        """Withdraw all of them."""
        while self._services:
            self._services.popitem()[1].close()
