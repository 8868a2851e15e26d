"""The services of rosapi that roslibjs and roslibpy use, answered inside the bridge."""

from __future__ import annotations

import base64
import dataclasses
import datetime
import json
import math
import xmlrpc.client
from typing import Any, Callable, Dict, Iterable, List, Mapping, Optional, Tuple, Type

import genpy

from ..clients.access import Access
from ..protocol.operations import MAX_TEXT, Arguments, OperationError, parse_json
from ..protocol.ros_messages import message_class, service_class, split_array
from ..ros import Ros

_PREFIX = "rosapi/"
_ACTION_TOPICS = ("cancel", "feedback", "status", "result")

_EXAMPLES = {"bool": "False", "string": "", "float32": "0.0", "float64": "0.0"}
_TIMES = ("time", "duration")
SCALAR, VARIABLE = -1, 0
"""What TypeDef says of a field that is no array, and of an array of any length."""


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
    changed
        Gives the global names of the parameters that it would change.
    """

    ask: Callable[[Arguments], Dict[str, Any]]
    fields: Tuple[str, ...] = ()
    immediate: bool = False
    changed: Optional[Callable[[Arguments], List[str]]] = None


class RosApi:
    """Answers questions about the ROS graph and the parameters.

    Parameters
    ----------
    own_services
        Types of the services that the bridge itself answers besides these, by their global names.
    access
        What those who ask may use: of other topics, services and parameters they hear nothing.
    """

    def __init__(self, ros: Ros, own_services: Mapping[str, str], access: Access) -> None:
        self._ros = ros
        self._access = access
        self._questions: Dict[str, Question] = {
            "topics": Question(lambda _: self._topics()),
            "topics_and_raw_types": Question(lambda _: self._topics_and_raw_types()),
            "topic_type": Question(self._topic_type, ("topic",)),
            "topics_for_type": Question(self._topics_for_type, ("type",)),
            "publishers": Question(self._publishers, ("topic",)),
            "subscribers": Question(self._subscribers, ("topic",)),
            "services": Question(lambda _: {"services": self._services()}),
            "service_type": Question(self._service_type, ("service",)),
            "services_for_type": Question(self._services_for_type, ("type",)),
            "service_node": Question(self._service_node, ("service",)),
            "service_host": Question(self._service_host, ("service",)),
            "service_providers": Question(self._service_providers, ("service",)),
            "message_details": Question(self._message_details, ("type",)),
            "service_request_details": Question(self._request_details, ("type",)),
            "service_response_details": Question(self._response_details, ("type",)),
            "nodes": Question(lambda _: {"nodes": sorted(ros.nodes())}),
            "node_details": Question(self._node_details, ("node",)),
            "action_servers": Question(lambda _: {"action_servers": self._action_servers()}),
            "get_param": Question(self._get_param, ("name", "default")),
            "set_param": Question(
                self._set_param,
                ("name", "value"),
                changed=lambda arguments: [ros.resolve(_name(arguments, "name"))],
            ),
            "has_param": Question(self._has_param, ("name",)),
            "delete_param": Question(
                self._delete_param,
                ("name",),
                changed=lambda arguments: self._spellings(_name(arguments, "name")),
            ),
            "get_param_names": Question(lambda _: {"names": self._param_names()}),
            "get_ros_version": Question(lambda _: self._version()),
            "get_time": Question(lambda _: self._time(), immediate=True),
        }
        self._own_services = {
            **own_services,
            **{f"/{_PREFIX}{name}": _type_of(name) for name in self._questions},
        }

    def find(self, service: str) -> Optional[Question]:
        """Return the question behind a service's name, None if it is not one of rosapi's."""
        name = service[1:] if service.startswith("/") else service
        if not name.startswith(_PREFIX):
            return None
        self._access.check_question(f"/{name}")
        question = self._questions.get(name[len(_PREFIX) :])
        if question is None:
            known = ", ".join(self._questions)
            raise OperationError(f"{service} is not offered; of rosapi there are {known}")
        return question

    def _open_topics(self, names: Iterable[str]) -> List[str]:
        """Return those topics that the client may hear or publish."""
        may = self._access.allows
        return [name for name in names if may("subscribe", name) or may("publish", name)]

    def _open_services(self, names: Iterable[str]) -> List[str]:
        """Return those services that the client may call."""
        may = self._access.allows
        return [name for name in names if name in self._own_services or may("call", name)]

    def _topics(self) -> Dict[str, Any]:
        names = self._open_topics(sorted(self._ros.topics()))
        types = self._ros.topic_types()
        return {"topics": names, "types": [types.get(name, "") for name in names]}

    def _topics_and_raw_types(self) -> Dict[str, Any]:
        answer = self._topics()
        texts = []
        for type_name in answer["types"]:
            try:
                texts.append(str(message_class(type_name)._full_text))
            except OperationError:
                texts.append("")
        return {**answer, "typedefs_full_text": texts}

    def _topics_for_type(self, arguments: Arguments) -> Dict[str, Any]:
        wanted = _name(arguments, "type")
        answer = self._topics()
        pairs = zip(answer["topics"], answer["types"])
        return {"topics": [topic for topic, type_name in pairs if type_name == wanted]}

    def _topic_type(self, arguments: Arguments) -> Dict[str, Any]:
        types = self._ros.topic_types()
        names = self._open_topics(self._spellings(_name(arguments, "topic")))
        found = (types.get(name) for name in names)
        return {"type": next(filter(None, found), "")}

    def _publishers(self, arguments: Arguments) -> Dict[str, Any]:
        names = self._open_topics([self._ros.resolve(_name(arguments, "topic"))])
        return {"publishers": [node for name in names for node in self._ros.publishers(name)]}

    def _subscribers(self, arguments: Arguments) -> Dict[str, Any]:
        names = self._open_topics([self._ros.resolve(_name(arguments, "topic"))])
        return {"subscribers": [node for name in names for node in self._ros.subscribers(name)]}

    def _services(self) -> List[str]:
        return sorted({*self._open_services(self._ros.services()), *self._own_services})

    def _type_of_service(self, service: str) -> str:
        own = self._own_services.get(service)
        if own is not None:
            return own
        try:
            return self._ros.service_type(service) or ""
        except OperationError:  # its node is gone, or hangs
            return ""

    def _service_type(self, arguments: Arguments) -> Dict[str, Any]:
        names = self._open_services(self._spellings(_name(arguments, "service")))
        return {"type": next(filter(None, map(self._type_of_service, names)), "")}

    def _services_for_type(self, arguments: Arguments) -> Dict[str, Any]:
        wanted = _name(arguments, "type")
        found = [name for name in self._services() if self._type_of_service(name) == wanted]
        return {"services": found}

    def _nodes_of_service(self, service: str) -> List[str]:
        if service in self._own_services:
            return [self._ros.resolve("~").rstrip("/")]
        return self._ros.service_nodes(service)

    def _service_node(self, arguments: Arguments) -> Dict[str, Any]:
        names = self._open_services(self._spellings(_name(arguments, "service")))
        nodes = (node for name in names for node in self._nodes_of_service(name))
        return {"node": next(nodes, "")}

    def _service_host(self, arguments: Arguments) -> Dict[str, Any]:
        names = self._open_services(self._spellings(_name(arguments, "service")))
        if any(name in self._own_services for name in names):
            return {"host": self._ros.own_host()}
        return {"host": next(filter(None, map(self._ros.service_host, names)), "")}

    def _service_providers(self, arguments: Arguments) -> Dict[str, Any]:
        """Return the nodes that offer services of a type, which is in the field `service`."""
        wanted = _name(arguments, "service")
        found = (name for name in self._services() if self._type_of_service(name) == wanted)
        return {
            "providers": sorted({node for name in found for node in self._nodes_of_service(name)})
        }

    def _message_details(self, arguments: Arguments) -> Dict[str, Any]:
        return {"typedefs": type_details(message_class(_name(arguments, "type")))}

    def _request_details(self, arguments: Arguments) -> Dict[str, Any]:
        found = service_class(_name(arguments, "type"))
        return {"typedefs": type_details(found._request_class)}

    def _response_details(self, arguments: Arguments) -> Dict[str, Any]:
        found = service_class(_name(arguments, "type"))
        return {"typedefs": type_details(found._response_class)}

    def _node_details(self, arguments: Arguments) -> Dict[str, Any]:
        details = self._ros.node_details(self._ros.resolve(_name(arguments, "node")))
        return {
            "subscribing": self._open_topics(details["subscribing"]),
            "publishing": self._open_topics(details["publishing"]),
            "services": self._open_services(details["services"]),
        }

    def _action_servers(self) -> List[str]:
        topics = set(self._open_topics(self._ros.topics()))
        goals = (topic[: -len("/goal")] for topic in topics if topic.endswith("/goal"))
        return sorted(
            name for name in goals if all(f"{name}/{part}" in topics for part in _ACTION_TOPICS)
        )

    def _get_param(self, arguments: Arguments) -> Dict[str, Any]:
        for name in self._spellings(_name(arguments, "name")):
            try:
                value = self._ros.get_param(name)
            except KeyError:
                continue
            self._access.check("get", name)
            return {"value": json.dumps(_plain(self._readable(name, value)))}
        default = arguments.get("default")
        return {"value": default if isinstance(default, str) and default else "null"}

    def _readable(self, name: str, value: Any) -> Any:
        """Return a parameter's value, without what the client may not read."""
        if not isinstance(value, dict):
            return value
        inside = name if name.endswith("/") else f"{name}/"
        return {
            key: self._readable(f"{inside}{key}", part)
            for key, part in value.items()
            if self._access.allows("get", f"{inside}{key}")
        }

    def _param_names(self) -> List[str]:
        return sorted(name for name in self._ros.param_names() if self._access.allows("get", name))

    def _has_param(self, arguments: Arguments) -> Dict[str, Any]:
        for name in self._spellings(_name(arguments, "name")):
            try:
                self._ros.get_param(name)
            except KeyError:
                continue
            return {"exists": self._access.allows("get", name)}
        return {"exists": False}

    def _set_param(self, arguments: Arguments) -> Dict[str, Any]:
        name = self._ros.resolve(_name(arguments, "name"))
        text = arguments.get("value")
        if not isinstance(text, str):
            raise OperationError("'value' must be a string that holds JSON")
        value = parse_json(text)
        try:
            self._ros.set_param(name, value)
        except RecursionError:
            raise OperationError("the value is nested too deeply") from None
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

    def _version(self) -> Dict[str, Any]:
        try:
            distro = str(self._ros.get_param("/rosdistro")).strip()
        except KeyError:
            distro = ""
        return {"version": 1, "distro": distro}

    def _time(self) -> Dict[str, Any]:
        now = self._ros.now()
        return {"time": {"secs": now.secs, "nsecs": now.nsecs}}

    def _spellings(self, name: str) -> List[str]:
        """Return what a name may mean: relative to the bridge, or global without its slash."""
        meanings = [self._ros.resolve(name)]
        if not name.startswith(("/", "~")):
            meanings.append(self._ros.resolve(f"/{name}"))
        return meanings


def _type_of(question: str) -> str:
    """Return the type that rosapi gives to one of its services."""
    unlike = {"action_servers": "GetActionServers", "get_ros_version": "GetROSVersion"}
    if question in unlike:
        return f"rosapi/{unlike[question]}"
    return "rosapi/" + "".join(part.capitalize() for part in question.split("_"))


def _name(arguments: Any, field: str) -> str:
    value = arguments.get(field)
    if not isinstance(value, str) or not value:
        raise OperationError(f"'{field}' must be a string that is not empty")
    if len(value) > MAX_TEXT:
        raise OperationError(f"'{field}' has {len(value)} characters; {MAX_TEXT} are enough")
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


def type_details(found: Type[genpy.Message]) -> List[Dict[str, Any]]:
    """Return the TypeDefs of a class and of all types inside it, itself first.

    Parameters
    ----------
    found
        Message class, or request or response class of a service.
    """
    details: Dict[str, Dict[str, Any]] = {}
    waiting = [found]
    while waiting:
        next_class = waiting.pop(0)
        if next_class._type in details:
            continue
        details[next_class._type] = _type_def(next_class)
        for field_type in details[next_class._type]["fieldtypes"]:
            if "/" in field_type:
                waiting.append(message_class(field_type))
    return list(details.values())


def _type_def(found: Type[genpy.Message]) -> Dict[str, Any]:
    types, lengths, examples = [], [], []
    for slot_type in found._slot_types:
        element, length, is_array = split_array(slot_type)
        types.append(element)
        lengths.append((length or VARIABLE) if is_array else SCALAR)
        nested = "/" in element or element in _TIMES
        examples.append("[]" if is_array else "{}" if nested else _EXAMPLES.get(element, "0"))
    constants = _constants(found)
    return {
        "type": found._type,
        "fieldnames": list(found.__slots__),
        "fieldtypes": types,
        "fieldarraylen": lengths,
        "examples": examples,
        "constnames": list(constants),
        "constvalues": list(constants.values()),
    }


def _constants(found: Type[genpy.Message]) -> Dict[str, str]:
    """Return the constants of a class; genpy makes them plain attributes."""
    return {
        name: str(value)
        for name, value in vars(found).items()
        if not name.startswith("_")
        and name not in found.__slots__
        and isinstance(value, (bool, int, float, str))
    }
