"""Generated classes of messages and services by their type's name."""

from __future__ import annotations

import re
from typing import Any, Callable, Optional, Type

import genpy

from ..ros import Ros
from .operations import OperationError

_TYPE_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*/[A-Za-z][A-Za-z0-9_]*", re.ASCII)


def message_class(type_name: str) -> Type[genpy.Message]:
    """Return the class of a message type such as "std_msgs/String".

    Raises
    ------
    OperationError
        This is no type name, or the type is not built on this machine.
    """
    return _find(genpy.message.get_message_class, "message", type_name)


def service_class(type_name: str) -> Any:
    """Return the class of a service type such as "std_srvs/Empty"; raises as message_class."""
    return _find(genpy.message.get_service_class, "service", type_name)


def topic_class(ros: Ros, topic: str, type_name: Optional[str]) -> Type[genpy.Message]:
    """Return the message class of a topic; blocks.

    Parameters
    ----------
    ros
        Knows the types of topics.
    topic
        Global name.
    type_name
        Type that the client gave, or None.

    Raises
    ------
    OperationError
        The client's type is not the topic's, or nobody knows the topic's type.
    """
    known = ros.topic_types().get(topic)
    if known is None or known == "*":  # "*": somebody has subscribed without knowing the type
        if type_name is None:
            raise OperationError(f"nobody has published {topic} yet, so its type must be given")
        return message_class(type_name)
    if type_name is None:
        return message_class(known)
    # The master remembers types of topics that nobody uses any more; those bind nobody.
    if type_name != known and topic in ros.topics():
        raise OperationError(f"{topic} has the type {known}, not {type_name}")
    return message_class(type_name)


def _find(find: Callable[[str], Optional[Any]], what: str, type_name: str) -> Any:
    # The name decides what is imported, so nothing but a type's name may get there.
    if not _TYPE_NAME.fullmatch(type_name):
        raise OperationError(
            f"{type_name[:80]!r} is no {what} type; one looks like std_msgs/String"
        )
    try:
        found = find(type_name)
    except (ImportError, AttributeError, ValueError):
        found = None
    if found is None:
        raise OperationError(f"the {what} type {type_name} is not built on this machine")
    return found
