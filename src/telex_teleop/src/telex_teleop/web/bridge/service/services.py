"""Services: those of ROS, and those of rosapi and of control, which the bridge answers itself."""

from __future__ import annotations

import asyncio
import dataclasses
from typing import Any, Dict, Sequence

from ...workers import OrderedWorker, in_own_thread
from ..control.access import Roles
from ..control.clients import Member
from ..control.control_services import ControlServices
from ..protocol.message_json import codec_of
from ..protocol.message_types import service_class
from ..protocol.operations import OperationError
from ..publish.command_gate import CommandGate
from ..ros import Ros
from .rosapi import Question, RosApi


@dataclasses.dataclass(frozen=True)
class Caller:
    """The client that calls, and what it may do."""

    member: Member
    gate: CommandGate


class ServiceDesk:
    """Answers service calls.

    Parameters
    ----------
    ros
        Where the services are.
    worker
        Thread for rosapi's questions to the master.
    control
        Answers what concerns control.
    roles
        What clients may do and see.
    timeout
        Time (s) after which a call is given up.
    """

    def __init__(
        self,
        ros: Ros,
        worker: OrderedWorker,
        control: ControlServices,
        roles: Roles,
        timeout: float,
    ) -> None:
        self._ros = ros
        self._worker = worker
        self._control = control
        self._timeout = timeout
        self._rosapi = {
            instructor: RosApi(ros, control.types, roles.of(instructor=instructor))
            for instructor in (False, True)
        }

    async def call(self, service: str, arguments: Any, caller: Caller) -> Dict[str, Any]:
        """Call a service and return the values of its response.

        Parameters
        ----------
        service
            Its name as the client spells it.
        arguments
            Object with the request's fields, list of them in their order, or None.
        caller
            Who calls.

        Raises
        ------
        OperationError
            There is no such service, the arguments do not fit, or the call failed.
        """
        try:
            question = self._rosapi[caller.member.instructor].find(service)
            if question is not None:
                return await self._ask_rosapi(question, arguments, caller)
            fields = self._control.fields_of(service)
            if fields is not None:
                return self._control.answer(service, caller.member, _as_object(arguments, fields))
            name = self._ros.resolve(service)
            caller.gate.admit_call(name)
            caller.gate.check_numbers("call", name, arguments or {})
            # A service may take its time, so each call has a thread of its own.
            answer = in_own_thread(lambda: self._call_ros(service, arguments))
            return await asyncio.wait_for(answer, self._timeout)
        except asyncio.TimeoutError:
            raise OperationError(f"{service} did not answer within {self._timeout:g} s") from None
        except Exception as error:  # whatever fails in ROS is the answer to the client
            raise OperationError(str(error) or type(error).__name__) from error

    async def _ask_rosapi(
        self, question: Question, arguments: Any, caller: Caller
    ) -> Dict[str, Any]:
        fields = _as_object(arguments, question.fields)
        if question.immediate:
            return question.ask(fields)
        if question.changed is not None:
            for name in question.changed(fields):
                caller.gate.admit_setting(name)
        answer = self._worker.submit(lambda: question.ask(fields))
        return await asyncio.wait_for(answer, self._timeout)

    def _call_ros(self, service: str, arguments: Any) -> Dict[str, Any]:
        name = self._ros.resolve(service)
        type_name = self._ros.service_type(name)
        if type_name is None:
            raise OperationError(f"there is no service {name}")
        found = service_class(type_name)
        request_codec = codec_of(found._request_class)
        fields = _as_object(arguments, request_codec.fields)
        request = request_codec.from_json(fields, self._ros.now)
        return codec_of(found._response_class).to_json(self._ros.call_service(name, found, request))


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
