"""What a program that ends asks of a manager, which may be slow, or have gone as well."""

from __future__ import annotations

import contextlib
import socket
import threading
import time
from typing import Callable, List, Optional

import rosgraph
import rospy
from rosgraph.network import write_ros_handshake_header

STALL = 1.0
"""Wall time (s) without an answer after which is seen whether the manager is still there."""

LONGEST_STALL = 10.0
"""Wall time (s) without an answer after which a manager counts as gone that is there."""

_CONNECTING = 1.0


def manager_address(prefix: str) -> Optional[str]:
    """Where a manager's services are, which differs for every process; None if nowhere.

    Parameters
    ----------
    prefix : str
        Of their names, as `ControllerManagerClient` has it.
    """
    try:
        master = rosgraph.Master(rospy.get_name())
        return str(master.lookupService(_a_service(prefix)))
    except (OSError, rosgraph.MasterException):
        return None


def call_at_the_end(prefix: str, calls: Callable[[Callable[[], None]], None]) -> None:
    """Call a manager's services, and give up where it has gone.

    A call of a service has no timeout: when everything is shut down together, the manager may go
    while it is asked. One that does not answer for a while, but takes connections, is slow.

    Parameters
    ----------
    prefix : str
        Of the services' names.
    calls : callable
        Makes the calls, in a thread of its own; calls its argument after each answer.
    """
    addresses: List[Optional[str]] = []
    answered = threading.Event()

    def work() -> None:
        addresses.append(manager_address(prefix))
        with contextlib.suppress(rospy.ServiceException, rospy.ROSException):
            calls(answered.set)
            return
        rospy.logdebug("the controller manager went before its spawner or unspawner")

    worker = threading.Thread(target=work, daemon=True)
    worker.start()
    heard = time.monotonic()
    while True:
        worker.join(STALL)
        if not worker.is_alive():
            return
        if answered.is_set():
            answered.clear()
            heard = time.monotonic()
            continue
        gone = bool(addresses) and not _takes_connections(addresses[0], prefix)
        if gone or time.monotonic() > heard + LONGEST_STALL:
            return


def _a_service(prefix: str) -> str:
    return str(rospy.resolve_name(f"{prefix}/load_controller"))


def _takes_connections(address: Optional[str], prefix: str) -> bool:
    """Whether somebody is at an address of a service, asked as `rospy.wait_for_service` does."""
    if address is None:
        return False
    place = rospy.core.parse_rosrpc_uri(address)
    header = {
        "probe": "1",
        "md5sum": "*",
        "callerid": rospy.get_name(),
        "service": _a_service(prefix),
    }
    try:
        with socket.create_connection(place, _CONNECTING) as connection:
            write_ros_handshake_header(connection, header)
    except OSError:
        return False
    return True
