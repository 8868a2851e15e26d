"""Services: those of ROS, and rosapi's, which the bridge answers itself."""

from __future__ import annotations

import asyncio
from typing import Any, Dict, Sequence

from ..workers import OrderedWorker, in_own_thread
from .message_json import codec_of
from .message_types import service_class
from .operations import OperationError
from .ros import Ros
from .rosapi import RosApi


class ServiceDesk:
    """Answers service calls.

    Parameters
    ----------
    ros
        Where the services are.
    worker
        Thread for rosapi's questions to the master.
    timeout
        Time (s) after which a call is given up.
    """

    def __init__(self, ros: Ros, worker: OrderedWorker, timeout: float) -> None:
        self._ros = ros
        self._worker = worker
        self._timeout = timeout
        self._rosapi = RosApi(ros)

    async def call(self, service: str, arguments: Any) -> Dict[str, Any]:
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
        question = self._rosapi.find(service)
        try:
            if question is None:
                # A service may take its time, so each call has a thread of its own.
                answer = in_own_thread(lambda: self._call_ros(service, arguments))
                return await asyncio.wait_for(answer, self._timeout)
            if question.immediate:
                return question.ask(_as_object(arguments, question.fields))
            fields = _as_object(arguments, question.fields)
            answer = self._worker.submit(lambda: question.ask(fields))
            return await asyncio.wait_for(answer, self._timeout)
        except asyncio.TimeoutError:
            raise OperationError(f"{service} did not answer within {self._timeout:g} s") from None
        except Exception as error:  # whatever fails in ROS is the answer to the client
            raise OperationError(str(error) or type(error).__name__) from error

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
