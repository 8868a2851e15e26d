"""The operations advertise_service, unadvertise_service and service_response of one client."""

from __future__ import annotations

import asyncio
import concurrent.futures
import contextlib
import functools
import itertools
from typing import Any, Callable, Dict, Iterator, List, Optional, Set

import genpy

from ...server_config import RosbridgeConfig
from ...workers import OrderedWorker
from ..clients.client import Client
from ..protocol.operations import Operation, OperationError
from ..protocol.ros_messages import FieldError, MessageCodec, codec_of, service_class
from ..ros import Ros

MAX_PENDING = 100
"""Calls of one service that may wait for its client."""


class AdvertisedService:
    """A service that one client answers for all of ROS.

    Parameters
    ----------
    name
        Global name.
    spelled
        The name as the client gave it, which is how it expects to be called.
    timeout
        Time (s) that the client gets to answer.
    numbers
        Of calls; no two calls of a client get the same one.

    Attributes
    ----------
    own_calls
        Calls of it by the client itself that are under way.
    opening
        The task that opens it.
    """

    def __init__(
        self,
        name: str,
        spelled: str,
        *,
        ros: Ros,
        worker: OrderedWorker,
        timeout: float,
        client: Client,
        numbers: Iterator[int],
    ) -> None:
        self.name = name
        self._spelled = spelled
        self._ros = ros
        self._worker = worker
        self._timeout = timeout
        self._client = client
        self._numbers = numbers
        self._loop = asyncio.get_running_loop()
        self._withdraw: Optional[Callable[[], None]] = None
        self._closed = False
        self.opening: Optional[asyncio.Task[None]] = None
        self.own_calls: Set[asyncio.Task[None]] = set()
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
            # There, as all that is done to it: it waits no more.
            with contextlib.suppress(RuntimeError):  # the loop has ended
                self._loop.call_soon_threadsafe(self._give_up, answer)
            raise OperationError(
                f"the client that offers {self.name} did not answer within {self._timeout:g} s"
            ) from None

    def _give_up(self, answer: concurrent.futures.Future[Any]) -> None:
        if not answer.done():
            answer.set_exception(OperationError(f"an answer of {self.name} came too late"))

    def _ask(self, request: genpy.Message, answer: concurrent.futures.Future[Any]) -> None:
        if self._closed or self._request_codec is None:
            answer.set_exception(OperationError(f"the client that offered {self.name} is gone"))
            return
        if len(self._pending) >= MAX_PENDING:
            answer.set_exception(OperationError(f"{MAX_PENDING} calls of {self.name} wait already"))
            return
        call_id = f"call_service:{self.name}:{next(self._numbers)}"
        self._pending[call_id] = answer
        answer.add_done_callback(lambda _: self._forget_soon(call_id))
        self._client.reply(
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

    def waits_for(self, call_id: object) -> bool:
        """Tell whether a call of this id waits for its answer."""
        return call_id in self._pending

    def close(self) -> None:
        """Withdraw it, open or not; calls that wait fail at once."""
        if self.opening is not None:
            self.opening.cancel()
        self._closed = True
        for answer in tuple(self._pending.values()):
            if not answer.done():
                answer.set_exception(OperationError(f"the client that offered {self.name} is gone"))
        self._worker.submit(self._end)

    def _end(self) -> None:
        if self._withdraw is not None:
            self._withdraw()


class AdvertisedServices:
    """All services that one client offers.

    What it asks of one service happens in the order in which it asks: a service that it offers and
    calls at once is called when it is there, and withdrawn when that call has been answered.
    """

    def __init__(
        self, client: Client, *, config: RosbridgeConfig, ros: Ros, worker: OrderedWorker
    ) -> None:
        self._client = client
        self._config = config
        self._ros = ros
        self._worker = worker
        self._services: Dict[str, AdvertisedService] = {}
        self._leaving: Set[AdvertisedService] = set()
        self._turns: Dict[str, asyncio.Task[None]] = {}
        self._numbers = itertools.count(1)

    def advertise(self, operation: Operation) -> None:
        """Offer a service; one of the same name that the client offers already is replaced."""
        spelled = operation.text("service")
        name = self._ros.resolve(spelled)
        type_name = operation.text("type")
        self._client.access.check("serve", name)
        before = self._services.pop(name, None)
        if before is not None:
            self._withdraw(name, before)
        limit = self._config.max_services
        if len(self._services) >= limit or len(self._leaving) > limit:
            raise OperationError(f"a client may offer {limit} services at most")
        service = AdvertisedService(
            name,
            spelled,
            ros=self._ros,
            worker=self._worker,
            timeout=self._config.service_timeout,
            client=self._client,
            numbers=self._numbers,
        )
        forget = functools.partial(self._forget, name, service)
        before_it = self.turn(name)

        async def open_in_turn() -> None:
            await _ended(before_it)
            await service.open(type_name)

        opening = self._client.open(open_in_turn, operation, forget)
        service.opening = self._take_turn(name, opening)
        self._services[name] = service

    def turn(self, name: str) -> Optional[asyncio.Task[None]]:
        """Return what the client has asked of a service last, if that has not happened yet."""
        return self._turns.get(name)

    def note_call(self, name: str, call: asyncio.Task[None]) -> None:
        """Remember a call by the client; if it offers that service, it goes on until then."""
        service = self._services.get(name)
        if service is not None:
            service.own_calls.add(call)
            call.add_done_callback(service.own_calls.discard)

    def _take_turn(self, name: str, task: asyncio.Task[None]) -> asyncio.Task[None]:
        self._turns[name] = task

        def forget(_: asyncio.Task[None]) -> None:
            if self._turns.get(name) is task:
                del self._turns[name]

        task.add_done_callback(forget)
        return task

    def _withdraw(self, name: str, service: AdvertisedService) -> None:
        """End a service, after what the client has asked of it so far."""
        before_it = self.turn(name)
        self._leaving.add(service)

        async def leave() -> None:
            await _ended(before_it, *service.own_calls)
            self._leaving.discard(service)
            service.close()
            await self._worker.submit(lambda: None)

        self._take_turn(name, self._client.start(leave()))

    def _forget(self, name: str, service: AdvertisedService) -> None:
        if self._services.get(name) is service:
            del self._services[name]

    def unadvertise(self, operation: Operation) -> None:
        """Offer a service no more."""
        name = self._ros.resolve(operation.text("service"))
        service = self._services.pop(name, None)
        if service is None:
            raise OperationError(f"{name} has not been advertised")
        self._withdraw(name, service)

    def review(self) -> List[str]:
        """Withdraw what the client may not offer any more; returns a sentence for each."""
        ended = [name for name in self._services if not self._client.access.allows("serve", name)]
        for name in ended:
            self._withdraw(name, self._services.pop(name))
        return [f"unadvertised: {self._client.access.refusal('serve', name)}" for name in ended]

    def respond(self, operation: Operation) -> None:
        """Take the answer to a call."""
        name = self._ros.resolve(operation.text("service"))
        services = [self._services[name]] if name in self._services else []
        services += [service for service in self._leaving if service.name == name]
        if not services:
            raise OperationError(f"{name} has not been advertised")
        asked = (service for service in services if service.waits_for(operation.id))
        succeeded = operation.get("result") is not False
        next(asked, services[0]).respond(operation.id, operation.get("values"), succeeded=succeeded)

    def close(self) -> None:
        """Withdraw all of them."""
        while self._services:
            self._services.popitem()[1].close()
        while self._leaving:
            self._leaving.pop().close()


async def _ended(*tasks: Optional[asyncio.Task[None]]) -> None:
    """Wait until tasks have ended, however they do."""
    running = [task for task in tasks if task is not None]
    if running:
        await asyncio.wait(running)
