"""The operation call_service: services of ROS, of rosapi, and the bridge's own."""

from __future__ import annotations

import asyncio
from typing import Any, Callable, Dict, Mapping, Optional, Sequence, Tuple

from ...workers import OrderedWorker, in_own_thread
from ..clients.access import Access
from ..clients.client import Client
from ..clients.control import ControlServices
from ..protocol.operations import Operation, OperationError
from ..protocol.ros_messages import codec_of, service_class
from ..ros import Ros
from ..topics.commands import CommandGate
from .advertise_service import AdvertisedServices
from .instructor_actions import InstructorActions
from .rosapi import Question, RosApi


class Services:
    """Answers service calls of all clients.

    Parameters
    ----------
    worker
        Thread for rosapi's questions to the master.
    access
        What clients may do and see, by whether they are instructors.
    actions
        Told of all calls of ROS's services that were answered.
    timeout
        Time (s) after which a call is given up.
    """

    def __init__(
        self,
        ros: Ros,
        worker: OrderedWorker,
        control: ControlServices,
        access: Mapping[bool, Access],
        actions: InstructorActions,
        timeout: float,
    ) -> None:
        self._ros = ros
        self._worker = worker
        self._control = control
        self._actions = actions
        self._timeout = timeout
        self._rosapi = {
            instructor: RosApi(ros, control.types, allowed)
            for instructor, allowed in access.items()
        }

    async def call(
        self, service: str, arguments: Any, client: Client, gate: CommandGate
    ) -> Dict[str, Any]:
        """Call a service and return the values of its response.

        Parameters
        ----------
        service
            Its name as the client spells it.
        arguments
            Object with the request's fields, list of them in their order, or None.

        Raises
        ------
        OperationError
            There is no such service, the arguments do not fit, or the call failed.
        """
        try:
            question = self._rosapi[client.member.instructor].find(service)
            if question is not None:
                return await self._ask_rosapi(question, arguments, gate)
            fields = self._control.fields_of(service)
            if fields is not None:
                return self._control.answer(service, client.member, _as_object(arguments, fields))
            name = self._ros.resolve(service)
            gate.admit_call(name)
            gate.check_numbers("call", name, arguments or {})
            # A service may take its time, so each call has a thread of its own.
            call = in_own_thread(lambda: self._call_ros(service, arguments))
            asked, answer = await asyncio.wait_for(call, self._timeout)
            self._actions.note(client.member, name, asked, answer)
            return answer
        except asyncio.TimeoutError:
            raise OperationError(f"{service} did not answer within {self._timeout:g} s") from None
        except Exception as error:  # whatever fails in ROS is the answer to the client
            raise OperationError(str(error) or type(error).__name__) from error

    def commands(self, name: str, client: Client) -> bool:
        """Tell whether calling a service, by its global name, commands the robot."""
        own = self._control.fields_of(name) is not None
        asks = self._rosapi[client.member.instructor].find(name) is not None
        return not own and not asks and client.access.is_command("call", name)

    async def _ask_rosapi(
        self, question: Question, arguments: Any, gate: CommandGate
    ) -> Dict[str, Any]:
        fields = _as_object(arguments, question.fields)
        if question.immediate:
            return question.ask(fields)
        if question.changed is not None:
            for name in question.changed(fields):
                gate.admit_setting(name)
        answer = self._worker.submit(lambda: question.ask(fields))
        return await asyncio.wait_for(answer, self._timeout)

    def _call_ros(self, service: str, arguments: Any) -> Tuple[Dict[str, Any], Dict[str, Any]]:
        """Return the fields of the request and of the response; blocks."""
        name = self._ros.resolve(service)
        type_name = self._ros.service_type(name)
        if type_name is None:
            raise OperationError(f"there is no service {name}")
        found = service_class(type_name)
        request_codec = codec_of(found._request_class)
        fields = _as_object(arguments, request_codec.fields)
        request = request_codec.from_json(fields, self._ros.now)
        response = self._ros.call_service(name, found, request)
        return fields, codec_of(found._response_class).to_json(response)


def _as_object(arguments: Any, fields: Sequence[str]) -> Dict[str, Any]:
    """Return arguments, which may be missing or a list in the order of the fields, as an object."""
    if arguments is None:
        return {}
    if isinstance(arguments, dict):
        return arguments
    if not isinstance(arguments, list):
        raise OperationError("'args' must be an object or a list")
    if len(arguments) > len(fields):
        raise OperationError(
            f"the request has {len(fields)} fields, but {len(arguments)} arguments came"
        )
    return dict(zip(fields, arguments))


class ServiceCalls:
    """The service calls of one client that are under way.

    Parameters
    ----------
    advertised
        What the client itself offers.
    resolve
        Gives a name its global form.
    limit
        How many may be under way.
    """

    def __init__(
        self,
        client: Client,
        gate: CommandGate,
        services: Services,
        *,
        advertised: AdvertisedServices,
        resolve: Callable[[str], str],
        limit: int,
    ) -> None:
        self._client = client
        self._gate = gate
        self._services = services
        self._advertised = advertised
        self._resolve = resolve
        self._limit = limit
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
        before_it = self._advertised.turn(name)
        self._under_way += 1
        call = self._client.start(self._answer(operation, service, before_it))
        self._advertised.note_call(name, call)

    def commands(self, operation: Operation) -> bool:
        """Tell whether an operation `call_service` commands the robot."""
        try:
            name = self._resolve(operation.text("service"))
        except OperationError:
            return False  # which the call's answer says
        return self._services.commands(name, self._client)

    def refuse(self, operation: Operation, reason: str) -> None:
        """Answer a call that is not made, with the reason."""
        self._respond(operation, operation.text("service"), reason, succeeded=False)

    async def _answer(
        self, operation: Operation, service: str, before_it: Optional[asyncio.Task[None]]
    ) -> None:
        try:
            if before_it is not None:
                await asyncio.wait([before_it])
            arguments = operation.get("args")
            values = await self._services.call(service, arguments, self._client, self._gate)
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
        self._client.reply(response)
