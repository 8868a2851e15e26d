"""The services of rosapi that roslibjs and roslibpy use, answered inside the bridge."""

from __future__ import annotations

import base64
import dataclasses
import datetime
import json
import math
import xmlrpc.client
from typing import Any, Callable, Dict, List, Optional, Tuple

from .operations import OperationError, parse_json
from .ros import Ros

_PREFIX = "rosapi/"
Arguments = Dict[str, Any]


@dataclasses.dataclass(frozen=True)
class Question:
    """A service of rosapi.

    Attributes
    ----------
    ask
        Takes the request's fields as an object, returns those of the response.
    fields
        The request's fields, in their order.
    immediate
        It does not block.
    """

    ask: Callable[[Arguments], Dict[str, Any]]
    fields: Tuple[str, ...] = ()
    immediate: bool = False


class RosApi:
    """Answers questions about the ROS graph and the parameters.

    Parameters
    ----------
    ros
        Where the answers are.
    """

    def __init__(self, ros: Ros) -> None:
        self._ros = ros
        self._questions: Dict[str, Question] = {
            "topics": Question(lambda _: self._topics()),
            "topic_type": Question(self._topic_type, ("topic",)),
            "services": Question(lambda _: {"services": sorted(ros.services())}),
            "service_type": Question(self._service_type, ("service",)),
            "nodes": Question(lambda _: {"nodes": sorted(ros.nodes())}),
            "get_param": Question(self._get_param, ("name", "default")),
            "set_param": Question(self._set_param, ("name", "value")),
            "delete_param": Question(self._delete_param, ("name",)),
            "get_param_names": Question(lambda _: {"names": sorted(ros.param_names())}),
            "get_time": Question(lambda _: self._time(), immediate=True),
        }

    def find(self, service: str) -> Optional[Question]:
        """Return the question behind a service's name, None if it is not one of rosapi's."""
        name = service[1:] if service.startswith("/") else service
        if not name.startswith(_PREFIX):
            return None
        question = self._questions.get(name[len(_PREFIX) :])
        if question is None:
            known = ", ".join(self._questions)
            raise OperationError(f"{service} is not offered; of rosapi there are {known}")
        return question

    def _topics(self) -> Dict[str, Any]:
        names = sorted(self._ros.topics())
        types = self._ros.topic_types()
        return {"topics": names, "types": [types.get(name, "") for name in names]}

    def _topic_type(self, arguments: Arguments) -> Dict[str, Any]:
        types = self._ros.topic_types()
        found = (types.get(name) for name in self._spellings(_name(arguments, "topic")))
        return {"type": next(filter(None, found), "")}

    def _service_type(self, arguments: Arguments) -> Dict[str, Any]:
        names = self._spellings(_name(arguments, "service"))
        return {"type": next(filter(None, map(self._ros.service_type, names)), "")}

    def _get_param(self, arguments: Arguments) -> Dict[str, Any]:
        for name in self._spellings(_name(arguments, "name")):
            try:
                return {"value": json.dumps(_plain(self._ros.get_param(name)))}
            except KeyError:
                continue
        default = arguments.get("default")
        return {"value": default if isinstance(default, str) and default else "null"}

    def _set_param(self, arguments: Arguments) -> Dict[str, Any]:
        name = self._ros.resolve(_name(arguments, "name"))
        if name == "/":
            raise OperationError("'name' must not be the root of all parameters")
        text = arguments.get("value")
        if not isinstance(text, str):
            raise OperationError("'value' must be a string that holds JSON")
        value = parse_json(text)
        try:
            self._ros.set_param(name, value)
        except (TypeError, OverflowError, xmlrpc.client.Fault) as error:
            raise OperationError(f"the parameter server cannot hold this value: {error}") from None
        return {}

    def _delete_param(self, arguments: Arguments) -> Dict[str, Any]:
        for name in self._spellings(_name(arguments, "name")):
            try:
                self._ros.delete_param(name)
            except KeyError:
                continue
            return {}
        raise OperationError(f"the parameter {arguments['name']} is not set")

    def _time(self) -> Dict[str, Any]:
        now = self._ros.now()
        return {"time": {"secs": now.secs, "nsecs": now.nsecs}}

    def _spellings(self, name: str) -> List[str]:
        """Return what a name may mean: relative to the bridge, or global without its slash."""
        meanings = [self._ros.resolve(name)]
        if not name.startswith(("/", "~")):
            meanings.append(self._ros.resolve(f"/{name}"))
        return meanings


def _name(arguments: Any, field: str) -> str:
    value = arguments.get(field)
    if not isinstance(value, str) or not value:
        raise OperationError(f"'{field}' must be a string that is not empty")
    return value


def _plain(value: Any) -> Any:
    """Return a value of the parameter server as one that JSON knows."""
    if isinstance(value, dict):
        return {str(key): _plain(part) for key, part in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(part) for part in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, xmlrpc.client.Binary):
        return base64.b64encode(value.data).decode("ascii")
    if isinstance(value, (xmlrpc.client.DateTime, datetime.datetime)):
        return str(value)
    return value
