"""Services that one client calls."""

from __future__ import annotations

import asyncio
from typing import Any, Callable, Dict, Optional

from ..link import Link
from ..protocol.operations import Operation, OperationError
from .offering import Offering
from .services import Caller, ServiceDesk


class Calling:
    """The service calls of one client that are under way.

    Parameters
    ----------
    desk
        Answers them.
    caller
        Who calls.
    offering
        What the client itself offers.
    resolve
        Gives a name its global form.
    limit
        How many may be under way.
    link
        The client.
    """

    def __init__(
        self,
        desk: ServiceDesk,
        caller: Caller,
        *,
        offering: Offering,
        resolve: Callable[[str], str],
        limit: int,
        link: Link,
    ) -> None:
        self._desk = desk
        self._caller = caller
        self._offering = offering
        self._resolve = resolve
        self._limit = limit
        self._link = link
        self._under_way = 0

    def call(self, operation: Operation) -> None:
        """Call a service; the answer goes to the client when it comes."""
        service = operation.text("service")
        if self._under_way >= self._limit:
            answer = f"{self._under_way} service calls of this client are under way already"
            self._respond(operation, service, answer, succeeded=False)
            return
        try:
            name = self._resolve(service)
        except OperationError as error:
            self._respond(operation, service, str(error), succeeded=False)
            return
        before_it = self._offering.turn(name)
        self._under_way += 1
        call = self._link.start(self._answer(operation, service, before_it))
        self._offering.note_call(name, call)

    async def _answer(
        self, operation: Operation, service: str, before_it: Optional[asyncio.Task[None]]
    ) -> None:
        try:
            if before_it is not None:
                await asyncio.wait([before_it])
            values = await self._desk.call(service, operation.get("args"), self._caller)
        except OperationError as error:
            self._respond(operation, service, str(error), succeeded=False)
        else:
            self._respond(operation, service, values, succeeded=True)
        finally:
            self._under_way -= 1

    def _respond(self, operation: Operation, service: str, values: Any, *, succeeded: bool) -> None:
        response: Dict[str, Any] = {"op": "service_response"}
        if operation.id is not None:
            response["id"] = operation.id
        response.update(service=service, values=values, result=succeeded)
        self._link.reply(response)
