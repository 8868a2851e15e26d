"""Keeps web pages out of the XML-RPC servers of ROS: the master's, every node's, roslaunch's.

Whoever reaches one of them can drive the robot, and none asks who it is. Programs of this machine
may; but a browser sends the requests of every page that its user visits from this machine, too. Of
those it says the origin, and it lets no page choose the type that XML-RPC has without asking the
server first. A page may also have its own name point to this machine; the request then names it as
the host.
"""

from __future__ import annotations

import contextlib
import functools
import ipaddress
import os
import socket
from http import HTTPStatus
from typing import Optional, Tuple
from urllib.parse import urlsplit

import rosgraph
import rosgraph.xmlrpc

__all__ = ["guard_xmlrpc", "is_own_host"]

_MOST_DROPPED = 65536
"""Bytes of a refused request that are read, so that its sender gets to read why."""


def guard_xmlrpc() -> None:
    """Let every XML-RPC server refuse web pages that rosgraph makes in this process from now on."""
    rosgraph.xmlrpc.SilenceableXMLRPCRequestHandler = GuardedRequestHandler


class GuardedRequestHandler(rosgraph.xmlrpc.SilenceableXMLRPCRequestHandler):
    """Answers XML-RPC requests of programs, and refuses those of web pages."""

    def parse_request(self) -> bool:
        """Read a request's first lines; tells whether to go on, and answers it if not."""
        if not super().parse_request():
            return False
        refusal = self._refusal()
        if refusal is None:
            return True
        length = self.headers.get("Content-Length", "")
        if length.isdecimal() and len(length) < 10:
            self.rfile.read(min(int(length), _MOST_DROPPED))
        # It also ends the connection: what is left of this request must not be taken as another.
        self.send_error(*refusal)
        return False

    def _refusal(self) -> Optional[Tuple[int, str]]:
        if "Origin" in self.headers:
            return HTTPStatus.FORBIDDEN, "web pages may not use ROS"
        if not all(is_own_host(host) for host in self.headers.get_all("Host", [])):
            return HTTPStatus.FORBIDDEN, (
                "this Host is none of this machine's names; use its address or host name, or set "
                "its ROS_HOSTNAME to the name that you use"
            )
        if self.headers.get_content_type() != "text/xml":  # text/plain where none is given
            return HTTPStatus.UNSUPPORTED_MEDIA_TYPE, "XML-RPC is text/xml"
        return None


@functools.lru_cache(maxsize=256)
def is_own_host(host: str) -> bool:
    """Tell whether a request's Host is an IP address or one of this machine's names.

    An address cannot have been made to point here by somebody else, as a name can.

    Parameters
    ----------
    host
        With or without a port.
    """
    try:
        name = (urlsplit(f"//{host}").hostname or "").rstrip(".")
    except ValueError:
        return False
    with contextlib.suppress(ValueError):
        ipaddress.ip_address(name)
        return True
    # The last one may have to ask the network.
    return name in _given_names() or name == socket.getfqdn().lower()


def _given_names() -> Tuple[str, ...]:
    """The names that this machine has, and those that ROS was told to use."""
    own = socket.gethostname().lower()
    master = urlsplit(os.environ.get("ROS_MASTER_URI", "")).hostname or ""
    announced = (rosgraph.network.get_address_override() or "").lower()
    return ("localhost", own, own.partition(".")[0], f"{own}.local", master, announced)
