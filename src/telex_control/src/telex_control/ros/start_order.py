"""Order in which the nodes of a launch import their modules on a machine with few cores.

What draws the first picture should not share the processor with the imports of nodes that are
needed only after it. Those wait here, before they import anything, for what the launch file names:
nodes that are known, or namespaces, with a slash at the end, in which something is published. The
wait is short and bounded: it decides about haste, and nothing else.
"""

from __future__ import annotations

import http.client
import importlib
import os
import socket
import sys
import time
from typing import Any, List
from xml.parsers.expat import ExpatError
from xmlrpc.client import Error, ServerProxy

NO_ANSWER = (OSError, Error, ExpatError, http.client.HTTPException)
"""What a call to a master or a node raises where nobody answers, or something else does."""

START_AFTER = "TELEX_START_AFTER"
"""Environment variable with the full names of what comes first, separated by blanks."""

_LONGEST = 3.0
"""Wait (s) after which a node starts whatever the others do."""

_CALLER = "/start_order"
_PERIOD = 0.1
_ANSWER = 1.0
"""Time (s) in which the master has to answer."""


def wait_for_turn(longest: float = _LONGEST) -> None:
    """Wait until the master knows what comes first, at most `longest` seconds.

    Raises
    ------
    SystemExit
        SIGINT came: the launch ends before the node has begun.
    """
    names = os.environ.get(START_AFTER, "").split()
    address = os.environ.get("ROS_MASTER_URI", "")
    if not names or not address:
        return
    end = time.monotonic() + longest
    before = socket.getdefaulttimeout()
    socket.setdefaulttimeout(_ANSWER)
    try:
        while names and time.monotonic() < end:
            names = _unknown(address, names)
            if names:
                time.sleep(_PERIOD)
    except KeyboardInterrupt:
        raise SystemExit(130) from None
    finally:
        socket.setdefaulttimeout(before)


def run_in_turn(module: str, function: str = "main") -> None:
    """Wait for this node's turn to import its module, then run it and end with its status."""
    wait_for_turn()
    sys.exit(getattr(importlib.import_module(module), function)())


def _unknown(address: str, names: List[str]) -> List[str]:
    """Those of the nodes and namespaces that the master does not know."""
    try:
        with ServerProxy(address) as master:
            return [name for name in names if not _is_known(master, name)]
    except NO_ANSWER:
        return names


def _is_known(master: Any, name: str) -> bool:
    if not name.endswith("/"):
        return bool(master.lookupNode(_CALLER, name)[0] == 1)
    _, _, topics = master.getPublishedTopics(_CALLER, "")
    return any(topic.startswith(name) for topic, _ in topics)
